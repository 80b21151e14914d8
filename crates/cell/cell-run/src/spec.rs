//! One run of a cell: written by the launcher into the run directory, read by every process at
//! its start.

use std::net::IpAddr;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::wire;
use cell_model::cells::cell::{CLIENT_CONTROLLER, Cell};
use cell_model::cells::replace::Replace;
use cell_model::cells::script::ScriptLine;
use cell_model::cells::setting::Setting;
use cell_model::data::Data;
use cell_model::error::ModelError;
use cell_model::robots::files::RobotFiles;
use cell_model::runs::policy_server::PolicyServer;

pub use crate::secrets::PageSecrets;

pub use cell_model::runs::speed::Speed;

/// Written beside the run file by a run in one process when it has ended.
pub const ENDED_FILE: &str = "ended";

/// The part of a run file that every version can read.
#[derive(Deserialize)]
struct Contract {
    #[serde(default)]
    contract: String,
}

/// One run of a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunSpec {
    /// Contract between the processes of the run: [`wire::contract`] of the launcher. Empty in
    /// run files of older builds.
    #[serde(default)]
    pub contract: String,
    /// Identity of the run, never 0; in every message.
    pub run: u64,
    /// Name of the cell, for `--cell`.
    pub cell: String,
    /// The command that a person started it with, as a shell takes it; empty where none did.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub command: String,
    /// Name of the demo: `cells/DEMO.toml`.
    pub demo: String,
    /// Policy of the task.
    pub policy: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Pace of simulated time.
    pub speed: Speed,
    /// Folder with `cells/` and `robots/`; `None` for the built-in files.
    pub data_dir: Option<PathBuf>,
    /// The program of the task, if it is not the built-in one.
    #[serde(default)]
    pub task_program: Option<PathBuf>,
    /// By arm: the program with its controllers, if it is not the built-in one.
    #[serde(default)]
    pub controller_programs: Vec<Option<PathBuf>>,
    /// By arm: its Franka control interface, where it has one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fci: Vec<Option<Fci>>,
    /// Folder in which the launcher put the built-in files for the processes of this run.
    #[serde(default)]
    pub built_in_dir: PathBuf,
    /// The run directory.
    pub run_dir: PathBuf,
    /// iceoryx2's root path, inside the run directory.
    pub root: PathBuf,
    /// Prefix of iceoryx2's names.
    pub prefix: String,
    /// Arms of the cell.
    pub arms: u8,
    /// The user's own robot in place of the cell's.
    pub robot: Option<RobotFiles>,
    /// Script, in the order of its lines.
    pub script: Vec<ScriptLine>,
    /// Whether to set up the scene and wait for resume.
    pub paused: bool,
    /// Number of bins for the job; `None` for all of the cell.
    #[serde(default)]
    pub bins: Option<u32>,
    /// Settings that replace numbers of the cell file.
    #[serde(default)]
    pub set: Vec<Setting>,
    /// Leaves of the task's tree that answer without being run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub replace: Vec<Replace>,
    /// Rate at which the actions of the task change (Hz), as those of a learned policy: each is
    /// held for its period and has numbers of 32 bits. `None`: with every decision.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub action_hz: Option<u32>,
    /// Cameras whose last picture is hashed into the summary.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frame_hash: Vec<String>,
    /// How a policy behind a socket is used; the defaults where missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy_server: Option<PolicyServer>,
    /// Whether to end the run when the task is done or has failed.
    pub until_done: bool,
    /// Latest simulated time at which the run ends (s).
    pub time_limit_s: Option<f64>,
    /// Whether to try real-time scheduling and locked memory.
    pub real_time: bool,
    /// The page; `None` with `--headless`.
    pub page: Option<PageSpec>,
    /// The flight recorder.
    pub record: RecordSpec,
    /// Directory of the incidents of the cell.
    #[serde(default)]
    pub incidents_dir: PathBuf,
    /// Warnings about the inputs of the run, for the page; see [`crate::report`].
    #[serde(default)]
    pub warnings: Vec<String>,
}

/// Address and files of the page.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PageSpec {
    /// Address and port to listen at.
    pub address: std::net::SocketAddr,
    /// Name by which other machines reach it, in addition to its addresses.
    #[serde(default)]
    pub host: Option<String>,
    /// The built page; `None` for the embedded one.
    pub dist: Option<PathBuf>,
    /// Advice for people if there is no page.
    pub hint: String,
    /// [`PageSecrets`] of the run, readable by its owner only.
    pub secrets: PathBuf,
}

/// Settings of the recorder.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordSpec {
    /// Directory of the flight recorder's ring.
    pub flight_dir: PathBuf,
    /// Largest size of the ring (bytes).
    pub limit_bytes: u64,
    /// File with the whole run, with `--record`.
    pub file: Option<PathBuf>,
}

/// A run file that cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum RunSpecError {
    /// An error of the file system.
    #[error("{path}: {source}; the launcher writes this file, start the cell with `robocell run`")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Not a run file of this version.
    #[error("{path}: {source}; launcher and process are of different versions")]
    Format {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// Of a launcher with another contract.
    #[error(
        "this program is of robocell {ours}, the cell of {theirs}; use the program, or the wheel, that \
         belongs to the cell"
    )]
    Contract {
        /// [`wire::contract`] of the launcher.
        theirs: String,
        /// That of this program.
        ours: String,
    },
}

/// The Franka control interface of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fci {
    /// Where it listens.
    pub address: IpAddr,
    /// Also in lockstep a client has a millisecond of wall time for each answer.
    pub strict: bool,
}

impl RunSpec {
    /// Name of the file inside the run directory.
    pub const FILE: &'static str = "run.json";

    /// Reads the file at `path`.
    pub fn load(path: &Path) -> Result<Self, RunSpecError> {
        let text = std::fs::read_to_string(path).map_err(|source| RunSpecError::Io {
            path: path.to_owned(),
            source,
        })?;
        let format = |source| RunSpecError::Format {
            path: path.to_owned(),
            source,
        };
        // The contract is read alone first: the rest of another version may not even parse, and
        // its error would name a key instead of the reason.
        let Contract { contract: theirs } = serde_json::from_str(&text).map_err(format)?;
        let ours = wire::contract();
        if theirs != ours {
            let theirs = match theirs.as_str() {
                "" => "a version that does not tell".to_owned(),
                _ => theirs,
            };
            return Err(RunSpecError::Contract { theirs, ours });
        }
        serde_json::from_str(&text).map_err(format)
    }

    /// The cell of the run, as every process of it has it.
    ///
    /// # Errors
    /// Returns [`ModelError`] for an unknown demo, and for the first file with an error.
    pub fn load_cell(&self) -> Result<Cell, ModelError> {
        self.load_cell_from(&Data::dir(&self.built_in_dir))
    }

    /// The cell of the run; without a folder of the user the files are those of `built_in`.
    ///
    /// # Errors
    /// As [`RunSpec::load_cell`].
    pub fn load_cell_from(&self, built_in: &Data) -> Result<Cell, ModelError> {
        self.load_cell_of(&self.data(built_in))
    }

    /// The source of the files of the run; without a folder of the user it is `built_in`.
    pub fn data(&self, built_in: &Data) -> Data {
        let data = self.data_dir.as_ref().map(Data::dir);
        data.map_or_else(|| built_in.clone(), |data| data.with_robots_of(built_in))
    }

    /// The cell of the run, from the files in `data`.
    ///
    /// # Errors
    /// As [`RunSpec::load_cell`].
    pub fn load_cell_of(&self, data: &Data) -> Result<Cell, ModelError> {
        let mut cell =
            Cell::load_with(data, &self.demo, self.seed, self.robot.as_ref(), &self.set)?;
        self.bins.map_or(Ok(()), |bins| cell.limit_bins(bins))?;
        for (arm, fci) in cell.arms.iter_mut().zip(&self.fci) {
            // Client programs command this arm, whichever controller the cell file names.
            if fci.is_some() {
                arm.controller = Some(CLIENT_CONTROLLER.to_owned());
            }
        }
        cell.replace.clone_from(&self.replace);
        cell.policy_server.clone_from(&self.policy_server);
        Ok(cell)
    }

    /// Writes the file at `path`.
    pub fn save(&self, path: &Path) -> Result<(), RunSpecError> {
        let text = serde_json::to_string_pretty(self).map_err(|source| RunSpecError::Format {
            path: path.to_owned(),
            source,
        })?;
        cell_model::draft::replace_unsynced(path, text.as_bytes(), 0o644).map_err(|source| {
            RunSpecError::Io {
                path: path.to_owned(),
                source,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Speed;

    #[test]
    fn speeds_are_read_as_people_write_them() {
        assert_eq!("1".parse(), Ok(Speed::RealTime));
        assert_eq!("max".parse(), Ok(Speed::Max));
        assert_eq!("2.5".parse(), Ok(Speed::Factor(2.5)));
        for bad in ["0", "nan", "-1", "fast", "1e9"] {
            assert!(bad.parse::<Speed>().is_err(), "{bad}");
        }
    }
}
