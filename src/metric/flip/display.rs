//! The values that a display shows: clamped, or exposed and tone-mapped.

/// Narkowicz' fit of the ACES tone curve, (p₀ x² + p₁ x) / (q₀ x² + q₁ x + q₂), for x without the exposure of
/// 0.6 built into it.
pub(super) const ACES: [f32; 5] = [
    0.6 * 0.6 * 2.51,
    0.6 * 0.03,
    0.6 * 0.6 * 2.43,
    0.6 * 0.59,
    0.14,
];

/// The change of values before they are compared.
#[derive(Clone, Copy)]
pub(super) enum Display {
    /// Clamped to 0..=1.
    Clamp,
    /// Multiplied by a factor, tone-mapped, clamped.
    Expose(f32),
}

/// A value as a display shows it, 0..=1.
#[inline]
pub(super) fn shown(value: f32, display: Display) -> f32 {
    let value = match display {
        Display::Clamp => value,
        Display::Expose(factor) => {
            let x = value.max(0.0) * factor;
            let [p0, p1, q0, q1, q2] = ACES;
            // Divided by x, since x² of a very bright texel is beyond f32.
            if x > 1.0 {
                (p0 + p1 / x) / (q0 + q1 / x + q2 / x / x)
            } else {
                (p0 * x + p1) * x / ((q0 * x + q1) * x + q2)
            }
        }
    };
    value.clamp(0.0, 1.0)
}
