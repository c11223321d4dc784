//! Glass that is next to nothing, dense glass, and bubbles.

use std::f64::consts::{SQRT_2, TAU};

use nephroid::internals::numeric::distributions::critical_value;
use nephroid::internals::reference::closed_form::GlassBall;

use super::shells::{FLOOR, HALF, SIDE, Shells, TRIED, added, lamp, rays, reflected, sum, truth};
use crate::support::extremes::{
    ORACLE, assert_as_asked, beams, error_as_asked, judged, layer, photons, red, scene, specular,
};

/// The probability that a right program fails the test of photons below.
const RISK: f64 = 1e-4;

/// E of a ball of index 1 + x is that of no ball, by a smooth function of x: both are closed forms of the
/// light through it, and all other light is next to nothing (LRD) or does not change (LD).
///
/// Flux that the ball reflects: near grazing incidence, c² = 2x sinh² t, F is e^(−4t), and ∫ F 2c dc = 2x ∫
/// e^(−4t) sinh 2t dt = x/3 of light that falls evenly on its cross-section. Of a ball less dense than its
/// surroundings, light is reflected totally up to c² = 2|x|, which is 2|x| more. The lamp is near, so that
/// the ball's rim has 1/cos θ = 1.083 times as much as that.
///
/// Light is reflected where it enters and where it leaves; the rest lands on the receiver, all of it: it is
/// turned by 2√(2|x|) at most, which is 1.6° here. So all light differs from that without a ball by twice
/// that part of what falls on the ball, less what of the reflected lands there, too. That is a ring about the
/// shadow, of radius 5/3, of which a texel has no more than its diagonal.
#[test]
fn glass_that_is_next_to_nothing_changes_next_to_nothing() {
    println!(
        "ball of index 1 + x: of LTTD by beams asked for 1e-3, worst texel and root mean square error; how far the truth of all light is out of their \
         bounds; all light / that of no ball − 1, by beams, by photons and their standard error; rays that land: how many, worst landing, of what is allowed"
    );
    let nothing = scene(&(lamp() + FLOOR), None, SIDE);
    let nothing = red(&beams(&nothing, 1e-3, 2).total);
    let straight = truth(&Shells::ball(1.0, 1.0));
    let indices = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 0.0, -1e-12, -1e-6];
    let errors = critical_value(1.0 - RISK / indices.len() as f64, 31.0);
    let texels = nothing.len() as f64;
    for x in indices {
        let shells = Shells::ball(1.0, 1.0 + x);
        let by_beams = beams(&shells.scene(SIDE), 1e-3, 2);
        let through = truth(&shells);
        let name = format!("{x:e}");
        let [off, error] = assert_as_asked(&name, &by_beams, "LTTD", &through, 1e-3);
        let all: Vec<f64> = (0..nothing.len())
            .map(|texel| nothing[texel] + (through[texel] - straight[texel]))
            .collect();
        let (all_missed, _) = judged(&by_beams.total, &all);
        let reflected = 1.083 * x.abs() / 3.0 * if x > 0.0 { 1.0 } else { 7.0 };
        let on_ball = GlassBall::SHIPPED.intercepted_flux();
        let texel = 2.0 * HALF / SIDE as f64;
        let in_texel = reflected * on_ball * (SQRT_2 * texel) / (TAU * 5.0 / 3.0);
        let brightest = all.iter().copied().fold(0.0, f64::max) * (texel * texel);
        // Beams do not follow so little.
        assert!(
            all_missed <= ORACLE + in_texel / brightest,
            "{x:e}: {all_missed:e}"
        );

        // On one texel, photons' standard error is that of the flux. Direct light is by quadrature, on small
        // texels, with a bound.
        let by_photons = photons(&shells.scene(1), 1 << 17, 2);
        let [caught] = specular(&by_photons)[..] else {
            panic!("one texel");
        };
        let direct = layer(&by_beams, "LD").expect("direct light");
        let bounds = direct.interval.as_ref().expect("beams have bounds");
        let bar = |texel: usize| bounds.high[texel].0[0] - direct.values[texel].0[0];
        let bars = (0..nothing.len()).map(bar).sum::<f64>() / texels;
        let standard_error = caught * by_photons.relative_error.expect("light on the receiver");
        let without = sum(&nothing) / texels;
        let change = sum(&red(direct)) / texels + caught - without;
        let reflected = 2.0 * reflected * on_ball / (2.0 * HALF).powi(2);
        assert!(
            change.abs() <= errors * standard_error + bars + reflected,
            "{x:e}: {change:e} ± {standard_error:e}, {bars:e}, {reflected:e}"
        );
        // Neither is so wide that anything would do: direct light's bounds hide nothing of what photons tell,
        // and those are no worse than points drawn at random, of which a share of p has a variance of (1 −
        // p)/(p n). 32 replicates make 1.6 times as much of the true standard error with a probability of
        // 4e-6.
        assert!(bars <= standard_error, "{x:e}: {bars:e}");
        let share = caught * (2.0 * HALF).powi(2) / by_photons.ledger.emitted.0[0];
        let random = caught * ((1.0 - share) / (share * by_photons.paths as f64)).sqrt();
        assert!(standard_error <= 1.6 * random, "{x:e}: {standard_error:e}");
        let rays = rays(&shells, 0.99, TRIED);
        println!(
            "  {x:+.0e}: {off:.1e}, {error:.1e}; {all_missed:.1e}; {:+.1e}, {:+.1e} ± {:.1e}; {}, {:.1e}, {:.2}",
            sum(&red(&by_beams.total)) / sum(&nothing) - 1.0,
            change / without,
            standard_error / without,
            rays.followed,
            rays.place,
            rays.of_allowed,
        );
    }
}

#[test]
fn dense_glass_and_bubbles_are_as_the_closed_form_has_them() {
    println!(
        "ball by its index inside and outside: of LTTD by beams asked for 1e-2, worst texel, and root mean square error of it, of LRD and of both, relative to both; rays that \
         land: how many, worst landing, worst flux, of what is allowed"
    );
    // The more light is bent, the more of it leaves by the receiver's side or upward.
    for (outside, inside, landed) in [
        (1.0, 1.5, TRIED),
        (1.0, 2.418, 50),
        (1.0, 10.0, 40),
        (1.0, 15.0, 40),
        // Here F's valley at Brewster's angle lies between the nodes of a coarse run.
        (1.0, 24.0, 40),
        (1.0, 27.0, 40),
        (1.0, 30.0, 40),
        (1.0, 33.0, 40),
        (1.0, 100.0, 40),
        (1.0, 0.99, TRIED),
        (1.33, 1.0, 40),
        (1.5, 1.0, 40),
        (100.0, 1.0, 25),
    ] {
        let shells = Shells::ball(outside, inside);
        let rays = rays(&shells, 0.99, landed);
        let found = beams(&shells.scene(SIDE), 1e-2, 2);
        let name = format!("{inside} in {outside}");
        let (through, reflected) = (truth(&shells), reflected(&shells));
        let [_, of_reflected] = assert_as_asked(&name, &found, "LRD", &reflected, 1e-2);
        let of_through = if layer(&found, "LTTD").is_some() {
            let [off, error] = assert_as_asked(&name, &found, "LTTD", &through, 1e-2);
            format!("{off:.1e}, {error:.1e}")
        } else {
            // A bubble in an index of 100 lets 3e-7 of the light pass: less than beams follow.
            assert_eq!(outside, 100.0);
            "not followed".to_owned()
        };
        let both = error_as_asked(&found, &added(&through, &reflected), &specular(&found));
        assert!(both <= 1e-2, "{name}: {both:e}");
        println!(
            "  {name}: {of_through}, {of_reflected:.1e}, {both:.1e}; {}, {:.1e}, {:.1e}, {:.2}",
            rays.followed, rays.place, rays.flux, rays.of_allowed
        );
    }
}
