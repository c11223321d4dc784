//! Scenes: shapes, materials, emitters and sensors, immutable and validated.

mod absorption;
mod coincidence;
mod daylight;
mod dispersion;
mod dispersive;
mod emitter;
mod environment;
mod integrator;
mod material;
mod material_check;
mod medium;
mod model;
mod notice;
mod object;
mod parts;
mod principled;
mod principled_thin;
mod requirements;
mod sensor;
mod slide;
mod sun_disc;
mod texture;
mod texture_lookup;
mod validate;

pub use crate::film::ReconstructionFilter;
pub use daylight::Daylight;
pub use dispersion::{DispersionError, MaterialsAtWavelength};
pub use dispersive::Dispersive;
pub use emitter::{Emitter, MAX_SHINING_TRIANGLES};
pub use environment::{Envmap, EnvmapCell, EnvmapError};
pub use integrator::Integrator;
pub use material::{Coat, Material, MaterialId, NormalTurn, Roughness};
pub use medium::{Boundary, Medium, MediumId};
pub use model::Scene;
pub use notice::{Ignored, SourcePosition, Warning};
pub use object::{Object, ShapeId};
pub use parts::{SceneError, SceneParts};
pub use principled::Principled;
pub use principled_thin::PrincipledThin;
pub use requirements::{Requirement, is_achromatic, is_grey, requirements};
pub use sensor::{Crop, Film, Perspective, Sensor, SensorKind};
pub use slide::Slide;
pub use sun_disc::SunDisc;
pub use texture::{
    BitmapTexture, Color, Scalar, Texture, TextureFilter, TextureId, TextureWrap, luminance,
};
pub use texture_lookup::TexturePoint;
