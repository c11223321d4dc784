//! Stage `lookup`, exact: beams dealt out on the sensor's texels by area.
//!
//! The three rays of a part of a beam land on three points of the film, between which its light is dealt out.
//! Where they meet different surfaces, the part is quartered, `border-levels` times; of what is left then,
//! each ray puts a third into its texel.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::beam::Beam;
use super::cull::Draw;
use super::settings::Settings;
use super::shade::Shading;
use super::variants::{
    Accumulate, Cosine, Density, Inside, Occlusion, Transmittance, WaterShadow, WaterSurface,
};
use super::volume::{Corner, Lattice, LitVertex, Whole};
use super::work::Work;
use crate::approximation::interface::Fresnel;
use crate::approximation::{ExactFilm, Receivers, SensorFilm};
use crate::geometry::{Ray, SurfacePoint, TraversalCounters};
use crate::radiometry::Rgb;
use crate::run::Error;
use crate::transport::path_end::{End, next_hit};
use crate::transport::screen::Screen;

/// True if the light of beams is linear in all stages, so that it can be dealt out. Then beams need no
/// points.
pub fn can_deal(settings: &Settings, film: &SensorFilm) -> bool {
    let is_receiver = film.shape().is_some();
    settings.accumulate == Accumulate::Exact
        && settings.cosine != Cosine::Vector
        && (is_receiver
            || settings.inside == Inside::Exact && settings.occlusion == Occlusion::Exact)
}

/// Deals the beams of draws out on a film: texel averages by the source's strength and the water's colour.
///
/// # Errors
///
/// If sums cannot be represented.
pub fn deal(
    shading: &Shading,
    vertices: &[Option<LitVertex>],
    beams: &[Option<Beam>],
    draws: &[Draw],
    film: &SensorFilm,
    work: &mut Work,
) -> Result<Vec<Rgb>, Error> {
    let settings = shading.lit.settings;
    let total: f64 = beams
        .iter()
        .flatten()
        .map(|beam| beam.light.iter().sum::<f64>())
        .sum();
    // Factors of stages that are not exact grow without bound towards a focus.
    let is_bounded = settings.density == Density::Exact && settings.cosine == Cosine::Exact;
    let headroom = if is_bounded { 1.0 } else { LARGEST_FACTOR };
    let largest = total.max(f64::MIN_POSITIVE) * headroom * film.largest_factor(shading.lit.scene);
    let exact = ExactFilm::new(film.size(), largest)?;
    let shape = film
        .shape()
        .filter(|_| settings.occlusion == Occlusion::None);
    let alone = shape.map(|shape| {
        let wanted = &shading.lit.scene.world().shapes()[shape as usize];
        Receivers::chosen(shading.lit.scene, |it| std::ptr::eq(it, wanted))
    });
    let dealing = Dealing {
        shading,
        screen: film.screen(),
        film: &exact,
        alone: alone.as_ref(),
    };
    let mut triangles: Vec<u32> = draws
        .iter()
        .filter_map(|draw| Some(beams[draw.beam as usize].as_ref()?.triangle))
        .collect();
    triangles.dedup();
    let done: Vec<Work> = triangles
        .par_iter()
        .filter(|_| !shading.lit.progress.is_stopped())
        .filter_map(|&triangle| {
            let whole = shading.lit.whole(triangle, vertices)?;
            Some(dealing.triangle(&whole))
        })
        .collect();
    for one in done {
        *work += one;
    }
    let measure = |texel: usize| match film.measure(texel) {
        0.0 => f64::INFINITY,
        measure => measure,
    };
    let sums = exact.finish()?.into_iter().enumerate();
    Ok(sums.map(|(texel, sum)| sum / measure(texel)).collect())
}

/// The largest factor by which stages that are not exact change light.
const LARGEST_FACTOR: f64 = 1_048_576.0;

/// Where a ray lands.
#[derive(Clone, Copy)]
struct Landing {
    at: DVec2,
    position: DVec3,
    /// The surface's unit normal, towards the light.
    normal: DVec3,
    /// What its light is multiplied by: stages that are exact at points, and the sensor.
    factor: Rgb,
    /// The same for rays on one smooth surface.
    surface: u64,
}

/// A corner of a part, and where its ray lands, if it does.
type Placed = Option<(Corner, Option<Landing>)>;

struct Dealing<'a> {
    shading: &'a Shading<'a>,
    screen: Screen<'a>,
    film: &'a ExactFilm,
    /// The measured surface by itself, if nothing under water hides it.
    alone: Option<&'a Receivers>,
}

impl Dealing<'_> {
    /// Deals out the beam below a triangle.
    fn triangle(&self, whole: &Whole) -> Work {
        let mut work = Work::default();
        let settings = self.shading.lit.settings;
        let lattice = Lattice::new(settings.levels, |at| self.placed(whole, at, &mut work));
        for corners in lattice.cells() {
            self.part(
                whole,
                &corners.map(|corner| *corner),
                settings.levels,
                settings.border_levels,
                &mut work,
            );
        }
        work
    }

    fn placed(&self, whole: &Whole, at: DVec2, work: &mut Work) -> Placed {
        let corner = self.shading.lit.corner(whole, at)?;
        let mut counters = TraversalCounters::default();
        let landing = self.landing(whole, &corner, &mut counters);
        work.add_rays(counters);
        Some((corner, landing))
    }

    /// Where a ray lands; `None` where it does not, or is in shadow.
    fn landing(
        &self,
        whole: &Whole,
        corner: &Corner,
        counters: &mut TraversalCounters,
    ) -> Option<Landing> {
        let lit = &self.shading.lit;
        let (scene, settings) = (lit.scene, lit.settings);
        let ruling = &corner.ruling;
        let direction = lit.slicing.direction(ruling.slope);
        let mut factor = 1.0;
        let start = lit.slicing.world(ruling.at(ruling.start), ruling.start);
        let place = lit.water.place(scene, whole.beam.triangle, corner.at);
        if settings.shadow == WaterShadow::Exact {
            factor *= lit.reaches(&place?, counters);
        }
        if settings.fresnel == Transmittance::Exact {
            factor *= lit.refracted(&place?, Fresnel::Exact)?.share;
        }
        if factor <= 0.0 {
            return None;
        }
        let ray = match place {
            // On the scene's own surface: off it by its rounding.
            Some(place) => SurfacePoint {
                position: start,
                ..place
            }
            .spawn(direction),
            None => Ray::new(start, direction),
        };
        let (ray, hit) = match self.alone {
            Some(alone) => (ray, alone.first(&ray, counters).map(|(hit, _)| hit)),
            None if settings.surface == WaterSurface::Triangles => {
                let hit = self.shading.receivers.first(&ray, counters);
                (ray, hit.map(|(hit, _)| hit))
            }
            None => {
                next_hit(scene, ray, counters).map_or((ray, None), |(ray, hit)| (ray, Some(hit)))
            }
        };
        let (end, canvas, surface) = self.screen.end(scene, &ray, hit.as_ref(), counters);
        let End::Landed(at) = end else {
            return None;
        };
        let (distance, normal) = match (&hit, self.screen) {
            (Some(hit), _) => (
                hit.distance,
                scene.world().surface_point(&ray, hit).geometric_normal,
            ),
            (None, Screen::Receiver(receiver)) => {
                let shape = &scene.world().shapes()[receiver.shape() as usize];
                (shape.meet_beyond(&ray)?.0, shape.plane()?[1])
            }
            (None, Screen::Camera { .. }) => return None,
        };
        Some(Landing {
            at,
            position: ray.at(distance),
            normal: normal * -normal.dot(direction).signum(),
            factor: canvas * factor,
            surface,
        })
    }

    /// Deals out a part of a triangle that has been quartered `levels` times, and may be `left` times more.
    fn part(&self, whole: &Whole, corners: &[Placed; 3], levels: u32, left: u32, work: &mut Work) {
        let landed = corners
            .each_ref()
            .map(|corner| corner.as_ref().and_then(|(_, landing)| *landing));
        if landed.iter().all(Option::is_none) {
            return;
        }
        let is_one = matches!(landed, [Some(a), Some(b), Some(c)] if a.surface == b.surface && b.surface == c.surface);
        if left > 0 && !is_one {
            self.quarters(whole, corners, levels, left, work);
            return;
        }
        let [Some((a, _)), Some((b, _)), Some((c, _))] = *corners else {
            return;
        };
        let Some(beam) = self.shading.lit.cell(whole, [a, b, c], levels) else {
            return;
        };
        let values = [0, 1, 2].map(|i| {
            landed[i].map_or(Rgb::BLACK, |it| {
                it.factor * (beam.light[i] * self.stages(&beam, i, &it))
            })
        });
        work.beams += 1;
        if let (true, [Some(a), Some(b), Some(c)]) = (is_one, landed) {
            work.blends += self.film.deal([a.at, b.at, c.at], values);
            return;
        }
        for (landing, value) in landed.into_iter().zip(values) {
            if let Some(landing) = landing {
                self.film.deposit_at(landing.at, value / 3.0);
                work.blends += 1;
            }
        }
    }

    fn quarters(
        &self,
        whole: &Whole,
        corners: &[Placed; 3],
        levels: u32,
        left: u32,
        work: &mut Work,
    ) {
        let Some(ats) = Self::places(corners) else {
            return;
        };
        let [a, b, c] = *corners;
        let mut middle = |i: usize, j: usize| self.placed(whole, 0.5 * (ats[i] + ats[j]), work);
        let (ab, bc, ca) = (middle(0, 1), middle(1, 2), middle(2, 0));
        for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            self.part(whole, &part, levels + 1, left - 1, work);
        }
    }

    /// Where corners are on the triangle; `None` if one has no ray.
    fn places(corners: &[Placed; 3]) -> Option<[DVec2; 3]> {
        let [a, b, c] = corners;
        Some([a.as_ref()?.0.at, b.as_ref()?.0.at, c.as_ref()?.0.at])
    }

    /// The product of stages `density` and `cosine` by their exact twins, where a ray lands.
    fn stages(&self, beam: &Beam, ray: usize, landing: &Landing) -> f64 {
        let lit = &self.shading.lit;
        let ruling = &beam.rulings[ray];
        let depth = lit.slicing.local(landing.position).1;
        let density = match lit.settings.density {
            Density::Exact => 1.0,
            Density::Slices => {
                beam.section(depth).area() * ruling.cos() * beam.by_area(lit.slicing, depth)
            }
            Density::Perpendicular => beam.section(depth).area() * beam.by_area(lit.slicing, depth),
        };
        let cosine = match lit.settings.cosine {
            Cosine::Exact | Cosine::Vector => 1.0,
            Cosine::Flat => {
                let cos = |direction: DVec3| -landing.normal.dot(direction);
                cos(self.shading.flat.direction).max(0.0) / cos(lit.slicing.direction(ruling.slope))
            }
        };
        let factor = density * cosine;
        if factor.is_nan() {
            0.0
        } else {
            factor.clamp(0.0, LARGEST_FACTOR)
        }
    }
}
