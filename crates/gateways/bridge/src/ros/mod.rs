//! ROS 2 as `rmw_zenoh` puts it on the network: messages in CDR, type hashes, keys.

pub mod attachment;
pub mod messages;
pub mod names;
pub mod types;

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Before every message: plain CDR, little-endian (DDSI-RTPS, 10.2).
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message in the format of the network.
///
/// # Errors
/// If CDR has no form for the message, such as a sequence of unknown length.
pub fn encode(message: &impl Serialize) -> Result<Vec<u8>, cdr_encoding::Error> {
    let mut bytes = ENCAPSULATION.to_vec();
    bytes.extend(cdr_encoding::to_vec::<_, LittleEndian>(message)?);
    Ok(bytes)
}

/// A message from the network; `None` if the bytes are not of this type.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let (head, body) = bytes.split_at_checked(ENCAPSULATION.len())?;
    // A client may send in the byte order of its machine; the head tells which.
    let read = match head.get(1)? {
        0 => cdr_encoding::from_bytes::<T, byteorder::BigEndian>(body),
        1 => cdr_encoding::from_bytes::<T, LittleEndian>(body),
        _ => return None,
    };
    read.ok().map(|(message, _)| message)
}

#[cfg(test)]
mod tests {
    use super::messages::{Header, Pose, PoseStamped, Time};
    use super::*;

    #[test]
    fn a_message_is_read_back_and_what_is_cut_off_or_too_long_is_none() {
        let message = PoseStamped {
            header: Header {
                stamp: Time { sec: 3, nanosec: 7 },
                frame_id: "world".to_owned(),
            },
            pose: Pose::default(),
        };
        let bytes = encode(&message).unwrap();
        // Encapsulation, stamp, length and text with padding, 7 doubles at a multiple of 8.
        assert_eq!(bytes.len(), 4 + 8 + 4 + 6 + 6 + 7 * 8);
        assert_eq!(decode::<PoseStamped>(&bytes), Some(message));
        for end in [0, 3, 4, 20, bytes.len() - 1] {
            assert_eq!(decode::<PoseStamped>(&bytes[..end]), None, "{end}");
        }
        let mut lies = bytes.clone();
        lies[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(decode::<PoseStamped>(&lies), None);
    }
}
