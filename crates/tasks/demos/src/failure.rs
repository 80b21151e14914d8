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
    /// A bin is tilted too far for suction to hold it.
    BinCannotBeGripped,
    /// A bin fell out of the cell, and no other is left.
    BinLost,
    /// A bin did not stay where it was set down, again and again.
    BinCannotBePlaced,
    /// A joint of the arm is at its limit.
    ArmCaught,
    /// The arm did not arrive at its goal, again and again.
    ArmDidNotArrive,
}

impl Failure {
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
            Self::BinLost => "bin_lost",
            Self::BinCannotBePlaced => "bin_cannot_be_placed",
            Self::ArmCaught => "arm_caught",
            Self::ArmDidNotArrive => "arm_did_not_arrive",
        }
    }
}
