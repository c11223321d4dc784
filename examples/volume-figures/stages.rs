//! Which stage makes the error.

use std::time::Instant;

use nephroid::internals::metric::Figure;
use nephroid::internals::run::Context;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::study::attribution::{Attribution, attribute};

use crate::judge::{Case, Judge, table};
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
    let (mut figures, mut shares) = (Vec::new(), Vec::new());
    let mut names = Vec::new();
    let mut cases = vec![("`water`, floor".to_owned(), None)];
    for occluder in OCCLUDERS {
        for meter in ["floor", "wall"] {
            let name = format!("`pool`, {occluder}, {meter}");
            cases.push((name, Some((occluder, meter))));
        }
    }
    for (name, place) in cases {
        let case = match place {
            None => judge.water(),
            Some((occluder, meter)) => judge.pool(occluder, meter),
        };
        let start = Instant::now();
        let found = attributed(case);
        let seconds = start.elapsed().as_secs_f64();
        let whole = |figure: Figure, factor: f64, offset: f64| {
            let value = found.of(figure).map(|shares| shares.whole + offset);
            value.map_or("-".to_owned(), |value| three_digits(factor * value))
        };
        figures.push(vec![
            name.clone(),
            whole(Figure::Energy, 100.0, 1.0),
            whole(Figure::L1, 100.0, 0.0),
            whole(Figure::Misplaced, 100.0, 0.0),
            whole(Figure::Displaced, 1.0, 0.0),
            whole(Figure::L2, 100.0, 0.0),
            three_digits(100.0 * found.not_modelled),
            found.runs.to_string(),
            format!("{seconds:.1}"),
        ]);
        let Some(l1) = found.of(Figure::L1) else {
            continue;
        };
        // Stages that add nothing anywhere are left out: those that meters or the defaults have exact.
        names = found.stages.iter().map(|it| it.name.clone()).collect();
        let mut cells = vec![name, three_digits(100.0 * l1.whole)];
        cells.extend(l1.stages.iter().map(|stage| {
            let percent = 100.0 * stage.share.value;
            if percent.abs() < 0.005 {
                "0".to_owned()
            } else {
                format!("{percent:+.2} ± {:.2}", 100.0 * stage.share.standard_error)
            }
        }));
        cells.push(three_digits(100.0 * l1.residual));
        shares.push(cells);
    }
    let mut head = vec!["scene".to_owned(), ">L1".to_owned()];
    head.extend(names.iter().map(|name| format!(">{name}")));
    head.push(">all exact".to_owned());
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    vec![
        table(
            &[
                "scene",
                ">energy",
                ">L1",
                ">misplaced",
                ">displaced [texels]",
                ">L2",
                ">not modelled",
                ">runs",
                ">s",
            ],
            &figures,
        ),
        table(&head, &shares),
    ]
}
