//! Commands of clients: a message in, a request to physics or the reason of a refusal out.
//!
//! The network can hold a message back: TCP delivers after a cut of the link what was sent
//! meanwhile, and without the check of its age an arm followed targets that were 5 s old
//! (ADR 0024). So a target needs a time, by the clock of the cell or by that of the sender.

use ipc_types::operator::OperatorAction;
use ipc_types::{OperatorRequest, Pose, WorldState};

use crate::endpoints::Command;
use crate::ros::attachment::Attachment;
use crate::ros::decode;
use crate::ros::messages::PoseStamped;

/// A target older than this is refused (ns): the network may have held it back.
// A dragging person sends many a second, so an older one is never the newest wish.
pub const MOST_AGE_NS: i64 = 1_000_000_000;
/// The policy that moves an arm to the operator's target.
const FOLLOWS: &str = "follow";
/// A quaternion may deviate by this much from a unit; it is normalised.
// Single precision and rounding of a client; a larger error is another quantity.
const NEAR_UNIT: f64 = 1.0e-3;

/// State of the cell when a command arrives.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// The newest state.
    pub world: &'a WorldState,
    /// Policy of the task.
    pub policy: &'a str,
    /// Calendar time of this host (ns since 1970).
    pub wall_ns: i64,
}

/// The request for `command`, of a message received as `payload` and `attachment`.
///
/// # Errors
/// The reason of the refusal.
pub fn request(
    command: Command,
    payload: &[u8],
    attachment: Option<Attachment>,
    now: &Situation<'_>,
) -> Result<OperatorRequest, String> {
    match command {
        Command::Target { arm } => {
            let message: PoseStamped = decode(payload)
                .ok_or("the message is not a geometry_msgs/msg/PoseStamped in CDR")?;
            // The age first: an old target is refused as old, even if it has other defects.
            check_age(&message, attachment, now)?;
            must_lead(now)?;
            Ok(OperatorRequest {
                arm,
                pose: pose(&message)?,
                ..of(OperatorAction::Target)
            })
        }
        Command::Gripper { arm, goal } => {
            must_lead(now)?;
            Ok(OperatorRequest {
                arm,
                count: goal.code(),
                ..of(OperatorAction::Gripper)
            })
        }
        Command::Task(action) => Ok(of(action)),
    }
}

fn of(action: OperatorAction) -> OperatorRequest {
    OperatorRequest {
        action: action.code(),
        ..OperatorRequest::zeroed_at_identity()
    }
}

/// While the task moves the arm it ignores targets; so the client gets a refusal.
fn must_lead(now: &Situation<'_>) -> Result<(), String> {
    if now.world.panel.task_paused == 0 && now.policy != FOLLOWS {
        return Err("the task leads the arm; call /task/pause first".to_owned());
    }
    Ok(())
}

/// A target without a stamp has the age of its attachment.
fn check_age(
    message: &PoseStamped,
    attachment: Option<Attachment>,
    now: &Situation<'_>,
) -> Result<(), String> {
    let stamp_ns = message.header.stamp.ns();
    let sim_ns = i64::try_from(now.world.header.sim_time_ns).unwrap_or(i64::MAX);
    // ROS uses a stamp of zero for "none".
    let (age_ns, clock) = if stamp_ns != 0 {
        (sim_ns.saturating_sub(stamp_ns), "/clock")
    } else {
        let sent = attachment.ok_or("it has neither a stamp nor an attachment of rmw_zenoh")?;
        (now.wall_ns.saturating_sub(sent.source_ns), "this host")
    };
    // Also from the future: then the clocks differ, and the age means nothing.
    if age_ns.saturating_abs() <= MOST_AGE_NS {
        return Ok(());
    }
    let (age, most) = (age_ns as f64 * 1.0e-9, MOST_AGE_NS as f64 * 1.0e-9);
    Err(format!(
        "it is {age:.3} s old by the clock of {clock}; {most} s are allowed: set \
         header.stamp to the time of /clock, or to zero where clocks of hosts agree"
    ))
}

/// The message's pose, in the world frame.
fn pose(message: &PoseStamped) -> Result<Pose, String> {
    let frame = message.header.frame_id.as_str();
    // An empty frame is taken for the world, as many tools leave it out.
    if !["", crate::outgoing::WORLD].contains(&frame) {
        return Err(format!("frame_id is \"{frame}\"; \"world\" is allowed"));
    }
    let (at, turn) = (message.pose.position, message.pose.orientation);
    let wxyz = [turn.w, turn.x, turn.y, turn.z];
    let norm = wxyz.iter().map(|part| part * part).sum::<f64>().sqrt();
    let is_unit = (norm - 1.0).abs() <= NEAR_UNIT;
    if !is_unit {
        return Err(format!("orientation has length {norm}; 1 is allowed"));
    }
    if ![at.x, at.y, at.z].iter().all(|part| part.is_finite()) {
        return Err("position is not finite".to_owned());
    }
    Ok(Pose {
        position: [at.x, at.y, at.z],
        orientation_wxyz: wxyz.map(|part| part / norm),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros::encode;
    use crate::ros::messages::Time;
    use ipc_types::Wire as _;

    const TARGET: Command = Command::Target { arm: 0 };

    /// At 5 s of simulated time, with the task paused.
    fn world() -> WorldState {
        let mut world = WorldState::zeroed();
        world.header.sim_time_ns = 5_000_000_000;
        world.panel.task_paused = 1;
        world
    }

    fn ask(
        message: &PoseStamped,
        sent_ns: i64,
        world: &WorldState,
    ) -> Result<OperatorRequest, String> {
        let now = Situation {
            world,
            policy: "fsm",
            wall_ns: 70_000_000_000,
        };
        let attachment = Attachment {
            sequence: 1,
            source_ns: sent_ns,
            gid: [0; 16],
        };
        request(TARGET, &encode(message).unwrap(), Some(attachment), &now)
    }

    fn stamped(sec: i32) -> PoseStamped {
        let mut message = PoseStamped::default();
        message.header.stamp = Time { sec, nanosec: 0 };
        message.pose.position.x = 0.4;
        message
    }

    #[test]
    fn a_target_that_the_network_held_back_is_refused() {
        let world = world();
        let fresh = ask(&stamped(5), 0, &world).unwrap();
        assert_eq!(fresh.action, OperatorAction::Target.code());
        assert!((fresh.pose.position[0] - 0.4).abs() < 1e-12);
        let said = ask(&stamped(2), 0, &world).unwrap_err();
        assert!(
            said.contains("3.000 s old") && said.contains("/clock"),
            "{said}"
        );
        // Without a stamp, by the time it was sent.
        ask(&stamped(0), 69_500_000_000, &world).unwrap();
        let said = ask(&stamped(0), 65_000_000_000, &world).unwrap_err();
        assert!(said.contains("5.000 s old"), "{said}");
    }

    #[test]
    fn what_is_no_pose_in_the_world_is_refused_with_its_value() {
        let world = world();
        let mut other = stamped(5);
        other.header.frame_id = "panda_hand".to_owned();
        assert!(ask(&other, 0, &world).unwrap_err().contains("panda_hand"));
        let mut turned = stamped(5);
        turned.pose.orientation.w = 2.0;
        assert!(ask(&turned, 0, &world).unwrap_err().contains("length 2"));
        let mut nan = stamped(5);
        nan.pose.position.y = f64::NAN;
        assert!(ask(&nan, 0, &world).unwrap_err().contains("finite"));
        nan.pose.orientation.x = f64::NAN;
        ask(&nan, 0, &world).unwrap_err();
    }

    #[test]
    fn an_arm_that_the_task_leads_is_not_taken_from_it() {
        let mut world = world();
        world.panel.task_paused = 0;
        assert!(
            ask(&stamped(5), 0, &world)
                .unwrap_err()
                .contains("/task/pause")
        );
    }
}
