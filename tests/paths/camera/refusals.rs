//! Sensors and scenes that give no image.

use nephroid::internals::transport::camera::{Camera, CameraError};

use super::views::{cameras, orthographic, scene};

#[test]
fn sensors_and_scenes_that_give_no_image_are_refused_by_name() {
    let refused = |elements: &str| {
        let scene = scene(elements);
        Camera::new(&scene, &scene.sensors()[0]).unwrap_err()
    };
    let [pinhole, _] = cameras();
    let id = "id=\"eye\" type=";
    let named = pinhole.replacen("type=", id, 1);
    assert_eq!(
        refused(
            &named
                .replace(
                    "type=\"perspective\">",
                    "type=\"thinlens\"><float name=\"aperture_radius\" value=\"0.1\"/>"
                )
                .replace(
                    "<float name=\"principal_point_offset_x\" value=\"0.07\"/>",
                    ""
                )
                .replace(
                    "<float name=\"principal_point_offset_y\" value=\"-0.04\"/>",
                    ""
                )
        )
        .to_string(),
        "sensor \"eye\" is a thinlens: a camera that light can be connected to must be perspective or \
         orthographic"
    );
    assert_eq!(
        refused(&named.replace("type=\"box\"", "type=\"gaussian\"")).to_string(),
        "sensor \"eye\" has a film with a gaussian filter: pixels here are plain averages; add <rfilter \
         type=\"box\"/> to the film, or render with --filter box"
    );
    let textured = "<shape type=\"sphere\" id=\"globe\"><bsdf type=\"twosided\"><bsdf type=\"diffuse\">\
        <texture type=\"checkerboard\" name=\"reflectance\"/></bsdf></bsdf></shape>";
    assert_eq!(
        refused(&format!("{named}{textured}")).to_string(),
        "sensor \"eye\" may see shape \"globe\", whose diffuse reflectance (or opacity) is a texture: light \
         that is connected to pixels as a whole needs an rgb or a float"
    );
    let far = "<shape type=\"rectangle\"><sensor type=\"irradiancemeter\" id=\"meter\"/></shape>";
    assert!(matches!(
        refused(far),
        CameraError::Kind {
            plugin: "irradiancemeter",
            ..
        }
    ));
    let vast = orthographic().replace("x=\"1.5\" y=\"1.5\"", "x=\"1e80\" y=\"1e80\"");
    assert!(matches!(refused(&vast), CameraError::Size { .. }));
}
