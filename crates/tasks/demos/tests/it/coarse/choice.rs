//! Events that may happen between two decisions.

/// By cube where it matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// All go where they shall.
    Nothing,
    /// The arm does not get anywhere.
    ArmStuck,
    /// The fingers do not open.
    GripperStuck,
    /// The fingers find no hold.
    Slippery,
    /// The held object falls out.
    Lost,
    /// A cube that is not held is put elsewhere.
    Moved(usize),
    /// A cube that is not held is put out of reach.
    Taken(usize),
    /// The task is reset.
    Reset,
    /// The task is killed, and a new one resumes from its checkpoint.
    Killed,
    /// The same, and meanwhile the held object falls out.
    KilledLost,
    /// The operator pauses the task, opens the hand, puts its content elsewhere and resumes the
    /// task.
    Led,
}

impl Choice {
    pub(crate) const ALL: [Self; 13] = [
        Self::Nothing,
        Self::ArmStuck,
        Self::GripperStuck,
        Self::Slippery,
        Self::Lost,
        Self::Moved(0),
        Self::Moved(1),
        Self::Taken(0),
        Self::Taken(1),
        Self::Reset,
        Self::Killed,
        Self::KilledLost,
        Self::Led,
    ];
}
