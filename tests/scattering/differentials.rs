//! Derivatives of rays are exact: they agree with differences of rays, and with the textbook's lenses and
//! mirrors.

use glam::{DMat2, DVec2, DVec3};
use nephroid::internals::geometry::{Ray, TraversalCounters};
use nephroid::internals::mitsuba;
use nephroid::internals::optics::{RayDerivative, reflect, refract};
use nephroid::internals::scene::{Scene, SensorKind};
use nephroid::internals::transport::differentials::{ChainStep, Follower, Landing, ThinBeam};
use nephroid::internals::transport::domain::LightSpace;
use nephroid::internals::transport::scatter::ShadingNormals;

use crate::support::bundled;

/// A ball of radius r about the origin, of index n, in parallel light along +z that is moved by x: the
/// paraxial ray at the height 0 turns by −x (n − 1)/(n r) at the first surface (the lens maker's power of one
/// surface).
#[test]
fn a_spherical_surface_has_the_lens_makers_power() {
    let (radius, eta) = (2.5, 1.5);
    let along = DVec3::Z;
    let start = RayDerivative {
        position: DVec3::X,
        direction: DVec3::ZERO,
    };
    let normal = -DVec3::Z;
    let arrived = start.transferred(along, 7.0, normal);
    assert_eq!(arrived.position, DVec3::X);
    let turn = arrived.position / radius;
    let inside = arrived.refracted(along, normal, turn, eta).unwrap();
    let power = (eta - 1.0) / (eta * radius);
    // Half a dozen roundings.
    assert!((inside.direction.x + power).abs() < 1e-15);
    // A concave mirror (seen from inside the ball) focuses at r/2: the direction changes by −2/r.
    let mirrored = arrived.reflected(along, -normal, -turn);
    assert!((mirrored.direction.x.abs() - 2.0 / radius).abs() < 1e-15);
}

#[test]
fn derivatives_of_the_formulas_agree_with_differences() {
    // A generic ray onto a generic curved surface: n(s) and D(s) given as functions of one coordinate.
    let direction =
        |s: f64| DVec3::new(0.3 + 0.7 * s, 0.1 - 0.4 * s, -1.0 + 0.2 * s * s).normalize();
    let normal = |s: f64| DVec3::new(0.2 - 0.9 * s, -0.1 + 0.5 * s, 1.0).normalize();
    let difference = |f: &dyn Fn(f64) -> DVec3| {
        // Central, with Richardson's extrapolation: the error is h⁴ f⁽⁵⁾ / 30 ~ 1e-11 and rounding 1e-16 / h
        // ~ 1e-13.
        let h = 1e-3;
        let at = |h: f64| (f(h) - f(-h)) / (2.0 * h);
        (at(0.5 * h) * 4.0 - at(h)) / 3.0
    };
    let derivative = RayDerivative {
        position: DVec3::ZERO,
        direction: difference(&direction),
    };
    let turn = difference(&normal);
    let reflected = derivative.reflected(direction(0.0), normal(0.0), turn);
    let expected = difference(&|s| reflect(direction(s), normal(s)));
    assert!(reflected.direction.distance(expected) < 1e-9);
    for eta in [1.5, 1.0 + 1e-9, 0.75] {
        let refracted = derivative
            .refracted(direction(0.0), normal(0.0), turn, eta)
            .unwrap();
        let expected = difference(&|s| refract(direction(s), normal(s), eta).unwrap());
        assert!(refracted.direction.distance(expected) < 1e-9, "{eta}");
    }
    // Beyond the critical angle there is nothing to differentiate.
    let steep = DVec3::new(0.9, 0.0, -0.4).normalize();
    let critical = derivative.refracted(steep, DVec3::Z, turn, 0.6);
    assert_eq!(critical, None);
}

#[test]
fn a_transferred_point_stays_on_the_surface() {
    let normal = DVec3::new(0.2, -0.3, 1.0).normalize();
    let direction = DVec3::new(0.5, 0.1, -1.0).normalize();
    let start = RayDerivative {
        position: DVec3::new(0.3, 0.2, 0.9),
        direction: DVec3::new(0.1, -0.4, 0.01),
    };
    let arrived = start.transferred(direction, 3.7, normal);
    // A dozen roundings of numbers below 2.
    assert!(arrived.position.dot(normal).abs() < 1e-14);
    assert_eq!(arrived.direction, start.direction);
}

/// A scene with every kind of specular surface that the shipped ones lack: a tilted disk and a tilted
/// rectangle of glass, a glass tube, lit by a spot.
const OTHERS: &str = r#"<scene version="3.0.0">
    <emitter type="spot">
        <transform name="to_world"><lookat origin="0.3, 0.1, 6" target="0, 0, 0" up="0, 1, 0"/></transform>
        <rgb name="intensity" value="1"/><float name="cutoff_angle" value="30"/><float name="beam_width" value="20"/>
    </emitter>
    <shape type="rectangle"><transform name="to_world"><scale value="0.8"/><rotate x="1" y="2" angle="25"/><translate x="-0.9" z="3"/></transform>
        <bsdf type="dielectric"/></shape>
    <shape type="disk"><transform name="to_world"><scale value="0.7"/><rotate y="1" angle="-35"/><translate x="1.2" z="2.2"/></transform>
        <bsdf type="dielectric"/></shape>
    <shape type="cylinder"><point name="p0" x="-1" y="1" z="1.2"/><point name="p1" x="1" y="1.3" z="1.5"/><float name="radius" value="0.4"/>
        <bsdf type="dielectric"/></shape>
    <shape type="sphere"><point name="center" x="0.2" y="-0.9" z="1"/><float name="radius" value="0.5"/>
        <bsdf type="dielectric"/></shape>
    <shape type="rectangle"><transform name="to_world"><scale value="6"/></transform>
        <sensor type="irradiancemeter"><film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film></sensor></shape>
</scene>"#;

fn others() -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("others.xml");
    std::fs::write(&path, OTHERS).unwrap();
    mitsuba::load(&path, &[]).unwrap()
}

fn receiver(scene: &Scene) -> u32 {
    scene
        .sensors()
        .iter()
        .find_map(|sensor| match sensor.kind {
            SensorKind::IrradianceMeter { shape } => Some(shape.0),
            _ => None,
        })
        .unwrap()
}

#[test]
fn the_derivatives_of_a_landing_agree_with_differences_of_landings() {
    let mut shapes_seen = std::collections::BTreeSet::new();
    for (name, scene) in [
        "glass-ball",
        "coffee-cup",
        "cube",
        "glass-ball-mesh",
        "water",
        "lens",
    ]
    .map(|name| (name, bundled(name, 8)))
    .into_iter()
    .chain([("others", others())])
    {
        let light = LightSpace::new(&scene).unwrap();
        let mut follower = Follower::new(&scene, receiver(&scene), 5, ShadingNormals::Flux);
        let mut compared = 0;
        for cell in light.cells().iter().step_by(7) {
            let chart = &light.charts()[cell.chart()];
            let place = cell.patch().at(DVec2::new(0.37, 0.61));
            let beam = |place: DVec2| {
                let emission = chart.delta_emission(place).unwrap();
                (emission.falloff > 0.0).then(|| ThinBeam::new(&emission))
            };
            let Some(start) = beam(place) else { continue };
            let mut landings: Vec<(Vec<ChainStep>, Landing)> = Vec::new();
            follower.every_path(&start, &mut |chain, landing| {
                landings.push((chain.to_vec(), *landing));
            });
            // Differences of rays that stay on the same faces: a step far smaller than a face.
            let size = cell.patch().to.x - cell.patch().from.x;
            for (chain, landing) in landings {
                for (axis, exact) in [DVec2::X, DVec2::Y].into_iter().zip(landing.derivatives) {
                    let mut at = |step: f64| {
                        let (met, landed) =
                            follower.retrace(&beam(place + axis * step)?, &chain)?;
                        Some((
                            met.iter().map(|(hit, _)| hit.face).collect::<Vec<_>>(),
                            landed.point.position,
                        ))
                    };
                    let mut difference = |step: f64| {
                        let ((before, low), (after, high)) = (at(-step)?, at(step)?);
                        (before == after).then(|| (high - low) / (2.0 * step))
                    };
                    let step = 1e-4 * size;
                    let (Some(fine), Some(coarse)) = (difference(step), difference(2.0 * step))
                    else {
                        continue;
                    };
                    // Central differences err by a third of what they change from twice the step on (f''' h²
                    // / 6), and by the rounding of landings (1e-15 of coordinates below 100, and more where
                    // light is spread) over the step.
                    let spread = landing.derivatives[0].length() + landing.derivatives[1].length();
                    let bound = 2.0 * fine.distance(coarse)
                        + 1e-15 * (100.0 + landing.point.position.length() + spread) * 10.0 / step;
                    if bound > 1e-3 * spread {
                        continue; // a difference that says nothing: nearly grazing, or far away
                    }
                    assert!(
                        fine.distance(exact) < bound,
                        "{name} {chain:?} at {place}: {exact} but {fine} ± {bound}"
                    );
                    compared += 1;
                    shapes_seen.extend(
                        chain.iter().map(|link| {
                            (name, scene.objects()[link.element.shape as usize].plugin)
                        }),
                    );
                }
            }
        }
        assert!(
            compared > 100,
            "{name}: only {compared} derivatives were compared"
        );
    }
    let plugins: std::collections::BTreeSet<_> =
        shapes_seen.iter().map(|(_, plugin)| *plugin).collect();
    for plugin in ["sphere", "cylinder", "rectangle", "disk", "ply", "cube"] {
        assert!(plugins.contains(plugin), "no path met a {plugin}");
    }
}

/// Along its own chain, whatever is in the way, light lands where it lands in the scene.
#[test]
fn a_forced_chain_agrees_with_the_scene_where_nothing_is_in_the_way() {
    for name in ["glass-ball", "coffee-cup", "cube", "glass-ball-mesh"] {
        let scene = bundled(name, 8);
        let light = LightSpace::new(&scene).unwrap();
        let mut follower = Follower::new(&scene, receiver(&scene), 4, ShadingNormals::Flux);
        let mut compared = 0;
        for cell in light.cells().iter().step_by(13) {
            let emission = light.charts()[cell.chart()]
                .delta_emission(cell.patch().from)
                .unwrap();
            let beam = ThinBeam::new(&emission);
            let mut landings = Vec::new();
            follower.every_path(&beam, &mut |chain, landing| {
                landings.push((chain.to_vec(), *landing));
            });
            for (chain, landing) in landings {
                let forced = follower.along(&beam, &chain).unwrap();
                let jacobian = |landing: &Landing| {
                    let [x, y] = landing.derivatives;
                    DMat2::from_cols(x.truncate(), y.truncate())
                };
                let (real, forced_jacobian) = (jacobian(&landing), jacobian(&forced));
                let spread = real.x_axis.length() + real.y_axis.length();
                // The two meet planes at distances that differ by rounding: 1e-15 of lengths below 30, spread
                // by each surface.
                let bound = 1e-13 * (30.0 + spread + landing.point.position.length());
                assert!(
                    forced.point.position.distance(landing.point.position) < bound,
                    "{name} {chain:?}"
                );
                assert!(
                    (forced_jacobian.x_axis - real.x_axis).length() < 1e-7 * spread.max(1.0),
                    "{name} {chain:?}"
                );
                compared += 1;
            }
        }
        assert!(compared > 100, "{name}: {compared}");
    }
}

/// A flat mirror and a rectangle are met beyond their borders when forced, but not in the scene.
#[test]
fn forced_chains_extend_flat_surfaces() {
    let scene = others();
    let world = scene.world();
    let disk = scene
        .objects()
        .iter()
        .position(|object| object.plugin == "disk")
        .unwrap();
    let element = nephroid::internals::geometry::SurfaceElement {
        shape: disk as u32,
        face: None,
    };
    let ray = Ray::new(DVec3::new(-3.0, 0.0, 6.0), -DVec3::Z);
    let mut counters = TraversalCounters::default();
    let (hit, point) = world.meet_element(&ray, element, &mut counters).unwrap();
    assert_eq!(hit.shape, disk as u32);
    // The plane of the disk: through (1.2, 0, 2.2), turned by −35° about y.
    let expected = 2.2 + (-3.0 - 1.2) * 35f64.to_radians().tan();
    assert!(
        (point.position.z - expected).abs() < 1e-5,
        "{} {expected}",
        point.position
    );
}
