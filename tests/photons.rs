//! The photon estimator, whole.
use glam::*;
use nephroid::geometry::*;
use nephroid::radiometry::Rgb;
use nephroid::reference::photons::*;
use nephroid::scene::*;

#[test]
fn try_it() {
    let at = |t: DVec3, s: f64| {
        Transform::from_matrix(DMat4::from_translation(t) * DMat4::from_scale(DVec3::splat(s)))
            .unwrap()
    };
    let obj = |m: u32, p: &'static str| Object {
        id: p.into(),
        plugin: p,
        declared_at: SourcePosition {
            file: "x".into(),
            line: 1,
            column: 1,
        },
        material: MaterialId(m),
    };
    let scene = Scene::new(SceneParts {
        shapes: vec![
            Shape::Rectangle(Rectangle::new(&at(DVec3::ZERO, 2.0), false).unwrap()),
            Shape::Sphere(Sphere::new(&at(DVec3::new(0.0, 0.0, 1.5), 1.0), false).unwrap()),
        ],
        objects: vec![obj(0, "rectangle"), obj(1, "sphere")],
        materials: vec![
            Material::Diffuse {
                reflectance: Rgb::grey(0.5),
            },
            Material::Dielectric {
                interior_ior: 1.5,
                exterior_ior: 1.0,
                specular_reflectance: Rgb::WHITE,
                specular_transmittance: Rgb::WHITE,
            },
        ],
        emitters: vec![Emitter::Point {
            position: DVec3::new(0.0, 0.0, 7.0),
            intensity: Rgb::grey(100.0),
        }],
        sensors: vec![Sensor {
            id: "floor".into(),
            kind: SensorKind::IrradianceMeter { shape: ShapeId(0) },
            film: Film {
                width: 512,
                height: 512,
                crop: Crop {
                    offset_x: 0,
                    offset_y: 0,
                    width: 512,
                    height: 512,
                },
                filter: ReconstructionFilter::Box,
            },
        }],
        ..Default::default()
    })
    .unwrap();
    for threads in [1] {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
            .install(|| {
                let p = Progress::default();
                let t0 = std::time::Instant::now();
                let setup = nephroid::reference::photons::run::Setup::new(
                    &scene,
                    &scene.sensors()[0],
                    PhotonSettings::default(),
                    &p,
                )
                .unwrap();
                println!(
                    "setup {:?} cells {} level {}",
                    t0.elapsed(),
                    setup.light().cells().len(),
                    setup.light().level()
                );
                let t0 = std::time::Instant::now();
                let d = setup.direct();
                println!("direct {:?}", t0.elapsed());
                let _ = d;
                let t0 = std::time::Instant::now();
                let e = setup.run(&Budget::default()).unwrap();
                let t = t0.elapsed();
                println!(
                    "{:?} {} M/s  rays {} err {:?} closure {:e}",
                    t,
                    e.paths as f64 / t.as_secs_f64() / 1e6,
                    e.counters.rays as f64 / e.paths as f64,
                    e.relative_error,
                    e.ledger.closure_error()
                );
                for l in &e.layers {
                    println!("{} {:?} {:?}", l.name, l.range(), l.relative_error());
                }
                println!("{:?}", e.ledger.sum());
            });
    }
}
