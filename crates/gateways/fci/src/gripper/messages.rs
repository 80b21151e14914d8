//! Messages over TCP, to and from the hand.

use serde::{Deserialize, Serialize};

use crate::bytes::Reader;

/// The version of the protocol that is served.
pub const GRIPPER_VERSION: u16 = 3;
/// Bytes of the header of a request and of a reply: command, id, size.
pub const GRIPPER_HEADER_BYTES: usize = 10;
/// Longest request.
// Grasp, 50 bytes, is the longest one.
pub const GRIPPER_REQUEST_BYTES: usize = 64;
/// Bytes of a state.
pub const GRIPPER_STATE_BYTES: usize = 23;

/// A request of a client.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GripperRequest {
    /// The first one of a connection.
    Connect {
        /// Version of the client.
        version: u16,
        /// Port of the client for states.
        udp_port: u16,
    },
    /// Finds the largest width.
    Homing,
    /// Closes until something is held.
    Grasp {
        /// Expected width of the object (m).
        width: f64,
        /// By how much it may be narrower (m).
        inner: f64,
        /// By how much it may be wider (m).
        outer: f64,
        /// m/s.
        speed: f64,
        /// N.
        force: f64,
    },
    /// Moves to a width.
    Move {
        /// m.
        width: f64,
        /// m/s.
        speed: f64,
    },
    /// Ends a motion.
    Stop,
}

/// A request with its place in the stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripperFramed {
    /// Number of the command; a reply repeats it.
    pub command: u16,
    /// Number of the request; a reply repeats it.
    pub id: u32,
    /// The request.
    pub request: GripperRequest,
    /// Bytes that it took.
    pub size: usize,
}

/// The first request in `bytes`; `None` until all of it has arrived.
///
/// # Errors
///
/// The command and the size that no request has: the stream cannot be read any further.
pub fn decode_gripper(bytes: &[u8]) -> Result<Option<GripperFramed>, (u16, u32)> {
    let mut header = Reader(bytes);
    let (Some(command), Some(id), Some(total)) = (header.u16(), header.u32(), header.u32()) else {
        return Ok(None);
    };
    let size = total as usize;
    if !(GRIPPER_HEADER_BYTES..=GRIPPER_REQUEST_BYTES).contains(&size) {
        return Err((command, total));
    }
    let Some(body) = bytes.get(GRIPPER_HEADER_BYTES..size) else {
        return Ok(None);
    };
    let mut body = Reader(body);
    let request = request(command, &mut body).filter(|_| body.0.is_empty());
    let request = request.ok_or((command, total))?;
    Ok(Some(GripperFramed {
        command,
        id,
        request,
        size,
    }))
}

fn request(command: u16, body: &mut Reader<'_>) -> Option<GripperRequest> {
    Some(match command {
        0 => GripperRequest::Connect {
            version: body.u16()?,
            udp_port: body.u16()?,
        },
        1 => GripperRequest::Homing,
        2 => GripperRequest::Grasp {
            width: body.f64()?,
            inner: body.f64()?,
            outer: body.f64()?,
            speed: body.f64()?,
            force: body.f64()?,
        },
        3 => GripperRequest::Move {
            width: body.f64()?,
            speed: body.f64()?,
        },
        4 => GripperRequest::Stop,
        _ => return None,
    })
}

/// A reply to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GripperReply {
    /// Command of the request.
    pub command: u16,
    /// Number of the request.
    pub id: u32,
    /// 0 success, 1 failed, 2 unsuccessful, 3 aborted.
    pub status: u16,
}

impl GripperReply {
    /// The bytes, with `rest` after the status.
    pub fn encode(&self, rest: &[u8]) -> Vec<u8> {
        let size = GRIPPER_HEADER_BYTES + 2 + rest.len();
        let total = u32::try_from(size).unwrap_or(u32::MAX);
        let mut bytes = Vec::with_capacity(size);
        bytes.extend(self.command.to_le_bytes());
        bytes.extend(self.id.to_le_bytes());
        bytes.extend(total.to_le_bytes());
        bytes.extend(self.status.to_le_bytes());
        bytes.extend(rest);
        bytes
    }
}
