//! Counted work by name: noise-free, and what can be mapped to another device.

use std::ops::AddAssign;

use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};

/// Work of one kind, counted.
///
/// # Example: photons of a run
///
/// ```
/// # use nephroid::{Budget, Context, Method};
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = Method::new("photons", &Default::default())?;
/// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
/// let is_photons = |counter: &&nephroid::Counter| counter.name == "photons";
/// let photons = rendering.counters.iter().find(is_photons).unwrap();
/// assert_eq!(photons.count, 4096);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counter {
    /// The kind, in the plural: `rays`, `photons`, `fragments`, ...
    pub name: String,
    /// How often it was done.
    pub count: u64,
}

impl Counter {
    /// So much work of a kind.
    #[doc(hidden)]
    pub fn new(name: &str, count: u64) -> Self {
        Self {
            name: name.to_owned(),
            count,
        }
    }
}

/// Counted work by name, in the order in which the kinds were first counted.
///
/// # Example: the work of a whole frame
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let map = nephroid::Method::new("caustic-map", &Default::default())?;
/// # let map = map.with("photons", "16")?.with("map", "16")?;
/// # let rendering = map.run(&scene, sensor, &Default::default(), &Default::default())?;
/// let mut frame = std::collections::BTreeMap::new();
/// for (kind, count) in rendering.stages.iter().flat_map(|stage| stage.work.iter()) {
///     *frame.entry(kind).or_insert(0) += count;
/// }
/// assert!(!frame.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counters(Vec<(&'static str, u64)>);

impl Counters {
    /// Counts of some kinds.
    #[doc(hidden)]
    pub fn of<const N: usize>(counts: [(&'static str, u64); N]) -> Self {
        let mut counters = Self::default();
        for (name, count) in counts {
            counters.add(name, count);
        }
        counters
    }

    /// Counts so much more of a kind.
    #[doc(hidden)]
    pub fn add(&mut self, name: &'static str, count: u64) {
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += count,
            None => self.0.push((name, count)),
        }
    }

    /// The count of a kind; 0 if it was never done.
    ///
    /// # Example: work that was never done
    ///
    /// ```
    /// let counters = nephroid::Counters::default();
    /// assert_eq!(counters.get("rays"), 0);
    /// ```
    pub fn get(&self, name: &str) -> u64 {
        let found = self.0.iter().find(|(known, _)| *known == name);
        found.map_or(0, |(_, count)| *count)
    }

    /// The counts as a list.
    #[doc(hidden)]
    pub fn list(&self) -> Vec<Counter> {
        self.iter()
            .map(|(name, count)| Counter::new(name, count))
            .collect()
    }

    /// All counts.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        self.0.iter().copied()
    }
}

impl AddAssign<&Self> for Counters {
    fn add_assign(&mut self, other: &Self) {
        for (name, count) in other.iter() {
            self.add(name, count);
        }
    }
}

impl Serialize for Counters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, count) in &self.0 {
            map.serialize_entry(name, count)?;
        }
        map.end()
    }
}

/// Work of one stage of a technique.
///
/// # Example: the slowest stage of a technique
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let map = nephroid::Method::new("caustic-map", &Default::default())?;
/// # let map = map.with("photons", "16")?.with("map", "16")?;
/// # let rendering = map.run(&scene, sensor, &Default::default(), &Default::default())?;
/// let by_time = |a: &&nephroid::StageWork, b: &&nephroid::StageWork| a.seconds.total_cmp(&b.seconds);
/// let slowest = rendering.stages.iter().max_by(by_time).unwrap();
/// assert!(slowest.seconds >= rendering.stages[0].seconds);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StageWork {
    /// The stage.
    pub name: &'static str,
    /// The pass of the stage, for techniques that repeat it: `slab 1`, `projector`, ...; else empty.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub pass: String,
    /// Work, counted.
    pub work: Counters,
    /// Time \[s\] on this machine, among its other users.
    pub seconds: f64,
}

impl StageWork {
    /// A stage that has done nothing yet.
    #[doc(hidden)]
    pub fn new(name: &'static str) -> Self {
        Self {
            name,
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_add_up_by_name_and_keep_their_order() {
        let mut all = Counters::of([("rays", 2), ("bytes", 0), ("fetches", 5)]);
        all += &Counters::of([("fetches", 1), ("bytes", 7)]);
        let listed: Vec<_> = all.iter().collect();
        assert_eq!(listed, [("rays", 2), ("bytes", 7), ("fetches", 6)]);
        assert_eq!(all.get("steps"), 0);
    }
}
