//! Work of a stage, in units that do not depend on the machine.

use crate::approximation::work::work;

work! {
    /// Photons that set out.
    photons,
    /// Rays that were traced against the scene.
    rays,
    /// Legs after a first event.
    legs,
    /// Cells that legs crossed, or texels without cells.
    deposits,
    /// Light samples that were made.
    samples,
    /// Light samples that were read from files.
    loaded,
    /// Places at which the table was read.
    queries,
    /// Cells that were read.
    fetches,
    /// Blocks of trees that were read, one a fetch.
    nodes,
    /// Bytes that were read.
    bytes,
    /// Numbers above the table's range.
    saturated,
    /// Bytes of the tables that a frame keeps.
    resident,
}
