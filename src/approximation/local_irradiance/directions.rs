//! Samples of light directions, and those that a frame blends: stage `directions` (sections 4.1, 5.1, 5.2).
//!
//! Directions are unit vectors from the object's centre to the light, along the object's own axes.

use glam::{DMat3, DVec3};

use super::lamp::least_rotation;
use super::settings::Settings;
use super::variants::{Axis, Directions, SampleAt, Symmetry};
use crate::geometry::Geodesic;
use crate::numeric::math;
use crate::numeric::rotation;
use crate::numeric::{harmonic_fit, spherical_harmonics};

/// The samples of light directions.
#[derive(Clone, Debug)]
pub struct Samples {
    all: Vec<DVec3>,
    lookup: Lookup,
}

#[derive(Clone, Debug)]
enum Lookup {
    /// Each direction is its own sample.
    Own,
    /// One sample serves all.
    Sphere,
    /// Samples by the angle to an axis, in a plane through it.
    Axis {
        axis: DVec3,
        across: DVec3,
        is_aligned: bool,
        is_nearest: bool,
    },
    Nearest,
    Three {
        geodesic: Box<Geodesic>,
        is_aligned: bool,
    },
    /// The fit of harmonics to the samples.
    Harmonics {
        fit: Vec<Vec<f64>>,
        order: usize,
    },
}

/// A sample's part in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blended {
    /// The sample.
    pub sample: usize,
    /// Its direction.
    pub towards: DVec3,
    /// Its weight.
    pub weight: f64,
    /// The rotation of places before they are looked up.
    pub turn: DMat3,
}

impl Samples {
    /// The number of light directions all round, without a symmetry.
    pub fn count(settings: &Settings) -> u32 {
        let f = settings.frequency;
        match settings.sample_at {
            SampleAt::Vertices => 10 * f * f + 2,
            SampleAt::Centres => 20 * f * f,
        }
    }

    /// The samples that settings ask for; `None` if harmonics are not determined by them.
    pub fn new(settings: &Settings) -> Option<Self> {
        let is_aligned = settings.directions == Directions::Aligned;
        if settings.directions == Directions::Exact {
            return Some(Self {
                all: Vec::new(),
                lookup: Lookup::Own,
            });
        }
        match settings.symmetry {
            Symmetry::Sphere => {
                return Some(Self {
                    all: vec![DVec3::Z],
                    lookup: Lookup::Sphere,
                });
            }
            Symmetry::Axis => {
                let (axis, across) = match settings.axis {
                    Axis::X => (DVec3::X, DVec3::Y),
                    Axis::Y => (DVec3::Y, DVec3::Z),
                    Axis::Z => (DVec3::Z, DVec3::X),
                };
                let steps = settings.axis_samples - 1;
                let along = |step: u32| {
                    let angle = std::f64::consts::PI * f64::from(step) / f64::from(steps);
                    axis * math::cos(angle) + across * math::sin(angle)
                };
                return Some(Self {
                    all: (0..=steps).map(along).collect(),
                    lookup: Lookup::Axis {
                        axis,
                        across,
                        is_aligned,
                        is_nearest: settings.directions == Directions::Nearest,
                    },
                });
            }
            Symmetry::None => {}
        }
        let geodesic = Geodesic::new(settings.frequency);
        let all = match settings.sample_at {
            SampleAt::Vertices => geodesic.vertices().to_vec(),
            SampleAt::Centres => (0..geodesic.triangles().len() as u32)
                .map(|triangle| geodesic.middle(triangle))
                .collect(),
        };
        let lookup = match settings.directions {
            Directions::Nearest | Directions::Exact => Lookup::Nearest,
            Directions::Aligned | Directions::Barycentric => Lookup::Three {
                geodesic: Box::new(geodesic),
                is_aligned,
            },
            Directions::Harmonics => {
                let order = settings.order as usize;
                Lookup::Harmonics {
                    fit: harmonic_fit(&all, order)?,
                    order,
                }
            }
        };
        Some(Self { all, lookup })
    }

    /// All of them; none if each direction is its own.
    pub fn all(&self) -> &[DVec3] {
        &self.all
    }

    /// The fit of harmonics to the samples, coefficient by coefficient, and their order.
    pub fn fit(&self) -> Option<(&[Vec<f64>], usize)> {
        match &self.lookup {
            Lookup::Harmonics { fit, order } => Some((fit, *order)),
            _ => None,
        }
    }

    fn one(&self, sample: usize, weight: f64, turn: DMat3) -> Blended {
        Blended {
            sample,
            towards: self.all[sample],
            weight,
            turn,
        }
    }

    /// The samples that a frame blends for a light, with their weights: these sum to 1 but for harmonics.
    pub fn blend(&self, towards: DVec3) -> Vec<Blended> {
        match &self.lookup {
            Lookup::Own => vec![Blended {
                sample: usize::MAX,
                towards,
                weight: 1.0,
                turn: DMat3::IDENTITY,
            }],
            Lookup::Sphere => {
                vec![self.one(0, 1.0, least_rotation(towards, self.all[0]))]
            }
            Lookup::Axis {
                axis,
                across,
                is_aligned,
                is_nearest,
            } => self.about_axis(towards, [*axis, *across], *is_aligned, *is_nearest),
            Lookup::Nearest => {
                let nearest = (0..self.all.len()).fold(0, |best, index| {
                    if self.all[index].dot(towards) > self.all[best].dot(towards) {
                        index
                    } else {
                        best
                    }
                });
                vec![self.one(nearest, 1.0, DMat3::IDENTITY)]
            }
            Lookup::Three {
                geodesic,
                is_aligned,
            } => {
                let place = geodesic.place(towards);
                let corners = geodesic.triangles()[place.triangle as usize];
                corners
                    .into_iter()
                    .zip(place.weights)
                    .filter(|(_, weight)| *weight > 0.0)
                    .map(|(corner, weight)| {
                        let sample = corner as usize;
                        let turn = if *is_aligned {
                            least_rotation(towards, self.all[sample])
                        } else {
                            DMat3::IDENTITY
                        };
                        self.one(sample, weight, turn)
                    })
                    .collect()
            }
            Lookup::Harmonics { fit, order } => {
                let row = spherical_harmonics(towards, *order);
                (0..self.all.len())
                    .map(|sample| {
                        let weight = row.iter().zip(fit).map(|(y, fit)| y * fit[sample]).sum();
                        self.one(sample, weight, DMat3::IDENTITY)
                    })
                    .collect()
            }
        }
    }

    fn about_axis(
        &self,
        towards: DVec3,
        [axis, across]: [DVec3; 2],
        is_aligned: bool,
        is_nearest: bool,
    ) -> Vec<Blended> {
        let flat = towards - axis * towards.dot(axis);
        let angle = math::atan2(flat.length(), towards.dot(axis));
        // About the axis into the plane of samples.
        let side = axis.cross(across);
        let turn = rotation::about(axis, -math::atan2(flat.dot(side), flat.dot(across)));
        let steps = (self.all.len() - 1) as f64;
        let place = angle / std::f64::consts::PI * steps;
        let low = place.floor().clamp(0.0, steps - 1.0);
        let part = (place - low).clamp(0.0, 1.0);
        let low = low as usize;
        if is_nearest {
            let sample = if part < 0.5 { low } else { low + 1 };
            return vec![self.one(sample, 1.0, turn)];
        }
        [(low, 1.0 - part), (low + 1, part)]
            .into_iter()
            .filter(|(_, weight)| *weight > 0.0)
            .map(|(sample, weight)| {
                let turn = if is_aligned {
                    least_rotation(turn * towards, self.all[sample]) * turn
                } else {
                    turn
                };
                self.one(sample, weight, turn)
            })
            .collect()
    }
}
