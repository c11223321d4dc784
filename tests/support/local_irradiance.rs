//! Shared parts of the tests of local precomputed irradiance: the technique with some settings, and a glass
//! ball in parallel light in closed form.

use std::f64::consts::PI;

use glam::DVec2;
use nephroid::internals::approximation::local_irradiance::{LocalIrradiance, Settings};
use nephroid::internals::method::Method;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::scene::Scene;

use super::approximation::{GLASS, scene_of};
#[allow(unused_imports, reason = "every program uses its own part of this")]
pub use super::technique::{rendered, texels};
use super::technique::{technique, values};

/// All stages exact, but for the number of photons.
pub const EXACT: [(&str, &str); 8] = [
    ("light", "exact"),
    ("scene", "exact"),
    ("directions", "exact"),
    ("deposit", "exact"),
    ("space", "exact"),
    ("region", "exact"),
    ("normal", "exact"),
    ("storage", "exact"),
];

/// Tables with some settings.
pub fn tables(settings: &[(&str, &str)]) -> Method {
    technique("local-irradiance", settings)
}

/// Settings of tables, checked.
pub fn settings(given: &[(&str, &str)]) -> Settings {
    Settings::of(&values(&LocalIrradiance, given)).unwrap()
}

/// Tables with all stages exact but for some settings.
pub fn exact_but(settings: &[(&str, &str)]) -> Method {
    tables(&[&EXACT, settings].concat())
}

/// A sun of 1 W/m² from a direction.
pub fn sun([x, y, z]: [f64; 3]) -> String {
    format!(
        r#"<emitter type="directional"><vector name="direction" x="{x}" y="{y}" z="{z}"/>
           <rgb name="irradiance" value="1, 1, 1"/></emitter>"#
    )
}

/// A glass ball of radius 1 at the origin, n = 1.5.
pub fn glass_ball() -> String {
    format!(r#"<shape type="sphere" id="ball">{GLASS}</shape>"#)
}

/// Objects in a sun, over a square meter of `half` to each side at some depth below the origin.
pub fn over_depth(
    direction: [f64; 3],
    objects: &str,
    [depth, half]: [f64; 2],
    side: usize,
) -> Scene {
    scene_of(&format!(
        r#"<scene version="3.0.0">
        {}
        {objects}
        <shape type="rectangle" id="floor">
            <transform name="to_world"><scale x="{half}" y="{half}"/><translate z="{}"/></transform>
            <bsdf type="diffuse"/>
            <sensor type="irradiancemeter">
                <film type="hdrfilm">
                    <integer name="width" value="{side}"/><integer name="height" value="{side}"/>
                    <rfilter type="box"/>
                </film>
            </sensor>
        </shape></scene>"#,
        sun(direction),
        -depth
    ))
}

/// Light that leaves a glass ball (radius 1, n = 1.5) of a ray of parallel light along −z, in the ray's own
/// plane: x across, y = z.
#[derive(Clone, Copy, Debug)]
pub struct Exit {
    /// Where it leaves.
    pub from: DVec2,
    /// Where it goes, a unit vector.
    pub direction: DVec2,
    /// Its share of the ray's light.
    pub share: f64,
}

impl Exit {
    /// Where it crosses the sphere of some radius.
    pub fn at_radius(&self, radius: f64) -> DVec2 {
        let along = self.from.dot(self.direction);
        let square = along * along - self.from.length_squared() + radius * radius;
        self.from + self.direction * (square.sqrt() - along)
    }

    /// Where it crosses the plane at a depth, if it does.
    pub fn at_depth(&self, depth: f64) -> Option<DVec2> {
        let length = (-depth - self.from.y) / self.direction.y;
        (self.direction.y < 0.0).then(|| self.from + self.direction * length)
    }
}

/// The light that leaves of a ray at an angle of incidence \[rad\]: LRD, and LTRᵏTD of up to 16 events.
pub fn exits(incidence: f64) -> Vec<Exit> {
    const IOR: f64 = 1.5;
    let (sine, cosine) = incidence.sin_cos();
    let reflected = dielectric_reflectance(cosine, IOR);
    let inside = (sine / IOR).asin();
    let at = |angle: f64| DVec2::new(angle.sin(), angle.cos());
    // Angles are from +z. A ray that leaves at the angle a with the exit angle i goes along a + i.
    let mut all = vec![Exit {
        from: at(incidence),
        direction: at(2.0 * incidence),
        share: reflected,
    }];
    let mut share = (1.0 - reflected) * (1.0 - reflected);
    let mut angle = incidence;
    for _ in 0..15 {
        angle += PI - 2.0 * inside;
        all.push(Exit {
            from: at(angle),
            direction: at(angle + incidence),
            share,
        });
        share *= reflected;
    }
    all
}

/// Calls `visit(exit, flux)` for the light of a ball in parallel light of 1 W/m², by rays evenly over its
/// cross section.
pub fn each_exit(rays: u32, mut visit: impl FnMut(&Exit, f64)) {
    for ray in 0..rays {
        let sine = ((f64::from(ray) + 0.5) / f64::from(rays)).sqrt();
        for exit in exits(sine.asin()) {
            visit(&exit, exit.share * PI / f64::from(rays));
        }
    }
}

/// Flux density outward through the sphere of some radius, in `bins` of the cosine to the light, from −1.
pub fn outward_density(radius: f64, bins: usize) -> Vec<f64> {
    let area = 4.0 * PI * radius * radius / bins as f64;
    let mut density = vec![0.0; bins];
    each_exit(1_000_000, |exit, flux| {
        let cosine = exit.at_radius(radius).y / radius;
        let bin = ((cosine + 1.0) / 2.0 * bins as f64) as usize;
        density[bin.min(bins - 1)] += flux / area;
    });
    density
}
