//! How far cells must reach, and how far a lamp must be.

use crate::judge::{floor, l1, percent, sum, turntable};
use crate::support::approximation::{GLASS, scene_of};
use crate::support::figures::table;
use crate::support::local_irradiance::{exact_but, texels};

/// Errors of the region alone.
pub fn reach() -> Vec<String> {
    let mut lines = Vec::new();
    for (name, drop) in [
        ("ball", "2"),
        ("ball", "4"),
        ("cube", "1.1"),
        ("prism", "0.7"),
        ("ring", "0.32"),
        ("bumpy", "2"),
    ] {
        let scene = turntable(name, &[("size", "64"), ("drop", drop)]);
        let photons = if name == "bumpy" { "131072" } else { "1048576" };
        let image = |given: &[(&str, &str)]| {
            floor(
                &exact_but(&[&[("photons", photons)], given].concat()),
                &scene,
            )
        };
        let truth = image(&[]);
        let mut cells = vec![format!("`{name}`"), drop.to_owned()];
        for region in ["clamp", "fade"] {
            for reach in ["2", "3", "4", "6"] {
                let own = image(&[("region", region), ("reach", reach)]);
                let energy = percent(sum(&own) / sum(&truth));
                cells.push(format!("{} ({energy})", percent(l1(&truth, &own))));
            }
        }
        lines.push(cells);
    }
    vec![table(
        &[
            "L1 (energy), %",
            ">drop, m",
            ">`clamp`: reach 2",
            ">3",
            ">4",
            ">6",
            ">`fade`: reach 2",
            ">3",
            ">4",
            ">6",
        ],
        &lines,
    )]
}

/// Errors of `light=directional` by the distance of a lamp.
pub fn lamp() -> Vec<String> {
    let ball =
        format!(r#"<shape type="sphere"><point name="center" x="0" y="0" z="2"/>{GLASS}</shape>"#);
    let cube = format!(
        r#"<shape type="cube"><transform name="to_world"><scale value="0.57735"/>
           <rotate x="0.6" y="0.8" angle="35"/><translate z="2"/></transform>{GLASS}</shape>"#
    );
    let mut lines = Vec::new();
    for (name, object) in [("ball", ball), ("cube, turned", cube)] {
        let mut cells = vec![name.to_owned()];
        for distance in [3.0, 5.0, 10.0, 30.0, 100.0f64] {
            // As the turntables' sun: azimuth 30°, elevation 60°.
            let [x, y, z] = [0.433, 0.25, 0.866].map(|it| it * distance);
            let intensity = distance * distance;
            let scene = scene_of(&format!(
                r#"<scene version="3.0.0">
                <emitter type="point"><point name="position" x="{x}" y="{y}" z="{}"/>
                    <rgb name="intensity" value="{intensity}, {intensity}, {intensity}"/></emitter>
                {object}
                <shape type="rectangle"><transform name="to_world"><scale x="3" y="3"/></transform>
                    <bsdf type="diffuse"/>
                    <sensor type="irradiancemeter"><film type="hdrfilm">
                        <integer name="width" value="64"/><integer name="height" value="64"/>
                        <rfilter type="box"/></film></sensor></shape></scene>"#,
                z + 2.0
            ));
            let image = |light: &str| {
                texels(
                    &exact_but(&[("light", light), ("photons", "1048576")]),
                    &scene,
                )
            };
            let (truth, own) = (image("exact"), image("directional"));
            let apart: f64 = truth.iter().zip(&own).map(|(a, b)| (a - b).abs()).sum();
            let [all, light] = [&truth, &own].map(|it| it.iter().sum::<f64>());
            cells.push(format!(
                "{} ({})",
                percent(apart / all),
                percent(light / all)
            ));
        }
        lines.push(cells);
    }
    vec![table(
        &["L1 (energy), %", ">3 radii", ">5", ">10", ">30", ">100"],
        &lines,
    )]
}
