//! Whether a target can move the tip: a robot that loads and then does not move has to report
//! the reason.

use nalgebra::Vector3;

use crate::random::Random;
use crate::robots::robot::Robot;
use crate::robots::urdf::independent;

/// Number of tips that a message names: more do not help to choose one.
pub(super) const MOST_CANDIDATES: usize = 12;
/// Number of configurations that are tried.
const TRIALS: usize = 32;
/// A tip that moves by less than this does not move visibly (m).
const LEAST_WAY: f64 = 1.0e-3;
/// A tip that needs longer than this for [`LEAST_WAY`] seems not to move (s).
const LONGEST: f64 = 1.0;
/// Step of the difference quotients (rad or m).
const STEP: f64 = 1.0e-6;
/// A joint that moves the tip by less than this does not move it (m/rad or m/m).
const LEAST_GAIN: f64 = 1.0e-6;

/// How a user defines the end of the arm.
#[derive(Clone, Copy)]
pub(crate) enum TipOption {
    /// On the command line; the arm has the joints before that link.
    Flag,
    /// In a file or on the command line; the file names the joints.
    FlagOnly,
    /// In `robot.toml`; the file names the joints.
    Key,
}

/// Effect of one joint on the tip, the largest over the configurations tried.
#[derive(Clone, Copy, Default)]
struct Effect {
    /// Motion of the tip per motion of the joint (m/rad or m/m).
    gain: f64,
    /// Distance between two positions of its range (m).
    way: f64,
}

impl Robot {
    /// Warns if no target can move the tip: the joints turn about axes through it, are not
    /// before it or have no range; the limits are near zero; the tuning has no pull.
    pub(crate) fn warn_if_tip_stays(&mut self, file: &str, option: TipOption) {
        let effects = self.effects();
        let way: f64 = effects.iter().map(|effect| effect.way).sum();
        if way < LEAST_WAY {
            let why = self.why_it_stays(&effects);
            let is_narrow = effects.iter().any(|effect| effect.gain >= LEAST_GAIN);
            let remedy = self.other_tips(option, is_narrow);
            self.warnings.push(format!(
                "{file}: no target can change the position of the tip '{}': {why}; {remedy}",
                self.tcp_frame_name()
            ));
        } else {
            let said = [self.slow(&effects), self.confined()].into_iter().flatten();
            let said: Vec<String> = said.map(|said| format!("{file}: {said}")).collect();
            self.warnings.extend(said);
        }
        if let Some(weak) = self.without_pull() {
            self.warnings.push(format!(
                "the tuning of '{}': rmp_params.target_rmp.{weak} is 0, so no target pulls the \
                 tip; give it a number above 0",
                self.name
            ));
        }
    }

    fn effects(&self) -> Vec<Effect> {
        let mut effects = vec![Effect::default(); self.arm_joints.len()];
        // A fixed seed: the same robot has the same warnings in every process and run.
        let mut random = Random::new(2);
        for _ in 0..TRIALS {
            let mut arm = self.anywhere(&mut random);
            let other = self.anywhere(&mut random);
            let at = self.tip_at(&arm);
            for (joint, effect) in effects.iter_mut().enumerate() {
                // One joint at a time, put back afterwards: the effects are those of single
                // joints.
                let kept = arm[joint];
                arm[joint] = kept + STEP;
                let gain = (self.tip_at(&arm) - at).norm() / STEP;
                arm[joint] = other[joint];
                let way = (self.tip_at(&arm) - at).norm();
                arm[joint] = kept;
                effect.gain = effect.gain.max(gain);
                effect.way = effect.way.max(way);
            }
        }
        effects
    }

    fn tip_at(&self, arm: &[f64]) -> Vector3<f64> {
        let pose = self.frame_pose(self.tcp_frame, &self.with_arm_positions(arm));
        pose.map_or_else(Vector3::zeros, |pose| pose.translation.vector)
    }

    fn why_it_stays(&self, effects: &[Effect]) -> String {
        let before = self.before_tip();
        let specs = self.arm_joints.iter().zip(self.arm_specs()).zip(effects);
        let reasons = specs.map(|((&joint, spec), effect)| {
            let name = &self.chain.joints()[joint].name;
            if !before.contains(&joint) {
                format!("joint '{name}' is not before it")
            } else if effect.gain < LEAST_GAIN {
                format!("joint '{name}' turns about an axis through it")
            } else {
                let range = spec.upper - spec.lower;
                format!("joint '{name}' has a range of {range} only")
            }
        });
        listed(reasons)
    }

    /// Joints that carry the tip, or that one of these copies.
    fn before_tip(&self) -> Vec<usize> {
        let joints = self.chain.joints();
        let frame = self.chain.frames().get(self.tcp_frame);
        let mut path = Vec::new();
        let mut next = frame.and_then(|frame| frame.joint);
        while let Some(joint) = next {
            path.push(joint);
            next = joints[joint].parent;
        }
        independent(&self.chain, &path)
    }

    /// Advice: the links that would move as the tip.
    fn other_tips(&self, option: TipOption, is_narrow: bool) -> String {
        let how = match option {
            TipOption::Flag | TipOption::FlagOnly => "`--tip LINK`",
            TipOption::Key => "`tcp_frame`",
        };
        let moving = self.moving_links(matches!(option, TipOption::Flag));
        if !moving.is_empty() {
            let names = listed(moving.into_iter().map(str::to_owned));
            return format!("{how} can name a link that moves: {names}");
        }
        if is_narrow {
            return "no other link moves either; widen the limits".to_owned();
        }
        format!(
            "no other link moves either; add one by a fixed joint, away from the axis, and name \
             it by {how}"
        )
    }

    /// Links whose position changes with the controlled joints, or with all joints.
    fn moving_links(&self, all: bool) -> Vec<&str> {
        let joints = self.chain.joints();
        let mut random = Random::new(3);
        let mut ways = vec![0.0_f64; self.chain.frames().len()];
        let mut first: Vec<Vector3<f64>> = Vec::new();
        for _ in 0..TRIALS {
            let mut positions = self.with_arm_positions(&self.anywhere(&mut random));
            if all {
                let ranges = joints.iter().map(|joint| (joint.lower, joint.upper));
                let middles = ranges.map(|(low, high)| (0.5 * (low + high), 0.5 * (high - low)));
                let anywhere = middles.map(|(middle, half)| middle + random.around_zero(half));
                positions = anywhere.collect();
            }
            let links = self.link_poses(&positions);
            let frames = self.chain.frames().iter().map(|frame| {
                let link = links.get(frame.joint.map_or(0, |joint| joint + 1));
                link.map_or_else(Vector3::zeros, |link| {
                    (link * frame.pose).translation.vector
                })
            });
            let places: Vec<Vector3<f64>> = frames.collect();
            if first.is_empty() {
                first.clone_from(&places);
            }
            for ((way, place), first) in ways.iter_mut().zip(&places).zip(&first) {
                *way = way.max((place - first).norm());
            }
        }
        let frames = self.chain.frames().iter().zip(ways);
        let moving = frames.filter(|(_, way)| *way >= LEAST_WAY);
        moving.map(|(frame, _)| frame.name.as_str()).collect()
    }

    /// A warning if the limits of motion let the tip move by [`LEAST_WAY`] only after
    /// [`LONGEST`], from rest and with the fastest joint alone.
    fn slow(&self, effects: &[Effect]) -> Option<String> {
        let most = self.rmpflow.canonical_resolve.max_acceleration_norm;
        let time = |(spec, effect): (&crate::JointSpec, &Effect)| {
            let way = LEAST_WAY / effect.gain;
            let by_velocity = way / spec.velocity;
            // From rest a way is a t^2 / 2 at a constant acceleration, and j t^3 / 6 at a constant
            // jerk.
            let by_acceleration = (2.0 * way / spec.acceleration.min(most)).sqrt();
            // The slowest of the three limits decides: each of them alone allows the motion in
            // its time.
            by_velocity
                .max(by_acceleration)
                .max((6.0 * way / spec.jerk).cbrt())
        };
        let times = self.arm_specs().zip(effects).map(time);
        let least = times.fold(f64::INFINITY, f64::min);
        if least <= LONGEST {
            return None;
        }
        let specs = self.arm_joints.iter().zip(self.arm_specs());
        let limits = specs.map(|(&joint, spec)| {
            let name = &self.chain.joints()[joint].name;
            let (velocity, acceleration, jerk) = (spec.velocity, spec.acceleration, spec.jerk);
            format!("joint '{name}' {velocity}, {acceleration}, {jerk}")
        });
        Some(format!(
            "the tip '{}' needs {least:.1} s for its first millimetre: the limits of velocity, \
             acceleration and jerk are too small: {}; the tuning's max_acceleration_norm is {most}",
            self.tcp_frame_name(),
            listed(limits)
        ))
    }

    /// A warning if the tip can move on a line or a surface only: its present place may be the
    /// nearest to a target.
    fn confined(&self) -> Option<String> {
        let path = match self.open_directions() {
            3 => return None,
            2 => "on a surface",
            _ => "along a line",
        };
        Some(format!(
            "the tip '{}' can only move {path} (joints: {}): it moves as near to a target as \
             that allows, and stays where it cannot get nearer",
            self.tcp_frame_name(),
            listed(self.arm_joint_names().into_iter())
        ))
    }

    /// The number of the tuning without which a target does not pull.
    fn without_pull(&self) -> Option<&'static str> {
        let target = &self.rmpflow.target;
        if target.accel_p_gain == 0.0 {
            return Some("accel_p_gain");
        }
        let most = target.max_metric_scalar.max(target.min_metric_scalar);
        (most == 0.0).then_some("max_metric_scalar")
    }
}

fn listed(parts: impl Iterator<Item = String>) -> String {
    let mut parts: Vec<String> = parts.collect();
    if parts.len() > MOST_CANDIDATES {
        let more = parts.len() - MOST_CANDIDATES;
        parts.truncate(MOST_CANDIDATES);
        parts.push(format!("{more} more"));
    }
    parts.join(", ")
}
