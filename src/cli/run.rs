//! A finished run, as commands show it.

use std::time::Duration;

use crate::method::Method;
use crate::run::Rendering;
use crate::scene::{Scene, Sensor};

/// Everything that describes a result.
pub struct Run<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The sensor filled.
    pub sensor: &'a Sensor,
    /// The method.
    pub method: &'a Method,
    /// The result.
    pub rendering: &'a Rendering,
    /// From the start of the command.
    pub elapsed: Duration,
}
