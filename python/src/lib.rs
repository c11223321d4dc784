//! The compiled half of the Python module `nephroid`: scenes, runs and films. Its other half, in `nephroid/`, checks
//! arguments and turns dicts into scene files.
//!
//! | file | content |
//! |---|---|
//! | `errors.rs` | errors of the library become the module's exceptions |
//! | `work.rs` | work on a thread and in a pool of its own, while the caller listens for Ctrl-C |
//! | `scene.rs` | a scene, and how it was read |
//! | `render.rs` | runs, shards, and their sum |
//! | `about.rs` | a scene's contents and costs, and the paths to one point |
//! | `attribute.rs` | the stages of a technique, and what each adds to its error |
//! | `study.rs` | studies: methods swept over their settings, judged by a truth |
//! | `film.rs` | a result, with its maps as arrays |
//! | `view.rs` | arrays that look at a film's memory: the only `unsafe` lines |
//! | `tools.rs` | comparison, images, the table of methods |

mod about;
mod attribute;
mod errors;
mod film;
mod render;
mod scene;
mod study;
mod tools;
mod view;
mod work;

use pyo3::prelude::*;

/// The compiled half of `nephroid`.
#[pymodule]
fn _nephroid(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<film::Film>()?;
    module.add_class::<film::Layer>()?;
    module.add("source_hash", nephroid::internals::run::SOURCE_HASH)?;
    module.add_class::<render::Gathering>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<work::Progress>()?;
    module.add_class::<study::StudyProgress>()?;
    module.add_function(wrap_pyfunction!(scene::load, module)?)?;
    module.add_function(wrap_pyfunction!(render::render, module)?)?;
    module.add_function(wrap_pyfunction!(render::shard, module)?)?;
    module.add_function(wrap_pyfunction!(render::merge, module)?)?;
    module.add_function(wrap_pyfunction!(render::part, module)?)?;
    module.add_function(wrap_pyfunction!(about::inspect, module)?)?;
    module.add_function(wrap_pyfunction!(about::probe, module)?)?;
    module.add_function(wrap_pyfunction!(attribute::attribute, module)?)?;
    module.add_function(wrap_pyfunction!(study::default_folder, module)?)?;
    module.add_function(wrap_pyfunction!(study::validate_study, module)?)?;
    module.add_function(wrap_pyfunction!(study::units, module)?)?;
    module.add_function(wrap_pyfunction!(study::unit, module)?)?;
    module.add_function(wrap_pyfunction!(tools::compare, module)?)?;
    module.add_function(wrap_pyfunction!(tools::exr, module)?)?;
    module.add_function(wrap_pyfunction!(tools::methods, module)?)?;
    Ok(())
}
