//! Stage `splat` by ellipses (beyond the paper): photons as large as those beside them land apart.
//!
//! P(u, v) is where the photon of the lattice's cell (u, v) lands. To first order the light of a cell covers
//! the parallelogram of ∂P/∂u and ∂P/∂v (photon differentials: Schjøth, Frisvad, Erleben and Sporring,
//! *Photon Differentials*, GRAPHITE 2007). The splat is an ellipse in the surface's plane,
//!
//! ```text
//! P + scale (a ∂P/∂u + b ∂P/∂v),   a² + b² ≤ 1
//! ```
//!
//! which reaches to the neighbours' places: points between photons are in π of them in the mean.
//!
//! A derivative is the shorter one of the ways to the neighbours on both sides: where light folds or faces
//! part, the longer one leads elsewhere. Neighbours are photons that had the same events, the last of them on
//! the same shape. A photon without any in its row or its column is a disc, as quads are.
//!
//! Half axes have the bounds of a quad's radius, `splat-min` to `splat-max`. Irradiance is Φ by the area.

use glam::DVec3;

use super::cuboid::Cuboid;
use super::emission::Lattice;
use super::photon::Landing;
use super::settings::Settings;
use super::splat::{Disc, discs};
use crate::numeric::math;
use crate::transport::signature::Signature;

/// A landing's place in an order of its own.
type Place = (u64, Signature, usize);

/// Memory of a landing in that order \[bytes\].
pub const PLACE_BYTES: u64 = size_of::<Place>() as u64;

/// Landings by the number of their photon and its events.
struct Places<'a> {
    landed: &'a [Landing],
    sorted: Vec<Place>,
}

impl<'a> Places<'a> {
    fn new(landed: &'a [Landing]) -> Self {
        let keys = landed
            .iter()
            .map(|it| (it.photon.index, it.photon.signature));
        let mut sorted: Vec<_> = (keys.enumerate())
            .map(|(place, (index, signature))| (index, signature, place))
            .collect();
        sorted.sort_unstable();
        Self { landed, sorted }
    }

    /// The way from a landing to that of another photon, if that went the same way.
    fn offset(&self, from: &Landing, photon: u64) -> Option<DVec3> {
        let key = (photon, from.photon.signature, 0);
        let first = self.sorted.partition_point(|it| *it < key);
        let &(index, signature, place) = self.sorted.get(first)?;
        let other = &self.landed[place];
        let is_same = (index, signature) == (photon, from.photon.signature)
            && other.photon.last == from.photon.last;
        is_same.then(|| other.position - from.position)
    }

    /// The derivative of places along a row or column, between the photons before and after one.
    fn derivative(&self, at: &Landing, [before, after]: [Option<u64>; 2]) -> Option<DVec3> {
        let before = before.and_then(|photon| Some(-self.offset(at, photon)?));
        let after = after.and_then(|photon| self.offset(at, photon));
        let shorter = |a: &DVec3, b: &DVec3| a.length_squared().total_cmp(&b.length_squared());
        let along = before.into_iter().chain(after).min_by(shorter)?;
        Some(along - at.normal * along.dot(at.normal))
    }
}

/// The half axes of the ellipse a p + b q, a² + b² ≤ 1: the angle t of p cos t + q sin t, at which the length
/// is stationary, has tan 2t = 2 p·q / (p² - q²).
pub fn half_axes([p, q]: [DVec3; 2]) -> [DVec3; 2] {
    let turn = 0.5 * math::atan2(2.0 * p.dot(q), p.length_squared() - q.length_squared());
    let (sin, cos) = math::sin_cos(turn);
    [p * cos + q * sin, q * cos - p * sin]
}

/// The ellipses of photons that landed, and discs of those whose neighbours part from them; `least` as of
/// [`discs`].
pub fn ellipses(
    lattices: &[Lattice],
    cuboid: &Cuboid,
    settings: &Settings,
    landed: &[Landing],
    least: f64,
) -> Vec<Disc> {
    let places = Places::new(landed);
    let most = settings.splat_max * cuboid.diagonal();
    let scale = settings.splat_scale;
    let bounded = |length: f64| (scale * length.max(settings.splat_min).min(most)).max(least);
    let mut all = discs(cuboid, settings, landed, least);
    for (disc, landing) in all.iter_mut().zip(landed) {
        let beside = (lattices.iter()).find_map(|it| it.neighbours(landing.photon.index));
        let along = beside.map(|beside| beside.map(|pair| places.derivative(landing, pair)));
        if let Some([Some(u), Some(v)]) = along {
            let [long, short] = half_axes([u, v]);
            let first = long
                .try_normalize()
                .unwrap_or_else(|| landing.normal.any_orthonormal_vector());
            let half = [bounded(long.length()), bounded(short.length())];
            *disc = Disc::elliptic(landing, first, half, settings.bias);
        }
    }
    all
}
