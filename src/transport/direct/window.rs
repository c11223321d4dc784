//! The part of a texel that parallel light from a flat surface meets, if nothing is in the way.

use glam::{DVec2, DVec3};

use super::arriving::unshadowed;
use super::glance::Glance;
use super::light::DirectLight;
use super::look::ShareRange;
use super::texel::DirectTexel;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::scene::Emitter;
use crate::transport::domain::normal_light::NormalLight;
use crate::transport::domain::patch::ChartPatch;
use crate::transport::domain::polygon::{area, cut, disk_area};
use crate::transport::domain::surface::Area;

/// What a texel and the light of a part have in common.
pub(super) struct Window {
    /// The part (0..=1) of the texel that is lit.
    pub(super) share: f64,
    /// Places in it, in fractions across the texel; a little inside of its corners and edges.
    pub(super) places: Vec<DVec2>,
    /// A box of places on the part around those from which light comes, if it is known.
    pub(super) origins: Option<ChartPatch>,
    /// True if the texel is one flat parallelogram, so that all of this is exact; else it is as if it were.
    pub(super) is_exact: bool,
}

impl Window {
    /// Parts of a texel below this are rounding.
    const ROUNDING: f64 = 1e-12;

    /// True if no light of the part meets the texel.
    pub(super) fn is_outside(&self) -> bool {
        self.is_exact && self.share <= Self::ROUNDING
    }

    /// True if a closer look at a texel that the end of the light divides may be trusted: the window is not
    /// small against the distance of its points, and it has not missed what the window's own places see.
    pub(super) fn is_found_by(&self, own: &Glance, closer: &DirectTexel) -> bool {
        const SMALL: f64 = 1.0 / 16.0;
        let is_missed = own.passed.most > 0.0 && closer.irradiance.is_black();
        self.share >= SMALL && !is_missed
    }

    /// True if light meets some of the texel and not all.
    pub(super) fn is_divided(&self) -> bool {
        (Self::ROUNDING..1.0 - Self::ROUNDING).contains(&self.share)
    }
}

/// Fractions across a texel that are a hair inside: its border may be that of the surface.
const INSET: f64 = 1e-6;

/// Sides of the polygon that stands for a disc where places in it are wanted.
const SIDES: u32 = 64;

/// Places of a window are by this part of their distance nearer to its middle than its corners.
const INWARD: f64 = 1e-3;

impl DirectLight<'_> {
    /// The window of a part on a texel. `None` for balls, where a corner of the texel has no surface, and on
    /// receivers along the light.
    pub(super) fn window(&self, texel: usize, part: &NormalLight) -> Option<Window> {
        let surface = part.area()?;
        let ends = [INSET, 1.0 - INSET];
        let at = |u: f64, v: f64| self.patch(texel, DVec2::new(u, v));
        let [first, right] = [at(ends[0], ends[0])?, at(ends[1], ends[0])?];
        let [below, last] = [at(ends[0], ends[1])?, at(ends[1], ends[1])?];
        let middle = at(0.5, 0.5)?;
        let scale = 1.0 / (1.0 - 2.0 * INSET);
        let x = (right.point.position - first.point.position) * scale;
        let y = (below.point.position - first.point.position) * scale;
        let corner = first.point.position - (x + y) * INSET;
        // Of two smooth surfaces, no more than rounding apart.
        let slack = 1e-9 * (x.length() + y.length()) + 8.0 * first.point.position_error.length();
        let is_at = |place: DVec3, u: f64, v: f64| place.distance(corner + x * u + y * v) <= slack;
        let is_exact = [&right, &below, &last, &middle].into_iter().all(|it| {
            it.face == first.face && (it.density - first.density).abs() <= 1e-9 * first.density
        }) && is_at(last.point.position, ends[1], ends[1])
            && is_at(middle.point.position, 0.5, 0.5);
        let [(from, way), (along_x, way_x), (along_y, way_y)] = [
            part.origin_of(corner)?,
            part.origin_of(corner + x)?,
            part.origin_of(corner + y)?,
        ];
        let (x, y) = (along_x - from, along_y - from);
        let origin = |place: &DVec2| from + x * place.x + y * place.y;
        let whole = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let mut lit = cut(&whole, |place| {
            way + (way_x - way) * place.x + (way_y - way) * place.y
        });
        let size = x.perp_dot(y).abs();
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let mut share = None;
        match surface {
            Area::Parallelogram { .. } | Area::Triangle(_) => {
                lit = cut(&lit, |place| origin(place).x);
                lit = cut(&lit, |place| origin(place).y);
                if let Area::Triangle(_) = surface {
                    lit = cut(&lit, |place| 1.0 - origin(place).x - origin(place).y);
                } else {
                    lit = cut(&lit, |place| 1.0 - origin(place).x);
                    lit = cut(&lit, |place| 1.0 - origin(place).y);
                }
            }
            Area::Disk { .. } => {
                let before: Vec<DVec2> = lit.iter().map(origin).collect();
                share = Some(disk_area(&before) / size);
                // The places are in a polygon inside of the disc.
                let unit = |angle: f64| {
                    let (sin, cos) = math::sin_cos(angle);
                    DVec2::new(cos, sin)
                };
                let turn = std::f64::consts::TAU / f64::from(SIDES);
                let reach = unit(0.5 * turn).x;
                for side in 0..SIDES {
                    let normal = unit(turn * f64::from(side));
                    lit = cut(&lit, |place| reach - normal.dot(origin(place)));
                }
            }
        }
        let share = share.unwrap_or_else(|| area(&lit)).clamp(0.0, 1.0);
        let mut places = Vec::new();
        if lit.len() >= 3 {
            let middle = lit.iter().sum::<DVec2>() / lit.len() as f64;
            places.push(middle);
            for (index, a) in lit.iter().enumerate() {
                let b = lit[(index + 1) % lit.len()];
                places.extend([*a, 0.5 * (*a + b)].map(|it| it + (middle - it) * INWARD));
            }
        }
        let origins = lit.iter().map(origin);
        let bounds = origins.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), it| {
            (low.min(it), high.max(it))
        });
        Some(Window {
            share,
            places,
            origins: (lit.len() >= 3).then_some(ChartPatch {
                from: bounds.0,
                to: bounds.1,
            }),
            is_exact,
        })
    }

    /// Average of a delta emitter's light through a window, by the shadows on its places. If these differ, or
    /// there are none, all of it counts as error.
    pub(super) fn through(
        &mut self,
        texel: usize,
        (emitter, part): (&Emitter, &NormalLight),
        window: &Window,
    ) -> Glance {
        let mut passed = ShareRange::NOTHING_SEEN;
        let (mut whole, mut sum, mut count) = (Rgb::BLACK, 0.0, 0.0);
        let home = [DVec2::splat(0.5)];
        let places = if window.places.is_empty() {
            &home[..]
        } else {
            &window.places
        };
        for place in places {
            let Some(patch) = self.patch(texel, *place) else {
                continue;
            };
            let (irradiance, towards, _) = unshadowed(&patch.point, emitter);
            whole = Rgb(std::array::from_fn(|c| whole.0[c].max(irradiance.0[c])));
            if let Some(ray) = part.meets(&patch.point) {
                let share = self.transmittance(&patch.point, towards, ray.reach);
                passed = passed.with_share(share);
                sum += share;
                count += 1.0;
            }
        }
        let whole = whole * window.share;
        let is_known = count > 0.0 && !passed.is_mixed() && window.is_exact;
        Glance {
            value: DirectTexel {
                irradiance: if count > 0.0 {
                    whole * (sum / count)
                } else {
                    Rgb::BLACK
                },
                error: if is_known { Rgb::BLACK } else { whole },
            },
            passed,
        }
    }
}
