//! Warnings that many joints of a file cause: one line for each kind.

/// Number of joints that a warning names.
const NAMED: usize = 6;

/// The notices, in the order of the file.
#[derive(Default)]
pub(super) struct Notices {
    kinds: Vec<Notice>,
}

struct Notice {
    line: usize,
    what: String,
    joints: Vec<String>,
    count: usize,
}

impl Notices {
    /// Adds `joint` to the notice `what`.
    pub(super) fn add(&mut self, line: usize, joint: String, what: String) {
        let known = self.kinds.iter().position(|notice| notice.what == what);
        let place = known.unwrap_or_else(|| {
            self.kinds.push(Notice {
                line,
                what,
                joints: Vec::new(),
                count: 0,
            });
            self.kinds.len() - 1
        });
        let notice = &mut self.kinds[place];
        notice.count += 1;
        if notice.joints.len() < NAMED {
            notice.joints.push(joint);
        }
    }

    /// The warnings, with file and the line of the first joint.
    pub(super) fn lines(self, file: &str) -> impl Iterator<Item = String> {
        self.kinds.into_iter().map(move |notice| {
            let word = if notice.count == 1 { "joint" } else { "joints" };
            let more = match notice.count - notice.joints.len() {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let names = notice.joints.join(", ");
            format!(
                "{file}:{}: {word} {names}{more}: {}",
                notice.line, notice.what
            )
        })
    }
}
