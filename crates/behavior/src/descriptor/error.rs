//! What is wrong with a file, and where.

/// Mistakes of one file that are reported; more are only counted.
const MAX_REPORTED: usize = 100;

/// Something wrong at a place of a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Located {
    /// Name of the file as it was given.
    pub file: String,
    /// Line, the first is 1.
    pub line: u32,
    /// Column in characters, the first is 1.
    pub column: u32,
    /// What is wrong, what was expected, and what to do.
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

/// Everything that is wrong with a file and those it includes, in the order of
/// the text. One line each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Errors {
    /// The mistakes, of very many the first hundred.
    pub list: Vec<Located>,
    /// How many more there were.
    pub omitted: usize,
}

impl Errors {
    /// Notes a mistake.
    pub fn push(&mut self, file: &str, place: super::json::Location, message: impl Into<String>) {
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

    /// Adds those of `other`.
    pub fn append(&mut self, other: Self) {
        for located in other.list {
            let place = super::json::Location {
                line: located.line,
                column: located.column,
            };
            self.push(&located.file, place, located.message);
        }
        self.omitted += other.omitted;
    }

    /// Whether so much is wrong that looking further is of no use.
    pub fn is_full(&self) -> bool {
        self.list.len() >= MAX_REPORTED
    }

    /// Whether nothing is wrong.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// `value` where nothing is wrong, otherwise all mistakes in the order of
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

    /// In the order of the text.
    pub fn sorted(mut self) -> Self {
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
