//! Real-time techniques: pipelines of named stages, each of which has an exact twin.
//!
//! A [`Technique`] fills a sensor, as a reference does, but by a published technique with its errors. Each
//! stage can be made exact: the error that goes with it is that stage's. Each run counts the work of every
//! stage, which can be mapped to another device.
//!
//! A new technique is a folder here, and a line in [`TECHNIQUES`]. It shares:
//!
//! | file | content |
//! |---|---|
//! | [`technique`] | the interface: settings, stages, light, cost, preparation, frame |
//! | [`stage`], `table` | stages by name; settings with their types |
//! | `work`, `clock` | work by counters, and time, by stage |
//! | [`sensor`] | the sensor: its points in batches, and irradiance averaged over texels |
//! | [`sources`] | lights without size |
//! | [`light_view`], [`extent`] | the scene as a light sees it, and how far shapes reach in it |
//! | [`receivers`], [`depth_map`] | the surfaces that receive, and their depths in such a view |
//! | [`precision`] | formats of buffers |
//! | [`interface`] | one specular interface, with or without Fresnel's equations |
//! | [`bands`] | splats drawn in bands, the same bits on any threads |
//! | [`exact_film`] | sums of light that no order changes |
//!
//! Nothing here knows the references, which judge it: see `study`.

pub mod bands;
pub mod caustic_map;
pub mod caustics_volume;
pub(crate) mod clock;
pub mod depth_map;
pub mod exact_film;
pub mod extent;
pub mod interface;
pub mod light_view;
pub mod light_volume;
pub mod local_irradiance;
pub mod precision;
pub mod receivers;
pub mod sensor;
pub mod sources;
pub mod stage;
pub(crate) mod table;
pub mod technique;
pub(crate) mod work;

pub use depth_map::DepthMap;
pub use exact_film::ExactFilm;
pub use extent::Extent;
pub use light_view::LightView;
pub use precision::Precision;
pub use receivers::Receivers;
pub use sensor::{SensorFilm, SensorPoint, SensorPoints};
pub use stage::Stage;
pub use technique::{
    Frame, Prepared, TableAccount, TableChoice, TableChoices, TableReport, Technique, Twins,
};

/// All techniques.
pub static TECHNIQUES: &[&dyn Technique] = &[
    &caustic_map::CausticMap,
    &light_volume::LightVolume,
    &caustics_volume::CausticsVolume,
    &local_irradiance::LocalIrradiance,
];
