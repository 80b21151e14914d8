//! The last cycles of a loop, in memory that outlives its process.
//!
//! A ring in a mapped file. Adding a cycle is a few stores: no allocation, no system
//! call, no lock. A successor appends to the ring of its predecessor, so both are there.

use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::overrun::Cause;
use crate::shared::SharedWords;

/// Marks a file of this layout (`RCBBOX01`).
const MAGIC: u64 = u64::from_le_bytes(*b"RCBBOX01");
/// Words before the first cycle: magic, number of cycles added.
const HEADER: usize = 2;
/// Words of a cycle: tick, start, lateness and duration, two of values, and last its
/// number, generation and cause.
const CYCLE: usize = 6;
/// Numbers a loop may add to each cycle.
pub const VALUES: usize = 4;
/// Cycles that are kept: four seconds of a loop of 1 kHz.
pub const KEPT: usize = 4096;
/// Bytes of the file.
pub const BYTES: usize = 8 * (HEADER + KEPT * CYCLE);

/// One cycle of a loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoxedCycle {
    /// Start number of the process; the lowest 16 bits.
    pub generation: u16,
    /// Tick it worked on.
    pub tick: u64,
    /// Start of the cycle, monotonic clock (ns).
    pub began_ns: u64,
    /// Delay of the start after its deadline (ns).
    pub late_ns: u32,
    /// Duration (ns).
    pub body_ns: u32,
    /// Cause of an overrun, if it was one.
    pub cause: Option<Cause>,
    /// Values added by the loop.
    pub values: [f32; VALUES],
}

/// The ring of one loop.
#[derive(Debug)]
pub struct BlackBox {
    memory: SharedWords,
    count: u64,
}

impl BlackBox {
    /// Opens or creates the ring at `path` (on tmpfs).
    ///
    /// # Errors
    /// Of the file system, also when it has no room.
    pub fn open(path: &Path) -> io::Result<Self> {
        let memory = SharedWords::open(path, HEADER + KEPT * CYCLE)?;
        let words = memory.words();
        // A file of another layout is emptied: its words mean something else.
        if words[0].load(Ordering::Acquire) != MAGIC {
            words[1].store(0, Ordering::Relaxed);
            words[0].store(MAGIC, Ordering::Release);
        }
        // Each page is touched once now, so that no cycle meets a page fault here.
        for word in words.iter().step_by(4096 / 8) {
            word.fetch_add(0, Ordering::Relaxed);
        }
        let count = words[1].load(Ordering::Acquire);
        Ok(Self { memory, count })
    }

    /// Adds a cycle; the oldest is overwritten.
    pub fn add(&mut self, cycle: &BoxedCycle) {
        let slot = slot(&self.memory, self.count);
        // Not valid while it is written: no cycle has this number.
        slot[5].store(u64::MAX, Ordering::Relaxed);
        core::sync::atomic::fence(Ordering::Release);
        slot[0].store(cycle.tick, Ordering::Relaxed);
        slot[1].store(cycle.began_ns, Ordering::Relaxed);
        slot[2].store(pair(cycle.late_ns, cycle.body_ns), Ordering::Relaxed);
        let [a, b, c, d] = cycle.values.map(f32::to_bits);
        slot[3].store(pair(a, b), Ordering::Relaxed);
        slot[4].store(pair(c, d), Ordering::Relaxed);
        let cause = cycle.cause.map_or(0, |cause| 1 + cause as u32);
        let kind = u32::from(cycle.generation) << 16 | cause;
        slot[5].store(pair(low(self.count), kind), Ordering::Release);
        // After the cycle: a reader must not look for a cycle that is not complete.
        self.count += 1;
        self.memory.words()[1].store(self.count, Ordering::Release);
    }

    /// The content of the ring at `path`, the oldest first; also while its process runs or
    /// after it was killed. A cycle that was being written is left out.
    ///
    /// # Errors
    /// Of the file system, and for a file of another layout.
    pub fn read(path: &Path) -> io::Result<Vec<BoxedCycle>> {
        // Checked first, as opening would extend a short file with zeros.
        if std::fs::metadata(path)?.len() < BYTES as u64 {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let memory = SharedWords::open(path, HEADER + KEPT * CYCLE)?;
        let words = memory.words();
        if words[0].load(Ordering::Acquire) != MAGIC {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let count = words[1].load(Ordering::Acquire);
        let first = count.saturating_sub(KEPT as u64);
        Ok((first..count)
            .filter_map(|number| read_cycle(&memory, number))
            .collect())
    }
}

fn read_cycle(memory: &SharedWords, number: u64) -> Option<BoxedCycle> {
    let slot = slot(memory, number);
    let mark = slot[5].load(Ordering::Acquire);
    let words = [0, 1, 2, 3, 4].map(|index: usize| slot[index].load(Ordering::Relaxed));
    core::sync::atomic::fence(Ordering::Acquire);
    let (of, kind) = halves(mark);
    // Another number: the writer has come round, or was killed while it wrote this cycle.
    if of != low(number) || slot[5].load(Ordering::Relaxed) != mark {
        return None;
    }
    let [tick, began_ns, times, ab, cd] = words;
    let (late_ns, body_ns) = halves(times);
    let ((a, b), (c, d)) = (halves(ab), halves(cd));
    let [generation, cause] = [kind >> 16, kind & 0xffff].map(|half| u16::try_from(half).ok());
    Some(BoxedCycle {
        generation: generation?,
        tick,
        began_ns,
        late_ns,
        body_ns,
        cause: Cause::ALL.get(usize::from(cause?).wrapping_sub(1)).copied(),
        values: [a, b, c, d].map(f32::from_bits),
    })
}

fn slot(memory: &SharedWords, number: u64) -> &[AtomicU64] {
    let index = usize::try_from(number % KEPT as u64).unwrap_or(0);
    &memory.words()[HEADER + index * CYCLE..][..CYCLE]
}

fn pair(low: u32, high: u32) -> u64 {
    u64::from(low) | u64::from(high) << 32
}

fn halves(word: u64) -> (u32, u32) {
    (low(word), low(word >> 32))
}

fn low(word: u64) -> u32 {
    u32::try_from(word & 0xffff_ffff).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycle(tick: u64) -> BoxedCycle {
        BoxedCycle {
            generation: 2,
            tick,
            began_ns: 1_000_000 * tick,
            late_ns: 5,
            body_ns: 7,
            cause: tick.is_multiple_of(3).then_some(Cause::Preemption),
            values: [0.5, -1.0, tick as f32, f32::MAX],
        }
    }

    #[test]
    fn the_last_cycles_outlive_the_process_and_the_successor_appends() {
        let dir = tempfile();
        let path = dir.join("ring");
        let mut first = BlackBox::open(&path).unwrap();
        for tick in 0..10 {
            first.add(&cycle(tick));
        }
        drop(first);
        let mut second = BlackBox::open(&path).unwrap();
        second.add(&BoxedCycle {
            generation: 3,
            ..cycle(10)
        });
        let all = BlackBox::read(&path).unwrap();
        assert_eq!(all.len(), 11);
        assert_eq!(all[4], cycle(4));
        assert_eq!(all[9].cause, Some(Cause::Preemption));
        assert_eq!((all[10].generation, all[10].tick), (3, 10));
        for tick in 11..20_000 {
            second.add(&cycle(tick));
        }
        let all = BlackBox::read(&path).unwrap();
        assert_eq!(all.len(), KEPT);
        assert_eq!(all.last().unwrap().tick, 19_999);
        assert_eq!(all[0].tick, 20_000 - KEPT as u64);
        std::fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn a_file_of_another_kind_and_a_cycle_half_written_are_not_read() {
        let dir = tempfile();
        let path = dir.join("ring");
        std::fs::write(&path, vec![7; BYTES]).unwrap();
        BlackBox::read(&path).unwrap_err();
        std::fs::write(&path, b"short").unwrap();
        BlackBox::read(&path).unwrap_err();
        BlackBox::read(&dir.join("none")).unwrap_err();
        std::fs::remove_file(&path).unwrap();
        let mut ring = BlackBox::open(&path).unwrap();
        ring.add(&cycle(1));
        ring.add(&cycle(2));
        slot(&ring.memory, 0)[5].store(u64::MAX, Ordering::Relaxed);
        let all = BlackBox::read(&path).unwrap();
        assert_eq!(all, [cycle(2)]);
        std::fs::remove_dir_all(dir).unwrap();
    }

    fn tempfile() -> std::path::PathBuf {
        use std::sync::atomic::AtomicU32;
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("robocell-box-{}-{number}", std::process::id());
        let dir = Path::new("/dev/shm").join(name);
        std::fs::create_dir(&dir).unwrap();
        dir
    }
}
