//! Closed forms as a method: which of them a scene is, judged by what the scene holds.
//!
//! Nothing depends on the name of a file. The scene's shapes, materials, emitter and sensor are compared with
//! what the formulas of this folder assume; one thing too many, or one number elsewhere, and the scene is
//! refused.
//!
//! | file | configuration |
//! |---|---|
//! | `open` | light with nothing in its way |
//! | `ball` | a glass ball over the receiver, on the axis of the light |
//! | `cup` | a cylinder that mirrors inside, on the receiver |
//! | `pane` | two parallel faces of glass between light and receiver |
//! | `solid` | a convex solid with flat facets in parallel light |
//!
//! A scene is solved in the receiver's own coordinates (`plane`). Places and directions that must coincide
//! may differ by 1e-13 of the scene's size: transforms round by some 1e-16.

mod ball;
mod cup;
mod glass;
mod known_layer;
mod open;
mod pane;
mod parts;
mod plane;
mod ring_flux;
mod solid;
mod solve;

pub use solve::{ClosedFormSettings, solve, supports};
