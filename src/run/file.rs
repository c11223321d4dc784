//! From a rendering to an image with its description.

use std::path::Path;

use super::texels;
use super::{Estimate, LayerName, Light, Quantity, Rendering};
use crate::film::exr::{self, ExrWriteError};
use crate::film::{Image, LazyImage, Rounding};
use crate::metric::texel_grid::AREA;
use crate::scene::Scene;
use crate::transport::chain_limits::left_out_of_image;

impl Rendering {
    /// Warnings of the scene and of the run, and of light that the method does not model.
    ///
    /// # Example: warnings in a log
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
    /// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
    /// for warning in rendering.all_warnings(&scene) {
    ///     eprintln!("warning: {warning}");
    /// }
    /// # assert!(rendering.all_warnings(&scene).is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn all_warnings(&self, scene: &Scene) -> Vec<String> {
        let of_scene = scene.warnings().iter().map(ToString::to_string);
        let mut all: Vec<String> = of_scene.chain(self.warnings.iter().cloned()).collect();
        if let (false, [layer]) = (self.light == Light::All, &self.estimate.layers[..]) {
            all.push(format!(
                "this is an approximation: of all light it models {} alone, and its error is not known here (see \
                 nephroid attribute)",
                layer.name
            ));
            if self.estimate.quantity == Quantity::Radiance {
                all.extend(left_out_of_image(scene));
            }
        }
        all
    }

    /// All layers as channels, with their description as attributes: `E` (of a camera `L`), `LD`, `LRD`, ...,
    /// each with `.R .G .B` and `.stderr.R .stderr.G .stderr.B`, or with bounds `.lo.R` ... and `.hi.R` ...;
    /// further maps.
    ///
    /// # Example: values as f32, by name
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
    /// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
    /// let image = rendering.image(&scene);
    /// assert_eq!((image.width, image.height), (8, 8));
    /// assert_eq!(image.metadata("unit"), Some("W/m²"));
    /// assert!(image.channel("E.R").is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn image(&self, scene: &Scene) -> Image {
        self.lazy_image(scene).to_image()
    }

    /// The [`image`](Self::image), whose samples are computed when they are asked for.
    pub(crate) fn lazy_image(&self, scene: &Scene) -> LazyImage<'_> {
        let estimate = &self.estimate;
        let mut image = estimate.lazy_channels();
        for (name, values) in &self.scalars {
            image.add_scalar(name, |texel| values[texel]);
        }
        for (name, values) in &self.maps {
            image.add_rgb(name, |texel| values[texel].0, Rounding::Nearest);
        }
        image.add_metadata("scene", scene.path().display().to_string());
        image.add_metadata("scene-hash", scene.content_hash());
        for (name, value) in &self.report {
            let text = value
                .as_str()
                .map_or_else(|| value.to_string(), str::to_owned);
            image.add_metadata(name, text);
        }
        image.add_metadata("version", env!("CARGO_PKG_VERSION"));
        image.add_metadata("complete", if estimate.incomplete { "no" } else { "yes" });
        let warnings = serde_json::json!(self.all_warnings(scene));
        image.add_metadata("warnings", warnings.to_string());
        image.add_metadata("quantity", estimate.quantity.name());
        image.add_metadata("unit", estimate.quantity.unit());
        let sensor = self
            .report
            .get("sensor")
            .and_then(serde_json::Value::as_str);
        let mut sensors = scene.sensors().iter();
        let size = [image.width, image.height];
        let sensor = sensors.find(|one| Some(one.id.as_str()) == sensor && one.size() == size);
        if let Some(description) = sensor.and_then(|one| texels::describe_texels(scene, one)) {
            let (key, value) = description.metadata;
            image.add_metadata(key, value);
            if let Some(areas) = description.areas {
                image.add_scalar(AREA, move |texel| areas[texel]);
            }
        }
        let mut conventions = conventions(estimate);
        if !scene.dispersion().is_empty() {
            conventions.push_str(
                "; light was traced at single wavelengths, whose colours may be below zero in a channel: they are \
                 beyond sRGB",
            );
        }
        image.add_metadata("conventions", conventions);
        image
    }

    /// Writes the [`image`](Self::image) as an EXR, whole or not at all.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    ///
    /// # Example
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use nephroid::{Budget, Context, Method};
    ///
    /// let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// let sensor = &scene.sensors()[0];
    /// let method = Method::new("closed-form", &Default::default())?;
    /// let rendering = method.run(&scene, sensor, &Budget::default(), &Context::default())?;
    /// let path = std::env::temp_dir().join("nephroid-write-exr.exr");
    /// rendering.write_exr(&scene, &path)?;
    /// let image = nephroid::read_exr(&path)?;
    /// assert_eq!(image.metadata("unit"), Some("W/m²"));
    /// assert_eq!(image.metadata("method"), Some("closed-form"));
    /// # std::fs::remove_file(&path)?;
    /// # Ok(())
    /// # }
    /// ```
    pub fn write_exr(&self, scene: &Scene, path: &Path) -> Result<(), ExrWriteError> {
        exr::write_lazily(path, &self.lazy_image(scene))
    }
}

/// The meaning of the numbers, for whoever finds the file alone.
fn conventions(estimate: &Estimate) -> String {
    let is_of_classes = |name: LayerName| matches!(name, LayerName::Class(_));
    let has_classes = estimate
        .layers
        .iter()
        .any(|layer| is_of_classes(layer.name));
    if has_classes && estimate.total.interval.is_some() {
        return "pixel-averaged radiance [W/m2/sr] towards the camera, linear sRGB; row 0 is the top; L is the sum \
                of the layers, which are classes of paths from light L to camera E, S a mirror or glass, D \
                anything else: emitted L S* E, direct L D S* E, caustic L S+ D E, caustic-sds L S+ D S+ E, \
                indirect L D ... D S* E, caustic-indirect L S+ D ... D S* E; the attribute full says which method \
                measured which class; stderr is one standard error over independent replicates, of methods that \
                draw lots; lo and hi are bounds, with a confidence of 99.9 % a layer as far as they are random, rounded \
                outward, and those of L the sums of the methods'; NaN is not known"
            .to_owned();
    }
    if has_classes {
        return "pixel-averaged radiance [W/m2/sr] towards the camera, linear sRGB; row 0 is the top; L is the sum \
                of the layers, which are classes of paths from light L to camera E, S a mirror or glass, D \
                anything else: emitted L S* E, direct L D S* E, indirect L D ... D S* E; caustic L S+ D E, \
                caustic-sds L S+ D S+ E and caustic-indirect L S+ D ... D S* E as far as paths from a camera \
                find them; stderr is one standard error over independent replicates; NaN is not known"
            .to_owned();
    }
    let measured = match estimate.quantity {
        Quantity::Irradiance => {
            "texel-averaged irradiance [W/m2], linear sRGB; row 0 is at v = 0, column 0 at u = 0 of the \
             receiver; E is the sum of the layers"
        }
        Quantity::Radiance => {
            "pixel-averaged radiance [W/m2/sr] of diffuse surfaces that the camera sees, linear sRGB, by light \
             that mirrors and glass brought there (direct light, LD, is not measured); row 0 is the top; \
             L is the sum of the layers, of which those in SE are seen by way of mirrors or glass; bias, of photon \
             maps, is what their blur adds to L where light is smooth"
        }
    };
    format!(
        "{measured}; layers are path signatures: L emitter, R mirror or total internal reflection, T \
         refraction, D diffuse surface; stderr is one standard error over independent replicates (for LD the \
         quadrature's bound or standard error); lo and hi are lower and upper bounds, rounded \
         outward (where there is stderr, too: with a confidence of 99.9 %); NaN is not known"
    )
}
