//! `docs/local-irradiance.png`: floors as they are, and as tables have them.

use nephroid::internals::run::format::three_digits;

use crate::judge::{floor, l1, percent, turntable};
use crate::support::figures::{save_picture, table};
use crate::support::local_irradiance::{exact_but, tables};

/// Texels a row of each part, and rows.
const SIDE: &str = "160";

/// Irradiance [W/m²] that is white.
const WHITE: f64 = 20.0;

/// The settings of all columns but the first.
fn columns() -> [(&'static str, Vec<(&'static str, &'static str)>); 3] {
    let fine = ("photons", "65536");
    [
        ("grid", vec![fine]),
        ("shells", vec![fine, ("space", "shells")]),
        (
            "harmonics, order 5",
            vec![
                ("directions", "harmonics"),
                ("storage", "f32"),
                ("space", "shells"),
                ("photons", "1024"),
            ],
        ),
    ]
}

/// Writes the picture.
pub fn picture() -> Vec<String> {
    let (mut rows, mut lines) = (Vec::new(), Vec::new());
    for name in ["ball", "prism", "bumpy"] {
        let scene = turntable(name, &[("size", SIDE)]);
        let photons = if name == "bumpy" { "131072" } else { "524288" };
        let truth = exact_but(&[("photons", photons)]);
        let values = |method| floor(&method, &scene);
        let mut row = vec![values(truth)];
        let mut cells = vec![format!("`{name}`")];
        for (_, given) in columns() {
            let image = values(tables(&given));
            cells.push(percent(l1(&row[0], &image)));
            row.push(image);
        }
        cells.push(three_digits(
            crate::judge::sum(&row[0]) / row[0].len() as f64,
        ));
        rows.push(row);
        lines.push(cells);
    }
    let side = SIDE.parse().unwrap();
    save_picture("local-irradiance.png", [side, side], WHITE, &rows);
    let mut head = vec!["L1, %".to_owned()];
    head.extend(columns().map(|(name, _)| format!(">{name}")));
    head.push(">mean of the truth".to_owned());
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    vec![
        "`docs/local-irradiance.png` is written.".to_owned(),
        table(&head, &lines),
    ]
}
