//! Stage `lookup`: a caustic map read as a field of irradiance.

use glam::{DVec2, DVec3};

use super::settings::Lookup;
use super::work::Work;
use crate::approximation::bands::signed;
use crate::approximation::{DepthMap, LightView};
use crate::geometry::SurfacePoint;
use crate::radiometry::Rgb;

/// A caustic map, projected onto the scene as a shadow map is.
#[derive(Clone, Debug)]
pub struct CausticTexture {
    /// Where its texels are.
    pub view: LightView,
    /// Flux \[W\] by texel.
    pub flux: Vec<Rgb>,
    /// The receivers that the light sees.
    pub depths: Option<DepthMap>,
}

/// All caustic maps of a scene: one for each light and face.
#[derive(Clone, Debug)]
pub struct CausticTextures {
    /// The maps.
    pub maps: Vec<CausticTexture>,
    /// How texels are read.
    pub lookup: Lookup,
    /// Of the shadow test, as a fraction of the range of depths.
    pub bias: f64,
}

impl CausticTexture {
    fn texel(&self, column: i64, row: i64) -> Rgb {
        let last = signed(self.view.side()) - 1;
        let (column, row) = (column.clamp(0, last), row.clamp(0, last));
        self.flux[row as usize * self.view.side() + column as usize]
    }

    /// Flux \[W\] of a texel about an image point.
    fn read(&self, at: DVec2, lookup: Lookup, work: &mut Work) -> Rgb {
        if lookup == Lookup::Nearest {
            work.fetches += 1;
            return self.texel(at.x as i64, at.y as i64);
        }
        work.fetches += 4;
        let corner = at - 0.5;
        let base = corner.floor();
        let f = corner - base;
        let (column, row) = (base.x as i64, base.y as i64);
        let across =
            |row| self.texel(column, row) * (1.0 - f.x) + self.texel(column + 1, row) * f.x;
        across(row) * (1.0 - f.y) + across(row + 1) * f.y
    }
}

impl CausticTextures {
    /// Irradiance E [W/m²] at a point of a surface, on the side of its unit `normal`.
    pub fn irradiance(&self, point: &SurfacePoint, normal: DVec3, work: &mut Work) -> Rgb {
        let mut sum = Rgb::BLACK;
        for map in &self.maps {
            let position = point.position;
            // The map knows one surface along each of the light's rays: the side that faces it.
            if !map.view.is_before(position, normal) {
                continue;
            }
            let Some(seen) = map
                .view
                .project(position)
                .filter(|seen| map.view.holds(seen.at))
            else {
                continue;
            };
            let flux = map.read(seen.at, self.lookup, work);
            // Most of a map has no light: nothing is left to be divided, nor shadowed.
            if flux.is_black() {
                continue;
            }
            if let Some(depths) = &map.depths {
                work.fetches += 1;
                let [near, far] = depths.view().range();
                let hides = depths
                    .view()
                    .project(position)
                    .and_then(|seen| depths.at(seen.at))
                    .is_some_and(|depth| seen.depth > depth + self.bias * (far - near));
                if hides {
                    continue;
                }
            }
            sum += flux / map.view.seen_area(position, normal);
        }
        sum
    }
}
