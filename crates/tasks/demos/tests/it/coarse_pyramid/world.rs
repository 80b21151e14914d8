//! Two arms, their hands and a few cubes, where everything happens between two
//! decisions or not at all.

use ipc_types::decision::GoalKind;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{
    ArmGoal, ArmState, ArmStatus, GripperGoal, Header, ObjectState, OperatorPanel, Pose, Wire,
    WorldState,
};

use super::choice::{ARMS, Choice};

pub(crate) const CUBE_M: f64 = 0.05;
const OPEN_M: f64 = 0.08;
/// Where a lost cube ends up: at the edge of the pyramid, within reach of both
/// arms; and out of reach.
const AWAY: [[f64; 2]; 4] = [[0.40, 0.09], [0.40, -0.09], [0.52, 0.09], [0.52, -0.09]];
const FAR: [[f64; 2]; 4] = [[1.0, 0.5], [1.0, 0.65], [1.0, -0.5], [1.0, -0.65]];

/// By arm: in the way of its stack.
const BESIDE: [[f64; 2]; ARMS] = [[0.52, -0.28], [0.52, 0.28]];

/// From where a cube is put down; higher than any stack (m).
const FROM_M: f64 = 0.5;

/// Objects of the cell file.
const OBJECTS: usize = 6;

/// See the module. Of the state only what the cell has: millions of these wait.
#[derive(Clone)]
pub(crate) struct World {
    pub(crate) tick: u64,
    pub(crate) panel: OperatorPanel,
    pub(crate) arms: [ArmState; ARMS],
    objects_state: [ObjectState; OBJECTS],
    pub(crate) status: [ArmStatus; ARMS],
    /// By arm: the held cube.
    pub(crate) held: [Option<usize>; ARMS],
    /// By arm: the last command of the hand.
    pub(crate) told: [GripperGoal; ARMS],
    /// By arm: its controller is silent.
    pub(crate) silent: [bool; ARMS],
    /// By arm: for how long, in time the task counts (ticks).
    pub(crate) silence: [u64; ARMS],
    /// By cube: its place in the cell file.
    objects: Vec<usize>,
}

impl World {
    /// Both arms beside the pyramid, their hands open; the cubes at `places`.
    pub(crate) fn new(objects: &[usize], places: &[[f64; 3]]) -> Self {
        let arm = |y| {
            let mut arm = ArmState::zeroed();
            arm.tcp = Pose {
                position: [0.4, y, 0.4],
                orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
            };
            arm.gripper.width = OPEN_M;
            arm
        };
        let mut world = Self {
            tick: 0,
            panel: OperatorPanel::zeroed(),
            arms: [arm(-0.5), arm(0.5)],
            objects_state: [ObjectState::zeroed(); OBJECTS],
            status: [ArmStatus::zeroed(); ARMS],
            held: [None; ARMS],
            told: [GripperGoal::Keep; ARMS],
            silent: [false; ARMS],
            silence: [0; ARMS],
            objects: objects.to_vec(),
        };
        for (cube, place) in places.iter().enumerate() {
            world.objects_state[objects[cube]].flags = OBJECT_ENABLED;
            world.put(cube, *place);
        }
        world.settle();
        world.sense();
        world
    }

    /// Fills in what physics would publish.
    pub(crate) fn write(&self, state: &mut WorldState) {
        state.header = Header::caused_by::<WorldState>(self.tick);
        state.panel = self.panel;
        state.arm_count = u32::try_from(ARMS).unwrap();
        state.arms[..ARMS].copy_from_slice(&self.arms);
        state.object_count = u32::try_from(OBJECTS).unwrap();
        state.objects[..OBJECTS].copy_from_slice(&self.objects_state);
    }

    pub(crate) fn is_possible(&self, choice: Choice) -> bool {
        match choice {
            Choice::Nothing | Choice::Reset | Choice::Killed => true,
            Choice::Slow(arm) | Choice::Stuck(arm) | Choice::Silent(arm) => !self.silent[arm],
            Choice::Heard(arm) => self.silent[arm],
            Choice::HandStuck(arm) => {
                self.told[arm] == GripperGoal::Open && !self.is_open(arm) && !self.silent[arm]
            }
            Choice::Slippery(arm) => {
                self.told[arm] == GripperGoal::Close
                    && self.held[arm].is_none()
                    && !self.silent[arm]
            }
            Choice::Lost(arm) | Choice::KilledLost(arm) | Choice::Led(arm) => {
                self.held[arm].is_some()
            }
            Choice::Moved(cube) => self.can_be_put(cube, AWAY[cube]),
            Choice::Beside(cube, arm) => self.can_be_put(cube, BESIDE[arm]),
            Choice::Taken(cube) => !self.is_held(cube) && !self.is_far(cube),
        }
    }

    /// The next `ticks`, in which `choice` happens and the arms follow `goals`.
    pub(crate) fn pass(&mut self, ticks: u64, choice: Choice, goals: &[ArmGoal]) {
        match choice {
            Choice::Lost(arm) | Choice::KilledLost(arm) | Choice::Led(arm) => self.lose(arm),
            Choice::Moved(cube) => self.put_down(cube, AWAY[cube]),
            Choice::Beside(cube, arm) => self.put_down(cube, BESIDE[arm]),
            Choice::Taken(cube) => self.put_down(cube, FAR[cube]),
            Choice::Silent(arm) => self.silent[arm] = true,
            Choice::Heard(arm) => self.silent[arm] = false,
            _ => {}
        }
        // No policy time passes without decisions.
        let killed = matches!(choice, Choice::Killed | Choice::KilledLost(_));
        for (silence, silent) in self.silence.iter_mut().zip(self.silent) {
            *silence = if silent {
                *silence + ticks * u64::from(!killed)
            } else {
                0
            };
        }
        self.tick += ticks;
        let tick = self.tick;
        for arm in (0..ARMS)
            .filter(|arm| !self.silent[*arm])
            .collect::<Vec<_>>()
        {
            let goal = &goals[arm];
            let status = &mut self.status[arm];
            status.header = Header::caused_by::<ArmStatus>(tick);
            status.goal_active = u32::from(goal.kind != GoalKind::Hold.code());
            status.goal_id = goal.goal_id;
            let stays = choice == Choice::Slow(arm) || choice == Choice::Stuck(arm);
            if goal.kind == GoalKind::Pose.code() && !stays {
                self.move_to(arm, goal.target);
            }
            match self.told[arm] {
                GripperGoal::Close => self.close(arm, choice),
                GripperGoal::Open if choice != Choice::HandStuck(arm) => self.open(arm),
                GripperGoal::Open | GripperGoal::Keep => {}
            }
        }
        self.settle();
        self.sense();
    }

    /// The hands receive a new decision.
    pub(crate) fn tell(&mut self, goals: &[ArmGoal]) {
        for (told, goal) in self.told.iter_mut().zip(goals) {
            let gripper = GripperGoal::from_code(goal.gripper).unwrap();
            if gripper != GripperGoal::Keep {
                *told = gripper;
            }
        }
    }

    /// No further disturbance: controllers speak, and cubes that no arm
    /// reaches are brought back; `is_stranded` beside an arm's stack. Whether
    /// there was anything to do.
    pub(crate) fn free(&mut self, is_stranded: impl Fn(usize, usize) -> bool) -> bool {
        let back: Vec<usize> = (0..self.objects.len())
            .filter(|cube| {
                let is_beside = |arm: &usize| self.is_at(*cube, BESIDE[*arm]);
                let beside = (0..ARMS).find(is_beside);
                self.is_far(*cube)
                    || beside.is_some_and(|arm| !self.is_held(*cube) && is_stranded(*cube, arm))
            })
            .collect();
        let changes = !back.is_empty() || self.silent != [false; ARMS];
        self.silent = [false; ARMS];
        for cube in back {
            self.put_down(cube, AWAY[cube]);
        }
        self.settle();
        self.sense();
        changes
    }

    fn move_to(&mut self, arm: usize, target: Pose) {
        self.arms[arm].tcp = target;
        if let Some(cube) = self.held[arm] {
            self.put(cube, target.position);
        }
    }

    fn close(&mut self, arm: usize, choice: Choice) {
        let finds = !matches!(choice, Choice::Slippery(a) | Choice::Lost(a) | Choice::KilledLost(a) | Choice::Led(a) if a == arm);
        if self.held[arm].is_none() && finds {
            self.held[arm] = self.between_fingers(arm);
        }
        let width = if self.held[arm].is_some() {
            CUBE_M
        } else {
            0.0
        };
        self.arms[arm].gripper.width = width;
    }

    fn open(&mut self, arm: usize) {
        self.held[arm] = None;
        self.arms[arm].gripper.width = OPEN_M;
    }

    fn lose(&mut self, arm: usize) {
        if let Some(cube) = self.held[arm].take() {
            self.put_down(cube, AWAY[cube]);
        }
    }

    /// From above: onto another cube, if one is there already.
    fn put_down(&mut self, cube: usize, [x, y]: [f64; 2]) {
        self.put(cube, [x, y, FROM_M]);
    }

    fn put(&mut self, cube: usize, position: [f64; 3]) {
        self.objects_state[self.objects[cube]].pose = Pose {
            position,
            ..Pose::IDENTITY
        };
    }

    /// Loose cubes rest on the table or on another cube, the lowest first.
    fn settle(&mut self) {
        let mut order: Vec<usize> = (0..self.objects.len()).collect();
        order.sort_by(|a, b| self.position(*a)[2].total_cmp(&self.position(*b)[2]));
        for cube in order {
            if !self.is_held(cube) {
                let [x, y, _] = self.position(cube);
                self.put(cube, [x, y, self.rest_height(cube)]);
            }
        }
    }

    /// Height at which a cube comes to rest if it is released (m).
    fn rest_height(&self, cube: usize) -> f64 {
        let [x, y, z] = self.position(cube);
        let below = |other: &usize| {
            let [ox, oy, oz] = self.position(*other);
            *other != cube && !self.is_held(*other) && oz < z && (x - ox).hypot(y - oy) < 0.03
        };
        let heights = (0..self.objects.len()).filter(below);
        let top = heights.map(|other| self.position(other)[2] + CUBE_M);
        top.fold(CUBE_M / 2.0, f64::max)
    }

    /// Readings of the hands' sensors.
    fn sense(&mut self) {
        for arm in 0..ARMS {
            let number = |cube: usize| u32::try_from(self.objects[cube] + 1).unwrap();
            let held = self.held[arm].map_or(0, number);
            let beam = self.held[arm]
                .or(self.between_fingers(arm))
                .map_or(0, number);
            let gripper = &mut self.arms[arm].gripper;
            (gripper.held_object, gripper.beam_object) = (held, beam);
        }
    }

    fn between_fingers(&self, arm: usize) -> Option<usize> {
        let tcp = self.arms[arm].tcp.position;
        let near = |cube: &usize| {
            let squares = self.position(*cube).into_iter().zip(tcp);
            squares.map(|(a, b)| (a - b) * (a - b)).sum::<f64>() < 0.02 * 0.02
        };
        (0..self.objects.len()).find(|cube| !self.is_held(*cube) && near(cube))
    }

    pub(crate) fn position(&self, cube: usize) -> [f64; 3] {
        self.objects_state[self.objects[cube]].pose.position
    }

    pub(crate) fn is_open(&self, arm: usize) -> bool {
        self.arms[arm].gripper.width >= OPEN_M
    }

    fn is_held(&self, cube: usize) -> bool {
        self.held.contains(&Some(cube))
    }

    fn is_at(&self, cube: usize, [x, y]: [f64; 2]) -> bool {
        let [cx, cy, _] = self.position(cube);
        (x - cx).hypot(y - cy) < 0.02
    }

    /// No disturbance puts a cube where it is already, or between the fingers of a hand.
    fn can_be_put(&self, cube: usize, [x, y]: [f64; 2]) -> bool {
        let tcps = self.arms.iter().map(|arm| arm.tcp.position);
        let mut hands = tcps.filter(|[hx, hy, hz]| (x - hx).hypot(y - hy) < 0.06 && *hz < 0.15);
        !self.is_held(cube) && !self.is_at(cube, [x, y]) && hands.next().is_none()
    }

    fn is_far(&self, cube: usize) -> bool {
        self.position(cube)[0] > 0.9
    }
}
