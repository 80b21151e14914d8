//! One moment of the cell as the page's binary frame (docs/page-protocol.md).

use ipc_types::arm::PATH_POINTS;
use ipc_types::contact::Contact;
use ipc_types::decision::GoalKind;
use ipc_types::{ArmState, ArmStatus, Contacts, Decision, ObjectState, Pose, WorldState};

/// `RCS1`, little-endian.
pub const MAGIC: u32 = 0x3153_4352;
/// Bytes before the arms.
pub const HEADER_BYTES: usize = 48;
/// Bytes of one arm.
pub const ARM_BYTES: usize = (115 + 3 * PATH_POINTS) * 4;
/// Bytes of one object.
pub const OBJECT_BYTES: usize = 14 * 4;
/// Bytes of one contact.
pub const CONTACT_BYTES: usize = 8 * 4;

/// The operator has paused the task.
pub const FLAG_TASK_PAUSED: u32 = 8;
/// Scrubbed or replayed.
pub const FLAG_NOT_LIVE: u32 = 16;
/// A recording is being written to a file.
pub const FLAG_RECORDING: u32 = 32;
/// Physics waits for a line of the script.
pub const FLAG_SCRIPTED_STOP: u32 = 64;
/// The bits of [`WorldState::flags`] that the page knows.
const WORLD_FLAGS: u32 = 7;

/// Content of a frame.
#[derive(Clone, Copy)]
pub struct Snapshot<'a> {
    /// The world.
    pub world: &'a WorldState,
    /// Last status of each controller, by arm.
    pub status: &'a [Option<&'a ArmStatus>],
    /// Last decision of the task.
    pub decision: Option<&'a Decision>,
    /// Contacts, of a live cell.
    pub contacts: Option<&'a Contacts>,
    /// Simulated seconds per second.
    pub real_time_factor: f64,
    /// [`FLAG_NOT_LIVE`] and [`FLAG_RECORDING`].
    pub flags: u32,
}

/// Finger joints of every arm, in the order of the cell file.
pub type Fingers<'a> = &'a [usize];

/// The frame of `snapshot`.
pub fn encode(snapshot: &Snapshot<'_>, fingers: Fingers<'_>) -> Vec<u8> {
    let world = snapshot.world;
    let (arms, objects) = (world.arms(), world.objects());
    let contacts = snapshot.contacts.map_or(&[][..], Contacts::list);
    // The size is known, so the frame is allocated once.
    let size = HEADER_BYTES
        + arms.len() * ARM_BYTES
        + objects.len() * OBJECT_BYTES
        + contacts.len() * CONTACT_BYTES;
    let mut out = Frame(Vec::with_capacity(size));
    out.u32(MAGIC);
    out.u32(flags(snapshot));
    out.f64(world.header.sim_time_ns as f64 * 1.0e-9);
    out.f64(world.header.tick as f64);
    out.f64(snapshot.real_time_factor);
    out.u32(number(arms.len()));
    out.u32(number(objects.len()));
    out.u32(number(contacts.len()));
    // Keeps the arms at a multiple of eight bytes.
    out.u32(0);
    for (index, arm) in arms.iter().enumerate() {
        let status = snapshot.status.get(index).copied().flatten();
        let fingers = fingers.get(index).copied().unwrap_or(0);
        // From the decision, not the status: the page shows the
        // obstacles that the task asks for.
        let mask = obstacle_word(snapshot.decision, index);
        let target_valid = target_is_valid(snapshot, index, status);
        out.arm(&ArmView {
            arm,
            status,
            target_valid,
            fingers,
            mask,
        });
    }
    for object in objects {
        out.object(object);
    }
    for contact in contacts {
        out.contact(contact);
    }
    out.0
}

fn flags(snapshot: &Snapshot<'_>) -> u32 {
    let world = snapshot.world;
    let bit = |on: bool, flag: u32| if on { flag } else { 0 };
    // Unknown bits are cleared: the page must not mistake a new flag for another one.
    (world.flags & WORLD_FLAGS)
        | bit(world.panel.task_paused != 0, FLAG_TASK_PAUSED)
        | bit(world.script_line != 0, FLAG_SCRIPTED_STOP)
        | (snapshot.flags & (FLAG_NOT_LIVE | FLAG_RECORDING))
}

/// Whether the controller's target is a pose to show: the task's, or the operator's. With a target
/// of the joints the status has the pose of the tool at the time of the request.
fn target_is_valid(snapshot: &Snapshot<'_>, arm: usize, status: Option<&ArmStatus>) -> bool {
    let panel = &snapshot.world.panel;
    let by_operator = panel.task_paused != 0
        && panel.target_seq > 0
        && panel.target_is_joints == 0
        && panel.target_arm as usize == arm;
    let goal = snapshot.decision.and_then(|d| d.goals.get(arm));
    let sent = goal.is_some_and(|goal| goal.kind == GoalKind::Pose.code());
    status.is_some_and(|status| status.goal_active == 1) && (by_operator || sent)
}

fn number(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(0)
}

/// Obstacles of the cell that count, as given by the task.
fn obstacle_word(decision: Option<&Decision>, arm: usize) -> u32 {
    let goal = decision.and_then(|d| d.goals.get(arm));
    let mask = goal.map_or(0, |goal| goal.obstacle_mask);
    // The highest bit says "all": 31 bits name single ones, and a cell may have more.
    let all = u32::from(mask == u64::MAX) << 31;
    (mask & 0x7fff_ffff) as u32 | all
}

struct ArmView<'a> {
    arm: &'a ArmState,
    status: Option<&'a ArmStatus>,
    target_valid: bool,
    fingers: usize,
    mask: u32,
}

struct Frame(Vec<u8>);

impl Frame {
    fn u32(&mut self, value: u32) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn f64(&mut self, value: f64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "seven digits are enough for a picture"
    )]
    fn f32(&mut self, value: f64) {
        self.0.extend_from_slice(&(value as f32).to_le_bytes());
    }

    fn all(&mut self, values: &[f64]) {
        for value in values {
            self.f32(*value);
        }
    }

    fn pose(&mut self, pose: &Pose) {
        self.all(&pose.position);
        self.all(&pose.orientation_wxyz);
    }

    fn arm(&mut self, view: &ArmView<'_>) {
        let ArmView { arm, status, .. } = *view;
        let goal_active = status.is_some_and(|s| s.goal_active == 1);
        self.u32(arm.joint_count);
        self.u32(
            u32::from(arm.fault == 1)
                | u32::from(arm.gripper.attached == 1) << 1
                | u32::from(goal_active) << 2
                | u32::from(view.target_valid) << 3,
        );
        // The action in the low byte, its cause above it; physics gives no cause.
        let controller_stop =
            status.map_or(0, |s| (s.stop_action & 0xff) | (s.stop_cause & 0xff) << 8);
        self.u32((arm.stop_action & 0xffff) | controller_stop << 16);
        // An arm has 16 joints at most.
        self.u32(status.map_or(0, |s| (s.clipped_joints & 0xffff) as u32));
        self.joints(arm, status, view.fingers);
        self.pose(&arm.tcp);
        // Without a controller the tool is shown where it is.
        self.pose(status.map_or(&arm.tcp, |s| &s.target));
        self.pose(status.map_or(&arm.tcp, |s| &s.setpoint));
        let gripper = &arm.gripper;
        self.all(&[gripper.width, gripper.grip_force, gripper.load]);
        self.f32(status.map_or(0.0, |s| s.position_error));
        // The value for "no obstacle" in the status, so that the page needs one rule.
        self.f32(status.map_or(1000.0, |s| s.min_clearance));
        self.u32(gripper.held_object);
        self.u32(view.mask);
        self.plan(status);
    }

    fn plan(&mut self, status: Option<&ArmStatus>) {
        self.u32(status.map_or(0, |s| (s.plan_state & 0xff) | (s.not_reached & 0xff) << 8));
        self.f32(status.map_or(0.0, |s| s.path_at));
        self.f32(status.map_or(0.0, |s| s.path_length));
        let path = status.map_or([[0.0; 3]; PATH_POINTS], |s| s.path);
        self.all(path.as_flattened());
    }

    fn joints(&mut self, arm: &ArmState, status: Option<&ArmStatus>, fingers: usize) {
        let count = (arm.joint_count as usize).min(arm.joint_positions.len());
        // A finger's position is half of the width.
        let with = |joints: &[f64; 16], finger: f64| {
            let mut all = *joints;
            if let Some(places) = all.get_mut(count..(count + fingers).min(16)) {
                places.fill(finger);
            }
            all
        };
        let gripper = &arm.gripper;
        let commanded = status.map_or(gripper.width, |s| s.gripper.width);
        self.all(&with(&arm.joint_positions, 0.5 * gripper.width));
        self.all(&with(&arm.joint_velocities, 0.5 * gripper.width_velocity));
        self.all(&with(&arm.joint_efforts, gripper.grip_force));
        self.all(&with(&arm.setpoint_positions, 0.5 * commanded));
        self.all(&with(&arm.setpoint_accelerations, 0.0));
    }

    fn object(&mut self, object: &ObjectState) {
        self.pose(&object.pose);
        self.u32(object.flags);
        self.all(&object.twist.linear);
        self.all(&object.twist.angular);
    }

    fn contact(&mut self, contact: &Contact) {
        self.u32(contact.a);
        self.u32(contact.b);
        self.all(&contact.position);
        self.all(&contact.force);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    fn word(frame: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(frame[at..at + 4].try_into().unwrap())
    }

    fn float(frame: &[u8], at: usize) -> f32 {
        f32::from_bits(word(frame, at))
    }

    #[test]
    fn the_page_finds_every_value_at_its_place() {
        let mut world = WorldState::zeroed();
        (world.arm_count, world.object_count, world.flags) = (2, 3, 1);
        world.header.sim_time_ns = 1_500_000_000;
        world.panel.task_paused = 1;
        world.arms[1].joint_count = 7;
        world.arms[1].joint_positions[6] = 0.25;
        world.arms[1].gripper.width = 0.08;
        world.arms[1].gripper.held_object = 3;
        world.objects[2].pose = Pose::IDENTITY;
        world.objects[2].flags = 5;
        let mut status = ArmStatus::zeroed();
        (status.goal_active, status.stop_action) = (1, 3);
        status.target = Pose::IDENTITY;
        (status.plan_state, status.not_reached, status.path_length) = (2, 3, 1.5);
        status.path[PATH_POINTS - 1][2] = 0.75;
        let mut decision = Decision::zeroed();
        decision.goals[1].kind = GoalKind::Pose.code();
        decision.goals[1].obstacle_mask = u64::MAX;
        world.objects[2].twist.angular = [0.0, 0.0, 0.5];
        let mut contacts = Contacts::zeroed();
        (contacts.count, contacts.contacts[0].b) = (1, 2 << 16);
        contacts.contacts[0].force = [0.0, 0.0, 9.5];
        let snapshot = Snapshot {
            world: &world,
            status: &[None, Some(&status)],
            decision: Some(&decision),
            contacts: Some(&contacts),
            real_time_factor: 0.5,
            flags: FLAG_RECORDING,
        };
        let frame = encode(&snapshot, &[2, 2]);
        let of_objects = HEADER_BYTES + 2 * ARM_BYTES + 3 * OBJECT_BYTES;
        assert_eq!(frame.len(), of_objects + CONTACT_BYTES);
        assert_eq!(word(&frame, 40), 1);
        assert_eq!(word(&frame, 4), 1 | FLAG_TASK_PAUSED | FLAG_RECORDING);
        assert_eq!(f64::from_le_bytes(frame[8..16].try_into().unwrap()), 1.5);
        let arm = HEADER_BYTES + ARM_BYTES;
        assert_eq!((word(&frame, arm), word(&frame, arm + 4)), (7, 4 | 8));
        assert_eq!(word(&frame, arm + 8), 3 << 16);
        assert_eq!(float(&frame, arm + 4 * 10), 0.25);
        assert_eq!(
            float(&frame, arm + 4 * 11),
            0.04,
            "a finger goes half the width"
        );
        assert_eq!(float(&frame, arm + 4 * 94), 1.0, "the target's w");
        assert_eq!(word(&frame, arm + 4 * 110), 3);
        assert_eq!(word(&frame, arm + 4 * 111), u32::MAX);
        assert_eq!(word(&frame, arm + 4 * 112), 2 | 3 << 8);
        assert_eq!(float(&frame, arm + 4 * 114), 1.5);
        assert_eq!(float(&frame, arm + 4 * 186), 0.75, "the last point");
        let object = HEADER_BYTES + 2 * ARM_BYTES + 2 * OBJECT_BYTES;
        assert_eq!(float(&frame, object + 12), 1.0);
        assert_eq!(word(&frame, object + 28), 5);
        assert_eq!(float(&frame, object + 52), 0.5, "the twist");
        assert_eq!(word(&frame, of_objects + 4), 2 << 16);
        assert_eq!(float(&frame, of_objects + 28), 9.5, "the force");
    }

    #[test]
    fn an_operators_target_of_joints_has_no_pose_to_start_from() {
        let mut world = WorldState::zeroed();
        (world.arm_count, world.panel.task_paused) = (1, 1);
        world.panel.target_seq = 1;
        let mut status = ArmStatus::zeroed();
        status.goal_active = 1;
        let has_pose = |world: &WorldState| {
            let snapshot = Snapshot {
                world,
                status: &[Some(&status)],
                decision: None,
                contacts: None,
                real_time_factor: 1.0,
                flags: 0,
            };
            word(&encode(&snapshot, &[2]), HEADER_BYTES + 4) & 8 != 0
        };
        assert!(has_pose(&world));
        world.panel.target_is_joints = 1;
        assert!(!has_pose(&world));
    }

    #[test]
    fn without_controller_and_task_nothing_is_pretended() {
        let mut world = WorldState::zeroed();
        world.arm_count = 1;
        let snapshot = Snapshot {
            world: &world,
            status: &[],
            decision: None,
            contacts: None,
            real_time_factor: 0.0,
            flags: 0,
        };
        let frame = encode(&snapshot, &[]);
        assert_eq!(word(&frame, HEADER_BYTES + 4), 0);
        assert_eq!(float(&frame, HEADER_BYTES + 4 * 109), 1000.0);
    }
}
