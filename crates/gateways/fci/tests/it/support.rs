//! A client without sockets, at a robot that follows its setpoints.

use cell_model::ramp::RampState;
use cell_model::{Data, Robot};
use fci::{
    Arm, COMMAND_BYTES, Error, Framed, Measured, MoveRequest, Reflex, Reply, Request, RobotCommand,
    STATE_BYTES, Setpoint,
};
use nalgebra::Vector3;

pub(crate) const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

pub(crate) fn robot() -> Robot {
    Robot::load(&Data::checkout(), "fr3").unwrap()
}

/// A command with nothing but its number.
pub(crate) fn command(message_id: u64) -> RobotCommand {
    let mut bytes = [0; COMMAND_BYTES];
    bytes[..8].copy_from_slice(&message_id.to_le_bytes());
    RobotCommand::decode(&bytes).unwrap()
}

pub(crate) struct Bench {
    pub(crate) arm: Arm,
    pub(crate) measured: Measured,
    pub(crate) setpoint: Option<Setpoint>,
    requests: u32,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self::at(robot().home().try_into().unwrap())
    }

    /// At rest at these joint positions (rad).
    pub(crate) fn at(home: [f64; 7]) -> Self {
        let robot = robot();
        let rest = home.map(|position| RampState {
            position,
            ..RampState::default()
        });
        Self {
            arm: Arm::new(&robot, &home, GRAVITY).unwrap(),
            measured: Measured {
                positions: home,
                velocities: [0.0; 7],
                torques: [0.0; 7],
                setpoint: rest,
                is_held: false,
            },
            setpoint: None,
            requests: 0,
        }
    }

    /// Sends a request; the replies that it has at once.
    pub(crate) fn request(&mut self, command: u32, request: Request) -> Vec<Reply> {
        self.requests += 1;
        self.arm.request(&Framed {
            command,
            id: self.requests,
            request,
            size: 0,
        });
        self.replies()
    }

    pub(crate) fn replies(&mut self) -> Vec<Reply> {
        std::iter::from_fn(|| self.arm.take_reply()).collect()
    }

    /// Starts a motion; its status.
    pub(crate) fn start(&mut self, controller: u32, generator: u32) -> u8 {
        let wanted = Request::Move(MoveRequest {
            controller,
            generator,
            is_async: false,
        });
        self.request(1, wanted)[0].status
    }

    /// A cycle of a robot that follows at once, with the answer of the client to the last
    /// state.
    pub(crate) fn cycle<'a>(&mut self, answer: impl Into<Option<&'a RobotCommand>>) {
        if let Some(answer) = answer.into() {
            self.arm.datagram(answer, false);
        }
        let setpoint = self.arm.advance(&self.measured);
        self.measured.setpoint = setpoint.joints;
        self.measured.positions = setpoint.joints.map(|joint| joint.position);
        self.measured.velocities = setpoint.joints.map(|joint| joint.velocity);
        self.setpoint = Some(setpoint);
    }

    /// The answer to state `message_id` arrives late.
    pub(crate) fn cycle_late(&mut self, message_id: u64) {
        self.arm.datagram(&command(message_id), false);
    }

    /// A command that answers the last state.
    pub(crate) fn answer(&self) -> RobotCommand {
        let mut command = command(self.arm.message_id());
        command.positions = self.measured.setpoint.map(|joint| joint.position);
        command
    }

    pub(crate) fn state(&self) -> [u8; STATE_BYTES] {
        let mut bytes = [0; STATE_BYTES];
        self.arm.write_state(&self.measured, &mut bytes);
        bytes
    }

    /// Cycles without a client until the arm is at rest.
    pub(crate) fn rest(&mut self) {
        for _ in 0..1000 {
            self.cycle(None);
        }
        assert!(self.arm.is_at_rest());
    }
}

/// A reflex with this error in this cycle, and with the value that a formula gives.
pub(crate) fn assert_broken(
    reflex: Option<Reflex>,
    error: Error,
    cycle: u64,
    value: f64,
    limit: f64,
) {
    let reflex = reflex.unwrap();
    assert_eq!(reflex.broken.error, error, "{reflex:?}");
    assert_eq!(reflex.cycle, cycle, "{reflex:?}");
    assert!(
        (reflex.broken.value - value).abs() < 1e-6 * value.abs(),
        "{reflex:?}"
    );
    assert!((reflex.broken.limit - limit).abs() < 1e-9, "{reflex:?}");
}

/// Numbers of a state from byte `at` on.
pub(crate) fn numbers(state: &[u8; STATE_BYTES], at: usize, count: usize) -> Vec<f64> {
    let bytes = state[at..at + 4 * count].chunks_exact(4);
    bytes
        .map(|bytes| f64::from(f32::from_le_bytes(bytes.try_into().unwrap())))
        .collect()
}
