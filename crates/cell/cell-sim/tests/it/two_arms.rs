//! Two arms that want the same place keep clear of each other: parry's
//! distances of their collision spheres are the oracle, at the joints that were
//! measured. Goals are fed straight to the cycles; there is no task.

use cell_model::{ArmSpec, Cell, Data};
use controller_proc::cycle::Cycle;
use ipc_types::decision::GoalKind;
use ipc_types::{ArmCommand, ArmStatus, Decision, GripperGoal, Header, Pose, Wire, WorldState};
use nalgebra::Point3;
use parry3d_f64::math::{Pose as ParryPose, Rotation, Vector};
use parry3d_f64::query::distance;
use parry3d_f64::shape::Ball;
use physics_proc::world::{StepInput, World};

/// Age limit of decisions (ticks): with real-time scheduling.
const LIMIT: u64 = 30;
/// Ticks between two looks at the distance.
const LOOK: u64 = 5;

/// The cell of the pyramid, with a hand on both arms' goals.
struct Duo {
    cell: Cell,
    world: World,
    cycles: Vec<Cycle>,
    state: Box<WorldState>,
    decision: Decision,
    commands: Vec<ArmCommand>,
    statuses: Vec<ArmStatus>,
    /// Least distance of the two arms' spheres so far (m).
    nearest: f64,
}

impl Duo {
    fn new(seed: u64) -> Self {
        let cell = Cell::load(&Data::checkout(), "franka-pyramid", seed, None).expect("a cell");
        let mut decision = Decision::zeroed();
        decision.arm_count = 2;
        for goal in &mut decision.goals {
            goal.target = Pose::IDENTITY;
            goal.obstacle_mask = u64::MAX;
        }
        let mut duo = Self {
            world: World::new(&cell).expect("a world"),
            cycles: (0..2)
                .map(|arm| Cycle::new(&cell, arm).expect("a controller"))
                .collect(),
            cell,
            state: Box::new(WorldState::zeroed()),
            decision,
            commands: vec![ArmCommand::zeroed(); 2],
            statuses: vec![ArmStatus::zeroed(); 2],
            nearest: f64::INFINITY,
        };
        duo.answer();
        duo
    }

    /// TCP goals of both arms (m, world), hands down and fingers along x.
    fn goals(&mut self, positions: [[f64; 3]; 2], gripper: [GripperGoal; 2]) {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let goals = self.decision.goals.iter_mut().zip([half, -half]);
        for ((goal, y), (position, gripper)) in goals.zip(positions.into_iter().zip(gripper)) {
            goal.goal_id += 1;
            goal.kind = GoalKind::Pose.code();
            goal.gripper = gripper.code();
            goal.target = Pose {
                position,
                orientation_wxyz: [0.0, half, y, 0.0],
            };
        }
    }

    fn answer(&mut self) {
        self.world.write_state(&mut self.state);
        self.state.header.generation = 1;
        let tick = self.state.header.tick;
        if tick.is_multiple_of(10) {
            self.decision.header = Header::caused_by::<Decision>(tick);
            self.decision.header.generation = 1;
        }
        let answers = self.commands.iter_mut().zip(&mut self.statuses);
        for (cycle, (command, status)) in self.cycles.iter_mut().zip(answers) {
            cycle.update(&self.state, Some(&self.decision), LIMIT, command, status);
            command.header.generation = 1;
            command.header.seq = tick + 1;
        }
    }

    fn run(&mut self, ticks: u64) {
        for tick in 0..ticks {
            let [left, right] = &self.commands[..] else {
                panic!("two arms")
            };
            self.world.step(&StepInput {
                commands: [Some(left), Some(right)],
                decision: None,
            });
            self.answer();
            if tick.is_multiple_of(LOOK) {
                self.nearest = self.nearest.min(self.distance());
            }
        }
        for arm in self.state.arms() {
            assert_eq!((arm.limit_violations, arm.fault), (0, 0));
        }
        assert_eq!(self.world.refused_commands(), 0);
    }

    /// Least distance of a sphere of one arm from a sphere of the other (m).
    fn distance(&self) -> f64 {
        let [left, right] = [0, 1].map(|arm| self.balls(arm));
        let mut least = f64::INFINITY;
        for (a, ball) in &left {
            for (b, other) in &right {
                let gap = distance(a, ball, b, other).expect("both are balls");
                least = least.min(gap.distance);
            }
        }
        least
    }

    fn balls(&self, arm: usize) -> Vec<(ParryPose, Ball)> {
        let ArmSpec { robot, base, .. } = &self.cell.arms[arm];
        // Fingers where the motion policies take them to be.
        let mut positions = robot.fixed_joint_positions.clone();
        let measured = &self.state.arms[arm].joint_positions;
        for (&joint, position) in robot.arm_joints.iter().zip(measured) {
            positions[joint] = *position;
        }
        let links = robot.link_poses(&positions);
        let ball = |sphere: &rmp::CollisionSphere| {
            let index = robot.chain.frame_index(&sphere.frame).expect("a frame");
            let frame = &robot.chain.frames()[index];
            let link = links[frame.joint.map_or(0, |joint| joint + 1)];
            let center = base * link * frame.pose * Point3::from(sphere.center);
            let place = Vector::new(center.x, center.y, center.z);
            let pose = ParryPose::from_parts(place, Rotation::IDENTITY);
            (pose, Ball::new(sphere.radius))
        };
        robot.spheres.iter().map(ball).collect()
    }

    /// How far the TCP of `arm` is from its goal (m).
    fn error(&self, arm: usize) -> f64 {
        self.statuses[arm].position_error
    }
}

const OPEN: [GripperGoal; 2] = [GripperGoal::Open; 2];
const CENTRE: [f64; 3] = [0.46, 0.0, 0.25];
const STACKS: [[f64; 3]; 2] = [[0.46, -0.28, 0.25], [0.46, 0.28, 0.25]];

#[test]
fn two_arms_sent_to_one_spot_do_not_touch() {
    let mut duo = Duo::new(1);
    duo.run(500);
    duo.goals([CENTRE, CENTRE], OPEN);
    duo.run(6_000);
    // Neither gets there, and both come to rest.
    let arms = duo.state.arms().iter();
    let speeds = arms.flat_map(|arm| arm.joint_velocities);
    let fastest = speeds.fold(0.0_f64, |most, v| most.max(v.abs()));
    assert!(fastest < 0.05, "{fastest} rad/s");
    assert!(duo.nearest > 0.005, "{} m", duo.nearest);
    // When they part again, each gets where it wants to.
    duo.goals(STACKS, OPEN);
    duo.run(4_000);
    assert!(duo.error(0) < 0.01 && duo.error(1) < 0.01);
}

#[test]
fn one_arm_works_at_the_centre_while_the_other_builds_its_stack() {
    let mut duo = Duo::new(2);
    duo.run(300);
    let low = |place: [f64; 3], z: f64| [place[0], place[1], z];
    for (first, second) in [(0, 1), (1, 0)] {
        let mut goals = STACKS;
        goals[first] = low(CENTRE, 0.35);
        duo.goals(goals, OPEN);
        duo.run(3_000);
        goals[second] = low(STACKS[second], 0.025);
        goals[first] = low(CENTRE, 0.16);
        duo.goals(goals, OPEN);
        duo.run(3_000);
        assert!(duo.error(0) < 0.01 && duo.error(1) < 0.01);
    }
    assert!(duo.nearest > 0.05, "{} m", duo.nearest);
}

#[test]
fn arms_that_change_sides_do_not_touch() {
    let mut duo = Duo::new(3);
    duo.run(300);
    duo.goals(STACKS, OPEN);
    duo.run(2_000);
    duo.goals([STACKS[1], STACKS[0]], OPEN);
    duo.run(6_000);
    assert!(duo.nearest > 0.005, "{} m", duo.nearest);
}
