//! Cameras: light that arrives at a surface, connected to the film, makes the radiance that pixels average.
//!
//! Where points are seen is held against Mitsuba 3.9.1; how bright, against integrals over the
//! pixel of radiance in closed form, which know nothing of footprints.

mod radiance;
mod rays;
mod refusals;
mod thin_lens;
mod views;
