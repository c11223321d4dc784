//! The stages one after the other.

use std::time::Instant;

use glam::DVec2;

use super::buffers::{Back, takes_part};
use super::demands::{MAPS, mode};
use super::footprint::deal_beams;
use super::hit::Canvas;
use super::lookup::{CausticTexture, CausticTextures};
use super::photons::{backs, photons};
use super::project::deal_texels;
use super::resolve::{mip, mip_splat, multi_resolution};
use super::settings::{Frustum, Hit, Lookup, Mode, Refraction, STAGES, Settings, Splat};
use super::splat::{Photon, draw};
use super::trace::Tracer;
use super::work::Work;
use crate::approximation::sources::{flux_bound, is_diffuse, sources};
use crate::approximation::{DepthMap, ExactFilm, Frame, LightView, Receivers, SensorFilm};
use crate::geometry::Bounds;
use crate::radiometry::Rgb;
use crate::run::{Error, StageWork};
use crate::scene::{Scene, Sensor};
use crate::transport::first_surface::Source;

/// The stages' places in [`Pipeline::work`].
const VIEW: usize = 0;
const REFRACTION: usize = 1;
const HIT: usize = 2;
const FLUX: usize = 3;
const SPLAT: usize = 5;
const LOOKUP: usize = 6;

/// Fills a sensor.
pub fn run(settings: &Settings, scene: &Scene, sensor: &Sensor) -> Result<Frame, Error> {
    let film = SensorFilm::new(scene, sensor)?;
    let mode = mode(settings, scene)?;
    let sources = sources(scene, MAPS)?;
    let mut pipeline = Pipeline {
        settings,
        scene,
        film: &film,
        receivers: Receivers::new(scene),
        mode,
        work: [Done::default(); STAGES.len()],
    };
    let [width, height] = film.size();
    let mut values = vec![Rgb::BLACK; width * height];
    for frame in 0..settings.frames {
        for (sum, value) in values.iter_mut().zip(pipeline.frame(&sources, frame)?) {
            *sum += value / f64::from(settings.frames);
        }
    }
    let counters = Work::of_frame(&pipeline.work.map(|done| done.work));
    let work = STAGES
        .iter()
        .zip(pipeline.work)
        .map(|(stage, done)| StageWork {
            work: done.work.counters(),
            seconds: done.seconds,
            ..StageWork::new(stage.name)
        });
    Ok(Frame {
        values,
        work: work.collect(),
        counters,
        warnings: Vec::new(),
    })
}

/// Work and time of a stage.
#[derive(Clone, Copy, Debug, Default)]
struct Done {
    work: Work,
    seconds: f64,
}

struct Pipeline<'a> {
    settings: &'a Settings,
    scene: &'a Scene,
    film: &'a SensorFilm,
    receivers: Receivers,
    mode: Mode,
    work: [Done; STAGES.len()],
}

impl Pipeline<'_> {
    /// Runs a part of a stage on the clock.
    fn timed<T>(&mut self, stage: usize, part: impl FnOnce(&mut Self) -> T) -> T {
        let start = Instant::now();
        let result = part(self);
        self.work[stage].seconds += start.elapsed().as_secs_f64();
        result
    }

    /// Where in its pixel a frame's photons are, as a shift from the middle: the additive sequence of the
    /// plastic number (Roberts 2018), whose first points cover a square evenly.
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

    fn frame(&mut self, sources: &[Source], frame: u32) -> Result<Vec<Rgb>, Error> {
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
        let shift = Self::shift(frame);
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
                    depths: &depths,
                })
                .collect();
            if is_direct {
                for light in &lights {
                    let canvas = Canvas::Sensor(self.film.screen());
                    self.beams(light, &canvas, shift, &film);
                }
                continue;
            }
            let fluxes = self.maps(&lights, &views, shift, total)?;
            for (index, (view, flux)) in views.into_iter().zip(fluxes).enumerate() {
                maps.push(CausticTexture {
                    view,
                    flux,
                    depths: depths.get(index).cloned(),
                });
            }
        }
        self.looked_up(maps, film)
    }

    /// Stage `lookup`: what the sensor's texels have of maps, or of a film that has it all.
    fn looked_up(&mut self, maps: Vec<CausticTexture>, film: ExactFilm) -> Result<Vec<Rgb>, Error> {
        let settings = self.settings;
        self.timed(LOOKUP, |this| {
            if settings.lookup == Lookup::Exact {
                let screen = this.film.screen();
                for map in &maps {
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
            let (values, work, views) =
                this.film
                    .evaluate(this.scene, settings.samples, |point, work: &mut Work| {
                        field.irradiance(&point.point, point.normal, work)
                    });
            this.work[LOOKUP].work += work;
            this.work[LOOKUP].work.add_rays(views);
            Ok(values)
        })
    }

    /// The receivers' depths in each view, where a stage reads them: marches do, and look-ups where receivers
    /// may hide one another.
    fn depth_maps(&mut self, views: &[LightView]) -> Vec<DepthMap> {
        let is_marched = self.settings.hit == Hit::DepthMap;
        let is_tested = self.settings.lookup != Lookup::Exact && self.receivers.may_hide();
        if !is_marched && !is_tested {
            return Vec::new();
        }
        self.timed(VIEW, |this| {
            let maps = views.iter().map(|view| {
                let view = view.with_side(this.settings.photons);
                let (map, counters) = DepthMap::new(&this.receivers, view, this.settings.view);
                this.work[VIEW].work.add_rays(counters);
                this.work[VIEW].work.bytes += map.bytes();
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
            pixel_measure: light.view.measure() / (light.view.side() as f64).powi(2),
            mode: self.mode,
            settings: self.settings,
            backs,
            depths: light.depths,
        }
    }

    /// The caustic maps of one light, in its views: flux \[W\] by texel.
    fn maps(
        &mut self,
        lights: &[Light],
        views: &[LightView],
        shift: DVec2,
        total: f64,
    ) -> Result<Vec<Vec<Rgb>>, Error> {
        if self.settings.splat == Splat::Exact {
            let with_beams = |view: &LightView| {
                let film = ExactFilm::new([view.side(); 2], total)?;
                for light in lights {
                    self.beams(light, &Canvas::Map(view), shift, &film);
                }
                film.finish()
            };
            return views.iter().map(with_beams).collect();
        }
        let mut photons: Vec<Vec<Photon>> = vec![Vec::new(); views.len()];
        for light in lights {
            for (all, some) in photons.iter_mut().zip(self.photons(light, views, shift)) {
                all.extend(some);
            }
        }
        let settings = self.settings;
        let drawn = views.iter().zip(&photons).map(|(view, photons)| {
            self.timed(SPLAT, |this| {
                let (map, work) = match settings.splat {
                    Splat::Mip => mip(view.side(), photons, settings.dense),
                    Splat::MipSplat => mip_splat(view.side(), photons, settings.dense),
                    Splat::MultiResolution => multi_resolution(view.side(), photons),
                    _ => draw(view.side(), photons),
                };
                this.work[SPLAT].work += work;
                map
            })
        });
        Ok(drawn.collect())
    }

    /// The picture of back faces, where refraction reads it.
    fn backs(&mut self, light: &Light) -> Vec<Option<Back>> {
        let is_read =
            self.mode == Mode::Refraction && self.settings.refraction == Refraction::ImageSpace;
        if !is_read {
            return Vec::new();
        }
        self.timed(VIEW, |this| {
            let (backs, work) = backs(&this.tracer(light, &[]));
            this.work[VIEW].work += work;
            backs
        })
    }

    /// A light's photons on each of its maps. Their stages run side by side, in tiles: the time that they
    /// take together is shared out by what threads spent in each.
    fn photons(&mut self, light: &Light, maps: &[LightView], shift: DVec2) -> Vec<Vec<Photon>> {
        let backs = self.backs(light);
        let start = Instant::now();
        let (photons, stages) = photons(&self.tracer(light, &backs), maps, shift);
        let seconds = start.elapsed().as_secs_f64();
        let all: f64 = stages.iter().map(|done| done.thread_seconds).sum();
        for (stage, done) in [VIEW, REFRACTION, HIT, FLUX].into_iter().zip(stages) {
            self.work[stage].work += done.work;
            if all > 0.0 {
                self.work[stage].seconds += seconds * done.thread_seconds / all;
            }
        }
        photons
    }
}

/// A light's photon buffer.
struct Light<'a> {
    source: &'a Source,
    view: &'a LightView,
    /// The part of it that specular objects are in.
    window: [DVec2; 2],
    /// The receivers in all pictures of this light.
    depths: &'a [DepthMap],
}
