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
    // As after kill -9: flushed messages are there.
    flight.flush(0);
    let mut read = Recording::open(dir.path()).unwrap();
    assert_eq!(read.at(39.999).unwrap().world.header.tick, 39_999);
    assert!((read.span_s().0 - from_s).abs() < 0.5);
    drop(flight);
    // The next run continues the numbers, and is the one shown.
    let mut next = Flight::new(Box::new(Disk), dir.path(), 78, limit, support::preamble());
    say(&mut next, 0..500);
    next.close();
    assert_eq!(Recording::open(dir.path()).unwrap().span_s(), (0.0, 0.499));
    assert!(bytes_in(dir.path()) <= limit);
}

#[test]
fn a_reader_keeps_the_past_that_the_ring_has_removed() {
    let dir = tempfile::tempdir().unwrap();
    let mut flight = ring(Box::new(Disk), dir.path(), 1 << 20);
    say(&mut flight, 0..5_000);
    flight.flush(0);
    let mut read = Recording::open(dir.path()).unwrap();
    say(&mut flight, 5_000..40_000);
    assert!(flight.span_s().0 > 4.0, "{}", flight.span_s().0);
    assert_eq!(read.at(2.5).unwrap().world.header.tick, 2_500);
}

#[test]
fn the_decision_before_a_long_pause_is_found() {
    let dir = tempfile::tempdir().unwrap();
    let mut flight = ring(Box::new(Disk), dir.path(), 64 << 20);
    say(&mut flight, 0..2_000);
    // A paused cell publishes its state repeatedly; the task decides nothing.
    let mut buffer = Vec::new();
    for second in 3..63_u64 {
        support::tick(1_999, |message| {
            flight.append_packed(&message.packed(&mut buffer), second * 1_000_000_000);
        });
        flight.flush(second * 1_000_000_000);
    }
    let frame = Recording::open(dir.path()).unwrap().at(1.999).unwrap();
    assert_eq!(frame.world.header.tick, 1_999);
    assert_eq!(frame.decision.header.tick, 1_990);
}

#[test]
fn time_that_was_set_back_is_an_epoch_of_its_own() {
    let dir = tempfile::tempdir().unwrap();
    let mut flight = ring(Box::new(Disk), dir.path(), 64 << 20);
    flight.begin_epoch(1);
    say(&mut flight, 0..60_400);
    // Physics was killed and resumed from its snapshot.
    flight.begin_epoch(2);
    say(&mut flight, 60_000..61_000);
    assert_eq!(flight.span_s(), (0.0, 60.999));
    // Here it had no snapshot.
    flight.begin_epoch(3);
    say(&mut flight, 0..7100);
    assert_eq!(flight.span_s(), (0.0, 7.099));
    let epochs = flight.epochs();
    let spans: Vec<_> = epochs.iter().map(|e| (e.epoch, e.from_s, e.to_s)).collect();
    let known = [(1, 0.0, 60.399), (2, 60.0, 60.999), (3, 0.0, 7.099)];
    assert_eq!(spans, known);
    flight.close();
    // A recorder that was restarted knows them as well.
    let mut again = ring(Box::new(Disk), dir.path(), 64 << 20);
    assert_eq!(again.epochs(), epochs);
    // Messages before a state are of the newest epoch.
    say(&mut again, 7100..7101);
    again.close();
    assert_eq!((again.epochs().len(), again.span_s()), (3, (0.0, 7.1)));
    let mut read = Recording::open(dir.path()).unwrap();
    assert_eq!(read.span_s(), (0.0, 7.1));
    assert_eq!(read.at(60.2).unwrap().world.header.tick, 7100);
    assert_eq!(
        read.log_until(60.2, 1).unwrap()[0].text.as_str(),
        "line 7100"
    );
    let lines = |read: &mut Recording, from_s, to_s| read.trace(from_s, to_s).unwrap().len();
    assert_eq!(lines(&mut read, 1.0, 2.0), 10);
    read.show_epoch(Some(2));
    assert_eq!(read.span_s(), (0.0, 60.999));
    assert_eq!(read.at(60.2).unwrap().world.header.tick, 60_200);
    assert_eq!(lines(&mut read, 59.5, 60.5), 10);
    // The last minute of a file is the last of the newest epoch.
    read.show_epoch(None);
    let file = dir.path().join("last.mcap");
    read.copy_span(0.0, 7.0, &file).unwrap();
    let copy = Recording::open(&file).unwrap();
    assert_eq!((copy.span_s(), copy.epochs().len()), ((0.0, 7.0), 1));
    read.show_epoch(Some(2));
    let file = dir.path().join("both.mcap");
    read.copy_span(59.0, 60.5, &file).unwrap();
    let copy = Recording::open(&file).unwrap();
    let epochs: Vec<_> = copy.epochs().iter().map(|e| e.epoch).collect();
    assert_eq!((copy.span_s().1, epochs), (60.5, vec![1, 2]));
}

/// A disk that another program fills up.
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
    let lost = flight.lost();
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
    let outside = tempfile::tempdir().unwrap();
    let copied = read.copy_span(0.0, 12.0, &outside.path().join("a.mcap"));
    assert_eq!(copied.unwrap().missing, lost);
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
