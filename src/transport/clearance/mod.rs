//! Whether all light of a cell goes the way that its six nodes went.
//!
//! A cell of light space is followed at its corners and the middles of its edges. Between them
//! there may be what none of the six saw: a thin thing in the way, or the edge of what they fell
//! on. So each leg of the path sweeps a [`Hull`], and is **clear** where
//!
//! - no other surface may overlap the hull,
//! - the surface that the leg starts on does not meet it again before its end, and
//! - the surface at its end catches all of it, up to the border that the nodes did not see.
//!
//! Where all legs are clear, all light of the cell meets the same surfaces in the same order.
//! Tests err on one side: a leg that is said to be clear is clear, as far as the six nodes show how
//! the cell's paths bend (see [`bulge`](crate::geometry::bulge)).
//!
//! A leg that is clear is so for every part of the cell: the part's hull lies in the cell's, up
//! to what both say of the bend. A [`CellClearance`] is therefore inherited, and a cell pays for each
//! leg once in its line.
//!
//! What this does not see: changes of the light within a surface (the onset of total reflection,
//! where topologies differ) and meshes that cut through each other inside the hull.

mod caught;
mod legs;
mod obstacles;
mod polygons;
mod same_surface;
mod trail;
mod tube;

use self::legs::{CameraSight, Leg, LegContact, record};
pub use self::trail::{Ending, Straight, Trail};
use super::first_surface::SurfaceChart;
use super::fixed_signature::PathFollower;
use crate::geometry::{Bounds, Hull, MeshBorder, Shape, range};
use crate::scene::Scene;

/// What is known of a cell's legs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellClearance {
    /// A bit a leg, the one from the source first: clear. Parts of the cell inherit it.
    pub legs: u32,
    /// Every leg is clear and all six nodes are of one topology: so are all paths of the cell.
    pub all: bool,
}

impl CellClearance {
    /// Whether nothing is between the source and the first surface, all over the cell: then
    /// no node of it need look.
    #[inline]
    pub fn is_in_sight(&self) -> bool {
        self.legs & 1 != 0
    }
}

/// Tells whether cells of a scene's light may be taken as one topology. One serves all sources,
/// signatures and threads.
pub struct Clearance<'a> {
    scene: &'a Scene,
    surfaces: Vec<Surface>,
}

/// What is known of a shape beforehand.
struct Surface {
    bounds: Bounds,
    /// Light goes on as if it were not there.
    passed: bool,
    /// Of a mesh.
    border: Option<MeshBorder>,
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

    /// Which legs of a cell are clear, by six paths of the follower's signature: those from the
    /// cell's corners, then from the middles of the edges opposite to them. Where a place is shared
    /// by several faces, its path may have been followed from any of them. Legs that
    /// are `already` known to be clear are not looked at again.
    ///
    /// Of a cell whose first surface is hidden all over, no leg is clear, but `all` is true.
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
        // Later legs have no bit: they are looked at again each time.
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
            .all(|leg| leg.sight != CameraSight::MaybeSeen);
        let wanted = u32::MAX >> (32 - record.legs.len().clamp(1, 32));
        found.all = record.one_topology && is_unseen && later && found.legs & wanted == wanted;
        found
    }

    /// Whether a blocker keeps all light of the first leg from its surface: whatever else is in
    /// the way can only help.
    fn is_hidden(&self, leg: &Leg) -> bool {
        let LegContact::Surface(shape) = leg.to else {
            return false;
        };
        let hull = Hull::new(&leg.start, &leg.end);
        self.is_caught(leg) && self.meets_own_surface_once(leg, &hull, shape)
    }

    fn is_clear(&self, leg: &Leg, is_first: bool) -> bool {
        match leg.sight {
            CameraSight::OutOfView => return true,
            CameraSight::OutOfViewToEnd if self.is_caught(leg) => return true,
            CameraSight::MaybeSeen => return false,
            CameraSight::OutOfViewToEnd | CameraSight::EndUnseen | CameraSight::NotAsked => {}
        }
        // The first leg is drawn from its end: it need not be caught.
        if !is_first && !self.is_caught(leg) || !self.misses_the_extension(leg) {
            return false;
        }
        let hull = Hull::new(&leg.start, &leg.end);
        self.surfaces.iter().enumerate().all(|(index, surface)| {
            let shape = index as u32;
            // After the last event, what is in the way of light that gets nowhere changes nothing.
            let is_harmless = leg.dark_over.is_some_and(|receiver| receiver != shape);
            if surface.passed || is_harmless || apart(&surface.bounds, hull.bounds()) {
                true
            } else if leg.starts_on(shape) || leg.ends_on(shape) {
                self.meets_own_surface_once(leg, &hull, shape)
            } else {
                !self.may_be_in_the_way(&hull, shape)
            }
        })
    }

    /// Whether no light of a leg lands beyond the receiver's border, where no node did.
    fn misses_the_extension(&self, leg: &Leg) -> bool {
        let Some(receiver) = leg.dark_over else {
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

fn apart(a: &Bounds, b: &Bounds) -> bool {
    a.min.cmpgt(b.max).any() || b.min.cmpgt(a.max).any()
}
