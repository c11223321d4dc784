//! Images in front of points that shine.

use glam::{DVec2, DVec3};

use super::BitmapTexture;
use crate::geometry::Transform;
use crate::radiometry::Rgb;

/// An image at unit distance in front of a point, upright across its axis, through which the point shines.
///
/// A direction is told by its place on that plane, d.xy / d.z in the point's frame. The image's parameters
/// (u, v) go from (0, 0) to (1, 1) between two places.
#[derive(Clone, Debug, PartialEq)]
pub struct Slide {
    image: BitmapTexture,
    /// The point, in world space.
    origin: DVec3,
    /// Orthonormal frame; the third is the axis.
    axes: [DVec3; 3],
    /// The place of (u, v) = (0, 0).
    first: DVec2,
    /// From there to that of (1, 1).
    size: DVec2,
}

impl Slide {
    /// An image before the origin of a frame, of which only rotation and translation matter. It reaches
    /// from the place of (u, v) = (0, 0) to that of (1, 1).
    pub fn new(image: BitmapTexture, to_world: &Transform, first: DVec2, last: DVec2) -> Self {
        Self {
            image,
            origin: to_world.point(DVec3::ZERO),
            axes: [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.vector(axis).normalize()),
            first,
            size: last - first,
        }
    }

    /// The point that shines, in world space.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Its frame, orthonormal; the third looks at the image.
    pub fn axes(&self) -> [DVec3; 3] {
        self.axes
    }

    /// The lowest and the highest coordinates of places on the image.
    pub fn extent(&self) -> (DVec2, DVec2) {
        let last = self.first + self.size;
        (self.first.min(last), self.first.max(last))
    }

    /// The image's value at a place.
    #[inline]
    pub fn at(&self, place: DVec2) -> Rgb {
        self.image.value(self.uv(place))
    }

    /// The value in a direction, wherever its place is: the image goes on beyond its borders as textures do.
    #[inline]
    pub fn towards(&self, direction: DVec3) -> Rgb {
        let [x, y, z] = self.axes.map(|axis| axis.dot(direction));
        self.at(DVec2::new(x, y) / z)
    }

    /// The radiant intensity in a direction (a unit vector), as a factor on the irradiance [W/m²] that the
    /// image gives the plane at unit distance: its value by cos³ θ. It is black beside the image and behind
    /// the point.
    #[inline]
    pub fn projected(&self, direction: DVec3) -> Rgb {
        let [x, y, z] = self.axes.map(|axis| axis.dot(direction));
        if z <= 0.0 {
            return Rgb::BLACK;
        }
        let uv = self.uv(DVec2::new(x, y) / z);
        if uv.cmplt(DVec2::ZERO).any() || uv.cmpgt(DVec2::ONE).any() {
            return Rgb::BLACK;
        }
        self.image.value(uv) * (1.0 / (z * z * z))
    }

    /// The largest value anywhere, channel by channel.
    pub fn peak(&self) -> Rgb {
        self.image.peak()
    }

    /// A bound of the values between two places, channel by channel.
    pub fn peak_between(&self, from: DVec2, to: DVec2) -> Rgb {
        let (from, to) = (self.uv(from), self.uv(to));
        self.image.peak_between(from.min(to), from.max(to))
    }

    /// True if a rectangle of places has more than a texel across.
    pub fn is_coarser_than_a_texel(&self, size: DVec2) -> bool {
        let texels = DVec2::new(
            self.image.image.width() as f64,
            self.image.image.height() as f64,
        );
        (size / self.size.abs() * texels).max_element() > 1.0
    }

    /// True if red, green and blue are the same everywhere.
    pub fn is_grey(&self) -> bool {
        let texels = self.image.image.texels();
        texels.iter().all(|[r, g, b]| r == g && g == b)
    }

    fn uv(&self, place: DVec2) -> DVec2 {
        (place - self.first) / self.size
    }
}
