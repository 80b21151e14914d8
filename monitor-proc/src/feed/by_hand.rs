//! Outcomes of requests to an arm that is led by hand: a gripper that closed on an object or on
//! nothing, an object that was torn off, a target that ended at a contact.
//!
//! Derived from the states, so that requests of the page, of the command line and of other
//! programs are all reported.

use cell_model::{ArmSpec, Cell};
use grasp::Solid;
use ipc_types::contact::BodyKind;
use ipc_types::equipment::{BreakCause, BreakLimit, SuctionRefusal};
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ArmState, GripperGoal, GripperState, WorldState};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};

/// Fingers that hold nothing after so many ticks have closed on nothing.
// The widest fingers close in less than a second.
const CLOSED_TICKS: u64 = 1_200;
/// A grip that is lost for fewer ticks is not reported: a finger may lift off for a moment.
const LOST_TICKS: u64 = 100;

/// A sentence for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Begins with the name of the arm.
    pub text: String,
    /// It is what the person wanted.
    pub is_good: bool,
}

/// Follows the states of a cell.
pub struct ByHand {
    arms: Vec<ArmSpec>,
    objects: Vec<(String, Solid)>,
    fixtures: Vec<String>,
    before: Option<Before>,
    /// A gripper that was told to close: the arm, and the tick.
    closing: Option<(usize, u64)>,
    /// By arm: the object that it held last, and the last tick at which it did.
    held: Vec<(Option<usize>, u64)>,
    /// By arm: whether the last request of a person was to open its gripper.
    opened: Vec<bool>,
}

/// Counts of the last state.
#[derive(Clone, Copy)]
struct Before {
    generation: u32,
    scene_reset: u32,
    gripper_seq: u32,
    contact_stops: u32,
    /// Refusals and breaks, by arm.
    grips: [(u32, u32); ipc_types::MAX_ARMS],
}

impl ByHand {
    /// For `cell`.
    pub fn new(cell: &Cell) -> Self {
        let objects = cell.objects.iter();
        Self {
            arms: cell.arms.clone(),
            objects: objects
                .map(|of| (of.name.clone(), Solid::of(&of.shape)))
                .collect(),
            fixtures: cell.fixtures.iter().map(|of| of.name.clone()).collect(),
            before: None,
            closing: None,
            held: vec![(None, 0); cell.arms.len()],
            opened: vec![false; cell.arms.len()],
        }
    }

    /// The outcomes since the last state.
    pub fn update(&mut self, world: &WorldState) -> Vec<Outcome> {
        let (now, panel) = (Before::of(world), &world.panel);
        let before = self.before.replace(now);
        // Another start of physics, or another scene: counters of the one before are not compared.
        let same =
            |old: &Before| (old.generation, old.scene_reset) == (now.generation, now.scene_reset);
        let Some(before) = before.filter(same) else {
            self.closing = None;
            self.held.fill((None, 0));
            self.opened.fill(false);
            self.note_opened(world);
            return Vec::new();
        };
        let mut found = Vec::new();
        if panel.gripper_seq != before.gripper_seq {
            let closes = panel.gripper == GripperGoal::Close.code();
            self.closing = closes.then_some((panel.target_arm as usize, world.header.tick));
            self.note_opened(world);
        }
        for (index, arm) in world.arms().iter().enumerate().take(self.arms.len()) {
            found.extend(self.closed(world, index, &arm.gripper, before.grips[index].0));
            if panel.task_paused != 0 {
                found.extend(self.lost(world, index, arm, before.grips[index].1));
            }
            self.note_held(world, index, &arm.gripper);
        }
        if panel.contact_stops != before.contact_stops {
            let with = self.body_name(panel.contact_with);
            let text = format!(
                "{} stopped at a contact: {with} presses with {:.0} N",
                self.arm_name(panel.target_arm as usize),
                panel.contact_force
            );
            found.push(Outcome {
                text,
                is_good: false,
            });
        }
        found
    }

    /// The end of a request to close the gripper of arm `index`.
    fn closed(
        &mut self,
        world: &WorldState,
        index: usize,
        gripper: &GripperState,
        refusals: u32,
    ) -> Option<Outcome> {
        let (_, since) = self.closing.filter(|(arm, _)| *arm == index)?;
        if let Some(object) = held(gripper) {
            let text = format!(
                "{} gripped {}",
                self.arm_name(index),
                self.object_name(object)
            );
            self.closing = None;
            return Some(Outcome {
                text,
                is_good: true,
            });
        }
        let is_late = world.header.tick > since + CLOSED_TICKS;
        let why = if gripper.refusals != refusals {
            match SuctionRefusal::from_code(gripper.refusal).unwrap_or_default() {
                SuctionRefusal::NotMovable => "the object there cannot be moved",
                SuctionRefusal::TooOblique => "the surface is too oblique for the cup",
                SuctionRefusal::None | SuctionRefusal::NothingThere => "nothing is there",
            }
        } else if is_late {
            "nothing is there"
        } else {
            return None;
        };
        self.closing = None;
        let nearest = self.nearest(world, index);
        let nearest = nearest.map_or_else(String::new, |(name, distance_m)| {
            format!(
                "; the nearest object is {name}, {:.0} mm away",
                1.0e3 * distance_m
            )
        });
        Some(Outcome {
            text: format!("{} gripped nothing: {why}{nearest}", self.arm_name(index)),
            is_good: false,
        })
    }

    /// An object that left the gripper without a request.
    fn lost(
        &mut self,
        world: &WorldState,
        index: usize,
        arm: &ArmState,
        breaks: u32,
    ) -> Option<Outcome> {
        let (Some(object), since) = self.held[index] else {
            return None;
        };
        let (gripper, name) = (&arm.gripper, self.object_name(object));
        let text = if gripper.breaks != breaks {
            let why = self.why_broken(index, gripper);
            format!(
                "{} lost {name}: it was torn off, {why}",
                self.arm_name(index)
            )
        } else if held(gripper).is_none()
            && world.header.tick > since + LOST_TICKS
            && !self.opened[index]
        {
            format!(
                "{} lost {name}: it slipped out of the fingers",
                self.arm_name(index)
            )
        } else {
            return None;
        };
        self.held[index].0 = None;
        Some(Outcome {
            text,
            is_good: false,
        })
    }

    fn why_broken(&self, index: usize, gripper: &GripperState) -> String {
        let suction = self.arms[index].robot.suction.as_ref();
        let limits = suction.map_or((0.0, 0.0), |of| (of.force_limit, of.torque_limit));
        let by = match BreakCause::from_code(gripper.break_cause).unwrap_or_default() {
            BreakCause::Impulse => "by an impact",
            BreakCause::Weight | BreakCause::None => "by its weight or a pull",
        };
        match BreakLimit::from_code(gripper.break_limit).unwrap_or_default() {
            BreakLimit::Torque => format!(
                "{by}: {:.1} N m at most, the cup holds {:.1} N m",
                gripper.peak_torque, limits.1
            ),
            BreakLimit::Force | BreakLimit::None => format!(
                "{by}: {:.0} N at most, the cup holds {:.0} N",
                gripper.peak_force, limits.0
            ),
        }
    }

    fn note_held(&mut self, world: &WorldState, index: usize, gripper: &GripperState) {
        if let Some(object) = held(gripper) {
            self.held[index] = (Some(object), world.header.tick);
        } else if world.panel.task_paused == 0 || self.opened[index] {
            // Opened by the task, or by the person.
            self.held[index].0 = None;
        }
    }

    /// Notes the goal of the last request to a gripper.
    fn note_opened(&mut self, world: &WorldState) {
        let panel = &world.panel;
        if let Some(opened) = self.opened.get_mut(panel.target_arm as usize) {
            *opened = panel.gripper == GripperGoal::Open.code();
        }
    }

    /// The object whose surface is nearest to the tool centre point (m).
    fn nearest(&self, world: &WorldState, index: usize) -> Option<(&str, f64)> {
        let tcp = Point3::from(world.arms().get(index)?.tcp.position);
        let here = self.objects.iter().zip(world.objects());
        let here = here.filter(|(_, state)| state.flags & OBJECT_ENABLED != 0);
        let distances = here.map(|((name, solid), state)| {
            let [w, x, y, z] = state.pose.orientation_wxyz;
            let pose = Isometry3::from_parts(
                Translation3::from(state.pose.position),
                UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
            );
            (name.as_str(), solid.distance_to(&pose, &tcp))
        });
        distances.min_by(|one, other| one.1.total_cmp(&other.1))
    }

    fn arm_name(&self, index: usize) -> &str {
        self.arms.get(index).map_or("the arm", |arm| &arm.name)
    }

    fn object_name(&self, index: usize) -> &str {
        self.objects
            .get(index)
            .map_or("an object", |(name, _)| name)
    }

    fn body_name(&self, body: u32) -> &str {
        let index = (body & 0xffff) as usize;
        match BodyKind::from_code(body >> 16) {
            Some(BodyKind::Object) => self.object_name(index),
            Some(BodyKind::Fixture) => self.fixtures.get(index).map_or("a fixture", |name| name),
            Some(BodyKind::Arm) => self.arm_name(index),
            None => "something",
        }
    }
}

impl Before {
    fn of(world: &WorldState) -> Self {
        let mut grips = [(0, 0); ipc_types::MAX_ARMS];
        for (slot, arm) in grips.iter_mut().zip(world.arms()) {
            *slot = (arm.gripper.refusals, arm.gripper.breaks);
        }
        Self {
            generation: world.header.generation,
            scene_reset: world.panel.scene_reset,
            gripper_seq: world.panel.gripper_seq,
            contact_stops: world.panel.contact_stops,
            grips,
        }
    }
}

/// Index of the object in the gripper.
fn held(gripper: &GripperState) -> Option<usize> {
    (gripper.held_object as usize).checked_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    fn world(tick: u64) -> WorldState {
        let mut world = WorldState::zeroed();
        (world.header.tick, world.arm_count, world.object_count) = (tick, 1, 5);
        world.panel.task_paused = 1;
        for (index, object) in world.objects.iter_mut().enumerate() {
            (object.flags, object.pose) = (OBJECT_ENABLED, ipc_types::Pose::IDENTITY);
            object.pose.position[0] = 0.1 * (1 + index) as f64;
        }
        world.arms[0].tcp = ipc_types::Pose::IDENTITY;
        world
    }

    /// The outcomes while `change` is in force from the second state on.
    fn reported(cell: &str, change: impl Fn(&mut WorldState)) -> Vec<String> {
        let cell = Cell::load(&cell_model::Data::checkout(), cell, 1, None).unwrap();
        let mut by_hand = ByHand::new(&cell);
        assert_eq!(by_hand.update(&world(1)), []);
        let mut texts = Vec::new();
        for tick in 2..2_000 {
            let mut world = world(tick);
            change(&mut world);
            texts.extend(by_hand.update(&world).into_iter().map(|of| of.text));
        }
        texts
    }

    fn close(world: &mut WorldState) {
        (world.panel.gripper_seq, world.panel.gripper) = (1, GripperGoal::Close.code());
    }

    #[test]
    fn a_gripper_that_closes_says_what_it_holds_or_how_far_away_the_nearest_object_is() {
        let gripped = reported("franka-stack", |world| {
            close(world);
            world.arms[0].gripper.held_object = u32::from(world.header.tick > 500);
        });
        assert_eq!(gripped, ["panda gripped red_cube"]);
        let nothing = reported("franka-stack", close);
        assert_eq!(
            nothing,
            ["panda gripped nothing: nothing is there; the nearest object is red_cube, 75 mm away"]
        );
        let refused = reported("ur10-fill-bin", |world| {
            close(world);
            world.arms[0].gripper.refusals = 1;
            world.arms[0].gripper.refusal = SuctionRefusal::TooOblique.code();
        });
        assert_eq!(refused.len(), 1);
        assert!(
            refused[0].contains("too oblique for the cup"),
            "{refused:?}"
        );
    }

    #[test]
    fn what_is_lost_and_what_stops_the_arm_is_reported_once() {
        let torn = reported("ur10-fill-bin", |world| {
            let tick = world.header.tick;
            let gripper = &mut world.arms[0].gripper;
            gripper.held_object = u32::from(tick < 100);
            (gripper.breaks, gripper.peak_force) = (u32::from(tick >= 100), 143.0);
            (gripper.break_limit, gripper.break_cause) =
                (BreakLimit::Force.code(), BreakCause::Weight.code());
        });
        assert_eq!(torn.len(), 1);
        assert!(torn[0].contains("143 N at most, the cup holds"), "{torn:?}");
        let slipped = reported("franka-stack", |world| {
            world.arms[0].gripper.held_object = u32::from(world.header.tick < 100);
        });
        assert_eq!(
            slipped,
            ["panda lost red_cube: it slipped out of the fingers"]
        );
        let opened = reported("franka-stack", |world| {
            let tick = world.header.tick;
            world.arms[0].gripper.held_object = u32::from(tick < 100);
            if tick >= 90 {
                (world.panel.gripper_seq, world.panel.gripper) = (1, GripperGoal::Open.code());
            }
        });
        assert_eq!(opened, [""; 0]);
        let of_the_other_arm = reported("franka-pyramid", |world| {
            let tick = world.header.tick;
            world.arm_count = 2;
            world.arms[1].gripper.held_object = u32::from(tick < 100);
            if tick >= 90 {
                (world.panel.gripper_seq, world.panel.gripper) = (1, GripperGoal::Open.code());
            }
        });
        assert_eq!(of_the_other_arm.len(), 1, "{of_the_other_arm:?}");
        let stopped = reported("franka-stack", |world| {
            let panel = &mut world.panel;
            (panel.contact_stops, panel.contact_force) = (1, 34.2);
            panel.contact_with = BodyKind::Fixture.code() << 16;
        });
        assert_eq!(stopped.len(), 1);
        assert!(stopped[0].ends_with("presses with 34 N"), "{stopped:?}");
    }
}
