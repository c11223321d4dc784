//! Beams by way of flat facets against closed forms: parallel light is exact.

use std::f64::consts::TAU;
use std::path::Path as FilePath;

use glam::{DVec2, DVec3};
use nephroid::internals::generate::{
    BrilliantCut, equilateral_prism, geodesic_sphere, round_brilliant, write_ply,
};
use nephroid::internals::geometry::{Mesh, MeshParts, Shape};
use nephroid::internals::mitsuba;
use nephroid::internals::reference::beams::BeamSettings;
use nephroid::internals::reference::beams::run::Setup;
use nephroid::internals::reference::closed_form::{
    FlatFacets, KnownPath, ParallelLight, TexelGrid,
};
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, LayerName, Progress};
use nephroid::internals::scene::{Crop, Scene, SensorKind};
use nephroid::internals::transport::facets::path::{FacetChain, FacetLight, FacetPaths};
use nephroid::internals::transport::facets::table::Facets;
use nephroid::internals::transport::first_surface::Source;
use nephroid::internals::transport::receiver::Receiver;
use nephroid::internals::transport::scatter::ShadingNormals;
use nephroid::internals::transport::signature::{Event, MAX_EVENTS, Signature};

use crate::support::Photons;
use crate::support::beams::beams_to;
use crate::support::scenes::over_floor;

const SIDE: u32 = 128;

/// A shipped scene with its solid as the formula makes it: files hold it rounded to single precision.
struct Solid {
    scene: Scene,
    parts: MeshParts,
    ior: f64,
    half_width: f64,
}

fn solid(name: &str, ior: f64, half_width: f64, formula: Option<MeshParts>) -> Solid {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name)
        .with_extension("xml");
    let mut scene = mitsuba::load_parts(&file, &[]).unwrap();
    for sensor in &mut scene.sensors {
        sensor.film.width = SIDE;
        sensor.film.height = SIDE;
        sensor.film.crop = Crop {
            offset_x: 0,
            offset_y: 0,
            width: SIDE,
            height: SIDE,
        };
    }
    let is_mesh = |shape: &&mut Shape| matches!(shape, Shape::Mesh(_));
    let shape = scene.shapes.iter_mut().find(is_mesh).unwrap();
    let Shape::Mesh(mesh) = &*shape else {
        panic!("{name} has no mesh");
    };
    let parts = formula.unwrap_or_else(|| MeshParts {
        positions: mesh.positions().to_vec(),
        triangles: mesh.triangles().to_vec(),
        face_normals: true,
        ..MeshParts::default()
    });
    *shape = Shape::Mesh(Mesh::new(parts.clone()).unwrap());
    Solid {
        scene: Scene::new(scene).unwrap(),
        parts,
        ior,
        half_width,
    }
}

fn turned(mut parts: MeshParts, turn: impl Fn(DVec3) -> DVec3) -> MeshParts {
    for position in &mut parts.positions {
        *position = turn(*position);
    }
    parts.normals = None;
    parts.face_normals = true;
    parts
}

fn about_y(degrees: f64) -> impl Fn(DVec3) -> DVec3 {
    let (sin, cos) = (degrees / 360.0 * TAU).sin_cos();
    move |p| DVec3::new(cos * p.x + sin * p.z, p.y, cos * p.z - sin * p.x)
}

fn solids() -> [(&'static str, Solid); 3] {
    let upright = |p: DVec3| DVec3::new(p.x, -p.z, p.y);
    let prism = turned(equilateral_prism(0.1, 0.2), |p| {
        about_y(18.590378)(upright(p)) + DVec3::Z * 0.15
    });
    let diamond = turned(round_brilliant(0.325, BrilliantCut::TOLKOWSKY), |p| {
        about_y(165.0)(p) + DVec3::Z * 0.4
    });
    [
        ("cube", solid("cube", 1.5, 2.0, None)),
        ("prism", solid("prism", 1.5, 0.25, Some(prism))),
        ("diamond", solid("diamond", 2.418, 1.2, Some(diamond))),
    ]
}

/// Each texel's error and the mean over the lit ones, and all uncertain flux of what set out, of one path.
fn compare(solid: &Solid, path: KnownPath, deepest: u32) -> (f64, f64, f64) {
    let scene = &solid.scene;
    let is_meter = |kind: &SensorKind| matches!(kind, SensorKind::IrradianceMeter { .. });
    let sensor = scene.sensors().iter().find(|s| is_meter(&s.kind)).unwrap();
    let receiver = Receiver::new(scene, sensor).unwrap();
    let source = Source::all(scene)[0];
    let Source::Parallel {
        direction,
        irradiance,
        ..
    } = source
    else {
        panic!("the sun is not parallel light");
    };
    let light = ParallelLight {
        direction,
        irradiance: irradiance.0[0],
    };
    let truth = FlatFacets::new(&solid.parts, solid.ior, light, deepest)
        .unwrap()
        .map(path, &TexelGrid::square(solid.half_width, SIDE as usize));
    let texel_area = receiver.texel_area(0);
    let total = truth.iter().sum::<f64>() * texel_area;
    let lit = truth.iter().filter(|&&value| value > 0.0).count().max(1);
    let mean = total / texel_area / lit as f64;
    let progress = Progress::default();
    let mut setup = Setup::new(scene, sensor, BeamSettings::default(), &progress).unwrap();
    let signature: Signature = path.signature().parse().unwrap();
    setup.only(signature);
    let (estimate, report) = setup.run(&Budget::default()).unwrap();
    let layer = estimate
        .layers
        .iter()
        .find(|layer| layer.name == LayerName::Path(signature));
    let worst = truth
        .iter()
        .enumerate()
        .fold(0.0_f64, |worst, (texel, truth)| {
            let found = layer.map_or(0.0, |layer| layer.values[texel].0[0]);
            worst.max((found - truth).abs())
        });
    let uncertain: f64 = report
        .signatures
        .iter()
        .map(|one| one.uncertain.mean())
        .sum();
    let emitted = report.signatures.iter().map(|one| one.emitted);
    (
        worst,
        mean,
        uncertain / emitted.fold(f64::MIN_POSITIVE, f64::max),
    )
}

#[test]
fn every_texel_of_cube_prism_and_diamond_is_that_of_the_closed_form_to_rounding() {
    const DEEPEST: u32 = 6;
    for (name, solid) in solids() {
        let through = (0..=DEEPEST).map(KnownPath::Through);
        for path in [KnownPath::Reflected(1)].into_iter().chain(through) {
            let (worst, mean, uncertain) = compare(&solid, path, DEEPEST);
            // An edge of a polygon that is off by 2⁻⁵⁰ of the scene's size, about a hundred texels,
            // moves as much of a texel's light; up to 8 legs stretch that by 10 each at most
            // where they graze, but then their light is weak. 1e-9 of the mean leaves a margin.
            assert!(worst <= 1e-9 * mean, "{name} {path:?}: {worst} of {mean}");
            // Slivers along edges: of which facet they are is not known, and that is said. Each is as wide as
            // `Edge::rounding`, 512 · 2⁻⁵² of the solid, along up to three edges of a part, on up to eight
            // legs.
            let slivers = 8.0 * 3.0 * 512.0 * f64::EPSILON;
            assert!(uncertain <= slivers, "{name} {path:?}: {uncertain}");
        }
    }
}

#[test]
fn coplanar_faces_make_one_facet() {
    // The floor is one more.
    let counts = solids().map(|(name, solid)| (name, Facets::new(&solid.scene).len()));
    // A brilliant has 57 facets; its girdle is 16 kites' quadrilaterals.
    assert_eq!(counts[0], ("cube", 7));
    assert_eq!(counts[1], ("prism", 6));
    assert_eq!(counts[2], ("diamond", 1 + 57 + 16));
}

/// A lamp below a pane of glass, between two mirrors: the pane reflects light near the axis in part,
/// and all light that is oblique. Mirrors reflect all of both.
#[test]
fn light_on_a_long_chain_remembers_its_first_event() {
    let wide = |height: f64, turn: &str| {
        format!(
            r#"<transform name="to_world"><scale value="10"/>{turn}
            <translate x="0" y="0" z="{height}"/></transform>"#
        )
    };
    let mirror = r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#;
    let things = format!(
        r#"<emitter type="point"><point name="position" x="0" y="0" z="2"/></emitter>
        <shape type="rectangle"><ref id="glass"/>{}</shape>
        <shape type="rectangle">{mirror}{}</shape>
        <shape type="rectangle">{mirror}{}</shape>"#,
        wide(3.0, ""),
        wide(1.0, ""),
        wide(2.5, r#"<rotate x="1" angle="180"/>"#)
    );
    let folder = tempfile::TempDir::new().unwrap();
    let scene = over_floor(folder.path(), &things, 4);
    let (source, facets) = (Source::all(&scene)[0], Facets::new(&scene));
    let paths = FacetPaths {
        scene: &scene,
        source: &source,
        facets: &facets,
        shading_normals: ShadingNormals::Flux,
    };
    let facet = |shape| facets.of(shape, 0).unwrap();
    let mut met = std::iter::once(facet(0)).chain([facet(1), facet(2)].into_iter().cycle());
    let mut chain = FacetChain::to(facet(0));
    for events in 1..=MAX_EVENTS {
        chain.push(met.next().unwrap(), Event::Reflection);
        // At 0.2, 0.4, 2 and 4 from the axis and 1 above the lamp; total reflection begins at 0.89.
        let [near, also_near, oblique, also_oblique] = [0.51, 0.52, 0.6, 0.7].map(|u| {
            let light: FacetLight<1> = paths.follow(&chain, DVec2::new(u, 0.5));
            assert!(light.is_on_its_way());
            light
        });
        assert_ne!(near.state, oblique.state, "after {events} events");
        assert_ne!(near.topology(), oblique.topology(), "after {events} events");
        assert_eq!(near.state, also_near.state, "after {events} events");
        assert_eq!(oblique.state, also_oblique.state, "after {events} events");
    }
}

/// Two nets of triangles with sides s have crossings as their edges do: 2/π times the product of both lengths
/// an area, (3.46/s)² 2/π. On a triangle of 0.433 s² these are 3.3, so the nets make 1 + 1 + 3.3 pieces a
/// triangle. The inner side of a facetted ball is such a net to the light of the outer side.
#[test]
fn light_from_a_facet_is_divided_by_the_edges_of_those_that_it_meets_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.ply");
    let ball = geodesic_sphere(0.4, 24);
    let faces = ball.triangles.len() as f64;
    let mut bytes = Vec::new();
    write_ply(&ball, "a ball", &mut bytes).unwrap();
    std::fs::write(&file, bytes).unwrap();
    for light in [
        r#"<emitter type="directional"><vector name="direction" x="0.1" y="0.2" z="-1"/></emitter>"#,
        r#"<emitter type="point"><point name="position" x="0.2" y="0.1" z="3"/></emitter>"#,
    ] {
        let things = format!(
            r#"{light}<shape type="ply"><string name="filename" value="{}"/>
            <boolean name="face_normals" value="true"/>
            <transform name="to_world"><translate z="1"/></transform><ref id="glass"/></shape>"#,
            file.display()
        );
        let scene = over_floor(folder.path(), &things, 32);
        let (_, report) = beams_to(2, &scene, 1e-2);
        let cells = |name: &str| {
            let one = report.signatures.iter().find(|it| it.name == name);
            one.unwrap().cells as f64
        };
        // All light of a lit facet is mirrored as one.
        let (through, lit) = (cells("LTTD"), cells("LRD"));
        println!(
            "{} pieces of LTTD for each of {lit} lit facets",
            through / lit
        );
        // A lamp at some radii lights 0.4 of a ball.
        assert!(lit > 0.35 * faces && lit < 0.55 * faces, "{lit} of {faces}");
        // Near the outline facets are narrow to each other's light, and it is cut where it grazes them: a
        // quarter more.
        assert!(
            (5.3 * 0.8..5.3 * 1.25).contains(&(through / lit)),
            "{through} of {lit}"
        );
    }
}

/// Height above the floor, and size, of a block with a slit.
const BLOCK: [f64; 2] = [0.1, 0.5];

/// Length of the block along y, in its units: light that enters by one end does not get to the other.
const LENGTH: f64 = 1.2;

/// A glass block. A slit goes up into it from below, aslant: it hides a part of the lower
/// side from light from above, and the wall that hides it mirrors all of that light. Places are (x, z).
const OUTLINE: [[f64; 2]; 7] = [
    [-1.0, 0.0],
    [-0.05, 0.0],
    [-0.3, 0.6],
    [0.0464, 0.0],
    [0.35, 0.0],
    [0.35, 1.0],
    [-1.0, 1.0],
];

fn block_with_a_slit() -> MeshParts {
    let [height, size] = BLOCK;
    let along = |y: f64| OUTLINE.map(|[x, z]| DVec3::new(x, y, z) * size + DVec3::Z * height);
    let ends = [[0, 1, 2], [0, 2, 6], [2, 5, 6], [2, 3, 5], [3, 4, 5]];
    let count = OUTLINE.len() as u32;
    let other_end = ends.map(|[a, b, c]| [a + count, c + count, b + count]);
    let sides = (0..count).flat_map(|corner| {
        let next = (corner + 1) % count;
        [
            [corner, corner + count, next + count],
            [corner, next + count, next],
        ]
    });
    MeshParts {
        positions: along(-0.5 * LENGTH)
            .into_iter()
            .chain(along(0.5 * LENGTH))
            .collect(),
        triangles: ends.into_iter().chain(other_end).chain(sides).collect(),
        face_normals: true,
        ..MeshParts::default()
    }
}

/// Facets that hide others share more than all light of a polygon with them, or less than all with those that
/// are seen.
#[test]
fn facets_that_hide_others_take_their_light_once() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("block.ply");
    let mut bytes = Vec::new();
    write_ply(&block_with_a_slit(), "a block with a slit", &mut bytes).unwrap();
    std::fs::write(&file, bytes).unwrap();
    let [x, y] = [0.05, 0.1];
    let things = format!(
        r#"<emitter type="directional"><vector name="direction" x="{x}" y="{y}" z="-1"/>
        <rgb name="irradiance" value="1"/></emitter>
        <shape type="ply"><string name="filename" value="{}"/>
        <boolean name="face_normals" value="true"/><ref id="glass"/></shape>"#,
        file.display()
    );
    let scene = over_floor(folder.path(), &things, 64);
    let (estimate, _) = beams_to(3, &scene, 1e-3);
    let photons = Photons::new(1 << 18).estimate(&scene);
    let flux = |estimate: &Estimate, name: &str| {
        let signature: Signature = name.parse().unwrap();
        estimate.ledger.rows[&signature].received.mean()
    };

    // Of a slab: what the sun sends to the parts of the lower side that neither the slit nor an end hides.
    let tilt = f64::hypot(x, y);
    let (cos, sin) = (1.0 / f64::hypot(1.0, tilt), tilt / f64::hypot(1.0, tilt));
    let cos_within = (1.0 - (sin / 1.5) * (sin / 1.5)).sqrt();
    let slope = sin / 1.5 / cos_within / tilt;
    let across = (cos - 1.5 * cos_within) / (cos + 1.5 * cos_within);
    let along = (1.5 * cos - cos_within) / (1.5 * cos + cos_within);
    let passed = 1.0 - 0.5 * (across * across + along * along);
    let [tip, mouth, right] = [2, 3, 4].map(|corner: usize| OUTLINE[corner]);
    let beside_the_slit =
        (tip[0] + x * slope * tip[1]) - (OUTLINE[0][0] + x * slope) + (right[0] - mouth[0]);
    let expected =
        cos * passed * passed * beside_the_slit * (LENGTH - y * slope) * BLOCK[1] * BLOCK[1];
    // Light gets into the slit by its end, too, and through its lower wall: no more than falls on that end.
    let opening = 0.5 * (mouth[0] - OUTLINE[1][0]) * tip[1] * BLOCK[1] * BLOCK[1];
    let most = expected + opening * y * cos;
    let found = flux(&estimate, "LTTD");
    // Light that enters by the outer sides is mirrored by the lower one, and too steep to get to the other side.
    // A file's places are rounded to 2⁻²⁴ of themselves: a dozen of them, in lengths of a third and more.
    assert!(
        (expected * (1.0 - 3e-6)..most).contains(&found),
        "{found} is not in {expected}..{most}"
    );

    // Of photons, 2¹⁸ fall on the block and its surroundings, and a tenth of them goes this way: 0.6 %, and five
    // of these.
    let (found, expected) = (flux(&estimate, "LTRTD"), flux(&photons, "LTRTD"));
    assert!(
        (found / expected - 1.0).abs() < 0.03,
        "{found} is not {expected}"
    );
}
