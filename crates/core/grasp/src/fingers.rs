//! Candidates for two fingers.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::candidate::{Approach, Candidate, Depth, Exclusion};
use crate::directions::{approaches, closings, rotation};
use crate::gripper::Hand;
use crate::scene::{Body, Scene};

/// Clearance of each finger to the object, to fixtures and to other objects before it closes (m).
const FINGER_CLEARANCE_M: f64 = 0.001;
/// Clearance of each finger to the sides of the object where the hand cannot open fully (m).
const SIDES_M: [f64; 2] = [0.012, 0.006];
/// Clearance of the hand to fixtures, objects and other arms, which move (m).
const MARGINS_M: (f64, f64, f64) = (0.5 * FINGER_CLEARANCE_M, FINGER_CLEARANCE_M, 0.01);
/// Shortest length of the pads that has to touch the object (m).
const OVERLAP_M: f64 = 0.002;
/// Distances before the grasp at which the open hand is checked (m): a finger is 15 mm thick.
const WAY_M: [f64; 6] = [0.0, 0.012, 0.025, 0.05, 0.075, 0.1];
/// Step of the search for the lowest depth (m).
const STEP_M: f64 = 0.001;

/// The candidates for `object`, which is at `pose`, in groups that differ in opening and depth;
/// `tool` is the present pose of the TCP. `add` gets the candidates of a group and the least cost
/// of those that follow, and returns whether it has enough.
pub(crate) fn candidates(
    hand: &Hand,
    scene: &Scene,
    (object, pose): (&Body, &Isometry3<f64>),
    tool: Option<&Isometry3<f64>>,
    mut add: impl FnMut(Vec<Candidate>, f64) -> bool,
) {
    let mut all = grasps(object, pose, tool);
    // A stable sort: equal costs keep the order of the shape's axes.
    all.sort_by(|a, b| a.least_cost.total_cmp(&b.least_cost));
    for (index, grasp) in all.iter().enumerate() {
        let next = all.get(index + 1);
        let least = next.map_or(f64::INFINITY, |next| next.least_cost);
        if add(grasp.candidates(hand, scene, object), least) {
            return;
        }
    }
}

/// All directions from which, and in which, fingers close around an object.
fn grasps(object: &Body, pose: &Isometry3<f64>, tool: Option<&Isometry3<f64>>) -> Vec<Grasp> {
    let mut all = Vec::new();
    let centred = Isometry3::from_parts(Translation3::identity(), pose.rotation);
    for closing in closings(&object.shape, pose) {
        // About the centre, so that a symmetric shape is gripped at its centre to the last bit.
        let (low, high) = object.solid.extent(&centred, &closing.axis);
        for (approach, direction) in approaches(&closing.axis) {
            let extent = object.solid.extent(pose, &direction);
            for axis in [closing.axis, -closing.axis] {
                let rotation = rotation(&direction, &axis);
                let turn = tool.map_or(0.0, |tool| tool.rotation.angle_to(&rotation));
                let least_cost = cost(approach, Depth::Centre) + 0.1 * turn + (high - low);
                all.push(Grasp {
                    approach,
                    rotation,
                    centre: pose.translation.vector + closing.axis * (0.5 * (low + high)),
                    direction,
                    extent,
                    half: closing.half(&direction),
                    width_m: high - low,
                    // Rounded, so that the last bits of an angle decide nothing.
                    least_cost: (1.0e6 * least_cost).round() * 1.0e-6,
                });
            }
        }
    }
    all
}

/// From above is best understood and has the shortest way back; the centre holds best.
fn cost(approach: Approach, depth: Depth) -> f64 {
    let of_approach = match approach {
        Approach::Above => 0.0,
        Approach::Oblique => 1.0,
        Approach::Side => 1.5,
    };
    let of_depth = match depth {
        Depth::Centre | Depth::Face => 0.0,
        Depth::Low => 0.2,
        Depth::Upper => 0.3,
    };
    of_approach + of_depth
}

/// A grasp whose depth is open.
struct Grasp {
    approach: Approach,
    rotation: UnitQuaternion<f64>,
    /// Between the fingers.
    centre: Vector3<f64>,
    /// Of the approach.
    direction: Vector3<f64>,
    /// Of the object along the direction (m).
    extent: (f64, f64),
    /// Half of the face that the pads can touch, along the direction (m).
    half: f64,
    width_m: f64,
    /// Cost of its cheapest candidate.
    least_cost: f64,
}

impl Grasp {
    /// Its candidates with the open hand and, where surroundings exclude them all, with a hand that
    /// is opened as far as the object needs.
    fn candidates(&self, hand: &Hand, scene: &Scene, object: &Body) -> Vec<Candidate> {
        let mut all = Vec::new();
        let widths = SIDES_M.map(|side| self.width_m + 2.0 * side);
        let narrower = widths
            .into_iter()
            .filter(|width| *width < hand.open_width_m);
        for opening_m in std::iter::once(hand.open_width_m).chain(narrower) {
            for (depth, at) in self.depths(hand, scene, opening_m) {
                all.push(self.candidate(hand, scene, object, (opening_m, depth, at)));
            }
            let is_free = all.iter().any(|of: &Candidate| of.excluded.is_none());
            let is_wide = self
                .misfit(hand, self.middle())
                .is_some_and(|why| matches!(why, Exclusion::TooWide { .. }));
            if is_free || is_wide {
                break;
            }
        }
        all
    }

    fn candidate(
        &self,
        hand: &Hand,
        scene: &Scene,
        object: &Body,
        (opening_m, depth, at): (f64, Depth, f64),
    ) -> Candidate {
        let tcp = self.tcp(at);
        let excluded = self
            .misfit(hand, at)
            .map(|why| self.beside(hand, scene).unwrap_or(why))
            .or_else(|| blocked(hand, scene, object, (&tcp, opening_m, self.width_m)));
        let narrow = if opening_m < hand.open_width_m {
            0.1
        } else {
            0.0
        };
        let of_depth = cost(self.approach, depth) - cost(self.approach, Depth::Centre);
        Candidate {
            tcp,
            approach: self.approach,
            depth,
            width_m: self.width_m,
            opening_m,
            cost: self.least_cost + of_depth + narrow,
            excluded,
        }
    }

    /// The TCP with its coordinate `at` along the direction.
    fn tcp(&self, at: f64) -> Isometry3<f64> {
        let off = at - self.direction.dot(&self.centre);
        Isometry3::from_parts((self.centre + self.direction * off).into(), self.rotation)
    }

    /// Centre of the face along the direction.
    fn middle(&self) -> f64 {
        self.direction.dot(&self.centre)
    }

    fn depths(&self, hand: &Hand, scene: &Scene, opening_m: f64) -> Vec<(Depth, f64)> {
        let middle = self.middle();
        let upper = self.extent.0 + hand.tip_m;
        let fits = |at: &f64| self.misfit(hand, *at).is_none();
        // Where something beside the object leaves no depth, that of closed fingers: then it is
        // named, and not what the object rests on.
        let low = self
            .lowest(hand, scene, opening_m, middle)
            .filter(fits)
            .or_else(|| self.lowest(hand, scene, self.width_m, middle));
        let low = low.unwrap_or(middle);
        let depth = if low < middle {
            Depth::Low
        } else {
            Depth::Centre
        };
        let mut depths = vec![(depth, low)];
        if upper < middle - STEP_M {
            depths.push((Depth::Upper, upper));
        }
        depths
    }

    /// The deepest place, at most the centre, at which the fingers touch no fixture.
    fn lowest(&self, hand: &Hand, scene: &Scene, opening_m: f64, middle: f64) -> Option<f64> {
        let is_clear = |at: &f64| {
            let tcp = self.tcp(*at);
            !scene.fixtures.iter().any(|fixture| {
                let mut fingers = hand.fingers_at(&tcp, opening_m);
                fingers.any(|(solid, at)| fixture.is_near(solid, &at, FINGER_CLEARANCE_M))
            })
        };
        // A little more than where the pads miss it: then it is too thin, not blocked.
        let end = self.extent.0 - hand.tip_m - 4.0 * FINGER_CLEARANCE_M;
        let steps = std::iter::successors(Some(middle), |at| Some(at - STEP_M));
        let mut steps = steps.take_while(|at| *at > end);
        steps.find(is_clear)
    }

    /// A fixture beside the object that keeps the closed fingers from it; not one that the object
    /// rests on.
    fn beside(&self, hand: &Hand, scene: &Scene) -> Option<Exclusion> {
        if self.width_m > hand.open_width_m {
            return None;
        }
        let tcp = self.tcp(self.extent.0 + BESIDE_M - hand.tip_m);
        let found = scene.fixtures.iter().find(|fixture| {
            let mut fingers = hand.fingers_at(&tcp, self.width_m);
            let Some(pose) = fixture.pose else {
                return false;
            };
            // Along the approach its near end is before the far end of the object.
            fixture.extent(&pose, &self.direction).0 < self.extent.1 - FINGER_CLEARANCE_M
                && fingers.any(|(solid, at)| fixture.is_near(solid, &at, FINGER_CLEARANCE_M))
        });
        found.map(|fixture| Exclusion::Fixture(fixture.name.clone()))
    }

    /// Whether the object fits between the fingers, and the pads touch it.
    fn misfit(&self, hand: &Hand, at: f64) -> Option<Exclusion> {
        let opens_m = hand.open_width_m - 2.0 * FINGER_CLEARANCE_M;
        if self.width_m > opens_m {
            let width_m = self.width_m;
            return Some(Exclusion::TooWide { width_m, opens_m });
        }
        let (low, high) = (self.middle() - self.half, self.middle() + self.half);
        let overlap_m = (at + hand.tip_m).min(high) - (at - hand.tip_m).max(low);
        // A round side is touched along a line, which has to be between the tips.
        let is_line = self.half < OVERLAP_M && (at - self.middle()).abs() < hand.tip_m - OVERLAP_M;
        (overlap_m < OVERLAP_M && !is_line).then(|| Exclusion::TooThin {
            overlap_m: overlap_m.max(0.0),
        })
    }
}

/// Part of the tips that is between the near end of an object and its far end, when fixtures
/// beside it are looked for (m).
const BESIDE_M: f64 = 2.0 * OVERLAP_M;

/// What the hand would touch on its way to `tcp` with this opening, or when it closes to
/// `width_m`.
fn blocked(
    hand: &Hand,
    scene: &Scene,
    object: &Body,
    (tcp, opening_m, width_m): (&Isometry3<f64>, f64, f64),
) -> Option<Exclusion> {
    let own = object.pose?;
    let touches_own = hand
        .palm
        .is_near(tcp, &object.solid, &own, FINGER_CLEARANCE_M);
    if touches_own {
        return Some(Exclusion::Hand);
    }
    blocked_on_way(hand, scene, object, (tcp, opening_m))
        .or_else(|| touched(hand, scene, object, (tcp, width_m)))
}

/// What the hand would touch on its way to or from `tcp`, with this width (m).
pub(crate) fn blocked_on_way(
    hand: &Hand,
    scene: &Scene,
    object: &Body,
    (tcp, width_m): (&Isometry3<f64>, f64),
) -> Option<Exclusion> {
    let back = tcp.rotation * -Vector3::z();
    WAY_M.iter().find_map(|off| {
        let at = Translation3::from(back * *off) * tcp;
        touched(hand, scene, object, (&at, width_m))
    })
}

fn touched(
    hand: &Hand,
    scene: &Scene,
    object: &Body,
    (tcp, width_m): (&Isometry3<f64>, f64),
) -> Option<Exclusion> {
    scene.touched(object, MARGINS_M, |body, margin| {
        is_near(hand, (tcp, width_m), body, margin)
    })
}

/// Whether a hand with this width is nearer to `body` than `margin` (m).
pub(crate) fn is_near(
    hand: &Hand,
    (tcp, width_m): (&Isometry3<f64>, f64),
    body: &Body,
    margin: f64,
) -> bool {
    let mut fingers = hand.fingers_at(tcp, width_m);
    body.is_near(&hand.palm, tcp, margin)
        || fingers.any(|(solid, at)| body.is_near(solid, &at, margin))
}
