//! Which stage makes the error.

use std::time::Instant;

use nephroid::internals::run::Context;
use nephroid::internals::study::attribution::{Attribution, attribute};

use crate::judge::{Case, Judge};
use crate::support::figures::attributions;
use crate::support::pool::{OCCLUDERS, volume};

fn attributed(case: &Case) -> Attribution {
    let context = Context::default();
    let found = attribute(
        &volume(&[]),
        &case.scene,
        case.sensor(),
        &context,
        &mut |_, _| (),
        |_| Ok(case.truth.clone()),
    );
    found.expect("a scene with water").expect("nobody stops it")
}

/// Shapley's values of L1.
pub fn stages(judge: &mut Judge) -> Vec<String> {
    let mut cases = vec![("`water`, floor".to_owned(), None)];
    for occluder in OCCLUDERS {
        for meter in ["floor", "wall"] {
            let name = format!("`pool`, {occluder}, {meter}");
            cases.push((name, Some((occluder, meter))));
        }
    }
    let all = cases.into_iter().map(|(name, place)| {
        let case = match place {
            None => judge.water(),
            Some((occluder, meter)) => judge.pool(occluder, meter),
        };
        let start = Instant::now();
        let found = attributed(case);
        (name, found, start.elapsed().as_secs_f64())
    });
    attributions(&all.collect::<Vec<_>>())
}
