//! Interactions of one ray with a surface, and the branches along which light goes on.

use glam::DVec3;

use super::flux::Flux;
use super::followed::Followed;
use super::signature::Event;
use crate::geometry::SurfacePoint;
use crate::optics::{
    conductor_reflectance, dielectric_reflectance, reflect, refract, thin_slab_reflectance,
};
use crate::radiometry::Rgb;
use crate::scene::{Color, Material, Scalar, Scene, TexturePoint};

/// Effect of interpolated normals on the flux that a ray carries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ShadingNormals {
    /// Flux changes by Fresnel's equations and absorption only: the ledger closes.
    #[default]
    Flux,
    /// Flux is also scaled by |ωi·ns ωo·ng| / |ωo·ns ωi·ng| at every specular event (Veach 1997, 5.3).
    /// Mitsuba's `ptracer` does so, and any path tracer from the camera implies it.
    Adjoint,
}

/// The ways light can go on from a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Way {
    /// Straight on, as if nothing were there; no event.
    Passed,
    /// Back to the side it came from.
    Reflected,
    /// Through the surface.
    Transmitted,
}

impl Way {
    /// All ways, in the order in which they share a uniform number.
    pub const ALL: [Self; 3] = [Self::Passed, Self::Reflected, Self::Transmitted];

    /// The event that a path's signature records.
    #[inline]
    pub fn event(self) -> Option<Event> {
        match self {
            Self::Passed => None,
            Self::Reflected => Some(Event::Reflection),
            Self::Transmitted => Some(Event::Transmission),
        }
    }
}

/// Light that goes on along one of the ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch<const N: usize> {
    /// The new direction of travel, a unit vector.
    pub direction: DVec3,
    /// The factor that filters and metals put on its flux.
    pub tint: Flux<N>,
}

/// Change of a ray's direction along one of the ways, with the unit normal on the side that light arrives
/// from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bending {
    /// No change: light passes, or crosses a thin pane or matched media.
    Straight,
    /// A mirror reflection.
    Reflection {
        /// The shading normal.
        normal: DVec3,
    },
    /// Snell's law.
    Refraction {
        /// The shading normal.
        normal: DVec3,
        /// `n_transmitted / n_incident`.
        eta: f64,
    },
}

/// Interaction of a ray with a surface: the shares of its light, before their directions are computed.
///
/// The part that neither shares nor tints carry on is absorbed.
pub struct Interaction<'a> {
    point: &'a SurfacePoint,
    direction: DVec3,
    shading_normals: ShadingNormals,
    /// The material inside masks, on the side that light meets; of a blend, the part that transmits, if any.
    material: &'a Material,
    /// The shading normal on the side light arrives from; zero if nothing needs it.
    normal: DVec3,
    /// `n_transmitted / n_incident`; 1 if light goes straight through.
    eta: f64,
    /// Shares by [`Way`].
    shares: [f64; 3],
    /// The share that meets a rough interface; no way leads on from it.
    rough: f64,
    /// The share that a smooth coat over a matt base mirrors.
    coat: f64,
    /// The share that meets a rough coat.
    rough_coat: f64,
    /// Of a blend, its parts' shares with their tints, by [`Way`].
    blended: Option<[Rgb; 3]>,
}

impl<'a> Interaction<'a> {
    /// The interaction of light that travels along `direction` with `material` at `point`.
    #[inline]
    pub fn new(
        scene: &'a Scene,
        material: &'a Material,
        point: &'a SurfacePoint,
        direction: DVec3,
        shading_normals: ShadingNormals,
    ) -> Self {
        let all = scene.materials();
        Self::among((scene, all), material, point, direction, shading_normals)
    }

    /// The interaction with `material`, which is one of these materials: a scene's own, or as light of one
    /// wavelength meets them.
    #[inline]
    pub fn among(
        (scene, materials): (&'a Scene, &'a [Material]),
        material: &'a Material,
        point: &'a SurfacePoint,
        direction: DVec3,
        shading_normals: ShadingNormals,
    ) -> Self {
        let front = direction.dot(point.geometric_normal) < 0.0;
        let mut interaction = Self {
            point,
            direction,
            shading_normals,
            material,
            normal: DVec3::ZERO,
            eta: 1.0,
            shares: [0.0; 3],
            rough: 0.0,
            coat: 0.0,
            rough_coat: 0.0,
            blended: None,
        };
        match material {
            // The commonest end of a chain.
            Material::Diffuse { .. } => {}
            Material::Mask { .. } | Material::TwoSided { .. } | Material::Blend { .. } => {
                interaction.unwrap((scene, materials), material, front);
            }
            _ => interaction.share(material, front, 1.0),
        }
        interaction
    }

    /// Looks through masks and two-sided materials at the material inside.
    fn unwrap(
        &mut self,
        (scene, materials): (&'a Scene, &'a [Material]),
        mut material: &'a Material,
        front: bool,
    ) {
        let mut passed = 0.0;
        let mut weight = 1.0;
        let mut both_sides = false;
        loop {
            match *material {
                Material::Mask { opacity, nested } => {
                    // Chains are refused if an opacity varies (see `LightSpace`), so `uv` is not used.
                    let opacity = scene.scalar(
                        opacity,
                        &TexturePoint {
                            uv: self.point.uv,
                            mesh: None,
                        },
                    );
                    passed += weight * (1.0 - opacity);
                    weight *= opacity;
                    material = &materials[nested.0 as usize];
                    both_sides = false;
                }
                Material::TwoSided {
                    front: material_front,
                    back,
                } => {
                    let side = if front { material_front } else { back };
                    material = &materials[side.0 as usize];
                    both_sides = true;
                }
                _ => break,
            }
        }
        if let Material::Blend { .. } = material {
            self.blended = Some([Rgb::BLACK; 3]);
            self.blend(materials, material, (front, both_sides), weight);
        } else {
            self.share(
                material,
                front || (both_sides && is_doubled(material)),
                weight,
            );
        }
        self.shares[Way::Passed as usize] += passed;
    }

    /// Shares out `weight` of the light among the parts of a blend. They reflect light one way; one part at
    /// most transmits it.
    fn blend(
        &mut self,
        materials: &'a [Material],
        material: &'a Material,
        (front, both_sides): (bool, bool),
        weight: f64,
    ) {
        match *material {
            Material::Blend {
                weight: second,
                nested,
            } => {
                // Chains are refused if it varies and matters (see `LightSpace`).
                let Scalar::Constant(second) = second else {
                    return;
                };
                for (id, share) in nested.into_iter().zip([1.0 - second, second]) {
                    let part = &materials[id.0 as usize];
                    let sides = (front, both_sides);
                    self.blend(materials, part, sides, weight * share);
                }
            }
            Material::TwoSided {
                front: of_front,
                back,
            } => {
                let side = if front { of_front } else { back };
                let part = &materials[side.0 as usize];
                self.blend(materials, part, (front, true), weight);
            }
            _ => {
                let mut part = Self {
                    shares: [0.0; 3],
                    blended: None,
                    ..*self
                };
                part.share(
                    material,
                    front || (both_sides && is_doubled(material)),
                    weight,
                );
                self.add(&part);
            }
        }
    }

    /// Adds a part of a blend.
    fn add(&mut self, part: &Self) {
        for way in [Way::Reflected, Way::Transmitted] {
            let share = part.share_of(way);
            if share > 0.0 {
                self.normal = part.normal;
                self.shares[way as usize] += share;
                if let Some(blended) = &mut self.blended {
                    blended[way as usize] += part.tint::<3>(way, Color::even).rgb() * share;
                }
                if way == Way::Transmitted {
                    (self.material, self.eta) = (part.material, part.eta);
                }
            }
        }
    }

    /// Shares out `weight` of the light at a plain material. `front` is true if light arrives on the side
    /// that a metal coats, or from a dielectric's exterior.
    #[inline]
    fn share(&mut self, material: &'a Material, front: bool, weight: f64) {
        self.material = material;
        match *material {
            Material::Null => self.shares[Way::Passed as usize] = weight,
            Material::Conductor { .. } => {
                if front && self.face() {
                    self.shares[Way::Reflected as usize] = weight;
                }
            }
            Material::Dielectric {
                interior_ior,
                exterior_ior,
                ..
            } => {
                self.eta = if front {
                    interior_ior / exterior_ior
                } else {
                    exterior_ior / interior_ior
                };
                if self.eta == 1.0 {
                    // Matched media: no interface, though Mitsuba still tints and counts it.
                    self.shares[Way::Transmitted as usize] = weight;
                } else if self.face() {
                    self.share_by(
                        dielectric_reflectance(self.cos_incident(), self.eta),
                        weight,
                    );
                }
            }
            Material::ThinDielectric {
                interior_ior,
                exterior_ior,
                ..
            } => {
                if self.face() {
                    let eta = interior_ior / exterior_ior;
                    self.share_by(thin_slab_reflectance(self.cos_incident(), eta), weight);
                }
            }
            // They have no ways, but a direction may be drawn.
            Material::RoughDielectric { .. } => self.rough = weight,
            Material::RoughConductor { .. } => self.rough = if front { weight } else { 0.0 },
            Material::Plastic(coat) => {
                if front && self.face() {
                    let eta = coat.interior_ior / coat.exterior_ior;
                    self.coat = weight * dielectric_reflectance(self.cos_incident(), eta);
                }
            }
            Material::RoughPlastic { .. } => self.rough_coat = if front { weight } else { 0.0 },
            // Interfaces whose normals a texture turns end chains.
            Material::Diffuse { .. }
            | Material::Principled(_)
            | Material::PrincipledThin(_)
            | Material::Turned { .. }
            | Material::Mask { .. }
            | Material::TwoSided { .. }
            | Material::Blend { .. } => {}
        }
    }

    #[inline]
    fn share_by(&mut self, reflectance: f64, weight: f64) {
        self.shares[Way::Reflected as usize] = weight * reflectance;
        self.shares[Way::Transmitted as usize] = weight * (1.0 - reflectance);
    }

    /// Finds the shading normal on the side that light arrives from.
    ///
    /// False if the shading normal and the true one disagree about that side. Such light is absorbed, as in
    /// Mitsuba's `ptracer`.
    #[inline]
    fn face(&mut self) -> bool {
        let shading = self.point.shading_normal;
        let along = self.direction.dot(shading);
        let true_along = self.direction.dot(self.point.geometric_normal);
        self.normal = if along < 0.0 { shading } else { -shading };
        along * true_along > 0.0
    }

    #[inline]
    fn cos_incident(&self) -> f64 {
        -self.direction.dot(self.normal)
    }

    /// The share (0..=1) of the arriving flux that goes this way, before its tint.
    #[inline]
    pub fn share_of(&self, way: Way) -> f64 {
        self.shares[way as usize]
    }

    /// Lets light go on from what is followed beside mirrors and glass.
    #[inline]
    pub fn follow(&mut self, followed: Followed) {
        if followed >= Followed::Rough {
            self.shares[Way::Reflected as usize] += self.coat;
        } else {
            self.rough = 0.0;
            self.coat = 0.0;
        }
        if followed < Followed::All {
            self.rough_coat = 0.0;
        }
    }

    /// True if no light goes on along any way.
    #[inline]
    pub fn is_end(&self) -> bool {
        self.shares == [0.0; 3]
    }

    /// The share (0..=1) of the arriving flux that meets a rough interface or coat: see
    /// [`glossy`](super::glossy).
    #[inline]
    pub fn rough_share(&self) -> f64 {
        self.rough + self.rough_coat
    }

    /// True if it meets a coat: what that does not reflect ends at the base, as light at any matt surface.
    #[inline]
    pub fn is_coated(&self) -> bool {
        self.coat > 0.0 || self.rough_coat > 0.0
    }

    /// The way into whose share `choice`, uniform in [0, 1), falls; `None` for absorption.
    #[inline]
    pub fn choose(&self, choice: f64) -> Option<Way> {
        let [passed, reflected, transmitted] = self.shares;
        if choice < passed {
            Some(Way::Passed)
        } else if choice < passed + reflected {
            Some(Way::Reflected)
        } else if choice < passed + reflected + transmitted {
            Some(Way::Transmitted)
        } else {
            None
        }
    }

    /// The branch along a way with a share above zero; `None` if the true surface is in its way.
    ///
    /// Factors must be the same everywhere: textures are black.
    #[inline]
    pub fn branch<const N: usize>(&self, way: Way) -> Option<Branch<N>> {
        self.branch_tinted(way, Color::even)
    }

    /// The same for factors of any kind, which `value_of` looks up.
    #[inline]
    pub fn branch_tinted<const N: usize>(
        &self,
        way: Way,
        value_of: impl FnOnce(&Color) -> Rgb,
    ) -> Option<Branch<N>> {
        match way {
            Way::Passed => Some(Branch {
                direction: self.direction,
                tint: Flux::WHITE,
            }),
            Way::Reflected => {
                let direction = reflect(self.direction, self.normal);
                self.checked(direction, self.tint(way, value_of), true)
            }
            Way::Transmitted => match self.material {
                Material::Dielectric { .. } if self.eta != 1.0 => {
                    let direction = refract(self.direction, self.normal, self.eta)?;
                    self.checked(direction, self.tint(way, value_of), false)
                }
                Material::Dielectric { .. } | Material::ThinDielectric { .. } => Some(Branch {
                    direction: self.direction,
                    tint: self.tint(way, value_of),
                }),
                _ => None,
            },
        }
    }

    /// The factor that filters and metals put on the flux along a way with a share above zero.
    #[inline]
    fn tint<const N: usize>(&self, way: Way, value_of: impl FnOnce(&Color) -> Rgb) -> Flux<N> {
        if let Some(blended) = &self.blended {
            return Flux::of(blended[way as usize] / self.share_of(way));
        }
        match (way, self.material) {
            (Way::Passed, _) => Flux::WHITE,
            (
                Way::Reflected,
                Material::Dielectric {
                    specular_reflectance: filter,
                    ..
                }
                | Material::ThinDielectric {
                    specular_reflectance: filter,
                    ..
                },
            )
            | (
                Way::Transmitted,
                Material::Dielectric {
                    specular_transmittance: filter,
                    ..
                }
                | Material::ThinDielectric {
                    specular_transmittance: filter,
                    ..
                },
            ) => Flux::of(value_of(filter)),
            (Way::Reflected, Material::Plastic(coat)) => {
                Flux::of(value_of(&coat.specular_reflectance))
            }
            _ => self.metallic_tint(value_of),
        }
    }

    /// The change of direction along a way with a share above zero. It also serves those who follow the light
    /// beside the ray.
    pub fn bending(&self, way: Way) -> Bending {
        let normal = self.normal;
        match (way, self.material) {
            (Way::Reflected, _) => Bending::Reflection { normal },
            (Way::Transmitted, Material::Dielectric { .. }) if self.eta != 1.0 => {
                Bending::Refraction {
                    normal,
                    eta: self.eta,
                }
            }
            _ => Bending::Straight,
        }
    }

    /// The share of each channel that a metal reflects.
    #[inline]
    fn metallic_tint<const N: usize>(&self, value_of: impl FnOnce(&Color) -> Rgb) -> Flux<N> {
        let Material::Conductor {
            eta,
            k,
            specular_reflectance,
        } = self.material
        else {
            return Flux::BLACK;
        };
        let cos_incident = self.cos_incident();
        let reflectance = |c: usize| conductor_reflectance(cos_incident, eta.0[c], k.0[c]);
        let metal = if eta.is_grey() && k.is_grey() {
            Flux([reflectance(0); N])
        } else {
            Flux(std::array::from_fn(reflectance))
        };
        Flux::of(value_of(specular_reflectance)) * metal
    }

    /// The branch, unless the true surface is in its way.
    #[inline]
    fn checked<const N: usize>(
        &self,
        direction: DVec3,
        mut tint: Flux<N>,
        reflects: bool,
    ) -> Option<Branch<N>> {
        let geometric = self.point.geometric_normal;
        let arrived = self.direction.dot(geometric);
        let leaves = direction.dot(geometric);
        if (arrived * leaves < 0.0) != reflects || leaves == 0.0 {
            return None;
        }
        if self.shading_normals == ShadingNormals::Adjoint && self.point.shading_normal != geometric
        {
            let factor = (self.direction.dot(self.normal) * leaves
                / (direction.dot(self.normal) * arrived))
                .abs();
            tint = tint * factor;
        }
        Some(Branch { direction, tint })
    }
}

/// True of what a two-sided material has on both of its sides.
fn is_doubled(material: &Material) -> bool {
    matches!(
        material,
        Material::Conductor { .. }
            | Material::RoughConductor { .. }
            | Material::Plastic(_)
            | Material::RoughPlastic { .. }
    )
}
