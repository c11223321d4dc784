//! Charts over all emitters, divided into cells that can make caustics.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::chart::{Falloff, LightChart};
use super::normal_light::NormalLight;
use super::patch::ChartPatch;
use super::probe::Probe;
use super::sky::Sky;
use super::surface::{LightPart, LightSurface};
use super::textured::TexturedPart;
use crate::geometry::{Bounds, Shape};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, MAX_SHINING_TRIANGLES, Material, Object, Scene, ShapeId};
use crate::transport::chain_limits::{self, NotFollowed};
use crate::transport::followed::Followed;

/// Number of cells at which division ends.
///
/// The cells then follow the outline of the specular geometry (about 5 % of a ball's cells are at its rim). A
/// cell's rays also stay together.
const ENOUGH_CELLS: usize = 2048;

/// Largest share of samples of light that meets coats only, for its flux: they reflect 4 % of most of it.
const SHARE_OF_COATS: f64 = 1.0 / 16.0;

/// Largest number of divisions: a patch 2⁻³⁹ wide still holds thousands of `f64` places.
const MAX_LEVEL: u32 = 40;

/// A patch of a chart whose light may meet specular geometry.
#[derive(Clone, Copy, Debug)]
pub struct LightCell {
    chart: u32,
    patch: ChartPatch,
}

impl LightCell {
    /// Its chart, as an index into [`LightSpace::charts`].
    pub fn chart(&self) -> usize {
        self.chart as usize
    }

    /// Its part of the chart.
    pub fn patch(&self) -> &ChartPatch {
        &self.patch
    }
}

/// All light that can meet specular geometry, as a list of cells.
#[derive(Debug)]
pub struct LightSpace {
    charts: Vec<LightChart>,
    /// The emitter of each chart, as an index into the scene's.
    emitters: Vec<u32>,
    cells: Vec<LightCell>,
    /// Sum of the shares of all cells before each; one longer than `cells`, from 0 to 1.
    cumulative: Vec<f64>,
    flux_bound: Rgb,
    level: u32,
    specular_bounds: Bounds,
}

/// Reason why light space cannot be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LightSpaceError {
    /// The shape of an area light has no charts.
    #[error(
        "the {emitter} emitter on shape \"{shape}\" ({plugin}) is not modelled; area lights can be \
         rectangle, disk, sphere, cube and meshes of at most {MAX_SHINING_TRIANGLES} triangles"
    )]
    AreaShape {
        /// Mitsuba's name of the emitter.
        emitter: &'static str,
        /// The shape.
        shape: String,
        /// Mitsuba's name of the shape.
        plugin: &'static str,
    },
    /// Chains cannot be followed in the scene.
    #[error(transparent)]
    NotFollowed(#[from] NotFollowed),
}

impl LightSpace {
    /// The part of the scene's light that may meet specular geometry.
    ///
    /// # Errors
    ///
    /// If the shape of an area light is not modelled, or chains cannot be followed in the scene.
    pub fn new(scene: &Scene) -> Result<Self, LightSpaceError> {
        Self::aimed(scene, Followed::Smooth)
    }

    /// Fails if the scene's light has no light space, without building one.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn check(scene: &Scene) -> Result<(), LightSpaceError> {
        chain_limits::check(scene)?;
        let mut shining = scene.emitters().iter();
        shining.try_for_each(|emitter| match emitter.shape() {
            Some(shape) if !emitter.strength().is_black() => {
                surface_of(scene, emitter, shape).map(drop)
            }
            _ => Ok(()),
        })
    }

    /// The part of the scene's light that may meet geometry from which chains go on. Cells from which it
    /// meets nothing but coats have a [smaller share](SHARE_OF_COATS) of samples.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn aimed(scene: &Scene, followed: Followed) -> Result<Self, LightSpaceError> {
        chain_limits::check(scene)?;
        let holds = |material: &Material| followed.holds(material, scene.materials());
        let targets = Targets::new(scene, holds);
        let mut charts = Vec::new();
        let mut emitters = Vec::new();
        for (index, emitter) in scene.emitters().iter().enumerate() {
            if !emitter.strength().is_black() {
                add_charts(scene, emitter, targets.ball(), &mut charts)?;
                emitters.resize(charts.len(), index as u32);
            }
        }
        let mut cells: Vec<LightCell> = (0..charts.len() as u32)
            .map(|chart| LightCell {
                chart,
                patch: charts[chart as usize].root(&targets.bounds),
            })
            .filter(|cell| targets.may_be_met(&charts, cell))
            .collect();
        let bare = Targets::without_coats(scene, followed);
        let meets_coats_only = |cell: &LightCell| {
            let bare = bare.as_ref();
            bare.is_some_and(|bare| !bare.may_be_met(&charts, cell))
        };
        // All of a sky meets the specular geometry, and all light of a room may meet a coat: their cells must
        // not take the room of those that follow the outline.
        let kind = |cell: &LightCell| match charts[cell.chart as usize] {
            LightChart::Sky(_) => 1,
            _ if meets_coats_only(cell) => 2,
            _ => 0,
        };
        let mut level = 0;
        while level < MAX_LEVEL {
            let kinds: Vec<usize> = cells.par_iter().map(kind).collect();
            let are_divided = [0, 1, 2].map(|kind| {
                let count = kinds.iter().filter(|one| **one == kind).count();
                (1..ENOUGH_CELLS).contains(&count)
            });
            if are_divided == [false; 3] {
                break;
            }
            level += 1;
            // A parallel map over indices: the order does not depend on the number of threads.
            cells = cells
                .par_iter()
                .zip(&kinds)
                .flat_map_iter(|(cell, kind)| {
                    if are_divided[*kind] {
                        targets.quarters(&charts, cell).collect()
                    } else {
                        vec![*cell]
                    }
                })
                .collect();
        }
        let (cells, bounds) = targets.by_share(&charts, cells);
        let flux_bound: Rgb = bounds.iter().copied().sum();
        let mut weights: Vec<f64> = bounds.iter().map(|flux| flux.mean()).collect();
        if bare.is_some() {
            let of_coats: Vec<bool> = cells.par_iter().map(meets_coats_only).collect();
            weigh_coats(&mut weights, &of_coats);
        }
        let total: f64 = weights.iter().sum();
        let mut cumulative = vec![0.0];
        let mut sum = 0.0;
        for weight in &weights {
            sum += weight;
            cumulative.push(sum / total);
        }
        Ok(Self {
            charts,
            emitters,
            cells,
            cumulative,
            flux_bound,
            level,
            specular_bounds: targets.bounds,
        })
    }

    /// The charts over all emitters.
    pub fn charts(&self) -> &[LightChart] {
        &self.charts
    }

    /// The emitter that a chart covers, at least in part, as an index into the scene's emitters.
    pub fn emitter_of(&self, chart: usize) -> usize {
        self.emitters[chart] as usize
    }

    /// The patch that all of a chart's cells were divided from.
    pub fn root(&self, chart: &LightChart) -> ChartPatch {
        chart.root(&self.specular_bounds)
    }

    /// True if a place on a chart lies in a cell, so that light from there may meet specular geometry.
    ///
    /// It looks at every cell, so it is for tests and pictures.
    pub fn holds(&self, chart: usize, place: DVec2) -> bool {
        self.cells.iter().any(|cell| {
            let ChartPatch { from, to } = cell.patch;
            cell.chart as usize == chart && from.cmple(place).all() && place.cmple(to).all()
        })
    }

    /// The cells, neighbours near each other.
    pub fn cells(&self) -> &[LightCell] {
        &self.cells
    }

    /// True if no light can meet specular geometry.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The flux of all cells \[W\], or a little more (see [`LightChart::flux_bound`]).
    pub fn flux_bound(&self) -> Rgb {
        self.flux_bound
    }

    /// Number of times that the charts were divided.
    pub fn level(&self) -> u32 {
        self.level
    }

    /// True if any cell needs four dimensions: light that starts from a surface.
    pub fn has_area(&self) -> bool {
        self.charts.iter().any(LightChart::has_area)
    }

    /// The share (0..=1) of all samples that a cell has; they sum to 1. It is that of all cells' flux, unless
    /// others were [given](Self::share_by).
    #[inline]
    pub fn share(&self, cell: usize) -> f64 {
        self.cumulative[cell + 1] - self.cumulative[cell]
    }

    /// Gives cells shares by which a sample of all is likely to vary least: half of each by its flux, as
    /// before, and half by √(share · q). Here q is the sum of the squared contributions of the cell's
    /// samples.
    pub fn share_by(&mut self, squares: &[f64]) {
        let important = |cell: usize| (self.share(cell) * squares[cell]).sqrt();
        let important: Vec<f64> = (0..self.cells.len()).map(important).collect();
        let all: f64 = important.iter().sum();
        if !(all > 0.0 && all.is_finite()) {
            return;
        }
        let (mut sum, mut cumulative) = (0.0, vec![0.0]);
        for (cell, important) in important.iter().enumerate() {
            sum += important / all;
            cumulative.push(0.5 * (self.cumulative[cell + 1] + sum));
        }
        // To the bit: no rounding may add a sample.
        cumulative[important.len()] = 1.0;
        self.cumulative = cumulative;
    }

    /// Number of the `count` samples that a cell gets, by systematic sampling.
    ///
    /// Cell c gets ⌊count · C(c+1) + offset⌋ − ⌊count · C(c) + offset⌋, with C the cumulative shares. Over a
    /// uniform `offset` in [0, 1) its mean is `count` times the cell's share.
    #[inline]
    pub fn allotment(&self, cell: usize, count: u64, offset: f64) -> u64 {
        let before = |c: usize| (self.cumulative[c] * count as f64 + offset).floor();
        (before(cell + 1) - before(cell)) as u64
    }

    /// The chart that a cell is part of.
    pub fn chart(&self, cell: usize) -> &LightChart {
        &self.charts[self.cells[cell].chart as usize]
    }
}

/// The geometry from which chains go on.
struct Targets<'a> {
    scene: &'a Scene,
    /// For each shape, true if chains go on from it and it is found by its boxes.
    specular: Vec<bool>,
    balls: Vec<(DVec3, f64)>,
    any_others: bool,
    bounds: Bounds,
}

impl<'a> Targets<'a> {
    /// Those that are no coats; `None` if chains go on from no coat.
    fn without_coats(scene: &'a Scene, followed: Followed) -> Option<Self> {
        let all = scene.materials();
        let mut objects = scene.objects().iter();
        let is_coat = |object: &Object| scene.material(object.material).has_coat(all);
        (followed > Followed::Smooth && objects.any(is_coat))
            .then(|| Self::new(scene, |material| followed.holds_bare(material, all)))
    }

    /// The shapes with a material for which `holds` is true.
    fn new(scene: &'a Scene, holds: impl Fn(&Material) -> bool) -> Self {
        let mut targets = Self {
            scene,
            specular: Vec::new(),
            balls: Vec::new(),
            any_others: false,
            bounds: Bounds::EMPTY,
        };
        for (index, shape) in scene.world().shapes().iter().enumerate() {
            let specular = holds(scene.material_of(index as u32));
            let mut in_tree = false;
            if specular {
                targets.bounds = targets.bounds.union(shape.bounds());
                // A ball is not tested by its box: it fills only half of it.
                match shape {
                    Shape::Sphere(sphere) => {
                        targets.balls.push((sphere.center(), sphere.radius()));
                    }
                    _ => in_tree = true,
                }
            }
            targets.any_others |= in_tree;
            targets.specular.push(in_tree);
        }
        targets
    }

    /// A ball (its middle and radius) that holds all specular shapes, about the middle of their bounds.
    ///
    /// `None` if there are none.
    fn ball(&self) -> Option<(DVec3, f64)> {
        if self.bounds.is_empty() {
            return None;
        }
        let center = self.bounds.center();
        let of_balls = self
            .balls
            .iter()
            .map(|(of, radius)| of.distance(center) + radius);
        let shapes = self.scene.world().shapes().iter().zip(&self.specular);
        let of_boxes = shapes.filter(|(_, in_tree)| **in_tree).map(|(shape, _)| {
            // The corner that is farthest away.
            let bounds = shape.bounds();
            ((bounds.center() - center).abs() + 0.5 * bounds.extent()).length()
        });
        let radius = of_boxes.chain(of_balls).fold(0.0, f64::max);
        Some((center, radius))
    }

    /// The quarters of a cell whose light may meet specular geometry.
    fn quarters(&self, charts: &[LightChart], cell: &LightCell) -> impl Iterator<Item = LightCell> {
        let chart = cell.chart;
        let quarters = cell
            .patch
            .quarters()
            .map(|patch| LightCell { chart, patch });
        quarters
            .into_iter()
            .filter(|cell| self.may_be_met(charts, cell))
    }

    /// The cells and bounds of their flux \[W\]. A sun in an image is in few cells: these are divided until
    /// each has its share.
    fn by_share(&self, charts: &[LightChart], cells: Vec<LightCell>) -> (Vec<LightCell>, Vec<Rgb>) {
        let chart = |cell: &LightCell| &charts[cell.chart as usize];
        let bounded = |cell: LightCell| (cell, chart(&cell).flux_bound(&cell.patch));
        let mut all: Vec<(LightCell, Rgb)> = cells.into_par_iter().map(bounded).collect();
        for _ in 0..MAX_LEVEL {
            let total: f64 = all.iter().map(|(_, flux)| flux.mean()).sum();
            let is_chosen = |(cell, flux): &(LightCell, Rgb)| {
                chart(cell).is_uneven(&cell.patch) && flux.mean() * ENOUGH_CELLS as f64 > total
            };
            if !all.iter().any(is_chosen) {
                break;
            }
            all = all
                .into_par_iter()
                .flat_map_iter(|one| {
                    if is_chosen(&one) {
                        self.quarters(charts, &one.0).map(bounded).collect()
                    } else {
                        vec![one]
                    }
                })
                .collect();
        }
        // A patch beside a bright texel may turn out to be black.
        all.retain(|(_, flux)| !flux.is_black());
        all.into_iter().unzip()
    }

    fn may_be_met(&self, charts: &[LightChart], cell: &LightCell) -> bool {
        let chart = &charts[cell.chart as usize];
        if chart.is_dark(&cell.patch) {
            return false;
        }
        let probe: Probe = chart.probe(&cell.patch);
        self.balls
            .iter()
            .any(|(center, radius)| probe.may_overlap_ball(*center, *radius))
            || self.any_others
                && self.scene.world().any_primitive_box(
                    |shape| self.specular[shape as usize],
                    |bounds| probe.may_overlap_box(bounds),
                )
    }
}

/// Gives light that meets coats only its [share](SHARE_OF_COATS) of samples, and together no more than all
/// other light has.
fn weigh_coats(weights: &mut [f64], of_coats: &[bool]) {
    let sum = |are_coats: bool| -> f64 {
        let pairs = weights.iter().zip(of_coats);
        let own = pairs.filter(|(_, of_coats)| **of_coats == are_coats);
        own.map(|(weight, _)| weight).sum()
    };
    let (others, coats) = (sum(false), sum(true));
    if others > 0.0 && coats > 0.0 {
        let scale = SHARE_OF_COATS.min(others / coats);
        let pairs = weights.iter_mut().zip(of_coats);
        for (weight, _) in pairs.filter(|(_, of_coats)| **of_coats) {
            *weight *= scale;
        }
    }
}

/// The charts that cover an emitter's light.
fn add_charts(
    scene: &Scene,
    emitter: &Emitter,
    specular: Option<(DVec3, f64)>,
    charts: &mut Vec<LightChart>,
) -> Result<(), LightSpaceError> {
    match emitter {
        Emitter::Point {
            position,
            intensity,
        } => charts.extend(cube_faces(&DMat3::IDENTITY).map(|axes| LightChart::Face {
            origin: *position,
            axes,
            intensity: *intensity,
            falloff: Falloff::None,
            slide: None,
        })),
        Emitter::Projector { slide, irradiance } => charts.push(LightChart::Projector {
            slide: slide.clone(),
            irradiance: *irradiance,
        }),
        Emitter::Spot {
            to_world,
            intensity,
            slide,
            ..
        } => {
            let axis = to_world.vector(DVec3::Z).normalize();
            // An image's sides are those of its face.
            let (x, y) = match slide {
                Some(slide) => (slide.axes()[0], slide.axes()[1]),
                None => axis.any_orthonormal_pair(),
            };
            let falloff = Falloff::of(emitter);
            let origin = to_world.point(DVec3::ZERO);
            let faces = cube_faces(&DMat3::from_cols(x, y, axis)).map(|axes| LightChart::Face {
                origin,
                axes,
                intensity: *intensity,
                falloff,
                slide: slide.clone(),
            });
            charts.extend(faces);
        }
        Emitter::Directional {
            direction,
            irradiance,
        } => {
            let bounds = scene.world().bounds();
            let (x, y) = direction.any_orthonormal_pair();
            charts.push(LightChart::Parallel {
                origin: bounds.center() - *direction * (bounds.radius() * 1.01),
                across: [x, y],
                direction: *direction,
                irradiance: *irradiance,
            });
        }
        Emitter::Area {
            shape,
            radiance,
            texture,
        } => {
            let surface = surface_of(scene, emitter, *shape)?;
            match texture {
                None => {
                    for part in surface.parts() {
                        add_area_charts(part, *radiance, None, charts);
                    }
                }
                Some(id) => {
                    for part in TexturedPart::all(scene, *shape, *id, &surface) {
                        let (even, light) = (part.even(), part.light());
                        match even {
                            Some(value) => add_area_charts(&light, *radiance * value, None, charts),
                            None => add_area_charts(&light, *radiance, Some(part), charts),
                        }
                    }
                }
            }
        }
        Emitter::DirectionalArea { shape, .. } => {
            let Some(parts) = NormalLight::parts(scene, emitter) else {
                return Err(not_modelled(scene, emitter, *shape));
            };
            let faces = cube_faces(&DMat3::IDENTITY);
            let all = parts.into_iter().flat_map(|part| part.charts(&faces));
            charts.extend(all.map(Box::new).map(LightChart::Normal));
        }
        Emitter::Constant { .. } | Emitter::Envmap(_) | Emitter::Sunsky(_) => {
            // No ball if nothing mirrors or refracts.
            if let Some(ball) = specular {
                let parts = Sky::parts(emitter, ball, &scene.world().bounds());
                charts.extend(parts.map(LightChart::Sky));
            }
        }
    }
    Ok(())
}

/// The charts over a part of a surface that shines in all directions.
fn add_area_charts(
    part: &LightPart,
    radiance: Rgb,
    texture: Option<TexturedPart>,
    charts: &mut Vec<LightChart>,
) {
    let textured = texture.map(Box::new);
    match *part {
        LightPart::Flat(area, normal) => {
            let (x, y) = normal.any_orthonormal_pair();
            charts.push(LightChart::Flat {
                area,
                axes: [x, y, normal],
                radiance,
                texture: textured,
            });
        }
        LightPart::Ball { center, radius } => {
            charts.extend(cube_faces(&DMat3::IDENTITY).map(|axes| LightChart::Ball {
                center,
                radius,
                axes,
                radiance,
                texture: textured.clone(),
            }));
        }
    }
}

/// The surface of a shape that shines.
fn surface_of(
    scene: &Scene,
    emitter: &Emitter,
    shape: ShapeId,
) -> Result<LightSurface, LightSpaceError> {
    let surface = LightSurface::new(&scene.world().shapes()[shape.0 as usize]);
    surface.ok_or_else(|| not_modelled(scene, emitter, shape))
}

fn not_modelled(scene: &Scene, emitter: &Emitter, shape: ShapeId) -> LightSpaceError {
    let object = &scene.objects()[shape.0 as usize];
    LightSpaceError::AreaShape {
        emitter: emitter.plugin(),
        shape: object.id.clone(),
        plugin: object.plugin,
    }
}

/// Frames of the six faces of a cube about the frame given by the columns of `frame`.
fn cube_faces(frame: &DMat3) -> [[DVec3; 3]; 6] {
    let [x, y, z] = [frame.x_axis, frame.y_axis, frame.z_axis];
    [
        [y, z, x],
        [z, y, -x],
        [z, x, y],
        [x, z, -y],
        [x, y, z],
        [y, x, -z],
    ]
}
