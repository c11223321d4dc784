//! What the last leg of a light path falls on: film coordinates for the end of a prescribed path.

use super::prescribed::End;
use super::receiver::Receiver;
use crate::geometry::{Hit, Ray, Shape, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::Scene;

/// A sensor as a prescribed path meets it.
#[derive(Clone, Copy, Debug)]
pub enum Screen<'a> {
    /// An irradiance meter: flux counts as it is.
    Receiver(&'a Receiver),
}

impl Screen<'_> {
    /// Columns and rows of the film.
    pub fn size(&self) -> [usize; 2] {
        match self {
            Self::Receiver(receiver) => [receiver.width(), receiver.height()],
        }
    }

    /// How a path ends whose last leg is `ray`, which met `hit` or nothing at all: where, the
    /// factor from its flux to what the film sums up, and a mark of the surface it ended on.
    ///
    /// The plane of a rectangle goes on beyond its border where nothing else is in the way: then
    /// the border needs no attention, the film's edge cuts what lands there.
    #[inline]
    pub fn end(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<&Hit>,
        _counters: &mut TraversalCounters,
    ) -> (End, Rgb, u64) {
        let Self::Receiver(receiver) = self;
        let shape = &scene.world().shapes()[receiver.shape() as usize];
        if let Some(hit) = hit
            && hit.shape == receiver.shape()
        {
            let point = scene.world().surface_point(ray, hit);
            return match receiver.place(&point, ray.direction) {
                Some(at) => (End::Landed(at), Rgb::WHITE, 0),
                None => (End::Stopped, Rgb::BLACK, 0),
            };
        }
        if let Shape::Rectangle(rectangle) = shape
            && rectangle.normal().dot(ray.direction) < 0.0
            && let Some((distance, uv)) = rectangle.meet_beyond(ray)
            && hit.is_none_or(|hit| hit.distance > distance)
        {
            return (End::Landed(receiver.film_place(uv)), Rgb::WHITE, 0);
        }
        match hit {
            Some(_) => (End::Stopped, Rgb::BLACK, 1),
            None => (End::Escaped, Rgb::BLACK, 0),
        }
    }
}
