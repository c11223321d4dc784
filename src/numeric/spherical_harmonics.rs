//! Real spherical harmonics, and least-squares fits by them.

use glam::DVec3;

/// The `order`² real spherical harmonics Y of bands 0 to `order` − 1, orthonormal over the sphere: Y(l, m) is
/// number l² + l + m.
///
/// Y(l, m) = √2 K P(l, |m|)(z) cos(mφ) for m > 0, sin(|m|φ) for m < 0, and K P(l, 0)(z) for m = 0, by the
/// recurrences of normalised associated Legendre functions (Press et al., *Numerical Recipes*, 6.7), without
/// the factor (−1)^m.
#[derive(Clone, Debug)]
pub struct SphericalHarmonics {
    order: usize,
    /// By m: the function with l = m, without sin(θ)^m.
    sectoral: Vec<f64>,
    /// By m and then l > m: the factors of the last function times z, and of the one before it.
    steps: Vec<[f64; 2]>,
}

impl SphericalHarmonics {
    /// Those of an order.
    pub fn new(order: usize) -> Self {
        let mut sectoral = (0.25 / std::f64::consts::PI).sqrt();
        let mut harmonics = Self {
            order,
            sectoral: Vec::new(),
            steps: Vec::new(),
        };
        for m in 0..order {
            let mf = m as f64;
            if m > 0 {
                sectoral *= ((2.0 * mf + 1.0) / (2.0 * mf)).sqrt();
            }
            harmonics.sectoral.push(sectoral);
            for l in m + 1..order {
                let lf = l as f64;
                let a = ((4.0 * lf * lf - 1.0) / (lf * lf - mf * mf)).sqrt();
                let below = lf - 1.0;
                let b = if l == m + 1 {
                    0.0
                } else {
                    ((below * below - mf * mf) / (4.0 * below * below - 1.0)).sqrt()
                };
                harmonics.steps.push([a, a * b]);
            }
        }
        harmonics
    }

    /// Their values in a unit direction, into a slice of at least `order`² numbers.
    #[inline]
    pub fn write(&self, direction: DVec3, all: &mut [f64]) {
        let z = direction.z;
        // (x + iy)^m, which has sin(θ)^m and the turn.
        let (mut real, mut imaginary) = (1.0, 0.0);
        let mut steps = self.steps.iter();
        for (m, sectoral) in self.sectoral.iter().enumerate() {
            if m > 0 {
                (real, imaginary) = (
                    real * direction.x - imaginary * direction.y,
                    real * direction.y + imaginary * direction.x,
                );
            }
            let scale = if m == 0 {
                1.0
            } else {
                std::f64::consts::SQRT_2
            };
            let (mut before, mut value) = (0.0, *sectoral);
            for l in m..self.order {
                if l > m
                    && let Some([a, b]) = steps.next()
                {
                    (before, value) = (value, a * z * value - b * before);
                }
                let middle = l * l + l;
                all[middle + m] = scale * value * real;
                if m > 0 {
                    all[middle - m] = scale * value * imaginary;
                }
            }
        }
    }
}

/// The [`SphericalHarmonics`] of an order in a unit direction.
pub fn spherical_harmonics(direction: DVec3, order: usize) -> Vec<f64> {
    let mut all = vec![0.0; order * order];
    SphericalHarmonics::new(order).write(direction, &mut all);
    all
}

/// The least-squares fit of spherical harmonics to values in some directions: a linear map, row by row, from
/// the values to the `order`² coefficients. `None` if the directions do not determine them.
///
/// P = (YᵀY)⁻¹Yᵀ by Cholesky's decomposition.
pub fn harmonic_fit(directions: &[DVec3], order: usize) -> Option<Vec<Vec<f64>>> {
    let n = order * order;
    let harmonics = SphericalHarmonics::new(order);
    let basis: Vec<Vec<f64>> = directions
        .iter()
        .map(|direction| {
            let mut row = vec![0.0; n];
            harmonics.write(*direction, &mut row);
            row
        })
        .collect();
    // The lower triangle of YᵀY, then of its factor.
    let mut factor = vec![vec![0.0; n]; n];
    for row in &basis {
        for i in 0..n {
            for j in 0..=i {
                factor[i][j] += row[i] * row[j];
            }
        }
    }
    let largest = (0..n).map(|i| factor[i][i]).fold(0.0, f64::max);
    for i in 0..n {
        for j in 0..=i {
            let done: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let rest = factor[i][j] - done;
            if i == j {
                // Directions that leave less than that of a harmonic to itself do not determine it.
                if rest <= 1e-9 * largest {
                    return None;
                }
                factor[i][i] = rest.sqrt();
            } else {
                factor[i][j] = rest / factor[j][j];
            }
        }
    }
    let mut map = vec![vec![0.0; directions.len()]; n];
    for (column, mut row) in basis.into_iter().enumerate() {
        for i in 0..n {
            let done: f64 = (0..i).map(|k| factor[i][k] * row[k]).sum();
            row[i] = (row[i] - done) / factor[i][i];
        }
        for i in (0..n).rev() {
            let done: f64 = (i + 1..n).map(|k| factor[k][i] * row[k]).sum();
            row[i] = (row[i] - done) / factor[i][i];
            map[i][column] = row[i];
        }
    }
    Some(map)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;
    use crate::numeric::quadrature::GaussLegendre;

    #[test]
    fn harmonics_are_orthonormal() {
        let order = 6;
        let n = order * order;
        let mut products = vec![0.0; n * n];
        // A Gauss rule of 8 nodes is exact for z to degree 15, 16 turns for sums of sines to degree 15.
        let rule = GaussLegendre::new(8).unwrap();
        for (z, weight) in rule.on(-1.0, 1.0) {
            for turn in 0..16 {
                let angle = f64::from(turn) * std::f64::consts::TAU / 16.0;
                let across = (1.0 - z * z).sqrt();
                let direction = DVec3::new(across * math::cos(angle), across * math::sin(angle), z);
                let all = spherical_harmonics(direction, order);
                for i in 0..n {
                    for j in 0..n {
                        products[i * n + j] +=
                            all[i] * all[j] * weight * std::f64::consts::TAU / 16.0;
                    }
                }
            }
        }
        for i in 0..n {
            for j in 0..n {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((products[i * n + j] - expected).abs() < 1e-12, "{i} {j}");
            }
        }
    }

    #[test]
    fn the_first_harmonics_are_those_of_the_textbooks() {
        let d = DVec3::new(0.36, 0.48, 0.8);
        let all = spherical_harmonics(d, 3);
        let pi = std::f64::consts::PI;
        assert!((all[0] - (0.25 / pi).sqrt()).abs() < 1e-15);
        let first = (0.75 / pi).sqrt();
        for (number, value) in [(1, d.y), (2, d.z), (3, d.x)] {
            assert!((all[number] - first * value).abs() < 1e-15);
        }
        let second = (15.0 / (4.0 * pi)).sqrt();
        assert!((all[4] - second * d.x * d.y).abs() < 1e-15);
        assert!((all[6] - (5.0 / (16.0 * pi)).sqrt() * (3.0 * d.z * d.z - 1.0)).abs() < 1e-15);
    }

    #[test]
    fn a_fit_gives_the_coefficients_back_and_too_few_directions_give_none() {
        let directions: Vec<DVec3> = (0..60)
            .map(|index| {
                let z = 1.0 - 2.0 * (f64::from(index) + 0.5) / 60.0;
                let turn = 2.399_963 * f64::from(index);
                let across = (1.0 - z * z).sqrt();
                DVec3::new(across * math::cos(turn), across * math::sin(turn), z)
            })
            .collect();
        let fit = harmonic_fit(&directions, 4).unwrap();
        let coefficient = |number: usize| 0.3 * number as f64 - 1.7;
        let values: Vec<f64> = directions
            .iter()
            .map(|direction| {
                let all = spherical_harmonics(*direction, 4);
                all.iter()
                    .enumerate()
                    .map(|(k, y)| coefficient(k) * y)
                    .sum()
            })
            .collect();
        for (number, row) in fit.iter().enumerate() {
            let found: f64 = row.iter().zip(&values).map(|(p, value)| p * value).sum();
            assert!((found - coefficient(number)).abs() < 1e-12, "{number}");
        }
        assert!(harmonic_fit(&directions[..12], 4).is_none());
    }
}
