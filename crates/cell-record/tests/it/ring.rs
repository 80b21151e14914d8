//! The flight recorder's ring: bounded, whole, and patient with its disk.

use crate::support;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cell_record::{Channel, Disk, Flight, Recording, Storage};

fn ring(storage: Box<dyn Storage>, dir: &Path, limit_bytes: u64) -> Flight {
    Flight::new(storage, dir, 77, limit_bytes, support::preamble())
}

fn say(flight: &mut Flight, ticks: std::ops::Range<u64>) {
    let mut buffer = Vec::new();
    for tick in ticks {
        let now_ns = tick * 1_000_000;
        support::tick(tick, |message| {
            flight.append_packed(&message.packed(&mut buffer), now_ns);
        });
        flight.flush_if_due(now_ns);
    }
}

fn bytes_in(dir: &Path) -> u64 {
    Disk.list(dir).iter().map(|(_, bytes)| bytes).sum()
}

#[test]
fn the_oldest_goes_and_the_rest_is_readable_without_an_end() {
    let dir = tempfile::tempdir().unwrap();
    let limit = 1 << 20;
    let mut flight = ring(Box::new(Disk), dir.path(), limit);
    say(&mut flight, 0..40_000);
    assert!(bytes_in(dir.path()) <= limit, "{}", bytes_in(dir.path()));
    let (from_s, to_s) = flight.span_s();
    assert!(from_s > 1.0 && to_s == 39.999, "{from_s} {to_s}");
    // As after kill -9: what was flushed is there.
    flight.flush(0);
    let mut read = Recording::open(dir.path()).unwrap();
    assert_eq!(read.at(39.999).unwrap().world.header.tick, 39_999);
    assert!((read.span_s().0 - from_s).abs() < 0.5);
    drop(flight);
    // The next run goes on, and is the one that is shown.
    let mut next = Flight::new(Box::new(Disk), dir.path(), 78, limit, support::preamble());
    say(&mut next, 0..500);
    next.close();
    assert_eq!(Recording::open(dir.path()).unwrap().span_s(), (0.0, 0.499));
    assert!(bytes_in(dir.path()) <= limit);
}

/// A disk somebody else fills.
struct Shared {
    full: Arc<AtomicBool>,
}

struct File {
    file: Box<dyn Write + Send>,
    full: Arc<AtomicBool>,
}

impl Write for File {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.full.load(Ordering::Relaxed) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Storage for Shared {
    fn create(&mut self, path: &Path) -> io::Result<Box<dyn Write + Send>> {
        let full = self.full.clone();
        Disk.create(path)
            .map(|file| Box::new(File { file, full }) as _)
    }

    fn remove(&mut self, path: &Path) -> io::Result<()> {
        Disk.remove(path)
    }

    fn list(&mut self, dir: &Path) -> Vec<(PathBuf, u64)> {
        Disk.list(dir)
    }
}

#[test]
fn a_disk_that_fills_costs_a_counted_gap_and_it_goes_on_by_itself() {
    let dir = tempfile::tempdir().unwrap();
    let full = Arc::new(AtomicBool::new(false));
    let storage = Shared { full: full.clone() };
    let mut flight = ring(Box::new(storage), dir.path(), 8 << 20);
    say(&mut flight, 0..3000);
    full.store(true, Ordering::Relaxed);
    say(&mut flight, 3000..8000);
    assert!(flight.trouble().is_some() && flight.lost() > 1000);
    full.store(false, Ordering::Relaxed);
    say(&mut flight, 8000..12_000);
    assert_eq!(flight.trouble(), None);
    flight.close();
    let mut read = Recording::open(dir.path()).unwrap();
    assert!(read.at(2.0).unwrap().world.header.tick >= 1999);
    assert_eq!(read.at(11.0).unwrap().world.header.tick, 11_000);
    let gaps = read.messages().map(Result::unwrap);
    let gaps: Vec<_> = gaps.filter(|e| e.channel == Channel::Gaps).collect();
    assert!(!gaps.is_empty());
    assert!(
        gaps.iter()
            .all(|gap| String::from_utf8_lossy(&gap.bytes).contains("disk"))
    );
}

#[test]
fn a_directory_that_vanishes_is_made_again() {
    let dir = tempfile::tempdir().unwrap();
    let inner = dir.path().join("flight");
    let mut flight = ring(Box::new(Disk), &inner, 8 << 20);
    say(&mut flight, 0..2000);
    std::fs::remove_dir_all(&inner).unwrap();
    say(&mut flight, 2000..25_000);
    flight.close();
    let mut read = Recording::open(&inner).unwrap();
    assert_eq!(read.at(24.0).unwrap().world.header.tick, 24_000);
}
