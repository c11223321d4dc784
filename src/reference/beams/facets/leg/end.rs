//! The thing that a polygon's leg ends on.

use glam::DVec3;

use crate::geometry::{Ray, Shape};
use crate::transport::facets::path::FacetPaths;
use crate::transport::screen::Screen;

/// The end of a polygon's leg, if nothing else is in its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::reference::beams::facets) enum LegEnd {
    /// A facet, within its edges.
    Facet(u32),
    /// The sensor, after the last event: the plane of a receiver.
    Sensor,
    /// A shape that is not flat and ends it.
    Blocked(u32),
    /// Nothing: the light leaves the scene.
    Away,
    /// A surface that is not flat and sends light on.
    Curved,
}

impl LegEnd {
    /// True if the place of the light at the end is known before a search. It is not for the surfaces that a
    /// camera sees, nor on a receiver on whose film lines are not lines.
    pub(super) fn is_known(self, paths: &FacetPaths<'_>, screen: &Screen<'_>) -> bool {
        self != Self::Sensor || rectangular_receiver(paths, screen).is_some()
    }

    /// The point where a ray's line meets a facet's or a rectangular receiver's plane; `None` for other ends.
    pub(in crate::reference::beams::facets) fn place(
        self,
        paths: &FacetPaths<'_>,
        screen: &Screen<'_>,
        ray: &Ray,
    ) -> Option<DVec3> {
        match self {
            Self::Facet(facet) => Some(paths.facets.get(facet).meet(ray)?.position),
            Self::Sensor => Some(ray.at(rectangular_receiver(paths, screen)?.meet_beyond(ray)?.0)),
            Self::Blocked(_) | Self::Away | Self::Curved => None,
        }
    }
}

/// The receiver, if it is a rectangle. On its film, lines of the plane are lines; on a disc's, which is
/// polar, they are not.
pub(in crate::reference::beams::facets) fn rectangular_receiver<'a>(
    paths: &FacetPaths<'a>,
    screen: &Screen<'_>,
) -> Option<&'a Shape> {
    let Screen::Receiver(receiver) = screen else {
        return None;
    };
    let shape = &paths.scene.world().shapes()[receiver.shape() as usize];
    matches!(shape, Shape::Rectangle(_)).then_some(shape)
}
