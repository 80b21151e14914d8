//! What lines of a script, and `robocell chaos`, do to the machine on which a cell runs.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use cell_model::cells::script::ScriptAction;

use super::script::nanos;

/// Busy loops beside the cell: more than a small machine has cores.
const BUSY_LOOPS: usize = 8;
/// A file system with more room than this is not filled: its memory is the machine's.
const MOST_FILLED: u64 = 512 << 20;
/// Bytes that are overwritten in a file.
const FLIPPED: u64 = 64;

/// Disturbances that last. They end when the value is dropped.
#[derive(Debug, Default)]
pub struct Disturbances {
    /// Until when (ns).
    busy: Vec<(u64, Child)>,
    filled: Vec<(u64, PathBuf)>,
}

impl Disturbances {
    /// Does what `action` says to the run in `run_dir`; an action about something else does
    /// nothing.
    ///
    /// # Errors
    /// In words, where it cannot be done.
    pub fn begin(
        &mut self,
        run_dir: &Path,
        now_ns: u64,
        action: &ScriptAction,
    ) -> Result<(), String> {
        match action {
            ScriptAction::Starve { for_s } => {
                let until_ns = now_ns + nanos(*for_s);
                for _ in 0..BUSY_LOOPS {
                    let child = busy_loop(*for_s).map_err(|error| error.to_string())?;
                    self.busy.push((until_ns, child));
                }
                Ok(())
            }
            ScriptAction::Fill { for_s } => {
                let path = run_dir.join("disturbance.fill");
                fill(&path)?;
                self.filled.push((now_ns + nanos(*for_s), path));
                Ok(())
            }
            ScriptAction::Corrupt { file } => {
                let path = run_dir.join(file);
                corrupt(&path).map_err(|error| format!("{}: {error}", path.display()))
            }
            _ => Ok(()),
        }
    }

    /// Ends the disturbances whose time has passed at `now_ns`.
    pub fn turn(&mut self, now_ns: u64) {
        for (_, mut child) in self
            .busy
            .extract_if(.., |(until_ns, _)| now_ns >= *until_ns)
        {
            end(&mut child);
        }
        for (_, path) in self
            .filled
            .extract_if(.., |(until_ns, _)| now_ns >= *until_ns)
        {
            std::fs::remove_file(path).ok();
        }
    }
}

impl Drop for Disturbances {
    fn drop(&mut self) {
        self.turn(u64::MAX);
    }
}

/// The kernel ends it after its time, if the launcher does not.
fn busy_loop(for_s: f64) -> io::Result<Child> {
    let limit_s = for_s.ceil() + 1.0;
    Command::new("sh")
        .args(["-c", &format!("ulimit -t {limit_s}; while :; do :; done")])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
}

fn end(child: &mut Child) {
    child.kill().ok();
    child.wait().ok();
}

fn fill(path: &Path) -> Result<(), String> {
    let say = |error: io::Error| format!("{}: {error}", path.display());
    let dir = path.parent().unwrap_or(path);
    let free = cell_rt::memory::free_bytes(dir).map_err(say)?;
    if free > MOST_FILLED {
        let (free, most) = (free >> 20, MOST_FILLED >> 20);
        return Err(format!(
            "{} has {free} MiB free; more than {most} MiB are not filled",
            dir.display()
        ));
    }
    let mut file = File::create(path).map_err(say)?;
    let zeros = vec![0; 1 << 16];
    // Until the write fails for lack of room, which is the purpose.
    while file.write_all(&zeros).is_ok() {}
    Ok(())
}

/// Inverts bytes everywhere in the file, so that every copy of a record is damaged.
fn corrupt(path: &Path) -> io::Result<()> {
    let mut file = File::options().read(true).write(true).open(path)?;
    let length = file.metadata()?.len();
    for place in 0..FLIPPED {
        let at = SeekFrom::Start((2 * place + 1) * length / (2 * FLIPPED));
        let mut byte = [0];
        file.seek(at)?;
        file.read_exact(&mut byte)?;
        file.seek(at)?;
        file.write_all(&[!byte[0]])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_every_part_of_a_file_are_overwritten() {
        let dir = std::env::temp_dir().join(format!("robocell-bytes-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("task.slots");
        std::fs::write(&path, [7; 6400]).unwrap();
        let action = ScriptAction::Corrupt {
            file: "task.slots".to_owned(),
        };
        let mut disturbances = Disturbances::default();
        disturbances.begin(&dir, 0, &action).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let mut parts = bytes.chunks(100);
        assert!(parts.all(|part| part.contains(&!7)), "each part");
        std::fs::remove_dir_all(&dir).unwrap();
        let refusal = disturbances.begin(&dir, 0, &action).unwrap_err();
        assert!(refusal.contains("task.slots"), "{refusal}");
    }
}
