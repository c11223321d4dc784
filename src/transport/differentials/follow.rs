//! Thin beams on their way through a scene.

use super::beam::{ChainStep, Landing, ThinBeam};
use crate::geometry::{Hit, SurfacePoint, TraversalCounters};
use crate::scene::{Material, Scene};
use crate::transport::chain::MAX_PASSES;
use crate::transport::scatter::{Interaction, ShadingNormals, Way};

/// Follower of thin beams through one scene to the front of one shape.
#[derive(Clone, Debug)]
pub struct Follower<'a> {
    scene: &'a Scene,
    receiver: u32,
    max_depth: u32,
    shading_normals: ShadingNormals,
    /// Work done so far.
    pub counters: TraversalCounters,
}

/// A branch that waits while another is followed.
struct PendingBranch {
    beam: ThinBeam,
    /// Number of steps of the chain before it parted.
    shared: usize,
    /// The step by which it parted; `None` if it parted at a surface that is as good as nothing.
    by: Option<ChainStep>,
    events: u32,
    passes: u32,
}

impl<'a> Follower<'a> {
    /// A follower of light to the front of shape `receiver`, through at most `max_depth` specular events.
    pub fn new(
        scene: &'a Scene,
        receiver: u32,
        max_depth: u32,
        shading_normals: ShadingNormals,
    ) -> Self {
        Self {
            scene,
            receiver,
            max_depth,
            shading_normals,
            counters: TraversalCounters::default(),
        }
    }

    /// Follows every branch of a beam. `land` is called each time that one meets the front of the receiver,
    /// with the steps before.
    pub fn every_path(&mut self, beam: &ThinBeam, land: &mut impl FnMut(&[ChainStep], &Landing)) {
        let mut chain = Vec::new();
        let mut pending = vec![PendingBranch {
            beam: *beam,
            shared: 0,
            by: None,
            events: 0,
            passes: 0,
        }];
        while let Some(branch) = pending.pop() {
            chain.truncate(branch.shared);
            chain.extend(branch.by);
            let beam = &branch.beam;
            let Some((hit, point)) = self.next_surface(beam) else {
                continue;
            };
            if self.is_received(beam, &hit, &point) {
                land(&chain, &beam.landing(&hit, point));
            }
            let world = self.scene.world();
            let interaction = self.interaction(beam, &hit, &point);
            // The last branch pushed is the first that is followed.
            for way in Way::ALL.into_iter().rev() {
                let is_event = way.event().is_some();
                if is_event && branch.events >= self.max_depth || branch.passes >= MAX_PASSES {
                    continue;
                }
                let Some(next) = beam.leaving(world, &hit, &point, &interaction, way) else {
                    continue;
                };
                let element = world.element(&hit);
                pending.push(PendingBranch {
                    beam: next,
                    shared: chain.len(),
                    by: (!self.is_nothing(&hit)).then_some(ChainStep { element, way }),
                    events: branch.events + u32::from(is_event),
                    passes: branch.passes + u32::from(!is_event),
                });
            }
        }
    }

    /// Follows a beam along `chain` and on to the receiver, whatever is in the way: flat surfaces, and the
    /// receiver, are extended beyond their borders. `None` if the chain breaks: a shape is missed, light is
    /// reflected totally, or it arrives at the receiver's back.
    pub fn along(&mut self, beam: &ThinBeam, chain: &[ChainStep]) -> Option<Landing> {
        let world = self.scene.world();
        let mut beam = *beam;
        for step in chain {
            let (hit, point) = world.meet_element(&beam.ray, step.element, &mut self.counters)?;
            let interaction = self.interaction(&beam, &hit, &point);
            beam = beam.leaving(world, &hit, &point, &interaction, step.way)?;
        }
        let receiver = crate::geometry::SurfaceElement {
            shape: self.receiver,
            face: None,
        };
        let (hit, point) = world.meet_element(&beam.ray, receiver, &mut self.counters)?;
        self.is_received(&beam, &hit, &point)
            .then(|| beam.landing(&hit, point))
    }

    /// Follows a beam through the scene as it is, on the ways of `chain`. `None` unless it meets the chain's
    /// shapes one after the other and then the receiver. It may meet other faces of a mesh than the chain's:
    /// the surfaces met are returned.
    pub fn retrace(
        &mut self,
        beam: &ThinBeam,
        chain: &[ChainStep],
    ) -> Option<(Vec<(Hit, SurfacePoint)>, Landing)> {
        let mut beam = *beam;
        let mut met = Vec::with_capacity(chain.len());
        for _ in 0..=chain.len() + MAX_PASSES as usize {
            let (hit, point) = self.next_surface(&beam)?;
            let world = self.scene.world();
            let interaction = self.interaction(&beam, &hit, &point);
            let way = match chain.get(met.len()) {
                None if self.is_received(&beam, &hit, &point) => {
                    return Some((met, beam.landing(&hit, point)));
                }
                _ if self.is_nothing(&hit) => Way::Passed,
                Some(step) if step.element.shape == hit.shape => {
                    met.push((hit, point));
                    step.way
                }
                _ => return None,
            };
            beam = beam.leaving(world, &hit, &point, &interaction, way)?;
        }
        None
    }

    /// The first shape that a beam meets.
    pub fn first_shape(&mut self, beam: &ThinBeam) -> Option<u32> {
        self.next_surface(beam).map(|(hit, _)| hit.shape)
    }

    fn next_surface(&mut self, beam: &ThinBeam) -> Option<(Hit, SurfacePoint)> {
        let world = self.scene.world();
        let hit = world.closest_hit(&beam.ray, f64::INFINITY, &mut self.counters)?;
        Some((hit, world.bounce_point(&beam.ray, &hit)))
    }

    fn interaction<'b>(
        &self,
        beam: &ThinBeam,
        hit: &Hit,
        point: &'b SurfacePoint,
    ) -> Interaction<'b>
    where
        'a: 'b,
    {
        let material = self.scene.material_of(hit.shape);
        let direction = beam.ray.direction;
        Interaction::new(self.scene, material, point, direction, self.shading_normals)
    }

    /// True if a beam meets the receiver from its front.
    fn is_received(&self, beam: &ThinBeam, hit: &Hit, point: &SurfacePoint) -> bool {
        hit.shape == self.receiver && beam.ray.direction.dot(point.geometric_normal) < 0.0
    }

    /// True if the surface is as good as nothing: paths do not count it.
    fn is_nothing(&self, hit: &Hit) -> bool {
        matches!(self.scene.material_of(hit.shape), Material::Null)
    }
}
