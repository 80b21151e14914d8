//! Everything that reads what a person can type or another process can send, as
//! functions of bytes: they must not panic, whatever the bytes are.
//!
//! The tests run each target on its corpus and on some thousand changed files of it; the
//! programs in `fuzz/` run them for as long as one likes (docs/fuzzing.md).

mod checkpoint;
mod files;
mod messages;
pub(crate) mod mutate;
mod recording;

/// One reader.
#[derive(Clone, Copy)]
pub(crate) struct Target {
    /// Its name, also of its program in `fuzz/`.
    pub(crate) name: &'static str,
    /// Reads the bytes, and uses what it read.
    pub(crate) run: fn(&[u8]),
    /// Valid inputs to begin with.
    pub(crate) corpus: fn() -> Vec<Vec<u8>>,
}

/// All of them.
pub(crate) const TARGETS: [Target; 12] = [
    files::CELL,
    files::TREE,
    files::MACHINE,
    files::MATRIX,
    files::URDF,
    files::XRDF,
    files::TUNING,
    messages::SCRIPT,
    messages::COMMAND,
    messages::MESSAGE,
    recording::RECORDING,
    checkpoint::CHECKPOINT,
];

/// The target of that name.
pub(crate) fn target(name: &str) -> Option<Target> {
    TARGETS.into_iter().find(|target| target.name == name)
}
