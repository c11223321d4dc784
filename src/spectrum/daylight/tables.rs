//! The coefficients of the models, from `data/`.
//!
//! `tests/mitsuba/sunsky_tables.py` wrote them. They are those of the authors' fits to brute-force
//! simulations of the atmosphere, under the licence beside them, in the order in which Mitsuba 3.9.1 keeps
//! them: little-endian single precision, the last index fastest.

/// Turbidities 1 to 10 of all tables.
pub const TURBIDITIES: usize = 10;
/// Control points of the curves over the sun's elevation.
pub const CONTROL_POINTS: usize = 6;
/// Numbers that shape the sky of one channel.
pub const SHAPE_NUMBERS: usize = 9;
/// Elevations of the sun in the table of its irradiance.
pub const SUN_ELEVATIONS: usize = 30;
/// Wavelengths of that table: 320 nm to 720 nm, every 40 nm.
pub const SUN_WAVELENGTHS: usize = 11;

/// By turbidity, albedo (0 and 1), control point, channel and number.
static SKY_SHAPE: &[u8; 4 * TURBIDITIES * 2 * CONTROL_POINTS * 3 * SHAPE_NUMBERS] =
    include_bytes!("data/sky-shape.f32");
/// By turbidity, albedo (0 and 1), control point and channel.
static SKY_RADIANCE: &[u8; 4 * TURBIDITIES * 2 * CONTROL_POINTS * 3] =
    include_bytes!("data/sky-radiance.f32");
/// By turbidity, elevation (2° to 89°, every 3°) and wavelength \[W/m²/nm\].
static SUN_IRRADIANCE: &[u8; 4 * TURBIDITIES * SUN_ELEVATIONS * SUN_WAVELENGTHS] =
    include_bytes!("data/sun-irradiance.f32");

/// The number at an index.
fn number(table: &[u8], index: usize) -> f64 {
    let bytes = &table[4 * index..4 * index + 4];
    f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
}

/// The two rows next to a place, and the share of the second: straight lines between rows, and the ends
/// beyond them.
fn rows(place: f64, count: usize) -> [(usize, f64); 2] {
    let place = place.clamp(0.0, (count - 1) as f64);
    let below = (place as usize).min(count - 2);
    let share = place - below as f64;
    [(below, 1.0 - share), (below + 1, share)]
}

/// The weighted sum over turbidities and a second index.
fn blended<const N: usize>(
    turbidity: f64,
    second: [(usize, f64); 2],
    at: impl Fn(usize, usize) -> [f64; N],
) -> [f64; N] {
    let mut sum = [0.0; N];
    for (row, weight) in rows(turbidity - 1.0, TURBIDITIES) {
        for (column, share) in second {
            for (sum, value) in sum.iter_mut().zip(at(row, column)) {
                *sum += weight * share * value;
            }
        }
    }
    sum
}

/// The curve with these control points at x in 0..=1: a Bézier curve of the fifth degree.
fn curve<const N: usize>(x: f64, point: impl Fn(usize) -> [f64; N]) -> [f64; N] {
    const BINOMIALS: [f64; CONTROL_POINTS] = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
    let power = |base: f64, exponent: usize| (0..exponent).fold(1.0, |product, _| product * base);
    let mut sum = [0.0; N];
    for (k, binomial) in BINOMIALS.into_iter().enumerate() {
        let weight = binomial * power(x, k) * power(1.0 - x, CONTROL_POINTS - 1 - k);
        for (sum, value) in sum.iter_mut().zip(point(k)) {
            *sum += weight * value;
        }
    }
    sum
}

/// The numbers that shape the sky of a channel. `x` is ∛(elevation / 90°), `albedo` that of the ground.
pub fn sky_shape(turbidity: f64, albedo: f64, x: f64, channel: usize) -> [f64; SHAPE_NUMBERS] {
    curve(x, |point| {
        blended(turbidity, rows(albedo, 2), |row, ground| {
            let first = ((row * 2 + ground) * CONTROL_POINTS + point) * 3 + channel;
            std::array::from_fn(|k| number(SKY_SHAPE, first * SHAPE_NUMBERS + k))
        })
    })
}

/// The factor on the sky of a channel.
pub fn sky_radiance(turbidity: f64, albedo: f64, x: f64, channel: usize) -> f64 {
    let [value] = curve(x, |point| {
        blended(turbidity, rows(albedo, 2), |row, ground| {
            let first = ((row * 2 + ground) * CONTROL_POINTS + point) * 3 + channel;
            [number(SKY_RADIANCE, first)]
        })
    });
    value
}

/// The sun's irradiance across its direction [W/m²/nm] at [`SUN_WAVELENGTHS`] wavelengths, by its elevation
/// in degrees: below 2° that of 2°, above 89° that of 89°.
pub fn sun_spectrum(turbidity: f64, elevation_degrees: f64) -> [f64; SUN_WAVELENGTHS] {
    let place = rows((elevation_degrees - 2.0) / 3.0, SUN_ELEVATIONS);
    blended(turbidity, place, |row, elevation| {
        let first = (row * SUN_ELEVATIONS + elevation) * SUN_WAVELENGTHS;
        std::array::from_fn(|k| number(SUN_IRRADIANCE, first + k))
    })
}
