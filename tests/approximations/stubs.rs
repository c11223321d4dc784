//! The interface of techniques carries the three that are to come: a stub of each uses the parts that it will need.
//!
//! A stub has no physics. It shows that stages, passes, preparations, sets of light and view rays fit the interface.

use std::fs;
use std::path::PathBuf;

use nephroid::internals::approximation::{
    DepthMap, ExactFilm, Extent, Frame, LightView, Precision, Prepared, Receivers, SensorFilm,
    Stage, TECHNIQUES, Technique, sources,
};
use nephroid::internals::geometry::TraversalCounters;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::{
    Context, Cost, Counter, Counters, Error, Light, Refusal, StageWork,
};
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::setting::{Kind, Preset, Setting, Values, words_of};
use nephroid::internals::transport::signature::{Event, Signature};

use crate::support::approximation::bundled;

const fn whole(key: &'static str, default: &'static str) -> Setting {
    Setting {
        key,
        kind: Kind::Whole(1, 4096),
        default: Preset::Value(default),
        unit: "",
        meaning: "A number of the stub",
    }
}

const PRECISION: Setting = Setting {
    key: "buffers",
    kind: Kind::Choice(words_of::<Precision>),
    default: Preset::Value("f32"),
    unit: "",
    meaning: "Stage: format of pictures",
};

const BUFFERS: &[Stage] = &[Stage {
    name: "buffers",
    exact: "exact",
}];

/// Barczak and Olano: single refraction (`LTD`), points with their view rays, exact sums, draws counted by pass.
struct LightVolume;

struct LightVolumeFrame {
    slices: u32,
}

impl Technique for LightVolume {
    fn name(&self) -> &'static str {
        "stub-light-volume"
    }
    fn meaning(&self) -> &'static str {
        "Hierarchical light volumes"
    }
    fn unit(&self) -> &'static str {
        "beams"
    }
    fn settings(&self) -> &'static [Setting] {
        const TABLE: &[Setting] = &[PRECISION, whole("slices", "4")];
        TABLE
    }
    fn stages(&self) -> &'static [Stage] {
        BUFFERS
    }
    fn sweep(&self) -> (&'static str, &'static [&'static str]) {
        ("slices", &["2", "4", "8"])
    }
    fn light(&self, _: &Scene, _: &Values) -> Result<Light, Refusal> {
        Ok(Light::Path(Signature::DIRECT.then(Event::Transmission)))
    }
    fn supports(&self, scene: &Scene, sensor: &Sensor, _: &Values) -> Result<(), Refusal> {
        SensorFilm::new(scene, sensor)?;
        sources::sources(scene, "light volumes").map(drop)
    }
    fn cost(&self, _: &Scene, _: &Sensor, values: &Values) -> Cost {
        let slices = values.whole("slices").unwrap_or(0);
        Cost {
            bytes: 1 << 20,
            work: vec![Counter::new("slices", slices)],
        }
    }
    fn prepare(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        values: &Values,
        _: &Context,
    ) -> Result<Box<dyn Prepared>, Error> {
        self.supports(scene, sensor, values)?;
        let slices = values.whole("slices").unwrap_or(1);
        Ok(Box::new(LightVolumeFrame { slices }))
    }
}

impl Prepared for LightVolumeFrame {
    fn work(&self) -> &[StageWork] {
        &[]
    }
    fn frame(&mut self, scene: &Scene, sensor: &Sensor, _: &Context) -> Result<Frame, Error> {
        let film = SensorFilm::new(scene, sensor)?;
        let [width, height] = film.size();
        // Camera-side techniques see points with albedo and view ray, in batches.
        let mut rays = TraversalCounters::default();
        let found = film.points(scene, 0..width * height, 1, &mut rays);
        let seen = found.points.iter().filter(|point| point.view.is_some());
        let exact = ExactFilm::new(film.size(), 1.0)?;
        for point in &found.points {
            let place = [point.texel % width, point.texel / width];
            exact.deposit(place, point.measured(Rgb::grey(0.5)));
        }
        let passes = (0..self.slices).map(|slice| StageWork {
            pass: format!("slice {}", slice + 1),
            work: Counters::of([("draws", 1), ("points", found.points.len() as u64)]),
            ..StageWork::new("buffers")
        });
        Ok(Frame {
            values: exact.finish()?,
            work: passes.collect(),
            counters: Counters::of([("rays", rays.rays), ("seen", seen.count() as u64)]),
            flux: Vec::new(),
            warnings: vec!["nothing descends".to_owned()],
        })
    }
}

/// De Barro et al.: all specular chains, pictures from lights, and frames of an animation that keep what is unchanged.
struct CausticsVolume;

struct CausticsVolumeFrame {
    precision: Precision,
    /// Hash of the scene whose pictures are kept.
    kept: Option<String>,
    pictures: Vec<DepthMap>,
}

impl Technique for CausticsVolume {
    fn name(&self) -> &'static str {
        "stub-caustics-volume"
    }
    fn meaning(&self) -> &'static str {
        "Caustics volumes"
    }
    fn unit(&self) -> &'static str {
        "beams"
    }
    fn settings(&self) -> &'static [Setting] {
        const TABLE: &[Setting] = &[PRECISION, whole("slabs", "3")];
        TABLE
    }
    fn stages(&self) -> &'static [Stage] {
        BUFFERS
    }
    fn sweep(&self) -> (&'static str, &'static [&'static str]) {
        ("slabs", &["1", "2", "3"])
    }
    fn light(&self, _: &Scene, _: &Values) -> Result<Light, Refusal> {
        Ok(Light::Specular { max_depth: 16 })
    }
    fn supports(&self, scene: &Scene, sensor: &Sensor, _: &Values) -> Result<(), Refusal> {
        SensorFilm::new(scene, sensor)?;
        sources::sources(scene, "caustics volumes").map(drop)
    }
    fn cost(&self, _: &Scene, _: &Sensor, _: &Values) -> Cost {
        Cost::default()
    }
    fn prepare(
        &self,
        _: &Scene,
        _: &Sensor,
        values: &Values,
        _: &Context,
    ) -> Result<Box<dyn Prepared>, Error> {
        Ok(Box::new(CausticsVolumeFrame {
            precision: values.word("buffers").unwrap_or(Precision::F32),
            kept: None,
            pictures: Vec::new(),
        }))
    }
}

impl Prepared for CausticsVolumeFrame {
    fn work(&self) -> &[StageWork] {
        &[]
    }
    fn frame(&mut self, scene: &Scene, sensor: &Sensor, _: &Context) -> Result<Frame, Error> {
        let mut work = StageWork {
            pass: "slab 1".to_owned(),
            ..StageWork::new("buffers")
        };
        if self.kept.as_deref() != Some(scene.content_hash()) {
            let receivers = Receivers::new(scene);
            let things: Vec<_> = scene.world().shapes().iter().map(Extent::of).collect();
            self.pictures.clear();
            for source in sources::sources(scene, "caustics volumes")? {
                for view in LightView::around(&source, &things, 8) {
                    let (picture, rays) = DepthMap::new(&receivers, view, self.precision);
                    work.work.add("texels", picture.bytes() / 4);
                    work.work.add("rays", rays.rays);
                    self.pictures.push(picture);
                }
            }
            self.kept = Some(scene.content_hash().to_owned());
        }
        let film = SensorFilm::new(scene, sensor)?;
        let (values, fetches, _) = film.evaluate(scene, 1, |point, fetches: &mut u64| {
            *fetches += 1;
            Rgb::grey(point.normal.z.abs())
        });
        work.work.add("fetches", fetches);
        Ok(Frame {
            values,
            counters: work.work.clone(),
            work: vec![work],
            flux: Vec::new(),
            warnings: Vec::new(),
        })
    }
}

/// Wyman, Hansen and Shirley: tables that are prepared once, kept in files, and read by every frame.
struct LocalIrradiance;

struct LocalIrradianceFrame {
    table: Vec<f64>,
    work: Vec<StageWork>,
}

impl Technique for LocalIrradiance {
    fn name(&self) -> &'static str {
        "stub-local-irradiance"
    }
    fn meaning(&self) -> &'static str {
        "Local precomputed irradiance"
    }
    fn unit(&self) -> &'static str {
        "beams"
    }
    fn settings(&self) -> &'static [Setting] {
        const TABLE: &[Setting] = &[PRECISION, whole("cells", "64")];
        TABLE
    }
    fn stages(&self) -> &'static [Stage] {
        BUFFERS
    }
    fn sweep(&self) -> (&'static str, &'static [&'static str]) {
        ("cells", &["16", "32", "64"])
    }
    fn light(&self, _: &Scene, _: &Values) -> Result<Light, Refusal> {
        Ok(Light::Specular { max_depth: 16 })
    }
    fn supports(&self, scene: &Scene, sensor: &Sensor, _: &Values) -> Result<(), Refusal> {
        SensorFilm::new(scene, sensor).map(drop)
    }
    fn cost(&self, _: &Scene, _: &Sensor, values: &Values) -> Cost {
        let cells = values.whole::<u64>("cells").unwrap_or(0).pow(3);
        Cost {
            bytes: 8 * cells,
            work: vec![Counter::new("cells", cells)],
        }
    }
    fn prepare(
        &self,
        scene: &Scene,
        _: &Sensor,
        values: &Values,
        context: &Context,
    ) -> Result<Box<dyn Prepared>, Error> {
        let cells = values.whole::<usize>("cells").unwrap_or(1);
        let file: Option<PathBuf> = context
            .cache
            .as_ref()
            .map(|folder| folder.join(format!("{}-{cells}.table", scene.content_hash())));
        let read = file.as_ref().and_then(|file| fs::read_to_string(file).ok());
        let read = read.and_then(|text| text.lines().map(|line| line.parse().ok()).collect());
        let mut work = StageWork::new("buffers");
        let table: Vec<f64> = read.unwrap_or_else(|| {
            work.work.add("photons", 1 << 10);
            vec![0.25; cells]
        });
        if let Some(file) = &file {
            let lines: Vec<String> = table.iter().map(f64::to_string).collect();
            fs::write(file, lines.join("\n")).map_err(|error| Refusal::new(error.to_string()))?;
        }
        Ok(Box::new(LocalIrradianceFrame {
            table,
            work: vec![work],
        }))
    }
}

impl Prepared for LocalIrradianceFrame {
    fn work(&self) -> &[StageWork] {
        &self.work
    }
    fn frame(&mut self, scene: &Scene, sensor: &Sensor, _: &Context) -> Result<Frame, Error> {
        let film = SensorFilm::new(scene, sensor)?;
        let [width, height] = film.size();
        Ok(Frame {
            values: vec![Rgb::grey(self.table[0]); width * height],
            counters: Counters::of([("fetches", (width * height) as u64)]),
            ..Frame::default()
        })
    }
}

fn values(technique: &dyn Technique, given: &[(&str, &str)]) -> Values {
    let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
    let given = given.iter().map(owned).collect();
    Values::new(
        technique.name(),
        technique.settings().iter().collect(),
        &given,
    )
    .unwrap()
}

#[test]
fn a_technique_of_one_signature_sees_points_with_view_rays_and_counts_its_passes() {
    let scene = bundled("glass-ball", 8);
    let sensor = &scene.sensors()[0];
    let values = values(&LightVolume, &[("slices", "3")]);
    let context = Context::default();
    let mut prepared = LightVolume
        .prepare(&scene, sensor, &values, &context)
        .unwrap();
    let frame = prepared.frame(&scene, sensor, &context).unwrap();
    let passes: Vec<&str> = frame.work.iter().map(|one| one.pass.as_str()).collect();
    assert_eq!(passes, ["slice 1", "slice 2", "slice 3"]);
    assert!(frame.values.iter().all(|value| *value == Rgb::grey(0.5)));
    assert_eq!(LightVolume.cost(&scene, sensor, &values).work[0].count, 3);
}

#[test]
fn a_technique_of_all_chains_keeps_its_pictures_from_frame_to_frame() {
    let (scene, moved) = (bundled("glass-ball", 8), bundled("glass-ball", 16));
    let context = Context::default();
    let values = values(&CausticsVolume, &[]);
    let light = CausticsVolume.light(&scene, &values).unwrap();
    assert!(light.includes("LTRTD".parse().unwrap()) && !light.includes(Signature::DIRECT));
    let mut prepared = CausticsVolume
        .prepare(&scene, &scene.sensors()[0], &values, &context)
        .unwrap();
    let mut texels = |scene: &Scene| {
        let frame = prepared
            .frame(scene, &scene.sensors()[0], &context)
            .unwrap();
        frame.counters.get("texels")
    };
    assert!(texels(&scene) > 0);
    assert_eq!(texels(&scene), 0, "nothing has changed");
    assert!(texels(&moved) > 0, "another scene");
}

#[test]
fn a_technique_with_tables_prepares_them_once_and_tells_their_cost_apart() {
    let folder = tempfile::tempdir().unwrap();
    let context = Context {
        cache: Some(folder.path().to_owned()),
        ..Context::default()
    };
    let scene = bundled("glass-ball", 8);
    let sensor = &scene.sensors()[0];
    let values = values(&LocalIrradiance, &[("cells", "16")]);
    let photons = || {
        let mut prepared = LocalIrradiance
            .prepare(&scene, sensor, &values, &context)
            .unwrap();
        let frame = prepared.frame(&scene, sensor, &context).unwrap();
        assert_eq!(frame.counters.get("photons"), 0, "a frame traces none");
        prepared.work()[0].work.get("photons")
    };
    assert_eq!(photons(), 1 << 10);
    assert_eq!(photons(), 0, "the table is read");
}

#[test]
fn techniques_are_found_by_their_names_and_share_no_setting_rows_by_accident() {
    for technique in TECHNIQUES {
        let keys: Vec<&str> = technique.settings().iter().map(|row| row.key).collect();
        for (index, key) in keys.iter().enumerate() {
            assert!(!keys[..index].contains(key), "{}: {key}", technique.name());
        }
        for stage in technique.stages() {
            let row = technique
                .settings()
                .iter()
                .find(|row| row.key == stage.name);
            let row = row.unwrap_or_else(|| panic!("{} has no setting", stage.name));
            assert!(row.kind.holds(stage.exact), "{}", stage.name);
        }
    }
}
