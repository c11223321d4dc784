//! Closest hits beside Embree 4: `cargo bench --bench embree`.
//!
//! The same meshes and rays, one thread, by turns: a ratio is the median of five. Embree's trees are robust ones, and
//! it searches for one ray after the other (`rtcIntersect1`). Ours are searched both so and many rays at a time.
//! Rays inside a mesh leave places and go in directions at random, as light inside glass does after some bounces.
//!
//! Embree comes from PyPI's wheel `embreex`: `pip install embreex`; a C compiler makes the program that loads it.
//! Skipped, with the reason, if either is missing. `PYTHON` names the Python that has the wheel.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "traversal/rays.rs"]
mod rays;

#[path = "../tests/support/mod.rs"]
mod support;

use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};

use nephroid::internals::geometry::{Hit, Mesh, Ray, Segment, Shape, TraversalCounters, World};
use rays::{coherent, incoherent, inside, is_measured, seconds, segments};
use support::geometry::{bumpy_torus, mesh};

/// Number of runs of each, of which the median counts.
const TURNS: usize = 5;

/// Rays that ours searches for at a time.
const BATCH: usize = 512;

fn main() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut embree = match Embree::start(folder.path()) {
        Ok(embree) => embree,
        Err(reason) => {
            println!("skipped: {reason}");
            return;
        }
    };
    println!(
        "| triangles | rays | Embree, ns/ray | ours / Embree, one by one | many at a time | hits of one alone |"
    );
    println!("|--:|---|--:|--:|--:|--:|");
    let mut builds = Vec::new();
    let fineness: &[(u32, u32)] = if is_measured() {
        &[(400, 100), (820, 200), (1320, 330)]
    } else {
        &[(40, 10)]
    };
    for &(around, across) in fineness {
        let mesh = mesh(bumpy_torus(around, across));
        let triangles = mesh.triangle_count();
        embree.send(&folder.path().join("mesh"), "mesh", |file| {
            write_mesh(file, &mesh)
        });
        let theirs = embree.numbers()[0];
        let mut world = None;
        let ours = seconds(|| world = Some(World::new(vec![Shape::Mesh(mesh)])));
        builds.push((triangles, ours, theirs));
        let world = world.expect("built");
        for (kind, rays) in [
            ("coherent", coherent()),
            ("incoherent", incoherent()),
            ("inside", inside()),
        ] {
            embree.send(&folder.path().join("rays"), "rays", |file| {
                write_rays(file, &rays)
            });
            embree.numbers();
            println!(
                "| {triangles} | {kind} {} |",
                contest(&world, &rays, &mut embree)
            );
        }
    }
    println!("\n| triangles | build, s | Embree's, s | ratio of times |\n|--:|--:|--:|--:|");
    for (triangles, ours, theirs) in builds {
        println!(
            "| {triangles} | {ours:.3} | {theirs:.3} | {:.2} |",
            ours / theirs
        );
    }
}

/// A line of the table, from its third column on.
fn contest(world: &World, rays: &[Ray], embree: &mut Embree) -> String {
    let segments = segments(rays);
    let mut hits = (0, 0.0);
    let mut times: [Vec<f64>; 3] = Default::default();
    for _ in 0..TURNS {
        let mut found = Vec::new();
        times[0].push(seconds(|| {
            black_box(one_by_one(world, rays));
        }));
        times[1].push(seconds(|| found = many_at_a_time(world, &segments)));
        embree.command("run");
        let answer = embree.numbers();
        times[2].push(answer[0]);
        hits = (found.iter().flatten().count(), answer[1]);
    }
    let ratio = |ours: usize| median(times[2].iter().zip(&times[ours]).map(|(b, a)| b / a));
    format!(
        "| {:.0} | {:.2} | {:.2} | {:.1e}",
        1e9 * median(times[2].iter().copied()) / rays.len() as f64,
        ratio(0),
        ratio(1),
        (hits.0 as f64 - hits.1).abs() / rays.len() as f64,
    )
}

fn one_by_one(world: &World, rays: &[Ray]) -> Vec<Option<Hit>> {
    let mut counters = TraversalCounters::default();
    rays.iter()
        .map(|ray| world.closest_hit(ray, f64::INFINITY, &mut counters))
        .collect()
}

fn many_at_a_time(world: &World, segments: &[Segment]) -> Vec<Option<Hit>> {
    let mut counters = TraversalCounters::default();
    let mut all = Vec::with_capacity(segments.len());
    let mut found = Vec::new();
    for batch in segments.chunks(BATCH) {
        world.closest_hits(batch, &mut found, &mut counters);
        all.append(&mut found);
    }
    all
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn write_mesh(file: &mut impl Write, mesh: &Mesh) -> std::io::Result<()> {
    let faces = mesh.triangle_count() as u32;
    file.write_all(&(3 * faces).to_le_bytes())?;
    file.write_all(&faces.to_le_bytes())?;
    // Corners of their own for each face: only hits are wanted.
    for corner in (0..faces).flat_map(|face| mesh.corners(face)) {
        for axis in corner.to_array() {
            file.write_all(&(axis as f32).to_le_bytes())?;
        }
    }
    (0..3 * faces).try_for_each(|corner| file.write_all(&corner.to_le_bytes()))
}

fn write_rays(file: &mut impl Write, rays: &[Ray]) -> std::io::Result<()> {
    file.write_all(&(rays.len() as u32).to_le_bytes())?;
    for number in rays
        .iter()
        .flat_map(|ray| [ray.origin, ray.direction])
        .flat_map(|it| it.to_array())
    {
        file.write_all(&(number as f32).to_le_bytes())?;
    }
    Ok(())
}

/// A process that searches with Embree.
struct Embree {
    process: Child,
    answers: BufReader<ChildStdout>,
}

impl Embree {
    /// Starts it; returns the reason if that is not possible.
    fn start(folder: &Path) -> Result<Self, String> {
        let library = library()?;
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/embree/closest_hits.c");
        let program = folder.join("closest_hits");
        let compiler = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
        let output = Command::new(compiler)
            .args(["-O2", "-o"])
            .arg(&program)
            .arg(source)
            .arg("-ldl")
            .output()
            .map_err(|error| format!("no C compiler: {error}"))?;
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            return Err(format!("closest_hits.c does not compile: {text}"));
        }
        let mut process = Command::new(program)
            .arg(library)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| error.to_string())?;
        let answers = BufReader::new(process.stdout.take().ok_or("no pipe")?);
        Ok(Self { process, answers })
    }

    fn command(&mut self, line: &str) {
        let input = self.process.stdin.as_mut().expect("a pipe");
        writeln!(input, "{line}").expect("it listens");
    }

    /// Writes a file and has it read.
    fn send(
        &mut self,
        path: &Path,
        command: &str,
        write: impl FnOnce(&mut std::io::BufWriter<std::fs::File>) -> std::io::Result<()>,
    ) {
        let file = std::fs::File::create(path).expect("a temporary file");
        let mut file = std::io::BufWriter::new(file);
        write(&mut file)
            .and_then(|()| file.flush())
            .expect("a temporary file");
        self.command(&format!("{command} {}", path.display()));
    }

    /// The numbers of its next answer.
    fn numbers(&mut self) -> Vec<f64> {
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("an answer");
        let numbers: Vec<f64> = line.split_whitespace().flat_map(str::parse).collect();
        assert!(!numbers.is_empty(), "Embree ended; its reason is above");
        numbers
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // It ends with its input. Nothing is lost if it does not.
        drop(self.process.stdin.take());
        let _ = self.process.wait();
    }
}

/// Embree's library, as the wheel has it.
fn library() -> Result<PathBuf, String> {
    const FIND: &str = "import embreex, pathlib; \
        print(next((pathlib.Path(embreex.__file__).parents[1] / 'embreex.libs').glob('libembree4*')))";
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let output = Command::new(python)
        .args(["-c", FIND])
        .output()
        .map_err(|error| format!("no Python: {error}"))?;
    let path = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    if output.status.success() && path.is_file() {
        Ok(path)
    } else {
        Err("no Python with Embree: pip install embreex".to_owned())
    }
}
