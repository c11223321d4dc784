//! Small scenes of caustics volumes: glass under the sun as in the paper's Fig. 1, glass in glass, and light
//! that goes back.

use nephroid::internals::scene::Scene;

use super::approximation::{GLASS, scene_of};

/// A ball of glass of radius 0.5 around (0, 0, 1.7).
const BALL: &str = r#"<shape type="sphere"><point name="center" x="0" y="0" z="1.7"/>
    <float name="radius" value="0.5"/>"#;

/// A vertical sun of 1 W/m², a floor of 2 x 2 with `side` x `side` texels, and some shapes.
fn under_the_sun(shapes: &str, side: usize) -> Scene {
    scene_of(&format!(
        r#"<scene version="3.0.0">
        <emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/>
            <rgb name="irradiance" value="1, 1, 1"/></emitter>
        {shapes}
        <shape type="rectangle"><bsdf type="diffuse"/>
            <sensor type="irradiancemeter" id="floor"><film type="hdrfilm">
                <integer name="width" value="{side}"/><integer name="height" value="{side}"/>
                <rfilter type="box"/></film></sensor>
        </shape></scene>"#
    ))
}

/// The glass ball of Fig. 1 under a vertical sun, and, if asked for, a glass box of 0.7 x 0.7 x 0.4 below it,
/// 20 cm apart. The box is in the ball's shadow: it has no light but the ball's.
pub fn ball_over(has_box: bool, side: usize) -> Scene {
    let below = if has_box {
        format!(
            r#"<shape type="cube"><transform name="to_world"><scale x="0.35" y="0.35" z="0.2"/>
                <translate z="0.8"/></transform>{GLASS}</shape>"#
        )
    } else {
        String::new()
    };
    under_the_sun(&format!("{BALL}{GLASS}</shape>{below}"), side)
}

/// A glass ball with a ball of index 2.4 of half its radius in it: glass in glass.
pub fn ball_in_ball(side: usize) -> Scene {
    under_the_sun(
        &format!(
            r#"{BALL}{GLASS}</shape>
            <shape type="sphere"><point name="center" x="0" y="0" z="1.7"/><float name="radius" value="0.25"/>
                <bsdf type="dielectric"><float name="int_ior" value="2.4"/><float name="ext_ior" value="1.5"/></bsdf>
            </shape>"#
        ),
        side,
    )
}

/// A glass ball over a mirror under a lamp, and a ceiling above the lamp with `side` x `side` texels, which
/// has only light that goes back.
pub fn ball_below_ceiling(side: usize) -> Scene {
    scene_of(&format!(
        r#"<scene version="3.0.0">
        <emitter type="spot"><transform name="to_world">
                <lookat origin="0.3, 0, 3" target="0, 0, 1" up="0, 1, 0"/></transform>
            <rgb name="intensity" value="10, 10, 10"/>
            <float name="cutoff_angle" value="20"/><float name="beam_width" value="18"/></emitter>
        <shape type="sphere"><point name="center" x="0" y="0" z="1.1"/><float name="radius" value="0.5"/>{GLASS}
        </shape>
        <shape type="rectangle"><transform name="to_world"><scale x="0.8" y="0.8"/><translate z="0.4"/></transform>
            <bsdf type="conductor"><string name="material" value="none"/></bsdf></shape>
        <shape type="rectangle"><transform name="to_world"><scale x="4" y="4"/><rotate x="1" angle="180"/>
                <translate z="3.5"/></transform><bsdf type="diffuse"/>
            <sensor type="irradiancemeter" id="ceiling"><film type="hdrfilm">
                <integer name="width" value="{side}"/><integer name="height" value="{side}"/>
                <rfilter type="box"/></film></sensor>
        </shape></scene>"#
    ))
}
