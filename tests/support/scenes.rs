//! Scenes at any resolution, and photon runs of them.

use std::fs;
use std::path::{Path, PathBuf};

use nephroid::internals::generate::{bumpy_ball, geodesic_sphere, write_ply};
use nephroid::internals::geometry::MeshParts;
use nephroid::internals::mitsuba;
use nephroid::internals::numeric::StreamKind;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::run::Budget;
use nephroid::internals::run::Progress;
use nephroid::internals::run::{Estimate, LayerName};
use nephroid::internals::scene::{Crop, Scene, SensorKind};

/// The file of a bundled scene.
pub fn bundled_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(format!("{name}.xml"))
}

/// A bundled scene whose irradiance meters have `side` x `side` texels.
pub fn bundled(name: &str, side: usize) -> Scene {
    loaded(&bundled_file(name), side)
}

/// Things over a receiver of `side` x `side` texels, the square of half width 1 in the plane z = 0; `<ref
/// id="glass"/>` is glass of index 1.5. Meshes are looked for in the folder, where the scene's file is
/// written.
pub fn over_floor(folder: &Path, things: &str, side: usize) -> Scene {
    let xml = format!(
        r#"<scene version="3.0.0">
  <bsdf type="dielectric" id="glass"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
  {things}
  <shape type="rectangle" id="floor">
    <bsdf type="diffuse"/>
    <sensor type="irradiancemeter" id="meter">
      <film type="hdrfilm">
        <integer name="width" value="{side}"/><integer name="height" value="{side}"/>
        <rfilter type="box"/>
      </film>
    </sensor>
  </shape>
</scene>"#
    );
    let file = folder.join("scene.xml");
    std::fs::write(&file, xml).unwrap();
    Scene::new(mitsuba::load_parts(&file, &[]).unwrap()).unwrap()
}

/// A scene file's scene whose irradiance meters have `side` x `side` texels.
pub fn loaded(file: &Path, side: usize) -> Scene {
    let mut parts = mitsuba::load_parts(file, &[]).unwrap();
    let side = u32::try_from(side).unwrap();
    for sensor in &mut parts.sensors {
        (sensor.film.width, sensor.film.height) = (side, side);
        sensor.film.crop = Crop {
            offset_x: 0,
            offset_y: 0,
            width: side,
            height: side,
        };
    }
    Scene::new(parts).unwrap()
}

/// The area [m²] that a scene's only irradiance meter measures.
pub fn sensor_area(scene: &Scene) -> f64 {
    let SensorKind::IrradianceMeter { shape } = meter(scene).kind else {
        unreachable!("a meter was asked for")
    };
    scene.world().shapes()[shape.0 as usize].area()
}

/// The scene's first irradiance meter.
pub fn meter(scene: &Scene) -> &nephroid::internals::scene::Sensor {
    scene
        .sensors()
        .iter()
        .find(|sensor| matches!(sensor.kind, SensorKind::IrradianceMeter { .. }))
        .unwrap()
}

/// A photon run to be made.
#[derive(Clone, Copy, Debug)]
pub struct Photons {
    /// Settings of the run.
    pub settings: PhotonSettings,
    /// Number of photons, all replicates together.
    pub count: u64,
}

impl Photons {
    /// With default settings.
    pub fn new(count: u64) -> Self {
        Self {
            settings: PhotonSettings::default(),
            count,
        }
    }

    /// With this many replicates.
    pub fn replicates(mut self, replicates: u32) -> Self {
        self.settings.replicates = replicates;
        self
    }

    /// With this kind of sample points.
    pub fn stream(mut self, stream: StreamKind) -> Self {
        self.settings.stream = stream;
        self
    }

    /// With this seed.
    pub fn seed(mut self, seed: u64) -> Self {
        self.settings.seed = seed;
        self
    }

    /// Measures the caustic on a scene's only irradiance meter.
    pub fn estimate(&self, scene: &Scene) -> Estimate {
        let progress = Progress::default();
        let budget = Budget {
            work: Some(self.count),
            ..Budget::default()
        };
        Setup::new(scene, meter(scene), self.settings, &progress)
            .and_then(|setup| setup.run(&budget))
            .unwrap()
    }
}

/// One channel of one layer: irradiance and standard error [W/m²] by texel. A signature that
/// no layer has was not found by the run: dark.
pub fn layer(estimate: &Estimate, name: &str, channel: usize) -> (Vec<f64>, Vec<f64>) {
    let wanted = LayerName::Path(name.parse().unwrap());
    estimate
        .layers
        .iter()
        .find(|layer| layer.name == wanted)
        .map_or_else(
            || {
                let texels = estimate.width * estimate.height;
                (vec![0.0; texels], vec![0.0; texels])
            },
            |layer| {
                let pick = |values: &[nephroid::internals::radiometry::Rgb]| {
                    values.iter().map(|value| value.0[channel]).collect()
                };
                (pick(&layer.values), pick(&layer.standard_error))
            },
        )
}

/// The scene `glass-ball-mesh` with 20 · `frequency`² triangles of a bumpy ball, with interpolated normals or flat,
/// below a lamp at a place.
///
/// # Panics
///
/// If the bundled file has no lamp where it is to be moved from.
pub fn below_bumps(frequency: u32, is_smooth: bool, lamp: [f64; 3], side: usize) -> Scene {
    below_mesh(bumpy_ball(1.0, frequency), is_smooth, lamp, side)
}

/// The same of a ball without bumps, with interpolated normals.
pub fn below_even_ball(frequency: u32, lamp: [f64; 3], side: usize) -> Scene {
    below_mesh(geodesic_sphere(1.0, frequency), true, lamp, side)
}

pub fn below_mesh(mut mesh: MeshParts, is_smooth: bool, [x, y, z]: [f64; 3], side: usize) -> Scene {
    let mut xml = fs::read_to_string(bundled_file("glass-ball-mesh")).unwrap();
    let lamp = r#"<point name="position" x="0" y="0" z="4"/>"#;
    assert!(xml.contains(lamp), "the lamp can be moved");
    let moved = format!(r#"<point name="position" x="{x}" y="{y}" z="{z}"/>"#);
    xml = xml.replace(lamp, &moved);
    if !is_smooth {
        mesh.normals = None;
        let file = r#"<string name="filename" value="glass-ball-mesh.ply"/>"#;
        let flat = r#"<boolean name="face_normals" value="true"/>"#;
        xml = xml.replace(file, &format!("{file}{flat}"));
    }
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = Vec::new();
    write_ply(&mesh, "a ball", &mut bytes).unwrap();
    fs::write(folder.path().join("glass-ball-mesh.ply"), bytes).unwrap();
    let file = folder.path().join("bumpy.xml");
    fs::write(&file, xml).unwrap();
    loaded(&file, side)
}

/// Two dozen small balls of glass at random places over a floor, in the light of a lamp above.
pub fn below_balls(side: usize) -> Scene {
    use std::fmt::Write as _;
    let mut xml = String::from(
        r#"<emitter type="point"><point name="position" x="0" y="0" z="2.5"/><rgb name="intensity" value="25"/></emitter>"#,
    );
    for place in [
        [-0.548000, 0.521000, 0.608000],
        [-0.367000, -0.006500, 0.419500],
        [0.227000, 0.433000, 0.206000],
        [-0.707000, 0.503500, 0.409500],
        [0.393000, -0.746500, 0.417000],
        [0.332000, -0.406500, 0.717000],
        [0.602000, -0.704000, 0.165000],
        [0.062000, 0.658500, 0.378500],
        [-0.425000, -0.116500, 0.167000],
        [-0.400000, -0.403500, 0.281000],
        [-0.060500, -0.315000, 0.162500],
        [0.506000, 0.084500, 0.535000],
        [-0.471000, 0.738500, 0.665500],
        [-0.568500, -0.250500, 0.582500],
        [0.316500, 0.654500, 0.403000],
        [0.495000, 0.255000, 0.332000],
        [0.131000, 0.573500, 0.657500],
        [0.007500, 0.133500, 0.170500],
        [-0.385500, 0.446000, 0.398500],
        [0.261500, -0.187500, 0.413000],
        [0.012500, 0.417500, 0.462500],
        [-0.684500, 0.305000, 0.739500],
        [-0.061000, -0.346000, 0.478500],
        [0.685500, -0.741000, 0.620000],
    ] {
        let [x, y, z] = place;
        write!(
            xml,
            r#"<shape type="sphere"><point name="center" x="{x}" y="{y}" z="{z}"/><float name="radius" value="0.1"/><ref id="glass"/></shape>"#
        )
        .unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    over_floor(folder.path(), &xml, side)
}
