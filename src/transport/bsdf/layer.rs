//! Layers of a [`Bsdf`](super::Bsdf), and one layer as a path from one direction meets it.

use glam::DVec3;

use super::lobe::Lobe;
use super::turned::TurnedNormal;
use crate::geometry::Frame;
use crate::radiometry::Rgb;

/// A lobe, and the texture that turns its normal, if any.
#[derive(Clone, Debug)]
pub(super) struct BsdfLayer<'a> {
    pub lobe: Lobe<'a>,
    pub turned: Option<TurnedNormal>,
    /// True on the back of a two-sided material, whose frame is mirrored at the tangent plane.
    pub is_mirrored: bool,
    /// Its share (0..=1) of a blend; 1 without one.
    pub weight: f64,
}

/// What light meets on one side of a surface.
#[derive(Clone, Debug)]
pub(super) enum LayerList<'a> {
    /// One material.
    One(BsdfLayer<'a>),
    /// The parts of a blend: weights add up to 1.
    Blend(Vec<BsdfLayer<'a>>),
}

impl<'a> LayerList<'a> {
    /// The layers, side by side.
    #[inline]
    pub fn all(&self) -> &[BsdfLayer<'a>] {
        match self {
            Self::One(layer) => std::slice::from_ref(layer),
            Self::Blend(layers) => layers,
        }
    }

    /// The one layer; `None` of a blend.
    #[inline]
    pub fn one(&self) -> Option<&BsdfLayer<'a>> {
        match self {
            Self::One(layer) => Some(layer),
            Self::Blend(_) => None,
        }
    }

    /// True if no direction has a density.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.all().iter().all(|layer| layer.lobe.is_delta())
    }

    /// Makes the bases below rough coats black.
    pub fn remove_bases(&mut self) {
        let layers = match self {
            Self::One(layer) => std::slice::from_mut(layer),
            Self::Blend(layers) => layers,
        };
        for layer in layers {
            if let Lobe::RoughPlastic(plastic) = &mut layer.lobe {
                plastic.base.diffuse_reflectance = Rgb::BLACK;
            }
        }
    }

    /// The layer in whose share a number in [0, 1) lies, and the place in that share, in [0, 1).
    pub fn choose(&self, choice: f64) -> (&BsdfLayer<'a>, f64) {
        /// The largest number below 1.
        const BELOW_ONE: f64 = 1.0f64.next_down();
        let layers = match self {
            Self::One(layer) => return (layer, choice),
            Self::Blend(layers) => layers,
        };
        let mut rest = choice;
        let last = layers.len() - 1;
        for layer in &layers[..last] {
            if rest < layer.weight {
                return (layer, (rest / layer.weight).min(BELOW_ONE));
            }
            rest -= layer.weight;
        }
        // Weights add up to 1 but for rounding.
        let last = &layers[last];
        (last, (rest / last.weight).clamp(0.0, BELOW_ONE))
    }
}

/// A layer as a path from one direction meets it.
///
/// There are three frames. One is the shading frame. One is the same mirrored at the tangent plane, on the
/// back of a two-sided surface, as Mitsuba does. One is that of the lobe, whose normal a texture may have
/// turned.
pub(super) struct LayerView<'b, 'a> {
    pub layer: &'b BsdfLayer<'a>,
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
    /// The layer as a path from `wi`, in the shading frame, meets it.
    #[inline]
    pub fn new(layer: &'b BsdfLayer<'a>, wi: DVec3) -> Self {
        let local = mirrored_if(layer.is_mirrored, wi);
        let turned = layer.turned.map(|turned| (turned, turned.frame(local)));
        Self {
            layer,
            turned,
            wi: turned.map_or(local, |(_, frame)| frame.to_local(local)),
        }
    }

    /// f |cos θ| towards `wo`, in the shading frame, by a share of the layer.
    #[inline]
    pub fn eval(&self, wo: DVec3, share: f64) -> Rgb {
        self.to_lobe(wo).map_or(Rgb::BLACK, |to| {
            self.layer.lobe.eval(self.wi, to.wo) * (self.shadowing(&to) * share)
        })
    }

    /// The density of `wo`, in the shading frame, by a share of the layer.
    #[inline]
    pub fn pdf(&self, wo: DVec3, share: f64) -> f64 {
        self.to_lobe(wo)
            .map_or(0.0, |to| self.layer.lobe.pdf(self.wi, to.wo) * share)
    }

    /// The direction in all frames, from the shading frame.
    ///
    /// `None` if the turned normal has it on its other side, to which no light goes.
    #[inline]
    pub fn to_lobe(&self, unmirrored: DVec3) -> Option<Onward> {
        let mirrored = mirrored_if(self.layer.is_mirrored, unmirrored);
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
        self.checked(mirrored_if(self.layer.is_mirrored, mirrored), mirrored, wo)
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
