//! Cameras: light that arrives at a surface, connected to the film, makes the radiance that pixels average.
//!
//! Places in the image are held against Mitsuba 3.9.1, and brightness against integrals over the
//! pixel of radiance in closed form, which know nothing of footprints.

mod radiance;
mod rays;
mod refusals;
mod thin_lens;
mod views;
