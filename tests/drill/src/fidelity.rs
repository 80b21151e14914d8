//! Whether the real cell does what the drill does: a plan of script lines in lockstep has the
//! same state hash in both.

use std::path::Path;
use std::process::Command;

use serde::Serialize;
use serde_json::Value;

use crate::draw;
use crate::planted::root;
use crate::run::run;

/// A plan that ran in both.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    /// Its seed.
    pub seed: u64,
    /// Name of the demo.
    pub demo: String,
    /// Last tick, and its state hash in the drill and in the real cell.
    pub tick: u64,
    /// See above.
    pub drill: String,
    /// See above.
    pub real: String,
}

impl Compared {
    /// Whether both are equal.
    pub fn is_equal(&self) -> bool {
        self.drill == self.real
    }
}

/// Runs the plan of `seed` in the drill and as four processes.
///
/// # Errors
/// In words, where one of the two cannot run.
pub fn compare(seed: u64) -> Result<Compared, String> {
    let plan = draw::scripted(seed);
    let outcome = run(&plan)?;
    if let Some(failed) = outcome.failed {
        return Err(format!(
            "seed {seed}: invariant {}, {}",
            failed.invariant, failed.why
        ));
    }
    let last = outcome.hashes.last().copied();
    let (tick, hash) = last.ok_or_else(|| format!("seed {seed}: no state was seen"))?;
    let dir = root().join("target/drill/fidelity");
    std::fs::create_dir_all(&dir).map_err(|error| format!("{}: {error}", dir.display()))?;
    let script = dir.join(format!("{seed}.jsonl"));
    std::fs::write(&script, plan.script.join("\n"))
        .map_err(|error| format!("{}: {error}", script.display()))?;
    let limit_s = plan.limit_s.unwrap_or_default().to_string();
    let seed_word = seed.to_string();
    let summary = real(
        &[
            "run",
            &plan.demo,
            "--policy",
            &plan.policy,
            "--seed",
            &seed_word,
            "--speed",
            "max",
            "--headless",
            "--until-done",
            "--cell",
            "drill",
            "--timeout",
            &limit_s,
            "--json",
            "--script",
        ],
        &script,
    )?;
    Ok(Compared {
        seed,
        demo: plan.demo,
        tick,
        drill: format!("{tick} {hash:016x}"),
        real: format!(
            "{} {}",
            summary["ticks"],
            summary["state_hash"].as_str().unwrap_or_default()
        ),
    })
}

/// The summary of `robocell WORDS SCRIPT`.
fn real(words: &[&str], script: &Path) -> Result<Value, String> {
    let mut robocell = Command::new("cargo");
    robocell.current_dir(root()).args(["robocell"]).args(words);
    let output = robocell
        .arg(script)
        .output()
        .map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().last().unwrap_or_default();
    serde_json::from_str(line).map_err(|error| {
        let said = String::from_utf8_lossy(&output.stderr);
        format!("{robocell:?}: {error}: {said}")
    })
}
