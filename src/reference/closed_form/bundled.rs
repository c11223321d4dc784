//! The bundled scenes, and the closed form of each.

use std::f64::consts::TAU;

use glam::DVec3;

use super::block::block;
use super::{
    AxialLight, AxialSpot, CupLight, FlatFacets, GlassBall, KnownPath, MirrorCup, ParabolicMirror,
    ParallelLight, PlanoConvexLens, TexelGrid,
};
use crate::generate::{BrilliantCut, equilateral_prism, round_brilliant};
use crate::geometry::MeshParts;
use crate::numeric::math;
use crate::numeric::rotation;

/// The closed form of one bundled scene's receiver.
#[derive(Clone, Debug)]
pub struct Bundled {
    /// As in [`generate::SCENES`](crate::generate::SCENES).
    pub scene: &'static str,
    /// The receiver is [−half, half]² about the z axis, rows along y (the scene's units).
    pub receiver_half_width: f64,
    /// The paths that are known, the strongest first or in order of their length.
    pub paths: Vec<KnownPath>,
    /// True if the scene is a mesh of a curved surface, which the closed form knows only as the limit of
    /// finer ones.
    pub up_to_facets: bool,
    form: KnownForm,
}

#[derive(Clone, Debug)]
enum KnownForm {
    Ball(GlassBall),
    Cup(MirrorCup),
    Facets(Box<FlatFacets>),
    Lens(PlanoConvexLens, AxialSpot),
    /// One a channel.
    Dish([ParabolicMirror; 3]),
}

impl Bundled {
    /// All bundled scenes whose texels are known, every path of them up to `most_reflections`.
    pub fn all(most_reflections: u32) -> Vec<Self> {
        let through = |path: fn(u32) -> KnownPath, from: u32| (from..=most_reflections).map(path);
        let body: Vec<KnownPath> = [KnownPath::Direct, KnownPath::Reflected(1)]
            .into_iter()
            .chain(through(KnownPath::Through, 0))
            .collect();
        let mirror: Vec<KnownPath> = [KnownPath::Direct]
            .into_iter()
            .chain(through(KnownPath::Reflected, 1))
            .collect();
        let known = |scene, receiver_half_width, paths: &[KnownPath], up_to_facets, form| Self {
            scene,
            receiver_half_width,
            paths: paths.to_vec(),
            up_to_facets,
            form,
        };
        let facets = |mesh: &MeshParts, ior, x, y, irradiance| {
            let direction = DVec3::new(x, y, -1.0).normalize();
            FlatFacets::new(
                mesh,
                ior,
                ParallelLight {
                    direction,
                    irradiance,
                },
                most_reflections,
            )
            .ok()
            .map(|solved| KnownForm::Facets(Box::new(solved)))
        };
        // The sun of the turntables: 60° above the horizon, 30° from the x axis.
        let turned = |mesh: &MeshParts| {
            let (sin, cos) = math::sin_cos(30.0_f64.to_radians());
            let across = math::tan(60.0_f64.to_radians()).recip();
            facets(mesh, 1.5, -across * cos, -across * sin, 10.0)
        };
        let mut all = vec![
            known(
                "glass-ball",
                2.0,
                &body,
                false,
                KnownForm::Ball(GlassBall::SHIPPED),
            ),
            known(
                "glass-ball-mesh",
                2.0,
                &body,
                true,
                KnownForm::Ball(GlassBall::SHIPPED),
            ),
            known(
                "coffee-cup",
                4.0,
                &mirror,
                false,
                KnownForm::Cup(COFFEE_CUP),
            ),
            known(
                "mirror-ring",
                2.0,
                &mirror,
                false,
                KnownForm::Cup(MIRROR_RING),
            ),
            known(
                "lens",
                0.08,
                &[KnownPath::Direct, KnownPath::Through(0)],
                true,
                KnownForm::Lens(LENS, LENS_LAMP),
            ),
            known(
                "parabolic-mirror",
                0.08,
                &[KnownPath::Reflected(1)],
                true,
                KnownForm::Dish(DISH),
            ),
        ];
        // These solids are convex and above the floor, so none is left out; a test counts them.
        let cut = [
            ("prism", 0.25, facets(&prism(), 1.5, 0.0, 0.0, 1000.0)),
            ("cube", 2.0, facets(&cube(), 1.5, 0.5, 0.2, 1000.0)),
            ("diamond", 1.2, facets(&diamond(), 2.418, 0.3, 0.1, 1000.0)),
            ("turntable-cube", 3.0, turned(&turntable_cube())),
            ("turntable-prism", 3.0, turned(&turntable_prism())),
        ];
        all.extend(
            cut.into_iter()
                .filter_map(|(scene, half, form)| Some(known(scene, half, &body, false, form?))),
        );
        all
    }

    /// The irradiance (W/m²) of every texel of `side`² over the receiver, by one path, in one channel (0, 1
    /// or 2: red, green, blue), rows from smallest y.
    pub fn map(&self, path: KnownPath, side: usize, channel: usize) -> Vec<f64> {
        let grid = TexelGrid::square(self.receiver_half_width, side);
        match (&self.form, path) {
            (KnownForm::Ball(ball), _) => ball.sheet(path).map(&grid),
            (KnownForm::Cup(cup), _) => cup.map(path, &grid),
            (KnownForm::Facets(solid), _) => solid.map(path, &grid),
            (KnownForm::Lens(_, lamp), KnownPath::Direct) => {
                let [middle, border] = lamp.sheets();
                grid.map(|texel| middle.texel_irradiance(texel) + border.texel_irradiance(texel))
            }
            (KnownForm::Lens(lens, _), KnownPath::Through(0)) => lens.sheet().map(&grid),
            (KnownForm::Dish(dishes), KnownPath::Reflected(1)) => dishes[channel.min(2)].map(&grid),
            (KnownForm::Lens(..) | KnownForm::Dish(_), _) => vec![0.0; side * side],
        }
    }
}

const COFFEE_CUP: MirrorCup = MirrorCup {
    radius: 4.0,
    height: 8.0,
    reflectance: 1.0,
    // (0.6, 0, -1): the irradiance is across the light.
    light: CupLight::Parallel {
        tan_angle: 0.6,
        irradiance: 1000.0,
    },
};

const MIRROR_RING: MirrorCup = MirrorCup {
    radius: 1.0,
    height: 0.6,
    reflectance: 1.0,
    light: CupLight::Point {
        distance: 1.0,
        height: 1.0,
        intensity: 10.0,
    },
};

const LENS: PlanoConvexLens = PlanoConvexLens {
    curvature: 0.06,
    aperture: 0.05,
    flat_height: 0.06,
    ior: 1.5,
    light: AxialLight::Point {
        height: 0.56,
        intensity: 10.0,
    },
};

const LENS_LAMP: AxialSpot = AxialSpot {
    height: 0.56,
    intensity: 10.0,
    cutoff_angle: 8.5 * TAU / 360.0,
    beam_width: 7.0 * TAU / 360.0,
    // atan(0.05 / 0.5): the rim seen from the lamp.
    blocked_angle: 0.09966865249116204,
};

const DISH: [ParabolicMirror; 3] = [dish(1.66, 9.22), dish(0.88, 6.27), dish(0.52, 4.84)];

const fn dish(eta: f64, k: f64) -> ParabolicMirror {
    ParabolicMirror {
        focal_length: 0.5,
        aperture: 0.5,
        receiver_height: 0.45,
        irradiance: 1000.0,
        shade_half_width: 0.08,
        eta,
        k,
    }
}

fn prism() -> MeshParts {
    let mut mesh = equilateral_prism(0.1, 0.2);
    let (sin, cos) = math::sin_cos(18.590378_f64.to_radians());
    for position in &mut mesh.positions {
        // A quarter turn about x, then about y.
        let (x, y, z) = (position.x, -position.z, position.y);
        *position = DVec3::new(cos * x + sin * z, y, cos * z - sin * x + 0.15);
    }
    mesh
}

fn cube() -> MeshParts {
    let mut mesh = block(DVec3::splat(-0.5), DVec3::splat(0.5));
    let (sin, cos) = math::sin_cos(20.0_f64.to_radians());
    for position in &mut mesh.positions {
        let DVec3 { x, y, z } = *position;
        *position = DVec3::new(cos * x - sin * y, sin * x + cos * y, z + 0.75);
    }
    mesh
}

fn diamond() -> MeshParts {
    let mut mesh = round_brilliant(0.325, BrilliantCut::TOLKOWSKY);
    let (sin, cos) = math::sin_cos(165.0_f64.to_radians());
    for position in &mut mesh.positions {
        let (x, z) = (position.x, position.z);
        *position = DVec3::new(cos * x + sin * z, position.y, cos * z - sin * x + 0.4);
    }
    mesh
}

fn turntable_cube() -> MeshParts {
    let mut mesh = block(DVec3::splat(-0.57), DVec3::splat(0.57));
    let turn = rotation::about(DVec3::Y, 15.0_f64.to_radians())
        * rotation::about(DVec3::X, 25.0_f64.to_radians());
    for position in &mut mesh.positions {
        *position = turn * *position + DVec3::new(0.0, 0.0, 1.2);
    }
    mesh
}

fn turntable_prism() -> MeshParts {
    let mut mesh = equilateral_prism(1.0, 1.6);
    for position in &mut mesh.positions {
        // A quarter turn about x, then one about −y.
        let (x, y, z) = (position.x, -position.z, position.y);
        *position = DVec3::new(-z, y, x + 0.7);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::SCENES;

    #[test]
    fn all_scenes_but_panes_waters_boxes_and_round_turntables_are_known() {
        let known = Bundled::all(1);
        let unknown: Vec<&str> = SCENES
            .iter()
            .map(|scene| scene.name)
            .filter(|name| !known.iter().any(|bundled| bundled.scene == *name))
            .collect();
        assert_eq!(
            unknown,
            [
                "glass-ball-behind-pane",
                "water",
                "pool",
                "rainbow",
                "cornell-glass",
                "cornell-caustics",
                "turntable-ball",
                "turntable-ring",
                "turntable-bumpy",
                "turntable-terrain"
            ]
        );
    }

    #[test]
    fn every_known_map_is_finite_and_not_negative_and_the_first_is_not_dark() {
        for bundled in Bundled::all(2) {
            for (i, &path) in bundled.paths.iter().enumerate() {
                let map = bundled.map(path, 16, 0);
                assert!(
                    map.iter().all(|e| e.is_finite() && *e >= -1e-9 * 1000.0),
                    "{} {path:?}",
                    bundled.scene
                );
                assert!(
                    i > 0 || map.iter().any(|e| *e > 0.0),
                    "{} {path:?}",
                    bundled.scene
                );
            }
        }
    }

    #[test]
    fn the_lenss_lamp_is_blocked_by_its_rim() {
        assert!((LENS_LAMP.blocked_angle - LENS.rim_angle()).abs() < 1e-15);
        assert!(
            LENS_LAMP.beam_width > LENS.rim_angle(),
            "the lens sees a point of constant intensity"
        );
    }

    fn holds(name: &str, texts: &[&str]) {
        let scene = SCENES.iter().find(|scene| scene.name == name).unwrap();
        for text in texts {
            assert!(scene.xml().contains(text), "{name}: {text}");
        }
    }

    #[test]
    fn the_scene_files_hold_these_numbers() {
        let sun = r#"<rgb name="irradiance" value="1000, 1000, 1000"/>"#;
        let ball = [
            r#"<point name="position" x="0" y="0" z="4"/>"#,
            r#"<rgb name="intensity" value="100, 100, 100"/>"#,
            r#"z="1.4"/>"#,
            r#"<float name="int_ior" value="1.5"/>"#,
            r#"<scale x="2" y="2"/>"#,
        ];
        holds("glass-ball", &ball);
        holds("glass-ball-mesh", &ball);
        holds(
            "coffee-cup",
            &[
                sun,
                r#"x="0.6" y="0" z="-1""#,
                r#"z="8"/>"#,
                r#"value="4"/>"#,
                "none",
            ],
        );
        holds(
            "mirror-ring",
            &[
                r#"x="-1" y="0" z="1""#,
                "10, 10, 10",
                r#"z="0.6"/>"#,
                r#"x="2" y="2""#,
            ],
        );
        holds(
            "prism",
            &[
                sun,
                r#"angle="18.590378""#,
                r#"<translate z="0.15"/>"#,
                r#"<scale x="0.25" y="0.25"/>"#,
            ],
        );
        holds(
            "cube",
            &[
                sun,
                r#"x="0.5" y="0.2" z="-1""#,
                r#"angle="20""#,
                r#"<translate z="0.75"/>"#,
            ],
        );
        holds(
            "diamond",
            &[
                sun,
                r#"x="0.3" y="0.1" z="-1""#,
                r#"angle="165""#,
                r#"<translate z="0.4"/>"#,
                "2.418",
            ],
        );
        holds(
            "lens",
            &[
                r#"origin="0, 0, 0.56""#,
                "10, 10, 10",
                r#"value="8.5"/>"#,
                r#"value="7"/>"#,
                r#"<translate z="0.06"/>"#,
            ],
        );
        holds(
            "parabolic-mirror",
            &[
                sun,
                "1.66, 0.88, 0.52",
                "9.22, 6.27, 4.84",
                r#"<translate z="0.45"/>"#,
            ],
        );
    }

    #[test]
    fn the_turntables_files_hold_these_numbers() {
        let turned = [
            r#"<default name="azimuth" value="30"/>"#,
            r#"<default name="elevation" value="60"/>"#,
        ];
        holds("turntable-cube", &turned);
        holds(
            "turntable-cube",
            &[
                r#"<scale value="0.57"/>"#,
                r#"<rotate x="1" angle="25"/>"#,
                r#"<rotate y="1" angle="15"/>"#,
                r#"<default name="drop" value="1.2"/>"#,
            ],
        );
        holds("turntable-prism", &turned);
        holds(
            "turntable-prism",
            &[
                r#"<rotate y="-1" angle="90"/>"#,
                r#"<default name="drop" value="0.7"/>"#,
            ],
        );
    }
}
