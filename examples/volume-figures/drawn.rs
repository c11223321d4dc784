//! Tables of what cameras see.

use nephroid::internals::metric::Figure;
use nephroid::internals::run::Rendering;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::scene::Scene;

use crate::support::figures::{figures, shown, table, whole};
use crate::support::pool::{VIEWS, exact_but, rendered, sensor, unlike, viewed, volume, work};
use crate::support::{bundled_file, loaded};

/// Films.
const SIZE: [usize; 2] = [256, 192];

/// Films where beams without clamping, or 64 points a pixel, would take long.
const SMALLER: [usize; 2] = [128, 96];

/// The share of pixels, in percent, that differ by more than a fraction of the brighter.
fn apart(one: &Rendering, other: &Rendering, fraction: f64) -> String {
    let (a, b) = (&one.estimate.total.values, &other.estimate.total.values);
    let pairs = a.iter().zip(b).map(|(a, b)| (a.mean(), b.mean()));
    let count = pairs
        .filter(|(a, b)| (a - b).abs() > fraction * a.max(*b))
        .count();
    three_digits(100.0 * count as f64 / a.len() as f64)
}

/// L1 in percent of one against another.
fn l1(scene: &Scene, view: &str, truth: &Rendering, other: &Rendering) -> String {
    let [truth, other] = [truth, other].map(|it| &it.estimate.total.values);
    shown(
        &figures(scene, sensor(scene, view), truth, other),
        Figure::L1,
    )
}

/// Hulls as printed against conservative ones.
pub fn hulls() -> Vec<String> {
    let scene = viewed("none", SIZE);
    let mut lines = Vec::new();
    for view in VIEWS {
        for grid in ["60", "120", "200"] {
            let of = |hull: &str| {
                let settings = [
                    ("hull", hull),
                    ("grid", grid),
                    ("inside", "exact"),
                    ("accumulate", "exact"),
                ];
                rendered(&scene, view, &volume(&settings))
            };
            let (padded, paper) = (of("padded"), of("paper"));
            let count = |it: &Rendering, kind: &str| whole(work(it, "clamp", kind));
            lines.push(vec![
                format!("`{view}`"),
                grid.to_owned(),
                whole(work(&padded, "surface", "beams")),
                count(&padded, "escapes"),
                count(&paper, "escapes"),
                count(&padded, "draws"),
                count(&paper, "draws"),
                whole(unlike(&padded, &paper) as u64),
                l1(&scene, view, &padded, &paper),
            ]);
        }
    }
    vec![table(
        &[
            "view",
            ">W",
            ">beams",
            ">escapes, padded",
            ">escapes, paper",
            ">draws, padded",
            ">draws, paper",
            ">pixels that differ",
            ">L1, %",
        ],
        &lines,
    )]
}

/// Images by each variant of stage `clamp`.
pub fn clamping() -> Vec<String> {
    let scene = viewed("disc", SMALLER);
    let mut lines = Vec::new();
    for view in VIEWS {
        for (inside, test) in [("exact", "fail"), ("stencil", "fail"), ("stencil", "pass")] {
            let of = |clamp: &str| {
                rendered(
                    &scene,
                    view,
                    &volume(&[
                        ("clamp", clamp),
                        ("inside", inside),
                        ("depth-test", test),
                        ("accumulate", "exact"),
                    ]),
                )
            };
            let [all, beams, nodes] = ["exact", "beams", "hierarchy"].map(of);
            let fragments = |it: &Rendering| work(it, "inside", "fragments") as f64;
            lines.push(vec![
                format!("`{view}`"),
                if inside == "exact" {
                    "`exact`".to_owned()
                } else {
                    format!("`stencil`, `{test}`")
                },
                whole(unlike(&nodes, &beams) as u64),
                whole(unlike(&nodes, &all) as u64),
                apart(&nodes, &all, 0.01),
                l1(&scene, view, &all, &nodes),
                three_digits(fragments(&all) / fragments(&nodes)),
                three_digits(
                    work(&all, "clamp", "vertices") as f64
                        / work(&nodes, "clamp", "vertices") as f64,
                ),
            ]);
        }
    }
    let water = loaded(&bundled_file("water"), 256);
    let of = |clamp: &str| {
        let rendering = rendered(&water, "camera", &volume(&[("clamp", clamp)]));
        work(&rendering, "inside", "fragments")
    };
    let (all, clamped) = (of("exact"), of("hierarchy"));
    vec![
        table(
            &[
                "view",
                "`inside`",
                ">beams: pixels that differ",
                ">exact: pixels that differ",
                ">by over 1 %, % of pixels",
                ">L1, %",
                ">fragments, exact / hierarchy",
                ">vertices, exact / hierarchy",
            ],
            &lines,
        ),
        format!(
            "`water`, camera: {} fragments without clamping, {} with it: {} times.",
            whole(all),
            whole(clamped),
            three_digits(all as f64 / clamped as f64)
        ),
    ]
}

/// The stencil buffer against points in beams.
pub fn stencil() -> Vec<String> {
    let scene = viewed("none", SIZE);
    let mut lines = Vec::new();
    for view in VIEWS {
        for test in ["fail", "pass"] {
            let of = |inside: &str| {
                rendered(
                    &scene,
                    view,
                    &volume(&[
                        ("inside", inside),
                        ("accumulate", "exact"),
                        ("depth-test", test),
                    ]),
                )
            };
            let (exact, stencil) = (of("exact"), of("stencil"));
            let blends = |it: &Rendering| work(it, "accumulate", "blends");
            lines.push(vec![
                format!("`{view}`"),
                format!("`{test}`"),
                whole(blends(&exact)),
                whole(blends(&stencil)),
                apart(&exact, &stencil, 0.0),
                apart(&exact, &stencil, 0.01),
                apart(&exact, &stencil, 0.1),
                l1(&scene, view, &exact, &stencil),
            ]);
        }
    }
    vec![table(
        &[
            "view",
            "`depth-test`",
            ">points in beams, exact",
            ">by stencil",
            ">pixels that differ, %",
            ">by over 1 %",
            ">by over 10 %",
            ">L1, %",
        ],
        &lines,
    )]
}

/// Errors of the presets on cameras, against the technique with all stages exact.
pub fn views() -> Vec<String> {
    let mut lines = Vec::new();
    for occluder in ["none", "disc"] {
        let scene = viewed(occluder, SMALLER);
        for view in VIEWS {
            let truth = rendered(&scene, view, &exact_but(&[("accumulate", "f32")]));
            let mut cells = vec![occluder.to_owned(), format!("`{view}`")];
            for settings in [
                &[][..],
                &[("cosine", "vector")],
                &[("density", "perpendicular")],
                &[("inside", "exact")],
                &[("depth-test", "pass")],
                &[("occlusion", "exact")],
                &[("density", "perpendicular"), ("occlusion", "exact")],
            ] {
                let rendering = rendered(&scene, view, &volume(settings));
                cells.push(l1(&scene, view, &truth, &rendering));
            }
            lines.push(cells);
        }
    }
    vec![table(
        &[
            "occluder",
            "view",
            ">default",
            ">`vector`",
            ">`perpendicular`",
            ">`inside=exact`",
            ">`depth-test=pass`",
            ">`occlusion=exact`",
            ">`perpendicular`, `occlusion=exact`",
        ],
        &lines,
    )]
}
