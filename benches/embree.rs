//! Closest hits beside Embree 4: `cargo bench --bench embree`.
//!
//! The same meshes and rays, rounded to `f32` for Embree, on one thread by turns: a ratio of speeds is the median of
//! five. Embree's trees are robust ones, and it searches for one ray after the other (`rtcIntersect1`). Ours are
//! searched both so and many rays at a time. Rays inside a mesh leave places and go in directions at random, as light
//! inside glass does after some bounces. Trees are built on all threads, once before a clock runs and then five times.
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

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use nephroid::internals::geometry::{Mesh, Ray, Shape, World};
use rays::{coherent, incoherent, inside, search, search_many, seconds, segments};
use support::child::Answering;
use support::geometry::{bumpy_torus, mesh};
use support::measured::{is_measured, times};

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
        "| triangles | rays | Embree, ns/ray | our speed / Embree's, one by one | many at a time | hit counts differ by |"
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
        let (world, build) = build(&mesh, &folder.path().join("mesh"), &mut embree);
        builds.push(build);
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
                "| {} | {kind} {} |",
                mesh.triangle_count(),
                contest(&world, &rays, &mut embree)
            );
        }
    }
    println!("\n| triangles | build, s | Embree's, s | our speed / Embree's |\n|--:|--:|--:|--:|");
    builds.iter().for_each(|line| println!("{line}"));
}

/// Number of runs of each, of which the median counts.
fn turns() -> usize {
    times(5)
}

/// The world of a mesh, which Embree has now, too; and a line of the table of builds.
fn build(mesh: &Mesh, file: &Path, embree: &mut Embree) -> (World, String) {
    let shape = || vec![Shape::Mesh(mesh.clone())];
    let mut world = World::new(shape());
    let mut times: [Vec<f64>; 2] = Default::default();
    for turn in 0..=turns() {
        let shapes = shape();
        let ours = seconds(|| world = World::new(shapes));
        embree.send(file, "mesh", |file| write_mesh(file, mesh));
        let theirs = embree.numbers()[0];
        // The first starts the threads of both.
        if turn > 0 {
            times[0].push(ours);
            times[1].push(theirs);
        }
    }
    let [ours, theirs] = times.map(|it| median(it.into_iter()));
    let line = format!(
        "| {} | {ours:.3} | {theirs:.3} | {:.2} |",
        mesh.triangle_count(),
        theirs / ours
    );
    (world, line)
}

/// A line of the table, from its third column on.
fn contest(world: &World, rays: &[Ray], embree: &mut Embree) -> String {
    let segments = segments(rays);
    let (mut ours, mut theirs) = (0, 0.0);
    let mut times: [Vec<f64>; 3] = Default::default();
    for _ in 0..turns() {
        times[0].push(seconds(|| ours = search(world, rays).0));
        times[1].push(seconds(|| ours = search_many(world, &segments)));
        embree.0.send("run");
        let answer = embree.numbers();
        times[2].push(answer[0]);
        theirs = answer[1];
    }
    let speed = |ours: usize| median(times[2].iter().zip(&times[ours]).map(|(b, a)| b / a));
    format!(
        "| {:.0} | {:.2} | {:.2} | {:.1e}",
        1e9 * median(times[2].iter().copied()) / rays.len() as f64,
        speed(0),
        speed(1),
        (ours as f64 - theirs).abs() / rays.len() as f64,
    )
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn write_mesh(file: &mut impl Write, mesh: &Mesh) -> std::io::Result<()> {
    for count in [mesh.positions().len(), mesh.triangle_count()] {
        file.write_all(&(count as u32).to_le_bytes())?;
    }
    for number in mesh.positions().iter().flat_map(|it| it.to_array()) {
        file.write_all(&(number as f32).to_le_bytes())?;
    }
    let mut corners = mesh.triangles().iter().flatten();
    corners.try_for_each(|corner| file.write_all(&corner.to_le_bytes()))
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
struct Embree(Answering);

impl Embree {
    /// Starts it; returns the reason if that is not possible.
    fn start(folder: &Path) -> Result<Self, String> {
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
        let mut process = Answering::start(Command::new(program).arg(library()?))?;
        // It says so once it has the library.
        match process.answer() {
            Some(_) => Ok(Self(process)),
            None => Err("Embree's library cannot be used".to_owned()),
        }
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
        self.0.send(&format!("{command} {}", path.display()));
    }

    /// The numbers of its next answer.
    fn numbers(&mut self) -> Vec<f64> {
        let line = self.0.answer().expect("Embree's reason is above");
        line.split_whitespace().flat_map(str::parse).collect()
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
