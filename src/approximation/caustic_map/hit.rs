//! Stage `hit`: where a photon meets a receiver.

use glam::{DVec2, DVec3};

use super::buffers::{DepthMap, Receivers};
use super::refraction::Exit;
use super::view::LightView;
use crate::approximation::Work;
use crate::geometry::{Ray, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::prescribed::{End, next_hit};
use crate::transport::screen::Screen;

/// What photons land on.
#[derive(Clone, Copy, Debug)]
pub enum Canvas<'a> {
    /// A caustic map: any receiver, by its place in the light's view.
    Map(&'a LightView),
    /// The sensor's own texels.
    Sensor(Screen<'a>),
}

/// A photon on a receiver.
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// On the canvas, in texels; may lie outside.
    pub at: DVec2,
    /// What its flux is multiplied by on the canvas.
    pub weight: Rgb,
    /// Where it is.
    pub position: DVec3,
    /// The receiver's unit normal; of a march the direction of the light.
    pub normal: DVec3,
    /// The same for photons on one smooth surface.
    pub surface: u64,
}

impl Canvas<'_> {
    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        match self {
            Self::Map(view) => [view.side(); 2],
            Self::Sensor(screen) => screen.size(),
        }
    }
}

/// A ray that is traced to the next surface, which must be no specular one; from an approximate exit point, which may
/// be inside the object still, to the next receiver.
pub fn traced(
    scene: &Scene,
    receivers: &Receivers,
    canvas: &Canvas,
    exit: &Exit,
    counters: &mut TraversalCounters,
) -> Option<Landing> {
    let found = if exit.is_exact {
        next_hit(scene, exit.ray, counters)
    } else {
        let found = receivers.first(&exit.ray, counters);
        found.map(|(hit, _)| (exit.ray, hit))
    };
    match canvas {
        Canvas::Map(view) => {
            let (ray, hit) = found?;
            if scene.material_of(hit.shape).is_specular(scene.materials()) {
                return None;
            }
            let point = scene.world().bounce_point(&ray, &hit);
            let element = scene.world().element(&hit);
            Some(Landing {
                at: view.project(point.position)?.at,
                weight: Rgb::WHITE,
                position: point.position,
                normal: point.geometric_normal,
                surface: u64::from(element.shape) << 32 | u64::from(element.face.unwrap_or(0)),
            })
        }
        Canvas::Sensor(screen) => {
            let (ray, hit) = match found {
                Some((ray, hit)) => (ray, Some(hit)),
                None => (exit.ray, None),
            };
            on_sensor(scene, screen, &ray, hit, counters)
        }
    }
}

/// Where the sensor has what a ray met.
fn on_sensor(
    scene: &Scene,
    screen: &Screen,
    ray: &Ray,
    hit: Option<crate::geometry::Hit>,
    counters: &mut TraversalCounters,
) -> Option<Landing> {
    let (end, weight, surface) = screen.end(scene, ray, hit.as_ref(), counters);
    let End::Landed(at) = end else {
        return None;
    };
    let point = hit.map(|hit| scene.world().bounce_point(ray, &hit));
    Some(Landing {
        at,
        weight,
        position: point.map_or(ray.origin, |point| point.position),
        normal: point.map_or(-ray.direction, |point| point.geometric_normal),
        surface,
    })
}

/// A march through the receivers' depth map: `steps` equal steps along the ray until it is deeper than the map, then
/// `bisections` of the last step. The way is as long as the range of depths.
///
/// The point found is on the map's surface as far as that is sampled; the march may step over what is thinner than a
/// step, and takes what is hidden from the light for solid (Szirmay-Kalos et al. 2005; section 6).
pub fn marched(
    scene: &Scene,
    receivers: &Receivers,
    canvas: &Canvas,
    exit: &Exit,
    depths: &DepthMap,
    [steps, bisections]: [u32; 2],
    work: &mut Work,
) -> Option<Landing> {
    let view = depths.view();
    let [_, far] = view.range();
    let step = far / f64::from(steps);
    let mut is_below = |distance: f64| -> Option<bool> {
        work.steps += 1;
        work.fetches += 1;
        let seen = view.project(exit.ray.at(distance))?;
        Some(seen.depth > depths.at(seen.at)?)
    };
    let mut below = None;
    for index in 1..=steps {
        let distance = step * f64::from(index);
        if is_below(distance)? {
            below = Some(distance);
            break;
        }
    }
    let mut high = below?;
    let mut low = high - step;
    for _ in 0..bisections {
        let middle = 0.5 * (low + high);
        if is_below(middle)? {
            high = middle;
        } else {
            low = middle;
        }
    }
    let position = exit.ray.at(0.5 * (low + high));
    let seen = view.project(position)?;
    match canvas {
        Canvas::Map(map) => Some(Landing {
            at: map.project(position)?.at,
            weight: Rgb::WHITE,
            position,
            normal: view.direction_to(position),
            surface: 0,
        }),
        // As a look-up would place it: along the light's ray.
        Canvas::Sensor(screen) => {
            let mut counters = TraversalCounters::default();
            let ray = view.ray(seen.at);
            let hit = receivers.first(&ray, &mut counters).map(|(hit, _)| hit);
            let landing = on_sensor(scene, screen, &ray, hit, &mut counters);
            work.add_rays(counters);
            landing
        }
    }
}
