//! Cameras over a floor, and the radiance that they connect.

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Hit, Ray, SurfacePoint, TraversalCounters};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::camera::{Camera, Connection};

use crate::support;

pub const FILM: &str = "<film type=\"hdrfilm\"><integer name=\"width\" value=\"120\"/>\
    <integer name=\"height\" value=\"80\"/><integer name=\"crop_offset_x\" value=\"10\"/>\
    <integer name=\"crop_offset_y\" value=\"20\"/><integer name=\"crop_width\" value=\"100\"/>\
    <integer name=\"crop_height\" value=\"50\"/><rfilter type=\"box\"/></film>";

pub const LOOK: &str = "<lookat origin=\"1, -5, 2\" target=\"0, 0, 0\" up=\"0, 0, 1\"/>";

pub fn scene(elements: &str) -> Scene {
    Scene::new(support::scene_files::scene(elements).unwrap()).unwrap()
}

pub fn sensor(plugin: &str, parameters: &str, transform: &str) -> String {
    format!(
        "<sensor type=\"{plugin}\">{parameters}<transform name=\"to_world\">{transform}</transform>\
         {FILM}</sensor>"
    )
}

pub fn perspective(parameters: &str) -> String {
    sensor("perspective", parameters, LOOK)
}

pub fn orthographic() -> String {
    let parameters =
        "<float name=\"near_clip\" value=\"0.5\"/><float name=\"far_clip\" value=\"20\"/>";
    let transform = format!("<scale x=\"1.5\" y=\"1.5\" z=\"2\"/>{LOOK}");
    sensor("orthographic", parameters, &transform)
}

pub fn camera(scene: &Scene) -> Camera {
    Camera::new(scene, &scene.sensors()[0]).unwrap()
}

/// Both kinds, with all that moves their images.
pub fn cameras() -> [String; 2] {
    let offset = "<float name=\"fov\" value=\"35\"/>\
        <float name=\"principal_point_offset_x\" value=\"0.07\"/>\
        <float name=\"principal_point_offset_y\" value=\"-0.04\"/>";
    [perspective(offset), orthographic()]
}

pub type MitsubaRay = ([f64; 3], [f64; 3]);

/// A floor of two colours (the back is red), and a lamp above it.
pub const FLOOR: &str = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"9\"/>\
    <rotate y=\"1\" angle=\"20\"/></transform><bsdf type=\"twosided\">\
    <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.2, 0.4, 0.8\"/></bsdf>\
    <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"1, 0, 0\"/></bsdf></bsdf></shape>";

pub const LAMP: DVec3 = DVec3::new(0.5, 0.3, 1.7);

pub fn connect(
    scene: &Scene,
    camera: &Camera,
    point: &SurfacePoint,
    from: DVec3,
) -> Option<Connection> {
    let direction = (point.position - from).normalize();
    // The first shape, of one colour: no other part of a hit is asked for.
    let hit = Hit {
        distance: 1.0,
        shape: 0,
        face: 0,
        barycentric: DVec2::ZERO,
    };
    camera.connect(
        scene,
        &hit,
        point,
        direction,
        &mut TraversalCounters::default(),
    )
}

/// The point at which a ray meets the first shape.
pub fn met(scene: &Scene, ray: &Ray) -> SurfacePoint {
    let hit = scene
        .world()
        .closest_hit(ray, f64::INFINITY, &mut TraversalCounters::default());
    scene.world().surface_point(ray, &hit.unwrap())
}
