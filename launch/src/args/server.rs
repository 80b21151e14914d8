//! Arguments about a policy behind a socket.

use std::path::PathBuf;

use clap::Args;

/// Observations and answers of a policy behind a socket.
#[derive(Clone, Debug, Default, Args)]
pub struct ServerArgs {
    /// Keys of the observations for a policy behind a socket, as lines
    /// "pixels/front" = "observation/image"; only those are sent
    #[arg(long, value_name = "FILE.toml", requires = "policy")]
    pub names: Option<PathBuf>,
    /// Write the answers of a policy behind a socket to this directory
    #[arg(long, value_name = "DIR", requires = "policy")]
    pub keep_answers: Option<PathBuf>,
    /// Use the answers in this directory, or file of one episode, in place of the server
    #[arg(
        long,
        value_name = "DIR|FILE",
        requires = "policy",
        conflicts_with = "keep_answers"
    )]
    pub answers: Option<PathBuf>,
}

/// Largest latency (ms).
const MAX_LATENCY_MS: u32 = 60_000;

/// Reads a latency (ms).
pub(crate) fn latency(text: &str) -> Result<u32, String> {
    let ms = text.parse().ok().filter(|ms| *ms <= MAX_LATENCY_MS);
    ms.ok_or_else(|| format!("a latency is a whole number of ms from 0 to {MAX_LATENCY_MS}"))
}
