//! Stage `hit`: where a photon meets a receiver.

use glam::{DVec2, DVec3};

use super::refraction::Exit;
use super::work::Work;
use crate::approximation::light_view::Projection;
use crate::approximation::{DepthMap, LightView, Receivers};
use crate::geometry::{Hit, Ray, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::path_end::{End, next_hit};
use crate::transport::screen::Screen;

/// A photon on a receiver.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Where it is.
    pub position: DVec3,
    /// The receiver's unit normal; of a march the direction of the light.
    pub normal: DVec3,
    /// The same for photons on one smooth surface.
    pub surface: u64,
}

/// What beams land on.
#[derive(Clone, Copy, Debug)]
pub enum Canvas<'a> {
    /// A caustic map: any receiver, by its place in the light's view.
    Map(&'a LightView),
    /// The sensor's own texels.
    Sensor(Screen<'a>),
}

/// A corner of a beam on a canvas.
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// In texels; may lie outside.
    pub at: DVec2,
    /// What its flux is multiplied by on the canvas.
    pub weight: Rgb,
    /// The same for corners on one smooth surface.
    pub surface: u64,
}

/// What a ray meets that is traced on: the next surface; from an approximate exit point, which may be inside
/// the object still, the next receiver.
fn next(
    scene: &Scene,
    receivers: &Receivers,
    exit: &Exit,
    counters: &mut TraversalCounters,
) -> Option<(Ray, Hit)> {
    if exit.is_exact {
        next_hit(scene, exit.ray, counters)
    } else {
        let (hit, _) = receivers.first(&exit.ray, counters)?;
        Some((exit.ray, hit))
    }
}

/// A photon whose ray is traced to the next surface, which must be no specular one.
pub fn traced(
    scene: &Scene,
    receivers: &Receivers,
    exit: &Exit,
    counters: &mut TraversalCounters,
) -> Option<Place> {
    let (ray, hit) = next(scene, receivers, exit, counters)?;
    if scene.material_of(hit.shape).is_specular(scene.materials()) {
        return None;
    }
    let point = scene.world().bounce_point(&ray, &hit);
    let element = scene.world().element(&hit);
    Some(Place {
        position: point.position,
        normal: point.geometric_normal,
        surface: u64::from(element.shape) << 32 | u64::from(element.face.unwrap_or(0)),
    })
}

/// A corner of a beam that is traced to the sensor.
pub fn traced_on_sensor(
    scene: &Scene,
    receivers: &Receivers,
    screen: &Screen,
    exit: &Exit,
    counters: &mut TraversalCounters,
) -> Option<Landing> {
    let found = next(scene, receivers, exit, counters);
    // A sensor on a plane also knows what would land beyond its border, where nothing is met.
    let (ray, hit) = found.map_or((exit.ray, None), |(ray, hit)| (ray, Some(hit)));
    on_sensor(scene, screen, &ray, hit, counters)
}

/// A corner of a beam that marched to a receiver, where a look-up would place it: along the light's ray.
pub fn marched_on_sensor(
    scene: &Scene,
    receivers: &Receivers,
    screen: &Screen,
    depths: &[DepthMap],
    place: &Place,
    counters: &mut TraversalCounters,
) -> Option<Landing> {
    let (map, seen) = seen_in(depths, place.position)?;
    let ray = map.view().ray(seen.at);
    let hit = receivers.first(&ray, counters).map(|(hit, _)| hit);
    on_sensor(scene, screen, &ray, hit, counters)
}

/// Where the sensor has what a ray met.
fn on_sensor(
    scene: &Scene,
    screen: &Screen,
    ray: &Ray,
    hit: Option<Hit>,
    counters: &mut TraversalCounters,
) -> Option<Landing> {
    let (end, weight, surface) = screen.end(scene, ray, hit.as_ref(), counters);
    match end {
        End::Landed(at) => Some(Landing {
            at,
            weight,
            surface,
        }),
        _ => None,
    }
}

/// The first of a light's pictures that a point is in, and where.
fn seen_in(depths: &[DepthMap], point: DVec3) -> Option<(&DepthMap, Projection)> {
    depths.iter().find_map(|map| {
        let seen = map.view().project(point)?;
        map.view().holds(seen.at).then_some((map, seen))
    })
}

/// A march through the receivers' depths: `steps` equal steps along the ray until it is deeper than what the
/// light sees there, then `bisections` of the last step. The way is as long as the range of depths. `depths`
/// are all pictures of one light, as a cube's faces are; the march goes on from one to the next, and ends
/// where none has it.
///
/// The point found is on the map's surface as far as that is sampled; the march may step over what is thinner
/// than a step, and takes what is hidden from the light for solid (Szirmay-Kalos et al. 2005; section 6).
pub fn marched(
    exit: &Exit,
    depths: &[DepthMap],
    [steps, bisections]: [u32; 2],
    work: &mut Work,
) -> Option<Place> {
    let far = depths.first()?.view().range()[1];
    let step = far / f64::from(steps);
    let mut is_below = |distance: f64| -> Option<bool> {
        work.steps += 1;
        work.fetches += 1;
        let (map, seen) = seen_in(depths, exit.ray.at(distance))?;
        Some(seen.depth > map.at(seen.at)?)
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
    let (map, _) = seen_in(depths, position)?;
    Some(Place {
        position,
        normal: map.view().direction_to(position),
        surface: 0,
    })
}
