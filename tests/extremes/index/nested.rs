//! Balls in balls, and films with next to nothing between their faces.

use super::shells::{SIDE, Shells, TRIED, rays, reflected, sum, truth};
use crate::support::extremes::{U, assert_as_asked, beams, layer, red, specular};

#[test]
fn balls_in_balls_bend_rays_as_bouguer_says() {
    println!(
        "balls in balls: rays that land: how many, worst landing, worst flux, of what is allowed"
    );
    for depth in 1..=8_usize {
        let shells = Shells {
            radii: (0..depth).map(|i| 1.0 - 0.1 * i as f64).collect(),
            indices: std::iter::once(1.0)
                .chain((0..depth).map(|i| [1.5, 1.33, 1.7, 1.2][i % 4]))
                .collect(),
        };
        let rays = rays(&shells, 0.95, TRIED);
        println!(
            "  {depth}: {}, {:.1e}, {:.1e}, {:.2}",
            rays.followed, rays.place, rays.flux, rays.of_allowed
        );
    }
}

/// Four deep, every second index far from its neighbours' and each surface reflecting; eight deep,
/// `LTTTTTTTTTTTTTTTTD`. All light that enters gets through: n r is nowhere less than 1. What is reflected on
/// the way in or out has other signatures.
#[test]
fn beams_through_balls_in_balls_are_as_bouguer_says() {
    println!(
        "balls in balls, all surfaces passed: of beams asked for 1e-2, worst texel and root mean square error; share of all specular light"
    );
    let [alternating, glassy]: [&[f64]; 2] = [
        &[1.0, 1.5, 1.33, 1.7, 1.2],
        &[1.0, 1.5, 1.4, 1.5, 1.4, 1.5, 1.4, 1.5, 1.4],
    ];
    for (indices, step) in [(alternating, 0.05), (glassy, 0.03)] {
        let depth = indices.len() - 1;
        let shells = Shells {
            radii: (0..depth).map(|i| 1.0 - step * i as f64).collect(),
            indices: indices.to_vec(),
        };
        assert_eq!(shells.widest_sin(), 1.0);
        let found = beams(&shells.scene(SIDE), 1e-2, 2 * depth as u32);
        let (signature, through) = (shells.signature(), truth(&shells));
        let name = format!("{depth} deep");
        let [off, error] = assert_as_asked(&name, &found, &signature, &through, 1e-2);
        assert_as_asked(&name, &found, "LRD", &reflected(&shells), 1e-2);
        let share = sum(&through) / sum(&specular(&found));
        println!("  {name}: {off:.1e}, {error:.1e}; {share:.3}");
        assert!(share > 0.9, "{name}: {share}");
    }
}

/// Water on a glass ball, the gap between their surfaces thick.
pub fn film(gap: f64) -> Shells {
    Shells {
        radii: vec![1.0, 1.0 - gap],
        indices: vec![1.0, 1.33, 1.5],
    }
}

/// A ray starts up to 32 u off a surface of radius 1 (16 u, and the step outward), and meets what is farther
/// off than that.
#[test]
fn a_film_however_thin_is_not_stepped_over() {
    println!(
        "film on a ball: rays that land: how many, worst landing, worst flux, of what is allowed"
    );
    for gap in [1e-1, 1e-3, 4e-5, 1e-7, 1e-9, 1e-11, 1e-13, 64.0 * U] {
        let rays = rays(&film(gap), 0.95, TRIED);
        println!(
            "  {gap:.0e}: {}, {:.1e}, {:.1e}, {:.2}",
            rays.followed, rays.place, rays.flux, rays.of_allowed
        );
    }
}

/// Beams look for the surface that light meets first: however near the inner ball is behind the outer, it is
/// not that.
#[test]
fn light_meets_the_film_first_and_then_the_ball() {
    println!(
        "film on a ball, LTTTTD: beams asked for 1e-2, worst texel and root mean square error"
    );
    for gap in [1e-1, 1e-3, 4e-5, 1e-7, 1e-10, 1e-12] {
        let shells = film(gap);
        let found = beams(&shells.scene(SIDE), 1e-2, 4);
        let name = format!("{gap:e}");
        let [off, error] = assert_as_asked(&name, &found, "LTTTTD", &truth(&shells), 1e-2);
        println!("  {gap:.0e}: {off:.1e}, {error:.1e}");
        // In water no ray passes farther than 1/1.33 from the centre: each meets the glass. And none meets
        // the glass first.
        for wrong in ["LTTD", "LTTTD"] {
            assert!(
                layer(&found, wrong).is_none_or(|layer| red(layer).iter().all(|e| *e == 0.0)),
                "{gap:e}: light by way of some of four surfaces, {wrong}"
            );
        }
    }
}
