//! Photon estimates of whole scenes against closed forms, one path signature at a time.
//!
//! The closed forms (`nephroid::reference::closed_form`) trace nothing: each is a map derived by
//! hand. Three questions are put to every scene:
//!
//! - **regions**: does the flux of every region of a coarse grid, and that of the whole receiver, lie
//!   within Student's quantile of the truth, in units of the estimate's own error bar?
//! - **texels**: do the z-scores of a fine grid have the mean 0 and the variance of Student's t?
//! - **darkness**: where no light can come, is there exactly none?
//!
//! All of this folder together fails a right program with a probability below [`bars::ALPHA`]; as the
//! seeds are fixed, it either always passes or never.

mod bars;
mod flat_facets;
mod glass_ball;
mod mirrors;
mod square_lamp;
mod water;
