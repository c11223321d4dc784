//! Layers of a [`Bsdf`](super::Bsdf), and one layer as a path from one direction meets it.

use glam::DVec3;

use super::lobe::Lobe;
use super::turned::TurnedNormal;
use crate::geometry::Frame;

/// A lobe, and the texture that turns its normal, if any.
#[derive(Clone, Debug)]
pub(super) struct BsdfLayer<'a> {
    pub(super) lobe: Lobe<'a>,
    pub(super) turned: Option<TurnedNormal>,
}

/// A layer as a path from one direction meets it.
///
/// There are three frames. One is the shading frame. One is the same mirrored at the tangent plane, on the
/// back of a two-sided surface, as Mitsuba does. One is that of the lobe, whose normal a texture may have
/// turned.
pub(super) struct LayerView<'b, 'a> {
    pub layer: &'b BsdfLayer<'a>,
    is_mirrored: bool,
    turned: Option<(TurnedNormal, Frame)>,
    /// Direction of the path's start, in the lobe's frame.
    pub wi: DVec3,
}

/// The direction that a path goes on along, in three frames.
pub(super) struct Onward {
    /// The direction in the shading frame.
    pub unmirrored: DVec3,
    mirrored: DVec3,
    /// The direction in the lobe's frame.
    pub wo: DVec3,
}

impl<'b, 'a> LayerView<'b, 'a> {
    /// The layer that a path from `wi`, in the shading frame, meets.
    #[inline]
    pub fn new(front: &'b BsdfLayer<'a>, back: Option<&'b BsdfLayer<'a>>, wi: DVec3) -> Self {
        let (layer, is_mirrored) = match back {
            Some(back) if wi.z < 0.0 => (back, true),
            _ => (front, false),
        };
        let local = mirrored_if(is_mirrored, wi);
        let turned = layer.turned.map(|turned| (turned, turned.frame(local)));
        Self {
            layer,
            is_mirrored,
            turned,
            wi: turned.map_or(local, |(_, frame)| frame.to_local(local)),
        }
    }

    /// True if a texture turned the normal.
    pub fn is_turned(&self) -> bool {
        self.turned.is_some()
    }

    /// The direction in all frames, from the shading frame.
    ///
    /// `None` if the turned normal has it on its other side, to which no light goes.
    #[inline]
    pub fn to_lobe(&self, unmirrored: DVec3) -> Option<Onward> {
        let mirrored = mirrored_if(self.is_mirrored, unmirrored);
        let wo = match &self.turned {
            Some((_, frame)) => frame.to_local(mirrored),
            None => mirrored,
        };
        self.checked(unmirrored, mirrored, wo)
    }

    /// The direction in all frames, from the lobe's frame; `None` as for [`Self::to_lobe`].
    #[inline]
    pub fn leave_lobe(&self, wo: DVec3) -> Option<Onward> {
        let mirrored = match &self.turned {
            Some((_, frame)) => frame.to_world(wo),
            None => wo,
        };
        self.checked(mirrored_if(self.is_mirrored, mirrored), mirrored, wo)
    }

    #[inline]
    fn checked(&self, unmirrored: DVec3, mirrored: DVec3, wo: DVec3) -> Option<Onward> {
        (self.turned.is_none() || mirrored.z * wo.z > 0.0).then_some(Onward {
            unmirrored,
            mirrored,
            wo,
        })
    }

    /// The share of light that the bumps of the texture do not shadow.
    #[inline]
    pub fn shadowing(&self, to: &Onward) -> f64 {
        match &self.turned {
            Some((turned, _)) => turned.shadowing(to.mirrored),
            None => 1.0,
        }
    }

    /// [`Self::shadowing`] of a direction in the shading frame.
    pub fn shadowing_of(&self, unmirrored: DVec3) -> f64 {
        self.to_lobe(unmirrored)
            .map_or(0.0, |to| self.shadowing(&to))
    }
}

/// The direction, mirrored at the tangent plane if asked for.
#[inline]
fn mirrored_if(is_mirrored: bool, local: DVec3) -> DVec3 {
    if is_mirrored {
        DVec3::new(local.x, local.y, -local.z)
    } else {
        local
    }
}
