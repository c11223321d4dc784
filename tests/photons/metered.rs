//! What a scene's first sensor measures: by photons, and of direct light alone.

use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::photons::{PhotonSettings, run};
use nephroid::internals::run::{Budget, Estimate, LayerName, Progress};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::direct::direct;
use nephroid::internals::transport::receiver::Receiver;

use crate::support::paths;

/// All light, by photons with the default settings.
pub fn by_photons(scene: &Scene, photons: u64) -> Estimate {
    by_photons_with(scene, PhotonSettings::default(), photons)
}

/// All light, by photons.
pub fn by_photons_with(scene: &Scene, settings: PhotonSettings, photons: u64) -> Estimate {
    let (budget, progress) = (Budget::work(photons), Progress::default());
    run(scene, &scene.sensors()[0], settings, &budget, &progress).unwrap()
}

/// Direct irradiance, and what is left uncertain of it, texel by texel.
pub fn directly(scene: &Scene, samples: u32) -> Vec<(Rgb, Rgb)> {
    let receiver = Receiver::new(scene, &scene.sensors()[0]).unwrap();
    let found = direct(scene, &receiver, 0, samples, &|| false).unwrap();
    let texels = found.texels.iter();
    texels.map(|it| (it.irradiance, it.error)).collect()
}

/// A scene of elements and of a floor from -1 to 1, whose meter has `side` x `side` texels.
pub fn above_a_floor(elements: &str, side: usize) -> String {
    format!(
        "<scene version=\"3.0.0\">{elements}<shape type=\"rectangle\" id=\"floor\"><bsdf type=\"diffuse\"/>\
         <sensor type=\"irradiancemeter\"><film type=\"hdrfilm\"><integer name=\"width\" value=\"{side}\"/>\
         <integer name=\"height\" value=\"{side}\"/><rfilter type=\"box\"/></film></sensor></shape></scene>"
    )
}

/// The scene of elements [`above_a_floor`].
pub fn scene_above_a_floor(elements: &str, side: usize) -> Scene {
    let text = above_a_floor(elements, side);
    let inner = text.trim_start_matches("<scene version=\"3.0.0\">");
    paths::scene(inner.trim_end_matches("</scene>"))
}

/// The texels of the layer of a signature, which must be there.
pub fn layer(estimate: &Estimate, signature: &str) -> Vec<Rgb> {
    let name = LayerName::Path(signature.parse().unwrap());
    let found = estimate.layers.iter().find(|layer| layer.name == name);
    let found = found.unwrap_or_else(|| panic!("{signature} has a layer"));
    found.values.clone()
}
