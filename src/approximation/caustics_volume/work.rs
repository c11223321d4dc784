//! Work of a stage, in units that do not depend on the machine.

use crate::approximation::work::work;

work! {
    /// Photons that a stage begins with; of beams, their corners.
    photons,
    /// Passes over photons: one a slab, and one of the projectors.
    passes,
    /// Texels of pictures that were made.
    texels,
    /// Triangles that were rasterised, and shapes that were sampled by rays.
    triangles,
    /// Texels or points that photons crossed.
    steps,
    /// Texels that were read.
    fetches,
    /// Photons whose state was copied from one pass to the next.
    copied,
    /// Photons that came to nothing.
    dropped,
    /// Splats that were drawn; of beams, triangles that were dealt out.
    splats,
    /// Points that were tested against splats; of beams, texels with a part.
    fragments,
    /// Rays that were traced against the scene.
    rays,
    /// Bytes of buffers that a stage writes for others.
    bytes,
}
