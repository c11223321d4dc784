//! Counts of the work of searches.

/// Counts of the work done by searches.
///
/// # Example: rays of a run
///
/// ```
/// # use nephroid::{Budget, Context, Method};
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = Method::new("photons", &Default::default())?;
/// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
/// let counters = rendering.estimate.counters;
/// assert!(counters.rays > 4096, "at least one a photon");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct TraversalCounters {
    /// Number of rays searched for.
    pub rays: u64,
    /// Number of nodes of trees visited, once for all rays that visit one together.
    pub node_visits: u64,
    /// Number of exact intersection tests.
    pub primitive_tests: u64,
}

impl std::ops::AddAssign for TraversalCounters {
    fn add_assign(&mut self, other: Self) {
        // Counters of shards come from files, which may say anything.
        self.rays = self.rays.saturating_add(other.rays);
        self.node_visits = self.node_visits.saturating_add(other.node_visits);
        self.primitive_tests = self.primitive_tests.saturating_add(other.primitive_tests);
    }
}
