//! The volume (section 3.1): an oriented cuboid, its faces and its slabs.

use glam::{DVec2, DVec3};

use crate::geometry::{Bounds, Frame, Ray};
use crate::setting::words::words;

words! {
    /// A face of a volume, as light meets it.
    Face {
        /// Where photons enter
        Entry = "entry",
        /// Opposite
        Far = "far",
        /// Beside, against the first axis across
        FirstLow = "first side",
        /// Beside, along the first axis across
        FirstHigh = "second side",
        /// Beside, against the second axis across
        SecondLow = "third side",
        /// Beside, along the second axis across
        SecondHigh = "fourth side",
    }
}

impl Face {
    /// All faces.
    pub const ALL: [Self; 6] = [
        Self::Entry,
        Self::Far,
        Self::FirstLow,
        Self::FirstHigh,
        Self::SecondLow,
        Self::SecondHigh,
    ];

    /// The outward normal in local coordinates.
    pub fn outward(self) -> DVec3 {
        match self {
            Self::Entry => DVec3::NEG_Z,
            Self::Far => DVec3::Z,
            Self::FirstLow => DVec3::NEG_X,
            Self::FirstHigh => DVec3::X,
            Self::SecondLow => DVec3::NEG_Y,
            Self::SecondHigh => DVec3::Y,
        }
    }

    /// The face of which a direction from the middle passes, that of a cube.
    pub fn along(local: DVec3) -> Self {
        let a = local.abs();
        if a.z >= a.x && a.z >= a.y {
            if local.z < 0.0 {
                Self::Entry
            } else {
                Self::Far
            }
        } else if a.x >= a.y {
            if local.x < 0.0 {
                Self::FirstLow
            } else {
                Self::FirstHigh
            }
        } else if local.y < 0.0 {
            Self::SecondLow
        } else {
            Self::SecondHigh
        }
    }
}

/// An oriented cuboid. Local coordinates begin in the middle of its entry face: x and y across, z inwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// The axes by which faces are named.
    axes: Frame,
    /// Its normal is into the volume.
    frame: Frame,
    /// The middle of the entry face.
    origin: DVec3,
    /// Half its sides along x and y, and all of that along z.
    size: DVec3,
}

impl Cuboid {
    /// A cuboid from its middle, its half sides along the axes of a frame, and the entry face's outward
    /// direction, which is an axis of that frame or its opposite.
    pub fn new(middle: DVec3, axes: &Frame, half: DVec3, outward: DVec3) -> Self {
        let n = -outward;
        let all = [(axes.s, half.x), (axes.t, half.y), (axes.n, half.z)];
        let is_across = |(axis, _): &(DVec3, f64)| axis.dot(n).abs() < 0.5;
        let mut across = all.into_iter().filter(is_across);
        let first = across.next().unwrap_or(all[0]);
        let second = across.next().unwrap_or(all[1]);
        let depth: f64 = all
            .iter()
            .map(|(axis, half)| 2.0 * half * axis.dot(n).abs().round())
            .sum();
        Self {
            axes: *axes,
            frame: Frame {
                s: first.0,
                t: n.cross(first.0),
                n,
            },
            origin: middle - n * (0.5 * depth),
            size: DVec3::new(first.1, second.1, depth),
        }
    }

    /// The frame of local coordinates.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The name of a face by the axes that the volume was made with.
    pub fn name(&self, face: Face) -> &'static str {
        const NAMES: [[&str; 2]; 3] = [["x-", "x+"], ["y-", "y+"], ["z-", "z+"]];
        let along = self.axes.to_local(self.outward(face));
        let axis = along.abs().max_position();
        NAMES[axis][usize::from(along[axis] > 0.0)]
    }

    /// Half the sides across, and the depth \[m\].
    pub fn size(&self) -> DVec3 {
        self.size
    }

    /// The length of a diagonal \[m\].
    pub fn diagonal(&self) -> f64 {
        DVec3::new(2.0 * self.size.x, 2.0 * self.size.y, self.size.z).length()
    }

    /// Local coordinates of a point.
    #[inline]
    pub fn to_local(&self, point: DVec3) -> DVec3 {
        self.frame.to_local(point - self.origin)
    }

    /// The point with some local coordinates.
    #[inline]
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        self.origin + self.frame.to_world(local)
    }

    /// The middle of the volume.
    pub fn middle(&self) -> DVec3 {
        self.origin + self.frame.n * (0.5 * self.size.z)
    }

    /// The middle of a face, local.
    pub fn face_middle(&self, face: Face) -> DVec3 {
        let half = DVec3::new(self.size.x, self.size.y, 0.5 * self.size.z);
        DVec3::Z * half.z + face.outward() * half
    }

    /// Two directions along a face, with half its sides along them, local.
    pub fn face_axes(face: Face, size: DVec3) -> [(DVec3, f64); 2] {
        let (x, y) = ((DVec3::X, size.x), (DVec3::Y, size.y));
        let z = (DVec3::Z, 0.5 * size.z);
        match face {
            Face::Entry | Face::Far => [x, y],
            Face::FirstLow | Face::FirstHigh => [y, z],
            Face::SecondLow | Face::SecondHigh => [x, z],
        }
    }

    /// The point of a face at fractions across it.
    pub fn face_point(&self, face: Face, at: DVec2) -> DVec3 {
        let [(a, half_a), (b, half_b)] = Self::face_axes(face, self.size);
        let local = self.face_middle(face)
            + a * (half_a * (2.0 * at.x - 1.0))
            + b * (half_b * (2.0 * at.y - 1.0));
        self.to_world(local)
    }

    /// The outward unit normal of a face.
    pub fn outward(&self, face: Face) -> DVec3 {
        self.frame.to_world(face.outward())
    }

    /// The corners.
    pub fn corners(&self) -> [DVec3; 8] {
        let low = DVec3::new(-self.size.x, -self.size.y, 0.0);
        let local = Bounds {
            min: low,
            max: self.size,
        };
        local.corners().map(|corner| self.to_world(corner))
    }

    /// True if a box is wholly inside.
    pub fn holds(&self, bounds: &Bounds) -> bool {
        let low = DVec3::new(-self.size.x, -self.size.y, 0.0);
        let local = bounds.corners().map(|corner| self.to_local(corner));
        local
            .iter()
            .all(|it| it.cmpge(low).all() && it.cmple(self.size).all())
    }

    /// The depths \[m\] between which a slab is.
    pub fn slab(&self, slab: usize, slabs: usize) -> [f64; 2] {
        [slab, slab + 1].map(|border| self.size.z * border as f64 / slabs as f64)
    }

    /// The slab at a depth.
    pub fn slab_at(&self, depth: f64, slabs: usize) -> usize {
        let slab = (depth / self.size.z * slabs as f64).floor();
        // Places on the borders may be beside them by rounding.
        (slab.max(0.0) as usize).min(slabs - 1)
    }

    /// Where a ray leaves the part of the volume between two depths, and by which face. The ray begins
    /// inside; `Entry` and `Far` are the faces of that part.
    #[inline]
    pub fn leaves(&self, ray: &Ray, [from, to]: [f64; 2]) -> (f64, Face) {
        let (p, d) = (
            self.to_local(ray.origin),
            self.frame.to_local(ray.direction),
        );
        let one = |place: f64, along: f64, low: f64, high: f64, faces: [Face; 2]| {
            if along > 0.0 {
                (((high - place) / along).max(0.0), faces[1])
            } else if along < 0.0 {
                (((low - place) / along).max(0.0), faces[0])
            } else {
                (f64::INFINITY, faces[1])
            }
        };
        let z = one(p.z, d.z, from, to, [Face::Entry, Face::Far]);
        let x = one(
            p.x,
            d.x,
            -self.size.x,
            self.size.x,
            [Face::FirstLow, Face::FirstHigh],
        );
        let y = one(
            p.y,
            d.y,
            -self.size.y,
            self.size.y,
            [Face::SecondLow, Face::SecondHigh],
        );
        [z, x, y]
            .into_iter()
            .fold(z, |best, next| if next.0 < best.0 { next } else { best })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume() -> Cuboid {
        let turned = Frame::along(DVec3::new(0.3, 0.2, 0.9).normalize(), DVec3::X);
        let half = DVec3::new(1.0, 2.0, 3.0);
        Cuboid::new(DVec3::new(4.0, 5.0, 6.0), &turned, half, turned.t)
    }

    #[test]
    fn local_coordinates_begin_in_the_middle_of_the_entry_face() {
        let volume = volume();
        assert_eq!(volume.size(), DVec3::new(1.0, 3.0, 4.0));
        let middle = volume.to_local(DVec3::new(4.0, 5.0, 6.0));
        assert!(middle.abs_diff_eq(DVec3::new(0.0, 0.0, 2.0), 1e-14));
        for face in Face::ALL {
            let point = volume.face_point(face, DVec2::new(0.5, 0.5));
            let outward = volume.outward(face);
            // A ray from the middle through a face leaves by that face.
            let ray = Ray::new(volume.middle(), outward);
            let (distance, found) = volume.leaves(&ray, [0.0, 4.0]);
            assert_eq!(found, face);
            assert!(ray.at(distance).abs_diff_eq(point, 1e-14));
        }
    }
}
