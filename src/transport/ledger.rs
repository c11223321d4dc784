//! A ledger of traced flux, by its end.

use std::collections::BTreeMap;

use super::signature::Signature;
use crate::radiometry::Rgb;

/// End of a chain's flux.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fate {
    /// Received in a texel of the sensor.
    Received,
    /// Received in a texel of the sensor, but without any specular event: measured by quadrature instead.
    Direct,
    /// Left the scene.
    Escaped,
    /// Absorbed on a surface or in a medium: a diffuse surface, a metal's or filter's share, the back of a
    /// mirror. Also if a shading normal contradicts the true one.
    Absorbed,
    /// Followed to the deepest level that the settings allow.
    CutOff,
}

impl Fate {
    /// All fates, in the order of a [`FluxByFate`]'s sums.
    pub const ALL: [Self; 5] = [
        Self::Received,
        Self::Direct,
        Self::Escaped,
        Self::Absorbed,
        Self::CutOff,
    ];

    /// Its place in [`Fate::ALL`].
    #[inline]
    pub fn index(self) -> usize {
        self as usize
    }
}

/// The flux that ended after one sequence of events, by fate \[W\].
///
/// # Example: flux through the ball
///
/// ```
/// # use nephroid::{Budget, Context, Method};
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = Method::new("photons", &Default::default())?;
/// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
/// let row = rendering.estimate.ledger.rows[&"LTTD".parse()?];
/// assert!(row.received.mean() > 30.0, "watts on the floor");
/// assert!(row.total().mean() >= row.received.mean());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct FluxByFate {
    /// Flux received in a texel of the sensor.
    pub received: Rgb,
    /// Flux received in a texel, without a specular event.
    pub direct: Rgb,
    /// Flux that left the scene.
    pub escaped: Rgb,
    /// Flux absorbed on a surface or in a medium.
    pub absorbed: Rgb,
    /// Flux past the deepest level.
    pub cut_off: Rgb,
}

impl FluxByFate {
    /// The row with these sums, in the order of [`Fate::ALL`].
    pub(crate) fn from_fates(fates: [Rgb; 5]) -> Self {
        let [received, direct, escaped, absorbed, cut_off] = fates;
        Self {
            received,
            direct,
            escaped,
            absorbed,
            cut_off,
        }
    }

    /// All of it \[W\].
    pub fn total(&self) -> Rgb {
        self.received + self.direct + self.escaped + self.absorbed + self.cut_off
    }
}

/// Ledger of all traced flux \[W\].
///
/// `emitted + shading_gain = Σ rows` to rounding, per channel. `shading_gain` is zero unless adjoint shading
/// normals scale flux.
///
/// # Example: all light is accounted for
///
/// ```
/// # use nephroid::{Budget, Context, Method};
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = Method::new("photons", &Default::default())?;
/// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
/// let ledger = &rendering.estimate.ledger;
/// for (signature, flux) in &ledger.rows {
///     println!("{signature:>8} {:8.3} W received", flux.received.mean());
/// }
/// assert!(ledger.closure_error().unwrap() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Flux that photons left their emitters with.
    pub emitted: Rgb,
    /// Flux that adjoint shading normals added; may be negative.
    pub shading_gain: Rgb,
    /// One row a signature, of the events before the end. Rows past the kept signatures are summed in
    /// `other`.
    pub rows: BTreeMap<Signature, FluxByFate>,
    /// Flux of signatures that have no row of their own.
    pub other: FluxByFate,
    /// Flux that ended elsewhere, mean of channels, known by difference. Methods that follow only received
    /// light have it. Then `emitted` is a mean of channels, too, and the other fates of the rows are not
    /// known.
    pub elsewhere: Option<f64>,
}

impl Ledger {
    /// Flux by fate over all signatures \[W\].
    ///
    /// # Example: flux that left the scene
    ///
    /// ```
    /// # use nephroid::{Budget, Context, Method};
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = Method::new("photons", &Default::default())?;
    /// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
    /// let ledger = &rendering.estimate.ledger;
    /// let escaped = ledger.sum().escaped.mean() / ledger.emitted.mean();
    /// assert!(escaped > 0.05 && escaped < 0.5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sum(&self) -> FluxByFate {
        let mut sum = self.other;
        for row in self.rows.values() {
            sum.received += row.received;
            sum.direct += row.direct;
            sum.escaped += row.escaped;
            sum.absorbed += row.absorbed;
            sum.cut_off += row.cut_off;
        }
        sum
    }

    /// Relative error of the balance, |emitted + gain − Σ rows| / emitted, in the worst channel; 0 if nothing
    /// was emitted.
    ///
    /// `None` if part of the flux is known by difference, since the balance then closes by definition.
    ///
    /// # Example: a test of a scene
    ///
    /// ```
    /// # use nephroid::{Budget, Context, Method};
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = Method::new("photons", &Default::default())?;
    /// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
    /// assert!(rendering.estimate.ledger.closure_error().is_some_and(|error| error < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn closure_error(&self) -> Option<f64> {
        if self.elsewhere.is_some() {
            return None;
        }
        let total = self.sum().total();
        let mut worst: f64 = 0.0;
        for c in 0..3 {
            let expected = self.emitted.0[c] + self.shading_gain.0[c];
            let scale = self.emitted.0[c].abs();
            if scale > 0.0 {
                worst = worst.max((expected - total.0[c]).abs() / scale);
            } else {
                worst = worst.max(total.0[c].abs());
            }
        }
        Some(worst)
    }
}
