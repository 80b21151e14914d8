//! Messages over TCP, to and from the arm (libfranka-common,
//! `research_interface/robot/service_types.h`, version 10).

use serde::{Deserialize, Serialize};

use crate::JOINTS;
use crate::bytes::Reader;

/// The version of the protocol that is served.
pub const VERSION: u16 = 10;
/// Bytes of the header of a request and of a reply: command, id, size.
pub const HEADER_BYTES: usize = 12;
/// Longest request.
// SetCollisionBehavior, 428 bytes, is the longest one that is known.
pub const REQUEST_BYTES: usize = 512;

/// A request of a client.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// The first one of a connection.
    Connect {
        /// Version of the client.
        version: u16,
        /// Port of the client for states.
        udp_port: u16,
    },
    /// Starts a motion.
    Move(MoveRequest),
    /// Ends the motion.
    StopMove,
    /// Thresholds of contacts and collisions.
    SetCollisionBehavior,
    /// Stiffness of the joint impedance controller (N·m/rad).
    SetJointImpedance([f64; JOINTS]),
    /// Stiffness of the Cartesian impedance controller (N/m, N·m/rad).
    SetCartesianImpedance([f64; 6]),
    /// Directions that can be guided by hand.
    SetGuidingMode,
    /// Stiffness frame in the end effector frame, column-major.
    SetEeToK([f64; 16]),
    /// End effector frame in the nominal one, column-major.
    SetNeToEe([f64; 16]),
    /// A load at the flange.
    SetLoad {
        /// Mass (kg).
        mass: f64,
        /// Centre of mass in the flange frame (m).
        center: [f64; 3],
        /// Inertia, column-major (kg·m²).
        inertia: [f64; 9],
    },
    /// Ends the state after a reflex.
    AutomaticErrorRecovery,
    /// Asks for the URDF.
    GetRobotModel,
}

/// What a motion is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MoveRequest {
    /// 0 joint impedance, 1 Cartesian impedance, 2 external (torques).
    pub controller: u32,
    /// 0 joint position, 1 joint velocity, 2 Cartesian pose, 3 Cartesian velocity, 4 none.
    pub generator: u32,
    /// Whether the client sends goals instead of a command for each cycle.
    pub is_async: bool,
}

/// Reason why bytes of a client are not a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Malformed {
    /// A size that no request has.
    Size(u32),
    /// A command that is not known.
    Command(u32),
    /// A command with another size than its own.
    Body(u32),
}

impl std::fmt::Display for Malformed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Size(size) => write!(
                f,
                "a request of {size} bytes; {HEADER_BYTES} to {REQUEST_BYTES} are allowed"
            ),
            Self::Command(command) => write!(f, "command {command}; 0 to 11 are known"),
            Self::Body(command) => write!(f, "command {command} with a body of another size"),
        }
    }
}

/// A request with its place in the stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framed {
    /// Number of the command; a reply repeats it.
    pub command: u32,
    /// Number of the request; a reply repeats it.
    pub id: u32,
    /// The request.
    pub request: Request,
    /// Bytes that it took.
    pub size: usize,
}

/// The first request in `bytes`; `None` until all of it has arrived.
///
/// # Errors
///
/// Where the bytes are not a request: the stream cannot be read any further.
pub fn decode(bytes: &[u8]) -> Result<Option<Framed>, Malformed> {
    let mut header = Reader(bytes);
    let (Some(command), Some(id), Some(total)) = (header.u32(), header.u32(), header.u32()) else {
        return Ok(None);
    };
    let size = total as usize;
    // Before the body: the rest of a longer request would never fit the buffer of the caller.
    if !(HEADER_BYTES..=REQUEST_BYTES).contains(&size) {
        return Err(Malformed::Size(total));
    }
    let Some(body) = bytes.get(HEADER_BYTES..size) else {
        return Ok(None);
    };
    let request = request(command, body)?;
    Ok(Some(Framed {
        command,
        id,
        request,
        size,
    }))
}

fn request(command: u32, body: &[u8]) -> Result<Request, Malformed> {
    let mut reader = Reader(body);
    let read = fields(command, &mut reader).ok_or(match command {
        0..=11 => Malformed::Body(command),
        _ => Malformed::Command(command),
    })?;
    if reader.0.is_empty() {
        return Ok(read);
    }
    Err(Malformed::Body(command))
}

fn fields(command: u32, body: &mut Reader<'_>) -> Option<Request> {
    Some(match command {
        0 => Request::Connect {
            version: body.u16()?,
            udp_port: body.u16()?,
        },
        1 => Request::Move(motion(body)?),
        2 => Request::StopMove,
        3 => {
            body.f64s::<52>()?;
            Request::SetCollisionBehavior
        }
        4 => Request::SetJointImpedance(body.f64s()?),
        5 => Request::SetCartesianImpedance(body.f64s()?),
        6 => {
            for _ in 0..7 {
                body.u8()?;
            }
            Request::SetGuidingMode
        }
        7 => Request::SetEeToK(body.f64s()?),
        8 => Request::SetNeToEe(body.f64s()?),
        9 => Request::SetLoad {
            mass: body.f64()?,
            center: body.f64s()?,
            inertia: body.f64s()?,
        },
        10 => Request::AutomaticErrorRecovery,
        11 => Request::GetRobotModel,
        _ => return None,
    })
}

fn motion(body: &mut Reader<'_>) -> Option<MoveRequest> {
    let (controller, generator) = (body.u32()?, body.u32()?);
    // Deviations of path and goal are checked by the robot's own controllers, which are
    // not part of a simulation of the interface.
    body.f64s::<6>()?;
    let is_async = body.u8()? != 0;
    body.f64s::<JOINTS>()?;
    Some(MoveRequest {
        controller,
        generator,
        is_async,
    })
}

/// Status of a reply to [`Request::Move`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum MoveStatus {
    /// The motion has ended as its client wanted.
    Success = 0,
    /// The motion has started; another reply follows.
    Started = 1,
    /// [`Request::StopMove`] ended it.
    Preempted = 2,
    /// The mode of the robot allows no motion.
    NotPossible = 5,
    /// A controller or generator that does not exist, or is not served.
    InvalidArgument = 7,
    /// A reflex ended it.
    Reflex = 8,
    /// The robot ended it for another reason.
    Aborted = 11,
}

/// A reply to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// Command of the request.
    pub command: u32,
    /// Number of the request.
    pub id: u32,
    /// 0 where the request was executed.
    pub status: u8,
}

impl Reply {
    /// Whether it ends a motion as its client wanted.
    pub fn is_success_of_motion(&self) -> bool {
        self.command == 1 && self.status == MoveStatus::Success as u8
    }

    /// The bytes, with `rest` after the status.
    pub fn encode(&self, rest: &[u8]) -> Vec<u8> {
        let size = HEADER_BYTES + 1 + rest.len();
        let size = u32::try_from(size).unwrap_or(u32::MAX);
        let mut bytes = Vec::with_capacity(HEADER_BYTES + 1 + rest.len());
        for number in [self.command, self.id, size] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.push(self.status);
        bytes.extend(rest);
        bytes
    }
}
