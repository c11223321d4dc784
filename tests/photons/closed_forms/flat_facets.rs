//! Light through flat facets: the cube, the prism, the diamond.

use glam::DVec3;
use nephroid::internals::geometry::{MeshParts, Shape};
use nephroid::internals::reference::closed_form::{
    FlatFacets, KnownPath, ParallelLight, TexelGrid,
};
use nephroid::internals::run::LayerName;
use nephroid::internals::scene::Scene;

use super::bars::{REGIONS, assert_direct_light_is_within_its_bound};
use crate::support::{Compared, Photons, bundled};

/// The one mesh of a scene that refracts, in world space, and the closed form of its light.
fn facets(scene: &Scene, direction: DVec3, ior: f64, most_reflections: u32) -> FlatFacets {
    let mesh = scene
        .world()
        .shapes()
        .iter()
        .find_map(|shape| match shape {
            Shape::Mesh(mesh) => Some(mesh),
            _ => None,
        })
        .unwrap();
    let parts = MeshParts {
        positions: mesh.positions().to_vec(),
        triangles: mesh.triangles().to_vec(),
        ..MeshParts::default()
    };
    let light = ParallelLight {
        direction: direction.normalize(),
        irradiance: 1000.0,
    };
    FlatFacets::new(&parts, ior, light, most_reflections).unwrap()
}

/// A bundled scene of one convex solid with flat facets in sunlight.
struct Facets {
    name: &'static str,
    /// Half width of the floor [m].
    half_width: f64,
    /// Direction of the sunlight; any length.
    direction: DVec3,
    ior: f64,
    /// Most reflections inside that the closed form follows.
    most_reflections: u32,
}

impl Facets {
    /// Every layer of the estimate is one that the closed form has, and agrees with it in every region; at
    /// least `least` regions of all layers together can be judged.
    fn assert_agree(&self, side: usize, least: usize) {
        let scene = bundled(self.name, side);
        let grid = TexelGrid::square(self.half_width, side);
        let solid = facets(&scene, self.direction, self.ior, self.most_reflections);
        let photons = Photons::new(1 << 20);
        let estimate = photons.estimate(&scene);
        let mut judged = 0;
        for found in &estimate.layers {
            let LayerName::Path(signature) = found.name else {
                continue;
            };
            let text = signature.to_string();
            let path = (0..signature.len() as u32)
                .map(KnownPath::Through)
                .chain([KnownPath::Direct, KnownPath::Reflected(1)])
                .find(|path| path.signature() == text)
                .unwrap_or_else(|| panic!("a convex solid has no path {text}"));
            let truth = solid.map(path, &grid);
            if path == KnownPath::Direct {
                assert_direct_light_is_within_its_bound(&estimate, &truth);
            } else if signature.len() as u32 <= self.most_reflections + 2 {
                let it = Compared::new(&scene, &photons, &estimate, &text, &truth);
                println!("{} {side}: {:?}", it.name, it.agreement());
                judged += it.judged().count();
                it.assert_regions(0);
                it.assert_darkness_is_exact(&grid, 0);
            }
        }
        assert!(judged >= least, "{}: {judged} regions judged", self.name);
    }
}

/// Through top and bottom the cube is a slab (lateral shift, Fresnel's series by signature); through
/// its sides light is totally reflected. All of it polygons.
#[test]
fn the_cubes_light_falls_into_the_right_regions_in_every_path() {
    let cube = Facets {
        name: "cube",
        half_width: 2.0,
        direction: DVec3::new(0.5, 0.2, -1.0),
        ior: 1.5,
        most_reflections: 14,
    };
    cube.assert_agree(1, 3);
    cube.assert_agree(REGIONS, 40);
}

/// At minimum deviation light crosses the prism along its base; each path lands in sharp-edged
/// polygons.
#[test]
fn the_prisms_light_falls_into_the_right_regions_in_every_path() {
    let prism = Facets {
        name: "prism",
        half_width: 0.25,
        direction: DVec3::NEG_Z,
        ior: 1.5,
        most_reflections: 14,
    };
    prism.assert_agree(1, 2);
    prism.assert_agree(REGIONS, 30);
}

/// A brilliant's light leaves after many total reflections, in hundreds of polygons.
#[test]
fn the_diamonds_light_falls_into_the_right_regions_in_every_path() {
    let diamond = Facets {
        name: "diamond",
        half_width: 1.2,
        direction: DVec3::new(0.3, 0.1, -1.0),
        ior: 2.418,
        most_reflections: 6,
    };
    diamond.assert_agree(1, 4);
    diamond.assert_agree(REGIONS, 15);
}
