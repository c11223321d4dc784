//! Work of a stage, in units that do not depend on the machine.

use crate::approximation::work::work;
use crate::run::Counters;

work! {
    /// Beams that are drawn, or begun in stage `surface`.
    beams,
    /// Beams not begun: their rays do not go down, or their water faces away from the light.
    dropped,
    /// Nodes of the hierarchy that were visited.
    nodes,
    /// Tests of a node or a beam against the view, or against a receiver's box.
    tests,
    /// Nodes that were compared with the shadow map.
    queries,
    /// Beams that are not drawn, being out of view or in shadow.
    culled,
    /// Beams that leave the hulls of their nodes.
    escapes,
    /// Vertices that were computed: of the water, and three a plane and pass of a beam.
    vertices,
    /// Commands to draw: two a range of planes.
    draws,
    /// Pixels that faces of beams cover, in both passes; of exact insides, points tested.
    fragments,
    /// Sums that were written.
    blends,
    /// Sums that reached the largest number of their format.
    saturated,
    /// Rays traced against the scene: what a device rasterises or traces.
    rays,
    /// Bytes of buffers that a stage writes for others, and of blends.
    bytes,
}

impl Work {
    /// The work of a whole frame, in the order of importance; `drawn` is the number of beams drawn.
    pub fn of_frame(stages: &[Self], drawn: u64) -> Counters {
        let mut sum = Self::default();
        for one in stages {
            sum += *one;
        }
        Counters::of([
            ("beams", drawn),
            ("draws", sum.draws),
            ("fragments", sum.fragments),
            ("blends", sum.blends),
            ("vertices", sum.vertices),
            ("tests", sum.tests),
            ("queries", sum.queries),
            ("rays", sum.rays),
            ("bytes", sum.bytes),
        ])
    }
}
