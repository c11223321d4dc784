//! PNG pictures of maps: a title, the map, and a bar that explains its colours.
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
//! A triangle above or below the bar means that values go on beyond it; magenta marks values that are not
//! numbers. Maps smaller than 256 texels are enlarged by a whole factor, texels kept square.

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
