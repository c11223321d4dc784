//! The clearance of cells.

use super::legs::{Leg, LegContact, LegSight, record};
use super::trail::Trail;
use crate::geometry::{Bounds, Hull, MeshBorder, Shape, range};
use crate::scene::Scene;
use crate::transport::first_surface::SurfaceChart;
use crate::transport::fixed_signature::PathFollower;

/// Knowledge of a cell's legs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellClearance {
    /// One bit a leg, the leg from the source first: 1 if it is clear. Parts of the cell inherit it.
    pub legs: u32,
    /// True if every leg is clear and all six nodes are of one topology: then all paths of the cell are.
    pub all: bool,
}

impl CellClearance {
    /// True if nothing is between the source and the first surface, all over the cell. Then its nodes need
    /// not test that.
    #[inline]
    pub fn is_in_sight(&self) -> bool {
        self.legs & 1 != 0
    }
}

/// Test of a scene's cells of light: may a cell be taken as one topology? One serves all sources, signatures
/// and threads.
pub struct Clearance<'a> {
    pub(super) scene: &'a Scene,
    pub(super) surfaces: Vec<Surface>,
}

/// Knowledge of a shape that is gathered beforehand.
pub(super) struct Surface {
    pub(super) bounds: Bounds,
    /// True if light goes on as if the shape were not there.
    pub(super) passed: bool,
    /// The border, for a mesh.
    pub(super) border: Option<MeshBorder>,
}

impl<'a> Clearance<'a> {
    /// Looks through the scene's meshes once, for borders that light can slip past.
    pub fn new(scene: &'a Scene) -> Self {
        let surfaces = scene.world().shapes().iter().enumerate();
        Self {
            scene,
            surfaces: surfaces
                .map(|(index, shape)| Surface {
                    bounds: shape.bounds(),
                    passed: scene.material_of(index as u32).is_passed(scene.materials()),
                    border: match shape {
                        Shape::Mesh(mesh) => Some(mesh.border()),
                        _ => None,
                    },
                })
                .collect(),
        }
    }

    /// The legs of a cell that are clear, by six paths of the follower's signature. They start at the cell's
    /// corners, then at the middles of the opposite edges. If several faces share a place, its path may start
    /// from any of them. Legs that are `already` known to be clear are not tested again.
    ///
    /// For a cell whose first surface is hidden all over, no leg is clear, but `all` is true.
    pub fn clear<const N: usize>(
        &self,
        follower: &mut PathFollower<'a, N>,
        chart: &SurfaceChart,
        trails: &[Trail; 6],
        already: CellClearance,
    ) -> CellClearance {
        if already.all {
            return already;
        }
        let record = record(follower, chart, trails);
        if record.hidden {
            let hidden =
                record.one_topology && record.legs.len() == 1 && self.is_hidden(&record.legs[0]);
            return CellClearance {
                legs: already.legs,
                all: hidden,
            };
        }
        let mut found = already;
        // Later legs have no bit: they are tested again each time.
        let mut later = true;
        for (index, leg) in record.legs.iter().enumerate() {
            match 1_u32.checked_shl(index as u32) {
                Some(bit) if found.legs & bit == 0 && self.is_clear(leg, index == 0) => {
                    found.legs |= bit;
                }
                Some(_) => {}
                None => later = later && self.is_clear(leg, false),
            }
        }
        // A leg may have been clear for a larger cell, some of whose nodes the camera saw.
        let is_unseen = record
            .legs
            .iter()
            .all(|leg| leg.sight != LegSight::MaybeSeen);
        let wanted = u32::MAX >> (32 - record.legs.len().clamp(1, 32));
        found.all = record.one_topology && is_unseen && later && found.legs & wanted == wanted;
        found
    }

    /// True if a blocker keeps all light of the first leg from its surface. Anything else in the way can only
    /// help.
    pub(super) fn is_hidden(&self, leg: &Leg) -> bool {
        let LegContact::Surface(shape) = leg.to else {
            return false;
        };
        let hull = Hull::new(&leg.start, &leg.end);
        self.is_caught(leg) && self.meets_own_surface_once(leg, &hull, shape)
    }

    fn is_clear(&self, leg: &Leg, is_first: bool) -> bool {
        match leg.sight {
            LegSight::OutOfView => return true,
            LegSight::OutOfViewToEnd if self.is_caught(leg) => return true,
            LegSight::MaybeSeen => return false,
            LegSight::OutOfViewToEnd
            | LegSight::EndUnseen
            | LegSight::DarkOver(_)
            | LegSight::NotAsked => {}
        }
        // The first leg is drawn from its end: it need not be caught.
        if !is_first && !self.is_caught(leg) || !self.misses_the_extension(leg) {
            return false;
        }
        let hull = Hull::new(&leg.start, &leg.end);
        self.surfaces.iter().enumerate().all(|(index, surface)| {
            let shape = index as u32;
            // After the last event, an obstacle changes nothing for light that does not land.
            let is_harmless =
                matches!(leg.sight, LegSight::DarkOver(receiver) if receiver != shape);
            if surface.passed || is_harmless || apart(&surface.bounds, hull.bounds()) {
                true
            } else if leg.starts_on(shape) || leg.ends_on(shape) {
                self.meets_own_surface_once(leg, &hull, shape)
            } else {
                !self.may_be_in_the_way(&hull, shape)
            }
        })
    }

    /// True if no light of a leg lands beyond the receiver's border, where no node did.
    fn misses_the_extension(&self, leg: &Leg) -> bool {
        let LegSight::DarkOver(receiver) = leg.sight else {
            return true;
        };
        let Some([center, normal]) = self.scene.world().shapes()[receiver as usize].plane() else {
            return true;
        };
        if leg.starts_on(receiver) {
            return true;
        }
        let [low, high] = range(&leg.start.map(|point| normal.dot(point - center)));
        if high <= 0.0 {
            return true; // from behind, light meets nothing but the receiver itself
        }
        let keeps_above = match leg.to {
            LegContact::Nothing => range(&leg.along().map(|along| normal.dot(along)))[0] >= 0.0,
            _ => range(&leg.end.map(|point| normal.dot(point - center)))[0] > 0.0,
        };
        low > 0.0 && keeps_above
    }
}

pub(super) fn apart(a: &Bounds, b: &Bounds) -> bool {
    a.min.cmpgt(b.max).any() || b.min.cmpgt(a.max).any()
}
