//! What goes beyond the paper: ellipses, advice on slabs and faces, and all stages exact.

use std::collections::BTreeMap;

use nephroid::internals::approximation::Technique;
use nephroid::internals::approximation::caustics_volume::advice::{Pilot, SLABS};
use nephroid::internals::approximation::caustics_volume::cuboid::Face;
use nephroid::internals::approximation::caustics_volume::demands::Volume;
use nephroid::internals::approximation::caustics_volume::{CausticsVolume, Settings};
use nephroid::internals::metric::Figure;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::setting::Values;

use crate::judge::{Judge, OBJECTS, SIDE};
use crate::support::approximation::{bundled, exact_but as exact_map, rendered as map_of};
use crate::support::caustics_volume::{exact_but, rendered, truth};
use crate::support::figures::{figures, shown, table};
use crate::support::scenes::meter;

/// Light and interfaces right.
const RIGHT: [(&str, &str); 2] = [("emission", "exact"), ("interface", "exact")];

/// Splats that are held against each other.
pub const SPLATS: [&str; 2] = ["quads", "ellipses"];

/// Stages that are exact beside them: none, those of the light, and the filter, too.
pub const STAGES: [&[(&str, &str)]; 3] = [
    &[],
    &RIGHT,
    &[
        ("emission", "exact"),
        ("interface", "exact"),
        ("smooth", "exact"),
    ],
];

/// L1 by discs and by ellipses.
pub fn splats(judge: &mut Judge) -> Vec<String> {
    let mut lines = Vec::new();
    for object in &OBJECTS {
        let case = judge.floor(object);
        for preset in ["lowest", "best"] {
            let mut cells = vec![object.row(), format!("`{preset}`")];
            for stages in STAGES {
                for splat in SPLATS {
                    let own = [("preset", preset), ("splat", splat)];
                    let method = object.volume(&[stages, &own].concat());
                    cells.push(shown(&case.judged(&method), Figure::L1));
                }
            }
            lines.push(cells);
        }
    }
    vec![table(
        &[
            "scene",
            "preset",
            ">default: quads",
            ">ellipses",
            ">light right: quads",
            ">ellipses",
            ">and not smoothed: quads",
            ">ellipses",
        ],
        &lines,
    )]
}

/// Light that two surfaces a slab lose, by slabs; and light by exit face.
pub fn advice() -> Vec<String> {
    let (mut slabs, mut faces) = (Vec::new(), Vec::new());
    for object in &OBJECTS {
        let scene = object.scene(SIDE);
        for (name, stages) in [("default", &[][..]), ("light right", &RIGHT[..])] {
            let all = [stages, &[("max-depth", object.depth)]].concat();
            let given: BTreeMap<String, String> = all
                .iter()
                .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
                .collect();
            let table = CausticsVolume.settings().iter().collect();
            let values = Values::new("caustics-volume", table, &given).expect("its own settings");
            let settings = Settings::of(&values).expect("its own settings");
            let volume = Volume::new(&scene, &settings).expect("an object of glass or metal");
            let pilot = Pilot::new(&scene, &settings, &volume);
            let percent = |share: f64| three_digits(100.0 * share);
            let row = vec![object.row(), name.to_owned()];
            let lost = (1..=SLABS).map(|count| {
                let shares = pilot.slabs(count);
                format!("{} + {}", percent(shares.lost), percent(shares.false_light))
            });
            slabs.push(row.iter().cloned().chain(lost).collect());
            let shares = pilot.faces();
            let inside = (1.0 - shares.iter().sum::<f64>()).max(0.0);
            let by_face = Face::ALL.map(|face| percent(shares[face as usize]));
            let cells = row.into_iter().chain(by_face);
            faces.push(cells.chain([percent(inside)]).collect());
        }
    }
    vec![
        table(
            &[
                "scene", "stages", ">1 slab", ">2", ">3", ">4", ">5", ">6", ">7", ">8",
            ],
            &slabs,
        ),
        table(
            &[
                "scene",
                "stages",
                ">entry",
                ">far",
                ">first side",
                ">second side",
                ">third side",
                ">fourth side",
                ">lands inside",
            ],
            &faces,
        ),
    ]
}

/// All stages exact: against the truth, and the light of two refractions against a caustic map.
pub fn exact(_: &mut Judge) -> Vec<String> {
    let scene = bundled("glass-ball", SIDE);
    let sensor = meter(&scene);
    let truth = truth(&scene, 1e-3);
    let values = |settings: &[(&str, &str)]| -> Vec<Rgb> {
        rendered(&exact_but(settings), &scene).estimate.total.values
    };
    let through = [("interface", "fresnel"), ("max-depth", "2")];
    let map = map_of(&exact_map(&[("photons", "2048")]), &scene);
    let map = map.estimate.total.values;
    let lines = [128_u32, 256, 512, 1024, 2048].map(|side| {
        let photons = (side * side).to_string();
        let photons = ("photons", photons.as_str());
        let all = figures(&scene, sensor, &truth, &values(&[photons]));
        let two = values(&[&through[..], &[photons]].concat());
        let two = figures(&scene, sensor, &map, &two);
        eprintln!(
            "{side}²: {} {}",
            shown(&all, Figure::L1),
            shown(&two, Figure::L1)
        );
        vec![
            format!("{side}²"),
            shown(&all, Figure::Energy),
            shown(&all, Figure::L1),
            shown(&all, Figure::L2),
            shown(&two, Figure::Energy),
            shown(&two, Figure::L1),
            shown(&two, Figure::L2),
        ]
    });
    vec![table(
        &[
            "photons",
            ">energy, %",
            ">L1, %",
            ">L2, %",
            ">LTTD by the map's: energy, %",
            ">L1, %",
            ">L2, %",
        ],
        &lines,
    )]
}
