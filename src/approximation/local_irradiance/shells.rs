//! Concentric shells around an object, each divided into the triangles of a geodesic.

use glam::DVec3;

use super::leg::{Leg, Stencil};
use crate::geometry::Geodesic;

/// Concentric shells: a cell is what is between two spheres and behind a triangle of directions.
#[derive(Clone, Debug)]
pub struct Shells {
    geodesic: Geodesic,
    /// The radii between shells \[m\], from the innermost.
    radii: Vec<f64>,
    triangles: Vec<Sides>,
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
            std::array::from_fn(|k| crosses[k].length().atan2(edges[k][0].dot(edges[k][1])));
        let area: DVec3 = (0..3).map(|k| normals[k] * (0.5 * angles[k])).sum();
        // Van Oosterom and Strackee 1983.
        let triple = a.dot(b.cross(c));
        let solid_angle = 2.0 * triple.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
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
        Self {
            geodesic,
            radii,
            triangles,
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
        f64::midpoint(self.radii[layer], self.radii[layer + 1])
    }

    /// The shell and the triangle of a cell.
    #[inline]
    pub fn parts(&self, cell: u32) -> (usize, u32) {
        let triangles = self.triangles.len();
        (
            cell as usize / triangles,
            (cell as usize % triangles) as u32,
        )
    }

    #[inline]
    fn index(&self, layer: usize, triangle: u32) -> u32 {
        (layer * self.triangles.len()) as u32 + triangle
    }

    /// The middle of a cell.
    #[inline]
    pub fn middle(&self, cell: u32) -> DVec3 {
        let (layer, triangle) = self.parts(cell);
        self.geodesic.middle(triangle) * self.radius(layer)
    }

    /// A cell's volume \[m³\].
    pub fn volume(&self, cell: u32) -> f64 {
        let (layer, triangle) = self.parts(cell);
        let cubes = self.radii[layer + 1].powi(3) - self.radii[layer].powi(3);
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

    /// The cells that a leg crosses in their order, each with the lengths at which it enters and leaves.
    #[inline]
    pub fn cross(&self, leg: &Leg, mut visit: impl FnMut(u32, f64, f64)) {
        let (from, direction) = (leg.from, leg.direction);
        // Radius² is t² + 2 b t + c.
        let (b, c) = (from.dot(direction), from.length_squared());
        let nearest = from - direction * b;
        let least = nearest.length_squared();
        let half_chord = |radius: f64| {
            let square = radius * radius - least;
            (square > 0.0).then(|| square.sqrt())
        };
        let layers = self.layers();
        let Some(half) = half_chord(self.radii[layers]) else {
            return;
        };
        let mut enter = (-b - half).max(0.0);
        let leave = (half - b).min(leg.length);
        if enter >= leave {
            return;
        }
        let radius = (c + enter * (2.0 * b + enter)).max(0.0).sqrt();
        let mut layer = self.radii[1..layers].partition_point(|border| *border < radius);
        let start = from + direction * enter;
        let mut triangle = self.geodesic.place(start).triangle;
        // On its way through a shell a leg turns by less than half a circle: it meets few more triangles than
        // lie along that, in each shell on its way in and on its way out.
        let most = 8 * self.geodesic.frequency() as usize + 2 * layers + 64;
        for _ in 0..most {
            let sides = &self.triangles[triangle as usize];
            let (mut end, mut way) = (leave, 5);
            for k in 0..3 {
                let slope = sides.normals[k].dot(direction);
                if slope < 0.0 {
                    let at = -sides.normals[k].dot(from) / slope;
                    if at < end {
                        (end, way) = (at, k);
                    }
                }
            }
            // Inward only before the nearest place, outward always.
            if enter < -b
                && layer > 0
                && let Some(half) = half_chord(self.radii[layer])
            {
                let at = -b - half;
                if at < end {
                    (end, way) = (at, 3);
                }
            }
            if layer + 1 < layers
                && let Some(half) = half_chord(self.radii[layer + 1])
                && half - b < end
            {
                (end, way) = (half - b, 4);
            }
            let end = end.max(enter);
            visit(self.index(layer, triangle), enter, end);
            enter = end;
            match way {
                3 => layer -= 1,
                4 => layer += 1,
                5 => return,
                k => triangle = self.geodesic.neighbours(triangle)[k],
            }
        }
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
        let layers = self.layers();
        let outer = (0..layers).position(|layer| self.radius(layer) > radius);
        match outer {
            None => ([layers - 1; 2], 0.0),
            Some(0) => ([0; 2], 0.0),
            Some(outer) => {
                let (a, b) = (self.radius(outer - 1), self.radius(outer));
                ([outer - 1, outer], (radius - a) / (b - a))
            }
        }
    }

    /// The cells around a place with their shares: on each of two shells its own triangle and the two across
    /// its nearest edges, linearly between the three middles.
    ///
    /// Towards a corner the place is beyond the line between the outer two. There, these two share alone, so
    /// that no share is negative.
    #[inline]
    pub fn linear(&self, place: DVec3) -> Stencil {
        let at = self.geodesic.place(place);
        let corner = (0..3).fold(0, |most, k| {
            if at.weights[k] > at.weights[most] {
                k
            } else {
                most
            }
        });
        let neighbours = self.geodesic.neighbours(at.triangle);
        let mut three = [(at.triangle, (2.0 - 3.0 * at.weights[corner]).max(0.0)); 3];
        for (slot, step) in [(1, 1), (2, 2)] {
            let k = (corner + step) % 3;
            three[slot] = (neighbours[k], at.weights[corner] - at.weights[k]);
        }
        let sum: f64 = three.iter().map(|(_, weight)| weight).sum();
        let ([inner, outer], part) = self.between(place.length());
        let mut stencil = Stencil::default();
        for (triangle, weight) in three {
            stencil.push(self.index(inner, triangle), weight / sum * (1.0 - part));
            if outer != inner {
                stencil.push(self.index(outer, triangle), weight / sum * part);
            }
        }
        stencil
    }
}
