//! Stage `interface` (sections 3.2 and 3.3): photons at a surface, and their ways on.

use glam::DVec3;

use super::ledger::{Fate, Tally};
use super::photon::Photon;
use super::settings::Settings;
use super::variants::{Interface, Splat};
use crate::approximation::interface::{Crossing, Fresnel, cross};
use crate::geometry::{Hit, SurfacePoint};
use crate::numeric::{Stream, StreamKind};
use crate::radiometry::Rgb;
use crate::scene::{Material, Scene};
use crate::transport::scatter::{Interaction, ShadingNormals, Way};

/// Events after which one way is drawn by lot, where all ways are modelled.
const SPLIT_EVENTS: usize = 2;

/// The share of a beam's light from which on it is followed.
const FAINTEST: f64 = 1e-6;

/// What becomes of a photon at a surface.
#[allow(
    clippy::large_enum_variant,
    reason = "it is on the stack, for a moment"
)]
pub enum Meeting {
    /// It lands there.
    Lands,
    /// It ends.
    Ends,
    /// Its ways on, up to three.
    Goes([Option<Photon>; 3]),
}

/// Surfaces as photons meet them.
#[derive(Clone, Copy, Debug)]
pub struct Optics<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The settings.
    pub settings: &'a Settings,
}

impl<'a> Optics<'a> {
    /// The material inside masks, on the side that light meets, and whether a metal has light on both sides.
    fn plain(&self, shape: u32, is_front: bool) -> (&'a Material, bool) {
        let mut material = self.scene.material_of(shape);
        let mut is_two_sided = false;
        loop {
            material = match *material {
                Material::Mask { nested, .. } => self.scene.material(nested),
                Material::TwoSided { front, back } => {
                    is_two_sided = true;
                    self.scene.material(if is_front { front } else { back })
                }
                _ => return (material, is_two_sided),
            };
        }
    }

    /// The paper's tests of normal and medium (section 3.3): light in air enters where the normal is against
    /// its direction, light in a medium leaves where it is along it. Else the interface is ignored.
    ///
    /// Panes and mirrors have no medium behind them. Pictures would show them again in the next texel: the
    /// side that a photon would meet then is not met twice in a row. Where surfaces are traced nothing is
    /// ignored.
    pub fn accepts(&self, photon: &Photon, shape: u32, normal: DVec3, is_traced: bool) -> bool {
        let along = photon.ray.direction.dot(normal);
        let (material, is_two_sided) = self.plain(shape, along < 0.0);
        match material {
            _ if is_traced => true,
            Material::Dielectric { .. } => (along > 0.0) == photon.is_inside,
            Material::Conductor { .. } if !is_two_sided && along < 0.0 => true,
            Material::ThinDielectric { .. } | Material::Conductor { .. } => {
                photon.last != shape || photon.would_meet_front != (along < 0.0)
            }
            _ => true,
        }
    }

    /// What becomes of a photon at a distance along its way, on a surface that it accepts.
    pub fn meet(
        &self,
        photon: &Photon,
        hit: &Hit,
        point: &SurfacePoint,
        tally: &mut Tally,
    ) -> Meeting {
        let scene = self.scene;
        let is_front = photon.ray.direction.dot(point.geometric_normal) < 0.0;
        let (material, _) = self.plain(hit.shape, is_front);
        if !material.is_specular(scene.materials()) {
            return Meeting::Lands;
        }
        if photon.signature.len() >= self.settings.max_depth as usize
            || self.settings.splat == Splat::Exact && photon.flux.max_channel() < FAINTEST
        {
            tally.add(Fate::TooDeep, photon.flux);
            return Meeting::Ends;
        }
        let arrived = Photon {
            length: photon.length + point.position.distance(photon.ray.origin),
            last: hit.shape,
            path: mixed(photon.path, self.element(hit)),
            ..*photon
        };
        match self.settings.interface {
            Interface::Exact => self.all_ways(&arrived, hit, point, tally),
            Interface::Refract
            | Interface::MirrorTotal
            | Interface::Schlick
            | Interface::Fresnel => self.one_way(&arrived, hit, point, tally),
        }
    }

    /// The number of the smooth surface that was hit.
    fn element(&self, hit: &Hit) -> u64 {
        let element = self.scene.world().element(hit);
        u64::from(element.shape) << 32 | u64::from(element.face.map_or(0, |face| face + 1))
    }

    /// The way on at an interface, with the factors on its flux; `None` if there is none.
    fn cross(
        &self,
        photon: &Photon,
        hit: &Hit,
        point: &SurfacePoint,
        way: Way,
        fresnel: Fresnel,
    ) -> Option<Crossing> {
        cross(
            self.scene,
            hit.shape,
            point,
            photon.ray.direction,
            way,
            fresnel,
        )
    }

    /// The photon on one of the ways.
    fn along(
        &self,
        photon: &Photon,
        hit: &Hit,
        point: &SurfacePoint,
        way: Way,
        direction: DVec3,
        flux: Rgb,
    ) -> Photon {
        let is_front = photon.ray.direction.dot(point.geometric_normal) < 0.0;
        let enters = match (way, self.plain(hit.shape, is_front).0) {
            (Way::Transmitted, Material::Dielectric { .. }) => is_front,
            _ => photon.is_inside,
        };
        Photon {
            ray: point.spawn(direction),
            flux,
            is_inside: enters,
            would_meet_front: is_front != (way == Way::Reflected),
            signature: way
                .event()
                .map_or(photon.signature, |event| photon.signature.then(event)),
            path: mixed(photon.path, way as u64),
            ..*photon
        }
    }

    /// The one way that the paper follows: refraction, or reflection by mirrors and in total reflection.
    fn one_way(
        &self,
        photon: &Photon,
        hit: &Hit,
        point: &SurfacePoint,
        tally: &mut Tally,
    ) -> Meeting {
        let fresnel = match self.settings.interface {
            Interface::Refract | Interface::MirrorTotal => Fresnel::None,
            Interface::Schlick => Fresnel::Schlick,
            Interface::Fresnel | Interface::Exact => Fresnel::Exact,
        };
        let is_front = photon.ray.direction.dot(point.geometric_normal) < 0.0;
        let is_mirror = matches!(
            self.plain(hit.shape, is_front).0,
            Material::Conductor { .. }
        );
        let reflects = |fresnel| self.cross(photon, hit, point, Way::Reflected, fresnel);
        let (way, crossing) = if is_mirror {
            (Way::Reflected, reflects(fresnel))
        } else {
            let through = self.cross(photon, hit, point, Way::Transmitted, fresnel);
            match through {
                None if self.settings.interface != Interface::Refract => {
                    (Way::Reflected, reflects(Fresnel::Exact))
                }
                through => (Way::Transmitted, through),
            }
        };
        let Some(crossing) = crossing else {
            let fate = if is_mirror {
                Fate::Behind
            } else {
                Fate::TotalReflection
            };
            tally.add(fate, photon.flux);
            return Meeting::Ends;
        };
        let by_fresnel = photon.flux * crossing.by_fresnel;
        let flux = photon.flux * crossing.throughput;
        tally.change(Fate::Taken, by_fresnel - photon.flux);
        tally.change(Fate::Unmodelled, flux - by_fresnel);
        let next = self.along(photon, hit, point, way, crossing.direction, flux);
        Meeting::Goes([Some(next), None, None])
    }

    /// All ways, each with its share; after some events a photon takes one by lot, with all that it has.
    fn all_ways(
        &self,
        photon: &Photon,
        hit: &Hit,
        point: &SurfacePoint,
        tally: &mut Tally,
    ) -> Meeting {
        let next = |way: Way| self.cross(photon, hit, point, way, Fresnel::Exact);
        let goes = |way: Way, direction: DVec3, flux: Rgb| {
            self.along(photon, hit, point, way, direction, flux)
        };
        let mut ways = [None; 3];
        if self.settings.splat == Splat::Exact || photon.signature.len() < SPLIT_EVENTS {
            for (place, way) in ways.iter_mut().zip(Way::ALL) {
                *place = next(way).map(|crossing| {
                    goes(way, crossing.direction, photon.flux * crossing.throughput)
                });
            }
        } else {
            let material = self.scene.material_of(hit.shape);
            let interaction = Interaction::new(
                self.scene,
                material,
                point,
                photon.ray.direction,
                ShadingNormals::Flux,
            );
            let lots = Stream::new(StreamKind::Random, 0);
            let lot = lots.padded4(photon.index, photon.signature.key())[0];
            ways[0] = interaction.choose(lot).and_then(|way| {
                let crossing = next(way)?;
                Some(goes(way, crossing.direction, photon.flux * crossing.tint))
            });
        }
        let left: Rgb = ways.iter().flatten().map(|one| one.flux).sum();
        tally.change(Fate::Taken, left - photon.flux);
        Meeting::Goes(ways)
    }
}

/// A path's number, and what it came by next, as one number.
fn mixed(path: u64, next: u64) -> u64 {
    // 2^64 / φ, odd.
    const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
    (path.rotate_left(25) ^ next.wrapping_add(1)).wrapping_mul(STEP)
}
