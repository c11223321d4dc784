//! Stage `inside`, as a stencil buffer tells it: faces of beams against the depths of pixels (section 3.2).
//!
//! Pass 1 adds 1 for each face that is before a pixel's surface and turns to the eye, and takes 1 away for
//! each that turns away. What is left is not zero where the surface is in the beam. Pass 2 writes the value
//! of the first face, in the order in which faces are drawn, and clears the pixel. So counts the paper's
//! source, Heidmann's *Real shadows, real time* (1991). With the eye in a beam that is drawn, each pixel
//! outside of it is taken to be inside. `depth-test=fail` counts the faces behind surfaces instead, which is
//! right wherever the eye is.
//!
//! Faces are between planes, with two triangles for each side and a cap at each end. Both beams at a side cut
//! it along the same diagonal. Faces end at the near plane, as a device clips them.

use glam::{DMat3, DVec2, DVec3};

use super::beam::owns;
use super::gather::Gathered;
use super::search::Drawn;
use super::shade::{ShadeWork, Shading};
use super::slicing::Slicing;
use super::sums::Sum;
use super::variants::{Cosine, DepthTest};
use crate::approximation::SensorFilm;
use crate::approximation::bands::{Band, in_bands, signed};
use crate::approximation::sensor::{SensorPoint, midpoint};
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::transport::camera::Camera;
use rayon::prelude::*;

/// Where places are on a camera's film, in homogeneous coordinates.
struct Projector {
    inverse: DMat3,
    origin: DVec3,
    is_parallel: bool,
}

/// A vertex of a face on the film: (x w, y w), w, and its depth, which is 0 or more from the near plane on.
#[derive(Clone, Copy, Debug)]
struct FilmVertex {
    at: DVec2,
    w: f64,
    depth: f64,
    value: DVec3,
}

impl FilmVertex {
    /// The vertex on the near plane between two.
    fn cut(&self, other: &Self) -> Self {
        // The same from both ends, since neighbours may cut the same edge the other way.
        let (a, b) = if (self.at.x, self.at.y, self.w) < (other.at.x, other.at.y, other.w) {
            (self, other)
        } else {
            (other, self)
        };
        let t = a.depth / (a.depth - b.depth);
        Self {
            at: a.at + (b.at - a.at) * t,
            w: a.w + (b.w - a.w) * t,
            depth: 0.0,
            value: a.value + (b.value - a.value) * t,
        }
    }
}

impl Projector {
    fn new(camera: &Camera) -> Option<Self> {
        let plane = camera.near_plane();
        let (origin, third) = match plane.eye {
            Some(eye) => (eye, plane.corner - eye),
            None => (plane.corner, plane.direction),
        };
        let matrix = DMat3::from_cols(plane.across[0], plane.across[1], third);
        let inverse = matrix.inverse();
        inverse.is_finite().then_some(Self {
            inverse,
            origin,
            is_parallel: plane.eye.is_none(),
        })
    }

    fn vertex(&self, place: DVec3, value: DVec3) -> FilmVertex {
        let h = self.inverse * (place - self.origin);
        if self.is_parallel {
            FilmVertex {
                at: h.truncate(),
                w: 1.0,
                depth: h.z,
                value,
            }
        } else {
            // With a depth of 1 on the near plane.
            FilmVertex {
                at: h.truncate(),
                w: h.z,
                depth: h.z - 1.0,
                value,
            }
        }
    }
}

/// A pixel while beams are drawn.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    sum: Sum,
    blends: u32,
    saturated: u32,
    /// Rays of stages `shadow` and `occlusion`.
    rays: [u32; 2],
}

/// Memory of a pixel \[bytes\].
pub const PIXEL_BYTES: u64 = size_of::<Pixel>() as u64;

/// Draws beams on a camera's film at `samples` x `samples` points of each pixel, one point of all pixels
/// after the other.
pub fn draw(
    shading: &Shading,
    drawn: &[Drawn],
    film: &SensorFilm,
    camera: &Camera,
    samples: u32,
) -> Gathered {
    let [width, height] = film.size();
    let mut gathered = Gathered {
        values: vec![Rgb::BLACK; width * height],
        work: ShadeWork::default(),
        views: TraversalCounters::default(),
    };
    let Some(projector) = Projector::new(camera) else {
        return gathered;
    };
    for place in 0..samples * samples {
        if shading.lit.progress.is_stopped() {
            break;
        }
        let at = midpoint(place, samples);
        let points = visible(shading, film, at, &mut gathered.views);
        let view = Drawing {
            shading,
            slicing: shading.lit.slicing,
            points: &points,
            projector: &projector,
            at,
            size: [width, height],
            depths: points
                .iter()
                .map(|point| {
                    point.as_ref().map_or(f64::NAN, |it| {
                        projector.vertex(it.point.position, DVec3::ZERO).depth
                    })
                })
                .collect(),
        };
        let (pixels, work) = view.all(drawn);
        gathered.work += work;
        let share = 1.0 / f64::from(samples * samples);
        for ((value, pixel), point) in gathered.values.iter_mut().zip(&pixels).zip(&points) {
            if let Some(point) = point {
                let irradiance = shading.irradiance(&pixel.sum, point);
                *value += point.measured(Rgb::grey(irradiance)) * share;
            }
        }
    }
    gathered
}

/// What a camera sees at a point of each pixel.
fn visible(
    shading: &Shading,
    film: &SensorFilm,
    at: DVec2,
    views: &mut TraversalCounters,
) -> Vec<Option<SensorPoint>> {
    let [width, height] = film.size();
    let rows: Vec<(Vec<Option<SensorPoint>>, TraversalCounters)> = (0..height)
        .into_par_iter()
        .map(|row| {
            let mut counters = TraversalCounters::default();
            let points = (row * width..(row + 1) * width)
                .map(|texel| film.point(shading.lit.scene, texel, at, &mut counters).1);
            (points.collect(), counters)
        })
        .collect();
    let mut all = Vec::with_capacity(width * height);
    for (points, counters) in rows {
        all.extend(points);
        *views += counters;
    }
    all
}

/// Beams on the film.
struct Drawing<'a> {
    shading: &'a Shading<'a>,
    slicing: &'a Slicing,
    /// What is seen in each pixel.
    points: &'a [Option<SensorPoint>],
    projector: &'a Projector,
    /// The point of each pixel that is drawn, in fractions of it.
    at: DVec2,
    size: [usize; 2],
    /// The surface's depth in each pixel; no number where there is none.
    depths: Vec<f64>,
}

impl Drawing<'_> {
    fn all(&self, drawn: &[Drawn]) -> (Vec<Pixel>, ShadeWork) {
        let rows = |drawn: &Drawn| self.rows(drawn);
        let (pixels, fragments) =
            in_bands(self.size, drawn, rows, |drawn, band: &mut Band<Pixel>| {
                if !self.shading.lit.progress.is_stopped() {
                    self.beam(drawn, band);
                }
            });
        let mut work = ShadeWork::default();
        work.inside.fragments = fragments;
        for pixel in &pixels {
            self.shading.count(
                u64::from(pixel.blends),
                u64::from(pixel.saturated),
                &mut work.accumulate,
            );
            work.shadow.rays += u64::from(pixel.rays[0]);
            work.occlusion.rays += u64::from(pixel.rays[1]);
        }
        (pixels, work)
    }

    /// The least and the largest film coordinates that a beam may reach; `None` if a part of it is before the
    /// near plane.
    fn reach(&self, drawn: &Drawn) -> Option<[DVec2; 2]> {
        let mut reach = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        for depth in drawn.depths {
            for ruling in &drawn.beam.rulings {
                let place = self.slicing.world(ruling.at(depth), depth);
                let vertex = self.projector.vertex(place, DVec3::ZERO);
                if vertex.depth < 0.0 {
                    return None;
                }
                let at = vertex.at / vertex.w;
                reach = [reach[0].min(at), reach[1].max(at)];
            }
        }
        Some(reach)
    }

    /// The first and the last row that a beam may reach.
    fn rows(&self, drawn: &Drawn) -> (i64, i64) {
        let last = signed(self.size[1]) - 1;
        self.reach(drawn).map_or((0, last), |[low, high]| {
            let limit = self.size[1] as f64;
            (
                low.y.clamp(-1.0, limit).floor() as i64,
                high.y.clamp(-1.0, limit).floor() as i64,
            )
        })
    }

    /// The first column that a beam may reach, and the first beyond it.
    fn columns(&self, drawn: &Drawn) -> [usize; 2] {
        let width = self.size[0] as f64;
        self.reach(drawn).map_or([0, self.size[0]], |[low, high]| {
            // A column to spare on either side.
            [low.x - 1.0, high.x + 2.0].map(|x| x.clamp(0.0, width) as usize)
        })
    }

    /// Draws a beam in a band.
    fn beam(&self, drawn: &Drawn, band: &mut Band<Pixel>) {
        let beam = drawn.beam;
        let ring = |plane: u32| -> [FilmVertex; 3] {
            let depth = self.slicing.plane(plane);
            let by_area = 1.0 / beam.section(depth).area();
            [0, 1, 2].map(|ray| {
                let place = self.slicing.world(beam.rulings[ray].at(depth), depth);
                self.projector
                    .vertex(place, self.value(drawn, ray, by_area))
            })
        };
        let [left, right] = self.columns(drawn);
        if left >= right {
            return;
        }
        let [top, end] = band.rows();
        let mut canvas = Canvas {
            drawing: self,
            columns: [left, right],
            top,
            stencil: vec![0; (right - left) * (end - top) as usize],
            touched: Vec::new(),
            band,
        };
        let [first, last] = drawn.planes;
        let mut above = ring(first);
        canvas.face(above);
        for plane in first + 1..=last {
            let below = ring(plane);
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                let is_first = Self::is_before(drawn, i, j);
                let (a, b, c, d) = (above[i], above[j], below[i], below[j]);
                // From the lower numbered ray's upper end, so to say, to the other's lower end.
                if is_first {
                    canvas.face([b, a, d]);
                    canvas.face([a, c, d]);
                } else {
                    canvas.face([b, a, c]);
                    canvas.face([b, c, d]);
                }
            }
            above = below;
        }
        canvas.face([above[0], above[2], above[1]]);
        canvas.end(drawn);
    }

    /// An order of a beam's rays that neighbours agree on.
    fn is_before(drawn: &Drawn, i: usize, j: usize) -> bool {
        let [a, b] = [i, j].map(|ray| drawn.beam.rulings[ray].base);
        (a.x, a.y) < (b.x, b.y)
    }

    /// What pass 2 writes at a vertex: an intensity, or a scaled light vector.
    fn value(&self, drawn: &Drawn, ray: usize, by_area: f64) -> DVec3 {
        let shading = self.shading;
        let ruling = &drawn.beam.rulings[ray];
        let intensity = shading.within(shading.at_vertex(drawn.beam, ray, by_area));
        match shading.lit.settings.cosine {
            Cosine::Flat | Cosine::Exact => DVec3::new(intensity, 0.0, 0.0),
            Cosine::Vector => -self.slicing.direction(ruling.slope) * intensity,
        }
    }
}

/// A pixel in which a face was counted, and that face's value there.
struct Touched {
    column: u32,
    row: u32,
    value: DVec3,
}

/// A triangle of the film, as pixels see it.
struct FilmTriangle {
    corners: [FilmVertex; 3],
    places: [DVec2; 3],
    /// 1 if it turns to the eye, else -1.
    turn: f64,
    /// 1/w of each corner.
    inverse: [f64; 3],
}

impl FilmTriangle {
    /// `None` of one that is seen from its edge.
    fn new(corners: [FilmVertex; 3]) -> Option<Self> {
        let places = [0, 1, 2].map(|i| corners[i].at / corners[i].w);
        let twice_area = (places[1] - places[0]).perp_dot(places[2] - places[0]);
        (twice_area != 0.0 && twice_area.is_finite()).then(|| Self {
            corners,
            places,
            turn: twice_area.signum(),
            inverse: [0, 1, 2].map(|i| 1.0 / corners[i].w),
        })
    }

    /// Whether a place is in it.
    #[inline]
    fn holds(&self, at: DVec2) -> bool {
        let turn = self.turn;
        let [a, b, c] = [
            self.places[0] - at,
            self.places[1] - at,
            self.places[2] - at,
        ];
        owns(b.perp_dot(c) * turn, (c - b) * turn)
            && owns(c.perp_dot(a) * turn, (a - c) * turn)
            && owns(a.perp_dot(b) * turn, (b - a) * turn)
    }

    /// The corners' weights at a place, up to a factor: in perspective by 1/w. They are linear on the film.
    #[inline]
    fn weights(&self, at: DVec2) -> [f64; 3] {
        let turn = self.turn;
        let [a, b, c] = [
            self.places[0] - at,
            self.places[1] - at,
            self.places[2] - at,
        ];
        [
            b.perp_dot(c) * turn * self.inverse[0],
            c.perp_dot(a) * turn * self.inverse[1],
            a.perp_dot(b) * turn * self.inverse[2],
        ]
    }

    /// The sum of weights, and that of depths by weights.
    #[inline]
    fn depth(&self, at: DVec2) -> [f64; 2] {
        let [a, b, c] = self.weights(at);
        let [p, q, r] = &self.corners;
        [a + b + c, p.depth * a + q.depth * b + r.depth * c]
    }

    /// The value at a place.
    fn value(&self, at: DVec2) -> DVec3 {
        let [a, b, c] = self.weights(at);
        let [p, q, r] = &self.corners;
        (p.value * a + q.value * b + r.value * c) / (a + b + c)
    }

    /// The range of columns in which it may hold points of a row, and the part of it in which it certainly
    /// does.
    fn columns(&self, y: f64) -> Option<[f64; 4]> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let [a, b, c] = self.places;
        for (a, b) in [(a, b), (b, c), (c, a)] {
            if (a.y <= y) != (b.y <= y) || a.y == y {
                let t = if a.y == b.y {
                    0.0
                } else {
                    (y - a.y) / (b.y - a.y)
                };
                let x = a.x + (b.x - a.x) * t;
                low = low.min(x);
                high = high.max(x);
            }
        }
        // A pixel's width is far above the rounding of a crossing.
        (low <= high).then_some([low - 1.0, low + 1.0, high - 1.0, high + 1.0])
    }
}

/// A band with the beam that is being drawn, and the stencil buffer of the part that this may reach.
struct Canvas<'a, 'b> {
    drawing: &'a Drawing<'a>,
    band: &'a mut Band<'b, Pixel>,
    /// The first column of the buffer, and the first beyond it.
    columns: [usize; 2],
    /// The first row.
    top: i64,
    /// 0 where no face was counted. Else 1 and twice the number of such faces that turn to the eye, less
    /// those that turn away.
    stencil: Vec<i16>,
    /// Pixels in which a face was counted, each with the value of the first.
    touched: Vec<Touched>,
}

impl Canvas<'_, '_> {
    /// Pass 1 of a face, and what pass 2 would write.
    fn face(&mut self, corners: [FilmVertex; 3]) {
        let mut polygon = [corners[0]; 4];
        let mut count = 0;
        for i in 0..3 {
            let (from, to) = (&corners[i], &corners[(i + 1) % 3]);
            if from.depth >= 0.0 {
                polygon[count] = *from;
                count += 1;
            }
            if (from.depth >= 0.0) != (to.depth >= 0.0) {
                polygon[count] = from.cut(to);
                count += 1;
            }
        }
        for i in 2..count {
            self.triangle([polygon[0], polygon[i - 1], polygon[i]]);
        }
    }

    /// A triangle that is all beyond the near plane.
    fn triangle(&mut self, corners: [FilmVertex; 3]) {
        let Some(triangle) = FilmTriangle::new(corners) else {
            return;
        };
        let count = if triangle.turn > 0.0 { 1 } else { -1 };
        let (shift, [width, _]) = (self.drawing.at, self.drawing.size);
        let [top, end] = self.band.rows();
        let [a, b, c] = triangle.places;
        let (lowest, highest) = (
            a.y.min(b.y).min(c.y) - shift.y,
            a.y.max(b.y).max(c.y) - shift.y,
        );
        let first = lowest.ceil().max(top as f64) as i64;
        let last = highest.floor().min(end as f64 - 1.0) as i64;
        let is_pass = self.drawing.shading.lit.settings.depth_test == DepthTest::Pass;
        let mut fragments = 0;
        for row in first..=last {
            let y = row as f64 + shift.y;
            let Some([from, sure_from, sure_to, to]) = triangle.columns(y) else {
                continue;
            };
            let [left, right] = self.columns;
            // The next whole number, for numbers from 0 on.
            let up = |x: f64| x as usize + usize::from(x > (x as usize) as f64);
            let first = up((from - shift.x).max(left as f64));
            let end = right.min((to - shift.x + 1.0).max(0.0) as usize);
            if first >= end {
                continue;
            }
            let depths = &self.drawing.depths[row as usize * width..][first..end];
            let line = &mut self.stencil[(row - self.top) as usize * (right - left)..]
                [first - left..end - left];
            let start = DVec2::new(first as f64 + shift.x, y);
            let [mut sum, mut depth] = triangle.depth(start);
            let [next_sum, next_depth] = triangle.depth(start + DVec2::X);
            let (sum_step, depth_step) = (next_sum - sum, next_depth - depth);
            let mut x = start.x;
            for (place, (surface, stencil)) in depths.iter().zip(line).enumerate() {
                let is_in = (x >= sure_from && x <= sure_to) || triangle.holds(DVec2::new(x, y));
                fragments += u64::from(is_in);
                // Both are false without a surface, which is no number.
                let is_counted = if is_pass {
                    depth < surface * sum
                } else {
                    depth >= surface * sum
                };
                if is_in && is_counted {
                    if *stencil == 0 {
                        *stencil = 1;
                        self.touched.push(Touched {
                            column: (first + place) as u32,
                            row: row as u32,
                            value: triangle.value(DVec2::new(x, y)),
                        });
                    }
                    *stencil += 2 * count;
                }
                x += 1.0;
                sum += sum_step;
                depth += depth_step;
            }
        }
        // Both passes draw them.
        self.band.fragments += 2 * fragments;
    }

    /// Pass 2: adds the first face's value where the count is not zero.
    fn end(self, drawn: &Drawn) {
        let (shading, points) = (self.drawing.shading, self.drawing.points);
        let width = self.drawing.size[0];
        for Touched { column, row, value } in self.touched {
            let index = row as usize * width + column as usize;
            let (Some(pixel), Some(point)) = (
                self.band.texel(i64::from(column), i64::from(row)),
                &points[index],
            ) else {
                continue;
            };
            let [left, right] = self.columns;
            let line = (i64::from(row) - self.top) as usize * (right - left);
            if self.stencil[line + column as usize - left] != 1 {
                let mut work = ShadeWork::default();
                let factor = shading.factor_at(drawn.beam, point, &mut work);
                let is_full = match shading.lit.settings.cosine {
                    Cosine::Vector => pixel.sum.add_vector(shading.format, value * factor),
                    Cosine::Flat | Cosine::Exact => pixel.sum.add(shading.format, value.x * factor),
                };
                pixel.blends += 1;
                pixel.saturated += u32::from(is_full);
                pixel.rays[0] += work.shadow.rays as u32;
                pixel.rays[1] += work.occlusion.rays as u32;
            }
        }
    }
}
