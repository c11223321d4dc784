//! A light's volume: its beams, from the triangles of water down to the lowest plane.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::beam::{Beam, Ruling};
use super::refract::{Refracted, refracted, refracted_at_vertex};
use super::settings::Settings;
use super::shadow::ShadowMap;
use super::slicing::Slicing;
use super::variants::{BeamFlux, BySteps, Step, Transmittance, WaterShadow, WaterSurface};
use super::water::Water;
use super::work::Work;
use crate::approximation::interface::Fresnel;
use crate::geometry::{SurfacePoint, TraversalCounters};
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::run::Progress;
use crate::scene::Scene;
use crate::transport::first_surface::Source;
use crate::transport::visibility::transmittance;

/// All that beams of one light depend on.
#[derive(Clone, Copy)]
pub struct Lit<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The settings.
    pub settings: &'a Settings,
    /// The light.
    pub source: &'a Source,
    /// The water.
    pub water: &'a Water,
    /// The planes.
    pub slicing: &'a Slicing,
    /// The wish to stop: light that was not gathered then is left out.
    pub progress: &'a Progress,
}

/// A vertex of the water in the light.
#[derive(Clone, Copy, Debug)]
pub struct LitVertex {
    light: Refracted,
    ruling: Ruling,
    /// The product of the stages that a device computes at vertices.
    weight: f64,
    /// True if nothing hides it from the light, as far as stage `shadow` tells.
    pub is_lit: bool,
}

impl LitVertex {
    /// Its ray.
    pub fn ruling(&self) -> &Ruling {
        &self.ruling
    }

    /// Flux that goes on there by the source's strength, for a unit of area across an axis.
    pub fn brightness(&self, axis: DVec3) -> f64 {
        self.light.density * self.light.incident.dot(axis).abs() * self.weight
    }
}

/// Light in flat water.
#[derive(Clone, Copy, Debug)]
pub struct FlatWater {
    /// Its unit direction below the surface: `L_flat`.
    pub direction: DVec3,
    /// Irradiance \[W/m²\] on a flat surface below it, by the source's strength.
    pub irradiance: f64,
    /// The water's colour.
    pub tint: Rgb,
}

impl FlatWater {
    /// The light of a source below the middle of a water surface.
    ///
    /// `None` if it does not come from above.
    pub fn new(scene: &Scene, water: &Water, source: &Source, normal: DVec3) -> Option<Self> {
        let places = water.vertices.iter().map(|vertex| vertex.position);
        let middle = places.sum::<DVec3>() / water.vertices.len().max(1) as f64;
        let point = SurfacePoint {
            position: middle,
            position_error: DVec3::ZERO,
            geometric_normal: normal,
            shading_normal: normal,
            uv: DVec2::ZERO,
        };
        let light = refracted(scene, water.shape(), &point, source, Fresnel::Exact)?;
        // Without a spot's falloff: the middle of the water may be out of its cone.
        let density = match source {
            Source::Point { origin, .. } => 1.0 / origin.distance_squared(middle),
            Source::Parallel { .. } => 1.0,
        };
        Some(Self {
            direction: light.direction,
            irradiance: density * light.incident.dot(normal).abs() * light.share,
            tint: light.tint,
        })
    }
}

impl Lit<'_> {
    /// The water's vertices in the light; `None` where it does not go down from there.
    pub fn vertices(
        &self,
        map: Option<&ShadowMap>,
        work: &mut BySteps<Work>,
    ) -> Vec<Option<LitVertex>> {
        let vertices = &self.water.vertices;
        let done: Vec<(Option<LitVertex>, u64)> =
            vertices.par_iter().map(|it| self.vertex(it, map)).collect();
        work[Step::Surface as usize].vertices += vertices.len() as u64;
        work[Step::Shadow as usize].rays += done.iter().map(|(_, rays)| rays).sum::<u64>();
        done.into_iter().map(|(vertex, _)| vertex).collect()
    }

    fn vertex(&self, vertex: &SurfacePoint, map: Option<&ShadowMap>) -> (Option<LitVertex>, u64) {
        let fresnel = match self.settings.fresnel {
            Transmittance::None | Transmittance::Exact => Fresnel::None,
            Transmittance::Schlick => Fresnel::Schlick,
            Transmittance::Vertex => Fresnel::Exact,
        };
        let (scene, shape) = (self.scene, self.water.shape());
        let Some(light) = refracted_at_vertex(scene, shape, vertex, self.source, fresnel) else {
            return (None, 0);
        };
        let Some(ruling) = light.ruling(vertex.position, self.slicing) else {
            return (None, 0);
        };
        let mut counters = TraversalCounters::default();
        let is_lit = match (self.settings.shadow, map) {
            (WaterShadow::None | WaterShadow::Exact, _) => true,
            (WaterShadow::Vertex, Some(map)) => map.is_lit(vertex.position),
            (WaterShadow::Vertex, None) => self.reaches(vertex, &mut counters) > 0.0,
        };
        let weight = if is_lit { light.share } else { 0.0 };
        let vertex = LitVertex {
            light,
            ruling,
            weight,
            is_lit,
        };
        (Some(vertex), counters.rays)
    }

    /// The light that the water refracts at a point; `None` if none meets it from outside.
    pub fn refracted(&self, point: &SurfacePoint, fresnel: Fresnel) -> Option<Refracted> {
        refracted(self.scene, self.water.shape(), point, self.source, fresnel)
    }

    /// The share of the light that reaches a point of the water. A crest before it hides it.
    pub fn reaches(&self, point: &SurfacePoint, counters: &mut TraversalCounters) -> f64 {
        let Some(light) = self.source.arrive(point.position) else {
            return 0.0;
        };
        let towards = -light.ray.direction;
        transmittance(self.scene, point, towards, light.distance, counters)
    }

    /// The vertices of a triangle; `None` if a ray does not go down.
    fn corners_of(&self, triangle: u32, vertices: &[Option<LitVertex>]) -> Option<[LitVertex; 3]> {
        let numbers = self.water.triangles[triangle as usize];
        let [a, b, c] = numbers.map(|vertex| vertices[vertex as usize]);
        Some([a?, b?, c?])
    }

    /// The beam below a triangle; `None` if a ray does not go down, or the triangle faces away.
    pub fn beam(&self, triangle: u32, vertices: &[Option<LitVertex>]) -> Option<Beam> {
        let lit = self.corners_of(triangle, vertices)?;
        let corners = self.water.corners(triangle);
        let light = self.light(corners, &lit.map(|vertex| vertex.light), self.settings.flux)?;
        Some(Beam {
            rulings: lit.map(|vertex| vertex.ruling),
            light: [0, 1, 2].map(|i| light[i] * lit[i].weight),
            triangle,
            corners: [DVec2::ZERO, DVec2::X, DVec2::Y],
        })
    }

    /// Stage `flux`: the light on a triangle, by each of its corners as if all of it were there \[m²\].
    /// `None` if it faces away from the light.
    fn light(
        &self,
        corners: [DVec3; 3],
        light: &[Refracted; 3],
        flux: BeamFlux,
    ) -> Option<[f64; 3]> {
        let [a, b, c] = corners;
        // Twice the area, on the side of the outer normal: light arrives against it.
        let across = (b - a).cross(c - a);
        let upward = across * across.dot(self.slicing.axis()).signum();
        let falling = light.each_ref().map(|it| -0.5 * it.incident.dot(upward));
        if falling.iter().any(|area| *area <= 0.0) {
            return None;
        }
        let area = 0.5 * upward.length();
        Some([0, 1, 2].map(|i| {
            light[i].density
                * match flux {
                    BeamFlux::Exact => falling[i],
                    BeamFlux::Literal => area,
                }
        }))
    }

    /// True if all vertices of a triangle are in shadow.
    pub fn is_dark(&self, triangle: u32, vertices: &[Option<LitVertex>]) -> bool {
        let corners = self.corners_of(triangle, vertices);
        corners.is_some_and(|corners| corners.iter().all(|vertex| !vertex.is_lit))
    }

    /// The flux of a beam by the source's strength, from stage to stage.
    pub fn flux(&self, beam: &Beam, vertices: &[Option<LitVertex>]) -> Option<BeamFluxes> {
        let lit = self.corners_of(beam.triangle, vertices)?;
        let (corners, refracted) = (self.water.corners(beam.triangle), lit.map(|it| it.light));
        let mean = |values: [f64; 3]| values.iter().sum::<f64>() / 3.0;
        let begun = self.light(corners, &refracted, self.settings.flux)?;
        Some(BeamFluxes {
            falling: mean(self.light(corners, &refracted, BeamFlux::Exact)?),
            begun: mean(begun),
            transmitted: mean([0, 1, 2].map(|i| begun[i] * lit[i].light.share)),
            lit: mean(beam.light),
        })
    }

    /// The beam below a triangle, ready to be divided; `None` where there is none.
    pub fn whole(&self, triangle: u32, vertices: &[Option<LitVertex>]) -> Option<Whole> {
        Some(Whole {
            beam: self.beam(triangle, vertices)?,
            weights: self
                .corners_of(triangle, vertices)?
                .map(|vertex| vertex.weight),
        })
    }

    /// A ray at a place of a triangle, by barycentric weights of its second and third vertex: as stage
    /// `surface` has it. `None` where there is none.
    pub fn corner(&self, whole: &Whole, at: DVec2) -> Option<Corner> {
        let mix = [1.0 - at.x - at.y, at.x, at.y];
        if self.settings.surface == WaterSurface::Triangles {
            return Some(Corner::between(&whole.beam, at, mix));
        }
        let point = self.water.place(self.scene, whole.beam.triangle, at)?;
        let light = self.refracted(&point, Fresnel::None)?;
        Some(Corner {
            at,
            ruling: light.ruling(point.position, self.slicing)?,
            place: point.position,
            refracted: Some(light),
            light: (0..3).map(|i| whole.weights[i] * mix[i]).sum(),
        })
    }

    /// The beams below the quarters of a triangle, quartered `levels` times.
    pub fn cells(&self, whole: &Whole, levels: u32) -> Vec<Beam> {
        let lattice = Lattice::new(levels, |at| self.corner(whole, at));
        let cells = lattice.cells();
        let found = cells.filter_map(|[a, b, c]| self.cell(whole, [(*a)?, (*b)?, (*c)?], levels));
        found.collect()
    }

    /// The beam between three rays of a triangle, which is one of the parts that it has after it was
    /// quartered `levels` times.
    pub fn cell(&self, whole: &Whole, corners: [Corner; 3], levels: u32) -> Option<Beam> {
        let light = match corners.map(|corner| corner.refracted) {
            [Some(a), Some(b), Some(c)] => {
                let places = corners.map(|corner| corner.place);
                let light = self.light(places, &[a, b, c], self.settings.flux)?;
                [0, 1, 2].map(|i| light[i] * corners[i].light)
            }
            _ => corners.map(|corner| corner.light * math::powf(0.5_f64, 2.0 * f64::from(levels))),
        };
        Some(Beam {
            rulings: corners.map(|corner| corner.ruling),
            light,
            triangle: whole.beam.triangle,
            corners: corners.map(|corner| corner.at),
        })
    }
}

/// A beam's flux by the source's strength \[m²\], from stage to stage.
#[derive(Clone, Copy, Debug)]
pub struct BeamFluxes {
    /// What falls on the triangle.
    pub falling: f64,
    /// What stage `flux` takes it for.
    pub begun: f64,
    /// What the water lets through.
    pub transmitted: f64,
    /// What is not in shadow.
    pub lit: f64,
}

/// A beam that is to be divided.
#[derive(Clone, Copy, Debug)]
pub struct Whole {
    /// The beam.
    pub beam: Beam,
    /// The product of the stages that a device computes at its vertices.
    weights: [f64; 3],
}

/// A ray at a corner of a part of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Barycentric weights of the triangle's second and third vertex.
    pub at: DVec2,
    /// The ray.
    pub ruling: Ruling,
    /// The place where it leaves the water's surface.
    pub place: DVec3,
    /// The light there; `None` of a ray between those of the triangle's vertices.
    refracted: Option<Refracted>,
    /// The product of the stages at vertices, linear between; without light there, the whole beam's light.
    light: f64,
}

impl Corner {
    /// A ray between those of a beam.
    fn between(whole: &Beam, at: DVec2, mix: [f64; 3]) -> Self {
        Self {
            at,
            ruling: whole.ruling(mix),
            place: DVec3::ZERO,
            refracted: None,
            light: (0..3).map(|i| whole.light[i] * mix[i]).sum(),
        }
    }
}

/// Something at the corners of all parts of a triangle that was quartered some times.
pub struct Lattice<T> {
    parts: u32,
    corners: Vec<T>,
}

impl<T> Lattice<T> {
    /// `corner(at)` at each, with `at` the barycentric weights of the triangle's second and third vertex.
    pub fn new(levels: u32, mut corner: impl FnMut(DVec2) -> T) -> Self {
        let parts = 1_u32 << levels;
        let places = (0..=parts).flat_map(|row| (0..=parts - row).map(move |column| (column, row)));
        let at = |(column, row)| DVec2::new(f64::from(column), f64::from(row)) / f64::from(parts);
        Self {
            parts,
            corners: places.map(|place| corner(at(place))).collect(),
        }
    }

    fn at(&self, column: u32, row: u32) -> &T {
        // Each row has one corner less than the one before.
        let start = row * (self.parts + 1) - row * row.saturating_sub(1) / 2;
        &self.corners[(start + column) as usize]
    }

    /// The corners of each part.
    pub fn cells(&self) -> impl Iterator<Item = [&T; 3]> {
        let squares =
            (0..self.parts).flat_map(|row| (0..self.parts - row).map(move |column| (column, row)));
        squares.flat_map(|(column, row)| {
            let [low, right, above] = [
                self.at(column, row),
                self.at(column + 1, row),
                self.at(column, row + 1),
            ];
            let is_pair = column + 1 < self.parts - row;
            let other = is_pair.then(|| [right, self.at(column + 1, row + 1), above]);
            [Some([low, right, above]), other].into_iter().flatten()
        })
    }
}
