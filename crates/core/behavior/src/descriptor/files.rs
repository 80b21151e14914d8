//! A file with all included files.

use super::Source;
use super::advice;
use super::error::Errors;
use super::json::{self, Entry, Location, MAX_BYTES, Value};
use super::limits::MAX_FILES;

/// The version of the format that this crate reads and writes.
pub const FORMAT: &str = "behavior-tree/1";

/// A file after its syntax was parsed.
pub(super) struct File {
    pub name: String,
    pub root: Value,
}

/// The file and all included files, itself first.
pub(super) fn collect(source: &Source<'_>) -> Result<Vec<File>, Errors> {
    let root = json::parse(source.file, source.text)?;
    let mut reader = Reader {
        source,
        files: Vec::new(),
        bytes: source.text.len(),
        errors: Errors::default(),
    };
    reader.add(source.file, root, &mut Vec::new());
    // Included files are complete before those that include them; reversed, the file is first.
    reader.files.reverse();
    reader.errors.or(reader.files)
}

struct Reader<'a> {
    source: &'a Source<'a>,
    files: Vec<File>,
    bytes: usize,
    errors: Errors,
}

impl Reader<'_> {
    /// The recursion is limited by [`MAX_FILES`].
    fn add(&mut self, name: &str, root: Value, open: &mut Vec<String>) {
        open.push(name.to_owned());
        self.format(name, &root);
        if let Some(includes) = root.get("includes") {
            if let Some(list) = includes.as_list() {
                for item in list {
                    // Each name opens a file: after many mistakes no further ones are read.
                    if self.errors.is_full() {
                        break;
                    }
                    self.include(name, item, open);
                }
            } else {
                let found = includes.describe();
                let message = format!("a list of file names is needed here, this is {found}");
                self.errors.push(name, includes.place, message);
            }
        }
        open.pop();
        self.files.push(File {
            name: name.to_owned(),
            root,
        });
    }

    fn include(&mut self, file: &str, item: &Value, open: &mut Vec<String>) {
        let Some(wanted) = item.as_text() else {
            let message = format!("a file name is needed here, this is {}", item.describe());
            return self.errors.push(file, item.place, message);
        };
        // Compared with the files that are open, so that two files may both include a third
        // one.
        if open.iter().any(|name| name == wanted) {
            let circle = [open.join(" -> "), wanted.to_owned()].join(" -> ");
            let message = format!("files include each other: {circle}; break the circle");
            return self.errors.push(file, item.place, message);
        }
        // A file that several others include is read once.
        if self.files.iter().any(|f| f.name == wanted) {
            return;
        }
        // Open files count as well: they are added to the list when their includes are
        // complete.
        if self.files.len() + open.len() >= MAX_FILES {
            let message = format!("more than {MAX_FILES} files are drawn in; join some of them");
            return self.errors.push(file, item.place, message);
        }
        let text = match (self.source.include)(wanted) {
            Ok(text) => text,
            Err(reason) => {
                let message = format!(
                    "the file '{}' cannot be read: {reason}; its name counts from the folder of \
                     the first file",
                    json::shortened(wanted)
                );
                return self.errors.push(file, item.place, message);
            }
        };
        // The sum is limited, not each file: 32 files of the largest size would fill memory.
        self.bytes += text.len();
        if self.bytes > MAX_BYTES {
            let message = format!("all files together have more than {MAX_BYTES} bytes");
            return self.errors.push(file, item.place, message);
        }
        match json::parse(wanted, &text) {
            Ok(root) => self.add(wanted, root, open),
            Err(errors) => self.errors.append(errors),
        }
    }

    fn format(&mut self, file: &str, root: &Value) {
        let Some(entries) = root.as_object() else {
            let message = format!("an object is needed here, this is {}", root.describe());
            return self.errors.push(file, root.place, message);
        };
        match entries.iter().find(|e| e.key == "format") {
            None => {
                let message = format!("\"format\": \"{FORMAT}\" is missing");
                self.errors.push(file, root.place, message);
            }
            Some(Entry { value, .. }) if value.as_text() == Some(FORMAT) => {}
            Some(Entry { value, .. }) => {
                let found = value.describe();
                let message = format!("this version reads the format '{FORMAT}', this is {found}");
                self.errors.push(file, value.place, message);
            }
        }
    }
}

/// The entries of an object that may have `known` keys only; other keys are
/// reported.
pub(super) fn object<'v>(
    errors: &mut Errors,
    file: &str,
    value: &'v Value,
    what: &str,
    known: &[&str],
) -> Option<&'v [Entry]> {
    let Some(entries) = value.as_object() else {
        let message = format!("{what} is needed here, this is {}", value.describe());
        errors.push(file, value.place, message);
        return None;
    };
    for entry in entries {
        if known.contains(&entry.key.as_str()) {
            continue;
        }
        // A search for the intended name takes time; past the limit the message is not shown
        // anyway.
        let message = if errors.is_full() {
            String::new()
        } else {
            format!("in {what}: {}", advice::unknown("key", &entry.key, known))
        };
        errors.push(file, entry.place, message);
    }
    Some(entries)
}

/// The value of `key`.
pub(super) fn get<'v>(entries: &'v [Entry], key: &str) -> Option<&'v Value> {
    entries.iter().find(|e| e.key == key).map(|e| &e.value)
}

/// The place of `key`, or else of its object.
pub(super) fn place_of(entries: &[Entry], key: &str, otherwise: Location) -> Location {
    let entry = entries.iter().find(|e| e.key == key);
    entry.map_or(otherwise, |e| e.value.place)
}
