//! Direct light of the square lamp, and the shadow of the ball in it.

use glam::{DVec2, DVec3};
use nephroid::internals::reference::closed_form::{TexelGrid, lambert_irradiance};

use super::bars::{ALPHA, COMPARISONS};
use crate::support::scenes::layer;
use crate::support::{Compared, Photons, bundled, student};

/// Direct light of a square lamp is Lambert's formula wherever the ball cannot stand between: where, as seen
/// from the floor, the cones round the lamp and round the ball are apart.
///
/// The formula is averaged over each texel by 2 x 2 Gauss points, which err by (size/distance)⁴/100 < 1e-9.
/// 16 replicates give each texel's error bar: 15 degrees of freedom.
#[test]
fn the_square_lamps_direct_light_is_lamberts() {
    const SIDE: usize = 64;
    const GAUSS: f64 = 0.288_675_134_594_812_9;
    let scene = bundled("cornell-glass", SIDE);
    let photons = Photons::new(64);
    let estimate = photons.estimate(&scene);
    // Facing down: counter-clockwise as seen from below.
    let corner = |x: f64, y: f64| DVec3::new(0.25 * x, 0.25 * y, 1.98);
    let lamp = [
        corner(-1.0, -1.0),
        corner(-1.0, 1.0),
        corner(1.0, 1.0),
        corner(1.0, -1.0),
    ];
    let lamp_radius = 0.25 * 2.0_f64.sqrt();
    let is_clear = |point: DVec3| {
        let to_lamp = DVec3::new(0.0, 0.0, 1.98) - point;
        let to_ball = DVec3::new(0.3, -0.2, 0.45) - point;
        let cones =
            (lamp_radius / to_lamp.length()).asin() + (0.4 / to_ball.length()).min(1.0).asin();
        to_lamp.angle_between(to_ball) > cones
    };
    let grid = TexelGrid::square(1.0, SIDE);
    let truth = grid.map(|texel| {
        let (middle, size) = (0.5 * (texel.min + texel.max), texel.max - texel.min);
        let points = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
            .map(|(x, y)| (middle + size * DVec2::new(x, y) * GAUSS).extend(0.0));
        let corners = [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)]
            .map(|(x, y)| (middle + size * DVec2::new(x, y)).extend(0.0));
        if corners.iter().all(|corner| is_clear(*corner)) {
            points
                .iter()
                .map(|&point| 0.25 * lambert_irradiance(point, DVec3::Z, &lamp, 40.0))
                .sum()
        } else {
            0.0
        }
    });
    let mut it = Compared::new(&scene, &photons, &estimate, "LD", &truth);
    it.freedom = 15;
    it.replicates = 16.0;
    it.name
        .push_str(" (whose error is a bound where the lamp is small and unhidden)");
    // Every texel gets 8 samples of each replicate, whatever falls into it: only where the closed form is
    // not known is nothing judged. Smooth over texel and lamp, they are nearly normal.
    it.photons = truth
        .iter()
        .map(|value| if *value > 0.0 { f64::INFINITY } else { 0.0 })
        .collect();
    println!("{}: {:?}", it.name, it.agreement());
    it.assert_regions(2000);
}

/// In the ball's shadow the lamp's light is a sum over the part of the lamp that a point sees: of those rays
/// that pass the ball's centre at more than its radius.
///
/// 100 x 100 points of the lamp at 2 x 2 Gauss points of the texel. The border of the visible part crosses at
/// most 2 · 100 of 100² cells, so each sum is known to a fiftieth of the whole lamp's light.
///
/// A texel has 128 samples: where a few hundredths of the lamp are hidden, or visible, often none of them
/// tells, and its error bar is of no use. So texels are judged together, by the share h of the lamp that is
/// hidden from them: the variance of their sum is at most that of independent samples, whole² h (1 − h)/128
/// each (and 2 % of it where nothing is hidden, for the lamp's own shading).
#[test]
fn the_square_lamps_light_fades_into_the_balls_shadow() {
    const SIDE: usize = 64;
    const CUTS: usize = 100;
    const GAUSS: f64 = 0.288_675_134_594_812_9;
    let scene = bundled("cornell-glass", SIDE);
    let photons = Photons::new(64);
    let estimate = photons.estimate(&scene);
    let (ball, radius) = (DVec3::new(0.3, -0.2, 0.45), 0.4);
    let lamp = TexelGrid::square(0.25, CUTS);
    // The whole lamp's and the visible part's.
    let irradiance = |point: DVec3| {
        let mut sums = DVec2::ZERO;
        for i in 0..CUTS * CUTS {
            let cell = lamp.texel(i % CUTS, i / CUTS);
            let offset = (0.5 * (cell.min + cell.max)).extend(1.98) - point;
            let squared = offset.length_squared();
            let value = 40.0 * offset.z * offset.z / (squared * squared) * cell.area();
            let to_ball = ball - point;
            let is_hidden = to_ball.cross(offset).length_squared() < radius * radius * squared;
            sums += DVec2::new(value, if is_hidden { 0.0 } else { value });
        }
        sums
    };
    let grid = TexelGrid::square(1.0, SIDE);
    let average = |texel: &nephroid::internals::reference::closed_form::TexelRect| {
        let (middle, size) = (0.5 * (texel.min + texel.max), texel.max - texel.min);
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
            .map(|(x, y)| irradiance((middle + size * DVec2::new(x, y) * GAUSS).extend(0.0)) * 0.25)
            .into_iter()
            .sum::<DVec2>()
    };
    let known: std::sync::Mutex<Vec<(DVec2, DVec2)>> = std::sync::Mutex::default();
    grid.map(|texel| {
        known.lock().unwrap().push((texel.min, average(texel)));
        0.0
    });
    let (values, _) = layer(&estimate, "LD", 0);
    // From (nearly) nothing hidden to all.
    for (from, to) in [(0.002, 0.1), (0.1, 0.25), (0.25, 0.75), (0.75, 0.998)] {
        let (mut off, mut variance, mut unknown, mut texels) = (0.0, 0.0, 0.0, 0);
        for (min, sums) in known.lock().unwrap().iter() {
            let hidden = 1.0 - sums.y / sums.x;
            if !(from..to).contains(&hidden) {
                continue;
            }
            let index = |along: f64| ((along + 1.0) * SIDE as f64 / 2.0).round() as usize;
            off += values[index(min.y) * SIDE + index(min.x)] - sums.y;
            variance += sums.x * sums.x * (hidden * (1.0 - hidden) + 0.02) / 128.0;
            unknown += 0.02 * sums.x;
            texels += 1;
        }
        let allowed = student::normal_quantile(ALPHA / COMPARISONS as f64) * variance.sqrt();
        println!(
            "hidden {from}..{to}: {texels} texels, off {off:.3}, allowed {allowed:.3} + {unknown:.3}"
        );
        assert!(texels >= 15, "{texels}");
        assert!(
            off.abs() <= allowed + unknown,
            "hidden {from}..{to}: {off} on {texels} texels, allowed {allowed} + {unknown}"
        );
    }
}
