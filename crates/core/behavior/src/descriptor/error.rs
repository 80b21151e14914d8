//! Mistakes in a file, with their places.

/// Number of mistakes of one file that are reported; more are only counted.
// A reader corrects the first ones.
const MAX_REPORTED: usize = 100;

/// A mistake at a place of a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Located {
    /// Name of the file as it was given.
    pub file: String,
    /// Line, the first is 1.
    pub line: u32,
    /// Column in characters, the first is 1.
    pub column: u32,
    /// The mistake, the expected form, and the correction.
    pub message: String,
}

impl std::fmt::Display for Located {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            file,
            line,
            column,
            message,
        } = self;
        write!(f, "{file}:{line}:{column}: {message}")
    }
}

/// All mistakes in a file and those it includes, in the order of
/// the text. One line each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Errors {
    /// The mistakes, at most the first hundred.
    pub list: Vec<Located>,
    /// Number of further ones.
    pub omitted: usize,
}

impl Errors {
    /// Adds a mistake.
    pub fn push(&mut self, file: &str, place: crate::lines::Location, message: impl Into<String>) {
        if self.list.len() >= MAX_REPORTED {
            self.omitted += 1;
            return;
        }
        let located = Located {
            file: file.to_owned(),
            line: place.line,
            column: place.column,
            message: message.into(),
        };
        // A subtree is read once for each use; its mistakes are reported once.
        if !self.list.contains(&located) {
            self.list.push(located);
        }
    }

    /// Adds the mistakes of `other`.
    pub fn append(&mut self, other: Self) {
        for located in other.list {
            let place = crate::lines::Location {
                line: located.line,
                column: located.column,
            };
            self.push(&located.file, place, located.message);
        }
        self.omitted += other.omitted;
    }

    /// Whether there are so many mistakes that reading further is useless.
    pub fn is_full(&self) -> bool {
        self.list.len() >= MAX_REPORTED
    }

    /// Whether there are no mistakes.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Returns `value` if there are no mistakes, otherwise all mistakes in the order of
    /// the text.
    ///
    /// # Errors
    /// Itself.
    pub fn or<T>(self, value: T) -> Result<T, Self> {
        if self.is_empty() {
            return Ok(value);
        }
        Err(self.sorted())
    }

    /// The mistakes in the order of the text.
    pub fn sorted(mut self) -> Self {
        // Constants, keys and nodes are read in several passes over a file.
        self.list.sort();
        self
    }
}

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, located) in self.list.iter().enumerate() {
            if index > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{located}")?;
        }
        if self.omitted > 0 {
            write!(f, "\nand {} more", self.omitted)?;
        }
        Ok(())
    }
}

impl std::error::Error for Errors {}
