//! The light of legs in cells: stages `deposit` and, if it is exact, `normal`.

use super::cells::Cells;
use super::leg::{Crossed, Leg};
use super::reads::Reads;
use super::shoot::{Deposits, TracedLeg};
use super::variants::Deposit;
use super::work::Work;
use crate::numeric::FixedPoint;
use crate::numeric::math;
use crate::run::Error;
use crate::transport::flux::Flux;

/// Sums of light that no order changes: whole numbers of a quantum.
#[derive(Clone, Debug)]
pub struct Sums<const N: usize> {
    scale: FixedPoint,
    quanta: Vec<[i64; N]>,
    has_overflowed: bool,
}

impl<const N: usize> Sums<N> {
    /// Sums of magnitudes up to `largest`, kept to 2⁻⁶⁰ of it.
    pub fn new(len: usize, largest: f64) -> Self {
        let scale = FixedPoint::for_total(largest);
        Self {
            has_overflowed: scale.is_err(),
            scale: scale.unwrap_or(FixedPoint::OF_ONE),
            quanta: vec![[0; N]; len],
        }
    }

    /// Adds to one of them.
    #[inline]
    pub fn add(&mut self, index: usize, value: Flux<N>) {
        for (sum, value) in self.quanta[index].iter_mut().zip(value.0) {
            let next = self
                .scale
                .quantise(value)
                .and_then(|quanta| sum.checked_add(quanta));
            match next {
                Some(next) => *sum = next,
                None => self.has_overflowed = true,
            }
        }
    }

    /// The sums of all threads.
    ///
    /// # Errors
    ///
    /// If one does not fit.
    pub fn total(parts: Vec<Self>, len: usize) -> Result<Vec<[f64; 3]>, Error> {
        let mut parts = parts.into_iter();
        let Some(mut first) = parts.next() else {
            return Ok(vec![[0.0; 3]; len]);
        };
        for part in parts {
            first.has_overflowed |= part.has_overflowed;
            for (sum, one) in first.quanta.iter_mut().zip(part.quanta) {
                for (sum, one) in sum.iter_mut().zip(one) {
                    match sum.checked_add(one) {
                        Some(next) => *sum = next,
                        None => first.has_overflowed = true,
                    }
                }
            }
        }
        if first.has_overflowed {
            return Err(Error::NotRepresentable(
                "the light in one cell is beyond what can be summed: it is infinite, or not a number".to_owned(),
            ));
        }
        let scale = first.scale;
        Ok(first
            .quanta
            .iter()
            .map(|sum| Flux::<N>(sum.map(|quanta| scale.value_i64(quanta))).rgb().0)
            .collect())
    }
}

/// The rule by which a leg's light counts in a cell.
#[derive(Clone, Debug)]
pub struct Rule<'a> {
    /// The cells.
    pub cells: &'a Cells,
    /// The stage's variant.
    pub deposit: Deposit,
    /// By how much \[m\] legs go on after surfaces that stop them.
    pub beyond: f64,
}

impl Rule<'_> {
    /// Calls `visit(part, density)` for each cell that has light of a leg: density is irradiance by flux
    /// \[1/m²\] on a surface across the leg.
    #[inline]
    fn cells_of<const N: usize>(
        &self,
        traced: &TracedLeg<N>,
        mut visit: impl FnMut(&Crossed, f64),
    ) {
        if self.deposit == Deposit::Exact && traced.is_inside {
            return;
        }
        let mut leg = traced.leg;
        if traced.is_stopped {
            leg.length += self.beyond;
        }
        let is_mean = self.deposit == Deposit::Exact;
        match self.cells {
            Cells::Grid(grid) => {
                // Cubes are all the same.
                let (crossed, by_volume) = (1.0 / grid.across(leg.direction), 1.0 / grid.volume());
                for part in grid.cross(&leg) {
                    let density = if is_mean {
                        (part.to - part.from) * by_volume
                    } else {
                        crossed
                    };
                    visit(&part, density);
                }
            }
            Cells::Shells(shells) => {
                for part in shells.cross(&leg) {
                    let density = if is_mean {
                        (part.to - part.from) / shells.volume(part.cell)
                    } else {
                        1.0 / shells.across(part.cell, leg.direction)
                    };
                    visit(&part, density);
                }
            }
        }
    }

    /// The cosine with which a leg meets a surface that faces the centre, at a cell's middle, but for the
    /// [factor](Self::factors) of the cell; or its mean over the part of the leg in the cell, which is the
    /// rise of the distance by the length.
    #[inline]
    fn outward(&self, leg: &Leg, part: &Crossed) -> f64 {
        match self.deposit {
            Deposit::Crossing => leg.direction.dot(part.outward),
            Deposit::Exact => rise(leg, part) / (part.to - part.from),
        }
    }

    /// Multiplies the sums of [`AllCells`] alone by what is the same for all legs of a cell: the length of
    /// [`Crossed::outward`], by which cosines are divided.
    pub fn factors(&self, values: &mut [[f64; 3]]) {
        let (Deposit::Crossing, Cells::Grid(grid)) = (self.deposit, self.cells) else {
            return;
        };
        for (cell, value) in values.iter_mut().enumerate() {
            let length = grid.middle(cell as u32).length();
            // A leg through the centre's own cube goes neither away from the centre nor towards it.
            let factor = if length > 0.0 {
                grid.half() / length
            } else {
                0.0
            };
            *value = value.map(|sum| sum * factor);
        }
    }

    /// The largest sum that can be expected for some flux \[W\].
    pub fn bound(&self, flux: f64) -> f64 {
        /// Legs of a photon's light and narrow cells.
        const HEADROOM: f64 = 64.0;
        let cells = self.cells;
        let least = match cells {
            Cells::Grid(grid) => grid.volume(),
            Cells::Shells(shells) => (0..shells.layers())
                .map(|layer| shells.volume((layer * shells.triangles()) as u32))
                .fold(f64::INFINITY, f64::min),
        };
        HEADROOM * flux / math::powf(least, 2.0 / 3.0)
    }
}

/// By how much \[m\] a leg's distance from the centre grows within a cell, where it goes away from it.
#[inline(never)]
fn rise(leg: &Leg, part: &Crossed) -> f64 {
    let start = part.from.max(-leg.from.dot(leg.direction));
    if start >= part.to {
        return 0.0;
    }
    (leg.at(part.to).length() - leg.at(start).length()).max(0.0)
}

/// Irradiance on surfaces that face the centre, in all cells.
pub struct AllCells<'a, const N: usize> {
    /// The rule.
    pub rule: &'a Rule<'a>,
    /// The sums, by cell.
    pub sums: Sums<N>,
}

impl<const N: usize> Deposits<N> for AllCells<'_, N> {
    #[inline]
    fn add(&mut self, traced: &TracedLeg<N>, work: &mut Work) {
        let (rule, sums) = (self.rule, &mut self.sums);
        rule.cells_of(traced, |part, density| {
            work.deposits += 1;
            let cosine = rule.outward(&traced.leg, part);
            if cosine > 0.0 {
                sums.add(part.cell as usize, traced.flux * (density * cosine));
            }
        });
    }
}

/// Vector irradiance in all cells: the flux density of light, Σ Φ d̂ by area, along each axis.
///
/// What comes from two sides cancels out in part: then it is too little for either.
pub struct CellVectors<'a, const N: usize> {
    /// The rule.
    pub rule: &'a Rule<'a>,
    /// The sums along x, y and z, cell by cell.
    pub sums: Sums<N>,
}

impl<const N: usize> Deposits<N> for CellVectors<'_, N> {
    #[inline]
    fn add(&mut self, traced: &TracedLeg<N>, work: &mut Work) {
        let (rule, sums) = (self.rule, &mut self.sums);
        let direction = traced.leg.direction.to_array();
        rule.cells_of(traced, |part, density| {
            work.deposits += 1;
            for (axis, along) in direction.into_iter().enumerate() {
                let number = 3 * part.cell as usize + axis;
                sums.add(number, traced.flux * (density * along));
            }
        });
    }
}

/// Irradiance on surfaces with the sensor's own normals, in the cells that it reads.
pub struct ReadCells<'a, const N: usize> {
    /// The rule.
    pub rule: &'a Rule<'a>,
    /// The cells with their normals.
    pub reads: &'a Reads,
    /// The sums, by their numbers.
    pub sums: Sums<N>,
}

impl<const N: usize> Deposits<N> for ReadCells<'_, N> {
    #[inline]
    fn add(&mut self, traced: &TracedLeg<N>, work: &mut Work) {
        let (rule, reads, sums) = (self.rule, self.reads, &mut self.sums);
        let direction = traced.leg.direction;
        rule.cells_of(traced, |part, density| {
            let range = reads.of(part.cell);
            work.deposits += range.len() as u64;
            for number in range {
                let cosine = -direction.dot(reads.normal(number));
                if cosine > 0.0 {
                    sums.add(number, traced.flux * (density * cosine));
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_leg_rises_from_its_nearest_place_on() {
        let leg = Leg {
            from: DVec3::new(-2.0, 1.0, 0.0),
            direction: DVec3::X,
            length: f64::INFINITY,
        };
        let of = |from: f64, to: f64| {
            let part = Crossed {
                cell: 0,
                from,
                to,
                outward: DVec3::X,
            };
            rise(&leg, &part)
        };
        // Nearest at the length 2, 1 m from the centre.
        assert_eq!(of(0.0, 1.5), 0.0);
        assert!((of(1.0, 4.0) - (5.0f64.sqrt() - 1.0)).abs() < 1e-15);
        assert!((of(3.0, 4.0) - (5.0f64.sqrt() - 2.0f64.sqrt())).abs() < 1e-15);
    }
}
