//! One photon map: the photons of one pass at the surfaces that scatter light, and the search among them.

use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::reference::photons::layers::LayerMap;
use crate::reference::photons::replicate::{Recipient, Task};
use crate::run::Error;
use crate::scene::{Material, MaterialId, Scene};
use crate::transport::chain::Arrival;
use crate::transport::flux::Flux;
use crate::transport::glossy;
use crate::transport::ledger::Fate;
use crate::transport::signature::Signature;

/// A photon at the surface that it met.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// The unit vector it travelled along.
    pub direction: DVec3,
    /// Flux that arrived \[W\].
    pub flux: Rgb,
    /// The layer of its signature.
    pub layer: u32,
    /// The shape it met.
    pub shape: u32,
}

/// Memory of a photon of a map \[bytes\]: as its task left it, and joined; its place and its number in the
/// tree.
pub const PHOTON_BYTES: u64 =
    2 * (size_of::<Photon>() + size_of::<[f64; 3]>()) as u64 + size_of::<[f64; 4]>() as u64;

/// A record of the photons that a task leaves on surfaces that scatter.
pub struct Catch<'a> {
    /// For each shape, true if it scatters: see [`scattering_shapes`].
    pub scatters: &'a [bool],
    /// The scene if light of rough interfaces does not count on others.
    pub without: Option<&'a Scene>,
    /// Layers of signatures.
    pub map: &'a LayerMap,
    /// Places of the photons.
    pub positions: Vec<[f64; 3]>,
    /// The photons at these places.
    pub photons: Vec<Photon>,
}

impl Recipient<3> for Catch<'_> {
    /// Its sums are of `f64`: their last bits depend on the order in which the map keeps its photons.
    const IS_ORDERED: bool = true;

    fn emitted(&mut self, _flux: Flux<3>) {}

    #[inline]
    fn arrived(&mut self, arrival: &Arrival<3>, _counters: &mut TraversalCounters) -> Fate {
        let shape = arrival.hit.shape;
        // Direct light is no caustic; photons find only the part of it that passes the borders of glass.
        let is_left_out = |scene| glossy::is_met(scene, arrival.hit, arrival.point, arrival.ray);
        if self.scatters[shape as usize]
            && !arrival.signature.is_empty()
            && !(arrival.signature.is_glossy() && self.without.is_some_and(is_left_out))
        {
            self.positions.push(arrival.point.position.to_array());
            self.photons.push(Photon {
                direction: arrival.ray.direction,
                flux: arrival.flux.rgb(),
                layer: self.map.layer(arrival.signature) as u32,
                shape,
            });
        }
        Fate::Absorbed
    }

    fn ended(&mut self, _signature: Signature, _fate: Fate, _flux: Flux<3>) {}

    fn gained(&mut self, _flux: Flux<3>) {}

    fn finish(&mut self) {}
}

/// For each shape, true if it scatters any light in a way that has a density over directions.
pub fn scattering_shapes(scene: &Scene) -> Vec<bool> {
    let scatters = |object: &crate::scene::Object| scatters(scene, object.material);
    scene.objects().iter().map(scatters).collect()
}

fn scatters(scene: &Scene, id: MaterialId) -> bool {
    let material = scene.material(id);
    match material {
        Material::Dielectric { .. }
        | Material::ThinDielectric { .. }
        | Material::Conductor { .. }
        | Material::Null => false,
        Material::Mask { .. }
        | Material::TwoSided { .. }
        | Material::Blend { .. }
        | Material::Turned { .. } => material.nested().any(|id| scatters(scene, id)),
        _ => true,
    }
}

/// The photons of one pass, to be searched by place.
pub struct PhotonMap {
    photons: Vec<Photon>,
    /// The search tree; `None` if there are no photons.
    ///
    /// The mutable trees of kiddo fail on points that share a coordinate, as photons on a floor do. Its
    /// immutable ones do not.
    tree: Option<ImmutableKdTree<f64, 3>>,
}

impl PhotonMap {
    /// The map of all photons that the tasks of a pass recorded, in their order.
    ///
    /// # Errors
    ///
    /// If the tree refuses so many photons.
    pub fn new(tasks: Vec<Task<Catch<'_>>>) -> Result<Self, Error> {
        let mut positions = Vec::new();
        let mut photons = Vec::new();
        for task in tasks {
            positions.extend(task.recipient.positions);
            photons.extend(task.recipient.photons);
        }
        Self::of(&positions, photons)
    }

    fn of(positions: &[[f64; 3]], photons: Vec<Photon>) -> Result<Self, Error> {
        let tree = if positions.is_empty() {
            None
        } else {
            let tree = ImmutableKdTree::new_from_slice(positions);
            Some(tree.map_err(|error| {
                let photons = positions.len();
                let reason =
                    format!("a photon map of {photons} photons cannot be built: {error:?}");
                Error::NotRepresentable(reason)
            })?)
        };
        Ok(Self { photons, tree })
    }

    /// Number of photons.
    pub fn len(&self) -> usize {
        self.photons.len()
    }

    /// True if no photon met a surface that scatters.
    pub fn is_empty(&self) -> bool {
        self.photons.is_empty()
    }

    /// Visits each photon whose squared distance \[m²\] from `position` is at most `radius_squared`, in any
    /// order.
    #[inline]
    pub fn within(
        &self,
        position: DVec3,
        radius_squared: f64,
        mut visit: impl FnMut(&Photon, f64),
    ) {
        let Some(tree) = &self.tree else {
            return;
        };
        tree.query(&position.to_array())
            .within::<SquaredEuclidean<f64>>(radius_squared)
            .unsorted()
            .visit(|found| visit(&self.photons[found.item as usize], found.distance));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::{Stream, StreamKind};

    #[test]
    fn the_search_finds_what_looking_at_every_photon_finds() {
        let stream = Stream::new(StreamKind::Random, 3);
        // All on a floor, many at the same x, a hundred at one point.
        let position = |index: u64| {
            let [x, y] = stream.point2(index);
            match index % 10 {
                0 => [0.5, y, 0.0],
                1 => [0.25, 0.75, 0.0],
                _ => [x, y, 0.0],
            }
        };
        let positions: Vec<[f64; 3]> = (0..1000).map(position).collect();
        let photon = |index: usize| Photon {
            direction: -DVec3::Z,
            flux: Rgb::grey(index as f64),
            layer: 0,
            shape: 0,
        };
        let map = PhotonMap::of(&positions, (0..1000).map(photon).collect()).unwrap();
        for query in 0..200 {
            let [x, y] = stream.point2(5000 + query);
            let [radius, _] = stream.point2(9000 + query);
            let at = DVec3::new(x, y, 0.0);
            let radius_squared = 0.05 * radius;
            let mut found = Vec::new();
            map.within(at, radius_squared, |photon, squared| {
                let index = photon.flux.0[0] as usize;
                let expected = at.distance_squared(DVec3::from_array(positions[index]));
                assert!((squared - expected).abs() <= 1e-15);
                found.push(index);
            });
            found.sort_unstable();
            let all: Vec<usize> = (0..1000)
                .filter(|&i| at.distance_squared(positions[i].into()) <= radius_squared)
                .collect();
            assert_eq!(found, all);
        }
        let none = PhotonMap::of(&[], Vec::new()).unwrap();
        none.within(DVec3::ZERO, f64::INFINITY, |_, _| panic!("there is none"));
    }
}
