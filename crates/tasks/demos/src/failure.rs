//! Reasons for which the jobs of the demos fail.

/// Reason for which a job failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The next cube stayed too far from the arm.
    CubeOutOfReach,
    /// A cube was lost again and again before it was set down.
    CubeCannotBeGripped,
    /// A cube did not stay where it was set down, again and again.
    CubeCannotBePlaced,
    /// A cube fell off the table.
    CubeLost,
    /// The gripper did not open.
    GripperBlocked,
    /// A bin is out of the arm's reach.
    BinOutOfReach,
    /// A bin is tilted too far for suction to hold it, or suction found no hold on it.
    BinCannotBeGripped,
    /// A bin was lost from the gripper again and again.
    BinCannotBeHeld,
    /// A bin fell out of the cell, and no other is left.
    BinLost,
    /// A bin did not stay where it was set down, again and again.
    BinCannotBePlaced,
    /// Another object is where the bin belongs, and no other place is free.
    PlaceTaken,
    /// No part is left that could break the grip of the bin.
    NoPartsLeft,
    /// A joint of the arm is at its limit.
    ArmCaught,
    /// The arm did not arrive at its goal, again and again.
    ArmDidNotArrive,
}

impl Failure {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::CubeOutOfReach,
        Self::CubeCannotBeGripped,
        Self::CubeCannotBePlaced,
        Self::CubeLost,
        Self::GripperBlocked,
        Self::BinOutOfReach,
        Self::BinCannotBeGripped,
        Self::BinCannotBeHeld,
        Self::BinLost,
        Self::BinCannotBePlaced,
        Self::PlaceTaken,
        Self::NoPartsLeft,
        Self::ArmCaught,
        Self::ArmDidNotArrive,
    ];

    /// Stable name in the summary and in the decision.
    pub fn reason(self) -> &'static str {
        match self {
            Self::CubeOutOfReach => "cube_out_of_reach",
            Self::CubeCannotBeGripped => "cube_cannot_be_gripped",
            Self::CubeCannotBePlaced => "cube_cannot_be_placed",
            Self::CubeLost => "cube_lost",
            Self::GripperBlocked => "gripper_blocked",
            Self::BinOutOfReach => "bin_out_of_reach",
            Self::BinCannotBeGripped => "bin_cannot_be_gripped",
            Self::BinCannotBeHeld => "bin_cannot_be_held",
            Self::BinLost => "bin_lost",
            Self::BinCannotBePlaced => "bin_cannot_be_placed",
            Self::PlaceTaken => "place_taken",
            Self::NoPartsLeft => "no_parts_left",
            Self::ArmCaught => "arm_caught",
            Self::ArmDidNotArrive => "arm_did_not_arrive",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robocell_skills::{grip, pick, place};

    /// No program and no person can rely on a name that no document has.
    #[test]
    fn every_reason_is_documented() {
        let document = include_str!("../../../../docs/reasons.md");
        let of_skills = [
            pick::reason::ALL,
            place::reason::ALL,
            &[grip::GRIPPER_BLOCKED],
        ];
        let all = Failure::ALL.map(Failure::reason);
        for reason in all.into_iter().chain(of_skills.concat()) {
            assert!(document.contains(&format!("`{reason}`")), "{reason}");
        }
        let mut names = all.to_vec();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Failure::ALL.len(), "two causes share a name");
    }
}
