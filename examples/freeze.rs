//! Hashes of what the program renders and prints: proof that a change of its code changes no result.
//!
//! Run it before a change and after it, on one machine; both must print the same lines:
//!
//! ```text
//! cargo build --release
//! cargo run --release --example freeze -- target/release/nephroid > before.txt
//! (the change, and `cargo build --release` again)
//! cargo run --release --example freeze -- target/release/nephroid before.txt
//! ```
//!
//! The second run prints only lines that differ (`-` before, `+` now) and then ends with exit code 1.
//! `--keep DIR` writes each JSON result into `DIR`, so that `diff -r` shows where two runs part.
//! `--only TEXT` makes only results whose name contains `TEXT`.
//!
//! A line is `name hash`, or `name refused: message` for what the program does not do. A name alone,
//! like `glass-ball/beams`, stands for the bits of all channels of an EXR. `.../summary` stands for the
//! JSON that came with it, and `.../picture` for its PNG. Times, speeds and what tells
//! programs apart are left out. All runs together take about 80 s of CPU time.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of an example, no results"
)]
#![allow(missing_docs, reason = "an example is no library")]

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output};

use nephroid::internals::film::exr;
use serde_json::Value;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// The EXR that each run writes anew, in the work folder; `PICTURE` goes beside it.
const FILM: &str = "result.exr";

const PICTURE: &str = "result.png";

/// Keys of JSON that hold times, paths, or what differs from program to program.
const LEFT_OUT: [&str; 5] = ["seconds", "timing", "version", "commit", "scene"];

const PARITY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/mitsuba/parity");

/// Runs for the receiver of each scene: name, arguments.
const ON_RECEIVER: [(&str, &str); 3] = [
    ("beams", "--method beams --error 5%"),
    ("photons", "--method photons --photons 65536"),
    ("caustic-map", "--method caustic-map"),
];

/// Runs for the camera of each scene.
const ON_CAMERA: [(&str, &str); 5] = [
    ("path", "--method path --spp 16 --replicates 4"),
    (
        "photon-map",
        "--method photon-map --map-photons 2048 --photons 8192",
    ),
    (
        "full",
        "--method full --spp 4 --photons 8192 --map-photons 2048 --error 30%",
    ),
    ("camera-beams", "--method beams --error 10%"),
    ("camera-photons", "--method photons --photons 16384"),
];

/// Bounds on work where a scene would take long.
const BOUNDS: [(&str, &str, &str); 2] = [
    ("diamond", "beams", "--max-depth 4"),
    ("diamond", "full", "--max-depth 4"),
];

/// Settings that no result above has: scene, name, arguments.
const MORE: &[(&str, &str, &str)] = &[
    (
        "glass-ball",
        "beams-adjoint",
        "--method beams --error 5% --shading-normals adjoint --layers 2",
    ),
    (
        "glass-ball-mesh",
        "beams-adjoint",
        "--method beams --error 20% --shading-normals adjoint --max-depth 3",
    ),
    (
        "water",
        "photons-adjoint",
        "--method photons --photons 16384 --shading-normals adjoint",
    ),
    (
        "glass-ball",
        "photons-random",
        "--method photons --photons 16384 --samples random --seed 7",
    ),
    (
        "cube",
        "photons-split-0",
        "--method photons --photons 16384 --split-depth 0 --replicates 8",
    ),
    (
        "cornell-glass",
        "photons-error",
        "--method photons --error 30% --direct-samples 256 --replicates 8",
    ),
    (
        "glass-ball",
        "caustic-map-exact",
        "--method caustic-map --set splat=exact --set lookup=exact",
    ),
    (
        "water",
        "caustic-map-fixed",
        "--method caustic-map --set splat=fixed --set photons=128",
    ),
    (
        "water",
        "caustic-map-mip",
        "--method caustic-map --set splat=mip --set view=f16 --set photons=128",
    ),
    (
        "lens",
        "caustic-map-mip-splat",
        "--method caustic-map --set splat=mip-splat --set frames=2",
    ),
    (
        "lens",
        "caustic-map-multi-resolution",
        "--method caustic-map --set splat=multi-resolution",
    ),
    (
        "lens",
        "caustic-map-thick-lens",
        "--method caustic-map --set splat=thick-lens --set lookup=nearest",
    ),
    (
        "diamond",
        "caustic-map-two-curvatures",
        "--method caustic-map --set splat=two-curvatures --set flux=exact",
    ),
    (
        "glass-ball",
        "caustic-map-traced",
        "--method caustic-map --set refraction=exact --set hit=exact --set fresnel=exact",
    ),
    (
        "glass-ball",
        "caustic-map-object",
        "--method caustic-map --set frustum=object --set fresnel=schlick",
    ),
    (
        "coffee-cup",
        "caustic-map-reflection",
        "--method caustic-map --set mode=reflection",
    ),
    (
        "mirror-ring",
        "caustic-map-reflection",
        "--method caustic-map --set mode=reflection --set splat=exact",
    ),
    (
        "glass-ball",
        "caustic-map-reflection",
        "--method caustic-map --set mode=reflection --set hit=exact",
    ),
    (
        "water",
        "caustic-map-on-camera",
        "--method caustic-map --sensor camera",
    ),
    (
        "cornell-glass",
        "path-power",
        "--method path --spp 8 --replicates 4 --max-depth 5 --rr-depth 2",
    ),
    (
        "cornell-glass",
        "path-balance",
        "--method path --spp 8 --light-sampling balance --replicates 4",
    ),
    (
        "cornell-glass",
        "path-emitters",
        "--method path --spp 8 --light-sampling emitters --replicates 4",
    ),
    (
        "cornell-glass",
        "path-surfaces",
        "--method path --spp 8 --light-sampling surfaces --hide-emitters",
    ),
    (
        "cornell-glass",
        "path-without-caustics",
        "--method path --spp 8 --without-caustics --replicates 4",
    ),
    (
        "glass-ball-behind-pane",
        "photon-map-anyhow",
        "--method photon-map --map-photons 2048 --photons 8192 --sensor camera --seen anyhow",
    ),
    (
        "glass-ball-behind-pane",
        "photon-map-directly",
        "--method photon-map --map-photons 2048 --photons 8192 --sensor camera --seen directly --radius 2",
    ),
    (
        "cornell-lens",
        "path",
        "--method path --spp 8 --replicates 4",
    ),
    (
        "cornell-lens",
        "photon-map",
        "--method photon-map --map-photons 2048 --photons 8192 --sensor camera",
    ),
    (
        "cornell-lens",
        "full",
        "--method full --spp 4 --photons 8192 --map-photons 2048 --error 50%",
    ),
    (
        "cornell-parallel",
        "path",
        "--method path --spp 8 --replicates 4",
    ),
    (
        "cornell-parallel",
        "photons",
        "--method photons --photons 16384 --sensor camera",
    ),
    (
        "workshop-lit-by-a-spot",
        "beams",
        "--method beams --error 10%",
    ),
    (
        "workshop-lit-by-a-spot",
        "photons",
        "--method photons --photons 65536",
    ),
    (
        "workshop-lit-by-a-spot",
        "camera-photons",
        "--method photons --photons 16384 --sensor camera",
    ),
    ("workshop", "path", "--method path --spp 16 --replicates 4"),
    (
        "workshop",
        "path-adjoint",
        "--method path --spp 16 --replicates 4 --shading-normals adjoint --samples random",
    ),
    (
        "workshop",
        "full",
        "--method full --spp 4 --photons 8192 --map-photons 2048 --error 50%",
    ),
    (
        "workshop-lit-by-a-spot",
        "photon-map",
        "--method photon-map --map-photons 2048 --photons 8192 --sensor camera",
    ),
];

/// Points of receivers to probe: scene, coordinates, more arguments.
const PROBES: [(&str, &str, &str); 8] = [
    ("glass-ball", "0.57,0.52", "--max-depth 2"),
    ("glass-ball-behind-pane", "0.43,0.52", "--max-depth 4"),
    (
        "glass-ball-mesh",
        "0.57,0.52",
        "--max-depth 2 --shading-normals adjoint",
    ),
    ("coffee-cup", "0.6,0.4", "--max-depth 3"),
    ("mirror-ring", "0.45,0.52", "--max-depth 2 --refine 1"),
    ("cube", "0.3,0.6", "--max-depth 4"),
    ("water", "0.31,0.64", "--max-depth 2"),
    ("cornell-glass", "0.5,0.5", "--max-depth 2"),
];

/// Caustic maps whose stages are judged: scene, more arguments.
const ATTRIBUTIONS: [(&str, &str); 3] = [
    ("glass-ball", "--set photons=64 --set map=64"),
    ("lens", "--set photons=64 --set splat=two-curvatures"),
    ("mirror-ring", "--set mode=reflection --set photons=64"),
];

const STUDY: &str = r#"
scene = "glass-ball.xml"
define = { size = 16 }
sensors = ["floor", "camera"]
margin = "5%"
[truth.floor]
method = "beams"
error = "2%"
[truth.camera]
method = "photons"
photons = 65536
[[method]]
method = "beams"
error = "20%"
sensor = "floor"
[[method]]
method = "photons"
photons = { from = 4096, to = 16384, times = 4 }
[[method]]
method = "caustic-map"
sensor = "floor"
photons = 64
map = 64
[[method]]
method = "path"
spp = { from = 4, to = 16, times = 4 }
"#;

/// What photons and beams do not take: light from all round, and textures on what a camera sees.
const SURROUNDINGS: &str =
    "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"0.1, 0.15, 0.2\"/></emitter>";

const CHECKS: &str = r#"<texture type="checkerboard" name="reflectance"><rgb name="color0" value="0.2, 0.3, 0.4"/>
<rgb name="color1" value="0.8, 0.7, 0.6"/><transform name="to_uv"><scale x="8" y="8"/></transform></texture>"#;

/// A room of what the shipped scenes lack: rough and coated materials, textures, masks, spots, surroundings.
const WORKSHOP: &str = r#"<scene version="3.0.0">
<default name="size" value="24"/>
<emitter type="constant"><rgb name="radiance" value="0.1, 0.15, 0.2"/></emitter>
<emitter type="spot"><rgb name="intensity" value="20, 15, 10"/><float name="cutoff_angle" value="35"/>
<transform name="to_world"><lookat origin="1, -1, 3" target="0, 0, 0.5" up="0, 1, 0"/></transform></emitter>
<shape type="sphere"><point name="center" x="-0.9" y="0.2" z="0.5"/><float name="radius" value="0.5"/>
<bsdf type="roughconductor"><float name="alpha" value="0.2"/><rgb name="eta" value="0.2, 0.9, 1.1"/>
<rgb name="k" value="3.9, 2.4, 2.1"/></bsdf></shape>
<shape type="sphere"><point name="center" x="0.3" y="0" z="0.7"/><float name="radius" value="0.45"/>
<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf></shape>
<shape type="sphere"><point name="center" x="0.2" y="1.1" z="0.4"/><float name="radius" value="0.4"/>
<bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.1, 0.3, 0.5"/></bsdf></shape>
<shape type="sphere"><point name="center" x="1.2" y="0.5" z="0.35"/><float name="radius" value="0.35"/>
<bsdf type="roughdielectric"><float name="alpha" value="0.1"/></bsdf></shape>
<shape type="disk"><transform name="to_world"><scale value="0.4"/><rotate x="1" angle="30"/>
<translate x="0.2" y="-0.6" z="1.4"/></transform><bsdf type="mask"><float name="opacity" value="0.4"/>
<bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><scale value="2"/></transform><bsdf type="diffuse">
<texture type="checkerboard" name="reflectance"><rgb name="color0" value="0.2, 0.3, 0.4"/>
<rgb name="color1" value="0.8, 0.7, 0.6"/><transform name="to_uv"><scale x="8" y="8"/></transform></texture>
</bsdf><sensor type="irradiancemeter" id="floor"><film type="hdrfilm"><integer name="width" value="$size"/>
<integer name="height" value="$size"/><rfilter type="box"/></film></sensor></shape>
<sensor type="perspective" id="camera"><float name="fov" value="40"/><transform name="to_world">
<lookat origin="-1, -4, 2.5" target="0, 0, 0.4" up="0, 0, 1"/></transform><film type="hdrfilm">
<integer name="width" value="24"/><integer name="height" value="16"/><rfilter type="gaussian"/></film></sensor>
</scene>"#;

fn main() -> Outcome<ExitCode> {
    let mut words = Vec::new();
    let (mut keep, mut only) = (None, String::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(word) = arguments.next() {
        match word.as_str() {
            "--keep" => {
                keep = Some(PathBuf::from(
                    arguments.next().ok_or("--keep needs a folder")?,
                ))
            }
            "--only" => only = arguments.next().ok_or("--only needs a text")?,
            _ => words.push(word),
        }
    }
    let (program, before) = match words.as_slice() {
        [program] => (program, None),
        [program, before] => (program, Some(read_lines(Path::new(before))?)),
        _ => return Err("usage: freeze PROGRAM [BEFORE] [--keep DIR] [--only TEXT]".into()),
    };
    if let Some(folder) = &keep {
        fs::create_dir_all(folder)?;
    }
    let mut session = Session {
        program: fs::canonicalize(program)?,
        work: tempfile::tempdir()?,
        keep: keep.map(fs::canonicalize).transpose()?,
        is_quiet: before.is_some(),
        only,
        results: BTreeMap::new(),
    };
    session.run_all()?;
    Ok(match before {
        None => ExitCode::SUCCESS,
        Some(before) => session.compare(&before),
    })
}

/// Results by name, as an earlier run printed them.
fn read_lines(path: &Path) -> Outcome<BTreeMap<String, String>> {
    let text = fs::read_to_string(path)?;
    let pairs = text.lines().filter_map(|line| line.split_once(' '));
    Ok(pairs
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .collect())
}

/// One run of this tool.
struct Session {
    program: PathBuf,
    work: tempfile::TempDir,
    /// Folder for normalised JSON.
    keep: Option<PathBuf>,
    is_quiet: bool,
    only: String,
    results: BTreeMap<String, String>,
}

impl Session {
    fn run_all(&mut self) -> Outcome<()> {
        let scenes = self.write_scenes()?;
        for scene in &scenes {
            self.inspect(scene)?;
            for (name, arguments) in ON_RECEIVER.into_iter().chain(ON_CAMERA) {
                let bound = BOUNDS
                    .iter()
                    .find(|(at, what, _)| at == scene && *what == name);
                let sensor = match ON_CAMERA.iter().any(|(other, _)| *other == name) {
                    true => "--sensor camera",
                    false => "",
                };
                let bound = bound.map_or("", |(_, _, bound)| bound);
                self.render(scene, name, &format!("{arguments} {sensor} {bound}"))?;
            }
        }
        for (scene, name, arguments) in MORE {
            self.render(scene, name, arguments)?;
        }
        self.shards("glass-ball", "--method photons --photons 32768", "")?;
        self.shards(
            "cornell-glass",
            "--method photons --photons 32768",
            "--sensor camera",
        )?;
        for (scene, at, arguments) in PROBES {
            let name = format!("{scene}/probe {at}").replace(' ', "-");
            let words = format!("probe {scene}.xml --json --at {at} {arguments}");
            self.json(&name, &words)?;
        }
        for (scene, arguments) in ATTRIBUTIONS {
            let words = format!("attribute {scene}.xml --json -D size=16 --error 3% {arguments}");
            self.json(&format!("{scene}/attribute"), &words)?;
        }
        self.comparison()?;
        self.study()?;
        self.parity()
    }

    /// Writes the shipped scenes, and some more, into the work folder, and names them.
    ///
    /// Comments go, so that their text changes no hash; films become small.
    fn write_scenes(&mut self) -> Outcome<BTreeSet<String>> {
        let folder = self.work.path().to_owned();
        let made = self.program("generate -o .")?;
        if !made.status.success() {
            return Err(String::from_utf8_lossy(&made.stderr).into());
        }
        let mut shipped = BTreeSet::new();
        for entry in fs::read_dir(&folder)? {
            let path = entry?.path();
            let name = path
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            let file = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            let mut bytes = fs::read(&path)?;
            let is_scene = path.extension().is_some_and(|end| end == "xml");
            if is_scene {
                bytes = without_comments(&String::from_utf8(bytes)?).into_bytes();
            }
            self.result(&format!("generate/{file}"), hash(&bytes));
            if is_scene {
                let text = String::from_utf8(bytes)?;
                fs::write(&path, small(&text))?;
                shipped.insert(name);
            }
        }
        let room = fs::read_to_string(folder.join("cornell-glass.xml"))?;
        let lens = "type=\"thinlens\" id=\"camera\"><float name=\"aperture_radius\" value=\"0.05\"/>\
            <float name=\"focus_distance\" value=\"3\"/>";
        let pinhole = "type=\"perspective\" id=\"camera\">";
        fs::write(folder.join("cornell-lens.xml"), room.replace(pinhole, lens))?;
        let parallel = "type=\"orthographic\" id=\"camera\">";
        let room = room.replace("<float name=\"fov\" value=\"42\"/>", "");
        fs::write(
            folder.join("cornell-parallel.xml"),
            room.replace(pinhole, parallel),
        )?;
        fs::write(folder.join("workshop.xml"), WORKSHOP)?;
        let spot = WORKSHOP
            .replace(SURROUNDINGS, "")
            .replace("gaussian", "box")
            .replace(
                CHECKS,
                "<rgb name=\"reflectance\" value=\"0.5, 0.4, 0.6\"/>",
            );
        fs::write(folder.join("workshop-lit-by-a-spot.xml"), spot)?;
        Ok(shipped)
    }

    fn inspect(&mut self, scene: &str) -> Outcome<()> {
        self.json(
            &format!("{scene}/inspect"),
            &format!("inspect {scene}.xml --json"),
        )
    }

    /// Renders; three results: the film, the summary, the picture.
    fn render(&mut self, scene: &str, name: &str, arguments: &str) -> Outcome<()> {
        let name = format!("{scene}/{name}");
        let size = if arguments.contains("size=") {
            ""
        } else {
            "-D size=24"
        };
        let size = if scene.starts_with("cornell-") && scene != "cornell-glass" {
            ""
        } else {
            size
        };
        self.film(
            &name,
            &format!("render {scene}.xml {size} {arguments} --json -o {FILM}"),
        )
    }

    fn film(&mut self, name: &str, words: &str) -> Outcome<()> {
        if !self.is_asked(name) {
            return Ok(());
        }
        let output = self.program(words)?;
        if output.status.code() == Some(2) {
            return self.refused(name, &output);
        }
        let (film, picture) = (self.work.path().join(FILM), self.work.path().join(PICTURE));
        let pixels = pixels(&film)?;
        self.result(name, pixels);
        self.result(&format!("{name}/picture"), hash(&fs::read(&picture)?));
        self.summary(&format!("{name}/summary"), &output.stdout)?;
        fs::remove_file(film)?;
        Ok(fs::remove_file(picture)?)
    }

    /// A run in two shards, put together.
    fn shards(&mut self, scene: &str, method: &str, sensor: &str) -> Outcome<()> {
        let name = format!("{scene}/merge");
        if !self.is_asked(&name) {
            return Ok(());
        }
        for part in ["1", "2"] {
            let words = format!(
                "render {scene}.xml -D size=24 {method} {sensor} --shard {part}/2 -o {part}.shard"
            );
            let output = self.program(&words)?;
            if output.status.code() == Some(2) {
                return self.refused(&name, &output);
            }
        }
        let words =
            format!("merge {scene}.xml -D size=24 {sensor} 1.shard 2.shard --json -o {FILM}");
        self.film(&name, &words)
    }

    fn comparison(&mut self) -> Outcome<()> {
        for (seed, file) in [(1, "a.exr"), (2, "b.exr")] {
            let words = format!(
                "render glass-ball.xml -D size=24 --method photons --photons 16384 --seed {seed} -o {file}"
            );
            self.program(&words)?;
        }
        self.json("glass-ball/compare", "compare a.exr b.exr --json")
    }

    fn study(&mut self) -> Outcome<()> {
        fs::write(self.work.path().join("study.toml"), STUDY)?;
        self.json(
            "glass-ball/validate",
            "validate study.toml -o report --json",
        )
    }

    /// The scenes that are held against Mitsuba: each kind of material, texture, light, shape and film.
    fn parity(&mut self) -> Outcome<()> {
        let mut scenes = Vec::new();
        for entry in fs::read_dir(PARITY)? {
            let path = entry?.path();
            if path.extension().is_some_and(|end| end == "xml") {
                scenes.push(path);
            }
        }
        scenes.sort();
        for scene in &scenes {
            let name = scene.file_stem().unwrap_or_default().to_string_lossy();
            let words = format!("render {} --json -o {FILM} --seed 3", scene.display());
            self.film(
                &format!("parity/{name}"),
                &format!("{words} --method path --spp 4 --replicates 2"),
            )?;
        }
        Ok(())
    }

    /// A result that is JSON on the standard output.
    fn json(&mut self, name: &str, words: &str) -> Outcome<()> {
        if !self.is_asked(name) {
            return Ok(());
        }
        let output = self.program(words)?;
        if output.status.code() == Some(2) {
            return self.refused(name, &output);
        }
        self.summary(name, &output.stdout)
    }

    fn summary(&mut self, name: &str, json: &[u8]) -> Outcome<()> {
        let mut value: Value =
            serde_json::from_slice(json).map_err(|error| format!("{name}: {error}"))?;
        normalise(&mut value);
        let text = serde_json::to_string_pretty(&value)?;
        if let Some(folder) = &self.keep {
            fs::write(
                folder.join(format!("{}.json", name.replace('/', "."))),
                &text,
            )?;
        }
        self.result(name, hash(text.as_bytes()));
        Ok(())
    }

    fn refused(&mut self, name: &str, output: &Output) -> Outcome<()> {
        let said = String::from_utf8_lossy(&output.stderr);
        let message = said.lines().find_map(|line| line.strip_prefix("error: "));
        let message = message.ok_or_else(|| format!("{name}: {said}"))?;
        let message = message.replace(PARITY, "");
        self.result(name, format!("refused: {message}"));
        Ok(())
    }

    fn is_asked(&self, name: &str) -> bool {
        name.contains(&self.only)
    }

    fn result(&mut self, name: &str, value: String) {
        if !self.is_asked(name) {
            return;
        }
        if !self.is_quiet {
            println!("{name} {value}");
        }
        let earlier = self.results.insert(name.to_owned(), value);
        assert!(earlier.is_none(), "two results are called {name}");
    }

    /// Runs the program in the work folder; words are parted by spaces.
    fn program(&self, words: &str) -> Outcome<Output> {
        let output = Command::new(&self.program)
            .current_dir(self.work.path())
            .args(words.split_whitespace())
            .output()?;
        match output.status.code() {
            Some(0..=2) => Ok(output),
            _ => Err(format!("{words}: {}", String::from_utf8_lossy(&output.stderr)).into()),
        }
    }

    /// Prints what differs from an earlier run; of that run only the results that are asked for count.
    fn compare(&self, before: &BTreeMap<String, String>) -> ExitCode {
        let names: BTreeSet<&String> = before.keys().chain(self.results.keys()).collect();
        let mut differing = 0;
        for name in names.iter().filter(|name| self.is_asked(name)) {
            let (old, new) = (before.get(*name), self.results.get(*name));
            if old != new {
                differing += 1;
                let line = |mark: char, value: Option<&String>| {
                    println!(
                        "{mark} {name} {}",
                        value.map_or("(missing)", String::as_str)
                    );
                };
                line('-', old);
                line('+', new);
            }
        }
        eprintln!("{differing} of {} results differ", self.results.len());
        ExitCode::from(u8::from(differing > 0))
    }
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex()[..32].to_owned()
}

/// A hash of all channels of an EXR: size, names, and bits; all NaN count as one.
fn pixels(path: &Path) -> Outcome<String> {
    let mut image = exr::read(path)?;
    image.channels.sort_by(|a, b| a.name.cmp(&b.name));
    let mut bytes = format!("{} x {}\n", image.width, image.height).into_bytes();
    for channel in &image.channels {
        bytes.extend(channel.name.as_bytes());
        bytes.push(b'\n');
        for sample in &channel.samples {
            let canonical = if sample.is_nan() { f32::NAN } else { *sample };
            bytes.extend(canonical.to_bits().to_le_bytes());
        }
    }
    Ok(hash(&bytes))
}

fn without_comments(xml: &str) -> String {
    let mut left = String::new();
    let mut rest = xml;
    while let Some((text, after)) = rest.split_once("<!--") {
        left.push_str(text);
        rest = after.split_once("-->").map_or("", |(_, after)| after);
    }
    left + rest
}

/// A scene with a camera of 24 x 16 pixels, and a receiver of 24 texels where no other size is given.
fn small(xml: &str) -> String {
    xml.replace("value=\"640\"", "value=\"24\"")
        .replace("value=\"480\"", "value=\"16\"")
        .replace("value=\"512\"", "value=\"24\"")
}

/// Leaves out times, and the hash of the program in the names of a study's films.
fn normalise(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.retain(|key, _| !LEFT_OUT.contains(&key.as_str()));
            map.values_mut().for_each(normalise);
        }
        Value::Array(values) => values.iter_mut().for_each(normalise),
        Value::String(text) if text.contains(".exr") => *text = without_hashes(text),
        _ => {}
    }
}

/// Film names of a study without the ten digits that say which program made them.
fn without_hashes(text: &str) -> String {
    let word = |word: &str| match word
        .strip_suffix(".exr")
        .and_then(|stem| stem.rsplit_once('-'))
    {
        Some((stem, hash)) if hash.len() == 10 && hash.chars().all(|c| c.is_ascii_hexdigit()) => {
            format!("{stem}.exr")
        }
        _ => word.to_owned(),
    };
    text.split(' ').map(word).collect::<Vec<_>>().join(" ")
}
