//! The grasps of an object in their order.

use nalgebra::Isometry3;

use crate::candidate::{Candidate, Exclusion};
use crate::gripper::Gripper;
use crate::scene::Scene;
use crate::{cup, fingers};

/// All candidates for an object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grasps {
    /// Those that nothing excludes first; then by cost.
    pub candidates: Vec<Candidate>,
}

/// The grasps of the object with index `object` of `scene` by `gripper`, whose TCP is at `tool`
/// (m, rad; `None`: anywhere). An object that is not in the cell has none.
pub fn grasps(
    gripper: &Gripper,
    scene: &Scene,
    object: usize,
    tool: Option<&Isometry3<f64>>,
) -> Grasps {
    first_grasps(gripper, scene, (object, tool), usize::MAX, |_| true)
}

/// As [`grasps`], with those excluded that `reaches` refuses, and only until `enough` are found:
/// none of those that are left out costs less.
pub fn first_grasps(
    gripper: &Gripper,
    scene: &Scene,
    (object, tool): (usize, Option<&Isometry3<f64>>),
    enough: usize,
    mut reaches: impl FnMut(&Isometry3<f64>) -> bool,
) -> Grasps {
    let size = scene
        .objects
        .get(object)
        .map_or(0.0, |of| of.solid.radius());
    let near = scene.around(object, gripper.radius() + size);
    let near = near.as_ref();
    let body = near.and_then(|near| near.objects.first());
    let Some(((body, pose), scene)) = body.and_then(|body| Some((body, body.pose?))).zip(near)
    else {
        return Grasps::default();
    };
    // Rounded, so that the last bits of an angle decide nothing; a stable sort keeps the order of
    // the shape's axes.
    let rounded = |candidate: &Candidate| (1.0e6 * candidate.cost).round();
    let by_cost = |a: &Candidate, b: &Candidate| rounded(a).total_cmp(&rounded(b));
    let mut all: Vec<Candidate> = Vec::new();
    let add = |mut group: Vec<Candidate>, least_cost: f64| {
        group.sort_by(by_cost);
        for of in group.iter_mut().filter(|of| of.excluded.is_none()) {
            of.excluded = (!reaches(&of.tcp)).then_some(Exclusion::OutOfReach);
        }
        all.extend(group);
        // A candidate that costs more than `least_cost` may be followed by a cheaper one.
        let is_best = |of: &&Candidate| of.excluded.is_none() && of.cost <= least_cost;
        all.iter().filter(is_best).count() >= enough
    };
    match gripper {
        Gripper::Fingers(hand) => fingers::candidates(hand, scene, (body, &pose), tool, add),
        Gripper::Cup(cup) => cup::candidates(cup, scene, (body, &pose), tool, add),
    }
    all.sort_by(by_cost);
    all.sort_by_key(|candidate| candidate.excluded.is_some());
    Grasps { candidates: all }
}

impl Grasps {
    /// Excludes the candidates that `reaches` refuses.
    pub fn ask_reach(&mut self, mut reaches: impl FnMut(&Isometry3<f64>) -> bool) {
        let free = |candidate: &&mut Candidate| candidate.excluded.is_none();
        for candidate in self.candidates.iter_mut().filter(free) {
            if !reaches(&candidate.tcp) {
                candidate.excluded = Some(Exclusion::OutOfReach);
            }
        }
        self.candidates
            .sort_by_key(|candidate| candidate.excluded.is_some());
    }

    /// The best grasp.
    pub fn best(&self) -> Option<&Candidate> {
        let first = self.candidates.first();
        first.filter(|candidate| candidate.excluded.is_none())
    }

    /// Why there is none: what excludes the best candidate, of those that are narrow enough if
    /// there are any. `None` if there is a grasp, or no candidate at all.
    pub fn refusal(&self) -> Option<&Exclusion> {
        if self.best().is_some() {
            return None;
        }
        let all = self.candidates.iter().filter_map(|of| of.excluded.as_ref());
        let fits = |of: &&Exclusion| !matches!(of, Exclusion::TooWide { .. });
        all.clone().find(fits).or_else(|| all.clone().next())
    }
}
