use super::super::block::block;
use super::*;
use crate::generate::{BrilliantCut, equilateral_prism, round_brilliant};
use crate::numeric::math;

fn light(x: f64, y: f64) -> ParallelLight {
    ParallelLight {
        direction: DVec3::new(x, y, -1.0).normalize(),
        irradiance: 1000.0,
    }
}

fn stone() -> MeshParts {
    let mut mesh = round_brilliant(1.0, BrilliantCut::TOLKOWSKY);
    let (sin, cos) = math::sin_cos(0.3_f64);
    for position in &mut mesh.positions {
        *position = DVec3::new(
            cos * position.x + sin * position.z,
            position.y,
            cos * position.z - sin * position.x + 2.0,
        );
    }
    mesh
}

#[test]
fn a_blocks_six_facets_are_found_in_its_twelve_triangles() {
    assert_eq!(
        facets(&block(DVec3::new(0.0, 0.0, 1.0), DVec3::ONE * 2.0))
            .unwrap()
            .len(),
        6
    );
    assert_eq!(facets(&stone()).unwrap().len(), 57 + 16);
}

#[test]
fn the_ledger_closes() {
    for (mesh, ior, reflections) in [
        (
            block(DVec3::new(-1.0, -1.0, 0.5), DVec3::new(1.0, 1.0, 2.0)),
            1.5,
            12,
        ),
        (stone(), 2.418, 5),
    ] {
        let ledger = FlatFacets::new(&mesh, ior, light(0.3, 0.1), reflections)
            .unwrap()
            .ledger();
        let sum = ledger.landed + ledger.escaped + ledger.cut_off;
        // Beams are cut at shared edges: rounding of 1e-15 of the solid's size each, thousands of them.
        assert!((sum / ledger.intercepted - 1.0).abs() < 1e-11, "{ledger:?}");
        assert!(ledger.landed > 0.05 * ledger.intercepted && ledger.escaped > 0.0);
    }
}

#[test]
fn a_wide_slab_transmits_and_shifts_as_the_formula_says() {
    use crate::reference::closed_form::FlatSlab;
    let mesh = block(DVec3::new(-50.0, -50.0, 1.0), DVec3::new(50.0, 50.0, 1.5));
    let solved = FlatFacets::new(&mesh, 1.5, light(0.75, 0.0), 4).unwrap();
    let slab = FlatSlab {
        thickness: 0.5,
        ior: 1.5,
    };
    let cos = 0.8;
    let texel = TexelRect::new(-0.1, -0.1, 0.1, 0.1);
    for k in 0..4 {
        let exact = 1000.0 * cos * slab.transmitted_fraction(cos, KnownPath::Through(k));
        let irradiance = solved.texel_irradiance(KnownPath::Through(k), &texel);
        assert!(
            (irradiance - exact).abs() < 1e-10 * 1000.0,
            "{k}: {irradiance} {exact}"
        );
    }
    assert_eq!(solved.texel_irradiance(KnownPath::Direct, &texel), 0.0);
    // The image's left border is that of the top facet, moved by the light and back by the slab.
    let edge = -50.0 + 0.75 * 1.5 - slab.foot_shift(math::atan(0.75_f64), 0);
    let image = solved
        .polygons()
        .iter()
        .filter(|polygon| polygon.path == KnownPath::Through(0));
    let left = image
        .flat_map(|polygon| &polygon.corners)
        .map(|corner| corner.x)
        .fold(f64::INFINITY, f64::min);
    assert!((left - edge).abs() < 1e-12, "{left} {edge}");
}

#[test]
fn a_prism_at_minimum_deviation_turns_light_by_its_formula() {
    let mut mesh = equilateral_prism(0.1, 0.2);
    // As in the bundled scene: length along y, upper face at the incidence asin(3/4).
    let (sin, cos) = math::sin_cos(math::asin(0.75_f64) - std::f64::consts::FRAC_PI_6);
    for position in &mut mesh.positions {
        let (x, y, z) = (position.x, -position.z, position.y);
        *position = DVec3::new(cos * x + sin * z, y, cos * z - sin * x + 0.15);
    }
    let solved = FlatFacets::new(&mesh, 1.5, light(0.0, 0.0), 0).unwrap();
    let deviation = 2.0 * math::asin(0.75_f64) - std::f64::consts::FRAC_PI_3;
    // In at cos i, out at cos i: the beam keeps its width, and falls on the floor at the deviation.
    let reflectance = dielectric_reflectance((7.0_f64 / 16.0).sqrt(), 1.5);
    let exact = 1000.0 * math::powi(1.0 - reflectance, 2) * math::cos(deviation);
    let found = solved
        .polygons()
        .iter()
        .filter(|polygon| polygon.path == KnownPath::Through(0));
    let nearest = found
        .map(|polygon| (polygon.irradiance - exact).abs())
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-10 * exact, "{nearest}");
}

#[test]
fn a_map_is_its_texels_and_its_sum_is_what_landed() {
    let mesh = block(DVec3::new(-0.5, -0.5, 0.25), DVec3::new(0.5, 0.5, 1.25));
    let solved = FlatFacets::new(&mesh, 1.5, light(0.5, 0.2), 3).unwrap();
    let grid = TexelGrid::square(8.0, 40);
    let mut landed = 0.0;
    for path in [
        KnownPath::Reflected(1),
        KnownPath::Through(0),
        KnownPath::Through(1),
        KnownPath::Through(2),
        KnownPath::Through(3),
    ] {
        let map = solved.map(path, &grid);
        let (column, row) = (21, 20);
        let texel = solved.texel_irradiance(path, &grid.texel(column, row));
        assert!((map[row * 40 + column] - texel).abs() < 1e-12 * 1000.0);
        landed += map.iter().sum::<f64>() * grid.texel(0, 0).area();
    }
    assert!((landed / solved.ledger().landed - 1.0).abs() < 1e-12);
    let shaded =
        1600.0 - solved.map(KnownPath::Direct, &grid).iter().sum::<f64>() / solved.floor_irradiance;
    let shadow = solved.ledger().intercepted / solved.floor_irradiance / grid.texel(0, 0).area();
    assert!((shaded - shadow).abs() < 1e-10);
}

#[test]
fn solids_that_are_not_convex_or_too_low_and_light_from_below_are_refused() {
    let mut dented = block(DVec3::new(-0.5, -0.5, 0.25), DVec3::new(0.5, 0.5, 1.25));
    dented.positions[7] = DVec3::new(0.1, 0.1, 0.9);
    assert!(matches!(
        FlatFacets::new(&dented, 1.5, light(0.0, 0.0), 1),
        Err(FacetsError::NotConvex { .. })
    ));
    let low = block(DVec3::new(-0.5, -0.5, -0.25), DVec3::new(0.5, 0.5, 1.25));
    assert!(matches!(
        FlatFacets::new(&low, 1.5, light(0.0, 0.0), 1),
        Err(FacetsError::BelowThePlane { .. })
    ));
    let good = block(DVec3::new(-0.5, -0.5, 0.25), DVec3::new(0.5, 0.5, 1.25));
    let mut torn = good.clone();
    torn.triangles[3][1] = 8;
    assert!(matches!(
        FlatFacets::new(&torn, 1.5, light(0.0, 0.0), 1),
        Err(FacetsError::Vertex {
            triangle: 3,
            vertex: 8
        })
    ));
    let upward = ParallelLight {
        direction: DVec3::Z,
        irradiance: 1.0,
    };
    assert!(matches!(
        FlatFacets::new(&good, 1.5, upward, 1),
        Err(FacetsError::Direction(_))
    ));
}
