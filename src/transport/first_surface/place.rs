//! Points of charts.

use crate::geometry::SurfacePoint;

/// A point of a chart.
#[derive(Clone, Copy, Debug)]
pub struct ChartPlace {
    /// On the surface.
    pub point: SurfacePoint,
    /// Surface area for a unit of chart area there \[m²\].
    pub area: f64,
}
