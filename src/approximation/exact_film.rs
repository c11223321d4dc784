//! Sums of light by texel that do not depend on the order of deposits.

use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};

use glam::DVec2;

use crate::film::coverage::deal;
use crate::numeric::FixedPoint;
use crate::radiometry::Rgb;
use crate::run::Error;

/// Sums of light by texel that do not depend on the order of deposits.
pub struct ExactFilm {
    size: [usize; 2],
    scale: FixedPoint,
    sums: Vec<AtomicI64>,
    overflowed: AtomicBool,
}

impl ExactFilm {
    /// An empty film for sums of magnitudes up to `largest`, kept to 2^-60 of that.
    ///
    /// # Errors
    ///
    /// Where that cannot be represented.
    pub fn new(size: [usize; 2], largest: f64) -> Result<Self, Error> {
        let scale = FixedPoint::for_total(largest).map_err(|_| overflow())?;
        Ok(Self {
            size,
            scale,
            sums: (0..3 * size[0] * size[1])
                .map(|_| AtomicI64::new(0))
                .collect(),
            overflowed: AtomicBool::new(false),
        })
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Adds light to a texel, from any thread.
    #[inline]
    pub fn deposit(&self, [column, row]: [usize; 2], value: Rgb) {
        let texel = row * self.size[0] + column;
        for (sum, part) in self.sums[3 * texel..3 * texel + 3].iter().zip(value.0) {
            match self.scale.quantise(part) {
                Some(quanta) => {
                    let before = sum.fetch_add(quanta, Ordering::Relaxed);
                    if before.checked_add(quanta).is_none() {
                        self.overflowed.store(true, Ordering::Relaxed);
                    }
                }
                None => self.overflowed.store(true, Ordering::Relaxed),
            }
        }
    }

    /// Adds light at a place; nothing outside.
    pub fn deposit_at(&self, at: DVec2, value: Rgb) {
        let [width, height] = self.size.map(|side| side as f64);
        if at.x >= 0.0 && at.y >= 0.0 && at.x < width && at.y < height {
            self.deposit([at.x as usize, at.y as usize], value);
        }
    }

    /// Deals the light of a triangle out by area, `flux` at its corners being a density that is linear
    /// between them, of which the mean is its whole. Returns how many texels had a part.
    pub fn deal(&self, image: [DVec2; 3], flux: [Rgb; 3]) -> u64 {
        let mut texels = 0;
        deal(image, self.size, |texel, part| {
            texels += 1;
            let value = flux[0] * part.share
                + (flux[1] - flux[0]) * part.moment.x
                + (flux[2] - flux[0]) * part.moment.y;
            self.deposit(texel, value);
        });
        texels
    }

    /// The sums.
    ///
    /// # Errors
    ///
    /// Where one does not fit.
    pub fn finish(self) -> Result<Vec<Rgb>, Error> {
        if self.overflowed.into_inner() {
            return Err(overflow());
        }
        let scale = self.scale;
        let value = |sum: &AtomicI64| scale.value_i64(sum.load(Ordering::Relaxed));
        Ok(self
            .sums
            .chunks_exact(3)
            .map(|texel| Rgb([value(&texel[0]), value(&texel[1]), value(&texel[2])]))
            .collect())
    }
}

fn overflow() -> Error {
    let reason = "the light on one texel or pixel is beyond what can be summed: allowed are emitters of 1e-250 to \
                  1e250 W, and cameras no nearer to what they see than 1/64 of the typical distance";
    Error::NotRepresentable(reason.to_owned())
}
