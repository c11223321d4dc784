//! Concentric shells around an object, each divided into the triangles of a geodesic.

use glam::DVec3;

use super::leg::{Crossed, Leg, Stencil};
use crate::geometry::{Geodesic, GeodesicDual};
use crate::numeric::math;

/// Concentric shells: a cell is what is between two spheres and behind a triangle of directions.
#[derive(Clone, Debug)]
pub struct Shells {
    geodesic: Geodesic,
    dual: GeodesicDual,
    /// The radii between shells \[m\], from the innermost.
    radii: Vec<f64>,
    /// The radii in the middle of each shell \[m\].
    halfway: Vec<f64>,
    triangles: Vec<Sides>,
    /// The number of a shell's triangles is 5 times two to this.
    shift: u32,
}

/// The borders of a triangle of directions.
#[derive(Clone, Copy, Debug)]
struct Sides {
    /// Unit normals of the planes through its edges, inward. Each edge is opposite to the corner of its
    /// place.
    normals: [DVec3; 3],
    /// The angles \[rad\] of its edges.
    angles: [f64; 3],
    /// The vector area of the spherical triangle.
    area: DVec3,
    /// Its solid angle \[sr\].
    solid_angle: f64,
}

impl Sides {
    fn new([a, b, c]: [DVec3; 3]) -> Self {
        let edges = [[b, c], [c, a], [a, b]];
        let crosses = edges.map(|[from, to]| from.cross(to));
        let normals = crosses.map(DVec3::normalize);
        let angles =
            std::array::from_fn(|k| math::atan2(crosses[k].length(), edges[k][0].dot(edges[k][1])));
        let area: DVec3 = (0..3).map(|k| normals[k] * (0.5 * angles[k])).sum();
        // Van Oosterom and Strackee 1983.
        let triple = a.dot(b.cross(c));
        let solid_angle = 2.0 * math::atan2(triple, 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        Self {
            normals,
            angles,
            area,
            solid_angle,
        }
    }
}

impl Shells {
    /// Shells between some radii \[m\] that grow, of 20·4^level triangles each.
    pub fn new(level: u32, radii: Vec<f64>) -> Self {
        let geodesic = Geodesic::new(1 << level);
        let triangles = (0..geodesic.triangles().len() as u32)
            .map(|triangle| Sides::new(geodesic.corners(triangle)))
            .collect();
        let pairs = radii.windows(2);
        Self {
            dual: GeodesicDual::new(&geodesic),
            geodesic,
            halfway: pairs.map(|pair| f64::midpoint(pair[0], pair[1])).collect(),
            radii,
            triangles,
            shift: 2 * level + 2,
        }
    }

    /// The radii between shells \[m\].
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    /// The division of each shell.
    pub fn geodesic(&self) -> &Geodesic {
        &self.geodesic
    }

    /// Triangles of a shell.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// Shells.
    pub fn layers(&self) -> usize {
        self.radii.len() - 1
    }

    /// All cells.
    pub fn count(&self) -> usize {
        self.layers() * self.triangles()
    }

    /// The radius \[m\] in the middle of a shell.
    #[inline]
    pub fn radius(&self, layer: usize) -> f64 {
        self.halfway[layer]
    }

    /// The shell and the triangle of a cell.
    #[inline]
    pub fn parts(&self, cell: u32) -> (usize, u32) {
        // A shell has 5 · 2^shift triangles: 5 is divided by without a division.
        let layer = (cell >> self.shift) / 5;
        (layer as usize, cell - layer * self.triangles.len() as u32)
    }

    #[inline]
    fn index(&self, layer: usize, triangle: u32) -> u32 {
        (layer * self.triangles.len()) as u32 + triangle
    }

    /// The middle of a cell.
    #[inline]
    pub fn middle(&self, cell: u32) -> DVec3 {
        let (layer, triangle) = self.parts(cell);
        self.dual.middle(triangle) * self.radius(layer)
    }

    /// The unit directions of the middles of a shell's triangles.
    pub fn middles(&self) -> &[DVec3] {
        self.dual.middles()
    }

    /// A cell's volume \[m³\].
    pub fn volume(&self, cell: u32) -> f64 {
        let (layer, triangle) = self.parts(cell);
        let cubes = math::powi(self.radii[layer + 1], 3) - math::powi(self.radii[layer], 3);
        self.triangles[triangle as usize].solid_angle * cubes / 3.0
    }

    /// A cell's area \[m²\] across a unit direction: half of Σ |A·d| over its faces, spherical ones by their
    /// vector areas.
    #[inline]
    pub fn across(&self, cell: u32, direction: DVec3) -> f64 {
        let (layer, triangle) = self.parts(cell);
        let sides = &self.triangles[triangle as usize];
        let squares = [self.radii[layer], self.radii[layer + 1]].map(|radius| radius * radius);
        let ends = (squares[0] + squares[1]) * sides.area.dot(direction).abs();
        let walls: f64 = (0..3)
            .map(|k| sides.angles[k] * sides.normals[k].dot(direction).abs())
            .sum();
        0.5 * (ends + 0.5 * (squares[1] - squares[0]) * walls)
    }

    /// The cells that a leg crosses, in their order.
    #[inline]
    pub fn cross(&self, leg: &Leg) -> impl Iterator<Item = Crossed> + '_ {
        let mut walk = Walk::new(self, leg);
        std::iter::from_fn(move || walk.as_mut()?.next())
    }

    /// The cell of a place, or the nearest one.
    #[inline]
    pub fn nearest(&self, place: DVec3) -> Stencil {
        let radius = place.length();
        let layer = self.radii[1..self.layers()].partition_point(|border| *border < radius);
        Stencil::one(self.index(layer, self.geodesic.place(place).triangle))
    }

    /// The shells around a radius, the inner one first, and the share of the outer one.
    #[inline]
    pub fn between(&self, radius: f64) -> ([usize; 2], f64) {
        /// Shells of which each is looked at: a search among them has branches that nothing foretells.
        const FEW: usize = 16;
        let is_within = |middle: &f64| *middle <= radius;
        if self.halfway.last().is_some_and(is_within) {
            return ([self.halfway.len() - 1; 2], 0.0);
        }
        let outer = if self.halfway.len() <= FEW {
            self.halfway
                .iter()
                .filter(|middle| is_within(middle))
                .count()
        } else {
            self.halfway.partition_point(is_within)
        };
        if outer == 0 {
            return ([0; 2], 0.0);
        }
        let (a, b) = (self.halfway[outer - 1], self.halfway[outer]);
        ([outer - 1, outer], (radius - a) / (b - a))
    }

    /// The cells around a place with their shares: on each of two shells the three between whose middles it
    /// is.
    #[inline]
    pub fn linear(&self, place: DVec3) -> Stencil {
        self.stencil(self.dual.between(place), self.between(place.length()))
    }

    /// The cells of three triangles on two shells, or on one, by their shares.
    #[inline]
    pub fn stencil(
        &self,
        three: [(u32, f64); 3],
        ([inner, outer], part): ([usize; 2], f64),
    ) -> Stencil {
        if outer == inner {
            let mut stencil = Stencil::default();
            for (triangle, share) in three {
                stencil.push(self.index(inner, triangle), share * (1.0 - part));
            }
            return stencil;
        }
        let mut stencil = Stencil::default();
        for (cell, share) in self.six(three, ([inner, outer], part)) {
            stencil.push(cell, share);
        }
        stencil
    }

    /// The cells of three triangles on two shells, with their shares: of each triangle the inner shell's
    /// cell, then the outer one's.
    #[inline]
    pub fn six(
        &self,
        [a, b, c]: [(u32, f64); 3],
        ([inner, outer], part): ([usize; 2], f64),
    ) -> [(u32, f64); 6] {
        let low = |(triangle, share)| (self.index(inner, triangle), share * (1.0 - part));
        let high = |(triangle, share)| (self.index(outer, triangle), share * part);
        [low(a), high(a), low(b), high(b), low(c), high(c)]
    }

    /// The triangles of a shell by the places of their middles.
    pub fn dual(&self) -> &GeodesicDual {
        &self.dual
    }
}

/// A leg on its way through shells.
struct Walk<'a> {
    shells: &'a Shells,
    leg: Leg,
    /// The leg's part along itself of the place it starts at, and its least distance² from the centre.
    along: f64,
    least: f64,
    /// The next cell.
    layer: usize,
    triangle: u32,
    /// The length at which the leg enters it, and that at which it leaves them all.
    enter: f64,
    leave: f64,
    /// Cells that may still follow.
    left: usize,
}

impl<'a> Walk<'a> {
    /// `None` if the leg crosses no cell.
    #[inline]
    fn new(shells: &'a Shells, leg: &Leg) -> Option<Self> {
        let (from, direction) = (leg.from, leg.direction);
        let layers = shells.layers();
        // Radius² is t² + 2 along t + from².
        let along = from.dot(direction);
        let mut walk = Self {
            shells,
            leg: *leg,
            along,
            least: (from - direction * along).length_squared(),
            layer: 0,
            triangle: 0,
            enter: 0.0,
            leave: leg.length,
            // On its way through a shell a leg turns by less than half a circle: it meets few more triangles
            // than lie along that, in each shell on its way in and on its way out.
            left: 8 * shells.geodesic.frequency() as usize + 2 * layers + 64,
        };
        let half = walk.half_chord(layers)?;
        walk.enter = (-along - half).max(0.0);
        walk.leave = walk.leave.min(half - along);
        if walk.enter >= walk.leave {
            return None;
        }
        let square = from.length_squared() + walk.enter * (2.0 * along + walk.enter);
        let radius = square.max(0.0).sqrt();
        walk.layer = shells.radii[1..layers].partition_point(|border| *border < radius);
        let start = from + direction * walk.enter;
        walk.triangle = shells.geodesic.place(start).triangle;
        Some(walk)
    }

    /// Half of the leg's way within a border, if it meets it.
    #[inline]
    fn half_chord(&self, border: usize) -> Option<f64> {
        let radius = self.shells.radii[border];
        let square = radius * radius - self.least;
        (square > 0.0).then(|| square.sqrt())
    }

    #[inline]
    fn next(&mut self) -> Option<Crossed> {
        self.left = self.left.checked_sub(1)?;
        let shells = self.shells;
        let sides = &shells.triangles[self.triangle as usize];
        let (mut end, mut way) = (self.leave, 5);
        for k in 0..3 {
            let slope = sides.normals[k].dot(self.leg.direction);
            if slope < 0.0 {
                let at = -sides.normals[k].dot(self.leg.from) / slope;
                if at < end {
                    (end, way) = (at, k);
                }
            }
        }
        // Inward only before the nearest place, outward always.
        if self.enter < -self.along
            && self.layer > 0
            && let Some(half) = self.half_chord(self.layer)
        {
            let at = -self.along - half;
            if at < end {
                (end, way) = (at, 3);
            }
        }
        if self.layer + 1 < shells.layers()
            && let Some(half) = self.half_chord(self.layer + 1)
            && half - self.along < end
        {
            (end, way) = (half - self.along, 4);
        }
        let end = end.max(self.enter);
        let crossed = Crossed {
            cell: shells.index(self.layer, self.triangle),
            from: self.enter,
            to: end,
            outward: shells.dual.middle(self.triangle),
        };
        self.enter = end;
        match way {
            3 => self.layer -= 1,
            4 => self.layer += 1,
            5 => self.left = 0,
            k => self.triangle = shells.geodesic.neighbours(self.triangle)[k],
        }
        Some(crossed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::{Stream, StreamKind};

    #[test]
    fn a_leg_crosses_its_cells_without_gaps_and_each_has_what_is_in_it() {
        let shells = Shells::new(3, vec![0.0, 0.4, 1.0, 1.3, 3.0]);
        let stream = Stream::new(StreamKind::Random, 1);
        for index in 0..20_000 {
            let [a, b, c, d] = stream.point4(index);
            let [e, f, g, _] = stream.padded4(index, 1);
            let from = DVec3::new(a, b, c) * 8.0 - 4.0;
            let towards = DVec3::new(d, e, f) * 4.0 - 2.0;
            let leg = Leg {
                from,
                direction: (towards - from).normalize(),
                length: if index % 2 == 0 {
                    f64::INFINITY
                } else {
                    6.0 * g
                },
            };
            let mut last: Option<f64> = None;
            let mut sum = 0.0;
            for Crossed { cell, from, to, .. } in shells.cross(&leg) {
                assert!(last.is_none_or(|last| last == from), "{index}");
                last = Some(to);
                sum += to - from;
                if to - from > 1e-9 {
                    let place = leg.at(f64::midpoint(from, to));
                    assert_eq!(shells.nearest(place).cells(), [cell], "{index}");
                }
            }
            let along = leg.from.dot(leg.direction);
            let square = along * along - leg.from.length_squared() + 9.0;
            let expected = if square > 0.0 {
                let ends = [-along - square.sqrt(), -along + square.sqrt()];
                (ends[1].min(leg.length) - ends[0].max(0.0)).max(0.0)
            } else {
                0.0
            };
            assert!(
                (sum - expected).abs() < 1e-12,
                "{index}: {sum} {expected} {leg:?}"
            );
        }
    }

    #[test]
    fn cells_fill_their_ball_and_have_the_areas_of_their_volume() {
        let shells = Shells::new(2, vec![0.0, 1.0, 1.5, 2.0]);
        let volume: f64 = (0..shells.count() as u32)
            .map(|cell| shells.volume(cell))
            .sum();
        let ball = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
        assert!((volume / ball - 1.0).abs() < 1e-12);
        // The mean area across all directions is a quarter of the surface of a convex body. Cells are convex
        // but for their inner sphere, and patches count by their vector areas: together less than 2 % here.
        let cell = shells.triangles() as u32 + 7;
        let geodesic = Geodesic::new(12);
        let directions = geodesic.vertices();
        let mean = directions
            .iter()
            .map(|d| shells.across(cell, *d))
            .sum::<f64>()
            / directions.len() as f64;
        let sides = &shells.triangles[7];
        let patches = sides.solid_angle * (1.0 + 1.5 * 1.5);
        let walls: f64 = sides.angles.iter().map(|angle| 0.5 * angle * 1.25).sum();
        assert!(
            (mean / (0.25 * (patches + walls)) - 1.0).abs() < 0.02,
            "{mean}"
        );
    }

    #[test]
    fn a_cell_is_found_by_its_shell_and_triangle() {
        for level in 0..4 {
            let shells = Shells::new(level, vec![0.0, 1.0, 2.0, 3.0]);
            for cell in 0..shells.count() as u32 {
                let (layer, triangle) = shells.parts(cell);
                assert!((triangle as usize) < shells.triangles());
                assert_eq!(shells.index(layer, triangle), cell);
            }
        }
    }

    #[test]
    fn linear_shares_sum_to_one_and_give_a_middle_its_own() {
        let shells = Shells::new(3, vec![0.0, 1.0, 2.0, 3.0]);
        for cell in 0..shells.count() as u32 {
            let stencil = shells.linear(shells.middle(cell));
            let own: f64 = stencil
                .iter()
                .filter(|(one, _)| *one == cell)
                .map(|(_, w)| w)
                .sum();
            assert!((own - 1.0).abs() < 1e-12, "{cell}: {own}");
            let sum: f64 = stencil.iter().map(|(_, weight)| weight).sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
    }
}
