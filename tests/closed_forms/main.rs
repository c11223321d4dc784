//! Temporary measurements.
use nephroid::reference::closed_form::*;
use nephroid::scene::{Crop, Scene, SensorKind};
use std::time::Instant;
fn bundled(name: &str, side: u32) -> Scene {
    let f = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.xml"));
    let mut parts = nephroid::mitsuba::load_parts(&f, &[]).unwrap();
    for sensor in &mut parts.sensors {
        (sensor.film.width, sensor.film.height) = (side, side);
        sensor.film.crop = Crop { offset_x: 0, offset_y: 0, width: side, height: side };
    }
    Scene::new(parts).unwrap()
}
#[test]
fn measure() {
    for name in ["glass-ball","coffee-cup","mirror-ring","prism","cube","diamond","lens","water","parabolic-mirror","glass-ball-mesh","glass-ball-behind-pane","cornell-glass"] {
        let scene = bundled(name, 32);
        let meter = scene.sensors().iter().find(|s| matches!(s.kind, SensorKind::IrradianceMeter{..})).unwrap();
        let cam = scene.sensors().iter().find(|s| !matches!(s.kind, SensorKind::IrradianceMeter{..})).unwrap();
        println!("{name}: {:?} cam {:?}", supports(&scene, meter).map_err(|e| e.to_string()), supports(&scene, cam).map_err(|e| e.to_string()));
        if supports(&scene, meter).is_ok() {
            for depth in [2u32, 4, 6, 8, 10, 12, 14, 16] {
                if name != "diamond" && ![8, 16].contains(&depth) { continue; }
                let t = Instant::now();
                let e = solve(&scene, meter, ClosedFormSettings { max_depth: depth }).unwrap();
                println!("  depth {depth}: {} layers, rel {:?}, {:?}", e.layers.len(), e.relative_error, t.elapsed());
                if t.elapsed().as_secs() > 20 { break; }
            }
        }
    }
}
