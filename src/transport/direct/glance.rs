//! A first look at a texel, and the texels that need a closer one.

use super::look::ShareRange;
use super::texel::DirectTexel;
use crate::radiometry::Rgb;
use crate::transport::receiver::Receiver;

/// A texel's irradiance from few points, and the shares of the emitter that these see.
pub(super) struct Glance {
    pub(super) value: DirectTexel,
    pub(super) passed: ShareRange,
}

impl Glance {
    /// A texel that no light can reach.
    pub(super) const DARK: Self = Self {
        value: DirectTexel {
            irradiance: Rgb::BLACK,
            error: Rgb::BLACK,
        },
        passed: ShareRange::NOTHING_SEEN,
    };
}

/// True if a texel and its neighbours do not all see the same share of the emitter.
pub(super) fn is_near_edge(first: &[Glance], texel: usize, receiver: &Receiver) -> bool {
    let (column, row) = (texel % receiver.width(), texel / receiver.width());
    let near = |i: usize, count: usize| i.saturating_sub(1)..(i + 2).min(count);
    let mut seen = first[texel].passed;
    for row in near(row, receiver.height()) {
        for column in near(column, receiver.width()) {
            seen = seen.with(first[row * receiver.width() + column].passed);
        }
    }
    seen.is_mixed()
}
