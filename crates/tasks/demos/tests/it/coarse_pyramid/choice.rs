//! Events that may happen between two decisions.

/// Number of arms.
pub(crate) const ARMS: usize = 2;

/// By arm or cube where it matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// All go where they shall.
    Nothing,
    /// The arm takes longer than the other one.
    Slow(usize),
    /// The arm does not get anywhere, for long.
    Stuck(usize),
    /// The fingers do not open, for long.
    HandStuck(usize),
    /// The fingers find no hold.
    Slippery(usize),
    /// The held object falls out and tumbles away.
    Lost(usize),
    /// A cube that is not held is put elsewhere, within reach of both arms.
    Moved(usize),
    /// A cube that is not held is put out of reach.
    Taken(usize),
    /// A cube that is not held is put beside the stack of an arm, in its way.
    Beside(usize, usize),
    /// The controller falls silent: the arm stays, the fingers too.
    Silent(usize),
    /// It answers again.
    Heard(usize),
    /// The task is reset.
    Reset,
    /// The task is killed, and a new one resumes from its checkpoint.
    Killed,
    /// The same, and meanwhile a cube falls out of the hand.
    KilledLost(usize),
    /// The operator pauses the task, opens the hand, puts its content elsewhere and resumes the
    /// task.
    Led(usize),
}

impl Choice {
    /// All there are with so many cubes.
    pub(crate) fn all(cubes: usize) -> Vec<Self> {
        let of_arm = |arm| {
            [
                Self::Slow(arm),
                Self::Stuck(arm),
                Self::HandStuck(arm),
                Self::Slippery(arm),
                Self::Lost(arm),
                Self::Silent(arm),
                Self::Heard(arm),
                Self::KilledLost(arm),
                Self::Led(arm),
            ]
        };
        let of_cube = |cube| {
            [
                Self::Moved(cube),
                Self::Taken(cube),
                Self::Beside(cube, 0),
                Self::Beside(cube, 1),
            ]
        };
        [Self::Nothing, Self::Reset, Self::Killed]
            .into_iter()
            .chain((0..ARMS).flat_map(of_arm))
            .chain((0..cubes).flat_map(of_cube))
            .collect()
    }

    /// Whether it disturbs the work.
    pub(crate) fn disturbs(self) -> bool {
        !matches!(self, Self::Nothing | Self::Slow(_) | Self::Heard(_))
    }
}
