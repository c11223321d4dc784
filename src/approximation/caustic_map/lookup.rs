//! Stage `lookup`: a caustic map read as a field of irradiance.

use std::ops::AddAssign;

use glam::{DVec2, DVec3};

use super::variants::Lookup;
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

/// What look-ups found, and their work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Looks {
    /// Counted.
    pub work: Work,
    /// On surfaces that face away from the light.
    pub turned: u64,
    /// Outside of a map.
    pub outside: u64,
    /// On texels without light.
    pub dark: u64,
    /// In the shadow of a receiver.
    pub hidden: u64,
    /// With light.
    pub lit: u64,
}

impl Looks {
    /// All of them.
    pub fn all(&self) -> u64 {
        self.turned + self.outside + self.dark + self.hidden + self.lit
    }
}

impl AddAssign for Looks {
    fn add_assign(&mut self, other: Self) {
        self.work += other.work;
        self.turned += other.turned;
        self.outside += other.outside;
        self.dark += other.dark;
        self.hidden += other.hidden;
        self.lit += other.lit;
    }
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
    pub fn irradiance(&self, point: &SurfacePoint, normal: DVec3, looks: &mut Looks) -> Rgb {
        let mut sum = Rgb::BLACK;
        for map in &self.maps {
            let position = point.position;
            // The map knows one surface along each of the light's rays: the side that faces it.
            if !map.view.is_before(position, normal) {
                looks.turned += 1;
                continue;
            }
            let Some(seen) = map
                .view
                .project(position)
                .filter(|seen| map.view.holds(seen.at))
            else {
                looks.outside += 1;
                continue;
            };
            let flux = map.read(seen.at, self.lookup, &mut looks.work);
            // Most of a map has no light: nothing is left to be divided, nor shadowed.
            if flux.is_black() {
                looks.dark += 1;
                continue;
            }
            if let Some(depths) = &map.depths {
                looks.work.fetches += 1;
                let [near, far] = depths.view().range();
                let hides = depths
                    .view()
                    .project(position)
                    .and_then(|seen| depths.at(seen.at))
                    .is_some_and(|depth| seen.depth > depth + self.bias * (far - near));
                if hides {
                    looks.hidden += 1;
                    continue;
                }
            }
            looks.lit += 1;
            sum += flux / map.view.seen_area(position, normal);
        }
        sum
    }
}
