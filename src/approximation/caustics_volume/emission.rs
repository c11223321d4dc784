//! Stage `emission` (sections 3.2 and 3.4): photons on the faces of the volume.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cuboid::{Cuboid, Face};
use super::demands::Volume;
use super::photon::Photon;
use super::settings::Settings;
use super::variants::Emission;
use super::work::Work;
use crate::geometry::{Ray, TraversalCounters};
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::first_surface::Source;
use crate::transport::signature::Signature;

/// A lattice of photons on a face: the light of one source through it.
///
/// Coordinates are those of its cells: (0, 0) to (columns, rows).
#[derive(Clone, Debug)]
pub struct Lattice<'a> {
    scene: &'a Scene,
    cuboid: &'a Cuboid,
    source: &'a Source,
    emission: Emission,
    face: Face,
    columns: u32,
    rows: u32,
    /// The number of its first photon.
    first: u64,
    /// What each cell carries by the light's strength, if all are equal.
    equal: f64,
}

/// The lattices of all lights.
pub fn lattices<'a>(scene: &'a Scene, settings: &Settings, volume: &'a Volume) -> Vec<Lattice<'a>> {
    let lights = volume.sources.len() as u32;
    let mut first = 0;
    let mut all = Vec::new();
    for source in &volume.sources {
        let photons = (settings.photons / lights).max(1);
        let faces = match settings.emission {
            Emission::Parallel | Emission::Towards => vec![Face::Entry],
            Emission::Exact => Face::ALL.to_vec(),
        };
        let measures: Vec<f64> = faces
            .iter()
            .map(|face| measure(&volume.cuboid, source, *face, [DVec2::ZERO, DVec2::ONE]))
            .collect();
        let sum: f64 = measures.iter().sum();
        for (face, measure) in faces.into_iter().zip(measures) {
            if measure <= 0.0 {
                continue;
            }
            let cells = (f64::from(photons) * measure / sum).max(1.0);
            let [(_, width), (_, height)] = Cuboid::face_axes(face, volume.cuboid.size());
            let columns = (cells * width / height)
                .sqrt()
                .round()
                .clamp(1.0, cells.ceil());
            let rows = (cells / columns).round().max(1.0);
            let mut lattice = Lattice {
                scene,
                cuboid: &volume.cuboid,
                source,
                emission: settings.emission,
                face,
                columns: columns as u32,
                rows: rows as u32,
                first,
                equal: 0.0,
            };
            if settings.emission != Emission::Exact {
                lattice.equal = lattice.all() / f64::from(lattice.columns * lattice.rows);
            }
            first += u64::from(lattice.columns) * u64::from(lattice.rows);
            all.push(lattice);
        }
    }
    all
}

/// Light-space measure of a rectangle of a face: solid angle \[sr\] from a point, of parallel light area
/// across it \[m²\]; 0 if the light is behind the face.
///
/// A rectangle from (0, 0) to (x, y) at distance d has the solid angle atan(x y / (d √(d² + x² + y²))).
fn measure(cuboid: &Cuboid, source: &Source, face: Face, [low, high]: [DVec2; 2]) -> f64 {
    let middle = cuboid.to_world(cuboid.face_middle(face));
    let outward = cuboid.outward(face);
    let [(_, half_a), (_, half_b)] = Cuboid::face_axes(face, cuboid.size());
    let half = DVec2::new(half_a, half_b);
    let distance = source.towards(middle).dot(outward);
    if distance <= 0.0 {
        return 0.0;
    }
    match *source {
        Source::Parallel { direction, .. } => {
            let sides = (high - low) * half * 2.0;
            sides.element_product() * -direction.dot(outward)
        }
        Source::Point { origin, .. } => {
            let foot = cuboid.frame().to_local(origin - middle);
            let [(a, _), (b, _)] = Cuboid::face_axes(face, cuboid.size());
            let foot = DVec2::new(foot.dot(a), foot.dot(b));
            let place = |at: DVec2| (at * 2.0 - 1.0) * half - foot;
            let (p, q) = (place(low), place(high));
            let corner = |x: f64, y: f64| {
                let far = (distance * distance + x * x + y * y).sqrt();
                math::atan2(x * y, distance * far)
            };
            corner(q.x, q.y) - corner(p.x, q.y) - corner(q.x, p.y) + corner(p.x, p.y)
        }
    }
}

impl Lattice<'_> {
    /// Columns and rows of cells.
    pub fn size(&self) -> [u32; 2] {
        [self.columns, self.rows]
    }

    /// The light's strength.
    pub fn strength(&self) -> Rgb {
        self.source.strength()
    }

    /// The fraction across the face of a place in the lattice.
    fn across(&self, at: DVec2) -> DVec2 {
        at / DVec2::new(f64::from(self.columns), f64::from(self.rows))
    }

    /// Light-space measure of a rectangle of the lattice.
    fn measure(&self, low: DVec2, high: DVec2) -> f64 {
        let range = [self.across(low), self.across(high)];
        measure(self.cuboid, self.source, self.face, range)
    }

    /// The falloff of the light towards a point.
    fn falloff(&self, point: DVec3) -> f64 {
        match self.source {
            Source::Point { falloff, .. } => {
                let towards = (-self.source.towards(point)).try_normalize();
                towards.map_or(0.0, |direction| falloff.factor(direction))
            }
            Source::Parallel { .. } => 1.0,
        }
    }

    /// What goes through all of the face by the light's strength: a sum over cells of measure by falloff.
    fn all(&self) -> f64 {
        let row = |row: u32| -> f64 {
            let carried = |column: u32| {
                let low = DVec2::new(f64::from(column), f64::from(row));
                let middle = self.cuboid.face_point(self.face, self.across(low + 0.5));
                self.measure(low, low + 1.0) * self.falloff(middle)
            };
            (0..self.columns).map(carried).sum()
        };
        // In the order of rows: the sum is the same bits on any threads.
        let rows: Vec<f64> = (0..self.rows).into_par_iter().map(row).collect();
        rows.iter().sum()
    }

    /// What a rectangle of the lattice carries by the light's strength, before the factor of each place.
    pub fn carried(&self, low: DVec2, high: DVec2) -> f64 {
        match self.emission {
            Emission::Parallel | Emission::Towards => self.equal * (high - low).element_product(),
            Emission::Exact => self.measure(low, high),
        }
    }

    /// The photon that starts at a place of the lattice, with the factor on what its cell carries as flux;
    /// `None` in shadow, and out of a spot's cone.
    pub fn photon(&self, at: DVec2, index: u64, work: &mut Work) -> Option<Photon> {
        work.photons += 1;
        let point = self.cuboid.face_point(self.face, self.across(at));
        let aim = match self.emission {
            Emission::Parallel => self.cuboid.to_world(DVec3::ZERO),
            Emission::Towards | Emission::Exact => point,
        };
        let direction = (-self.source.towards(aim)).try_normalize()?;
        let factor = match self.emission {
            Emission::Parallel | Emission::Towards => 1.0,
            Emission::Exact => self.falloff(point),
        };
        let is_lost =
            factor <= 0.0 || self.emission == Emission::Exact && self.is_dark(point, work);
        work.dropped += u64::from(is_lost);
        (!is_lost).then(|| Photon {
            ray: Ray::new(point, direction),
            flux: Rgb::grey(factor),
            length: 0.0,
            is_inside: false,
            signature: Signature::DIRECT,
            last: u32::MAX,
            would_meet_front: false,
            path: 0,
            index: self.first + index,
        })
    }

    /// True if something is between the light and a point.
    fn is_dark(&self, point: DVec3, work: &mut Work) -> bool {
        let Some(arriving) = self.source.arrive(point) else {
            return true;
        };
        let scene = self.scene;
        let mut counters = TraversalCounters::default();
        let is_dark = scene.world().any_hit(
            &arriving.ray,
            arriving.distance,
            |hit| !scene.material_of(hit.shape).is_passed(scene.materials()),
            &mut counters,
        );
        work.add_rays(counters);
        is_dark
    }

    /// The photon of a cell, with its flux \[W\].
    pub fn cell(&self, index: u64, work: &mut Work) -> Option<Photon> {
        let column = index % u64::from(self.columns);
        let low = DVec2::new(column as f64, (index / u64::from(self.columns)) as f64);
        let mut photon = self.photon(low + 0.5, index, work)?;
        photon.flux = photon.flux * self.strength() * self.carried(low, low + 1.0);
        Some(photon)
    }

    /// The numbers of the photons beside one: before and after it in its row, then in its column. `None` if
    /// the photon is not of this lattice.
    pub fn neighbours(&self, photon: u64) -> Option<[[Option<u64>; 2]; 2]> {
        let cell = photon
            .checked_sub(self.first)
            .filter(|it| *it < self.cells())?;
        let columns = u64::from(self.columns);
        let beside = |place: u64, count: u64, step: u64| {
            let before = (place > 0).then(|| photon - step);
            [before, (place + 1 < count).then(|| photon + step)]
        };
        Some([
            beside(cell % columns, columns, 1),
            beside(cell / columns, u64::from(self.rows), columns),
        ])
    }

    /// Cells.
    pub fn cells(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Frame;
    use crate::transport::domain::chart::Falloff;

    #[test]
    fn faces_of_a_volume_together_have_the_solid_angle_of_all_its_cells() {
        let axes = Frame::along(DVec3::new(0.1, -0.4, 0.8).normalize(), DVec3::Y);
        let cuboid = Cuboid::new(DVec3::X, &axes, DVec3::new(1.0, 0.5, 0.3), axes.n);
        let source = Source::Point {
            origin: DVec3::new(2.0, 3.0, 4.0),
            intensity: Rgb::WHITE,
            falloff: Falloff::None,
        };
        for face in Face::ALL {
            let all = measure(&cuboid, &source, face, [DVec2::ZERO, DVec2::ONE]);
            // Brute force: dω = cos / d² dA at the midpoints of 400² cells. The midpoint rule's error falls
            // as the square of their side: 1e-5 of the face.
            let mut sum = 0.0;
            let parts = 400;
            for index in 0..parts * parts {
                let at = (DVec2::new(f64::from(index % parts), f64::from(index / parts)) + 0.5)
                    / f64::from(parts);
                let towards = source.towards(cuboid.face_point(face, at));
                let cos = towards.normalize().dot(cuboid.outward(face));
                sum += cos.max(0.0) / towards.length_squared();
            }
            let [(_, a), (_, b)] = Cuboid::face_axes(face, cuboid.size());
            sum *= 4.0 * a * b / f64::from(parts * parts);
            assert!(
                (all - sum).abs() < 1e-5 * sum + 1e-15,
                "{face:?} {all} {sum}"
            );
        }
    }
}
