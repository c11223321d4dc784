//! Sensors that see next to nothing of the light: what falls where they look is found, and bounds hold there.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec2;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::closed_form::{GlassBall, KnownPath, TexelRect};
use nephroid::internals::run::{Estimate, LayerName};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::camera::Camera;

use crate::support::scenes::bundled_file;
use crate::support::seen::{by_beams, sensor};

/// Texels or pixels a side.
const SIDE: usize = 8;

/// Where on the floor of the glass ball the sensors look \[m\]: in the light of one smooth sheet, beside any
/// fold.
const PLACE: DVec2 = DVec2::new(0.2, 0.1);

/// Landings are sums and products of coordinates of up to some 4 m, over fewer than 32 operations that each
/// round to half an epsilon: they are off by no more than this \[m\], and so are edges of texels and pixels.
const ROUNDING: f64 = 32.0 * 4.0 * 0.5 * f64::EPSILON;

fn film(width: usize, offset: usize) -> String {
    format!(
        r#"<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{width}"/>
  <integer name="crop_offset_x" value="{offset}"/><integer name="crop_offset_y" value="{offset}"/>
  <integer name="crop_width" value="{SIDE}"/><integer name="crop_height" value="{SIDE}"/><rfilter type="box"/></film>"#
    )
}

/// The shipped glass ball, with more in the scene.
fn with(more: &str) -> Scene {
    let xml = std::fs::read_to_string(bundled_file("glass-ball")).unwrap();
    of(&xml.replace("</scene>", &format!("{more}</scene>")))
}

fn of(xml: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, xml).unwrap();
    Scene::new(nephroid::internals::mitsuba::load_parts(&file, &[]).unwrap()).unwrap()
}

/// A finished run of beams to an error.
fn beams(scene: &Scene, id: &str, relative_error: f64) -> Estimate {
    let (estimate, _) = by_beams(scene, id, relative_error);
    assert!(!estimate.incomplete);
    estimate
}

/// Every texel of every layer is within its bounds, by the closed forms of the ball's sheets over what
/// `texel` says, times `scale`; `LTTD` is among them. Returns the error of `LTTD`, root mean square over texels
/// and the largest, and the largest half width of its bounds, relative.
fn assert_known(
    name: &str,
    estimate: &Estimate,
    scale: f64,
    texel: impl Fn(usize) -> TexelRect,
) -> [f64; 3] {
    let mut through = None;
    for layer in &estimate.layers {
        let LayerName::Path(signature) = layer.name else {
            continue;
        };
        let events = signature.to_string();
        let inside = events
            .strip_prefix("LT")
            .and_then(|one| one.strip_suffix("TD"));
        let Some(reflections) = inside else {
            continue;
        };
        let sheet = GlassBall::SHIPPED.sheet(KnownPath::Through(reflections.len() as u32));
        let bounds = layer.interval.as_ref().unwrap();
        let (mut squares, mut worst, mut width) = (0.0_f64, 0.0_f64, 0.0_f64);
        for index in 0..SIDE * SIDE {
            let texel = texel(index);
            let truth = scale * sheet.texel_irradiance(&texel);
            let side = (texel.max - texel.min).min_element();
            // What rounding moves across a texel's edges; the quadrature of the closed form is good to 1e-9.
            let rounding = truth * (1e-9 + 4.0 * ROUNDING / side);
            let (low, high) = (bounds.low[index].0[0], bounds.high[index].0[0]);
            assert!(
                low - rounding <= truth && truth <= high + rounding,
                "{name}, {signature}, texel {index}: {truth} is not in {low} .. {high}"
            );
            width = width.max(0.5 * (high - low) / truth);
            let error = (layer.values[index].0[0] - truth).abs() / truth;
            squares += error * error;
            worst = worst.max(error);
        }
        let off = (squares / (SIDE * SIDE) as f64).sqrt();
        println!("{name}, {signature}: off by {off:.1e}, {worst:.1e} at most, bounds {width:.1e}");
        if reflections.is_empty() {
            through = Some([off, worst, width]);
        }
    }
    through.expect("LTTD is found")
}

/// A camera so far above the floor, looking down: L = ρ/π E, averaged over what a pixel sees. From 1e-7 m it
/// sees a part of some 1e-15 of the light.
#[test]
fn a_camera_ever_nearer_to_a_floor_sees_what_falls_there() {
    for exponent in 1..=7 {
        let height = 10_f64.powi(-exponent);
        let scene = with(&format!(
            r#"<sensor type="perspective" id="near"><float name="fov" value="38"/><float name="near_clip" value="1e-9"/>
  <transform name="to_world"><lookat origin="{x},{y},{height}" target="{x},{y},-1" up="0,1,0"/></transform>{}</sensor>"#,
            film(SIDE, 0),
            x = PLACE.x,
            y = PLACE.y,
        ));
        let camera = Camera::new(&scene, sensor(&scene, "near")).unwrap();
        let on_floor = |at: DVec2| {
            let ray = camera.pixel_ray(at).ray;
            ray.at(-ray.origin.z / ray.direction.z).truncate()
        };
        let pixel = |index: usize| {
            let corner = DVec2::new((index % SIDE) as f64, (index / SIDE) as f64);
            let (a, b) = (on_floor(corner), on_floor(corner + 1.0));
            let (low, high) = (a.min(b), a.max(b));
            TexelRect::new(low.x, low.y, high.x, high.y)
        };
        let estimate = beams(&scene, "near", 0.01);
        let name = format!("{height:e} m");
        // The floor's reflectance is 0.8.
        let [off, worst, width] = assert_known(&name, &estimate, 0.8 * FRAC_1_PI, pixel);
        // An error of 1 % was asked for, root mean square over texels. Bounds are some ten times as wide, where
        // there are few cells.
        assert!(
            off < 0.01 && worst < 0.02 && width < 0.2,
            "{off} {worst} {width}"
        );
    }
}

/// Eight texels of films ever finer over the same floor.
#[test]
fn a_crop_of_an_ever_finer_film_has_the_light_of_its_place() {
    for exponent in [8, 12, 16, 20] {
        let width = 1_usize << exponent;
        // (u, v) = (0, 0) is at −2 m.
        let offset = (0.25 * (PLACE + 2.0) * width as f64).as_usizevec2();
        let xml = std::fs::read_to_string(bundled_file("glass-ball")).unwrap();
        let (before, rest) = xml.split_once("<film").unwrap();
        let (_, after) = rest.split_once("</film>").unwrap();
        let scene = of(&format!("{before}{}{after}", film(width, offset.x)));
        let texel = |index: usize| {
            let size = 4.0 / width as f64;
            let at = DVec2::new(
                (offset.x + index % SIDE) as f64,
                (offset.x + index / SIDE) as f64,
            );
            let low = at * size - 2.0;
            TexelRect::new(low.x, low.y, low.x + size, low.y + size)
        };
        let estimate = beams(&scene, "floor", 0.01);
        let name = format!("{width} texels");
        let [off, worst, _] = assert_known(&name, &estimate, 1.0, texel);
        // As it was asked for; twice that on no texel of smooth light.
        assert!(off < 0.01 && worst < 0.02, "{off} {worst}");
    }
}

/// A diffuse bead in the light of the ball: what it gets is the light that a point there would get, by its
/// radius squared, as soon as it is small.
#[test]
fn a_bead_ever_smaller_gets_the_light_of_its_place() {
    let mut smallest: Option<[f64; 2]> = None;
    for exponent in (3..=7).rev() {
        let radius = 10_f64.powi(-exponent);
        let scene = with(&format!(
            r#"<shape type="sphere"><point name="center" x="0.2" y="0.1" z="0.2"/><float name="radius" value="{radius}"/>
  <bsdf type="diffuse"/><sensor type="irradiancemeter" id="bead">{}</sensor></shape>"#,
            film(SIDE, 0)
        ));
        let estimate = beams(&scene, "bead", 0.01);
        let bounds = estimate.total.interval.as_ref().unwrap();
        // Belts of a sphere between polar angles a and b: 2π r² (cos a − cos b), divided among texels.
        let share = |index: usize| {
            let angle = |row: usize| PI * row as f64 / SIDE as f64;
            let row = index / SIDE;
            2.0 / SIDE as f64 * (angle(row).cos() - angle(row + 1).cos())
        };
        let across = |values: &[Rgb]| -> f64 {
            values
                .iter()
                .enumerate()
                .map(|(index, value)| value.0[0] * share(index))
                .sum()
        };
        let [low, high] = [across(&bounds.low), across(&bounds.high)];
        println!(
            "{radius:e} m: {} in {low} .. {high} W/m²",
            across(&estimate.total.values)
        );
        assert!(low > 0.5 * high, "bounds are no bounds");
        let [from, to] = *smallest.get_or_insert([low, high]);
        // Over a disc of radius r the mean of a smooth function differs from that of its centre by r²/8 of
        // its second derivatives: the sheet's light falls off over some 0.1 m, so that (r/0.1)² is to spare.
        let bent = (radius / 0.1).powi(2) * high;
        assert!(
            low <= to + bent && from <= high + bent,
            "{low} .. {high}, but {from} .. {to}"
        );
    }
}

/// The same behind flat glass, in the sun: every texel is known. E = (1 − F)² E₀ max(0, n · l), averaged over
/// a texel.
#[test]
fn a_bead_ever_smaller_below_a_pane_gets_what_the_pane_lets_through() {
    for exponent in 2..=6 {
        let radius = 10_f64.powi(-exponent);
        let scene = of(&format!(
            r#"<scene version="3.0.0"><emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/>
  <rgb name="irradiance" value="1"/></emitter>
  <shape type="cube"><transform name="to_world"><scale x="1" y="1" z="0.1"/><translate z="0.9"/></transform>
  <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>
  <shape type="sphere"><point name="center" x="0.31" y="0.17" z="0.2"/><float name="radius" value="{radius}"/>
  <bsdf type="diffuse"/><sensor type="irradiancemeter" id="bead">{}</sensor></shape></scene>"#,
            film(SIDE, 0)
        ));
        let estimate = beams(&scene, "bead", 0.01);
        let wanted = LayerName::Path("LTTD".parse().unwrap());
        let layer = estimate.layers.iter().find(|layer| layer.name == wanted);
        let layer = layer.expect("light goes straight through");
        let bounds = layer.interval.as_ref().unwrap();
        let passed = (1.0 - dielectric_reflectance(1.0, 1.5)).powi(2);
        for index in 0..SIDE * SIDE {
            // The mean of cos θ over a belt is that of its ends' cosines.
            let angle = |row: usize| PI * row as f64 / SIDE as f64;
            let row = index / SIDE;
            let truth = passed * (0.5 * (angle(row).cos() + angle(row + 1).cos())).max(0.0);
            let (low, high) = (bounds.low[index].0[0], bounds.high[index].0[0]);
            // By rounding, belts lie elsewhere by a part of the bead.
            let rounding = 1e-9 + 4.0 * ROUNDING / radius;
            assert!(
                low - rounding <= truth && truth <= high + rounding,
                "{radius:e} m, texel {index}: {truth} is not in {low} .. {high}"
            );
        }
    }
}

/// The back of the floor gets no light, but a discovery of thousands of paths cannot know: what it may have missed is in the bounds.
#[test]
fn darkness_has_a_bar_where_light_was_looked_for_in_vain() {
    let xml = std::fs::read_to_string(bundled_file("glass-ball")).unwrap();
    let turned = xml.replace(
        r#"<scale x="2" y="2"/>"#,
        r#"<scale x="2" y="2"/><rotate x="1" angle="180"/>"#,
    );
    let (before, rest) = turned.split_once("<film").unwrap();
    let (_, after) = rest.split_once("</film>").unwrap();
    let scene = of(&format!("{before}{}{after}", film(SIDE, 0)));
    let estimate = beams(&scene, "floor", 0.01);
    let bounds = estimate.total.interval.as_ref().unwrap();
    let area = (4.0 / SIDE as f64).powi(2);
    for index in 0..SIDE * SIDE {
        assert_eq!(estimate.total.values[index].0[0], 0.0);
        assert_eq!(bounds.low[index].0[0], 0.0);
        // (1 − p/2)ⁿ = 5e-4 for n = 2¹³ + 2¹⁴ + 2¹⁵ places: p = 2.65e-4 of the ball's light, here to a tenth.
        let unseen = bounds.high[index].0[0] * area / GlassBall::SHIPPED.intercepted_flux();
        assert!((2.4e-4..2.9e-4).contains(&unseen), "{unseen}");
    }
    // Without the ball there is nothing to look for.
    let (before, rest) = turned.split_once(r#"<shape type="sphere""#).unwrap();
    let (_, after) = rest.split_once("</shape>").unwrap();
    let scene = of(&format!("{before}{after}"));
    let estimate = beams(&scene, "floor", 0.01);
    let bounds = estimate.total.interval.as_ref().unwrap();
    assert!(bounds.high.iter().all(|high| high.is_black()));
}
