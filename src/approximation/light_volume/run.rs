//! The stages one after the other.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::adaptive::Tolerance;
use super::beam::Beam;
use super::cull::{Culling, Draw, View};
use super::darkness;
use super::deal::{can_deal, deal};
use super::demands;
use super::faint::without_faintest;
use super::gather::gather;
use super::grid::JoinedGrid;
use super::hull::{Hull, Hulls};
use super::ledger::Flow;
use super::quadtree::{Quadtree, lower_left};
use super::search::Drawn;
use super::settings::Settings;
use super::shade::{ShadeWork, Shading};
use super::shadow::ShadowMap;
use super::slicing::{LocalBox, Slicing};
use super::stencil::draw;
use super::sums::Format;
use super::variants::{
    BySteps, Clamp, Inside, Queries, STAGES, ShadowCull, SliceAxis, Step, TexelPoints, WaterShadow,
    WaterSurface,
};
use super::volume::{FlatWater, Lit, LitVertex};
use super::water::{Triangles, Water, mean_normal};
use super::work::Work;
use crate::approximation::clock::{Clocked, Done, stage_work};
use crate::approximation::sources::is_diffuse;
use crate::approximation::{Frame, Receivers, SensorFilm};
use crate::geometry::Bounds;
use crate::radiometry::Rgb;
use crate::run::{Error, Progress};
use crate::scene::{Scene, Sensor};
use crate::transport::first_surface::Source;

/// Points along each side of a texel, where a look-up of all of it must ask points.
pub(super) const MIDPOINTS: u32 = 8;

/// What outlives a frame.
pub struct Kept {
    /// The shape that is the water's surface.
    pub shape: u32,
    /// Its mean normal, snapped.
    normal: DVec3,
    tree: Quadtree,
}

impl Kept {
    /// The hierarchy of a scene's water.
    pub fn new(scene: &Scene, shape: u32, settings: &Settings) -> Self {
        let normal = mean_normal(&scene.world().shapes()[shape as usize]);
        Self {
            shape,
            normal,
            tree: tree(&Water::new(scene, shape, settings), normal, settings),
        }
    }

    /// The hierarchy.
    pub fn tree(&self) -> &Quadtree {
        &self.tree
    }
}

/// The hierarchy of the water's triangles.
fn tree(water: &Water, normal: DVec3, settings: &Settings) -> Quadtree {
    let frame = super::slicing::frame(normal);
    let across = |place: DVec3| frame.to_local(place).truncate();
    let corners: Vec<DVec2> = (0..water.triangles.len() as u32)
        .map(|triangle| lower_left(water.corners(triangle).map(across)))
        .collect();
    let all = water.vertices.iter().map(|vertex| across(vertex.position));
    let range = all.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], it| {
        [low.min(it), high.max(it)]
    });
    let heights = water
        .vertices
        .iter()
        .map(|vertex| vertex.position.dot(normal));
    let height = heights.sum::<f64>() / water.vertices.len().max(1) as f64;
    let counts = [settings.buckets, settings.splits];
    Quadtree::new(&corners, range, (frame, height), counts)
}

/// Fills a sensor with light through the water. A wish to stop ends the frame under way: the image has what
/// was gathered so far.
pub fn run(
    settings: &Settings,
    kept: &mut Kept,
    scene: &Scene,
    sensor: &Sensor,
    progress: &Progress,
) -> Result<Frame, Error> {
    let film = SensorFilm::new(scene, sensor)?;
    let sources = demands::lights(scene, kept.shape)?;
    let receivers = Receivers::new(scene);
    let mut pipeline = Pipeline {
        settings,
        scene,
        film: &film,
        progress,
        receivers: &receivers,
        normal: kept.normal,
        work: Default::default(),
        flow: Flow::default(),
        warnings: Vec::new(),
        drawn: 0,
    };
    let [width, height] = film.size();
    let mut values = vec![Rgb::BLACK; width * height];
    let water = pipeline.timed(Step::Surface, |this, _| this.water(kept));
    pipeline
        .warnings
        .extend(left_out(scene, kept.shape, settings, &water));
    for source in &sources {
        if progress.is_stopped() {
            break;
        }
        if let Some(light) = pipeline.light(&water, &kept.tree, source)? {
            for (sum, value) in values.iter_mut().zip(light) {
                *sum += value;
            }
        }
    }
    if film.shape().is_some() {
        let texels = values.iter().enumerate();
        let image: Rgb = texels
            .map(|(texel, value)| *value * film.measure(texel))
            .sum();
        pipeline.flow.end(image);
    }
    let is_dark = values.iter().all(|value| value.is_black());
    let mut warnings = pipeline.warnings;
    if progress.is_stopped() {
        let stopped = "stopped before all texels were gathered: light is missing";
        warnings.insert(0, stopped.to_owned());
    } else if is_dark {
        warnings.insert(0, darkness::reason(&pipeline.flow, pipeline.drawn, &film));
    }
    let stages: Vec<Work> = pipeline.work.iter().map(|done| done.work).collect();
    Ok(Frame {
        values,
        work: stage_work(&STAGES, &pipeline.work, Work::counters),
        counters: Work::of_frame(&stages, pipeline.drawn),
        flux: if film.shape().is_some() {
            pipeline.flow.entries()
        } else {
            Vec::new()
        },
        warnings,
    })
}

/// A warning of a grid's cells that reach beside the water's surface, if there are any.
fn left_out(scene: &Scene, shape: u32, settings: &Settings, water: &Water) -> Option<String> {
    let triangles = Triangles::of(settings, &scene.world().shapes()[shape as usize]);
    let (all, left) = (triangles.count(), water.triangles.len() as u64);
    let lod = if settings.lod > 0.0 {
        ", and lod joins no cells"
    } else {
        ""
    };
    (left < all).then(|| {
        format!(
            "shape \"{}\" does not fill its rectangle: {} of {all} triangles of the grid reach beside it, and are left \
             out{lod}",
            scene.objects()[shape as usize].id,
            all - left
        )
    })
}

struct Pipeline<'a> {
    settings: &'a Settings,
    scene: &'a Scene,
    film: &'a SensorFilm,
    progress: &'a Progress,
    receivers: &'a Receivers,
    /// The water's mean normal.
    normal: DVec3,
    work: BySteps<Done<Work>>,
    flow: Flow,
    warnings: Vec<String>,
    /// Beams drawn.
    drawn: u64,
}

impl Clocked for Pipeline<'_> {
    type Step = Step;
    type Work = Work;

    fn done(&mut self, step: Step) -> &mut Done<Work> {
        &mut self.work[step as usize]
    }
}

impl Pipeline<'_> {
    fn work(&mut self, step: Step) -> &mut Work {
        &mut self.work[step as usize].work
    }

    /// The water of this frame; the hierarchy is made anew if it has other triangles.
    fn water(&self, kept: &mut Kept) -> Water {
        let water = Water::new(self.scene, kept.shape, self.settings);
        if water.triangles.len() != kept.tree.order().len() {
            kept.tree = tree(&water, kept.normal, self.settings);
        }
        water
    }

    /// The boxes of what receives: the shape of a meter, or all that a camera may see.
    fn boxes(&self) -> Vec<Bounds> {
        let shapes = (0_u32..).zip(self.scene.world().shapes());
        let receives = |shape: u32| match self.film.shape() {
            Some(measured) => measured == shape,
            None => is_diffuse(self.scene, self.scene.material_of(shape)),
        };
        let found = shapes.filter(|(shape, _)| receives(*shape));
        found.map(|(_, shape)| shape.bounds()).collect()
    }

    /// The light of one source on the sensor; `None` if none goes down.
    fn light(
        &mut self,
        water: &Water,
        tree: &Quadtree,
        source: &Source,
    ) -> Result<Option<Vec<Rgb>>, Error> {
        let (scene, settings, normal) = (self.scene, self.settings, self.normal);
        let Some(flat) = FlatWater::new(scene, water, source, normal) else {
            self.warnings
                .push("light does not go down into the water".to_owned());
            return Ok(None);
        };
        let axis = match settings.axis {
            SliceAxis::Water => normal,
            SliceAxis::Refracted => -flat.direction,
        };
        let boxes = self.boxes();
        let places: Vec<DVec3> = water
            .vertices
            .iter()
            .map(|vertex| vertex.position)
            .collect();
        let Some(slicing) = Slicing::new(axis, &places, &boxes, settings.slices) else {
            self.warnings
                .push("no receiver is below the water".to_owned());
            return Ok(None);
        };
        let lit = Lit {
            scene,
            settings,
            source,
            water,
            slicing: &slicing,
            progress: self.progress,
        };
        let shading = Shading {
            lit,
            flat: &flat,
            format: Format::of(settings.accumulate, settings.cosine, settings.white),
            receivers: self.receivers,
        };
        let map = self.shadow_map(&lit, &places, tree);
        let vertices = self.vertices(&lit, map.as_ref());
        let joined = self.joined(&lit, &flat, &vertices);
        let (water, tree) = match &joined {
            Some((water, tree)) => (water, tree),
            None => (water, tree),
        };
        let lit = Lit { water, ..lit };
        let shading = Shading { lit, ..shading };
        let beams = self.beams(&lit, tree, &vertices);
        let is_lit = self.lit_beams(&lit, tree, &vertices, &beams, map.as_ref());
        let boxes = boxes.iter().map(|bounds| slicing.local_box(bounds));
        let boxes: Vec<LocalBox> = boxes.filter(|target| target.depths[1] > 0.0).collect();
        let draws = self.draws(&slicing, tree, &beams, &is_lit, &boxes);
        let draws = self.bright_draws(&slicing, &beams, draws);
        self.count_drawn(&draws);
        let colour = source.strength() * flat.tint;
        self.flow
            .add_light(&lit, &vertices, &beams, &is_lit, &draws, colour);
        let values = self.image(&shading, &vertices, &beams, &draws)?;
        Ok(Some(
            values.into_iter().map(|value| value * colour).collect(),
        ))
    }

    /// The water and its hierarchy after cells of the grid were joined where few beams do; `None` without
    /// `lod`, and on a surface that does not fill its rectangle.
    fn joined(
        &mut self,
        lit: &Lit,
        flat: &FlatWater,
        vertices: &[Option<LitVertex>],
    ) -> Option<(Water, Quadtree)> {
        let settings = self.settings;
        let world = &self.scene.world().shapes()[lit.water.shape() as usize];
        let Triangles::Grid(side) = Triangles::of(settings, world) else {
            return None;
        };
        let grid = JoinedGrid::new(settings.buckets, side);
        if settings.lod == 0.0 || vertices.len() != (side as usize).pow(2) {
            return None;
        }
        self.timed(Step::Surface, |this, _| {
            let tolerance = Tolerance {
                most: settings.lod,
                texel: this.film.texel_length(this.scene),
                bottom: lit.slicing.bottom(),
                axis: lit.slicing.axis(),
                flat: flat.irradiance,
            };
            let water = lit
                .water
                .with_triangles(grid.triangles(vertices, &tolerance));
            let tree = tree(&water, this.normal, settings);
            Some((water, tree))
        })
    }

    fn count_drawn(&mut self, draws: &[Draw]) {
        self.drawn += draws.chunk_by(|a, b| a.beam == b.beam).count() as u64;
        let work = self.work(Step::Clamp);
        for draw in draws {
            let planes = u64::from(draw.planes[1] - draw.planes[0]) + 1;
            work.draws += 2;
            work.vertices += 2 * 3 * planes;
        }
    }

    /// Stage `shadow`: the map, if a stage reads it.
    fn shadow_map(&mut self, lit: &Lit, places: &[DVec3], tree: &Quadtree) -> Option<ShadowMap> {
        let settings = self.settings;
        let is_read =
            settings.shadow == WaterShadow::Vertex || settings.shadow_cull == ShadowCull::Hierarchy;
        if !is_read || settings.shadow_map == 0 {
            return None;
        }
        self.timed(Step::Shadow, |_, work| {
            let (source, slicing, side) = (lit.source, lit.slicing, settings.shadow_map);
            let plane = tree.plane();
            Some(ShadowMap::new(
                lit.scene, source, slicing, places, plane, side, work,
            ))
        })
    }

    /// Stages `surface`, `flux`, `fresnel` and `shadow` at vertices.
    fn vertices(&mut self, lit: &Lit, map: Option<&ShadowMap>) -> Vec<Option<LitVertex>> {
        self.timed(Step::Surface, |this, _| {
            let mut work: BySteps<Work> = Default::default();
            let vertices = lit.vertices(map, &mut work);
            for (sum, one) in this.work.iter_mut().zip(work) {
                sum.work += one;
            }
            vertices
        })
    }

    /// The beams in the tree's order.
    fn beams(
        &mut self,
        lit: &Lit,
        tree: &Quadtree,
        vertices: &[Option<LitVertex>],
    ) -> Vec<Option<Beam>> {
        self.timed(Step::Flux, |this, _| {
            let order = tree.order().par_iter();
            let beams: Vec<_> = order
                .map(|&triangle| lit.beam(triangle, vertices))
                .collect();
            let begun = beams.iter().flatten().count() as u64;
            let work = this.work(Step::Surface);
            work.beams += begun;
            work.dropped += beams.len() as u64 - begun;
            beams
        })
    }

    /// Stage `shadow-cull`: the beams that are left.
    fn lit_beams(
        &mut self,
        lit: &Lit,
        tree: &Quadtree,
        vertices: &[Option<LitVertex>],
        beams: &[Option<Beam>],
        map: Option<&ShadowMap>,
    ) -> Vec<bool> {
        let settings = self.settings;
        self.timed(Step::ShadowCull, |_, work| {
            match (settings.shadow_cull, map) {
                (ShadowCull::Hierarchy, Some(map)) => {
                    let must_overlap = settings.queries == Queries::Overlap;
                    map.lit_leaves(tree, beams, settings.s_min, must_overlap, work)
                }
                (ShadowCull::Dark, _) => {
                    let is_dark = |beam: &Beam| lit.is_dark(beam.triangle, vertices);
                    let found: Vec<bool> = beams
                        .iter()
                        .map(|beam| !beam.as_ref().is_some_and(is_dark))
                        .collect();
                    work.culled += found.iter().filter(|is_lit| !**is_lit).count() as u64;
                    found
                }
                (ShadowCull::Hierarchy | ShadowCull::Exact, _) => vec![true; beams.len()],
            }
        })
    }

    /// Stage `clamp`: what is drawn.
    fn draws(
        &mut self,
        slicing: &Slicing,
        tree: &Quadtree,
        beams: &[Option<Beam>],
        is_lit: &[bool],
        boxes: &[LocalBox],
    ) -> Vec<Draw> {
        let settings = self.settings;
        let (draws, hulls) = self.timed(Step::Clamp, |this, work| {
            let view = match this.film {
                SensorFilm::Receiver(_) => View::default(),
                SensorFilm::Camera(camera) => View::new(&camera.frustum(), slicing),
            };
            // Only the hierarchy reads them.
            let is_read = settings.clamp == Clamp::Hierarchy;
            let hulls = is_read.then(|| Hulls::new(tree, beams, slicing, settings.hull));
            work.bytes += hulls.as_ref().map_or(0, Hulls::bytes);
            let culling = Culling {
                tree,
                beams,
                is_lit,
                hulls: hulls.as_ref(),
                slicing,
                view: &view,
                boxes,
            };
            (culling.draws(settings.clamp, work), hulls)
        });
        // Off the clock: a device has no use for it.
        if let Some(hulls) = hulls {
            self.work(Step::Clamp).escapes += escapes(tree, beams, &hulls);
        }
        draws
    }

    /// What is left without the faintest beams.
    fn bright_draws(
        &mut self,
        slicing: &Slicing,
        beams: &[Option<Beam>],
        draws: Vec<Draw>,
    ) -> Vec<Draw> {
        let share = self.settings.least_flux;
        if share == 0.0 {
            return draws;
        }
        self.timed(Step::Clamp, |_, work| {
            let before = draws.len();
            let left = without_faintest(slicing, beams, draws, share);
            work.culled += (before - left.len()) as u64;
            left
        })
    }

    /// Stages from `density` on: the sensor's values by the source's strength and the water's colour.
    fn image(
        &mut self,
        shading: &Shading,
        vertices: &[Option<LitVertex>],
        beams: &[Option<Beam>],
        draws: &[Draw],
    ) -> Result<Vec<Rgb>, Error> {
        let settings = self.settings;
        let is_whole = settings.lookup == TexelPoints::Exact;
        if is_whole && can_deal(settings, self.film) {
            return self.timed(Step::Lookup, |this, work| {
                deal(shading, vertices, beams, draws, this.film, work)
            });
        }
        let samples = if is_whole { MIDPOINTS } else { 1 };
        let cells = self.cells(shading, vertices, beams, draws);
        let slicing = shading.lit.slicing;
        let drawn: Vec<Drawn> = match &cells {
            Some(cells) => cells
                .iter()
                .flat_map(|(draw, cells)| {
                    let planes = draw.planes;
                    cells
                        .iter()
                        .map(move |beam| Drawn::new(beam, planes, slicing))
                })
                .collect(),
            None => draws
                .iter()
                .filter_map(|draw| {
                    let beam = beams[draw.beam as usize].as_ref()?;
                    Some(Drawn::new(beam, draw.planes, slicing))
                })
                .collect(),
        };
        let (values, done, views) = self.timed(Step::Inside, |this, _| {
            match (this.film, settings.inside) {
                (SensorFilm::Camera(camera), Inside::Stencil) => {
                    draw(shading, &drawn, this.film, camera, samples)
                }
                (SensorFilm::Camera(_), Inside::Exact) | (SensorFilm::Receiver(_), _) => {
                    gather(shading, &drawn, this.film, samples)
                }
            }
            .into_parts()
        });
        self.add(&done);
        self.work(Step::Lookup).add_rays(views);
        Ok(values)
    }

    fn add(&mut self, done: &ShadeWork) {
        *self.work(Step::Accumulate) += done.accumulate;
        *self.work(Step::Inside) += done.inside;
        *self.work(Step::Shadow) += done.shadow;
        *self.work(Step::Occlusion) += done.occlusion;
    }

    /// The parts of the beams that are drawn, if stage `surface` is exact.
    fn cells(
        &mut self,
        shading: &Shading,
        vertices: &[Option<LitVertex>],
        beams: &[Option<Beam>],
        draws: &[Draw],
    ) -> Option<Vec<(Draw, Vec<Beam>)>> {
        let settings = self.settings;
        (settings.surface == WaterSurface::Exact).then(|| {
            self.timed(Step::Surface, |_, _| {
                let cells = draws.par_iter().map(|draw| {
                    let beam = beams[draw.beam as usize].as_ref();
                    let lit = &shading.lit;
                    let beam = beam.filter(|_| !lit.progress.is_stopped());
                    let whole = beam.and_then(|beam| lit.whole(beam.triangle, vertices));
                    let cells = whole.map(|whole| lit.cells(&whole, settings.levels));
                    (*draw, cells.unwrap_or_default())
                });
                cells.collect()
            })
        })
    }
}

/// The beams that leave the hulls of their leaves.
fn escapes(tree: &Quadtree, beams: &[Option<Beam>], hulls: &Hulls) -> u64 {
    let is_outside =
        |hull: Option<&Hull>, beam: &Beam| hull.is_none_or(|hull| hull.is_left_by(beam));
    let of_leaf = |leaf| {
        let beams = beams[tree.triangles(leaf)].iter().flatten();
        beams
            .filter(|beam| is_outside(hulls.of(leaf), beam))
            .count() as u64
    };
    tree.all_leaves().map(of_leaf).sum()
}
