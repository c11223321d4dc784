//! The errors that closed forms claim: a texel and the mean of its four quarters are two quadratures of the
//! same light.

use nephroid::internals::run::Estimate;
use nephroid::internals::run::LayerName;
use nephroid::internals::scene::Scene;

use crate::support::oracles::PANE;
use crate::support::recognised::{edited, known, layer_of, of_text};

/// Asserts that every texel is the mean of its quarters, within both errors.
fn assert_quarters_agree(name: &str, scene: impl Fn([u32; 2]) -> Scene, depth: u32) {
    // Odd: the axis is in the middle of a texel, and on a corner of the quarters.
    for size in [[16, 12], [15, 11]] {
        let whole = known(&scene(size), depth);
        let quarters = known(&scene(size.map(|side| 2 * side)), depth);
        let worst = worst_of_claimed(&whole, &quarters);
        println!("{name} {size:?}: {worst:.2e} of the claimed error");
        assert!(worst <= 1.0, "{name} {size:?}: {worst}");
    }
}

/// The largest difference over what both claim.
fn worst_of_claimed(whole: &Estimate, quarters: &Estimate) -> f64 {
    let mut worst: f64 = 0.0;
    for layer in &whole.layers {
        let LayerName::Path(signature) = layer.name else {
            unreachable!("one path each");
        };
        let fine = layer_of(quarters, signature).unwrap();
        let bounds = [layer, fine].map(|layer| layer.interval.as_ref().unwrap());
        for texel in 0..layer.values.len() {
            let (column, row) = (texel % whole.width, texel / whole.width);
            let corner = 2 * row * quarters.width + 2 * column;
            let four = [0, 1, quarters.width, quarters.width + 1].map(|step| corner + step);
            let mean = |of: &dyn Fn(usize) -> f64| 0.25 * four.map(of).iter().sum::<f64>();
            let off = layer.values[texel].0[0] - mean(&|at| fine.values[at].0[0]);
            let claimed = bounds[0].high[texel].0[0] - layer.values[texel].0[0]
                + mean(&|at| bounds[1].high[at].0[0] - fine.values[at].0[0]);
            if off != 0.0 {
                worst = worst.max(off.abs() / claimed);
            }
        }
    }
    worst
}

#[test]
fn balls_keep_their_error() {
    assert_quarters_agree("glass-ball", |size| edited("glass-ball", &[], size), 16);
    // The least index that is taken, and a dense ball near the floor.
    for ior in ["1.05", "2.4"] {
        let changes = [
            (r#"value="1.5""#, &*format!(r#"value="{ior}""#)),
            (r#"z="1.4""#, r#"z="1.01""#),
        ];
        assert_quarters_agree(ior, |size| edited("glass-ball", &changes, size), 8);
    }
}

#[test]
fn cups_keep_their_error() {
    assert_quarters_agree("coffee-cup", |size| edited("coffee-cup", &[], size), 4);
    assert_quarters_agree("mirror-ring", |size| edited("mirror-ring", &[], size), 4);
    let within = [(r#"x="-1" y="0" z="1""#, r#"x="0" y="-0.4" z="1.3""#)];
    assert_quarters_agree("within", |size| edited("mirror-ring", &within, size), 4);
}

#[test]
fn solids_keep_their_error() {
    assert_quarters_agree("cube", |size| edited("cube", &[], size), 8);
    assert_quarters_agree("prism", |size| edited("prism", &[], size), 8);
}

#[test]
fn panes_and_lights_alone_keep_their_error() {
    assert_quarters_agree("pane", |size| of_text(PANE, size), 6);
    let alone = |light: &str, size| {
        let receiver = PANE.rfind(r#"<shape type="rectangle">"#).unwrap();
        of_text(
            &format!("<scene version=\"3.0.0\">{light}{}", &PANE[receiver..]),
            size,
        )
    };
    for light in [
        r#"<emitter type="point"><point name="position" x="0.4" y="-0.7" z="0.3"/></emitter>"#,
        r#"<emitter type="spot"><transform name="to_world">
           <lookat origin="0, 0, 0.8" target="0, 0, 0" up="0, 1, 0"/></transform>
           <float name="cutoff_angle" value="30"/><float name="beam_width" value="18"/></emitter>"#,
        r#"<shape type="rectangle"><transform name="to_world"><scale x="0.3" y="0.2"/>
           <rotate x="1" angle="176"/><translate x="0.3" y="-0.4" z="0.3"/></transform>
           <emitter type="area"/></shape>"#,
    ] {
        assert_quarters_agree(&light[..24], |size| alone(light, size), 0);
    }
}
