//! The next surface of many rays.

use glam::DVec3;
use nephroid::internals::geometry::{Ray, TraversalCounters};
use nephroid::internals::transport::path_end::{next_hit, next_hits};

use crate::support::paths::scene;

/// Three squares on top of each other, the upper two at some places passed: by no surface, and by a mask.
const SCENE: &str = r#"
    <bsdf type="null" id="nothing"/>
    <bsdf type="mask" id="gone">
        <float name="opacity" value="0"/>
        <bsdf type="diffuse"/>
    </bsdf>
    <shape type="rectangle">
        <transform name="to_world"><translate x="-0.5" z="2"/></transform>
        <ref id="nothing"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><translate x="0.5" z="1"/></transform>
        <ref id="gone"/>
    </shape>
    <shape type="rectangle">
        <bsdf type="diffuse"/>
    </shape>"#;

#[test]
fn many_rays_meet_what_each_meets_beyond_what_is_passed() {
    let scene = scene(SCENE);
    let rays: Vec<Ray> = (0..64)
        .map(|i| {
            Ray::new(
                DVec3::new(0.05 * f64::from(i) - 1.575, 0.1, 3.0),
                DVec3::NEG_Z,
            )
        })
        .collect();
    let [mut together, mut alone] = [TraversalCounters::default(); 2];
    let found = next_hits(&scene, rays.iter().copied(), &mut together);
    let expected: Vec<_> = rays
        .iter()
        .map(|ray| next_hit(&scene, *ray, &mut alone))
        .collect();
    assert_eq!(found, expected);
    assert_eq!(together.rays, alone.rays);
    // To the lower square from the plane of what was passed last; none goes all the way.
    for (plane, many) in [(3.0, 0), (2.0, 10), (1.0, 30)] {
        let starts = |(ray, _): &&(Ray, _)| (ray.origin.z - plane).abs() < 1e-6;
        let from = found.iter().flatten().filter(starts);
        assert_eq!(from.count(), many, "from {plane}");
    }
    assert!(found.iter().flatten().all(|(_, hit)| hit.shape == 2));
    assert!(next_hits(&scene, std::iter::empty(), &mut together).is_empty());
}
