//! Meaning of emitters and sensors in Mitsuba's scene files. Numbers called Mitsuba's
//! were read back from Mitsuba 3.9.1, `scalar_rgb`, with `mi.load_string` and `mi.traverse`.

use glam::DVec3;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::{Crop, Emitter, Film, ReconstructionFilter, SensorKind, ShapeId};

use crate::support::scene_files::{assert_close, error, scene};

fn emitter(emitter: &str) -> Result<Emitter, String> {
    Ok(scene(emitter)?.emitters[0].clone())
}

fn sensor(sensor: &str) -> Result<(SensorKind, Film), String> {
    let sensor = scene(sensor)?.sensors.remove(0);
    Ok((sensor.kind, sensor.film))
}

#[test]
fn emission_has_mitsubas_numbers() {
    let intensity = |element: &str| {
        let point = format!("<emitter type=\"point\">{element}</emitter>");
        emitter(&point).map(|emitter| emitter.strength())
    };
    assert_eq!(intensity(""), Ok(Rgb::WHITE));
    assert_eq!(
        intensity("<float name=\"intensity\" value=\"2\"/>"),
        Ok(Rgb::grey(2.0))
    );
    assert_eq!(
        intensity("<rgb name=\"intensity\" value=\"2\"/>"),
        Ok(Rgb::grey(2.0))
    );
    assert_eq!(
        intensity("<rgb name=\"intensity\" value=\"1 ,2 3\"/>"),
        Ok(Rgb([1.0, 2.0, 3.0]))
    );
    assert_eq!(
        intensity(
            "<spectrum type=\"d65\" name=\"intensity\"><float name=\"scale\" value=\"10\"/></spectrum>"
        ),
        Ok(Rgb::grey(10.0))
    );
    assert_eq!(
        intensity(
            "<spectrum type=\"uniform\" name=\"intensity\"><float name=\"value\" value=\"3\"/></spectrum>"
        ),
        Ok(Rgb::grey(3.0))
    );
    // A constant spectrum is not white: it is illuminant E.
    let uniform = intensity("<spectrum name=\"intensity\" value=\"2\"/>").unwrap();
    for (channel, mitsuba) in uniform.0.into_iter().zip([2.40959, 1.89658, 1.81783]) {
        assert_close(channel, mitsuba);
    }
    assert!(
        intensity("<rgb name=\"intensity\" value=\"-1\"/>")
            .unwrap_err()
            .contains("must not be negative")
    );
    assert!(
        intensity("<spectrum name=\"intensity\" value=\"1, 2, 3\"/>")
            .unwrap_err()
            .contains("wavelength:value pairs")
    );
    assert!(
        intensity("<spectrum name=\"intensity\" filename=\"a.spd\"/>")
            .unwrap_err()
            .contains("spectra from files are not modelled")
    );
}

#[test]
fn a_sampling_weight_is_above_zero() {
    let point = |weight: &str| {
        emitter(&format!(
            "<emitter type=\"point\"><float name=\"sampling_weight\" value=\"{weight}\"/></emitter>"
        ))
    };
    assert!(point("0.25").is_ok());
    for weight in ["0", "-1"] {
        let said = point(weight).unwrap_err();
        assert!(
            said.contains("sampling_weight") && said.contains("must be above 0"),
            "{said}"
        );
    }
}

#[test]
fn a_point_stands_at_its_position_or_its_transforms_origin() {
    let at = |element: &str| -> Result<_, String> {
        match emitter(&format!("<emitter type=\"point\">{element}</emitter>"))? {
            Emitter::Point { position, .. } => Ok(position),
            other => panic!("{other:?}"),
        }
    };
    let position = "<point name=\"position\" x=\"1\" y=\"2\" z=\"3\"/>";
    let transform = "<transform name=\"to_world\"><translate x=\"4\"/></transform>";
    assert_eq!(at(position), Ok(DVec3::new(1.0, 2.0, 3.0)));
    assert_eq!(at(transform), Ok(DVec3::new(4.0, 0.0, 0.0)));
    assert!(
        at(&format!("{position}{transform}"))
            .unwrap_err()
            .contains("exclude each other")
    );
}

#[test]
fn a_spot_fades_from_three_quarters_of_its_cutoff() {
    let angles = |element: &str| -> Result<_, String> {
        match emitter(&format!("<emitter type=\"spot\">{element}</emitter>"))? {
            Emitter::Spot {
                cutoff_angle,
                beam_width,
                ..
            } => Ok((cutoff_angle.to_degrees(), beam_width.to_degrees())),
            other => panic!("{other:?}"),
        }
    };
    let close = |found: (f64, f64), expected: (f64, f64)| {
        assert_close(found.0, expected.0);
        assert_close(found.1, expected.1);
    };
    close(angles("").unwrap(), (20.0, 15.0));
    close(
        angles("<float name=\"cutoff_angle\" value=\"30\"/>").unwrap(),
        (30.0, 22.5),
    );
    assert!(
        angles("<float name=\"beam_width\" value=\"30\"/>")
            .unwrap_err()
            .contains("from 0 to cutoff_angle (20)")
    );
    assert!(
        angles("<float name=\"cutoff_angle\" value=\"0\"/>")
            .unwrap_err()
            .contains("above 0")
    );
}

#[test]
fn directional_light_travels_along_its_direction_or_its_transforms_z_axis() {
    let travel = |element: &str| -> Result<_, String> {
        match emitter(&format!(
            "<emitter type=\"directional\">{element}</emitter>"
        ))? {
            Emitter::Directional { direction, .. } => Ok(direction),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(travel(""), Ok(DVec3::Z));
    assert_eq!(
        travel("<vector name=\"direction\" x=\"0\" y=\"-2\" z=\"0\"/>"),
        Ok(DVec3::NEG_Y)
    );
    let turned = "<transform name=\"to_world\"><rotate y=\"1\" angle=\"90\"/></transform>";
    assert_eq!(travel(turned), Ok(DVec3::X));
    assert!(
        travel("<vector name=\"direction\" value=\"0\"/>")
            .unwrap_err()
            .contains("must not be zero")
    );
}

#[test]
fn an_area_light_belongs_to_one_shape() {
    let parts = scene("<shape type=\"sphere\"/><emitter type=\"area\" id=\"light\"/><shape type=\"rectangle\"><ref id=\"light\"/></shape>").unwrap();
    assert_eq!(
        parts.emitters,
        [Emitter::Area {
            shape: ShapeId(1),
            radiance: Rgb::WHITE,
            texture: None,
        }]
    );
    assert!(error("<emitter type=\"area\"/>").contains("must belong to a shape"));
    let twice = "<emitter type=\"area\" id=\"l\"/><shape type=\"sphere\"><ref id=\"l\"/></shape><shape type=\"disk\"><ref id=\"l\"/></shape>";
    assert!(error(twice).contains("shines from several shapes"));
    assert!(
        error("<shape type=\"sphere\"><emitter type=\"point\"/></shape>")
            .contains("cannot be inside a shape")
    );
}

#[test]
fn light_that_is_not_modelled_is_never_silent() {
    for plugin in ["timed_sunsky", "volumelight"] {
        let message = error(&format!("<emitter type=\"{plugin}\"/>"));
        assert!(
            message.contains(&format!("emitter \"{plugin}\" is not modelled")),
            "{message}"
        );
    }
}

#[test]
fn a_meter_measures_its_shape_with_mitsubas_default_film() {
    let parts = scene("<shape type=\"sphere\"/><shape type=\"rectangle\"><sensor type=\"irradiancemeter\"/></shape>").unwrap();
    let sensor = &parts.sensors[0];
    assert_eq!(
        sensor.kind,
        SensorKind::IrradianceMeter { shape: ShapeId(1) }
    );
    assert_eq!((sensor.film.width, sensor.film.height), (768, 576));
    assert_eq!(
        sensor.film.crop,
        Crop {
            offset_x: 0,
            offset_y: 0,
            width: 768,
            height: 576
        }
    );
    assert_eq!(
        sensor.film.filter,
        ReconstructionFilter::Gaussian { stddev: 0.5 }
    );
    // Mitsuba would blur the map with that filter.
    assert!(parts.warnings[0].message.contains("rfilter type=\"box\""));
    let boxed = "<shape type=\"disk\"><sensor type=\"irradiancemeter\"><film type=\"hdrfilm\"><rfilter type=\"box\"/></film></sensor></shape>";
    assert!(scene(boxed).unwrap().warnings.is_empty());
    assert!(
        error("<sensor type=\"irradiancemeter\"/>")
            .contains("must be inside the shape it measures")
    );
    let placed = "<shape type=\"disk\"><sensor type=\"irradiancemeter\"><transform name=\"to_world\"/></sensor></shape>";
    assert!(error(placed).contains("\"to_world\": is not allowed"));
}

#[test]
fn a_shape_may_have_several_meters_though_mitsuba_allows_one() {
    let parts = scene("<shape type=\"disk\"><sensor type=\"irradiancemeter\"/><sensor type=\"irradiancemeter\"/></shape>").unwrap();
    assert_eq!(parts.sensors.len(), 2);
    assert!(
        parts
            .warnings
            .iter()
            .any(|warning| warning.message.contains("Mitsuba 3 allows one"))
    );
}

#[test]
fn a_perspective_camera_has_mitsubas_field_of_view() {
    let fov = |element: &str| -> Result<_, String> {
        match sensor(&format!("<sensor type=\"perspective\">{element}</sensor>"))?.0 {
            SensorKind::Perspective(camera) => Ok(camera.horizontal_fov.to_degrees()),
            other => panic!("{other:?}"),
        }
    };
    assert_close(fov("").unwrap(), 38.1848);
    assert_close(
        fov("<string name=\"focal_length\" value=\"35mm\"/>").unwrap(),
        52.6225,
    );
    assert_close(fov("<float name=\"fov\" value=\"40\"/>").unwrap(), 40.0);
    assert_close(
        fov("<float name=\"fov\" value=\"40\"/><string name=\"fov_axis\" value=\"y\"/>").unwrap(),
        51.774,
    );
    for degrees in ["0", "180", "190", "-1"] {
        let message = fov(&format!("<float name=\"fov\" value=\"{degrees}\"/>")).unwrap_err();
        assert!(message.contains("above 0 and below 180"), "{message}");
    }
    assert!(
        fov("<float name=\"fov\" value=\"40\"/><string name=\"fov_axis\" value=\"z\"/>")
            .unwrap_err()
            .contains("must be one of x, y")
    );
    assert!(
        fov("<transform name=\"to_world\"><scale value=\"2\"/></transform>")
            .unwrap_err()
            .contains("must not scale or shear")
    );
}

#[test]
fn thin_lens_and_orthographic_cameras_are_read() {
    let lens = "<sensor type=\"thinlens\"><float name=\"aperture_radius\" value=\"0.1\"/><float name=\"focus_distance\" value=\"3\"/></sensor>";
    let (kind, _) = sensor(lens).unwrap();
    assert!(matches!(
        kind,
        SensorKind::ThinLens {
            aperture_radius: 0.1,
            focus_distance: 3.0,
            ..
        }
    ));
    assert!(
        sensor("<sensor type=\"thinlens\"/>")
            .unwrap_err()
            .contains("needs the parameter \"aperture_radius\"")
    );
    let (kind, _) = sensor("<sensor type=\"orthographic\"/>").unwrap();
    assert!(matches!(
        kind,
        SensorKind::Orthographic {
            near_clip: 0.01,
            far_clip: 10_000.0,
            ..
        }
    ));
}

#[test]
fn films_keep_size_crop_and_filter() {
    let film = |elements: &str| {
        let text = format!(
            "<sensor type=\"orthographic\"><film type=\"hdrfilm\">{elements}</film></sensor>"
        );
        sensor(&text).map(|(_, film)| film)
    };
    let cropped = film(
        "<integer name=\"width\" value=\"64\"/><integer name=\"height\" value=\"32\"/><integer name=\"crop_offset_x\" value=\"16\"/>\
         <integer name=\"crop_width\" value=\"48\"/><rfilter type=\"lanczos\"/>",
    )
    .unwrap();
    assert_eq!(
        cropped.crop,
        Crop {
            offset_x: 16,
            offset_y: 0,
            width: 48,
            height: 32
        }
    );
    assert_eq!(cropped.filter, ReconstructionFilter::Lanczos { lobes: 3 });
    let filter =
        |rfilter: &str| film(&format!("<rfilter type=\"{rfilter}\"/>")).map(|film| film.filter);
    assert_eq!(filter("box"), Ok(ReconstructionFilter::Box));
    assert_eq!(
        filter("tent"),
        Ok(ReconstructionFilter::Tent { radius: 1.0 })
    );
    assert_eq!(
        filter("mitchell"),
        Ok(ReconstructionFilter::Mitchell {
            b: 1.0 / 3.0,
            c: 1.0 / 3.0
        })
    );
    assert_eq!(filter("catmullrom"), Ok(ReconstructionFilter::CatmullRom));
    assert!(
        filter("sinc")
            .unwrap_err()
            .contains("is not known; known are: box")
    );
    // As in Mitsuba, the crop's size does not shrink by its offset on its own.
    assert!(
        film("<integer name=\"crop_offset_x\" value=\"10\"/>")
            .unwrap_err()
            .contains("does not fit")
    );
    assert!(
        film("<integer name=\"width\" value=\"0\"/>")
            .unwrap_err()
            .contains("must be from 1")
    );
    assert!(
        film("<integer name=\"width\" value=\"99999999999\"/>")
            .unwrap_err()
            .contains("99999999999")
    );
}
