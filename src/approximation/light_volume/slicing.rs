//! Parallel planes across an axis, and coordinates along and across it.

use glam::{DVec2, DVec3};

use crate::geometry::{Bounds, Frame};

/// Parallel planes, equally spaced along an axis from the water's top to the lowest receiver.
///
/// A place has a *depth* \[m\], from the top plane down, and coordinates \[m\] across the axis.
#[derive(Clone, Copy, Debug)]
pub struct Slicing {
    /// Its normal is the axis, upwards.
    frame: Frame,
    /// The top plane's height along the axis.
    top: f64,
    /// The distance of the lowest plane from the top one.
    bottom: f64,
    slices: u32,
}

/// A coordinate axis is taken instead of an axis less than acos 0.98, or 11 degrees, away from it.
const NEAR: f64 = 0.98;

/// The share of the whole depth that the lowest plane is below the lowest receiver, so that no receiver is
/// lost by rounding.
const MARGIN: f64 = 1e-9;

impl Slicing {
    /// The planes across `axis` (a unit vector) from `top` down to below `receivers`.
    ///
    /// `None` if no receiver reaches below `top`.
    pub fn new(axis: DVec3, water: &[DVec3], receivers: &[Bounds], slices: u32) -> Option<Self> {
        let frame = frame(axis);
        let top = water
            .iter()
            .map(|place| place.dot(axis))
            .fold(f64::NEG_INFINITY, f64::max);
        let corners = receivers.iter().flat_map(Bounds::corners);
        let lowest = corners
            .map(|place| place.dot(axis))
            .fold(f64::INFINITY, f64::min);
        let bottom = (top - lowest) * (1.0 + MARGIN);
        (bottom > 0.0 && bottom.is_finite()).then_some(Self {
            frame,
            top,
            bottom,
            slices,
        })
    }

    /// The axis, upwards.
    pub fn axis(&self) -> DVec3 {
        self.frame.n
    }

    /// Where a place is across the axis, and its depth.
    #[inline]
    pub fn local(&self, place: DVec3) -> (DVec2, f64) {
        let local = self.frame.to_local(place);
        (local.truncate(), self.top - local.z)
    }

    /// The place with these coordinates.
    #[inline]
    pub fn world(&self, across: DVec2, depth: f64) -> DVec3 {
        self.frame.to_world(across.extend(self.top - depth))
    }

    /// A vector's parts across the axis, and downwards.
    #[inline]
    pub fn local_vector(&self, vector: DVec3) -> (DVec2, f64) {
        let local = self.frame.to_local(vector);
        (local.truncate(), -local.z)
    }

    /// The unit vector that goes down with a slope \[m/m\].
    #[inline]
    pub fn direction(&self, slope: DVec2) -> DVec3 {
        self.frame.to_world(slope.extend(-1.0)).normalize()
    }

    /// Number of slices.
    pub fn slices(&self) -> u32 {
        self.slices
    }

    /// The depth of the lowest plane \[m\].
    pub fn bottom(&self) -> f64 {
        self.bottom
    }

    /// The depth of a plane \[m\]: 0 of the top one, and the bottom of plane number [`slices`](Self::slices).
    #[inline]
    pub fn plane(&self, index: u32) -> f64 {
        if index == self.slices {
            self.bottom
        } else {
            self.bottom * (f64::from(index) / f64::from(self.slices))
        }
    }

    /// The slice that a depth is in, by its upper plane, and the fraction of the way to its lower one.
    #[inline]
    pub fn slice(&self, depth: f64) -> (u32, f64) {
        let slices = f64::from(self.slices);
        let place = (depth / self.bottom * slices).clamp(0.0, slices);
        let index = place.floor().min(slices - 1.0);
        (index as u32, place - index)
    }

    /// The planes that enclose a range of depths: the first and the last.
    pub fn planes_around(&self, [low, high]: [f64; 2]) -> [u32; 2] {
        let slices = f64::from(self.slices);
        let first = (low / self.bottom * slices)
            .floor()
            .clamp(0.0, slices - 1.0);
        let last = (high / self.bottom * slices)
            .ceil()
            .clamp(first + 1.0, slices);
        [first as u32, last as u32]
    }

    /// A box around bounds in local coordinates: two corners across the axis, and two depths.
    pub fn local_box(&self, bounds: &Bounds) -> LocalBox {
        let mut local = LocalBox::EMPTY;
        for corner in bounds.corners() {
            local.extend(self.local(corner));
        }
        local
    }
}

/// A box along the coordinates of a [`Slicing`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalBox {
    /// The least and the largest coordinates across the axis.
    pub across: Rectangle,
    /// The least and the largest depth.
    pub depths: [f64; 2],
}

impl LocalBox {
    /// Nothing.
    pub const EMPTY: Self = Self {
        across: [DVec2::INFINITY, DVec2::NEG_INFINITY],
        depths: [f64::INFINITY, f64::NEG_INFINITY],
    };

    /// Takes in a place.
    #[inline]
    pub fn extend(&mut self, (across, depth): (DVec2, f64)) {
        self.across = [self.across[0].min(across), self.across[1].max(across)];
        self.depths = [self.depths[0].min(depth), self.depths[1].max(depth)];
    }
}

/// Coordinates across an axis, and along it.
pub fn frame(axis: DVec3) -> Frame {
    let along = if axis.x.abs() < 0.9 {
        DVec3::X
    } else {
        DVec3::Y
    };
    Frame::along(axis, along)
}

/// A rectangle across an axis: its least and its largest coordinates.
pub type Rectangle = [DVec2; 2];

/// The rectangle around both.
#[inline]
pub fn join(a: Rectangle, b: Rectangle) -> Rectangle {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// True if two rectangles have a point in common.
#[inline]
pub fn overlap(a: Rectangle, b: Rectangle) -> bool {
    a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all()
}

/// The axis to cut across for a surface with this mean normal: a coordinate axis if one is near.
pub fn snapped(normal: DVec3) -> DVec3 {
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let along = normal.dot(axis);
        if along.abs() > NEAR {
            return axis * along.signum();
        }
    }
    normal
}
