//! `robocell joints`: leads an arm to a joint configuration.

use ipc_types::operator::OperatorAction;
use ipc_types::world::FLAG_PAUSED;
use ipc_types::{ArmState, MAX_JOINTS, WorldState};
use supervisor::failure::Failure;

use super::approach::{AWAY_TICKS, Arrival, REST, REST_TICKS, contact_since};
use super::follow::Follower;
use super::hand::{contact_stop, in_parentheses, not_reached, state_of_led_cell};
use super::operate::{ask_physics, request};
use super::session::Session;
use crate::args::JointsArgs;
use crate::say;

/// Closer to the target than this is at it (rad or m): with a cube in the gripper the
/// drives of a Franka rest 6 mrad away.
const NEAR: f64 = 1.0e-2;

/// `robocell joints A1 A2 ...`: returns when the arm is at rest.
pub(crate) fn joints(args: &JointsArgs) -> Result<(), Failure> {
    let led = &args.movement.of;
    let session = Session::of(&led.cell.cell)?;
    let bus = session.join()?;
    let mut world = Follower::new(&session, &bus)?;
    let state = state_of_led_cell(&session, &mut world)?;
    let arm = state.arms().get(led.arm as usize);
    let count = arm.map_or(0, |arm| arm.joint_count as usize);
    if arm.is_none() || args.values.len() != count {
        return Err(Failure::usage(format!(
            "{} joint positions were given; arm {} of this cell has {count} joints",
            args.values.len(),
            led.arm
        )));
    }
    let cell = session.load_cell()?;
    let units = cell.arms.get(led.arm as usize);
    let units = units.map_or_else(Vec::new, |arm| arm.robot.arm_units());
    let target = target(&args.values, &units, args.movement.deg);
    let mut wish = request(OperatorAction::Joints);
    (wish.arm, wish.joints) = (led.arm, target);
    wish.contact_limit = args.movement.contact_limit;
    let stops = state.panel.contact_stops;
    let asked = ask_physics(&bus, &wish)?;
    if args.movement.no_wait {
        let time_s = asked.header.sim_time_ns as f64 * 1.0e-9;
        say::line(format_args!("joint target set at {time_s:.3} s"));
        return Ok(());
    }
    let mut rest_since = asked.header.tick;
    let (state, is_paused) = world.until(|state| {
        // First: an arm that a contact stopped is at rest, too.
        if contact_since(&state.panel, stops).is_some() {
            return Some((*state, false));
        }
        let arm = state.arms().get(led.arm as usize)?;
        if !rests(arm) {
            rest_since = state.header.tick;
        }
        let (error, _) = largest_error(&arm.joint_positions, &target, &units);
        let patience = if error < NEAR { REST_TICKS } else { AWAY_TICKS };
        let settled = state.header.tick > rest_since + patience;
        let is_paused = state.flags & FLAG_PAUSED != 0;
        (settled || is_paused).then_some((*state, is_paused))
    })?;
    if is_paused {
        say::line(format_args!(
            "joint target set at {:.3} s; the arm moves when simulated time is resumed",
            time_s(&state)
        ));
        return Ok(());
    }
    if let Some(Arrival::Contact(force_n, with)) = contact_since(&state.panel, stops) {
        return Err(contact_stop(&session, force_n, with, time_s(&state)));
    }
    report(&state, led.arm, &target, &units, || {
        not_reached(&bus, led.arm)
    })
}

/// Simulated time of a state (s).
fn time_s(state: &WorldState) -> f64 {
    state.header.sim_time_ns as f64 * 1.0e-9
}

/// The positions of the command line in rad and m.
fn target(values: &[f64], units: &[&str], in_degrees: bool) -> [f64; MAX_JOINTS] {
    let mut target = [0.0; MAX_JOINTS];
    for ((slot, value), unit) in target.iter_mut().zip(values).zip(units) {
        // `--deg` is about angles: prismatic joints stay in metres.
        let turns = in_degrees && *unit == "rad";
        *slot = if turns { value.to_radians() } else { *value };
    }
    target
}

fn rests(arm: &ArmState) -> bool {
    arm.joint_velocities.iter().all(|rate| rate.abs() < REST)
}

fn report(
    state: &WorldState,
    arm: u32,
    target: &[f64; MAX_JOINTS],
    units: &[&'static str],
    why: impl FnOnce() -> &'static str,
) -> Result<(), Failure> {
    let time_s = time_s(state);
    let measured = state.arms().get(arm as usize).map(|a| a.joint_positions);
    let measured = measured.unwrap_or(*target);
    let (error, unit) = largest_error(&measured, target, units);
    if error < NEAR {
        say::line(format_args!(
            "joint target reached at {time_s:.3} s, at most {error:.4} {unit} away"
        ));
        return Ok(());
    }
    Err(Failure::configuration(format!(
        "not reachable{}: the arm stopped {error:.4} {unit} away from the joint target at \
         {time_s:.3} s",
        in_parentheses(why())
    )))
}

/// The largest error of a joint, with its unit.
fn largest_error(
    measured: &[f64; MAX_JOINTS],
    target: &[f64; MAX_JOINTS],
    units: &[&'static str],
) -> (f64, &'static str) {
    let pairs = measured.iter().zip(target).zip(units);
    let errors = pairs.map(|((is, wanted), unit)| ((is - wanted).abs(), *unit));
    errors.fold((0.0, "rad"), |largest, error| {
        if error.0 > largest.0 { error } else { largest }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prismatic_joint_has_metres_in_degrees_and_errors() {
        let units = ["m", "rad"];
        let wanted = target(&[0.4, 180.0], &units, true);
        assert_eq!(wanted[..2], [0.4, std::f64::consts::PI]);
        let mut measured = wanted;
        measured[0] += 0.25;
        measured[1] -= 0.125;
        assert_eq!(largest_error(&measured, &wanted, &units), (0.25, "m"));
    }
}
