//! How the values on the command line are read.

/// Name of a cell: it becomes a directory.
pub(crate) fn cell_name(text: &str) -> Result<String, String> {
    let fine = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    // The name is part of the paths of sockets, which end at 108 bytes.
    if (1..=24).contains(&text.len()) && text.chars().all(fine) && !text.starts_with('-') {
        return Ok(text.to_owned());
    }
    Err("a cell's name has 1 to 24 letters, digits, `-` or `_`".to_owned())
}

/// Name of a machine, as it is in a link.
pub(crate) fn host_name(text: &str) -> Result<String, String> {
    let fine = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '.');
    // 253 is the longest name in DNS.
    if (1..=253).contains(&text.len()) && text.chars().all(fine) {
        return Ok(text.to_owned());
    }
    Err(
        "the name of a machine has letters, digits, `-` and `.`, without `http://` and port"
            .to_owned(),
    )
}

/// A coordinate (m) or an angle (rad, or degrees where `--deg` is given).
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    let allowed = "a finite number between -1000 and 1000";
    match text.parse::<f64>() {
        // Processes refuse messages with larger positions (`ipc_types::validate`).
        Ok(value) if value.is_finite() && value.abs() <= 1000.0 => Ok(value),
        // As in `0.5m` or `90deg`: the number is fine, the unit is the mistake.
        Err(_) if text.starts_with(|c: char| c.is_ascii_digit() || "-.".contains(c)) => {
            Err(format!(
                "{allowed}, without a unit: metres for positions; radians for angles, or degrees with `--deg`"
            ))
        }
        _ => Err(allowed.to_owned()),
    }
}

/// A contact force (N).
pub(crate) fn newtons(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (1.0..=1000.0).contains(&value) => Ok(value),
        _ => Err("newtons, from 1 to 1000".to_owned()),
    }
}

/// A seed.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("a whole number from 0 to {}", u64::MAX))
}

/// A place in a list, or a count of things.
pub(crate) fn count(text: &str) -> Result<u32, String> {
    text.parse()
        .map_err(|_| format!("a whole number from 0 to {}", u32::MAX))
}

/// How far a sphere may reach out of the geometry that it covers (m).
pub(crate) fn margin(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.001..=1.0).contains(&value) => Ok(value),
        _ => Err("metres, from 0.001 to 1".to_owned()),
    }
}

/// Spheres of a link.
pub(crate) fn sphere_count(text: &str) -> Result<u32, String> {
    match text.parse::<u32>() {
        Ok(value) if (1..=200).contains(&value) => Ok(value),
        _ => Err("a whole number from 1 to 200".to_owned()),
    }
}

/// A package and its folder.
pub(crate) fn package(text: &str) -> Result<String, String> {
    match text.split_once('=') {
        Some((name, dir)) if !name.is_empty() && !dir.is_empty() => Ok(text.to_owned()),
        _ => Err("a name and a folder, as in my_robot_description=/path/to/it".to_owned()),
    }
}

/// A duration.
pub(crate) fn positive_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1.0e6 => Ok(value),
        _ => Err("seconds, more than 0 and at most 1000000".to_owned()),
    }
}

/// A moment of simulated time.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=1.0e6).contains(&value) => Ok(value),
        _ => Err("seconds, from 0 to 1000000".to_owned()),
    }
}

/// Faults a minute.
pub(crate) fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 600.0 => Ok(value),
        _ => Err("faults a minute, more than 0 and at most 600".to_owned()),
    }
}

/// A duration of up to a day.
pub(crate) fn minutes(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1440.0 => Ok(value),
        _ => Err("minutes, more than 0 and at most 1440".to_owned()),
    }
}

/// How far back, as in `60s`, `2m` or `2min`.
pub(crate) fn seconds_back(text: &str) -> Result<f64, String> {
    let minutes = text.strip_suffix("min").or_else(|| text.strip_suffix('m'));
    let (number, factor) = if let Some(minutes) = minutes {
        (minutes, 60.0)
    } else {
        (text.strip_suffix('s').unwrap_or(text), 1.0)
    };
    positive_seconds(number)
        .map(|value| value * factor)
        .map_err(|_| "a time as in 60s or 2m".to_owned())
}

/// `A..B`, both ends included.
pub(crate) fn seed_range(text: &str) -> Result<(u64, u64), String> {
    let wanted = || "A..B with A up to B, for example 1..50, or how many from 0 on".to_owned();
    if let Ok(count) = text.parse::<u64>() {
        return count
            .checked_sub(1)
            .map(|last| (0, last))
            .ok_or_else(wanted);
    }
    let (first, end) = text.split_once("..").ok_or_else(wanted)?;
    let parse = |part: &str| part.parse::<u64>().map_err(|_| wanted());
    let (first, end) = (parse(first)?, parse(end)?);
    if first <= end {
        Ok((first, end))
    } else {
        Err(wanted())
    }
}

/// A share from 0 to 1, but not 0.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok();
    let share = share.filter(|share| *share > 0.0 && *share <= 1.0);
    share.ok_or_else(|| "above 0, up to 1".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::{CommandFactory, Parser};

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_target_takes_negative_numbers_and_refuses_nan() {
        let cli = Cli::try_parse_from(["robocell", "target", "0.4", "-0.1", "0.3"]).unwrap();
        let Command::Target(target) = cli.command else {
            panic!("target")
        };
        assert_eq!(target.values, [0.4, -0.1, 0.3]);
        assert!(Cli::try_parse_from(["robocell", "target", "nan", "0", "0"]).is_err());
    }

    #[test]
    fn a_cell_name_cannot_leave_the_run_directory() {
        for bad in ["", "..", "a/b", "-x", "a b", "ä"] {
            assert!(cell_name(bad).is_err(), "{bad}");
        }
        assert!(cell_name("left_arm-2").is_ok());
    }

    #[test]
    fn a_negative_number_is_a_value_out_of_range_and_no_flag() {
        for line in [
            "run franka-stack --seed -1",
            "run franka-stack --speed -1",
            "run ur10-palletize --bins -1",
            "load reach --seed -1",
            "step -5",
            "drop-parts -3",
            "gripper open --arm -1",
            "eval reach --seeds -1..3",
            "eval reach --seeds 1..3 --jobs -1",
            "record last -3s",
            "plot a.mcap --from -1",
        ] {
            let words = std::iter::once("robocell").chain(line.split(' '));
            let error = Cli::try_parse_from(words).unwrap_err();
            assert_eq!(
                error.kind(),
                clap::error::ErrorKind::ValueValidation,
                "{line}: {error}"
            );
        }
    }

    #[test]
    fn a_time_back_has_a_unit_or_means_seconds() {
        assert_eq!(seconds_back("60s"), Ok(60.0));
        assert_eq!(seconds_back("2min"), Ok(120.0));
        assert_eq!(seconds_back("5m"), Ok(300.0));
        assert_eq!(seconds_back("0.5"), Ok(0.5));
        for bad in ["", "s", "-3s", "1h", "nan"] {
            assert!(seconds_back(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn seeds_are_a_range_with_both_ends() {
        assert_eq!(seed_range("3..10"), Ok((3, 10)));
        assert_eq!(seed_range("5..5"), Ok((5, 5)));
        assert_eq!(seed_range("5"), Ok((0, 4)));
        assert_eq!(share("0.9"), Ok(0.9));
        for bad in ["0", "1.1", "-1", "nan"] {
            assert!(share(bad).is_err(), "{bad}");
        }
        for bad in ["0", "9..2", "..", "a..b"] {
            assert!(seed_range(bad).is_err(), "{bad}");
        }
    }
}
