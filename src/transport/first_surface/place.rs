//! Points of charts.

use crate::geometry::SurfacePoint;

/// A point of a chart.
#[derive(Clone, Copy, Debug)]
pub struct ChartPlace {
    /// The point on the surface.
    pub point: SurfacePoint,
    /// Surface area \[m²\] for a unit of chart area there.
    pub area: f64,
}
