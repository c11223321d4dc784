//! The signatures that are followed, and a bound on the light of the others.
//!
//! Each signature costs work before it tells anything: a ray for each of its first surfaces. Signatures that
//! are too faint to matter are not followed. Let φ be the flux of such light by texel. Its error, if it is
//! left out, is √(Σ φ²). The discovery's paths tell it: of two paths in one bin, each stands for flux w on
//! the same b texels, so
//!
//! ```text
//! Σ φ² ≥ Σ over bins (Σ w)² / b,  less the paths' own squares
//! ```
//!
//! If that light is spread evenly over n texels, an error e relative to their mean is Σ φ² = (e Φ)² / n.
//!
//! The faintest are left out while the sum of all Σ φ² is a small part of the error asked for, squared, and
//! their flux a small part of all. What they may bring to a texel is in the upper bound of every texel.
//!
//! Of some signatures no path fell on the film, only beside it. So few paths do not show that none of their
//! light is there: all of it may be. If that is more than the same small part, they are followed, too. Their
//! cells show what is there.

use glam::DVec2;

use super::discovery::{Landing, SignatureLight};
use crate::transport::signature::Signature;

/// Part of the error asked for that light may have which is not followed, in flux and by texel. What is
/// followed must then be better by 3 % of that error ([`left`]). With a tenth, a glass ball at 0.1 % spends
/// 85 % of its work on light that adds 1e-5 to the error.
const PART: f64 = 0.25;

/// The largest number of signatures that are followed.
const MOST_SIGNATURES: usize = 256;

/// Mean number of paths in a part of the film that tell whether it is lit: of evenly spread light, e⁻⁴ = 2 %
/// of the parts have none. A film has four parts at least.
const TELLING: usize = 4;

/// Bins a side of the film, coarse to fine, in which paths are counted.
const BINS: [usize; 4] = [1, 4, 16, 64];

/// Factor of the largest density of paths that bounds what a texel gets: light is not spread evenly within a
/// bin, and the paths are few.
pub const MARGIN: f64 = 4.0;

/// Signatures with the discovery's estimates of their light.
pub type Found = (Signature, SignatureLight);

/// The error that light which is followed may have, if all of it may have `target`: the two are independent.
pub fn left(target: f64) -> f64 {
    target * (1.0 - PART * PART).sqrt()
}

/// The relative errors that signatures are needed for on a film: for larger ones they may be left out,
/// together with all those of smaller errors. Zero for those beyond the largest number.
pub fn needed_for(found: &[Found], film: [usize; 2]) -> Vec<f64> {
    let on_film: f64 = found.iter().map(|(_, light)| light.on_film).sum();
    let texels = (film[0] * film[1]) as f64;
    let mut by_error: Vec<(f64, f64, usize)> = found
        .iter()
        .enumerate()
        .map(|(index, (_, light))| (squares(light, film), light.may_bring(), index))
        .collect();
    by_error.sort_by(|(a, x, i), (b, y, j)| a.total_cmp(b).then(x.total_cmp(y)).then(i.cmp(j)));
    let (mut needed, mut beside) = (vec![0.0; found.len()], 0.0);
    let (mut flux, mut sum) = (0.0, 0.0);
    let too_many = found.len().saturating_sub(MOST_SIGNATURES);
    for (rank, (squares, may_bring, index)) in by_error.into_iter().enumerate() {
        let most = if found[index].1.is_beside() {
            // It is no part of the likely error: the two do not share the small part.
            beside += may_bring;
            beside
        } else {
            (flux, sum) = (flux + may_bring, sum + squares);
            f64::max(flux, (sum * texels).sqrt())
        };
        let error = most / (PART * on_film);
        if rank >= too_many {
            needed[index] = error;
        }
    }
    needed
}

/// Light that is left out.
#[derive(Clone, Debug, Default)]
pub struct LeftOut {
    /// Flux \[W\] on the film.
    pub flux: f64,
    /// Sum over texels of the squared flux \[W²\].
    pub squares: f64,
    /// Flux \[W\] that a texel may get; empty if nothing is left out.
    pub bound: Vec<f64>,
}

impl LeftOut {
    /// The light of some signatures that are left out.
    pub fn of<'a>(found: impl Iterator<Item = &'a Found> + Clone, film: [usize; 2]) -> Self {
        let landings: Vec<Landing> = found
            .clone()
            .flat_map(|(_, light)| light.landings.iter().copied())
            .collect();
        let texels = (film[0] * film[1]) as f64;
        // What landed beside the film only may be on it, too, as far as so few paths tell.
        let beside = found.clone().filter(|(_, light)| light.is_beside());
        let beside = beside.fold(0.0, |sum, (_, light)| sum + light.may_bring());
        let sum = squares_of(found.clone(), film);
        Self {
            flux: found
                .map(|(_, light)| light.on_film)
                .fold(0.0, |sum, flux| sum + flux),
            squares: sum,
            bound: bound(&landings, film),
        }
        .and_everywhere(MARGIN * beside / texels, film)
    }

    /// The same with so much flux \[W\] more that each texel may get.
    #[must_use]
    pub fn and_everywhere(mut self, flux: f64, film: [usize; 2]) -> Self {
        if flux > 0.0 {
            self.bound.resize(film[0] * film[1], 0.0);
            for bound in &mut self.bound {
                *bound += flux;
            }
        }
        self
    }
}

/// Σ φ² of the light of some signatures, which are independent.
pub fn squares_of<'a>(found: impl Iterator<Item = &'a Found>, film: [usize; 2]) -> f64 {
    found.map(|(_, light)| squares(light, film)).sum()
}

/// Σ φ² of a signature's light, from its paths.
fn squares(light: &SignatureLight, film: [usize; 2]) -> f64 {
    let texels = (film[0] * film[1]) as f64;
    let mut most = light.on_film * light.on_film / texels;
    let own = light.landings.iter();
    let own = own.fold(0.0, |sum, landing| sum + landing.flux * landing.flux);
    for side in BINS {
        let sums = flux_by_bin(&light.landings, film, side);
        let squares: f64 = sums.iter().map(|sum| sum * sum).sum();
        most = most.max((squares - own) * (side * side) as f64 / texels);
    }
    most
}

/// The texels that light reaches, as far as its paths tell; empty if they are too few to tell.
///
/// Errors are relative to the mean of lit texels. Light that is left out counts among these: else an error
/// of faint light on all of the film would be relative to the mean within a bright spot.
///
/// The film is halved both ways while its parts have paths enough to tell. A part with a path is lit.
pub fn reached<'a>(found: impl Iterator<Item = &'a Found>, film: [usize; 2]) -> Vec<bool> {
    let mut paths: Vec<DVec2> = found
        .flat_map(|(_, light)| light.landings.iter().map(|one| one.at))
        .collect();
    if paths.len() < 4 * TELLING {
        return Vec::new();
    }
    let mut reached = vec![false; film[0] * film[1]];
    mark(
        &mut paths,
        [[0, film[0]], [0, film[1]]],
        film[0],
        &mut reached,
    );
    reached
}

/// Marks the lit texels of a window, as ranges of columns and rows, of a film with rows of some `columns`.
fn mark(paths: &mut [DVec2], window: [[usize; 2]; 2], columns: usize, reached: &mut [bool]) {
    let [[left, right], [top, bottom]] = window;
    if paths.is_empty() {
        return;
    }
    let is_texel = right - left <= 1 && bottom - top <= 1;
    if paths.len() < 4 * TELLING || is_texel {
        for row in top..bottom {
            reached[row * columns + left..row * columns + right].fill(true);
        }
        return;
    }
    let (x, y) = (left.midpoint(right), top.midpoint(bottom));
    let (above, below) = divide(paths, |at| at.y < y as f64);
    for (paths, rows) in [(above, [top, y]), (below, [y, bottom])] {
        let (before, behind) = divide(paths, |at| at.x < x as f64);
        mark(before, [[left, x], rows], columns, reached);
        mark(behind, [[x, right], rows], columns, reached);
    }
}

/// Sorts those that are first to the front.
fn divide(paths: &mut [DVec2], is_first: impl Fn(&DVec2) -> bool) -> (&mut [DVec2], &mut [DVec2]) {
    let mut first = 0;
    for index in 0..paths.len() {
        if is_first(&paths[index]) {
            paths.swap(index, first);
            first += 1;
        }
    }
    paths.split_at_mut(first)
}

/// The most flux that texels may get of light whose paths are known: by the densest bins about each.
pub fn bound(landings: &[Landing], film: [usize; 2]) -> Vec<f64> {
    let texels = film[0] * film[1];
    if landings.is_empty() {
        return Vec::new();
    }
    let mut bound = vec![0.0; texels];
    for side in BINS {
        raise(&mut bound, &flux_by_bin(landings, film, side), side, film);
    }
    bound
}

/// Raises what texels may get to what the densest of `side` x `side` bins about each tell.
fn raise(bound: &mut [f64], sums: &[f64], side: usize, film: [usize; 2]) {
    let near = |at: usize| at.saturating_sub(1)..(at + 2).min(side);
    let most: Vec<f64> = (0..side * side)
        .map(|at| {
            let rows = near(at / side);
            rows.flat_map(|row| near(at % side).map(move |column| (row, column)))
                .map(|(row, column)| sums[row * side + column])
                .fold(0.0, f64::max)
        })
        .collect();
    let scale = MARGIN * (side * side) as f64 / bound.len() as f64;
    for (texel, bound) in bound.iter_mut().enumerate() {
        *bound = f64::max(*bound, scale * most[bin_of_texel(texel, film, side)]);
    }
}

/// The part (0..=1) that texels are taken to get at most of light of any one signature, which lands as its
/// paths do; evenly if it has none.
pub fn most_part<'a>(
    signatures: &(impl Iterator<Item = &'a [Landing]> + Clone),
    film: [usize; 2],
) -> Vec<f64> {
    let mut part = vec![0.0; film[0] * film[1]];
    for side in BINS {
        // All of it is on the film: in the only bin of one.
        let mut densest = vec![if side == 1 { 1.0 } else { 0.0 }; side * side];
        for landings in signatures.clone() {
            let flux = landings.iter().fold(0.0, |sum, one| sum + one.flux);
            let sums = flux_by_bin(landings, film, side);
            for (densest, sum) in densest.iter_mut().zip(sums) {
                *densest = f64::max(*densest, if flux > 0.0 { sum / flux } else { 0.0 });
            }
        }
        raise(&mut part, &densest, side, film);
    }
    for part in &mut part {
        *part = part.min(1.0);
    }
    part
}

/// Flux \[W\] that landed in each of `side` x `side` bins of a film.
fn flux_by_bin(landings: &[Landing], film: [usize; 2], side: usize) -> Vec<f64> {
    let along = |at: f64, texels: usize| {
        let bin = (at / texels as f64 * side as f64) as usize;
        bin.min(side - 1)
    };
    let mut sums = vec![0.0; side * side];
    for Landing { at, flux } in landings {
        sums[along(at.y, film[1]) * side + along(at.x, film[0])] += flux;
    }
    sums
}

/// The bin of a texel's corner.
fn bin_of_texel(texel: usize, film: [usize; 2], side: usize) -> usize {
    let (x, y) = (texel % film[0], texel / film[0]);
    y * side / film[1] * side + x * side / film[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILM: [usize; 2] = [64, 32];

    /// A signature of `events` reflections with so much flux by each of some paths.
    fn light(events: usize, flux: f64, places: &[[f64; 2]]) -> Found {
        let name = format!("L{}D", "R".repeat(events));
        let landings: Vec<Landing> = places
            .iter()
            .map(|at| Landing {
                at: DVec2::from(*at),
                flux,
            })
            .collect();
        let on_film = flux * places.len() as f64;
        let found = SignatureLight {
            flux: on_film,
            on_film,
            peak: 1.0,
            landings,
        };
        (name.parse().unwrap(), found)
    }

    /// One place in each texel of every fourth column and row.
    fn spread() -> Vec<[f64; 2]> {
        (0..128)
            .map(|index| {
                [
                    (index % 16) as f64 * 4.0 + 0.5,
                    (index / 16) as f64 * 4.0 + 0.5,
                ]
            })
            .collect()
    }

    /// Those that are left out for an error of 1 %.
    fn left_out(found: &[Found]) -> Vec<Found> {
        let needed = needed_for(found, FILM);
        let found = found.iter().cloned().zip(needed);
        found
            .filter(|(_, needed)| *needed <= 1e-2)
            .map(|(one, _)| one)
            .collect()
    }

    #[test]
    fn the_faintest_are_left_out_while_their_sum_is_little() {
        // Of a flux of about 128, 1 % of a quarter is 0.32: two of three signatures of 0.15 each.
        let faint = [2, 3, 4].map(|events| light(events, 0.15 / 128.0, &spread()));
        let found = [vec![light(1, 1.0, &spread())], faint.to_vec()].concat();
        let others = left_out(&found);
        assert_eq!(others.len(), 2);
        let left_out = LeftOut::of(others.iter(), FILM);
        assert!((left_out.flux - 0.3).abs() < 1e-12);
    }

    /// The same light beside the film.
    fn beside(events: usize, flux: f64) -> Found {
        let (signature, found) = light(events, flux / 128.0, &spread());
        let found = SignatureLight {
            on_film: 0.0,
            landings: Vec::new(),
            ..found
        };
        (signature, found)
    }

    #[test]
    fn light_beside_the_film_is_left_out_while_it_is_little() {
        let bright = light(1, 1.0, &spread());
        // 1 % of a quarter is 0.32, as above: the faintest two of four fit into it.
        let beside = [(2, 20.0), (3, 0.15), (4, 0.16), (5, 0.14)];
        let beside = beside.map(|(events, flux)| self::beside(events, flux));
        let found = [vec![bright.clone()], beside.to_vec()].concat();
        let others = left_out(&found);
        let left: Vec<f64> = others.iter().map(|(_, light)| light.flux).collect();
        assert_eq!(left, [0.15, 0.14]);
        // A quarter of the error asked for, four times over.
        let left_out = LeftOut::of(others.iter(), FILM);
        let mean = 128.0 / 2048.0;
        assert!(left_out.bound.iter().all(|bound| *bound <= 1e-2 * mean));
        // Light that is left out on the film takes no room from light beside it.
        let faint = light(6, 0.15 / 128.0, &spread());
        assert!(self::left_out(&[found, vec![faint]].concat()).len() == 3);
    }

    #[test]
    fn faint_light_in_one_place_is_followed() {
        let bright = light(1, 1.0, &spread());
        // As much flux as before, but in a bin of 2048 / 64²: half a texel.
        let focus = light(2, 0.15 / 128.0, &[[3.25, 3.25]; 128]);
        assert!(left_out(&[bright, focus]).is_empty());
    }

    /// Part of a film of 64 x 64 texels that light at these places reaches.
    fn part_reached(places: &[[f64; 2]]) -> f64 {
        const SIDE: usize = 64;
        let reached = reached([light(1, 1.0, places)].iter(), [SIDE; 2]);
        let lit = reached.iter().filter(|reached| **reached).count();
        lit as f64 / (SIDE * SIDE) as f64
    }

    #[test]
    fn few_paths_tell_that_light_reaches_all_of_a_film_and_none_of_the_dark_half() {
        // One path in each of 16 x 16 parts, then of those in the left half alone.
        let even: Vec<[f64; 2]> = (0..256)
            .map(|index| [(index % 16) as f64, (index / 16) as f64].map(|at| 4.0 * at + 1.5))
            .collect();
        assert_eq!(part_reached(&even), 1.0);
        let (left, _): (Vec<_>, Vec<_>) = even.iter().partition(|at| at[0] < 32.0);
        assert_eq!(part_reached(&left), 0.5);
        // Many more in one texel do not hide that the others are everywhere, but for 15 texels about that
        // one.
        let focus = [even, vec![[1.5, 1.5]; 4096]].concat();
        assert_eq!(part_reached(&focus), 1.0 - 15.0 / 4096.0);
    }

    #[test]
    fn what_light_reaches_is_told_by_place_on_films_of_any_form() {
        // The first 24 of 48 columns, a path in each texel; then the first 12 of 20 rows.
        let size = [48, 20];
        let texels = |is_lit: &dyn Fn(usize, usize) -> bool| -> Vec<bool> {
            let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
            all.map(|(x, y)| is_lit(x, y)).collect()
        };
        for is_lit in [&|x, _| x < 24, &|_, y| y < 10] as [&dyn Fn(usize, usize) -> bool; 2] {
            let expected = texels(is_lit);
            let places: Vec<[f64; 2]> = (0..expected.len())
                .filter(|texel| expected[*texel])
                .map(|texel| [texel % size[0], texel / size[0]].map(|at| at as f64 + 0.5))
                .collect();
            assert!(reached([light(1, 1.0, &places)].iter(), size) == expected);
        }
        // Films of one row are divided along it.
        let row: Vec<[f64; 2]> = (0..64).map(|x| [f64::from(x) + 0.5, 0.5]).collect();
        let reached = reached([light(1, 1.0, &row)].iter(), [128, 1]);
        assert_eq!(reached.iter().filter(|reached| **reached).count(), 64);
    }

    #[test]
    fn too_few_paths_tell_nothing_of_what_light_reaches() {
        assert_eq!(part_reached(&[[1.5, 1.5]; 15]), 0.0);
        assert_eq!(part_reached(&[[1.5, 1.5]; 16]), 1.0 / 4096.0);
    }

    #[test]
    fn the_bound_of_light_left_out_is_more_than_its_density() {
        let found = [light(1, 1.0, &spread())];
        let left_out = LeftOut::of(found.iter(), FILM);
        let mean = 128.0 / 2048.0;
        assert!(left_out.bound.iter().all(|bound| *bound >= MARGIN * mean));
        // Σ φ² of even light is (Σ φ)² / n; bins as small as texels see each path alone.
        assert!(left_out.squares >= 2048.0 * mean * mean * (1.0 - 1e-12));
    }

    #[test]
    fn a_texel_gets_no_more_than_all_and_as_much_as_the_densest_signature_tells() {
        let focused = light(1, 2.0, &[[32.5, 16.5]]).1.landings;
        let corners = [[1.0, 1.0], [62.0, 1.0], [1.0, 30.0], [62.0, 30.0]];
        let spread = light(2, 1.0, &corners).1.landings;
        let none: &[Landing] = &[];
        // Evenly, four times as dense.
        let even = MARGIN / (FILM[0] * FILM[1]) as f64;
        assert_eq!(most_part(&[none].into_iter(), FILM), vec![even; 64 * 32]);
        let both = most_part(&[&focused[..], &spread[..]].into_iter(), FILM);
        let alone = most_part(&[&focused[..]].into_iter(), FILM);
        let at = 16 * 64 + 32;
        // A bin of 64 x 64 is half a texel: all of it may be there.
        assert_eq!((both[at], alone[at]), (1.0, 1.0));
        assert!(both[64 + 1] > alone[64 + 1] && alone[64 + 1] >= even);
        assert_eq!(most_part(&[&focused[..]].into_iter(), [1, 1]), [1.0]);
    }
}
