//! Elementary functions with the same bits on every machine.
//!
//! The standard library hands `sin`, `exp`, `powf` and their like to the C library of the system. Its last
//! bits depend on its version, and in glibc on the processor: it has a form with fused multiply-add, and one
//! without. Here they are those of the crate `libm`: plain Rust, in additions, multiplications, divisions and
//! square roots, which IEEE 754 fixes to the bit. No compiler reorders or fuses these on its own.
//! `clippy.toml` forbids the standard ones.
//!
//! Some functions may stay the standard library's, because IEEE 754 fixes their only result: `sqrt`, `abs`,
//! `floor`, `ceil`, `round`, `trunc`, `%`, `rem_euclid`, and `mul_add`, which rounds once wherever it runs.
//!
//! Errors are below one unit in the last place, but for [`tan`], [`powf`] and [`exp2`] hardly above half of
//! one (FreeBSD's msun, from which `libm` comes). [`powi`] is off by half a unit for each multiplication.
//! Arguments without a value give NaN, and results too large give infinity, as in the standard library.

/// sin x; x in radians.
#[inline]
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// cos x; x in radians.
#[inline]
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// (sin x, cos x); x in radians. The same bits as [`sin`] and [`cos`], for about the price of one.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// tan x; x in radians.
#[inline]
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// The angle in [−π/2, π/2] with the sine x; NaN beyond [−1, 1].
#[inline]
pub fn asin(x: f64) -> f64 {
    libm::asin(x)
}

/// The angle in [0, π] with the cosine x; NaN beyond [−1, 1].
#[inline]
pub fn acos(x: f64) -> f64 {
    libm::acos(x)
}

/// The angle in [−π/2, π/2] with the tangent x.
#[inline]
pub fn atan(x: f64) -> f64 {
    libm::atan(x)
}

/// The angle of the point (x, y) from the x axis, in [−π, π]. At the origin it is 0 or ±π, by the signs of
/// its zeros.
#[inline]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// eˣ.
#[inline]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// 2ˣ; exact for whole x.
#[inline]
pub fn exp2(x: f64) -> f64 {
    libm::exp2(x)
}

/// eˣ − 1, without cancellation about 0.
#[inline]
pub fn exp_m1(x: f64) -> f64 {
    libm::expm1(x)
}

/// The natural logarithm; −∞ at 0, NaN below.
#[inline]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// ln(1 + x), without cancellation about 0.
#[inline]
pub fn ln_1p(x: f64) -> f64 {
    libm::log1p(x)
}

/// The logarithm to base 2; exact at powers of two.
#[inline]
pub fn log2(x: f64) -> f64 {
    libm::log2(x)
}

/// The logarithm to base 10; exact at powers of ten.
#[inline]
pub fn log10(x: f64) -> f64 {
    libm::log10(x)
}

/// xʸ for any y; NaN if x < 0 and y is not whole.
#[inline]
pub fn powf(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// xⁿ by squaring: the product of x^(2ᵏ) over the bits k of |n|, lowest first; its reciprocal if n < 0.
///
/// [`f64::powi`] has an unspecified result: the compiler may compute it while it builds, by the `pow` of the
/// machine that it runs on, or leave it to a function of its own.
#[inline]
pub fn powi(x: f64, n: i32) -> f64 {
    let mut left = n.unsigned_abs();
    let mut power = x;
    let mut product = if left & 1 == 1 { x } else { 1.0 };
    left >>= 1;
    while left > 0 {
        power *= power;
        if left & 1 == 1 {
            product *= power;
        }
        left >>= 1;
    }
    if n < 0 { 1.0 / product } else { product }
}

/// ∛x.
#[inline]
pub fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

/// √(x² + y²), without overflow or underflow in between.
#[inline]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// erf x = 2/√π ∫₀ˣ exp(−t²) dt.
#[inline]
pub fn erf(x: f64) -> f64 {
    libm::erf(x)
}

/// 1 − erf x, without cancellation for large x.
#[inline]
pub fn erfc(x: f64) -> f64 {
    libm::erfc(x)
}

/// ln |Γ(x)|.
#[inline]
pub fn ln_gamma(x: f64) -> f64 {
    libm::lgamma(x)
}

/// The functions of single precision that anything needs.
pub mod single {
    /// eˣ.
    #[inline]
    pub fn exp(x: f32) -> f32 {
        libm::expf(x)
    }

    /// 2ˣ; exact for whole x.
    #[inline]
    pub fn exp2(x: f32) -> f32 {
        libm::exp2f(x)
    }

    /// The logarithm to base 2.
    #[inline]
    pub fn log2(x: f32) -> f32 {
        libm::log2f(x)
    }

    /// xʸ for any y; NaN if x < 0 and y is not whole.
    #[inline]
    pub fn powf(x: f32, y: f32) -> f32 {
        libm::powf(x, y)
    }

    /// ∛x.
    #[inline]
    pub fn cbrt(x: f32) -> f32 {
        libm::cbrtf(x)
    }

    /// √(x² + y²).
    #[inline]
    pub fn hypot(x: f32, y: f32) -> f32 {
        libm::hypotf(x, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_powers_are_products_and_their_reciprocals() {
        for x in [0.3, -1.7, 1.1, 2.0] {
            let mut product = 1.0;
            for n in 0..20 {
                // n multiplications here, at most 2 log₂ n there, each off by half a unit.
                let allowed = f64::from(n) * f64::EPSILON;
                assert!((powi(x, n) / product - 1.0).abs() <= allowed, "{x}, {n}");
                assert_eq!(powi(x, -n), 1.0 / powi(x, n));
                product *= x;
            }
        }
        assert_eq!(powi(2.0, -1074), 0.0);
        assert_eq!(powi(0.0, 0), 1.0);
        assert_eq!(powi(3.0, i32::MIN), 0.0);
    }

    #[test]
    fn powers_of_two_and_ten_are_exact() {
        for n in -300..300 {
            assert_eq!(exp2(f64::from(n)), powi(2.0, n));
            assert_eq!(log2(powi(2.0, n)), f64::from(n));
        }
        let mut ten: f64 = 1.0;
        for n in 0..=22 {
            assert_eq!(log10(ten), f64::from(n));
            ten *= 10.0;
        }
    }

    /// `mul_add` stays the standard library's: it must round once on this machine, too.
    #[test]
    fn multiplying_and_adding_rounds_once() {
        let mut state: u64 = 1;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            f64::from_bits((state >> 12) | 0x3ff0_0000_0000_0000) - 1.5
        };
        for _ in 0..10_000 {
            let (a, b) = (next(), next());
            for c in [next(), -(a * b), next() * f64::EPSILON] {
                assert_eq!(std::hint::black_box(a).mul_add(b, c), libm::fma(a, b, c));
            }
        }
    }
}
