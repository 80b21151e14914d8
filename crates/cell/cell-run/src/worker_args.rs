//! The arguments with which the launcher starts every process.

use std::path::PathBuf;

/// `--spec RUN_DIR/run.json --generation N [--arm I]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorkerArgs {
    /// The run file.
    pub spec: PathBuf,
    /// Number of the start of this process, from 1.
    pub generation: u32,
    /// Index of the arm, for a controller.
    pub arm: u8,
}

/// An error in the arguments, with the way to start the program.
#[derive(Debug, thiserror::Error)]
#[error(
    "{0}; the launcher starts this program as `--spec RUN_DIR/run.json --generation N [--arm I]`, people start `robocell run DEMO`"
)]
pub struct WorkerArgsError(String);

impl WorkerArgs {
    /// Parses the arguments after the program's name.
    pub fn parse(arguments: impl Iterator<Item = String>) -> Result<Self, WorkerArgsError> {
        let mut arguments = arguments;
        let (mut spec, mut generation, mut arm) = (None, None, 0);
        while let Some(name) = arguments.next() {
            let value = arguments
                .next()
                .ok_or_else(|| WorkerArgsError(format!("{name} has no value")))?;
            match name.as_str() {
                "--spec" => spec = Some(PathBuf::from(value)),
                "--generation" => generation = Some(number(&name, &value)?),
                "--arm" => arm = number(&name, &value)?,
                // A launcher of another version may mean something by it, so it is not ignored.
                _ => return Err(WorkerArgsError(format!("{name} is unknown"))),
            }
        }
        Ok(Self {
            spec: spec.ok_or_else(|| WorkerArgsError("--spec is missing".to_owned()))?,
            generation: generation
                .ok_or_else(|| WorkerArgsError("--generation is missing".to_owned()))?,
            arm,
        })
    }
}

fn number<T: std::str::FromStr>(name: &str, value: &str) -> Result<T, WorkerArgsError> {
    value.parse().map_err(|_not_a_number| {
        WorkerArgsError(format!("{name} is {value:?}, not a small whole number"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<WorkerArgs, String> {
        WorkerArgs::parse(line.split_whitespace().map(str::to_owned)).map_err(|e| e.to_string())
    }

    #[test]
    fn the_launchers_line_is_read_and_a_wrong_one_says_how() {
        let args = parse("--spec /x/run.json --generation 3 --arm 1").unwrap();
        assert_eq!((args.generation, args.arm), (3, 1));
        for bad in ["", "--spec", "--spec a --generation x", "--speck a"] {
            assert!(parse(bad).unwrap_err().contains("robocell run"), "{bad}");
        }
    }
}
