//! Texels that see all of a delta emitter, or nothing of it, without a ray for each.
//!
//! A shaft is all the space between an emitter and a square of texels on a flat receiver. Visibility can
//! differ within it only if something of these is in it:
//!
//! - an edge of a mesh's [silhouette](crate::geometry::Mesh::silhouette), or of a rectangle;
//! - a face that touches the receiver;
//! - a part of a ball or disc, but not all of the shaft's cross section: these are convex, so that they hide
//!   all of a square if they hide its four corners;
//! - a tube's rim, or one of the two lines on it at which the emitter's rays graze it (`tube.rs`);
//! - a tube that leans into the receiver, or a mask.
//!
//! If there is none, one ray tells for all of the square. Otherwise its quarters are asked, down to texels
//! and on to parts of them (`divided.rs`). Shafts were introduced for this by Haines and Wallace, "Shaft
//! culling for efficient ray-traced radiosity" (1991).

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::arriving::ends_in_a_step;
use super::edge::CORNERS;
use super::shaft::{Obstacle, Origin, Shaft, WITHIN};
use crate::geometry::{Bounds, Shape, Sphere, TraversalCounters};
use crate::scene::{Emitter, Material, Scene};
use crate::transport::receiver::Receiver;
use crate::transport::visibility::transmittance;

/// Texels a side of the squares to begin with.
const SQUARE: usize = 64;

/// Distance from the receiver's plane, relative to coordinates, at which a face counts as touching it.
pub(super) const TOUCHING: f64 = 1e-9;

/// Most lines that are kept for a texel. One with more is looked at by points alone.
const MOST_LINES: usize = 64;

/// The points of a texel, as an emitter sees them.
pub(super) enum TexelView<'a> {
    /// All see this share of it.
    Same(f64),
    /// They may see different shares, because of these lines.
    Divided(&'a [Obstacle]),
    /// They may see different shares, because of many lines, or of something whose shadow has no known
    /// outline.
    Unknown,
}

/// The views of all texels.
pub(super) struct Views {
    /// Shares by texel, row by row; no number where they may differ.
    shares: Vec<f64>,
    /// The lines of those that lines divide.
    lines: BTreeMap<usize, Vec<Obstacle>>,
}

impl Views {
    /// The view of a texel.
    pub(super) fn of(&self, texel: usize) -> TexelView<'_> {
        let share = self.shares[texel];
        match self.lines.get(&texel) {
            _ if !share.is_nan() => TexelView::Same(share),
            Some(lines) => TexelView::Divided(lines),
            None => TexelView::Unknown,
        }
    }
}

/// An emitter's visibility from the texels of a flat receiver.
pub(super) struct Shafts<'a> {
    pub(super) scene: &'a Scene,
    pub(super) receiver: &'a Receiver,
    pub(super) origin: Origin,
    pub(super) normal: DVec3,
    /// Largest coordinate of the scene and the emitter.
    reach: f64,
}

/// What was found of a part of the film, and the work that it took.
#[derive(Default)]
struct Found {
    /// First columns and rows, last ones and one more, and the share that all of these texels see.
    same: Vec<([usize; 2], [usize; 2], f64)>,
    lines: Vec<(usize, Vec<Obstacle>)>,
    counters: TraversalCounters,
}

impl<'a> Shafts<'a> {
    /// The shafts of an emitter without size. `None` for others, and if the receiver is not a rectangle or
    /// shows the emitter its back.
    pub(super) fn new(scene: &'a Scene, receiver: &'a Receiver, emitter: &Emitter) -> Option<Self> {
        let shape = &scene.world().shapes()[receiver.shape() as usize];
        let (Shape::Rectangle(floor), Some(origin)) = (shape, Origin::of(emitter)) else {
            return None;
        };
        if ends_in_a_step(emitter) {
            return None;
        }
        let normal = floor.normal();
        let is_front = normal.dot(origin.from(floor.center())) > 0.0;
        let Bounds { min, max } = scene.world().bounds();
        let position = match origin {
            Origin::At(position) => position,
            Origin::Towards(_) => DVec3::ZERO,
        };
        let reach = min.abs().max(max.abs()).max(position.abs()).max_element();
        is_front.then_some(Self {
            scene,
            receiver,
            origin,
            normal,
            reach,
        })
    }

    /// The views of all texels, row by row.
    pub(super) fn views(
        &self,
        stop: &(dyn Fn() -> bool + Sync),
        counters: &mut TraversalCounters,
    ) -> Views {
        let obstacles = self.obstacles();
        let side = |texels: usize| texels.div_ceil(SQUARE);
        let (width, across) = (self.receiver.width(), side(self.receiver.width()));
        let squares: Vec<Found> = (0..across * side(self.receiver.height()))
            .into_par_iter()
            .map(|index| {
                let from = [index % across * SQUARE, index / across * SQUARE];
                let mut found = Found::default();
                // What is left out then is thrown away with the rest.
                if !stop() {
                    self.divide(from, SQUARE, &obstacles, &mut found);
                }
                found
            })
            .collect();
        let mut views = Views {
            shares: vec![f64::NAN; self.receiver.texels()],
            lines: BTreeMap::new(),
        };
        for found in squares {
            *counters += found.counters;
            for (from, end, share) in found.same {
                for row in from[1]..end[1] {
                    views.shares[row * width + from[0]..row * width + end[0]].fill(share);
                }
            }
            views.lines.extend(found.lines);
        }
        views
    }

    /// Those of some obstacles that visibility may differ by within a square, given its corners in order.
    pub(super) fn dividing(&self, corners: [DVec3; 4], obstacles: &[Obstacle]) -> Vec<Obstacle> {
        Shaft::new(self.origin, corners, self.normal, self.reach).dividing(obstacles)
    }

    /// Everything that may hide the emitter from some places only.
    fn obstacles(&self) -> Vec<Obstacle> {
        let (scene, world) = (self.scene, self.scene.world());
        let mut obstacles = Vec::new();
        for (index, shape) in world.shapes().iter().enumerate() {
            let material = scene.material_of(index as u32);
            if index as u32 == self.receiver.shape() {
                continue;
            }
            if matches!(material, Material::Mask { .. }) {
                obstacles.push(Obstacle::Box(shape.bounds()));
                continue;
            }
            if material.is_passed(scene.materials()) {
                continue;
            }
            match shape {
                // A ball round the emitter hides it from all places outside.
                Shape::Sphere(ball) if self.is_within(ball) => {}
                Shape::Sphere(ball) => {
                    obstacles.push(Obstacle::Ball(ball.center(), ball.radius()));
                }
                Shape::Rectangle(plate) => {
                    let [a, b, c, d] = CORNERS.map(|uv| plate.point(uv));
                    obstacles.extend([[a, b], [b, c], [c, d], [d, a]].map(Obstacle::Edge));
                    obstacles.extend(
                        self.touching([a, b, c])
                            .into_iter()
                            .chain(self.touching([c, d, a])),
                    );
                }
                Shape::Disk(plate) => {
                    obstacles.push(Obstacle::Disk(plate.center(), plate.half_axes()));
                }
                Shape::Cylinder(tube) => obstacles.extend(self.of_tube(tube, shape.bounds())),
                Shape::Mesh(mesh) => {
                    let outline = mesh.silhouette(|corners| self.origin.facing(corners));
                    obstacles.extend(outline.into_iter().map(Obstacle::Edge));
                    let faces = 0..mesh.triangle_count() as u32;
                    obstacles.extend(faces.filter_map(|face| self.touching(mesh.corners(face))));
                }
            }
        }
        // The rim of a tube that a disc closes is the disc's.
        let is_disc = |it: &&Obstacle| matches!(it, Obstacle::Disk(..));
        let discs: Vec<Obstacle> = obstacles.iter().filter(is_disc).copied().collect();
        obstacles.retain(|it| !discs.iter().any(|disc| it.is_rim_of(disc)));
        obstacles
    }

    /// True if the emitter is in a ball that does not reach the receiver's plane.
    fn is_within(&self, ball: &Sphere) -> bool {
        let Origin::At(position) = self.origin else {
            return false;
        };
        let floor = &self.scene.world().shapes()[self.receiver.shape() as usize];
        let inside = ball.radius() * (1.0 - WITHIN);
        let outside = ball.radius() * (1.0 + WITHIN);
        position.distance(ball.center()) < inside
            && floor
                .plane()
                .is_some_and(|[center, _]| self.normal.dot(ball.center() - center) > outside)
    }

    /// A face as an obstacle if it touches the receiver's plane: then its shadow ends there, too.
    fn touching(&self, corners: [DVec3; 3]) -> Option<Obstacle> {
        let floor = &self.scene.world().shapes()[self.receiver.shape() as usize];
        let [center, _] = floor.plane()?;
        let heights = corners.map(|corner| self.normal.dot(corner - center));
        let near = corners.map(|corner| TOUCHING * (corner.length() + center.length()));
        let is_above = (0..3).all(|i| heights[i] > near[i]);
        let is_below = (0..3).all(|i| heights[i] < -near[i]);
        (!is_above && !is_below).then_some(Obstacle::Face(corners))
    }

    /// Finds the views of a square's texels.
    fn divide(&self, from: [usize; 2], size: usize, obstacles: &[Obstacle], found: &mut Found) {
        let (width, height) = (self.receiver.width(), self.receiver.height());
        let end = [(from[0] + size).min(width), (from[1] + size).min(height)];
        if from[0] >= end[0] || from[1] >= end[1] {
            return;
        }
        let first = from[1] * width + from[0];
        let reach = DVec2::new((end[0] - from[0]) as f64, (end[1] - from[1]) as f64);
        let at = |part: DVec2| self.receiver.point(self.scene, first, part * reach);
        let corners = CORNERS.map(at);
        let ([Some(a), Some(b), Some(c), Some(d)], Some(middle)) = (corners, at(DVec2::splat(0.5)))
        else {
            return;
        };
        let within = self.dividing([a, b, c, d].map(|point| point.position), obstacles);
        if within.is_empty() {
            let way = self.origin.from(middle.position);
            let distance = match self.origin {
                Origin::At(_) => way.length(),
                Origin::Towards(_) => f64::INFINITY,
            };
            let towards = way.normalize();
            let share = transmittance(self.scene, &middle, towards, distance, &mut found.counters);
            found.same.push((from, end, share));
        } else if size > 1 {
            let half = size / 2;
            for (x, y) in [(0, 0), (half, 0), (0, half), (half, half)] {
                self.divide([from[0] + x, from[1] + y], half, &within, found);
            }
        } else if within.len() <= MOST_LINES && within.iter().all(Obstacle::is_simple) {
            found.lines.push((first, within));
        }
    }
}
