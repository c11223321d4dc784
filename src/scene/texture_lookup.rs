//! The values of a scene's textures at a place of a surface.

use glam::DVec2;

use super::{Color, Scalar, Scene, Texture, TextureId, luminance};
use crate::geometry::{Hit, Mesh, Shape, SurfacePoint};
use crate::radiometry::Rgb;

/// The place of a surface at which a texture is looked up.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint<'a> {
    /// Surface parameters.
    pub uv: DVec2,
    /// The mesh, face and barycentric weights, if the surface is a mesh.
    pub mesh: Option<(&'a Mesh, u32, DVec2)>,
}

impl<'a> TexturePoint<'a> {
    /// The place of a hit; `point` must be [`World::surface_point`](crate::geometry::World::surface_point) of
    /// it.
    #[inline]
    pub fn new(scene: &'a Scene, hit: &Hit, point: &SurfacePoint) -> Self {
        let mesh = match &scene.world().shapes()[hit.shape as usize] {
            Shape::Mesh(mesh) => Some((mesh, hit.face, hit.barycentric)),
            _ => None,
        };
        Self { uv: point.uv, mesh }
    }
}

impl Scene {
    /// The value of a colour at a point; black if it is unknown.
    #[inline]
    #[doc(hidden)]
    pub fn color(&self, color: Color, at: &TexturePoint) -> Rgb {
        match color {
            Color::Constant(rgb) => rgb,
            Color::Texture(id) => self.texture_value(id, at),
            Color::Unknown => Rgb::BLACK,
        }
    }

    /// The value of a number at a point.
    #[inline]
    #[doc(hidden)]
    pub fn scalar(&self, scalar: Scalar, at: &TexturePoint) -> f64 {
        match scalar {
            Scalar::Constant(number) => number,
            Scalar::Texture(id) => luminance(self.texture_value(id, at)),
        }
    }

    /// The value of a texture at a point.
    #[doc(hidden)]
    pub fn texture_value(&self, id: TextureId, at: &TexturePoint) -> Rgb {
        match self.texture(id) {
            Texture::Bitmap(bitmap) => bitmap.value(at.uv),
            Texture::Checkerboard {
                color0,
                color1,
                to_uv,
            } => {
                let uv = to_uv.transform_point2(at.uv);
                let first_half = |x: f64| x - x.floor() < 0.5;
                if first_half(uv.x) == first_half(uv.y) {
                    *color0
                } else {
                    *color1
                }
            }
            Texture::MeshAttribute { name, scale } => at
                .mesh
                .and_then(|(mesh, face, weights)| mesh.attribute(name, face, weights))
                .map_or(Rgb::BLACK, |value| Rgb(value) * *scale),
            Texture::Scaled { nested, scale } => self.texture_value(*nested, at) * *scale,
        }
    }

    /// The change of a texture's luminance with u and v; zero if it is not known.
    #[doc(hidden)]
    pub fn texture_gradient(&self, id: TextureId, at: &TexturePoint) -> DVec2 {
        match self.texture(id) {
            Texture::Bitmap(bitmap) => bitmap.gradient(at.uv),
            Texture::Scaled { nested, scale } if scale.is_grey() => {
                self.texture_gradient(*nested, at) * scale.0[0]
            }
            _ => DVec2::ZERO,
        }
    }
}
