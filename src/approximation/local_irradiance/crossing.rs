//! Legs that count where they cross the sensor's surface: stage `space`, exact.

use glam::{DMat3, DVec3};

use super::deposit::Sums;
use super::settings::Settings;
use super::shoot::{Deposits, TracedLeg};
use super::variants::{Deposit, Normal, Region};
use super::work::Work;
use crate::geometry::{Ray, TraversalCounters};
use crate::scene::Scene;
use crate::transport::chain::{Arrival, MAX_PASSES};
use crate::transport::flux::Flux;
use crate::transport::screen::Screen;
use crate::transport::signature::Signature;

/// The share of a faded region's radius at which light begins to fade.
const FADE_FROM: f64 = 0.9;

/// The factor of a fading region at a distance by its radius: from 1 at nine tenths to 0 at the border, along
/// 3x² − 2x³.
#[inline]
pub fn faded(distance: f64) -> f64 {
    let x = ((1.0 - distance) / (1.0 - FADE_FROM)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Legs that count where they cross the sensor's surface.
pub struct OnSensor<'a, const N: usize> {
    /// The settings.
    pub settings: &'a Settings,
    /// The scene with the sensor.
    pub scene: &'a Scene,
    /// The sensor.
    pub screen: Screen<'a>,
    /// The object's centre in the world.
    pub center: DVec3,
    /// The rotation from the sample's own axes to the world, for the light's own direction.
    pub to_world: DMat3,
    /// The radius \[m\] of the region.
    pub radius: f64,
    /// By how much \[m\] legs go on after surfaces that stop them.
    pub beyond: f64,
    /// The sums, by texel.
    pub sums: Sums<N>,
}

impl<const N: usize> Deposits<N> for OnSensor<'_, N> {
    fn add(&mut self, traced: &TracedLeg<N>, work: &mut Work) {
        if self.settings.deposit == Deposit::Exact && traced.is_inside {
            return;
        }
        let from = self.center + self.to_world * traced.leg.from;
        let direction = self.to_world * traced.leg.direction;
        let mut length = traced.leg.length;
        if traced.is_stopped {
            length += self.beyond;
        }
        let settings = self.settings;
        let mut counters = TraversalCounters::default();
        let mut landed = Vec::new();
        self.cross(
            Ray::new(from, direction),
            length,
            &mut counters,
            |place, normal, texel| {
                let away = place - self.center;
                let distance = away.length();
                if distance > self.radius && settings.region != Region::Exact {
                    return;
                }
                let mut weight = match settings.normal {
                    // Without cells there is nothing that light from two sides cancels out in.
                    Normal::Exact | Normal::Vector => 1.0,
                    Normal::Fixed => {
                        let outward = away / distance;
                        direction.dot(outward).max(0.0) * (-normal.dot(outward)).max(0.0)
                            / -direction.dot(normal)
                    }
                };
                if settings.region == Region::Fade {
                    weight *= faded(distance / self.radius);
                }
                landed.push((texel, weight));
            },
        );
        if settings.region == Region::Clamp {
            self.beyond_border(from, direction, length, &mut counters, &mut landed);
        }
        for ((texel, factor), weight) in landed {
            if weight > 0.0 {
                work.deposits += 1;
                self.sums
                    .add(texel, traced.flux * Flux::of(factor) * weight);
            }
        }
        work.add_rays(counters);
    }
}

/// A texel with the factor from flux to its sum.
type Texel = (usize, crate::radiometry::Rgb);

impl<const N: usize> OnSensor<'_, N> {
    /// All places where a ray meets the sensor, up to a length: the place, the unit normal on the side that
    /// it comes from, and the texel.
    fn cross(
        &self,
        mut ray: Ray,
        mut length: f64,
        counters: &mut TraversalCounters,
        mut found: impl FnMut(DVec3, DVec3, Texel),
    ) {
        let world = self.scene.world();
        // A leg ends on its surface, which it is to meet.
        length *= 1.0 + 1e-12;
        for _ in 0..MAX_PASSES {
            let Some(hit) = world.closest_hit(&ray, length, counters) else {
                return;
            };
            let point = world.bounce_point(&ray, &hit);
            let arrival: Arrival<N> = Arrival {
                ray: &ray,
                hit: &hit,
                point: &point,
                signature: Signature::DIRECT,
                flux: Flux::WHITE,
            };
            if let Some(texel) = self.screen.texel(self.scene, &arrival, counters) {
                let normal = point.geometric_normal;
                let normal = if normal.dot(ray.direction) < 0.0 {
                    normal
                } else {
                    -normal
                };
                found(point.position, normal, texel);
            }
            length -= hit.distance;
            ray = point.spawn(ray.direction);
        }
    }

    /// Light that leaves the region: what is beyond has that of the border, along the line to the centre. A
    /// surface at the distance d has |d|²/B² of a leg's flux.
    fn beyond_border(
        &self,
        from: DVec3,
        direction: DVec3,
        length: f64,
        counters: &mut TraversalCounters,
        landed: &mut Vec<(Texel, f64)>,
    ) {
        let away = from - self.center;
        let along = away.dot(direction);
        let square = along * along - away.length_squared() + self.radius * self.radius;
        if square <= 0.0 {
            return;
        }
        let at = square.sqrt() - along;
        if !(0.0..=length).contains(&at) {
            return;
        }
        let outward = (away + direction * at) / self.radius;
        let ray = Ray::new(self.center + outward * self.radius, outward);
        self.cross(ray, f64::INFINITY, counters, |place, normal, texel| {
            let square = (place - self.center).length_squared() / (self.radius * self.radius);
            let weight = match self.settings.normal {
                Normal::Fixed => square,
                Normal::Exact | Normal::Vector => {
                    square * (-direction.dot(normal)).max(0.0)
                        / (direction.dot(outward) * -normal.dot(outward))
                }
            };
            landed.push((texel, weight));
        });
    }
}
