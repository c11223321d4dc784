//! The stages one after the other.

use std::time::Instant;

use glam::DVec2;
use rayon::prelude::*;

use super::buffers::{Back, DepthMap, Front, Receivers, back, takes_part};
use super::demands::{check_outside, flux_bound, is_diffuse, mode, sources};
use super::footprint::{ExactFilm, deal_beams};
use super::hit::Canvas;
use super::lookup::{CausticTexture, CausticTextures};
use super::project::deal_texels;
use super::refraction::Exit;
use super::resolve::{mip, mip_splat, multi_resolution};
use super::settings::{Frustum, Hit, Lookup, Mode, Refraction, Settings, Splat};
use super::splat::{Photon, draw};
use super::spread::spread;
use super::trace::Tracer;
use super::view::LightView;
use crate::approximation::{ApproximationError, Rendering, SensorFilm, StageWork, Work};
use crate::geometry::{Bounds, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::{Scene, Sensor};
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
        let exits = self.stage(REFRACTION, &fronts, |this, front: &Sent<Front>, work| {
            this.tracer(light, &backs).exit(front.at, &front.what, work)
        });
        let landed = self.stage(HIT, &exits, |this, exit: &Sent<Exit>, work| {
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
        photons: &[Sent<T>],
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
