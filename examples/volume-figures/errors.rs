//! Tables of errors on meters.

use nephroid::internals::metric::Figure;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::run::format::three_digits;

use crate::judge::{Case, Judge};
use crate::support::approximation::scene_of;
use crate::support::figures::{shown, table, whole};
use crate::support::pool::{exact_but, rendered, volume, work};

/// Energy in flat water, in percent of the closed form.
fn flat_water(degrees: f64, settings: &[(&str, &str)]) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let scene = scene_of(&format!(
        r#"<scene version="3.0.0">
        <emitter type="directional"><vector name="direction" x="{sin}" y="0" z="-{cos}"/>
            <rgb name="irradiance" value="1, 1, 1"/></emitter>
        <shape type="rectangle"><transform name="to_world"><scale x="8" y="8"/><translate z="1"/></transform>
            <bsdf type="dielectric"><float name="int_ior" value="1.33"/><float name="ext_ior" value="1"/></bsdf>
        </shape>
        <shape type="rectangle"><bsdf type="diffuse"/><sensor type="irradiancemeter" id="floor">
            <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>
            <rfilter type="box"/></film></sensor></shape></scene>"#
    ));
    let values = rendered(&scene, "floor", &exact_but(settings))
        .estimate
        .total
        .values;
    let mean = values.iter().map(|value| value.mean()).sum::<f64>() / values.len() as f64;
    let truth = cos * (1.0 - dielectric_reflectance(cos, 1.33));
    three_digits(100.0 * mean / truth)
}

/// Cures of the second cosine.
const CURES: [(&str, &[(&str, &str)]); 7] = [
    ("as printed", &[("density", "slices"), ("cosine", "flat")]),
    ("vectors", &[("density", "slices"), ("cosine", "vector")]),
    (
        "`density=perpendicular`",
        &[("density", "perpendicular"), ("cosine", "flat")],
    ),
    (
        "`density=perpendicular`, vectors",
        &[("density", "perpendicular"), ("cosine", "vector")],
    ),
    (
        "`axis=refracted`",
        &[
            ("density", "slices"),
            ("cosine", "flat"),
            ("axis", "refracted"),
        ],
    ),
    (
        "`axis=refracted`, vectors",
        &[
            ("density", "slices"),
            ("cosine", "vector"),
            ("axis", "refracted"),
        ],
    ),
    (
        "the same, 256 slices",
        &[
            ("density", "slices"),
            ("cosine", "vector"),
            ("axis", "refracted"),
            ("slices", "256"),
        ],
    ),
];

/// Energies: two cosines.
pub fn cosines(judge: &mut Judge) -> Vec<String> {
    let lines = CURES.iter().map(|(name, settings)| {
        let mut cells = vec![(*name).to_owned()];
        cells.extend([0.0, 30.0, 60.0].map(|degrees| flat_water(degrees, settings)));
        for meter in ["floor", "wall"] {
            let found = judge.pool("none", meter).judged(&exact_but(settings)).1;
            cells.extend([Figure::Energy, Figure::L1].map(|figure| shown(&found, figure)));
        }
        cells
    });
    let lines: Vec<Vec<String>> = lines.collect();
    vec![table(
        &[
            "energy, %",
            ">flat water, 0°",
            ">30°",
            ">60°",
            ">pool, floor",
            ">L1",
            ">wall",
            ">L1",
        ],
        &lines,
    )]
}

/// Flat cosines against vectors.
pub fn vectors(judge: &mut Judge) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, is_exact, density) in [
        ("all else exact", true, "exact"),
        ("all else exact but `density=slices`", true, "slices"),
        ("all else by default", false, "slices"),
        (
            "by default but `density=perpendicular`",
            false,
            "perpendicular",
        ),
    ] {
        let mut cells = vec![name.to_owned()];
        for meter in ["floor", "wall"] {
            let case = judge.pool("none", meter);
            for cosine in ["flat", "vector"] {
                let settings = [("cosine", cosine), ("density", density)];
                let volume = if is_exact {
                    exact_but(&settings)
                } else {
                    volume(&settings)
                };
                cells.push(case.figure(&volume, Figure::L1));
            }
        }
        lines.push(cells);
    }
    vec![table(
        &[
            "L1, %",
            ">floor, `flat`",
            ">`vector`",
            ">wall, `flat`",
            ">`vector`",
        ],
        &lines,
    )]
}

/// The trade of `S_min`.
pub fn tolerance(judge: &mut Judge) -> Vec<String> {
    let mut lines = Vec::new();
    for s_min in ["0.05", "0.2", "0.35", "0.5", "0.65", "0.8", "0.95", "1"] {
        let mut cells = vec![s_min.to_owned()];
        for occluder in ["disc", "fence"] {
            let case = judge.pool(occluder, "floor");
            for shadow in ["vertex", "none"] {
                let settings = [
                    ("shadow", shadow),
                    ("shadow-cull", "hierarchy"),
                    ("s-min", s_min),
                ];
                let (rendering, found) = case.judged(&exact_but(&settings));
                if shadow == "vertex" {
                    cells.push(whole(work(&rendering, "shadow-cull", "culled")));
                }
                cells.push(shown(&found, Figure::L1));
            }
        }
        lines.push(cells);
    }
    let mut without = vec!["no culling".to_owned()];
    for occluder in ["disc", "fence"] {
        let case = judge.pool(occluder, "floor");
        without.push("0".to_owned());
        for shadow in ["vertex", "none"] {
            without.push(case.figure(&exact_but(&[("shadow", shadow)]), Figure::L1));
        }
    }
    lines.push(without);
    vec![table(
        &[
            "S_min",
            ">disc: culled",
            ">L1, %",
            ">`shadow=none`",
            ">fence: culled",
            ">L1, %",
            ">`shadow=none`",
        ],
        &lines,
    )]
}

/// The trade of W.
pub fn grid(judge: &mut Judge) -> Vec<String> {
    let mut lines = Vec::new();
    for grid in ["30", "60", "120", "160", "200", "400"] {
        let mut cells = vec![grid.to_owned()];
        let line = |case: &Case, cells: &mut Vec<String>| {
            let (rendering, found) =
                case.judged(&exact_but(&[("surface", "triangles"), ("grid", grid)]));
            if cells.len() == 1 {
                cells.push(whole(work(&rendering, "surface", "beams")));
            }
            let default = case.judged(&volume(&[("grid", grid)])).1;
            cells.extend([
                shown(&found, Figure::L1),
                shown(&found, Figure::Displaced),
                shown(&default, Figure::L1),
            ]);
        };
        line(judge.water(), &mut cells);
        line(judge.pool("none", "floor"), &mut cells);
        lines.push(cells);
    }
    vec![table(
        &[
            ">W",
            ">beams",
            ">`water`: L1, %",
            ">displaced",
            ">L1 by default, %",
            ">pool: L1, %",
            ">displaced",
            ">L1 by default, %",
        ],
        &lines,
    )]
}

/// The trade of slices.
pub fn slices(judge: &mut Judge) -> Vec<String> {
    let mut lines = Vec::new();
    for slices in ["2", "4", "8", "16", "32", "64"] {
        let mut cells = vec![slices.to_owned()];
        for (density, axis) in [
            ("slices", "water"),
            ("perpendicular", "water"),
            ("perpendicular", "refracted"),
        ] {
            for meter in ["floor", "wall"] {
                let case = judge.pool("none", meter);
                let settings = [("density", density), ("axis", axis), ("slices", slices)];
                cells.push(case.figure(&exact_but(&settings), Figure::L1));
            }
        }
        lines.push(cells);
    }
    vec![table(
        &[
            ">slices",
            ">`slices`: floor",
            ">wall",
            ">`perpendicular`: floor",
            ">wall",
            ">and `axis=refracted`: floor",
            ">wall",
        ],
        &lines,
    )]
}
