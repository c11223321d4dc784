//! Frames of an animation, one after the other.

use super::Method;
use super::reference::Job;
use crate::approximation::Prepared;
use crate::run::{Budget, Context, Counter, Error, Rendering};
use crate::scene::{Scene, Sensor};

/// Frames of an animation by one method, one after the other.
///
/// A frame may use what is left of those before it, if the method's settings ask for that: tables, pictures
/// of slabs in which nothing moved (`update=changed`), photons of other frames (`shares`, `amortise`). All
/// other frames are made as if they were the only ones.
///
/// # Example: two frames of a ball that rises
///
/// ```
/// use nephroid::{Budget, Context, Method};
///
/// let settings = [("photons", "400"), ("g-buffer", "40"), ("update", "changed")];
/// let settings = settings.map(|(key, value)| (key.to_owned(), value.to_owned())).into();
/// let method = Method::new("caustics-volume", &settings)?;
/// let mut frames = method.frames();
/// for lift in ["0", "0.1"] {
///     let parameters = [("size", "8"), ("lift", lift)];
///     let scene = nephroid::load("scenes/cornell-caustics.xml".as_ref(), &parameters)?;
///     let sensor = &scene.sensors()[0];
///     let (budget, context) = (Budget::default(), Context::default());
///     let frame = frames.frame(&scene, sensor, &budget, &context)?;
///     let alone = method.run(&scene, sensor, &budget, &context)?;
///     assert_eq!(frame.estimate.total.values, alone.estimate.total.values);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Sequence<'a> {
    method: &'a Method,
    /// What is left of the last frame.
    left: Option<Box<dyn Prepared>>,
}

impl Method {
    /// Frames by this method, the first of which is still to be made.
    ///
    /// # Example: nothing is made yet
    ///
    /// ```
    /// let method = nephroid::Method::new("caustic-map", &Default::default())?;
    /// let _frames = method.frames();
    /// # Ok::<(), nephroid::SettingError>(())
    /// ```
    pub fn frames(&self) -> Sequence<'_> {
        Sequence {
            method: self,
            left: None,
        }
    }
}

impl Sequence<'_> {
    /// The next frame: fills a sensor of a scene, which may have moved since the last frame.
    ///
    /// # Errors
    ///
    /// As [`Method::run`]. What was left of earlier frames is lost then.
    ///
    /// # Example: frames of a technique that keeps nothing are runs
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// use nephroid::{Budget, Context, Method};
    ///
    /// let method = Method::new("photons", &Default::default())?;
    /// let frame = method.frames().frame(&scene, sensor, &Budget::work(4096), &Context::default())?;
    /// assert_eq!(frame.estimate.paths, 4096);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn frame(
        &mut self,
        scene: &Scene,
        sensor: &Sensor,
        budget: &Budget,
        context: &Context,
    ) -> Result<Rendering, Error> {
        let method = self.method;
        if method.is_of_cameras() && !sensor.is_camera() {
            method.supports(scene, sensor)?;
        }
        method.check_memory(scene, sensor, context)?;
        let budget = budget.or(method.budget());
        method.check_bar(&budget)?;
        let job = Job {
            scene,
            sensor,
            values: &method.values,
            budget: &budget,
            context,
        };
        let left = &mut self.left;
        let mut rendering = context.install(|| method.entry.run(&job, left))?;
        if rendering.counters.is_empty() {
            let estimate = &rendering.estimate;
            let counters = &estimate.counters;
            rendering.counters = vec![
                Counter::new("rays", counters.rays),
                Counter::new("node visits", counters.node_visits),
                Counter::new("primitive tests", counters.primitive_tests),
                Counter::new(rendering.unit, estimate.paths),
            ];
        }
        Ok(method.described(rendering, sensor))
    }
}
