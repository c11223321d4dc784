//! The stages one after the other.

use std::time::Instant;

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use super::buffers::{Back, DepthMap, Front, Receivers, back, is_inside, takes_part};
use super::footprint::{ExactFilm, deal_beams};
use super::hit::{Canvas, Landing};
use super::lookup::{CausticTexture, CausticTextures};
use super::project::deal_texels;
use super::refraction::Exit;
use super::resolve::{mip, mip_splat, multi_resolution};
use super::settings::{Frustum, Hit, Lookup, Mode, Refraction, Settings, Splat};
use super::splat::{DEVIATIONS, Photon, Spread, draw};
use super::trace::Tracer;
use super::view::LightView;
use crate::approximation::{ApproximationError, Rendering, SensorFilm, StageWork, Work};
use crate::geometry::{Bounds, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Material, Scene, Sensor};
use crate::transport::first_surface::Source;
use crate::transport::signature::{Event, Signature};

/// The stages' places in [`Pipeline::work`].
const VIEW: usize = 0;
const REFRACTION: usize = 1;
const HIT: usize = 2;
const FLUX: usize = 3;
const SPLAT: usize = 5;
const LOOKUP: usize = 6;

/// Fills a sensor.
pub fn run(
    settings: &Settings,
    scene: &Scene,
    sensor: &Sensor,
) -> Result<Rendering, ApproximationError> {
    let film = SensorFilm::new(scene, sensor)?;
    let mode = mode(settings, scene)?;
    let sources = sources(scene)?;
    if mode == Mode::Refraction {
        check_outside(scene, &sources)?;
    }
    let mut pipeline = Pipeline {
        settings,
        scene,
        film: &film,
        receivers: Receivers::new(scene),
        mode,
        work: settings
            .stages()
            .iter()
            .map(|stage| StageWork {
                name: stage.name,
                work: Work::default(),
                seconds: 0.0,
            })
            .collect(),
    };
    let [width, height] = film.size();
    let mut values = vec![Rgb::BLACK; width * height];
    for frame in 0..settings.frames {
        for (sum, value) in values.iter_mut().zip(pipeline.frame(&sources, frame)?) {
            *sum += value / f64::from(settings.frames);
        }
    }
    let signature = match mode {
        Mode::Refraction => Signature::DIRECT
            .then(Event::Transmission)
            .then(Event::Transmission),
        Mode::Reflection => Signature::DIRECT.then(Event::Reflection),
    };
    Ok(Rendering {
        width,
        height,
        signature,
        values,
        work: pipeline.work,
    })
}

/// The mode asked for, or refraction where something refracts.
fn mode(settings: &Settings, scene: &Scene) -> Result<Mode, ApproximationError> {
    let has = |mode| {
        scene
            .objects()
            .iter()
            .any(|object| takes_part(scene, scene.material(object.material), mode))
    };
    let mode = settings.mode.unwrap_or(if has(Mode::Refraction) {
        Mode::Refraction
    } else {
        Mode::Reflection
    });
    let (does, plugins) = match mode {
        Mode::Refraction => ("refracts", "dielectric or thindielectric"),
        Mode::Reflection => ("mirrors", "conductor, dielectric or thindielectric"),
    };
    if has(mode) {
        Ok(mode)
    } else {
        Err(ApproximationError::NoSpecular {
            mode: mode.name(),
            does,
            plugins,
        })
    }
}

/// The lights, which must all be points or directions.
fn sources(scene: &Scene) -> Result<Vec<Source>, ApproximationError> {
    let refused = scene
        .emitters()
        .iter()
        .find(|emitter| !emitter.is_delta() && !emitter.strength().is_black());
    if let Some(emitter) = refused.map(Emitter::plugin) {
        return Err(ApproximationError::Emitter { plugin: emitter });
    }
    let sources = Source::all(scene);
    if sources.is_empty() {
        return Err(ApproximationError::NoEmitter);
    }
    Ok(sources)
}

/// Refuses points inside a refractor: their light crosses one interface.
fn check_outside(scene: &Scene, sources: &[Source]) -> Result<(), ApproximationError> {
    for source in sources {
        let Source::Point { origin, .. } = *source else {
            continue;
        };
        let found = (0_u32..).zip(scene.objects()).find(|(shape, object)| {
            let material = scene.material(object.material);
            takes_part(scene, material, Mode::Refraction) && is_inside(scene, *shape, origin)
        });
        if let Some((_, object)) = found {
            return Err(ApproximationError::LightInside {
                position: origin.to_array(),
                shape: object.id.clone(),
            });
        }
    }
    Ok(())
}

struct Pipeline<'a> {
    settings: &'a Settings,
    scene: &'a Scene,
    film: &'a SensorFilm,
    receivers: Receivers,
    mode: Mode,
    work: Vec<StageWork>,
}

/// What a pixel of the photon buffer became.
struct Sent<T> {
    /// Its image point.
    at: DVec2,
    what: T,
}

impl Pipeline<'_> {
    /// Runs a part of a stage on the clock.
    fn timed<T>(&mut self, stage: usize, part: impl FnOnce(&mut Self) -> T) -> T {
        let start = Instant::now();
        let result = part(self);
        self.work[stage].seconds += start.elapsed().as_secs_f64();
        result
    }

    /// Where in its pixel a frame's photons are, as a shift from the middle: the additive sequence of the plastic
    /// number (Roberts 2018), whose first points cover a square evenly.
    fn shift(frame: u32) -> DVec2 {
        const PLASTIC: f64 = 1.324_717_957_244_746;
        let step = DVec2::new(1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC));
        (step * f64::from(frame) + 0.5).fract() - 0.5
    }

    /// The boxes of what is specular, and of what receives.
    fn targets(&self) -> [Vec<Bounds>; 2] {
        let shapes = self.scene.world().shapes();
        let (mut specular, mut receiving) = (Vec::new(), Vec::new());
        for (index, shape) in (0_u32..).zip(shapes) {
            let material = self.scene.material_of(index);
            if takes_part(self.scene, material, self.mode) {
                specular.push(shape.bounds());
            }
            let measured = self.film.shape();
            let receives =
                measured.map_or_else(|| is_diffuse(self.scene, material), |shape| shape == index);
            if receives {
                receiving.push(shape.bounds());
            }
        }
        [specular, receiving]
    }

    fn frame(&mut self, sources: &[Source], frame: u32) -> Result<Vec<Rgb>, ApproximationError> {
        let [specular, receiving] = self.targets();
        let all = [&specular[..], &receiving[..]].concat();
        let refractor = specular
            .iter()
            .fold(Bounds::EMPTY, |all, one| all.union(*one));
        let settings = self.settings;
        let is_direct = settings.splat == Splat::Exact && settings.lookup == Lookup::Exact;
        let total: f64 = sources
            .iter()
            .map(|source| flux_bound(source, &refractor))
            .sum();
        let largest = total * self.film.largest_factor(self.scene);
        let film = ExactFilm::new(self.film.size(), largest)?;
        let mut maps = Vec::new();
        for source in sources {
            let views = LightView::around(source, &all, settings.map);
            let photon_views = match settings.frustum {
                Frustum::Scene => LightView::around(source, &all, settings.photons),
                Frustum::Object => LightView::around(source, &specular, settings.photons),
            };
            let depths = self.depth_maps(&views);
            let lights: Vec<Light> = photon_views
                .iter()
                .map(|view| Light {
                    source,
                    view,
                    window: view.window(&refractor),
                    // A photon marches through the picture that its own view has of the scene.
                    depths: depth_map_of(view, &depths),
                })
                .collect();
            if is_direct {
                for light in &lights {
                    let canvas = Canvas::Sensor(self.film.screen());
                    self.beams(light, &canvas, Self::shift(frame), &film);
                }
                continue;
            }
            for (index, view) in views.iter().enumerate() {
                let flux = self.map(&lights, view, Self::shift(frame), total)?;
                maps.push(CausticTexture {
                    view: *view,
                    flux,
                    depths: depths.get(index).cloned(),
                });
            }
        }
        self.timed(LOOKUP, |this| {
            if settings.lookup == Lookup::Exact {
                for map in &maps {
                    let screen = this.film.screen();
                    this.work[LOOKUP].work += deal_texels(
                        this.scene,
                        &this.receivers,
                        &map.view,
                        &map.flux,
                        &screen,
                        &film,
                    );
                }
                let measure = |texel: usize| match this.film.measure(texel) {
                    0.0 => f64::INFINITY,
                    measure => measure,
                };
                let sums = film.finish()?.into_iter().enumerate();
                return Ok(sums.map(|(texel, sum)| sum / measure(texel)).collect());
            }
            let field = CausticTextures {
                maps,
                lookup: settings.lookup,
                bias: settings.bias,
            };
            let (values, work) = this.film.evaluate(this.scene, &field, settings.samples);
            this.work[LOOKUP].work += work;
            Ok(values)
        })
    }

    /// The receivers' depths in each view, where a stage reads them.
    fn depth_maps(&mut self, views: &[LightView]) -> Vec<DepthMap> {
        if self.settings.hit == Hit::Exact && self.settings.lookup == Lookup::Exact {
            return Vec::new();
        }
        self.timed(VIEW, |this| {
            let maps = views.iter().map(|view| {
                let view = view.with_side(this.settings.photons);
                let (map, work) = DepthMap::new(&this.receivers, view, this.settings.view);
                this.work[VIEW].work += work;
                map
            });
            maps.collect()
        })
    }

    fn beams(&mut self, light: &Light, canvas: &Canvas, shift: DVec2, film: &ExactFilm) {
        let backs = self.backs(light);
        self.timed(SPLAT, |this| {
            let tracer = this.tracer(light, &backs);
            let work = deal_beams(&tracer, canvas, shift, film);
            let stages = [
                (VIEW, work.view),
                (REFRACTION, work.refraction),
                (HIT, work.hit),
                (SPLAT, work.splat),
            ];
            for (stage, work) in stages {
                this.work[stage].work += work;
            }
        });
    }

    fn tracer<'b>(&'b self, light: &Light<'b>, backs: &'b [Option<Back>]) -> Tracer<'b> {
        Tracer {
            scene: self.scene,
            receivers: &self.receivers,
            window: light.window,
            source: light.source,
            view: light.view,
            mode: self.mode,
            settings: self.settings,
            backs,
            depths: light.depths,
        }
    }

    /// One caustic map: flux \[W\] by texel.
    fn map(
        &mut self,
        lights: &[Light],
        view: &LightView,
        shift: DVec2,
        total: f64,
    ) -> Result<Vec<Rgb>, ApproximationError> {
        let canvas = Canvas::Map(view);
        if self.settings.splat == Splat::Exact {
            let film = ExactFilm::new([view.side(); 2], total)?;
            for light in lights {
                self.beams(light, &canvas, shift, &film);
            }
            return film.finish();
        }
        let mut photons = Vec::new();
        for light in lights {
            photons.extend(self.photons(light, &canvas, view, shift));
        }
        Ok(self.timed(SPLAT, |this| {
            let settings = this.settings;
            let (map, work) = match settings.splat {
                Splat::Mip => mip(view.side(), &photons, settings.dense),
                Splat::MipSplat => mip_splat(view.side(), &photons, settings.dense),
                Splat::MultiResolution => multi_resolution(view.side(), &photons),
                _ => draw(view.side(), &photons),
            };
            this.work[SPLAT].work += work;
            map
        }))
    }

    /// The picture of back faces, where refraction reads it.
    fn backs(&mut self, light: &Light) -> Vec<Option<Back>> {
        let is_read =
            self.mode == Mode::Refraction && self.settings.refraction == Refraction::ImageSpace;
        if !is_read {
            return Vec::new();
        }
        self.timed(VIEW, |this| {
            let tracer = this.tracer(light, &[]);
            let side = light.view.side();
            let rows: Vec<(Vec<Option<Back>>, Work)> = (0..side)
                .into_par_iter()
                .map(|row| {
                    let (mut work, mut counters) = (Work::default(), TraversalCounters::default());
                    let row = (0..side)
                        .map(|column| {
                            let at = DVec2::new(column as f64, row as f64) + 0.5;
                            let front = tracer.front(at, &mut work)?;
                            back(tracer.scene, &front, &mut counters)
                        })
                        .collect();
                    work.add_rays(counters);
                    (row, work)
                })
                .collect();
            let mut backs = Vec::with_capacity(side * side);
            for (row, work) in rows {
                backs.extend(row);
                // Rasterised once; that the fronts are found again is no photon's work.
                this.work[VIEW].work.rays += work.rays;
            }
            this.work[VIEW].work.bytes += (side * side * 16) as u64;
            backs
        })
    }

    /// All photons of a light on a map.
    fn photons(
        &mut self,
        light: &Light,
        canvas: &Canvas,
        map: &LightView,
        shift: DVec2,
    ) -> Vec<Photon> {
        let side = light.view.side();
        let backs = self.backs(light);
        let fronts = self.timed(VIEW, |this| {
            let tracer = this.tracer(light, &backs);
            let rows: Vec<_> = (0..side)
                .into_par_iter()
                .map(|row| front_row(&tracer, row, shift))
                .collect();
            let mut fronts = Vec::new();
            for (row, work) in rows {
                fronts.extend(row);
                this.work[VIEW].work += work;
            }
            this.work[VIEW].work.bytes += (side * side * 2 * 12) as u64;
            fronts
        });
        let exits = self.stage(REFRACTION, fronts, |this, front: &Sent<Front>, work| {
            this.tracer(light, &backs).exit(front.at, &front.what, work)
        });
        let landed = self.stage(HIT, exits, |this, exit: &Sent<Exit>, work| {
            let tracer = this.tracer(light, &backs);
            Some((exit.what, tracer.landing(&exit.what, canvas, work)?))
        });
        self.timed(FLUX, |this| {
            this.work[FLUX].work.photons += landed.len() as u64;
            let tracer = this.tracer(light, &backs);
            landed
                .par_iter()
                .map(|sent| {
                    let (exit, landing) = &sent.what;
                    let low = sent.at - 0.5;
                    let emitted = tracer.emitted(sent.at, low, low + 1.0);
                    Photon {
                        at: landing.at,
                        flux: emitted * exit.throughput * landing.weight,
                        spread: spread(this.settings, this.mode, light.view, map, exit, landing),
                    }
                })
                .collect()
        })
    }

    /// Runs a stage on every photon that is left, and keeps those that it does not drop, in their order.
    fn stage<T: Sync, U: Send>(
        &mut self,
        stage: usize,
        photons: Vec<Sent<T>>,
        step: impl Fn(&Self, &Sent<T>, &mut Work) -> Option<U> + Sync,
    ) -> Vec<Sent<U>> {
        /// Photons a task.
        const TASK: usize = 1024;
        let parts: Vec<(Vec<Sent<U>>, Work)> = self.timed(stage, |this| {
            let this = &*this;
            photons
                .par_chunks(TASK)
                .map(|chunk| {
                    let mut work = Work::default();
                    let left = chunk
                        .iter()
                        .filter_map(|sent| {
                            let what = step(this, sent, &mut work)?;
                            Some(Sent { at: sent.at, what })
                        })
                        .collect();
                    (left, work)
                })
                .collect()
        });
        let mut left = Vec::with_capacity(photons.len());
        for (part, work) in parts {
            left.extend(part);
            self.work[stage].work += work;
        }
        left
    }
}

/// A light's photon buffer.
struct Light<'a> {
    source: &'a Source,
    view: &'a LightView,
    /// The part of it that specular objects are in.
    window: [DVec2; 2],
    depths: Option<&'a DepthMap>,
}

/// The depth map of the view with the same axis, or the only one.
fn depth_map_of<'a>(view: &LightView, maps: &'a [DepthMap]) -> Option<&'a DepthMap> {
    let middle = DVec2::splat(0.5 * view.side() as f64);
    let ray = view.ray(middle);
    maps.iter()
        .find(|map| {
            let seen = map.view().project(ray.at(map.view().range()[1]));
            seen.is_some_and(|seen| map.view().holds(seen.at))
        })
        .or(maps.first())
}

/// The fronts in one row of a photon buffer.
fn front_row(tracer: &Tracer, row: usize, shift: DVec2) -> (Vec<Sent<Front>>, Work) {
    let mut work = Work::default();
    let fronts = (0..tracer.view.side())
        .filter_map(|column| {
            let at = DVec2::new(column as f64, row as f64) + 0.5 + shift;
            let what = tracer.front(at, &mut work)?;
            Some(Sent { at, what })
        })
        .collect();
    (fronts, work)
}

/// How wide a photon is drawn, in texels of the map.
fn spread(
    settings: &Settings,
    mode: Mode,
    view: &LightView,
    map: &LightView,
    exit: &Exit,
    landing: &Landing,
) -> Spread {
    // Texels of the map by pixel of the photon buffer.
    let ratio = view.half() / view.side() as f64 * map.side() as f64 / map.half();
    let unbent = settings.base_size * ratio;
    let background = landing.position.distance(exit.ray.origin);
    let lens = &exit.lens;
    let bounded = |factor: f64| {
        let diameter = factor * unbent;
        // At least a texel, as points on a device are.
        Spread::Round(
            if diameter.is_nan() { unbent } else { diameter }
                .clamp(1.0, settings.largest_splat.max(1.0)),
        )
    };
    match (settings.splat, mode) {
        (Splat::ThinLens | Splat::ThickLens, Mode::Reflection) => bounded(lens.mirror(background)),
        (Splat::ThinLens, Mode::Refraction) => bounded(lens.thin(background)),
        (Splat::ThickLens, Mode::Refraction) => bounded(lens.thick(background)),
        (Splat::TwoCurvatures, _) => ellipse(settings, map, exit, landing),
        _ => Spread::Round(settings.splat_size),
    }
}

/// The Gaussian of a photon's pixel, σ = `base_size` / 6 pixels, carried to the map by the beam's exact derivatives; never
/// narrower than a third of a texel, nor larger than the largest splat.
fn ellipse(settings: &Settings, map: &LightView, exit: &Exit, landing: &Landing) -> Spread {
    const NARROWEST: f64 = 1.0 / 3.0;
    let distance = landing.position.distance(exit.ray.origin);
    let [a, b] = exit.derivatives.map(|derivative| {
        let on_receiver = derivative.transferred(exit.ray.direction, distance, landing.normal);
        map.project_derivative(landing.position, on_receiver.position)
            * (settings.base_size / DEVIATIONS)
    });
    let floor = DMat2::from_diagonal(DVec2::splat(NARROWEST * NARROWEST));
    let covariance = DMat2::from_cols(
        DVec2::new(a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y),
        DVec2::new(a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y),
    );
    let trace = covariance.x_axis.x + covariance.y_axis.y;
    let largest = (settings.largest_splat / DEVIATIONS).powi(2);
    if !trace.is_finite() {
        return Spread::Ellipse(DMat2::from_diagonal(DVec2::splat(largest)));
    }
    // The larger variance is between half the trace and the trace.
    let shrink = (largest / trace.max(f64::MIN_POSITIVE)).min(1.0);
    Spread::Ellipse(covariance * shrink + floor)
}

/// A bound on the flux \[W\] that falls on a box.
fn flux_bound(source: &Source, bounds: &Bounds) -> f64 {
    let strength = source.strength().max_channel();
    match source {
        Source::Parallel { .. } => strength * 4.0 * bounds.radius().powi(2),
        _ => strength * 4.0 * std::f64::consts::PI,
    }
}

/// Whether a camera sees irradiance on it.
fn is_diffuse(scene: &Scene, material: &Material) -> bool {
    matches!(material, Material::Diffuse { .. })
        || material
            .nested()
            .any(|id| is_diffuse(scene, scene.material(id)))
}
