//! Laws of every bsdf: reciprocity, adjoints, and good manners at the extremes.

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Ray, SurfacePoint};
use nephroid::internals::numeric::{Stream, StreamKind};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::bsdf::{Bsdf, BsdfSample, Scattering, Transport, check_colors};
use nephroid::internals::transport::scatter::{Interaction, ShadingNormals, Way};

use crate::support::bsdf::{Surface, bsdfs, direction, scene};

/// Directions all over the sphere, deterministic.
fn directions(seed: u64, count: u64) -> impl Iterator<Item = DVec3> {
    let stream = Stream::new(StreamKind::Random, seed);
    (0..count).map(move |index| {
        let [u, v] = stream.point2(index);
        let (z, phi) = (2.0 * u - 1.0, std::f64::consts::TAU * v);
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * phi.cos(), radius * phi.sin(), z)
    })
}

/// f(wi, wo) / n_i² = f(wo, wi) / n_o² (Veach 1997, 5.14), f being what is evaluated by the cosine of wo.
#[test]
fn light_goes_the_same_way_back() {
    for case in bsdfs() {
        // A mask's passing light and turned normals that depend on the viewer are out of this.
        if case.contains("map\"") {
            continue;
        }
        let surface = Surface::square(&case, DVec2::new(0.3, 0.7));
        let bsdf = surface.bsdf();
        if bsdf.is_delta() {
            continue;
        }
        let index = |name: &str, default: f64| {
            let mark = format!("name=\"{name}\" value=\"");
            case.split(&mark).nth(1).map_or(default, |rest| {
                rest.split('"').next().unwrap().parse().unwrap()
            })
        };
        let is_thin = case.contains("principledthin");
        let indices = if is_thin {
            // Light goes through a sheet unbent.
            (1.0, 1.0)
        } else if case.contains("principled") {
            // `specular` is the reflectance at normal incidence by 0.08, and 0.001 if it is zero.
            let amplitude = (0.08 * index("specular", 0.5).max(1e-3)).sqrt();
            (index("eta", 2.0 / (1.0 - amplitude) - 1.0), 1.0)
        } else {
            (index("int_ior", 1.5046), index("ext_ior", 1.000277))
        };
        let n = |w: DVec3| if w.z < 0.0 { indices.0 } else { indices.1 };
        let mut met = 0;
        for (wi, wo) in directions(1, 400).zip(directions(2, 400)) {
            let f = |from: DVec3, to: DVec3| {
                bsdf.eval(from, to, Transport::Radiance).0[1] / (to.z.abs() * n(from) * n(from))
            };
            if is_thin && wi.z * wo.z < 0.0 && !is_seen_both_ways(wi, wo) {
                continue;
            }
            let (there, back) = (f(wi, wo), f(wo, wi));
            met += u32::from(there > 0.0);
            // Some 30 roundings; D of a facet amplifies those of m by at most 2 tan²θ_m/α², where
            // it is not yet e^-50: by some 100.
            let tolerance = 1e4 * f64::EPSILON * there.max(back) + 1e-20;
            assert!(
                (there - back).abs() <= tolerance,
                "{case}\n{wi} {wo}: {there} {back}"
            );
        }
        // Of 400 pairs a quarter is on the front, less what is beyond the critical angle.
        assert!(met > 10, "{case}: {met}");
    }
}

/// True if light through a sheet leaves by the back of the facet that mirrors one direction into the other, seen
/// from either end. At grazing angles Mitsuba's thin sheet lets it pass one way only.
fn is_seen_both_ways(wi: DVec3, wo: DVec3) -> bool {
    let [a, b] = [wi, wo].map(|w| DVec3::new(w.x, w.y, w.z.abs()));
    let m = a + b;
    let across = DVec3::new(m.x, m.y, -m.z);
    a.dot(across) < 0.0 && b.dot(across) < 0.0
}

/// A mesh of one triangle in the plane z = 0 whose shading normals lean, met from above.
fn leaning(bsdf: &str) -> (Scene, Ray) {
    let folder = tempfile::TempDir::new().unwrap();
    let ply = folder.path().join("leaning.ply");
    std::fs::write(
        &ply,
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n\
         -1 -1 0 0.5 0.1 1\n3 -1 0 0.3 -0.4 1\n-1 3 0 0.2 0.3 1\n3 0 1 2\n",
    )
    .unwrap();
    let scene = scene(&format!(
        "<shape type=\"ply\"><string name=\"filename\" value=\"{}\"/>{bsdf}</shape>",
        ply.display()
    ));
    (scene, Ray::new(DVec3::new(0.2, 0.1, 1.0), -DVec3::Z))
}

fn met<'a>(scene: &'a Scene, ray: &Ray) -> (Bsdf<'a>, SurfacePoint) {
    let hit = scene
        .world()
        .closest_hit(ray, f64::INFINITY, &mut Default::default())
        .unwrap();
    let point = scene.world().surface_point(ray, &hit);
    assert!(point.shading_normal.dot(point.geometric_normal) < 0.99);
    (Bsdf::at(scene, &hit, &point), point)
}

/// Two ways to the same number, written apart: a photon's, by Veach's factor, and the adjoint of a camera's.
#[test]
fn flux_at_smooth_interfaces_is_that_of_photons_with_adjoint_shading_normals() {
    for (case, two_sided) in [
        ("<bsdf type=\"dielectric\"/>", true),
        ("<bsdf type=\"thindielectric\"/>", true),
        (
            "<bsdf type=\"conductor\"><string name=\"material\" value=\"Cu\"/></bsdf>",
            false,
        ),
    ] {
        let (scene, ray) = leaning(case);
        let (bsdf, point) = met(&scene, &ray);
        let mut compared = 0;
        for wi in directions(3, 300) {
            let interaction = Interaction::new(
                &scene,
                &scene.materials()[0],
                &point,
                -wi,
                ShadingNormals::Adjoint,
            );
            for (way, scattering) in [
                (Way::Reflected, Scattering::Reflected),
                (Way::Transmitted, Scattering::Transmitted),
            ] {
                let Some(branch) = (interaction.share_of(way) > 0.0)
                    .then(|| interaction.branch::<3>(way))
                    .flatten()
                else {
                    continue;
                };
                let sample: BsdfSample = [0.0, 1.0f64.next_down()]
                    .into_iter()
                    .filter_map(|u| bsdf.sample(wi, [u, 0.5, 0.5], Transport::Flux))
                    .find(|sample| sample.scattering == scattering)
                    .unwrap();
                assert!(bsdf.is_consistent(wi, sample.wo));
                assert!(sample.wo.abs_diff_eq(branch.direction, 1e-14));
                for c in 0..3 {
                    let photon = interaction.share_of(way) * branch.tint.0[c];
                    let path = sample.weight.0[c] * sample.pdf_solid_angle;
                    // A few dozen roundings; a grazing refraction amplifies them by 1/cos.
                    assert!(
                        (photon - path).abs() <= 1e-12 * photon,
                        "{case} {photon} {path}"
                    );
                }
                compared += 1;
            }
        }
        assert!(
            compared > if two_sided { 300 } else { 100 },
            "{case}: {compared}"
        );
    }
}

/// With the true normal n, eval_flux(wi, wo) |wi·n| = eval_radiance(wo, wi) |wo·n|: the module's definition,
/// here for shading normals that lean, where a cosine mistaken for another shows.
#[test]
fn flux_at_leaning_normals_is_the_adjoint_of_radiance_and_its_samples_average_to_it() {
    for case in [
        "<bsdf type=\"diffuse\"/>",
        "<bsdf type=\"roughdielectric\"><float name=\"alpha\" value=\"0.4\"/></bsdf>",
        "<bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.4\"/></bsdf>",
        "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.3\"/><bsdf type=\"diffuse\"/>\
         <bsdf type=\"roughdielectric\"><float name=\"alpha\" value=\"0.4\"/></bsdf></bsdf>",
        "<bsdf type=\"principledthin\"><float name=\"spec_trans\" value=\"0.5\"/>\
         <float name=\"diff_trans\" value=\"0.7\"/></bsdf>",
    ] {
        let (scene, ray) = leaning(case);
        let (bsdf, point) = met(&scene, &ray);
        let n = point.geometric_normal;
        for (wi, wo) in directions(4, 200).zip(directions(5, 200)) {
            let flux = bsdf.eval(wi, wo, Transport::Flux) * wi.dot(n).abs();
            let radiance = bsdf.eval(wo, wi, Transport::Radiance) * wo.dot(n).abs();
            assert!((flux.0[0] - radiance.0[0]).abs() <= 4.0 * f64::EPSILON * flux.0[0]);
        }
        // Of a uniform lamp all round, a camera sees ∫ eval_radiance(wo, wi) dwi; light from all round sends
        // it ∫ eval_flux(wi, wo) |wi·n| dwi / |wo·n|: the same number from two loops over samples.
        let wo = direction(30.0, 40.0);
        let stream = Stream::new(StreamKind::Sobol, 6);
        let count = 1 << 16;
        let (mut seen, mut sent) = (0.0, 0.0);
        for (index, wi) in directions(7, count).enumerate() {
            let [a, b, c, _] = stream.point4(index as u64);
            if let Some(sample) = bsdf.sample(wo, [a, b, c], Transport::Radiance) {
                seen += sample.weight.0[0];
            }
            sent += bsdf.eval(wi, wo, Transport::Flux).0[0]
                * (wi.dot(n).abs() / wo.dot(n).abs() * 4.0 * std::f64::consts::PI);
        }
        let (seen, sent) = (seen / count as f64, sent / count as f64);
        // 65536 random points: weights scatter by 0.1 or so, values (bounded by some 20 at the
        // peaks) by 2 or so, which is 0.8 % of the mean; five times that.
        assert!((seen - sent).abs() < 0.04 * seen, "{case}: {seen} {sent}");
    }
}

/// Directions along the surface, all but along it, normal to it, and on both sides; the ends of the
/// unit interval; the smoothest roughness there is and some beyond.
#[test]
fn at_the_extremes_nothing_is_negative_infinite_or_no_number() {
    let mut all = bsdfs();
    for distribution in ["ggx", "beckmann"] {
        for (plugin, more) in [
            ("roughconductor", ""),
            ("roughdielectric", ""),
            (
                "roughdielectric",
                "<float name=\"int_ior\" value=\"1.0003\"/>",
            ),
            ("roughdielectric", "<float name=\"int_ior\" value=\"100\"/>"),
            ("roughplastic", ""),
        ] {
            for alpha in ["1e-4", "1e-9", "1", "30"] {
                all.push(format!(
                    "<bsdf type=\"{plugin}\"><string name=\"distribution\" value=\"{distribution}\"/>\
                     <float name=\"alpha\" value=\"{alpha}\"/>{more}</bsdf>"
                ));
            }
        }
    }
    let grazing = |z: f64| DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
    let mut ways: Vec<DVec3> = [0.0, -0.0, 1e-300, -1e-300, 1e-17, -1e-12, 1e-8, -1e-4]
        .map(grazing)
        .into();
    ways.extend([DVec3::Z, -DVec3::Z, DVec3::Y, direction(180.0 - 1e-7, 10.0)]);
    ways.extend(directions(8, 12));
    let ends = [0.0, f64::MIN_POSITIVE, 1e-16, 0.3, 0.5, 1.0f64.next_down()];
    for case in all {
        let surface = Surface::square(&case, DVec2::new(0.3, 0.7));
        let bsdf = surface.bsdf();
        for mode in [Transport::Radiance, Transport::Flux] {
            for &wi in &ways {
                for &wo in &ways {
                    let value = bsdf.eval(wi, wo, mode);
                    assert!(
                        value.is_finite() && value.min_channel() >= 0.0,
                        "{case}\n{wi} {wo} {value:?}"
                    );
                    let density = bsdf.pdf_solid_angle(wi, wo);
                    assert!(
                        density.is_finite() && density >= 0.0,
                        "{case}\n{wi} {wo} {density}"
                    );
                }
                for u in ends {
                    for v in ends {
                        for w in ends {
                            let Some(sample) = bsdf.sample(wi, [u, v, w], mode) else {
                                continue;
                            };
                            let is_sound = sample.weight.is_finite()
                                && sample.weight.min_channel() >= 0.0
                                && sample.pdf_solid_angle > 0.0
                                && sample.pdf_solid_angle.is_finite()
                                && (sample.wo.length() - 1.0).abs() < 1e-12
                                && sample.eta > 0.0;
                            assert!(is_sound, "{case}\n{wi} {:?}: {sample:?}", [u, v, w]);
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn what_a_camera_would_see_as_black_for_want_of_an_image_is_refused_by_name() {
    let image = "<texture type=\"bitmap\" name=\"diffuse_reflectance\"><string name=\"filename\" value=\"none.png\"/></texture>";
    let missing = scene(&format!(
        "<shape type=\"sphere\"/><shape type=\"sphere\" id=\"globe\"><bsdf type=\"twosided\">\
         <bsdf type=\"roughplastic\">{image}</bsdf></bsdf></shape>"
    ));
    let message = check_colors(&missing).unwrap_err().to_string();
    assert!(
        message.starts_with("shape \"globe\" has a roughplastic whose colour is not known"),
        "{message}"
    );
    assert_eq!(check_colors(&scene("<shape type=\"sphere\"/>")), Ok(()));
}
