//! What is wrong with a file, and where: all of it at once.

/// Problems of one file that are reported.
const MAX_REPORTED: usize = 100;

/// Location in a text. Line and column count from 1; 0 is "written in Rust".
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Location {
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

/// One thing that is wrong, with what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Where.
    pub place: Location,
    /// What, what was expected, and what was probably meant.
    pub message: String,
}

/// Everything that is wrong with a definition, in the order of the text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Problems {
    /// Name of the file, or of the machine if it was written in Rust.
    pub file: String,
    /// At least one.
    pub list: Vec<Problem>,
}

impl Problems {
    pub(crate) fn new(file: &str, mut list: Vec<Problem>) -> Self {
        list.sort_by_key(|problem| problem.place);
        list.dedup();
        Self {
            file: file.to_owned(),
            list,
        }
    }
}

impl Problems {
    /// Those of reading and those of compiling a file. What has no place of its
    /// own is about the whole file.
    pub(crate) fn join<T>(
        file: &str,
        reading: Vec<Problem>,
        compiled: Result<T, Self>,
    ) -> Result<T, Self> {
        let compiling = match compiled {
            Ok(table) if reading.is_empty() => return Ok(table),
            Ok(_) => Vec::new(),
            Err(wrong) => wrong.list,
        };
        let mut all = [reading, compiling].concat();
        for problem in &mut all {
            if problem.place.line == 0 {
                problem.place = Location { line: 1, column: 1 };
            }
        }
        Err(Self::new(file, all))
    }
}

impl std::fmt::Display for Problems {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, problem) in self.list.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            let Location { line, column } = problem.place;
            match line {
                0 => write!(f, "{}: {}", self.file, problem.message)?,
                _ => write!(f, "{}:{line}:{column}: {}", self.file, problem.message)?,
            }
        }
        Ok(())
    }
}

/// Collects problems while a definition is read or compiled.
#[derive(Debug, Default)]
pub(crate) struct Collector(pub(crate) Vec<Problem>);

impl Collector {
    /// Notes a problem; of very many only the first are kept, and one that says so.
    pub(crate) fn add(&mut self, place: Location, message: impl Into<String>) {
        self.add_with(place, || message.into());
    }

    /// As [`Self::add`]; for messages that take long to compose, as a search for the name
    /// that was meant does: a file may have a hundred thousand mistakes.
    pub(crate) fn add_with(&mut self, place: Location, message: impl FnOnce() -> String) {
        let message = match self.0.len() {
            count if count < MAX_REPORTED => message(),
            MAX_REPORTED => format!("more than {MAX_REPORTED} mistakes; only the first are shown"),
            _ => return,
        };
        self.0.push(Problem { place, message });
    }

    /// `value`, unless there were problems.
    pub(crate) fn finish<T>(self, file: &str, value: T) -> Result<T, Problems> {
        if self.0.is_empty() {
            return Ok(value);
        }
        Err(Problems::new(file, self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mistakes_that_are_not_shown_are_reported() {
        let mut collector = Collector::default();
        for number in 0..MAX_REPORTED + 10 {
            collector.add(Location { line: 1, column: 1 }, format!("mistake {number}"));
        }
        let problems = collector.finish("a.toml", ()).unwrap_err();
        assert_eq!(problems.to_string().lines().count(), MAX_REPORTED + 1);
        assert!(problems.to_string().contains("more than 100 mistakes"));
    }
}
