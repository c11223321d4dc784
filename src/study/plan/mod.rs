//! The runs of a study: those that its file names, with sensible defaults for the rest.

mod default;
mod error;
mod run;
mod sensor_plan;
mod sensors;
mod study_plan;

pub use error::PlanError;
pub use run::StudyRun;
pub use sensor_plan::SensorPlan;
pub use study_plan::StudyPlan;
