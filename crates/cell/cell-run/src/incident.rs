//! An incident: the data kept when a process or an arm of a run failed.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use ipc_types::topic::Process;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Largest number of incidents of one cell on disk; the oldest is deleted.
pub const KEPT: usize = 32;

/// Part of the description of a process that does not get the processor.
pub const STARVED: &str = "gets too little processor time";

/// The ring of the last cycles of `process` in the run directory `dir`.
pub fn ring_path(dir: &Path, process: &str) -> PathBuf {
    dir.join("blackbox").join(format!("{process}.ring"))
}

/// Names of the values that `process` keeps with each cycle, with units.
pub fn value_names(process: Process) -> [&'static str; 4] {
    match process {
        Process::Physics => [
            "arm 0 stop action",
            "arm 0 fastest joint (rad/s)",
            "arm 1 stop action",
            "arm 1 fastest joint (rad/s)",
        ],
        Process::Controller(_) => [
            "stop action",
            "decision age (ticks)",
            "fastest joint setpoint (rad/s)",
            "distance to target (m)",
        ],
        Process::Task => ["outcome", "", "", ""],
        Process::Monitor => [""; 4],
    }
}

/// One incident. Times are milliseconds after its first event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Incident {
    /// Number, cause and run of the incident.
    #[serde(flatten)]
    pub head: Head,
    /// What happened, in order.
    pub events: Vec<Event>,
    /// The last cycles of each loop.
    pub loops: Vec<LoopTrace>,
    /// The last lines of the logs of the processes it is about.
    pub logs: Vec<LogTail>,
    /// The flight recorder's ring, which has the messages of that time.
    #[schemars(with = "String")]
    pub recording: PathBuf,
}

/// What an incident is about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Head {
    /// From 1 up, in one cell.
    pub number: u32,
    /// What failed first.
    pub what: String,
    /// What failed in the second after it.
    #[serde(default)]
    pub also: Vec<String>,
    /// Wall clock, UTC, for people.
    pub at: String,
    /// Simulated time (s).
    pub sim_time_s: f64,
    /// Identity of the run.
    pub run: u64,
    /// The demo.
    pub demo: String,
    /// Its policy.
    pub policy: String,
    /// Seed of the run.
    pub seed: u64,
    /// Version of robocell.
    pub version: String,
    /// Whether the second after the first event is in it.
    pub complete: bool,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Event {
    /// When.
    pub at_ms: f64,
    /// In words.
    pub what: String,
}

/// Cycles of one loop, as columns of the same length, the oldest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LoopTrace {
    /// Process of the loop.
    pub process: String,
    /// Which start of the process.
    pub generation: Vec<u16>,
    /// Tick it worked on.
    pub tick: Vec<u64>,
    /// When it began.
    pub at_ms: Vec<f64>,
    /// How long after its deadline that was (µs).
    pub late_us: Vec<f64>,
    /// How long it took (µs).
    pub body_us: Vec<f64>,
    /// Overruns: index of the cycle, and the cause.
    pub overruns: Vec<(usize, String)>,
    /// What else the loop kept, by name.
    pub values: BTreeMap<String, Vec<f64>>,
}

/// The end of a log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LogTail {
    /// Whose.
    pub process: String,
    /// The lines.
    pub lines: Vec<String>,
}

/// The directory of the incidents of one cell.
#[derive(Clone, Debug)]
pub struct Incidents {
    dir: PathBuf,
}

impl Incidents {
    /// The incidents in `dir`, which need not exist.
    pub fn at(dir: PathBuf) -> Self {
        Self { dir }
    }

    /// Path of the incident `number`: a directory with `incident.json` and the state files of
    /// its process.
    pub fn path(&self, number: u32) -> PathBuf {
        self.dir.join(number.to_string())
    }

    /// The numbers of all incidents, in order.
    pub fn numbers(&self) -> Vec<u32> {
        let entries = fs::read_dir(&self.dir).into_iter().flatten().flatten();
        let number = |entry: fs::DirEntry| entry.file_name().to_str()?.parse().ok();
        let mut numbers: Vec<u32> = entries.filter_map(number).collect();
        // A directory is listed in any order.
        numbers.sort_unstable();
        numbers
    }

    /// The head of the incident `number`.
    ///
    /// # Errors
    /// Returns errors of the file system, and one for a file of another version.
    pub fn head(&self, number: u32) -> io::Result<Head> {
        Ok(serde_json::from_slice(&self.bytes(number)?)?)
    }

    /// The incident `number`.
    ///
    /// # Errors
    /// As [`Self::head`].
    pub fn load(&self, number: u32) -> io::Result<Incident> {
        Ok(serde_json::from_slice(&self.bytes(number)?)?)
    }

    /// The incident `number` as JSON text.
    ///
    /// # Errors
    /// Returns errors of the file system.
    pub fn bytes(&self, number: u32) -> io::Result<Vec<u8>> {
        fs::read(self.path(number).join(FILE))
    }

    /// Writes an incident, a second time when it is complete, and deletes the oldest ones.
    ///
    /// # Errors
    /// Returns errors of the file system.
    pub fn save(&self, incident: &Incident) -> io::Result<()> {
        let dir = self.path(incident.head.number);
        fs::create_dir_all(&dir)?;
        cell_model::draft::replace_unsynced(
            &dir.join(FILE),
            &serde_json::to_vec(incident)?,
            0o600,
        )?;
        // Last: where the new incident cannot be written, no old one is deleted.
        let numbers = self.numbers();
        let old = numbers.len().saturating_sub(KEPT);
        for number in &numbers[..old] {
            fs::remove_dir_all(self.path(*number))?;
        }
        Ok(())
    }
}

const FILE: &str = "incident.json";

impl LoopTrace {
    /// The value at `percent` % of the sorted `of`, 100 for the largest; 0 without cycles.
    pub fn percentile(of: &[f64], percent: usize) -> f64 {
        let mut sorted = of.to_vec();
        sorted.sort_by(f64::total_cmp);
        let index = sorted.len().saturating_sub(1) * percent.min(100) / 100;
        sorted.get(index).copied().unwrap_or(0.0)
    }

    /// Overruns by cause.
    pub fn causes(&self) -> BTreeMap<&str, usize> {
        let mut causes = BTreeMap::new();
        for (_, cause) in &self.overruns {
            *causes.entry(cause.as_str()).or_default() += 1;
        }
        causes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn incident(number: u32) -> Incident {
        Incident {
            head: Head {
                number,
                also: Vec::new(),
                what: "task was killed (SIGKILL)".to_owned(),
                at: String::new(),
                sim_time_s: 1.5,
                run: 7,
                demo: "reach".to_owned(),
                policy: "fsm".to_owned(),
                seed: 3,
                version: String::new(),
                complete: false,
            },
            events: Vec::new(),
            loops: vec![LoopTrace::default()],
            logs: Vec::new(),
            recording: PathBuf::new(),
        }
    }

    #[test]
    fn the_newest_incidents_are_kept() {
        let dir = std::env::temp_dir().join(format!("robocell-incidents-{}", std::process::id()));
        let incidents = Incidents::at(dir.clone());
        assert!(incidents.numbers().is_empty());
        for number in (1..=KEPT + 2).filter_map(|number| u32::try_from(number).ok()) {
            incidents.save(&incident(number)).unwrap();
        }
        assert_eq!(incidents.numbers().len(), KEPT);
        assert_eq!(incidents.numbers()[0], 3);
        let mut again = incident(5);
        again.head.complete = true;
        incidents.save(&again).unwrap();
        assert_eq!(incidents.load(5).unwrap(), again);
        assert!(incidents.head(5).unwrap().complete && !incidents.head(6).unwrap().complete);
        incidents.head(1).unwrap_err();
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn the_median_of_few_and_of_none() {
        assert_eq!(LoopTrace::percentile(&[3.0, 1.0, 2.0], 50), 2.0);
        assert_eq!(LoopTrace::percentile(&[3.0, 1.0, 2.0], 100), 3.0);
        assert_eq!(LoopTrace::percentile(&[], 99), 0.0);
    }
}
