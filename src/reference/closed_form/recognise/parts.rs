//! The parts of a scene that a closed form is made from.

use glam::DVec3;

use super::plane::ReceiverPlane;
use crate::geometry::Shape;
use crate::radiometry::Rgb;
use crate::run::Refusal;
use crate::scene::{Emitter, Material, Scene, Sensor};

/// A scene's receiver, its one light, and all else.
pub(super) struct SceneContents<'a> {
    pub(super) plane: ReceiverPlane,
    pub(super) light: OneLight,
    /// All shapes but the receiver and the light's own.
    pub(super) bodies: Vec<Body<'a>>,
}

/// The scene's only emitter.
pub(super) struct OneLight {
    pub(super) origin: LightOrigin,
    /// Strength in the unit of its kind.
    pub(super) strength: Rgb,
    /// Name for messages.
    pub(super) name: String,
}

/// The place light comes from, in the receiver's coordinates.
pub(super) enum LightOrigin {
    Point(DVec3),
    /// The direction of travel, a unit vector.
    Parallel(DVec3),
    Spot {
        position: DVec3,
        /// Its axis, a unit vector.
        axis: DVec3,
        cutoff_angle: f64,
        beam_width: f64,
    },
    /// A rectangle's corners, counter-clockwise seen from the side that shines.
    Rectangle([DVec3; 4]),
}

/// A shape in the light's way.
pub(super) struct Body<'a> {
    pub(super) shape: &'a Shape,
    pub(super) material: &'a Material,
    /// Name for messages.
    pub(super) name: String,
}

/// The parts of a scene: its receiver, its one light, and all else.
///
/// # Errors
///
/// If the receiver, the emitters, or shapes beside an area light are none that closed forms know.
pub(super) fn contents<'a>(
    scene: &'a Scene,
    sensor: &Sensor,
) -> Result<SceneContents<'a>, Refusal> {
    let plane = ReceiverPlane::new(scene, sensor)?;
    let mut shining = scene
        .emitters()
        .iter()
        .enumerate()
        .filter(|(_, emitter)| !emitter.strength().is_black());
    let Some((index, emitter)) = shining.next() else {
        return Err(Refusal::new("no emitter shines: closed forms need one"));
    };
    if let Some((second, other)) = shining.next() {
        return Err(Refusal::new(format!(
            "emitters {index} ({}) and {second} ({}) both shine: closed forms know the light of one emitter",
            emitter.plugin(),
            other.plugin()
        )));
    }
    let name = format!("emitter {index} ({})", emitter.plugin());
    let origin = light_origin(scene, emitter, &plane, &name)?;
    let lamp = emitter.shape();
    let bodies: Vec<Body> = scene
        .world()
        .shapes()
        .iter()
        .zip(scene.objects())
        .enumerate()
        .filter(|(index, (_, object))| {
            let id = *index as u32;
            let is_passed = scene.material(object.material).is_passed(scene.materials());
            id != plane.shape && lamp.is_none_or(|lamp| lamp.0 != id) && !is_passed
        })
        .map(|(_, (shape, object))| Body {
            shape,
            material: scene.material(object.material),
            name: format!("shape \"{}\" ({})", object.id, object.plugin),
        })
        .collect();
    if lamp.is_some()
        && let Some(body) = bodies.first()
    {
        return Err(Refusal::new(format!(
            "{name} shines from a surface, and there is {} beside it: light from a surface is known with nothing in \
             its way",
            body.name
        )));
    }
    Ok(SceneContents {
        plane,
        light: OneLight {
            origin,
            strength: emitter.strength(),
            name,
        },
        bodies,
    })
}

fn light_origin(
    scene: &Scene,
    emitter: &Emitter,
    plane: &ReceiverPlane,
    name: &str,
) -> Result<LightOrigin, Refusal> {
    match emitter {
        Emitter::Point { position, .. } => Ok(LightOrigin::Point(plane.point(*position))),
        Emitter::Directional { direction, .. } => {
            Ok(LightOrigin::Parallel(plane.vector(*direction).normalize()))
        }
        Emitter::Projector { .. } | Emitter::Spot { slide: Some(_), .. } => Err(Refusal::new(
            format!("{name} throws an image: closed forms know lights without one"),
        )),
        Emitter::Spot {
            to_world,
            cutoff_angle,
            beam_width,
            ..
        } => Ok(LightOrigin::Spot {
            position: plane.point(to_world.point(DVec3::ZERO)),
            axis: plane.vector(to_world.vector(DVec3::Z)).normalize(),
            cutoff_angle: *cutoff_angle,
            beam_width: *beam_width,
        }),
        Emitter::DirectionalArea { .. } => Err(Refusal::new(format!(
            "{name} shines along the normals of a surface: closed forms know point, spot, directional, and area \
             lights"
        ))),
        Emitter::Area {
            texture: Some(_), ..
        } => Err(Refusal::new(format!(
            "{name} has a texture: closed forms know surfaces that shine evenly"
        ))),
        Emitter::Area { shape, .. } => {
            let object = &scene.objects()[shape.0 as usize];
            let Shape::Rectangle(lamp) = &scene.world().shapes()[shape.0 as usize] else {
                return Err(Refusal::new(format!(
                    "{name} shines from shape \"{}\" ({}): closed forms know light from a rectangle",
                    object.id, object.plugin
                )));
            };
            if shape.0 == plane.shape {
                return Err(Refusal::new(format!(
                    "{name} shines from the receiver itself, shape \"{}\": no light of it falls there",
                    object.id
                )));
            }
            let [u, v] = lamp.edges().map(|edge| 0.5 * edge);
            let center = lamp.center();
            let mut corners =
                [-u - v, u - v, u + v, v - u].map(|offset| plane.point(center + offset));
            if u.cross(v).dot(lamp.normal()) < 0.0 {
                corners.reverse();
            }
            Ok(LightOrigin::Rectangle(corners))
        }
        Emitter::Constant { .. } | Emitter::Envmap(_) | Emitter::Sunsky(_) => {
            Err(Refusal::new(format!(
                "{name} shines from all round: closed forms know point, spot, directional, and area lights"
            )))
        }
    }
}
