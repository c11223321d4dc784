//! Facets' normals: what must hold of any distribution, and the smooth limit of the tables.

use glam::DVec3;
use nephroid::internals::numeric::quadrature::GaussLegendre;
use nephroid::internals::optics::{
    FacetDistribution, Microfacets, RoughTransmittance, dielectric_reflectance,
};

const BOTH: [FacetDistribution; 2] = [FacetDistribution::Beckmann, FacetDistribution::Ggx];

/// ∫ f over the upper half of directions, in slopes: m = (-x, -y, 1)/√(1 + x² + y²), dω = m_z³ dx dy, with x
/// and y from -∞ to ∞ by x = α tan t.
fn over_normals(alpha: [f64; 2], f: impl Fn(DVec3) -> f64) -> f64 {
    let rule = GaussLegendre::new(128).unwrap();
    let axis = |alpha: f64| {
        let half = std::f64::consts::FRAC_PI_2;
        let nodes = rule.on(-half, half).map(move |(t, weight)| {
            let cos = t.cos();
            (alpha * t.tan(), weight * alpha / (cos * cos))
        });
        nodes.collect::<Vec<_>>()
    };
    let (xs, ys) = (axis(alpha[0]), axis(alpha[1]));
    let mut sum = 0.0;
    for &(x, weight_x) in &xs {
        for &(y, weight_y) in &ys {
            let m = DVec3::new(-x, -y, 1.0).normalize();
            sum += weight_x * weight_y * m.z.powi(3) * f(m);
        }
    }
    sum
}

#[test]
fn facets_cover_the_surface_and_what_is_seen_of_them_covers_the_view() {
    for distribution in BOTH {
        for alpha in [[0.1, 0.1], [0.5, 0.2], [1.0, 1.0]] {
            let facets = Microfacets::new(distribution, alpha);
            let covered = over_normals(alpha, |m| facets.density(m) * m.z);
            // Smooth but for the corners, where GGX's tails meet both ends of t: there lies 1/128² of the
            // square, with a thousandth of the weight.
            assert!(
                (covered - 1.0).abs() < 1e-6,
                "{distribution:?} {alpha:?}: {covered}"
            );
            for theta in [0.0f64, 0.6, 1.2, 1.5] {
                let v = DVec3::new(0.8 * theta.sin(), 0.6 * theta.sin(), theta.cos());
                let seen = over_normals(alpha, |m| facets.visible_density(v, m).max(0.0));
                // The density has a kink where facets are seen edge on, which a rule of n nodes a side
                // resolves to its spacing squared: (π/128)² of the slopes' share there.
                assert!(
                    (seen - 1.0).abs() < 1e-3,
                    "{distribution:?} {alpha:?} {theta}: {seen}"
                );
            }
        }
    }
}

#[test]
fn normals_are_drawn_as_often_as_they_are_seen() {
    // The mean of m.x over visible normals, by sampling on a grid of midpoints and by the density.
    for distribution in BOTH {
        let alpha = [0.4, 0.7];
        let facets = Microfacets::new(distribution, alpha);
        for theta in [0.2f64, 1.0, 1.45] {
            let v = DVec3::new(0.6 * theta.sin(), -0.8 * theta.sin(), theta.cos());
            let n = 200;
            let mut drawn = DVec3::ZERO;
            for i in 0..n {
                for j in 0..n {
                    let u = [(i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / n as f64];
                    drawn += facets.sample_visible(v, u) / (n * n) as f64;
                }
            }
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let expected = over_normals(alpha, |m| {
                    facets.visible_density(v, m).max(0.0) * m.dot(axis)
                });
                // As above, and midpoints of a map that is not smooth: 1/n of the largest jump, 2, squared.
                assert!(
                    (drawn.dot(axis) - expected).abs() < 2e-3,
                    "{distribution:?} {theta} {axis}"
                );
            }
        }
    }
}

#[test]
fn a_smooth_coat_lets_through_what_fresnel_says() {
    for distribution in BOTH {
        let eta = 1.5;
        let table = RoughTransmittance::new(distribution, 1e-4, eta);
        for i in [8, 20, 40, 63] {
            // At the table's own cosines, 63rds, that are far above the roughness.
            let cos = i as f64 / 63.0;
            let expected = 1.0 - dielectric_reflectance(cos, eta);
            // Slopes of 1e-4 change F by 1e-4 of its derivative, at most some 6 next to grazing, and GGX's
            // tails reach a few times as far.
            let error = (table.entering(cos) - expected).abs();
            assert!(
                error < 1e-3,
                "{distribution:?} {cos}: {} {expected}",
                table.entering(cos)
            );
        }
        // The table's rule for the light kept inside, (2/64) Σ F(μ) μ, applied to Fresnel's own F: facets
        // blur only the edge at the critical angle, by less than one step, which is worth 2 μ/64.
        let mean: f64 = (0..64)
            .map(|i| (i as f64 / 63.0).max(1e-6))
            .map(|cos| 2.0 * cos * dielectric_reflectance(cos, 1.0 / eta) / 64.0)
            .sum();
        let kept = table.internal_reflectance();
        assert!(
            (kept - mean).abs() < 0.01,
            "{distribution:?}: {kept} {mean}"
        );
        // d'Eon and Irving's fit for 1.5 gives 0.5963; the rule's own error is 2/64 or less.
        assert!((kept - 0.5963).abs() < 0.03, "{kept}");
    }
}

#[test]
fn mitsubas_fit_of_the_shadowing_is_within_0_35_percent() {
    // Both are public by what they do: the value has the fit, the density the exact function.
    let facets = Microfacets::new(FacetDistribution::Beckmann, [0.5; 2]);
    let mut largest = 0.0f64;
    for step in 1..1000 {
        let theta = 0.00157 * f64::from(step);
        let v = DVec3::new(theta.sin(), 0.0, theta.cos());
        let m = DVec3::Z;
        let exact = facets.visible_density(v, m) * v.z / (facets.density(m) * v.dot(m));
        largest = largest.max((facets.shadowing(v, m) / exact - 1.0).abs());
    }
    assert!((1e-3..3.5e-3).contains(&largest), "{largest}");
}
