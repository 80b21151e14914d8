//! All readers of input from people and other processes, as functions of bytes: they must not
//! panic, for any bytes.
//!
//! The tests run each target on its corpus and on some thousand changed files of it; the
//! programs in `fuzz/` run them for as long as one likes (docs/fuzzing.md).

pub(crate) mod checkpoint;
pub(crate) mod files;
pub(crate) mod messages;
pub(crate) mod mutate;
pub(crate) mod recording;
pub(crate) mod robot;

/// One reader.
#[derive(Clone, Copy)]
pub(crate) struct Target {
    /// Its name, also of its program in `fuzz/`.
    pub(crate) name: &'static str,
    /// Reads the bytes, and uses the result.
    pub(crate) run: fn(&[u8]),
    /// Valid inputs from which the changes start.
    pub(crate) corpus: fn() -> Vec<Vec<u8>>,
}

/// All of them.
pub(crate) const TARGETS: [Target; 15] = [
    files::CELL,
    files::TREE,
    files::MACHINE,
    files::MATRIX,
    files::URDF,
    files::XRDF,
    files::TUNING,
    messages::SCRIPT,
    messages::COMMAND,
    messages::POLICY_ANSWER,
    messages::MESSAGE,
    recording::RECORDING,
    checkpoint::CHECKPOINT,
    robot::FCI_STREAM,
    robot::FCI_DATAGRAM,
];

/// The target of that name.
pub(crate) fn target(name: &str) -> Option<Target> {
    TARGETS.into_iter().find(|target| target.name == name)
}
