//! One interface of a scene with dispersion.

use super::MaterialId;
use crate::spectrum::Glass;

/// An interface whose index depends on the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct Dispersive {
    /// A plain interface, no wrapper.
    pub material: MaterialId,
    /// The id by which it was named: a bsdf's or a shape's.
    pub id: String,
    /// Its index.
    pub glass: Glass,
}
