//! The side file of rows: their shard, and facts that do not depend on inputs. One JSON object
//! a line, the plan first.

use std::io::BufReader;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use cell_model::user_file;
use serde::{Deserialize, Serialize};

use crate::identity::Identity;
use crate::shard::Shard;

/// Which episodes a file of rows is to have.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// Build and inputs.
    #[serde(flatten)]
    pub identity: Identity,
    /// First and last seed of all shards.
    pub seeds: [u64; 2],
    /// The shard.
    pub shard: Shard,
    /// Combinations of the values of `--set`; 0 without.
    #[serde(default)]
    pub variants: u32,
    /// What `robocell run` takes beside policy and seed to run one of the episodes again; for
    /// people, as paths differ from host to host.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub arguments: Vec<String>,
}

impl Plan {
    /// First to last seed of all shards.
    pub fn range(&self) -> RangeInclusive<u64> {
        self.seeds[0]..=self.seeds[1]
    }

    /// Numbers of the combinations, of which each seed has all: 0 alone without `--set`.
    pub fn variants(&self) -> RangeInclusive<u32> {
        self.variants.min(1)..=self.variants
    }

    /// Rows of the shard.
    pub fn rows(&self) -> u64 {
        let each = u64::from(self.variants.max(1));
        self.shard.len(&self.range()).saturating_mul(each)
    }
}

/// When, where and for how long an episode ran.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// Its seed.
    pub seed: u64,
    /// Its variant; 0 without `--set`.
    #[serde(default)]
    pub variant: u32,
    /// Name of the machine.
    pub host: String,
    /// End (s since 1970).
    pub ended_s: u64,
    /// Time it took (s).
    pub wall_time_s: f64,
}

/// Path of the side file of the rows at `path`.
pub fn path_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".info");
    PathBuf::from(name)
}

/// The plan of the rows at `path`; `None` without a side file, or where it was cut off.
pub fn plan_of(path: &Path) -> Option<Plan> {
    let mut line = String::new();
    let file = user_file::open_file(&path_of(path)).ok()?;
    user_file::read_line(&mut BufReader::new(file), &mut line).ok()?;
    serde_json::from_str(&line).ok()
}
