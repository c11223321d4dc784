//! The stages one after the other.

use std::time::Instant;

use glam::DVec2;

use super::buffers::{Back, Backs, takes_part};
use super::darkness;
use super::demands::MAPS;
use super::footprint::deal_beams;
use super::hit::Canvas;
use super::ledger::Flow;
use super::lookup::{CausticTexture, CausticTextures, Looks};
use super::photons::{backs, photons};
use super::project::{deal_texels, flux_beside};
use super::resolve::{Chosen, mip, mip_splat, multi_resolution};
use super::settings::Settings;
use super::splat::{Photon, added, draw};
use super::tally::Tally;
use super::trace::Tracer;
use super::variants::{
    BySteps, Frustum, Hit, Kernel, Lookup, Mode, Refraction, STAGES, Splat, Step,
};
use super::work::Work;
use crate::approximation::clock::{Clocked, Done, stage_work};
use crate::approximation::sensor::SensorPoint;
use crate::approximation::sources::{flux_bound, is_diffuse, sources};
use crate::approximation::{DepthMap, ExactFilm, Extent, Frame, LightView, Receivers, SensorFilm};
use crate::geometry::Bounds;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::run::cost::TRIPLE;
use crate::run::{Error, Progress, Refusal};
use crate::scene::{Scene, Sensor};
use crate::transport::first_surface::Source;

/// Fills a sensor with light of one mode. A wish to stop ends the frame under way: if it is the first, the
/// image has what its photons brought so far, else it has the frames before it.
pub fn run(
    settings: &Settings,
    mode: Mode,
    scene: &Scene,
    sensor: &Sensor,
    progress: &Progress,
) -> Result<Frame, Error> {
    let film = SensorFilm::new(scene, sensor)?;
    let sources = sources(scene, MAPS)?;
    let mut pipeline = Pipeline {
        progress,
        settings,
        scene,
        film: &film,
        receivers: Receivers::new(scene),
        mode,
        work: Default::default(),
        flow: Flow::default(),
        looks: None,
    };
    let [width, height] = film.size();
    let mut values = vec![Rgb::BLACK; width * height];
    let mut flow = Flow::default();
    let mut frames = 0;
    for frame in 0..settings.frames {
        let light = pipeline.frame(&sources, frame)?;
        if frames > 0 && progress.is_stopped() {
            break;
        }
        for (sum, value) in values.iter_mut().zip(light) {
            *sum += value / f64::from(settings.frames);
        }
        flow += std::mem::take(&mut pipeline.flow);
        frames += 1;
    }
    if frames < settings.frames {
        let missing = f64::from(settings.frames) / f64::from(frames.max(1));
        for value in &mut values {
            *value *= missing;
        }
    }
    let counters = Work::of_frame(&pipeline.work.map(|done| done.work));
    let is_dark = values.iter().all(|value| value.is_black());
    let warning = if progress.is_stopped() {
        Some(format!(
            "stopped in frame {} of {}: light of one frame, or frames, are missing",
            frames.max(1),
            settings.frames
        ))
    } else {
        is_dark.then(|| darkness::reason(&flow.tally, pipeline.looks.as_ref()))
    };
    Ok(Frame {
        values,
        work: stage_work(&STAGES, &pipeline.work, Work::counters),
        counters,
        flux: flow.entries(frames.max(1)),
        warnings: warning.into_iter().collect(),
    })
}

struct Pipeline<'a> {
    progress: &'a Progress,
    settings: &'a Settings,
    scene: &'a Scene,
    film: &'a SensorFilm,
    receivers: Receivers,
    mode: Mode,
    work: BySteps<Done<Work>>,
    /// Flux of the frame.
    flow: Flow,
    /// Look-ups of a map so far, if there is one.
    looks: Option<Looks>,
}

impl Clocked for Pipeline<'_> {
    type Step = Step;
    type Work = Work;

    fn done(&mut self, step: Step) -> &mut Done<Work> {
        &mut self.work[step as usize]
    }
}

impl Pipeline<'_> {
    /// Where in its pixel a frame's photons are, as a shift from the middle: the additive sequence of the
    /// plastic number (Roberts 2018), whose first points cover a square evenly.
    fn shift(frame: u32) -> DVec2 {
        const PLASTIC: f64 = 1.324_717_957_244_746;
        let step = DVec2::new(1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC));
        (step * f64::from(frame) + 0.5).fract() - 0.5
    }

    fn frame(&mut self, sources: &[Source], frame: u32) -> Result<Vec<Rgb>, Error> {
        let [specular, receiving] = targets(self.scene, self.mode, self.film.shape());
        let all = [&specular[..], &receiving[..]].concat();
        let refractor = specular
            .iter()
            .fold(Bounds::EMPTY, |all, one| all.union(one.bounds()));
        let settings = self.settings;
        let is_direct = settings.splat == Splat::Exact && settings.lookup == Lookup::Exact;
        let total: f64 = sources
            .iter()
            .map(|source| flux_bound(source, &refractor))
            .sum();
        // What is dealt out by density may be more than what sets out: the flat image of a cube's faces is
        // twice a sphere.
        let total = 2.0 * total;
        let largest = total * self.film.largest_factor(self.scene);
        // Look-ups that read maps need no sums by texel, but flux that can be summed.
        let summed = match settings.lookup {
            Lookup::Exact => self.film.size(),
            Lookup::Nearest | Lookup::Bilinear => [0; 2],
        };
        let film = ExactFilm::new(summed, largest)?;
        let shift = Self::shift(frame);
        let mut maps = Vec::new();
        for source in sources {
            let views = LightView::around(source, &all, settings.map);
            let photon_views = photon_views(settings, source, &all, &specular);
            let depths = self.depth_maps(&views);
            let lights: Vec<Light> = photon_views
                .iter()
                .map(|view| Light {
                    source,
                    view,
                    window: view.window(&refractor),
                    depths: &depths,
                    maps: &views,
                })
                .collect();
            if is_direct {
                for light in &lights {
                    let canvas = Canvas::Sensor(self.film.screen());
                    let tally = self.beams(light, &canvas, shift, &film);
                    self.flow.tally += tally;
                }
                continue;
            }
            let fluxes = self.maps(&lights, &views, shift, total)?;
            for (index, (view, flux)) in views.iter().zip(fluxes).enumerate() {
                maps.push(CausticTexture {
                    view: *view,
                    flux,
                    depths: depths.get(index).cloned(),
                });
            }
        }
        self.looked_up(maps, film)
    }

    /// Stage `lookup`: what the sensor's texels have of maps, or of a film that has it all.
    fn looked_up(&mut self, maps: Vec<CausticTexture>, film: ExactFilm) -> Result<Vec<Rgb>, Error> {
        if self.settings.lookup == Lookup::Exact {
            let values = self.timed(Step::Lookup, |this, work| this.dealt(&maps, film, work))?;
            self.account(&maps, &values);
            return Ok(values);
        }
        let settings = self.settings;
        let field = CausticTextures {
            maps,
            lookup: settings.lookup,
            bias: settings.bias,
        };
        let values = self.timed(Step::Lookup, |this, work| {
            let look = |point: &SensorPoint, looks: &mut Looks| {
                field.irradiance(&point.point, point.normal, looks)
            };
            let (values, looks, views) = this.film.evaluate(this.scene, settings.samples, look);
            *work += looks.work;
            work.add_rays(views);
            *this.looks.get_or_insert_default() += looks;
            values
        });
        self.account(&field.maps, &values);
        Ok(values)
    }

    /// The film's averages, after the maps' texels are dealt out on it.
    fn dealt(
        &self,
        maps: &[CausticTexture],
        film: ExactFilm,
        work: &mut Work,
    ) -> Result<Vec<Rgb>, Error> {
        let screen = self.film.screen();
        for map in maps {
            let (view, flux) = (&map.view, &map.flux);
            *work += deal_texels(self.scene, &self.receivers, view, flux, &screen, &film);
        }
        let measure = |texel: usize| match self.film.measure(texel) {
            0.0 => f64::INFINITY,
            measure => measure,
        };
        let sums = film.finish()?.into_iter().enumerate();
        Ok(sums.map(|(texel, sum)| sum / measure(texel)).collect())
    }

    /// What became of the flux of maps, or of beams on the sensor, on the way to the image. A camera's values
    /// are no flux: there the account ends before.
    fn account(&mut self, maps: &[CausticTexture], values: &[Rgb]) {
        if self.film.shape().is_none() {
            return;
        }
        let texels = values.iter().enumerate();
        let image: Rgb = texels
            .map(|(texel, value)| *value * self.film.measure(texel))
            .sum();
        if maps.is_empty() {
            self.flow.beside += image - self.flow.tally.landed.flux;
            return;
        }
        let screen = self.film.screen();
        let (mut total, mut beside) = (Rgb::BLACK, Rgb::BLACK);
        for CausticTexture { view, flux, .. } in maps {
            total += flux.iter().copied().sum();
            beside += flux_beside(self.scene, &self.receivers, view, flux, &screen);
        }
        self.flow.beside += -beside;
        self.flow.read += image - total + beside;
    }

    /// The receivers' depths in each view, where a stage reads them: marches do, and look-ups where receivers
    /// may hide one another.
    fn depth_maps(&mut self, views: &[LightView]) -> Vec<DepthMap> {
        if !reads_depths(self.settings, &self.receivers) {
            return Vec::new();
        }
        self.timed(Step::View, |this, work| {
            let maps = views.iter().map(|view| {
                let view = view.with_side(this.settings.photons);
                let (map, counters) = DepthMap::new(&this.receivers, view, this.settings.view);
                work.add_rays(counters);
                work.bytes += map.bytes();
                map
            });
            maps.collect()
        })
    }

    /// Beams of a light dealt out on a canvas. Where a light has several maps, the flux on its way is that of
    /// the first.
    fn beams(&mut self, light: &Light, canvas: &Canvas, shift: DVec2, film: &ExactFilm) -> Tally {
        let backs = self.backs(light, shift);
        let dealt = self.timed(Step::Splat, |this, _| {
            deal_beams(&this.tracer(light, &backs), canvas, shift, film)
        });
        for (sum, work) in self.work.iter_mut().zip(dealt.work) {
            sum.work += work;
        }
        dealt.tally
    }

    fn tracer<'b>(&'b self, light: &Light<'b>, backs: &'b Backs) -> Tracer<'b> {
        Tracer {
            progress: self.progress,
            scene: self.scene,
            receivers: &self.receivers,
            window: light.window,
            source: light.source,
            view: light.view,
            pixel_measure: light.view.measure() / math::powi(light.view.side() as f64, 2),
            mode: self.mode,
            settings: self.settings,
            backs,
            maps: light.maps,
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
        let mut tally = Tally::default();
        if self.settings.splat == Splat::Exact {
            let mut fluxes = Vec::new();
            for (index, view) in views.iter().enumerate() {
                let film = ExactFilm::new([view.side(); 2], total)?;
                for light in lights {
                    let one = self.beams(light, &Canvas::Map(view), shift, &film);
                    if index == 0 {
                        tally += one;
                    }
                }
                fluxes.push(film.finish()?);
            }
            let drawn: Rgb = fluxes.iter().flatten().copied().sum();
            self.flow.beyond_map += drawn - tally.landed.flux;
            self.flow.tally += tally;
            return Ok(fluxes);
        }
        let mut photons: Vec<Vec<Photon>> = vec![Vec::new(); views.len()];
        for light in lights {
            let (some, one) = self.photons(light, shift);
            for (all, some) in photons.iter_mut().zip(some) {
                if all.is_empty() {
                    *all = some;
                } else {
                    all.extend(some);
                }
            }
            tally += one;
        }
        let (mut brought, mut kernel) = (Rgb::BLACK, Rgb::BLACK);
        let mut fluxes = Vec::new();
        for (view, photons) in views.iter().zip(&photons) {
            let Chosen { map, drawn, .. } = self.timed(Step::Splat, |this, work| {
                let chosen = this.drawn(view, photons);
                *work += chosen.work;
                chosen
            });
            let all: Rgb = map.iter().copied().sum();
            self.flow.chosen += all - drawn;
            brought += drawn;
            if self.settings.kernel != Kernel::Gaussian && self.draws_by_kernel() {
                let home: Vec<Photon> = photons
                    .iter()
                    .filter(|photon| view.holds(photon.at))
                    .copied()
                    .collect();
                kernel += added(&home);
            }
            fluxes.push(map);
        }
        self.flow.kernel += kernel;
        self.flow.beyond_map += brought - kernel - tally.landed.flux;
        self.flow.tally += tally;
        Ok(fluxes)
    }

    /// Whether photons are drawn by `kernel`, each with a size of its own.
    fn draws_by_kernel(&self) -> bool {
        match self.settings.splat {
            Splat::Fixed | Splat::ThinLens | Splat::ThickLens | Splat::MultiResolution => true,
            Splat::TwoCurvatures | Splat::Mip | Splat::MipSplat | Splat::Exact => false,
        }
    }

    /// A map with its photons drawn.
    fn drawn(&self, view: &LightView, photons: &[Photon]) -> Chosen {
        let (side, dense) = (view.side(), self.settings.dense);
        match self.settings.splat {
            Splat::Mip => mip(side, photons, dense),
            Splat::MipSplat => mip_splat(side, photons, dense),
            Splat::MultiResolution => multi_resolution(side, photons, self.settings.kernel),
            Splat::Fixed
            | Splat::ThinLens
            | Splat::ThickLens
            | Splat::TwoCurvatures
            | Splat::Exact => {
                let (map, work) = draw(side, photons, self.settings.kernel);
                let drawn = map.iter().copied().sum();
                Chosen { map, drawn, work }
            }
        }
    }

    /// The picture of back faces, where refraction reads it.
    fn backs(&mut self, light: &Light, shift: DVec2) -> Backs {
        if !reads_backs(self.settings, self.mode) {
            return Backs::default();
        }
        self.timed(Step::View, |this, work| {
            let (backs, done) = backs(&this.tracer(light, &Backs::default()), shift);
            *work += done;
            backs
        })
    }

    /// A light's photons on each of its maps. Their stages run side by side, in tiles: the time that they
    /// take together is shared out by what threads spent in each.
    fn photons(&mut self, light: &Light, shift: DVec2) -> (Vec<Vec<Photon>>, Tally) {
        let backs = self.backs(light, shift);
        let start = Instant::now();
        let traced = photons(&self.tracer(light, &backs), shift);
        let seconds = start.elapsed().as_secs_f64();
        let all: f64 = traced.stages.iter().map(|done| done.thread_seconds).sum();
        for (sum, done) in self.work.iter_mut().zip(&traced.stages) {
            sum.work += done.work;
            if all > 0.0 {
                sum.seconds += seconds * done.thread_seconds / all;
            }
        }
        (traced.photons, traced.tally)
    }
}

/// What is specular, and what receives: the shape that is measured on, or all that a camera may see.
fn targets(scene: &Scene, mode: Mode, measured: Option<u32>) -> [Vec<Extent<'_>>; 2] {
    let shapes = scene.world().shapes();
    let (mut specular, mut receiving) = (Vec::new(), Vec::new());
    for (index, shape) in (0_u32..).zip(shapes) {
        let material = scene.material_of(index);
        if takes_part(scene, material, mode) {
            specular.push(Extent::of(shape));
        }
        if measured.map_or_else(|| is_diffuse(scene, material), |shape| shape == index) {
            receiving.push(Extent::of(shape));
        }
    }
    [specular, receiving]
}

/// The views of a light's photon buffers.
fn photon_views(
    settings: &Settings,
    source: &Source,
    all: &[Extent],
    specular: &[Extent],
) -> Vec<LightView> {
    match settings.frustum {
        Frustum::Scene => LightView::around(source, all, settings.photons),
        Frustum::Object => LightView::around(source, specular, settings.photons),
    }
}

/// A light's buffers.
#[derive(Clone, Copy, Debug)]
pub struct LightBuffers {
    /// Its caustic maps.
    pub maps: u64,
    /// Pixels of its photon buffers that specular objects may be in: photons that may land.
    pub photons: u64,
    /// Those of the largest of its buffers.
    pub largest: u64,
}

/// The buffers of all lights, as far as geometry tells.
///
/// # Errors
///
/// As [`sources`].
pub fn buffers(
    settings: &Settings,
    mode: Mode,
    scene: &Scene,
    measured: Option<u32>,
) -> Result<Vec<LightBuffers>, Refusal> {
    let [specular, receiving] = targets(scene, mode, measured);
    let all = [&specular[..], &receiving[..]].concat();
    let refractor = specular
        .iter()
        .fold(Bounds::EMPTY, |all, one| all.union(one.bounds()));
    let of_source = |source: &Source| {
        let pixels = photon_views(settings, source, &all, &specular)
            .iter()
            .map(|view| {
                let [low, high] = view.window(&refractor);
                // Centres on a border count on both sides.
                let size = (high - low).max(DVec2::ZERO).ceil() + 1.0;
                let side = view.side() as u64;
                (size.x as u64).min(side) * (size.y as u64).min(side)
            })
            .collect::<Vec<u64>>();
        LightBuffers {
            maps: LightView::around(source, &all, settings.map).len() as u64,
            photons: pixels.iter().sum(),
            largest: pixels.iter().copied().max().unwrap_or(0),
        }
    };
    Ok(sources(scene, MAPS)?.iter().map(of_source).collect())
}

/// Whether the receivers' depths are read: marches do, and look-ups where receivers may hide one another.
fn reads_depths(settings: &Settings, receivers: &Receivers) -> bool {
    let is_marched = matches!(settings.hit, Hit::DepthMap | Hit::FixedPoint);
    is_marched || settings.lookup != Lookup::Exact && receivers.may_hide()
}

/// Whether the picture of back faces is read.
fn reads_backs(settings: &Settings, mode: Mode) -> bool {
    mode == Mode::Refraction && settings.refraction == Refraction::ImageSpace
}

/// Memory \[bytes\] that the stages take beside the film's values, for these buffers.
pub fn bytes_of_stages(
    settings: &Settings,
    mode: Mode,
    scene: &Scene,
    texels: u64,
    lights: &[LightBuffers],
) -> u64 {
    let square = |side: u32| u64::from(side).pow(2);
    let (pixels, map) = (square(settings.photons), square(settings.map));
    let depths = if reads_depths(settings, &Receivers::new(scene)) {
        pixels * size_of::<f64>() as u64
    } else {
        0
    };
    let backs = if reads_backs(settings, mode) {
        pixels * size_of::<Option<Back>>() as u64
    } else {
        0
    };
    let is_exact = settings.splat == Splat::Exact;
    let is_direct = is_exact && settings.lookup == Lookup::Exact;
    let summed = if settings.lookup == Lookup::Exact {
        // As integers, and read.
        2 * TRIPLE * texels
    } else {
        0
    };
    // Photons are there in tiles and joined, on each map.
    let photon = if is_exact {
        0
    } else {
        size_of::<Photon>() as u64
    };
    // Flux as integers and read, or a splat's levels: 1 + 1/4 + 1/16 ..., and their sum.
    let drawing = match settings.splat {
        Splat::Exact | Splat::Mip | Splat::MipSplat | Splat::MultiResolution => 2,
        Splat::Fixed | Splat::ThinLens | Splat::ThickLens | Splat::TwoCurvatures => 1,
    } * TRIPLE
        * map;
    let (mut kept, mut most) = (0, 0);
    for light in lights {
        let traced = backs + photon * light.maps * (light.photons + light.largest);
        let drawn = photon * light.maps * light.photons + drawing;
        most = most.max(kept + light.maps * depths + traced.max(drawn));
        if !is_direct {
            // A map keeps depths of its own.
            kept += light.maps * (TRIPLE * map + depths);
        }
    }
    summed + most.max(kept)
}

/// A light's photon buffer.
struct Light<'a> {
    source: &'a Source,
    view: &'a LightView,
    /// The part of it that specular objects are in.
    window: [DVec2; 2],
    /// The receivers in all pictures of this light.
    depths: &'a [DepthMap],
    /// The views of this light's maps.
    maps: &'a [LightView],
}
