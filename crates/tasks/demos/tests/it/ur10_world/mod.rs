//! One coarse world for the three jobs of the UR10, without dynamics: the cup moves to its goal
//! at an even pace, suction takes the bin in front of it, and a released bin keeps its place on
//! a support and falls elsewhere.

use cell_model::{Cell, Data, Shape};
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::equipment::{BreakCause, BreakLimit};
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ArmStatus, DECISION_TICKS, Decision, GripperGoal, Pose, Wire, WorldState};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use robocell_skills::{geometry, pose};
use robocell_task::Task;

/// Distance that the cup moves between two decisions (m).
const PACE_M: f64 = 0.03;
/// The cup takes a side whose middle is this near (m); a spot on a floor may be
/// further off.
const GRIP_M: f64 = 0.01;
const BIN: [f64; 3] = [0.30, 0.20, 0.135];

/// Where a job's bins come, and where they find support.
pub(crate) struct Placement {
    pub(crate) demo: &'static str,
    pub(crate) policy: &'static str,
    /// Position at which a bin arrives (m).
    supply: [f64; 3],
    /// Where bins are turned over (m); at the jig they turn by themselves.
    station: [f64; 3],
    jig: bool,
}

pub(crate) const PLACES: [Placement; 3] = [
    Placement {
        demo: "ur10-palletize",
        policy: "table",
        supply: [0.05, 0.45, -0.151],
        station: [0.79, 0.74, -0.03],
        jig: true,
    },
    Placement {
        demo: "ur10-bin-stack",
        policy: "matrix",
        supply: [0.01, 0.54, -0.3825],
        station: [0.695, 0.648, 0.3475],
        jig: false,
    },
    Placement {
        demo: "ur10-fill-bin",
        policy: "matrix",
        supply: [-0.17, 0.81, -0.44],
        station: [9.0, 9.0, 9.0],
        jig: false,
    },
];

#[derive(Clone)]
struct Held {
    bin: usize,
    in_cup: Isometry3<f64>,
}

pub(crate) struct World {
    pub(crate) place: &'static Placement,
    pub(crate) state: Box<WorldState>,
    pub(crate) decision: Box<Decision>,
    pub(crate) task: Task,
    pub(crate) lines: Vec<String>,
    /// The arm does not move.
    pub(crate) stuck: bool,
    /// Suction finds no hold.
    pub(crate) leaky: bool,
    cell: Cell,
    status: Box<ArmStatus>,
    bins: Vec<usize>,
    held: Option<Held>,
    asked: Option<u32>,
    parts: u32,
    came: usize,
}

impl World {
    pub(crate) fn new(place: &'static Placement, bins: u32) -> Self {
        let mut cell = Cell::load(&Data::checkout(), place.demo, 1, None).unwrap();
        if place.demo != "ur10-fill-bin" {
            cell.limit_bins(bins).unwrap();
        }
        let mut state = Box::new(WorldState::zeroed());
        state.arm_count = 1;
        state.object_count = u32::try_from(cell.objects.len()).unwrap();
        (state.panel.task_start, state.panel.task_started) = (1, 1);
        let arm = &cell.arms[0];
        let joints = arm.robot.with_arm_positions(&arm.home);
        state.arms[0].tcp =
            pose::wire(&arm.robot.frame_pose(arm.robot.tcp_frame, &joints).unwrap());
        for (object, spec) in state.objects.iter_mut().zip(&cell.objects) {
            object.pose = pose::wire(&spec.pose);
            object.flags = if spec.parked { 0 } else { OBJECT_ENABLED };
        }
        let is_bin = |i: &usize| matches!(cell.objects[*i].shape, Shape::Bin { .. });
        Self {
            place,
            task: demos::policies().task(&cell, place.policy).unwrap(),
            bins: (0..cell.objects.len())
                .filter(is_bin)
                .take(bins as usize)
                .collect(),
            cell,
            state,
            decision: Box::new(Decision::zeroed()),
            lines: Vec::new(),
            stuck: false,
            leaky: false,
            status: Box::new(ArmStatus::zeroed()),
            held: None,
            asked: None,
            parts: 0,
            came: 0,
        }
    }

    /// A new process, with the checkpoint of the one before or with those bytes.
    pub(crate) fn restart(&mut self, record: Option<&[u8]>) -> bool {
        let own = self.task.checkpoint();
        self.task = demos::policies()
            .task(&self.cell, self.place.policy)
            .unwrap();
        self.task.restore(record.unwrap_or(&own)).is_ok()
    }

    /// Where the bins are, for a test that failed.
    pub(crate) fn bins(&self) -> String {
        let bin = |bin: &usize| {
            let object = &self.state.objects[*bin];
            let up = geometry::rotation(object.pose.orientation_wxyz) * Vector3::z();
            format!(
                "{} {:.3?} up {:.2}",
                object.flags, object.pose.position, up.z
            )
        };
        let bins: Vec<String> = self.bins.iter().map(bin).collect();
        bins.join(", ")
    }

    pub(crate) fn outcome(&self) -> Outcome {
        Outcome::from_code(self.decision.outcome).unwrap()
    }

    pub(crate) fn holds(&self) -> bool {
        self.held.is_some()
    }

    pub(crate) fn gripper(&self) -> GripperGoal {
        GripperGoal::from_code(self.decision.goals[0].gripper).unwrap()
    }

    /// One decision, and its effects.
    pub(crate) fn step(&mut self) {
        let mut lines = Vec::new();
        let status = [Some(&*self.status)];
        self.task
            .decide(&self.state, &status, &mut self.decision, &mut lines);
        let people = lines.iter().filter(|line| line.kind.is_for_people());
        self.lines
            .extend(people.map(|line| line.text.as_str().to_owned()));
        ipc_types::Validate::validate(&*self.decision).unwrap();
        self.move_arm();
        self.suck();
        self.supply();
        self.fill();
        self.state.header.tick += DECISION_TICKS;
    }

    fn move_arm(&mut self) {
        let goal = self.decision.goals[0];
        self.status.goal_id = goal.goal_id;
        self.status.goal_active = 1;
        let tcp = self.state.arms[0].tcp;
        if goal.kind != GoalKind::Hold.code() && !self.stuck {
            let way = Vector3::from(goal.target.position) - Vector3::from(tcp.position);
            let part = (PACE_M / way.norm().max(1.0e-9)).min(1.0);
            self.state.arms[0].tcp = if part < 1.0 {
                pose::between(&tcp, &goal.target, part)
            } else {
                goal.target
            };
        }
        if let Some(held) = &self.held {
            let bin = pose::isometry(&self.state.arms[0].tcp) * held.in_cup;
            self.state.objects[held.bin].pose = pose::wire(&bin);
        }
    }

    fn suck(&mut self) {
        let was = self.state.arms[0].gripper.suction == 1;
        let on = match self.gripper() {
            GripperGoal::Keep => was,
            GripperGoal::Open => false,
            GripperGoal::Close => true,
        };
        self.state.arms[0].gripper.suction = u32::from(on);
        if on && !was {
            self.held = self.in_front().filter(|_| !self.leaky);
            self.state.arms[0].gripper.refusals += u32::from(self.held.is_none());
        } else if !on {
            self.let_go();
        }
        self.show_grip();
    }

    fn show_grip(&mut self) {
        let held = self.held.as_ref().map_or(0, |held| held.bin + 1);
        let gripper = &mut self.state.arms[0].gripper;
        gripper.attached = u32::from(held > 0);
        gripper.held_object = u32::try_from(held).unwrap();
    }

    /// The bin one of whose sides the cup touches, pointing at it.
    fn in_front(&self) -> Option<Held> {
        let cup = pose::isometry(&self.state.arms[0].tcp);
        let half = Vector3::from(BIN) * 0.5;
        let sides = [
            ([0.0, 0.0, 0.005 - half.z], Vector3::z(), 0.1),
            ([0.0, 0.0, -half.z], -Vector3::z(), GRIP_M),
            ([half.x, 0.0, 0.0], Vector3::x(), GRIP_M),
            ([-half.x, 0.0, 0.0], -Vector3::x(), GRIP_M),
            ([0.0, half.y, 0.0], Vector3::y(), GRIP_M),
            ([0.0, -half.y, 0.0], -Vector3::y(), GRIP_M),
        ];
        let touched = |bin: &usize| {
            let at = pose::isometry(&self.state.objects[*bin].pose);
            let here = self.state.objects[*bin].flags & OBJECT_ENABLED != 0;
            let side = |(middle, out, aside): &([f64; 3], Vector3<f64>, f64)| {
                let off = (at * Point3::from(*middle)).coords - cup.translation.vector;
                let normal = at.rotation * out;
                let away = off.dot(&normal);
                let faces = (cup.rotation * Vector3::x()).dot(&normal) < -0.9;
                faces && away.abs() < GRIP_M && (off - normal * away).norm() < *aside
            };
            here && sides.iter().any(side)
        };
        let bin = self.bins.iter().copied().find(touched)?;
        let in_cup = cup.inverse() * pose::isometry(&self.state.objects[bin].pose);
        Some(Held { bin, in_cup })
    }

    /// In the jig a bin turns, in the holder and low over its place it stays;
    /// from anywhere else it falls.
    fn let_go(&mut self) {
        let Some(Held { bin, .. }) = self.held.take() else {
            return;
        };
        let at = Vector3::from(self.state.objects[bin].pose.position);
        let station = Vector3::from(self.place.station);
        if (at - station).xy().norm() < 0.2 {
            if self.place.jig {
                self.put(bin, [0.78, 0.75, -0.0275], 0.0, 0.775);
            }
        } else if !self.supported(bin) {
            self.fall(bin);
        }
    }

    /// Whether a bin is supported: flat, at a height at which bins rest there.
    fn supported(&self, bin: usize) -> bool {
        let place = pose::isometry(&self.state.objects[bin].pose);
        let at = place.translation.vector;
        let flat = (place.rotation * Vector3::z()).z.abs() > 0.99;
        let levels = |floor: f64| {
            let level = (at.z - floor) / BIN[2] - 0.5;
            (level - level.round()).abs() < 0.1 && (-0.1..3.1).contains(&level)
        };
        match self.place.demo {
            "ur10-palletize" => flat && at.x > 0.4 && at.y < 0.2 && (at.z + 0.43).abs() < 0.02,
            "ur10-bin-stack" => flat && at.x > 0.4 && at.y < 0.2 && levels(-0.45),
            _ => at.z < -0.3,
        }
    }

    /// Off the floor it is cleared, to come again; in the third job it stays there.
    fn fall(&mut self, bin: usize) {
        if self.place.demo == "ur10-fill-bin" {
            let lies = [-std::f64::consts::FRAC_PI_2, 0.0, std::f64::consts::PI];
            let [x, y, z] = self.place.supply;
            self.put(bin, [x, y, z], 0.0, 0.0);
            let turn = UnitQuaternion::from_euler_angles(0.0, lies[self.came % 3], 0.0);
            let at = Isometry3::from_parts(Translation3::new(x, y, z), turn);
            self.state.objects[bin].pose = pose::wire(&at);
            self.came += 1;
        } else {
            self.state.objects[bin].flags = 0;
        }
    }

    fn put(&mut self, bin: usize, position: [f64; 3], over: f64, yaw: f64) {
        let turn = UnitQuaternion::from_euler_angles(over, 0.0, yaw);
        let at = Isometry3::from_parts(Translation3::from(position), turn);
        self.state.objects[bin].pose = pose::wire(&at);
        self.state.objects[bin].flags = OBJECT_ENABLED;
    }

    /// Bins come to the end of the belt at once, every other one upside down.
    fn supply(&mut self) {
        let add = self.decision.io.add_bin;
        let new = self.asked.replace(add).is_some_and(|had| add > had);
        let enabled =
            |world: &Self, bin: usize| world.state.objects[bin].flags & OBJECT_ENABLED != 0;
        let end = Vector3::from(self.place.supply);
        let at_end = |world: &Self| {
            world.bins.iter().copied().find(|bin| {
                let off = Vector3::from(world.state.objects[*bin].pose.position) - end;
                enabled(world, *bin) && off.x.abs() < 0.2 && off.yz().norm() < 0.05
            })
        };
        self.run_belt();
        let parked = self.bins.iter().copied().find(|bin| !enabled(self, *bin));
        if let Some(bin) = parked.filter(|_| new && at_end(self).is_none()) {
            let over = [0.0, std::f64::consts::PI][self.came % 2];
            self.put(bin, self.place.supply, over, 0.1);
            self.came += 1;
        }
        let seen = at_end(self).map_or(0, |bin| bin + 1);
        self.state.equipment.sensors[0] = u32::try_from(seen).unwrap();
    }

    /// Bins on the belt move towards its end.
    fn run_belt(&mut self) {
        let [_, end_y, end_z] = self.place.supply;
        let held = self.held.as_ref().map(|held| held.bin);
        for bin in self.bins.iter().copied().filter(|bin| Some(*bin) != held) {
            let [x, y, z] = &mut self.state.objects[bin].pose.position;
            let on_belt = x.abs() < 0.3 && (*z - end_z).abs() < 0.05 && *y > end_y;
            if on_belt && self.decision.io.conveyor_running == 1 {
                *y = (*y - 0.003).max(end_y);
            }
        }
    }

    /// Fifteen loads of parts break the grip.
    fn fill(&mut self) {
        let drops = self.decision.io.drop_parts;
        if self.held.is_none() {
            self.parts = drops;
        } else if drops > self.parts + 15 {
            self.break_grip();
        }
    }

    /// The held object falls.
    pub(crate) fn break_grip(&mut self) {
        if let Some(Held { bin, .. }) = self.held.take() {
            let gripper = &mut self.state.arms[0].gripper;
            gripper.breaks += 1;
            gripper.break_limit = BreakLimit::Force.code();
            gripper.break_cause = BreakCause::Weight.code();
            self.fall(bin);
            self.show_grip();
        }
    }

    /// A user takes a bin out of the cell, or out of the hand.
    pub(crate) fn take_away(&mut self, which: usize) {
        let bin = self.bins[which % self.bins.len()];
        if self.held.as_ref().is_some_and(|held| held.bin == bin) {
            self.break_grip();
        } else {
            self.fall(bin);
        }
    }

    /// A user shoves a bin that no arm holds, on the belt between its guards.
    pub(crate) fn shove(&mut self, which: usize, by: [f64; 2]) {
        let bin = self.bins[which % self.bins.len()];
        let end = self.place.supply;
        if self.held.as_ref().is_none_or(|held| held.bin != bin) {
            let [x, y, z] = &mut self.state.objects[bin].pose.position;
            let belt = (*z - end[2]).abs() < 0.05 && x.abs() < 0.3;
            (*x, *y) = (*x + by[0], *y + by[1]);
            if belt {
                (*x, *y) = (x.clamp(-0.1, 0.1), y.clamp(end[1], end[1] + 0.5));
            }
        }
    }

    /// The operator leads the cup to somewhere near where it is.
    pub(crate) fn lead(&mut self, by: [f64; 3]) {
        let tcp: Pose = self.state.arms[0].tcp;
        self.state.panel.target = pose::shifted(&tcp, by);
        self.state.panel.target_seq += 1;
    }
}
