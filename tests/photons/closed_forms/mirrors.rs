//! Light off mirrors: the cup, the ring, the dish.

use nephroid::internals::reference::closed_form::{CupLight, KnownPath, MirrorCup, TexelGrid};

use super::bars::STREAMS;
use crate::support::oracles::dish_fluxes;
use crate::support::{Compared, Photons, bundled};

/// The scene `coffee-cup`.
const CUP: MirrorCup = MirrorCup {
    radius: 4.0,
    height: 8.0,
    reflectance: 1.0,
    light: CupLight::Parallel {
        tan_angle: 0.6,
        irradiance: 1000.0,
    },
};

/// The scene `mirror-ring`.
const RING: MirrorCup = MirrorCup {
    radius: 1.0,
    height: 0.6,
    reflectance: 1.0,
    light: CupLight::Point {
        distance: 1.0,
        height: 1.0,
        intensity: 10.0,
    },
};

/// Seen from above a ray in an upright mirror cylinder is a billiard in a circle; what each region cuts out
/// of each reflected chord adds up to its flux. Known to 1e-8 of the bare bottom's irradiance.
fn assert_cup_agrees(name: &str, cup: &MirrorCup, half_width: f64, bare: f64, side: usize) {
    let scene = bundled(name, side);
    let grid = TexelGrid::square(half_width, side);
    for stream in STREAMS {
        let photons = Photons::new(1 << 20).stream(stream);
        let estimate = photons.estimate(&scene);
        for reflections in [1, 2] {
            let path = KnownPath::Reflected(reflections);
            let it = Compared::new(
                &scene,
                &photons,
                &estimate,
                &path.signature(),
                &cup.map(path, &grid),
            )
            .known_to(1e-8 * bare);
            println!("{stream:?} {} {side}: {:?}", it.name, it.agreement());
            if side == 1 {
                it.assert_regions(1);
            } else if reflections == 1 {
                it.assert_texels(80);
            } else {
                it.assert_regions(5);
            }
        }
    }
}

/// LRD is the nephroid's sheet, LRRD the one with its caustic at three quarters of R cos φ.
#[test]
fn the_coffee_cups_nephroid_is_right_in_every_texel() {
    assert_cup_agrees("coffee-cup", &CUP, 4.0, 1000.0, 1);
    assert_cup_agrees("coffee-cup", &CUP, 4.0, 1000.0, 20);
}

/// LRD is the cardioid's sheet of a lamp above the ring's edge.
#[test]
fn the_mirror_rings_cardioid_is_right_in_every_texel() {
    assert_cup_agrees("mirror-ring", &RING, 2.0, 10.0, 1);
    assert_cup_agrees("mirror-ring", &RING, 2.0, 10.0, 32);
}

/// The flux on the receiver is that of the whole dish's paraboloid, without the square that the receiver
/// shades, and without the slivers between the mesh's rim, a polygon of 6 · 28 corners, and the circle. Each
/// channel has its own metal.
///
/// The mesh's interpolated normals err by less than 1e-4 rad, over which the reflectance
/// changes by less than 1e-6; all light still lands well within the receiver (at most 0.067 of 0.08 m).
#[test]
fn the_dish_gathers_its_apertures_flux_in_every_channel() {
    let scene = bundled("parabolic-mirror", 1);
    let photons = Photons::new(1 << 20);
    let estimate = photons.estimate(&scene);
    for (channel, flux) in dish_fluxes().into_iter().enumerate() {
        let truth = [flux / 0.0256];
        let it = Compared::channel(&scene, &photons, &estimate, "LRD", channel, &truth)
            .known_to(1e-6 * truth[0]);
        println!("{}: {:?}", it.name, it.agreement());
        it.assert_regions(1);
    }
}
