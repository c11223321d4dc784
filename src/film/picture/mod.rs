//! PNG pictures of maps: a title, the map, and a bar that says what its colours mean.
//!
//! ```text
//!   title                        unit
//!  +---------------------------+ +-+
//!  |                           | | |- 12
//!  |            map            | | |- 10
//!  |     row 0 is the top      | | |- 8
//!  |                           | | |- ...
//!  +---------------------------+ +-+
//! ```
//!
//! A triangle above or below the bar says that values go on beyond it; magenta is what is
//! no number. Maps smaller than 256 texels are enlarged by a whole factor, texels kept square.

mod canvas;
mod content;
mod layout;
mod palette;
mod png;
mod range;
mod ticks;

pub use content::{Content, PictureSpec};
pub use png::{PictureError, write};
pub use range::{BarRange, Scale};
