//! The mistakes of a file and their places, collected so that all are reported at once.

/// Number of mistakes of one file that are reported.
// A reader corrects the first ones; a generated file may have a hundred thousand.
const MAX_REPORTED: usize = 100;

/// Location in a text. Line and column count from 1; 0 means "written in Rust".
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Location {
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

/// A mistake, with its correction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Its place.
    pub place: Location,
    /// The mistake, the expected form, and the probable intention.
    pub message: String,
}

/// All mistakes of a definition, in the order of the text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Problems {
    /// Name of the file, or of the machine if it was written in Rust.
    pub file: String,
    /// At least one.
    pub list: Vec<Problem>,
}

impl Problems {
    pub(crate) fn new(file: &str, mut list: Vec<Problem>) -> Self {
        // Readers and compilers find mistakes in their own order; some find the same one.
        list.sort_by_key(|problem| problem.place);
        list.dedup();
        Self {
            file: file.to_owned(),
            list,
        }
    }
}

impl Problems {
    /// Joins the mistakes of reading and of compiling a file. A mistake without a place
    /// is about the whole file.
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
    /// Adds a mistake; only the first ones are kept, and one that says so.
    pub(crate) fn add(&mut self, place: Location, message: impl Into<String>) {
        self.add_with(place, || message.into());
    }

    /// As [`Self::add`], for messages that are expensive to compose, such as a search for the
    /// intended name: a file may have a hundred thousand mistakes.
    pub(crate) fn add_with(&mut self, place: Location, message: impl FnOnce() -> String) {
        let message = match self.0.len() {
            count if count < MAX_REPORTED => message(),
            MAX_REPORTED => format!("more than {MAX_REPORTED} mistakes; only the first are shown"),
            _ => return,
        };
        self.0.push(Problem { place, message });
    }

    /// Returns `value`, or the mistakes if there are any.
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
