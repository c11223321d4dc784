//! Look-ups of a caustic map against closed forms: one lit texel, read where it is and beside it.

use glam::{DVec2, DVec3};
use nephroid::internals::approximation::caustic_map::lookup::{
    CausticTexture, CausticTextures, Looks,
};
use nephroid::internals::approximation::caustic_map::variants::Lookup;
use nephroid::internals::approximation::{DepthMap, Extent, LightView, Precision, Receivers};
use nephroid::internals::geometry::{Bounds, SurfacePoint};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::first_surface::Source;

use crate::support::approximation::{lit_by, over_floor, scene_of};

const SIDE: u32 = 64;

/// A lamp at height 4 over the floor, seen in 64² texels; the floor fills the image but for its margin.
fn floor_view(scene: &Scene) -> LightView {
    let floor = Bounds::from_points([DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 0.0)]);
    LightView::around(&Source::all(scene)[0], &[Extent::Box(floor)], SIDE)[0]
}

/// A map with one lit texel of 1 W.
fn one_texel(view: LightView, [column, row]: [usize; 2], lookup: Lookup) -> CausticTextures {
    let mut flux = vec![Rgb::BLACK; (SIDE * SIDE) as usize];
    flux[row * SIDE as usize + column] = Rgb::WHITE;
    CausticTextures {
        maps: vec![CausticTexture {
            view,
            flux,
            depths: None,
        }],
        lookup,
        bias: 0.01,
    }
}

fn on_floor(view: &LightView, at: DVec2) -> SurfacePoint {
    let ray = view.ray(at);
    SurfacePoint {
        position: ray.at(-ray.origin.z / ray.direction.z),
        position_error: DVec3::ZERO,
        geometric_normal: DVec3::Z,
        shading_normal: DVec3::Z,
        uv: DVec2::ZERO,
    }
}

/// Area of a texel on the floor: the view's plane is parallel to it.
fn texel_area() -> f64 {
    (4.0 * 1.001 / f64::from(SIDE)).powi(2)
}

#[test]
fn a_texel_is_read_where_it_is_and_fades_to_its_neighbours_middles() {
    let scene = scene_of(&over_floor("", 4));
    let view = floor_view(&scene);
    let texel = [40, 17];
    let middle = DVec2::new(40.5, 17.5);
    for (offset, bilinear, nearest) in [
        (DVec2::ZERO, 1.0, 1.0),
        (DVec2::new(0.25, 0.0), 0.75, 1.0),
        (DVec2::new(-0.25, 0.4), 0.75 * 0.6, 1.0),
        (DVec2::new(0.75, -0.5), 0.25 * 0.5, 0.0),
        (DVec2::new(0.0, 0.9), 0.1, 0.0),
        (DVec2::new(1.0, 0.0), 0.0, 0.0),
        (DVec2::new(-1.2, 0.0), 0.0, 0.0),
    ] {
        for (lookup, share) in [(Lookup::Bilinear, bilinear), (Lookup::Nearest, nearest)] {
            let field = one_texel(view, texel, lookup);
            let point = on_floor(&view, middle + offset);
            let found = field.irradiance(&point, DVec3::Z, &mut Looks::default());
            let expected = share / texel_area();
            // Rounding of places of some tens of texels: 1e-14 of a texel, times the steepest fall.
            let allowed = 1e-11 / texel_area();
            assert!(
                (found.mean() - expected).abs() < allowed,
                "{offset}: {found:?} {expected}"
            );
        }
    }
}

#[test]
fn a_look_up_divides_by_the_area_that_a_texel_sees_of_a_tilted_surface() {
    let scene = scene_of(&over_floor("", 4));
    let view = floor_view(&scene);
    let at = DVec2::new(50.5, 32.0);
    let point = on_floor(&view, at);
    // A surface through the same point that faces the lamp: the texel's solid angle times the distance squared.
    let away = point.position - DVec3::new(0.0, 0.0, 4.0);
    let field = one_texel(view, [50, 32], Lookup::Nearest);
    let found = field.irradiance(&point, -away.normalize(), &mut Looks::default());
    let cos = 4.0 / away.length();
    let solid_angle = (0.5 * 2.0 * 1.001 / f64::from(SIDE)).powi(2) * cos.powi(3);
    let expected = 1.0 / (solid_angle * away.length_squared());
    assert!(
        (found.mean() / expected - 1.0).abs() < 1e-12,
        "{found:?} {expected}"
    );
}

#[test]
fn only_the_side_that_faces_the_light_is_lit() {
    let scene = scene_of(&over_floor("", 4));
    let view = floor_view(&scene);
    let field = one_texel(view, [40, 17], Lookup::Bilinear);
    let point = on_floor(&view, DVec2::new(40.5, 17.5));
    let mut looks = Looks::default();
    let back = field.irradiance(&point, -DVec3::Z, &mut looks);
    assert!(back.is_black(), "{back:?}");
    assert_eq!((looks.turned, looks.all()), (1, 1));
    let beside = on_floor(&view, DVec2::new(-3.0, 17.5));
    assert!(field.irradiance(&beside, DVec3::Z, &mut looks).is_black());
    assert_eq!((looks.outside, looks.all()), (1, 2));
    let dark = on_floor(&view, DVec2::new(10.5, 17.5));
    assert!(field.irradiance(&dark, DVec3::Z, &mut looks).is_black());
    assert_eq!((looks.dark, looks.all()), (1, 3));
    assert!(!field.irradiance(&point, DVec3::Z, &mut looks).is_black());
    assert_eq!((looks.lit, looks.all()), (1, 4));
}

#[test]
fn what_lies_below_the_depth_map_by_more_than_the_bias_is_in_shadow() {
    let lamp = r#"<emitter type="point"><point name="position" x="0" y="0" z="4"/><rgb name="intensity" value="1"/></emitter>"#;
    let scene = scene_of(&lit_by(lamp, "", 4));
    let view = floor_view(&scene);
    let (depths, _) = DepthMap::new(&Receivers::new(&scene), view, Precision::Exact);
    let mut field = one_texel(view, [40, 17], Lookup::Nearest);
    field.maps[0].depths = Some(depths);
    let [near, far] = view.range();
    let at = DVec2::new(40.5, 17.5);
    let below = |share: f64| {
        let mut point = on_floor(&view, at);
        let ray = view.ray(at);
        point.position += ray.direction / -ray.direction.z * (share * (far - near));
        let mut looks = Looks::default();
        let found = field.irradiance(&point, DVec3::Z, &mut looks);
        assert_eq!(looks.hidden, u64::from(found.is_black()));
        found.is_black()
    };
    assert!(!below(0.0) && !below(0.009) && below(0.011));
}
