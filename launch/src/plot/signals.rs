//! What of a recording can be plotted: the same signals, names and units as in the plots of
//! the page.

use ipc_types::decision::GoalKind;
use ipc_types::{ArmStatus, Decision, WorldState};
use serde_json::Value;

/// A controller without obstacles says 1000 m.
const NO_OBSTACLE_M: f64 = 999.0;
const MM: f64 = 1.0e3;
const AXES: [&str; 3] = ["x", "y", "z"];

/// Where the value of a signal is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// Of the states of the world.
    World(OfWorld),
    /// Of the statuses of the controller of an arm.
    Status(u8, OfStatus),
}

/// A number of a state; the first index is that of the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum OfWorld {
    Position(usize, usize),
    Setpoint(usize, usize),
    Error(usize, usize),
    Velocity(usize, usize),
    Effort(usize, usize),
    Tcp(usize, usize),
    Width(usize),
    /// Half of the width of the gripper: its fingers are not measured one by one.
    Finger(usize),
    FingerVelocity(usize),
    GripForce(usize),
    Load(usize),
    SuctionForce(usize),
    SuctionTorque(usize),
    /// Height of an object.
    Height(usize),
}

/// A number of a status.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum OfStatus {
    PositionError,
    Clearance,
}

/// A signal of a recording.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Signal {
    /// As in `left/joint1 position`.
    pub(super) name: String,
    pub(super) unit: &'static str,
    pub(super) source: Source,
    /// From the unit of the messages to `unit`.
    scale: f64,
}

/// The signals of a recording with this scene.
pub(super) fn signals(scene: &Value) -> Vec<Signal> {
    let mut all = Vec::new();
    for (index, arm) in list(&scene["arms"]).iter().enumerate() {
        add_arm(&mut all, index, arm);
    }
    for (index, object) in list(&scene["objects"]).iter().enumerate() {
        let source = Source::World(OfWorld::Height(index));
        let name = format!("objects/{} z", text(&object["name"]));
        all.push(signal(name, "m", 1.0, source));
    }
    all
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn signal(name: String, unit: &'static str, scale: f64, source: Source) -> Signal {
    Signal {
        name,
        unit,
        source,
        scale,
    }
}

fn add_arm(all: &mut Vec<Signal>, arm: usize, spec: &Value) {
    let group = text(&spec["name"]);
    let named = |name: &str, unit, scale, source| {
        let name = format!("{group}/{name}");
        signal(name, unit, scale, source)
    };
    let world = |name: &str, unit, scale, of| named(name, unit, scale, Source::World(of));
    let number = u8::try_from(arm).unwrap_or(u8::MAX);
    let status = |name, of| named(name, "mm", MM, Source::Status(number, of));
    all.push(status("distance to target", OfStatus::PositionError));
    all.push(status("clearance", OfStatus::Clearance));
    for (axis, name) in AXES.iter().enumerate() {
        let name = format!("TCP {name}");
        all.push(world(&name, "m", 1.0, OfWorld::Tcp(arm, axis)));
    }
    if text(&spec["gripper"]["kind"]) == "suction" {
        all.push(world("suction load", "%", 100.0, OfWorld::Load(arm)));
        all.push(world("suction force", "N", 1.0, OfWorld::SuctionForce(arm)));
        let torque = OfWorld::SuctionTorque(arm);
        all.push(world("suction torque", "N m", 1.0, torque));
    } else if !spec["gripper"].is_null() {
        all.push(world("gripper width", "mm", MM, OfWorld::Width(arm)));
        all.push(world("grip force", "N", 1.0, OfWorld::GripForce(arm)));
    }
    add_joints(all, group, arm, spec);
}

fn add_joints(all: &mut Vec<Signal>, group: &str, arm: usize, spec: &Value) {
    let joints = list(&spec["joints"]);
    let arm_joints = spec["arm_joints"].as_u64().unwrap_or(u64::MAX);
    let names: Vec<&str> = joints.iter().map(|joint| text(&joint["name"])).collect();
    for (joint, name) in short_names(&names).into_iter().enumerate() {
        let linear = text(&joints[joint]["kind"]) == "prismatic";
        let (unit, rate, effort, scale) = if linear {
            ("mm", "mm/s", "N", MM)
        } else {
            ("°", "°/s", "N m", 1.0_f64.to_degrees())
        };
        let mut add = |what: &str, unit, scale, of| {
            let name = format!("{group}/{name} {what}");
            all.push(signal(name, unit, scale, Source::World(of)));
        };
        if joint as u64 >= arm_joints {
            add("position", unit, scale, OfWorld::Finger(arm));
            add("velocity", rate, scale, OfWorld::FingerVelocity(arm));
            add("effort", effort, 1.0, OfWorld::GripForce(arm));
            continue;
        }
        add("position", unit, scale, OfWorld::Position(arm, joint));
        add("setpoint", unit, scale, OfWorld::Setpoint(arm, joint));
        add("error", unit, scale, OfWorld::Error(arm, joint));
        add("velocity", rate, scale, OfWorld::Velocity(arm, joint));
        add("effort", effort, 1.0, OfWorld::Effort(arm, joint));
    }
}

/// Without what all have in front, the robot's name, and without `_joint` behind.
fn short_names(names: &[&str]) -> Vec<String> {
    let first = names.first().copied().unwrap_or_default();
    let robot = first.find('_').map_or("", |end| &first[..=end]);
    let shared = names.iter().all(|name| name.starts_with(robot));
    let front = if shared { robot.len() } else { 0 };
    let short = |name: &&str| name[front..].trim_end_matches("_joint").to_owned();
    names.iter().map(short).collect()
}

impl Signal {
    /// Its value in a state; not a number where it has none.
    pub(super) fn of_world(&self, state: &WorldState) -> f64 {
        match self.source {
            Source::World(of) => self.scale * of.read(state).unwrap_or(f64::NAN),
            Source::Status(..) => f64::NAN,
        }
    }

    /// Its value in a status; not a number where it has none. The state and the decision
    /// of that time say whether there is a target.
    pub(super) fn of_status(
        &self,
        status: &ArmStatus,
        state: &WorldState,
        decision: Option<&Decision>,
    ) -> f64 {
        let value = match self.source {
            Source::Status(arm, OfStatus::PositionError) => {
                has_target(usize::from(arm), status, state, decision)
                    .then_some(status.position_error)
            }
            Source::Status(_, OfStatus::Clearance) => {
                Some(status.min_clearance).filter(|clearance| *clearance <= NO_OBSTACLE_M)
            }
            Source::World(_) => None,
        };
        self.scale * value.unwrap_or(f64::NAN)
    }
}

/// Whether the arm is led to a pose, by the task or by the operator.
fn has_target(
    arm: usize,
    status: &ArmStatus,
    state: &WorldState,
    decision: Option<&Decision>,
) -> bool {
    let panel = &state.panel;
    let led = panel.task_paused != 0 && panel.target_seq > 0 && panel.target_arm as usize == arm;
    let goal = decision.and_then(|decision| decision.goals.get(arm));
    let sent = goal.is_some_and(|goal| goal.kind == GoalKind::Pose.code());
    status.goal_active == 1 && (led || sent)
}

impl OfWorld {
    fn read(self, state: &WorldState) -> Option<f64> {
        let arm = |arm: usize| state.arms().get(arm);
        let gripper = |index: usize| arm(index).map(|arm| &arm.gripper);
        match self {
            Self::Position(a, joint) => arm(a)?.joint_positions.get(joint).copied(),
            Self::Setpoint(a, joint) => arm(a)?.setpoint_positions.get(joint).copied(),
            Self::Error(a, joint) => {
                let arm = arm(a)?;
                Some(arm.joint_positions.get(joint)? - arm.setpoint_positions.get(joint)?)
            }
            Self::Velocity(a, joint) => arm(a)?.joint_velocities.get(joint).copied(),
            Self::Effort(a, joint) => arm(a)?.joint_efforts.get(joint).copied(),
            Self::Tcp(a, axis) => arm(a)?.tcp.position.get(axis).copied(),
            Self::Width(a) => gripper(a).map(|gripper| gripper.width),
            // Both fingers move by half of it.
            Self::Finger(a) => gripper(a).map(|gripper| 0.5 * gripper.width),
            Self::FingerVelocity(a) => gripper(a).map(|gripper| 0.5 * gripper.width_velocity),
            Self::GripForce(a) => gripper(a).map(|gripper| gripper.grip_force),
            Self::Load(a) => gripper(a).map(|gripper| gripper.load),
            Self::SuctionForce(a) => gripper(a).map(|gripper| gripper.suction_force),
            Self::SuctionTorque(a) => gripper(a).map(|gripper| gripper.suction_torque),
            Self::Height(object) => Some(state.objects().get(object)?.pose.position[2]),
        }
    }
}

#[cfg(test)]
mod tests {
    use ipc_types::Wire as _;
    use serde_json::json;

    use super::*;

    fn scene() -> Value {
        json!({
            "arms": [{
                "name": "left",
                "gripper": { "kind": "parallel" },
                "arm_joints": 1,
                "joints": [
                    { "name": "panda_joint1", "kind": "revolute" },
                    { "name": "panda_finger_joint", "kind": "prismatic" },
                ],
            }],
            "objects": [{ "name": "red_cube" }],
        })
    }

    #[test]
    fn signals_have_the_names_and_units_of_the_page() {
        let all = signals(&scene());
        let unit = |name: &str| {
            let found = all.iter().find(|signal| signal.name == name);
            found.map(|signal| signal.unit)
        };
        for (name, wanted) in [
            ("left/distance to target", "mm"),
            ("left/TCP z", "m"),
            ("left/gripper width", "mm"),
            ("left/joint1 position", "°"),
            ("left/joint1 velocity", "°/s"),
            ("left/joint1 effort", "N m"),
            ("left/finger position", "mm"),
            ("objects/red_cube z", "m"),
        ] {
            assert_eq!(unit(name), Some(wanted), "{name}");
        }
        assert_eq!(unit("left/suction load"), None);
        assert_eq!(
            short_names(&["shoulder_pan_joint", "elbow_joint"]),
            ["shoulder_pan", "elbow"]
        );
    }

    #[test]
    fn values_are_in_the_units_that_are_named() {
        let all = signals(&scene());
        let mut state = WorldState::zeroed();
        (state.arm_count, state.object_count) = (1, 1);
        state.arms[0].joint_positions[0] = 0.5;
        state.arms[0].setpoint_positions[0] = 0.25;
        state.arms[0].gripper.width = 0.08;
        let value = |name: &str| {
            let found = all.iter().find(|signal| signal.name == name).unwrap();
            found.of_world(&state)
        };
        assert!((value("left/joint1 error") - 14.323_945).abs() < 1e-6);
        assert!((value("left/gripper width") - 80.0).abs() < 1e-9);
        assert!((value("left/finger position") - 40.0).abs() < 1e-9);
        assert!(value("left/distance to target").is_nan());
    }

    #[test]
    fn an_arm_without_a_target_has_no_position_error() {
        let error = &signals(&scene())[0];
        let (state, mut decision) = (WorldState::zeroed(), Decision::zeroed());
        let mut status = ArmStatus::zeroed();
        (status.goal_active, status.position_error) = (1, 0.002);
        assert!(error.of_status(&status, &state, Some(&decision)).is_nan());
        decision.goals[0].kind = GoalKind::Pose.code();
        assert!((error.of_status(&status, &state, Some(&decision)) - 2.0).abs() < 1e-12);
    }
}
