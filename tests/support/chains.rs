//! Light for chains of which a test follows every branch.

use nephroid::internals::geometry::Ray;
use nephroid::internals::numeric::{Stream, StreamKind};
use nephroid::internals::transport::chain::Emitted;
use nephroid::internals::transport::flux::Flux;

/// Unit flux \[W\] along a ray.
pub fn light<const N: usize>(ray: Ray) -> Emitted<N> {
    Emitted {
        ray,
        flux: Flux::WHITE,
        choices: Stream::new(StreamKind::Random, 0).extras(0),
    }
}
