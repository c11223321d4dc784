//! Stage `splat`, by photon density: maps of several finenesses, of which each texel takes what has enough
//! photons.

use glam::DVec2;

use super::splat::{Photon, Spread, draw, filtered};
use super::variants::Kernel;
use super::work::Work;
use crate::approximation::bands::{Band, in_bands, reach};
use crate::radiometry::Rgb;

/// A map whose texels are chosen among several.
pub struct Chosen {
    /// Flux \[W\] by texel.
    pub map: Vec<Rgb>,
    /// Flux \[W\] on the finest of them: what photons brought.
    pub drawn: Rgb,
    /// What was done.
    pub work: Work,
}

/// Diameters of the four splats of section 4.1, in texels.
pub const DIAMETERS: [f64; 4] = [3.0, 7.0, 11.0, 15.0];

/// Photons of a splat up to which it is not used, and from which on it is used alone (section 4.1).
const FEW: f64 = 8.0;
const MANY: f64 = 16.0;

/// A texel of the two maps of section 4.1.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    /// Flux \[W\] by each splat.
    flux: [Rgb; 4],
    /// Photons whose splat holds the texel.
    count: [u32; 4],
}

/// Multi-resolution splatting (section 4.1): flux \[W\] by texel.
///
/// Each photon is drawn once, as one point of 15 texels with four Gaussians in it, and counted in the texels
/// that each of the four circles holds. Then each texel is put together from its finest splat with more than
/// 8 photons and the next two coarser: from coarse to fine, where the finer one is brighter,
///
/// ```text
/// E ← E + b(c) (Eᵢ − E),   b(c) = 3t² − 2t³,   t = (c − 8) / (16 − 8) in 0..=1
/// ```
///
/// b being the sum of the two upper cubic Bernstein polynomials. (The report says "a Bernstein interpolant"
/// and "normalized based on the number of splats weighted", not which.)
pub fn multi_resolution(side: usize, photons: &[Photon], kernel: Kernel) -> Chosen {
    let largest = DIAMETERS[3];
    let (cells, fragments) = in_bands(
        [side; 2],
        photons,
        |photon| reach(photon.at.y, largest),
        |photon: &Photon, band| {
            let before = band.fragments;
            for (index, diameter) in DIAMETERS.into_iter().enumerate() {
                // One point holds all four: its fragments are those of the largest, drawn last.
                band.fragments = before;
                stamp(photon, (index, diameter), kernel, band);
            }
        },
    );
    let work = Work {
        splats: photons.len() as u64,
        fragments,
        // Two maps of four channels, each read once more.
        bytes: (cells.len() * 2 * 4 * 4) as u64,
        fetches: 2 * cells.len() as u64,
        ..Work::default()
    };
    Chosen {
        map: cells.iter().map(combined).collect(),
        drawn: cells.iter().map(|cell| cell.flux[0]).sum(),
        work,
    }
}

fn stamp(photon: &Photon, (index, diameter): (usize, f64), kernel: Kernel, band: &mut Band<Cell>) {
    match kernel {
        Kernel::Gaussian => {
            band.draw_round(photon.at, diameter, |cell, weight, [column, row]| {
                cell.flux[index] += photon.flux * weight;
                let center = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                let is_inside = center.distance_squared(photon.at) <= 0.25 * diameter * diameter;
                cell.count[index] += u32::from(is_inside);
            });
        }
        Kernel::Wyman2008 => filtered(photon.at, diameter, |weight, [column, row]| {
            if let Some(cell) = band.texel(column, row) {
                cell.flux[index] += photon.flux * weight;
                cell.count[index] += 1;
                band.fragments += 1;
            }
        }),
    }
}

fn combined(cell: &Cell) -> Rgb {
    let weight = |index: usize| {
        let t = ((f64::from(cell.count[index]) - FEW) / (MANY - FEW)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    let finest = (0..3).find(|&index| weight(index) > 0.0).unwrap_or(3);
    let coarsest = (finest + 2).min(3);
    let mut sum = cell.flux[coarsest];
    for index in (finest..coarsest).rev() {
        let finer = cell.flux[index];
        if finer.mean() > sum.mean() {
            sum += (finer - sum) * weight(index);
        }
    }
    sum
}

/// One level of a chain of maps: flux \[W\] and photons by texel. Level k has texels of 2ᵏ x 2ᵏ of the finest
/// map's, those at the far borders perhaps a part of them.
struct Level {
    side: usize,
    flux: Vec<Rgb>,
    count: Vec<u32>,
}

impl Level {
    /// Photons counted and dealt out to single texels.
    fn of_points(side: usize, photons: &[Photon]) -> (Self, Work) {
        let (cells, fragments) = in_bands(
            [side; 2],
            photons,
            |photon| reach(photon.at.y, 0.0),
            |photon: &Photon, band: &mut Band<(Rgb, u32)>| {
                let (column, row) = (photon.at.x.floor() as i64, photon.at.y.floor() as i64);
                if let Some((flux, count)) = band.texel(column, row) {
                    *flux += photon.flux;
                    *count += 1;
                    band.fragments += 1;
                }
            },
        );
        let work = Work {
            splats: photons.len() as u64,
            fragments,
            bytes: (cells.len() * 16) as u64,
            ..Work::default()
        };
        let (flux, count) = cells.into_iter().unzip();
        (Self { side, flux, count }, work)
    }

    /// Four texels of this level summed into one; the last of an odd number stands alone.
    fn coarser(&self) -> Self {
        let side = self.side.div_ceil(2);
        let mut level = Self {
            side,
            flux: vec![Rgb::BLACK; side * side],
            count: vec![0; side * side],
        };
        for row in 0..self.side {
            for column in 0..self.side {
                let (from, to) = (row * self.side + column, row / 2 * side + column / 2);
                level.flux[to] += self.flux[from];
                level.count[to] += self.count[from];
            }
        }
        level
    }
}

/// Mipmapping by density (section 4): flux \[W\] by texel, each from the finest level of a chain of
/// box-filtered maps at which its texel has `dense` photons.
pub fn mip(side: usize, photons: &[Photon], dense: u32) -> Chosen {
    let (base, mut work) = Level::of_points(side, photons);
    let mut levels = vec![base];
    while let Some(last) = levels.last().filter(|last| last.side > 1) {
        let next = last.coarser();
        work.bytes += (next.flux.len() * 16) as u64;
        levels.push(next);
    }
    chosen(&levels, dense, work)
}

/// Photons splatted into every level of a chain of maps, as Gaussians of 3 texels of that level (section 4,
/// figure 4): flux \[W\] by texel, each from the finest level at which its texel has `dense` photons.
pub fn mip_splat(side: usize, photons: &[Photon], dense: u32) -> Chosen {
    let mut work = Work::default();
    let mut levels = Vec::new();
    let (mut level_side, mut scale) = (side, 1.0);
    loop {
        let moved: Vec<Photon> = photons
            .iter()
            .map(|photon| Photon {
                at: photon.at * scale,
                flux: photon.flux,
                spread: Spread::Round(DIAMETERS[0]),
            })
            .collect();
        let (points, _) = Level::of_points(level_side, &moved);
        let (flux, done) = draw(level_side, &moved, Kernel::Gaussian);
        work += done;
        levels.push(Level { flux, ..points });
        if level_side == 1 {
            break;
        }
        level_side = level_side.div_ceil(2);
        scale *= 0.5;
    }
    chosen(&levels, dense, work)
}

/// Each texel from the finest level that has `dense` photons there, or else the coarsest: a coarser texel's
/// flux by the number of texels that it stands for.
fn chosen(levels: &[Level], dense: u32, mut work: Work) -> Chosen {
    let side = levels.first().map_or(0, |finest| finest.side);
    let mut map = Vec::with_capacity(side * side);
    for row in 0..side {
        for column in 0..side {
            let mut value = Rgb::BLACK;
            for (index, level) in levels.iter().enumerate() {
                let texel = (row >> index) * level.side + (column >> index);
                // What is beyond the map's border is no part of a coarse texel.
                let covered =
                    |at: usize| ((((at >> index) + 1) << index).min(side)) - (at >> index << index);
                work.fetches += 1;
                value = level.flux[texel] / (covered(row) * covered(column)) as f64;
                if level.count[texel] >= dense {
                    break;
                }
            }
            map.push(value);
        }
    }
    let finest = levels
        .first()
        .map(|finest| finest.flux.iter().copied().sum());
    Chosen {
        map,
        drawn: finest.unwrap_or_default(),
        work,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mipmapping_keeps_all_flux_whatever_the_level_and_the_side() {
        // A lattice that has nothing to do with texels.
        let photons = |side: usize| -> Vec<Photon> {
            (0..500)
                .map(|index| Photon {
                    at: (DVec2::new(0.618_034, 0.754_878) * f64::from(index)).fract() * side as f64,
                    flux: Rgb::grey(1.0 + f64::from(index % 3)),
                    spread: Spread::Round(1.0),
                })
                .collect()
        };
        for side in [1, 2, 37, 64] {
            let photons = photons(side);
            let sent: f64 = photons.iter().map(|photon| photon.flux.mean()).sum();
            for dense in [1, u32::MAX] {
                let Chosen { map, .. } = mip(side, &photons, dense);
                let found: f64 = map.iter().map(|texel| texel.mean()).sum();
                // Where levels are mixed, light of a coarse texel is also in its finer neighbours: only one
                // level keeps it.
                if dense == u32::MAX {
                    // A few thousand additions of positive numbers.
                    assert!((found / sent - 1.0).abs() < 1e-12, "{side}: {found} {sent}");
                } else {
                    assert!(found >= sent * (1.0 - 1e-12), "{side}: {found} {sent}");
                }
            }
        }
    }

    #[test]
    fn the_interpolant_takes_the_finest_splat_with_many_photons_and_only_if_it_is_brighter() {
        let cell = |count: [u32; 4], flux: [f64; 4]| {
            combined(&Cell {
                flux: flux.map(Rgb::grey),
                count,
            })
            .mean()
        };
        let falling = [8.0, 4.0, 2.0, 1.0];
        assert_eq!(cell([16, 20, 30, 40], falling), 8.0);
        assert_eq!(cell([8, 16, 30, 40], falling), 4.0);
        assert_eq!(cell([0, 0, 0, 3], falling), 1.0);
        // Half way between 8 and 16 photons the interpolant is 1/2.
        assert_eq!(cell([12, 20, 30, 40], falling), 6.0);
        // Darker splats are left out.
        assert_eq!(cell([16, 20, 30, 40], [1.0, 2.0, 4.0, 8.0]), 4.0);
    }
}
