//! The values of a scene's textures at a place of a surface.

use glam::{DMat3, DVec2};

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
            Scalar::Texture(id) => match self.texture(id) {
                // As in Mitsuba 3.9: its `eval_1` has color1 where its `eval` has color0.
                Texture::Checkerboard {
                    color0,
                    color1,
                    to_uv,
                } => match checkered([*color1, *color0], *to_uv, at.uv) {
                    Color::Texture(nested) => self.scalar(Scalar::Texture(nested), at),
                    color => luminance(color.even()),
                },
                _ => luminance(self.texture_value(id, at)),
            },
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
            } => self.color(checkered([*color0, *color1], *to_uv, at.uv), at),
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

/// The first of two colours where u and v are in the same half of the unit interval, else the second.
fn checkered([same, other]: [Color; 2], to_uv: DMat3, uv: DVec2) -> Color {
    let uv = to_uv.transform_point2(uv);
    let first_half = |x: f64| x - x.floor() < 0.5;
    if first_half(uv.x) == first_half(uv.y) {
        same
    } else {
        other
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;

    /// A scene, and the texture of its mask's opacity.
    fn masked(text: &str) -> (Scene, TextureId) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("masked.xml");
        std::fs::write(&file, text).unwrap();
        let scene = crate::mitsuba::load(&file, &[]).unwrap();
        let opacity = scene.materials().iter().flat_map(Material::scalars).next();
        let Some(Scalar::Texture(id)) = opacity else {
            panic!("no texture");
        };
        (scene, id)
    }

    #[test]
    fn a_checkerboard_as_a_number_has_its_colours_swapped_as_in_mitsuba() {
        let text = r#"<scene version="3.0.0"><shape type="rectangle"><bsdf type="mask">
            <texture name="opacity" type="checkerboard">
                <float name="color0" value="0.1"/><float name="color1" value="0.9"/></texture>
            <bsdf type="diffuse"/></bsdf></shape></scene>"#;
        let (scene, id) = masked(text);
        // Mitsuba 3.9.1: t.eval(si) is 0.1, 0.9, 0.9, 0.1 there, and t.eval_1(si) 0.9, 0.1, 0.1, 0.9.
        let places = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)];
        for ((u, v), [as_number, as_colour]) in
            places
                .into_iter()
                .zip([[0.9, 0.1], [0.1, 0.9], [0.1, 0.9], [0.9, 0.1]])
        {
            let at = TexturePoint {
                uv: DVec2::new(u, v),
                mesh: None,
            };
            assert!((scene.scalar(Scalar::Texture(id), &at) - as_number).abs() < 1e-15);
            assert_eq!(scene.texture_value(id, &at), Rgb::grey(as_colour));
        }
    }

    #[test]
    fn a_checkerboards_squares_may_be_textures_with_coordinates_of_their_own() {
        let text = r#"<scene version="3.0.0"><shape type="rectangle"><bsdf type="mask">
            <texture name="opacity" type="checkerboard">
                <texture name="color0" type="checkerboard">
                    <float name="color0" value="0.1"/><float name="color1" value="0.2"/>
                    <transform name="to_uv"><scale x="2" y="2"/></transform></texture>
                <float name="color1" value="0.9"/></texture>
            <bsdf type="diffuse"/></bsdf></shape></scene>"#;
        let (scene, id) = masked(text);
        // The first square is itself divided in four; as a number, both boards swap their colours.
        for (place, as_colour, as_number) in [
            ((0.1, 0.1), 0.1, 0.9),
            ((0.3, 0.1), 0.2, 0.9),
            ((0.7, 0.1), 0.9, 0.2),
            ((0.8, 0.1), 0.9, 0.1),
        ] {
            let at = TexturePoint {
                uv: place.into(),
                mesh: None,
            };
            assert_eq!(
                scene.texture_value(id, &at),
                Rgb::grey(as_colour),
                "{place:?}"
            );
            let number = scene.scalar(Scalar::Texture(id), &at);
            assert!((number - as_number).abs() < 1e-15, "{place:?}: {number}");
        }
    }
}
