//! Which runs a study makes: what its file says, and sensible defaults for what it does not.

mod default;
mod error;
mod run;
mod sensor_plan;
mod sensors;
mod study_plan;

pub use error::PlanError;
pub use run::{StageRun, StageRuns, StudyRun};
pub use sensor_plan::SensorPlan;
pub use study_plan::StudyPlan;
