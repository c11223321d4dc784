//! Why an image has no light.

use super::ledger::Flow;
use crate::approximation::SensorFilm;

/// The reason for which a frame has no light, in one sentence that begins with it.
pub fn reason(flow: &Flow, drawn: u64, film: &SensorFilm) -> String {
    let (begun, flux) = flow.set_out();
    if begun == 0 {
        return "no light goes down through the water: its triangles face away from the light, or rays are too flat"
            .to_owned();
    }
    let culled = flow.culled();
    if culled == begun {
        return format!("all {begun} beams were culled in shadow");
    }
    if drawn == 0 {
        let receiver = match film {
            SensorFilm::Receiver(_) => "the sensor's surface",
            SensorFilm::Camera(_) => "surfaces in view",
        };
        return format!(
            "none of {} beams is drawn: they are out of view, too faint, or meet no box of {receiver}",
            begun - culled
        );
    }
    if flow.drawn().is_black() {
        return format!(
            "all of {:.3e} W on the water is in shadow or reflected",
            flux.mean()
        );
    }
    let hint = match film {
        SensorFilm::Receiver(_) => "all of it lands beside the sensor, or on its back",
        SensorFilm::Camera(_) => {
            "no pixel shows a lit diffuse surface; a camera above the water sees only the water's surface"
        }
    };
    format!(
        "{drawn} beams of {:.3e} W were drawn, and {hint}",
        flow.drawn().mean()
    )
}
