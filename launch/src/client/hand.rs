//! An arm led by hand from the command line.

use std::time::{Duration, Instant};

use cell_bus::Bus;
use cell_model::Cell;
use cell_rt::clock::monotonic_ns;
use ipc_types::arm::NotReached;
use ipc_types::contact::BodyKind;
use ipc_types::operator::OperatorAction;
use ipc_types::topic::TopicId;
use ipc_types::{ArmStatus, GripperGoal, Pose, WorldState};
use supervisor::failure::Failure;

use super::approach::{Approach, Arrival, MOST_S};
use super::follow::{Follower, PATIENCE};
use super::operate::{ask_physics, request, tell};
use super::session::Session;
use crate::args::{GripperArgs, GripperVerb, TargetArgs};
use crate::say;

/// How long a status is waited for.
const STATUS_PATIENCE: Duration = Duration::from_millis(200);
/// The policy that goes where the operator points, paused or not.
const FOLLOWS: &str = "follow";

/// `robocell gripper open|close`.
pub(crate) fn gripper(args: &GripperArgs) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::Gripper);
    wish.arm = args.of.arm;
    let (goal, done) = match args.verb {
        GripperVerb::Open => (GripperGoal::Open, "gripper opening"),
        GripperVerb::Close => (GripperGoal::Close, "gripper closing"),
    };
    wish.count = goal.code();
    let session = Session::of(&args.of.cell.cell)?;
    let bus = session.join()?;
    state_of_led_cell(&session, &mut Follower::new(&session, &bus)?)?;
    tell(&session, &wish, done)
}

/// `robocell target X Y Z [R P Y]`: returns when the arm is there, or at rest elsewhere.
pub(crate) fn target(args: &TargetArgs) -> Result<(), Failure> {
    let (position, angles) = match *args.values.as_slice() {
        [x, y, z] => ([x, y, z], None),
        [x, y, z, roll, pitch, yaw] => (
            [x, y, z],
            Some(radians([roll, pitch, yaw], args.movement.deg)?),
        ),
        _ => {
            return Err(Failure::usage(
                "a target has three values, or six with roll, pitch and yaw",
            ));
        }
    };
    let led = &args.movement.of;
    let session = Session::of(&led.cell.cell)?;
    let bus = session.join()?;
    let mut world = Follower::new(&session, &bus)?;
    let state = state_of_led_cell(&session, &mut world)?;
    let orientation_wxyz = match angles {
        None => present_orientation(&state, led.arm)?,
        Some([roll, pitch, yaw]) => quaternion(roll, pitch, yaw),
    };
    let mut wish = request(OperatorAction::Target);
    wish.arm = led.arm;
    wish.pose = Pose {
        position,
        orientation_wxyz,
    };
    wish.contact_limit = args.movement.contact_limit;
    let asked = ask_physics(&bus, &wish)?;
    if args.movement.no_wait {
        let time_s = asked.header.sim_time_ns as f64 * 1.0e-9;
        say::line(format_args!("target set at {time_s:.3} s"));
        return Ok(());
    }
    let mut approach = Approach::new(wish.pose, asked.header.tick);
    let (end, time_s) = world.until(|state| {
        let end = approach.look(state, led.arm)?;
        Some((end, state.header.sim_time_ns as f64 * 1.0e-9))
    })?;
    if let Arrival::Contact(force_n, with) = end {
        return Err(contact_stop(&session, force_n, with, time_s));
    }
    report(end, time_s, not_reached(&bus, led.arm))
}

/// The arm stopped at a contact.
pub(super) fn contact_stop(session: &Session, force_n: f64, with: u32, time_s: f64) -> Failure {
    // Without the cell file the force is still worth to be said.
    let name = session
        .load_cell()
        .ok()
        .and_then(|cell| body_name(&cell, with));
    let name = name.unwrap_or_else(|| "something".to_owned());
    Failure::configuration(format!(
        "contact: the arm stopped at {time_s:.3} s, {name} presses with {force_n:.0} N; \
         `--contact-limit` allows more"
    ))
}

/// Name of a body as in [`ipc_types::contact::Contact`].
fn body_name(cell: &Cell, body: u32) -> Option<String> {
    let index = (body & 0xffff) as usize;
    match BodyKind::from_code(body >> 16)? {
        BodyKind::Object => cell.objects.get(index).map(|of| of.name.clone()),
        BodyKind::Fixture => cell.fixtures.get(index).map(|of| of.name.clone()),
        BodyKind::Arm => cell.arms.get(index).map(|of| of.name.clone()),
    }
}

/// Why the controller of an arm says that it does not reach its target; empty where it says
/// nothing.
pub(super) fn not_reached(bus: &Bus, arm: u32) -> &'static str {
    let arm = u8::try_from(arm).ok().map(TopicId::ArmStatus);
    let mut latest = arm.and_then(|topic| bus.latest::<ArmStatus>(topic).ok());
    let until = Instant::now() + STATUS_PATIENCE;
    while let Some(latest) = &mut latest {
        if latest.refresh()
            && let Some(status) = latest.get()
        {
            return NotReached::from_code(status.not_reached).map_or("", NotReached::name);
        }
        // A controller that is being restarted sends nothing: the message is printed without a
        // reason.
        if Instant::now() > until {
            break;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    ""
}

/// ` (why)`, or nothing where there is no reason.
pub(super) fn in_parentheses(why: &str) -> String {
    if why.is_empty() {
        return String::new();
    }
    format!(" ({why})")
}

/// Says how the arm stopped.
fn report(end: Arrival, time_s: f64, why: &str) -> Result<(), Failure> {
    let away = |(distance_m, angle): (f64, f64)| {
        format!(
            "{:.1} mm and {:.1} deg",
            1.0e3 * distance_m,
            angle.to_degrees()
        )
    };
    match end {
        Arrival::Reached(error) => {
            say::line(format_args!(
                "target reached at {time_s:.3} s, {} away",
                away(error)
            ));
            Ok(())
        }
        Arrival::AtRest(error) => Err(Failure::configuration(format!(
            "not reachable{}: the arm stopped {} away from the target at {time_s:.3} s",
            in_parentheses(why),
            away(error)
        ))),
        Arrival::Moving(error) => {
            say::line(format_args!(
                "the arm still moves after {MOST_S} s, {} away from the target",
                away(error)
            ));
            Ok(())
        }
        Arrival::Paused => {
            say::line(format_args!(
                "target set at {time_s:.3} s; the arm moves when simulated time is resumed"
            ));
            Ok(())
        }
        // The caller reports a contact, as it can look up the name of the body.
        Arrival::Contact(..) | Arrival::Replaced => {
            say::line(format_args!("another target was given at {time_s:.3} s"));
            Ok(())
        }
    }
}

/// The angles of the command line in radians; those that look like degrees are refused.
fn radians(angles: [f64; 3], in_degrees: bool) -> Result<[f64; 3], Failure> {
    if in_degrees {
        return Ok(angles.map(f64::to_radians));
    }
    let limit = 2.0 * std::f64::consts::PI;
    match angles.iter().find(|angle| angle.abs() > limit) {
        None => Ok(angles),
        Some(angle) => Err(Failure::usage(format!(
            "{angle} rad is more than a turn; angles are in radians, from -{limit:.4} to \
             {limit:.4}: give `--deg` for degrees"
        ))),
    }
}

/// The state of a cell whose arms the operator leads; refused while the task leads them, because
/// its next decision would overwrite a target.
pub(super) fn state_of_led_cell(
    session: &Session,
    world: &mut Follower,
) -> Result<WorldState, Failure> {
    // Physics answers `task pause` before it publishes the state that shows it: a state from
    // before this command is not enough to refuse it.
    let asked_ns = monotonic_ns();
    let until = Instant::now() + PATIENCE;
    loop {
        let state = world.now()?;
        if state.panel.task_paused != 0 || session.spec.policy == FOLLOWS {
            return Ok(state);
        }
        if state.header.publish_ns > asked_ns || Instant::now() > until {
            return Err(Failure::configuration(
                "refused: the task leads the arm; `robocell task pause` gives it to you",
            ));
        }
    }
}

/// The orientation the operator gave last, or the one the tool has.
fn present_orientation(state: &WorldState, arm: u32) -> Result<[f64; 4], Failure> {
    let panel = &state.panel;
    if panel.target_seq > 0 && panel.target_arm == arm {
        return Ok(panel.target.orientation_wxyz);
    }
    let found = state.arms().get(arm as usize);
    found
        .map(|arm| arm.tcp.orientation_wxyz)
        .ok_or_else(|| Failure::configuration(format!("this cell has no arm {arm}")))
}

/// Rotation about the fixed axes x, y, z in this order, as w x y z.
fn quaternion(roll: f64, pitch: f64, yaw: f64) -> [f64; 4] {
    let ((sr, cr), (sp, cp), (sy, cy)) = (
        (roll / 2.0).sin_cos(),
        (pitch / 2.0).sin_cos(),
        (yaw / 2.0).sin_cos(),
    );
    [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
}

#[cfg(test)]
mod tests {
    use super::{quaternion, radians};

    #[test]
    fn roll_by_half_a_turn_points_the_tool_down() {
        let [w, x, y, z] = quaternion(std::f64::consts::PI, 0.0, 0.0);
        assert!(w.abs() < 1e-12 && (x - 1.0).abs() < 1e-12 && y.abs() < 1e-12 && z.abs() < 1e-12);
    }

    #[test]
    fn degrees_that_were_meant_as_such_are_not_taken_for_radians() {
        let pi = std::f64::consts::PI;
        assert_eq!(radians([0.0, 180.0, 0.0], true).unwrap(), [0.0, pi, 0.0]);
        assert_eq!(radians([0.0, pi, -pi], false).unwrap(), [0.0, pi, -pi]);
        let said = radians([0.0, 180.0, 0.0], false).unwrap_err().message;
        assert!(said.contains("180 rad") && said.contains("--deg"), "{said}");
    }

    #[test]
    fn yaw_turns_about_the_vertical_axis_last() {
        let q = quaternion(0.3, -0.2, 0.9);
        assert!((q.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12);
        let [w, x, y, z] = quaternion(0.0, 0.0, 1.0);
        assert!((w - 0.5_f64.cos()).abs() < 1e-12 && (z - 0.5_f64.sin()).abs() < 1e-12);
        assert!(x.abs() < 1e-12 && y.abs() < 1e-12);
    }
}
