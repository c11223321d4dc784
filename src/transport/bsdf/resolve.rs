//! From a scene's material to a [`Bsdf`] at a point.

use super::lobe::Lobe;
use super::smooth::{Interface, Metal};
use super::{Bsdf, Layer};
use crate::geometry::{Frame, Hit, SurfacePoint};
use crate::radiometry::Rgb;
use crate::scene::{Material, Scene};

/// Looks through masks at what they hold.
pub(super) fn at<'a>(scene: &'a Scene, hit: &Hit, point: &SurfacePoint) -> Bsdf<'a> {
    let mut material = scene.material_of(hit.shape);
    let mut opacity = 1.0;
    while let Material::Mask {
        opacity: own,
        nested,
    } = material
    {
        opacity *= own;
        material = scene.material(*nested);
    }
    if *material == Material::Null {
        opacity = 0.0;
    }
    let frame = Frame::around(point.shading_normal);
    let layer = |material| Layer {
        lobe: lobe(scene, material),
        frame,
    };
    let (front, back) = match material {
        Material::TwoSided { front, back } => (
            layer(scene.material(*front)),
            Some(layer(scene.material(*back))),
        ),
        _ => (layer(material), None),
    };
    Bsdf {
        geometric_normal: point.geometric_normal,
        shading_normal: point.shading_normal,
        passed: 1.0 - opacity,
        front,
        back,
    }
}

fn lobe<'a>(_scene: &'a Scene, material: &'a Material) -> Lobe<'a> {
    match *material {
        Material::Diffuse { reflectance } => Lobe::Diffuse(reflectance.unwrap_or(Rgb::BLACK)),
        Material::Dielectric {
            interior_ior,
            exterior_ior,
            specular_reflectance,
            specular_transmittance,
        } => Lobe::Dielectric(Interface {
            eta: interior_ior / exterior_ior,
            specular_reflectance,
            specular_transmittance,
        }),
        Material::ThinDielectric {
            interior_ior,
            exterior_ior,
            specular_reflectance,
            specular_transmittance,
        } => Lobe::Pane(Interface {
            eta: interior_ior / exterior_ior,
            specular_reflectance,
            specular_transmittance,
        }),
        Material::Conductor {
            eta,
            k,
            specular_reflectance,
        } => Lobe::Conductor(Metal {
            eta,
            k,
            specular_reflectance,
        }),
        Material::Null | Material::Mask { .. } | Material::TwoSided { .. } => Lobe::Black,
    }
}
