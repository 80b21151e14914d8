//! Snapshots of the page protocol, as far as a terminal shows them.

/// `RCS1`.
const MAGIC: u32 = 0x3153_4352;
/// Bytes before the arms, and of an arm.
const HEADER: usize = 48;
const ARM: usize = 187 * 4;
/// Most joints of an arm.
const JOINTS: usize = 16;

/// A moment of the cell.
#[derive(Debug, PartialEq)]
pub(super) struct Snapshot {
    pub(super) time_s: f64,
    pub(super) real_time_factor: f64,
    pub(super) is_paused: bool,
    pub(super) arms: Vec<ArmFrame>,
}

/// An arm of it.
#[derive(Debug, PartialEq)]
pub(super) struct ArmFrame {
    pub(super) joint_positions: Vec<f64>,
    pub(super) joint_efforts: Vec<f64>,
    pub(super) tcp: [f64; 3],
    pub(super) width_m: f64,
    pub(super) grip_force: f64,
    pub(super) load: f64,
    /// Index plus 1; 0 for none.
    pub(super) held_object: usize,
}

impl Snapshot {
    /// `None` for what is no snapshot, or a part of one.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        if word(bytes, 0)? != MAGIC {
            return None;
        }
        let arms = word(bytes, 32)? as usize;
        let arm = |index: usize| ArmFrame::of(bytes.get(HEADER + index * ARM..)?);
        // As many as the bytes can hold, whatever the number says.
        let most = bytes.len() / ARM;
        Some(Self {
            time_s: double(bytes, 8)?,
            real_time_factor: double(bytes, 24)?,
            is_paused: word(bytes, 4)? & 1 != 0,
            arms: (0..arms.min(most)).map(arm).collect::<Option<_>>()?,
        })
    }
}

impl ArmFrame {
    fn of(bytes: &[u8]) -> Option<Self> {
        let bytes = bytes.get(..ARM)?;
        let float = |at: usize| Some(f64::from(f32::from_bits(word(bytes, 4 * at)?)));
        let joints = (word(bytes, 0)? as usize).min(JOINTS);
        let floats = |at: usize| (at..at + joints).map(float).collect::<Option<Vec<_>>>();
        Some(Self {
            joint_positions: floats(4)?,
            joint_efforts: floats(36)?,
            tcp: [float(84)?, float(85)?, float(86)?],
            width_m: float(105)?,
            grip_force: float(106)?,
            load: float(107)?,
            held_object: word(bytes, 4 * 110)? as usize,
        })
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let word = bytes.get(at..)?.first_chunk()?;
    Some(u32::from_le_bytes(*word))
}

fn double(bytes: &[u8], at: usize) -> Option<f64> {
    let double = bytes.get(at..)?.first_chunk()?;
    Some(f64::from_le_bytes(*double))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_snapshot_is_read_and_a_part_of_one_is_none() {
        let mut bytes = vec![0; HEADER + ARM];
        let mut put = |at: usize, word: u32| {
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        };
        put(0, MAGIC);
        put(4, 1);
        put(32, 1);
        put(HEADER, 7);
        put(HEADER + 4 * 10, 0.5_f32.to_bits());
        put(HEADER + 4 * 86, 0.25_f32.to_bits());
        put(HEADER + 4 * 110, 3);
        let snapshot = Snapshot::of(&bytes).unwrap();
        let arm = &snapshot.arms[0];
        assert!(snapshot.is_paused && arm.held_object == 3 && arm.joint_positions.len() == 7);
        assert!((arm.joint_positions[6] - 0.5).abs() < 1e-9 && (arm.tcp[2] - 0.25).abs() < 1e-9);
        // A cut message has fewer arms than it says.
        assert!(Snapshot::of(&bytes[..HEADER + ARM - 4]).is_none_or(|s| s.arms.is_empty()));
        assert_eq!(Snapshot::of(&bytes[1..]), None);
        assert_eq!(Snapshot::of(&[]), None);
    }
}
