//! Stage `hit`: where a photon meets a receiver.

use glam::{DVec2, DVec3};

use super::loss::Loss;
use super::refraction::Exit;
use super::work::Work;
use crate::approximation::light_view::Projection;
use crate::approximation::{DepthMap, LightView, Receivers};
use crate::geometry::{Hit, Ray, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::path_end::{End, next_hits};
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
    /// In space.
    pub position: DVec3,
    /// What its flux is multiplied by on the canvas.
    pub weight: Rgb,
    /// The same for corners on one smooth surface.
    pub surface: u64,
}

/// What rays meet that are traced on: the next surface; from an approximate exit point, which may be inside
/// the object still, the next receiver. An entry each, with the ray to it.
fn next<'e>(
    scene: &Scene,
    receivers: &Receivers,
    exits: impl Iterator<Item = &'e Exit> + Clone,
    counters: &mut TraversalCounters,
) -> Vec<Option<(Ray, Hit)>> {
    // All are of one variant of `refraction`.
    if !exits.clone().any(|exit| exit.may_be_inside) {
        return next_hits(scene, exits.map(|exit| exit.ray), counters);
    }
    let next = |exit: &Exit| {
        let (hit, _) = receivers.first(&exit.ray, counters)?;
        Some((exit.ray, hit))
    };
    exits.map(next).collect()
}

/// Photons whose rays are traced to the next surface, an entry each.
///
/// # Errors
///
/// Where that is a specular one, and where there is none.
pub fn traced<'e>(
    scene: &Scene,
    receivers: &Receivers,
    exits: impl Iterator<Item = &'e Exit> + Clone,
    counters: &mut TraversalCounters,
) -> Vec<Result<Place, Loss>> {
    let place = |found: Option<(Ray, Hit)>| {
        let (ray, hit) = found.ok_or(Loss::NoReceiver)?;
        if scene.material_of(hit.shape).is_specular(scene.materials()) {
            return Err(Loss::Specular);
        }
        let point = scene.world().bounce_point(&ray, &hit);
        let element = scene.world().element(&hit);
        Ok(Place {
            position: point.position,
            normal: point.geometric_normal,
            surface: u64::from(element.shape) << 32 | u64::from(element.face.unwrap_or(0)),
        })
    };
    let found = next(scene, receivers, exits, counters);
    found.into_iter().map(place).collect()
}

/// Corners of beams that are traced to the sensor, an entry each.
///
/// # Errors
///
/// Where they meet anything else, or nothing.
pub fn traced_on_sensor<'e>(
    scene: &Scene,
    receivers: &Receivers,
    screen: &Screen,
    exits: impl Iterator<Item = &'e Exit> + Clone,
    counters: &mut TraversalCounters,
) -> Vec<Result<Landing, Loss>> {
    let found = next(scene, receivers, exits.clone(), counters);
    let landing = |(exit, found): (&Exit, Option<(Ray, Hit)>)| {
        // A sensor on a plane also knows what would land beyond its border, where nothing is met.
        let (ray, hit) = found.map_or((exit.ray, None), |(ray, hit)| (ray, Some(hit)));
        on_sensor(scene, screen, &ray, hit, counters).ok_or_else(|| {
            let is_specular =
                |hit: Hit| scene.material_of(hit.shape).is_specular(scene.materials());
            match hit {
                Some(hit) if is_specular(hit) => Loss::Specular,
                Some(_) => Loss::BesideSensor,
                None => Loss::NoReceiver,
            }
        })
    };
    exits.zip(found).map(landing).collect()
}

/// A corner of a beam that marched to a receiver, where a look-up would place it: along the light's ray.
///
/// # Errors
///
/// Where the sensor has no texel.
pub fn marched_on_sensor(
    scene: &Scene,
    receivers: &Receivers,
    screen: &Screen,
    depths: &[DepthMap],
    place: &Place,
    counters: &mut TraversalCounters,
) -> Result<Landing, Loss> {
    let (map, seen) = seen_in(depths, place.position).ok_or(Loss::NoReceiver)?;
    let ray = map.view().ray(seen.at);
    let hit = receivers.first(&ray, counters).map(|(hit, _)| hit);
    on_sensor(scene, screen, &ray, hit, counters).ok_or(Loss::BesideSensor)
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
    let End::Landed(at) = end else {
        return None;
    };
    let measured = match screen {
        Screen::Receiver(receiver) => {
            scene.world().shapes()[receiver.shape() as usize].meet_beyond(ray)
        }
        Screen::Camera { .. } => None,
    };
    let distance = measured.map(|(distance, _)| distance);
    let distance = distance.or_else(|| hit.map(|hit| hit.distance))?;
    Some(Landing {
        at,
        position: ray.at(distance),
        weight,
        surface,
    })
}

/// The first of a light's pictures that a point is in, and where.
#[inline]
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
///
/// # Errors
///
/// Where the way leaves all pictures, or ends, above the receivers.
pub fn marched(
    exit: &Exit,
    depths: &[DepthMap],
    [steps, bisections]: [u32; 2],
    work: &mut Work,
) -> Result<Place, Loss> {
    let far = depths.first().ok_or(Loss::NoReceiver)?.view().range()[1];
    let step = far / f64::from(steps);
    let mut is_below = |distance: f64| -> Result<bool, Loss> {
        work.steps += 1;
        let (depth, found) = depths_at(depths, exit.ray.at(distance), work)?;
        Ok(depth > found)
    };
    let mut below = None;
    for index in 1..=steps {
        let distance = step * f64::from(index);
        if is_below(distance)? {
            below = Some(distance);
            break;
        }
    }
    let mut high = below.ok_or(Loss::NoReceiver)?;
    let mut low = high - step;
    for _ in 0..bisections {
        let middle = 0.5 * (low + high);
        if is_below(middle)? {
            high = middle;
        } else {
            low = middle;
        }
    }
    seen_place(depths, exit.ray.at(0.5 * (low + high)))
}

/// The march of Wyman's demo of 2008 (`createPhotonBuffer`): the ray's direction T is scaled to a depth of 1.
///
/// Of two guesses, 0 and 1 scene unit of depth, it takes the one nearer to what the light sees there. Ten
/// times it goes to that depth: t ← z(P₂ + t T) − z(P₂), with z the depth of the receiver in a point's
/// pixel.
///
/// # Errors
///
/// Where the ray runs back to the light, and where a step leaves all pictures or is on no receiver.
pub fn fixed_point(exit: &Exit, depths: &[DepthMap], work: &mut Work) -> Result<Place, Loss> {
    const GUESSES: [f64; 2] = [0.0, 1.0];
    const STEPS: u32 = 10;
    let start = exit.ray.origin;
    let axis = depths.first().ok_or(Loss::NoReceiver)?.view().axis();
    let slope = exit.ray.direction.dot(axis);
    if slope <= 0.0 {
        return Err(Loss::NoReceiver);
    }
    let along = exit.ray.direction / slope;
    // Faces of a cube have axes of their own: depths are those along the first one's.
    let mut further = |distance: f64| -> Result<f64, Loss> {
        work.steps += 1;
        let point = start + along * distance;
        let (depth, found) = depths_at(depths, point, work)?;
        if !found.is_finite() {
            return Err(Loss::NoReceiver);
        }
        let (map, seen) = seen_in(depths, point).ok_or(Loss::NoReceiver)?;
        let ray = map.view().ray(seen.at);
        let below = (found - depth) / ray.direction.dot(map.view().axis());
        Ok((point + ray.direction * below - start).dot(axis))
    };
    let mut best = (f64::INFINITY, 0.0);
    for guess in GUESSES {
        let off = further(guess).map_or(f64::INFINITY, |found| (found - guess).abs());
        if off < best.0 {
            best = (off, guess);
        }
    }
    let mut distance = best.1;
    for _ in 0..STEPS {
        distance = further(distance)?;
    }
    seen_place(depths, start + along * distance)
}

/// The depth of a point, and that of the receiver which the light sees there.
#[inline]
fn depths_at(depths: &[DepthMap], point: DVec3, work: &mut Work) -> Result<(f64, f64), Loss> {
    work.fetches += 1;
    let (map, seen) = seen_in(depths, point).ok_or(Loss::NoReceiver)?;
    let found = map.at(seen.at).ok_or(Loss::NoReceiver)?;
    Ok((seen.depth, found))
}

/// A photon at a point that the light sees.
fn seen_place(depths: &[DepthMap], position: DVec3) -> Result<Place, Loss> {
    let (map, _) = seen_in(depths, position).ok_or(Loss::NoReceiver)?;
    Ok(Place {
        position,
        normal: map.view().direction_to(position),
        surface: 0,
    })
}
