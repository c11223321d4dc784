//! Scene files that grow while they are read, by entities, references and includes.

use std::sync::OnceLock;

use tempfile::TempDir;

use super::changed::load_text;
use super::watch::{TIMES_HONEST, alone, load, load_elements, scene_of};

/// The heap \[bytes\] that an honest scene file of this length may take: the smallest scene's, and for each
/// byte what a thousand balls take for each of theirs.
fn honest_scene_peak(length: usize) -> f64 {
    static MEASURED: OnceLock<(f64, f64)> = OnceLock::new();
    let (least, a_byte) = *MEASURED.get_or_init(|| {
        let measured = |balls: usize| {
            let elements = "<shape type=\"sphere\"/>\n".repeat(balls);
            // Once before: what the first thread of all takes is no scene's.
            load_elements(&elements);
            let outcome = load_elements(&elements);
            assert!(outcome.result.is_ok());
            (outcome.peak as f64, scene_of(&elements).len() as f64)
        };
        let [small, large] = [1, 1000].map(measured);
        let a_byte = (large.0 - small.0) / (large.1 - small.1);
        println!(
            "an honest scene takes {} bytes of heap, and {a_byte:.1} for a byte",
            small.0
        );
        (small.0, a_byte)
    });
    least + a_byte * length as f64
}

#[test]
fn scene_files_that_grow_while_they_are_read_are_refused() {
    let _alone = alone();
    let entities: String = (1..64)
        .map(|n| format!("<!ENTITY e{n} \"&e{};&e{};\">", n - 1, n - 1))
        .collect();
    let bomb = format!(
        "<!DOCTYPE s [<!ENTITY e0 \"xxxxxxxx\">{entities}]><scene version=\"3.0.0\">&e63;</scene>"
    );
    let deep = "<shape type=\"shapegroup\">".repeat(1_000_000);
    let long = "x".repeat(1 << 19);
    let parameters: String = (0..100_000)
        .map(|n| format!("<default name=\"p{n}\" value=\"$a$a\"/>\n"))
        .collect();
    // Every `$a` is compared with names of every length.
    let names: String = (1..1500)
        .map(|n| format!("<default name=\"{}\" value=\"1\"/>\n", "a".repeat(n)))
        .collect();
    let names = format!(
        "{names}<string name=\"{}\" value=\"x\"/>",
        "$a".repeat(500_000)
    );
    let group = format!(
        "<shape type=\"shapegroup\" id=\"g\">{}</shape>",
        "<shape type=\"sphere\"/>".repeat(20_000)
    );
    let instances = "<shape type=\"instance\"><ref id=\"g\"/></shape>\n".repeat(20_000);
    let cases = [
        ("an entity bomb", bomb, "not well-formed XML"),
        ("elements a million deep", scene_of(&deep), ""),
        (
            "elements a million deep and back",
            scene_of(&format!("{deep}{}", "</shape>".repeat(1_000_000))),
            "more than 64 levels deep",
        ),
        (
            "plain tags a million deep and back",
            scene_of(&format!(
                "{}{}",
                "<a>".repeat(1_000_000),
                "</a>".repeat(1_000_000)
            )),
            "",
        ),
        (
            "a hundred thousand long parameters",
            scene_of(&format!(
                "<default name=\"a\" value=\"{long}\"/>{parameters}"
            )),
            "come to more than",
        ),
        (
            "names of fifteen hundred lengths",
            scene_of(&names),
            "is longer than",
        ),
        (
            "four hundred million instances",
            scene_of(&format!("{group}{instances}")),
            "instances",
        ),
    ];
    for (case, text, expected) in cases {
        let allowed = TIMES_HONEST * honest_scene_peak(text.len());
        let outcome = load_text(text.as_bytes());
        let (peak, seconds) = (outcome.peak, outcome.seconds);
        println!(
            "{case}: {} bytes, {peak} bytes of heap ({:.2} of what is allowed), {seconds:.2} s",
            text.len(),
            peak as f64 / allowed
        );
        let error = outcome.refusal(case);
        assert!(error.contains(expected), "{case}: {error}");
        assert!(
            error.len() < 10_000,
            "{case}: a message of {} bytes",
            error.len()
        );
        assert!(
            (peak as f64) < allowed,
            "{case}: {peak} bytes of heap, {allowed} are allowed"
        );
    }
}

#[test]
fn includes_end_however_they_are_nested() {
    let _alone = alone();
    let folder = TempDir::new().unwrap();
    let write = |name: String, elements: &str| {
        std::fs::write(folder.path().join(name), scene_of(elements)).unwrap()
    };
    let include = |name: &str| format!("<include filename=\"{name}\"/>\n");
    // A hundred thousand files, each of which includes the next.
    for n in 0..100_000 {
        write(
            format!("chain{n}.xml"),
            &include(&format!("chain{}.xml", n + 1)),
        );
    }
    // Fifteen, each of which includes the next ten times: 10¹⁴ in all.
    for n in 0..15 {
        write(
            format!("tree{n}.xml"),
            &include(&format!("tree{}.xml", n + 1)).repeat(10),
        );
    }
    write("tree15.xml".to_owned(), "");
    // A hundred thousand times the same, and itself by other names.
    write(
        "flat.xml".to_owned(),
        &include("tree15.xml").repeat(100_000),
    );
    write("self.xml".to_owned(), &include("./././self.xml").repeat(10));
    for (name, expected) in [
        ("chain0.xml", "more than 15 levels deep"),
        ("tree0.xml", "which is all that is allowed"),
        ("flat.xml", "which is all that is allowed"),
        ("self.xml", "includes"),
    ] {
        let outcome = load(&folder.path().join(name));
        let (peak, seconds) = (outcome.peak, outcome.seconds);
        let error = outcome.refusal(name);
        assert!(error.contains(expected), "{name}: {error}");
        // Of 2¹⁴ files their names and versions are kept, no contents: 40 bytes each in a list that is three
        // times as long while it grows, from one half of its room to twice that; and the name, which may have
        // twice its room.
        let path = folder.path().join(name);
        let kept = 3 * 40 + 2 * path.as_os_str().len();
        let length = std::fs::metadata(&path).unwrap().len() as usize;
        let allowed = TIMES_HONEST * honest_scene_peak(length) + ((1 << 14) * kept) as f64;
        println!(
            "{name}: {peak} bytes of heap ({:.2} of what is allowed), {seconds:.2} s",
            peak as f64 / allowed
        );
        assert!(
            (peak as f64) < allowed,
            "{name}: {peak} bytes of heap, {allowed} are allowed"
        );
    }
}
