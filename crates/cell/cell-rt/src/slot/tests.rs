//! Records across kills, damage and growth.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use super::layout::{FILE_HEADER, MAX_CAPACITY, SLOT_HEADER};
use super::place::grown;
use super::{MemoryFile, SlotFile};
use crate::effects::Effects;

struct TestFile(PathBuf);

impl TestFile {
    fn new(name: &str) -> Self {
        let file = format!("cell-rt-slot-{name}-{}", std::process::id());
        Self(std::env::temp_dir().join(file))
    }
}

impl Drop for TestFile {
    fn drop(&mut self) {
        std::fs::remove_file(&self.0).unwrap();
    }
}

#[test]
fn the_newest_record_is_found_after_reopening() {
    let place = TestFile::new("newest");
    let mut file = SlotFile::open(&place.0, 100).unwrap();
    assert_eq!(file.newest(), None);
    for seq in 1..=7 {
        file.write(seq, format!("record {seq}").as_bytes()).unwrap();
    }
    drop(file);
    let mut file = SlotFile::open(&place.0, 100).unwrap();
    assert_eq!(file.newest(), Some((7, b"record 7".to_vec())));
    file.write(8, b"").unwrap();
    assert_eq!(
        SlotFile::open(&place.0, 100).unwrap().newest(),
        Some((8, Vec::new()))
    );
    file.clear();
    assert_eq!(file.newest(), None);
}

#[test]
fn of_many_slots_the_newest_records_are_there_in_their_order() {
    let place = TestFile::new("many");
    let mut file = SlotFile::with_slots(&place.0, 8, 5).unwrap();
    for seq in 1..=7 {
        file.write(seq, &seq.to_le_bytes()).unwrap();
    }
    drop(file);
    let file = SlotFile::with_slots(&place.0, 8, 5).unwrap();
    let seqs: Vec<_> = file.all().into_iter().map(|(seq, _)| seq).collect();
    assert_eq!(seqs, [7, 6, 5, 4, 3]);
    let file = SlotFile::with_slots(&place.0, 8, 4).unwrap();
    assert_eq!(file.all(), [], "another layout");
}

#[test]
fn a_record_that_was_being_written_gives_way_to_the_one_before() {
    let place = TestFile::new("torn");
    let mut file = SlotFile::open(&place.0, 64).unwrap();
    file.write(1, &[1; 64]).unwrap();
    file.write(2, &[2; 64]).unwrap();
    let slot = usize::from(file.newest_slot().unwrap().0 == 1);
    for word in 0..SLOT_HEADER + 8 {
        let victim = &file.slot(slot)[word];
        let whole = victim.load(Ordering::Relaxed);
        for bit in [0, 17, 63] {
            victim.store(whole ^ (1 << bit), Ordering::Relaxed);
            assert_eq!(
                file.newest(),
                Some((1, vec![1; 64])),
                "word {word} bit {bit}"
            );
        }
        victim.store(whole, Ordering::Relaxed);
    }
    assert_eq!(file.newest(), Some((2, vec![2; 64])));
}

#[test]
fn every_changed_bit_of_a_record_gives_way_to_the_one_before_and_is_reported() {
    // Up to records of some blocks of a checksum that is computed by blocks.
    for length in [1, 7, 8, 9, 64, 1_000] {
        let place = MemoryFile::default();
        let open = || SlotFile::in_memory(&place, 1_000, 2).unwrap();
        let record = |seed: u8| -> Vec<u8> { (seed..=u8::MAX).cycle().take(length).collect() };
        let mut file = open();
        file.write(1, &record(1)).unwrap();
        file.write(2, &record(2)).unwrap();
        let slot = file.newest_slot().unwrap().0;
        for bit in 0..64 * SLOT_HEADER + 8 * length {
            let victim = &file.slot(slot)[bit / 64];
            victim.fetch_xor(1 << (bit % 64), Ordering::Relaxed);
            let found = open();
            assert_eq!(found.newest(), Some((1, record(1))), "{length}: bit {bit}");
            assert!(found.was_damaged(), "{length}: bit {bit}");
            victim.fetch_xor(1 << (bit % 64), Ordering::Relaxed);
        }
        assert_eq!(open().newest(), Some((2, record(2))));
        assert!(!open().was_damaged());
    }
}

#[test]
fn every_changed_bit_of_the_head_that_costs_records_is_reported() {
    for bit in 0..64 * FILE_HEADER {
        let place = MemoryFile::default();
        // A length that has a shorter one with one bit less.
        let open = || SlotFile::in_memory(&place, 100, 2).unwrap();
        open().write(1, &[1; 64]).unwrap();
        place.words()[bit / 64].fetch_xor(1 << (bit % 64), Ordering::Relaxed);
        let found = open();
        let is_there = found.newest() == Some((1, vec![1; 64]));
        assert!(is_there != found.was_damaged(), "bit {bit}");
    }
}

#[test]
fn a_bit_that_is_flipped_by_a_draw_costs_a_record_and_is_reported() {
    for draw in 0..200 {
        let place = MemoryFile::default();
        let open = || SlotFile::in_memory(&place, 20, 3).unwrap();
        assert!(place.flip(draw).is_none(), "without a record");
        open().write(1, &[1; 20]).unwrap();
        assert!(!open().was_damaged());
        let flipped = place.flip(draw << 30 | draw).unwrap();
        assert!(place.still_has(&flipped));
        let mut file = open();
        assert!(file.was_damaged() && file.newest().is_none(), "{draw}");
        file.clear();
        file.write(1, &[1; 20]).unwrap();
    }
}

#[test]
fn damage_is_noticed_and_a_write_that_was_cut_off_is_none() {
    let place = TestFile::new("damage");
    let mut file = SlotFile::open(&place.0, 64).unwrap();
    file.write(1, &[1; 64]).unwrap();
    file.write(2, &[2; 64]).unwrap();
    let reopened = || SlotFile::open(&place.0, 64).unwrap();
    assert!(!reopened().was_damaged());
    file.slot(0)[2].store(u64::MAX, Ordering::Relaxed);
    assert!(!reopened().was_damaged());
    file.slot(1)[SLOT_HEADER].store(7, Ordering::Relaxed);
    assert!(reopened().was_damaged());
}

#[test]
fn a_record_longer_than_all_before_makes_the_slots_longer() {
    let place = TestFile::new("grown");
    let mut file = SlotFile::open(&place.0, 64).unwrap();
    file.write(1, &[1; 64]).unwrap();
    file.write(2, &[2; 64]).unwrap();
    // Left by a process that was killed while it did this.
    std::fs::write(grown(&place.0), b"a part").unwrap();
    file.write(3, &vec![3; 200_000]).unwrap();
    let found = [(3, vec![3; 200_000]), (2, vec![2; 64])];
    assert_eq!(file.all(), found);
    let mut file = SlotFile::open(&place.0, 64).unwrap();
    assert!(!file.was_damaged());
    assert_eq!(file.all(), found, "read by a process that expects less");
    assert!(file.write(4, &vec![0; MAX_CAPACITY + 1]).is_err());
    assert_eq!(file.all(), found);
}

#[test]
fn a_file_that_was_cut_off_is_damaged() {
    let place = TestFile::new("cut");
    let mut file = SlotFile::open(&place.0, 5_000).unwrap();
    file.write(1, &[1; 5_000]).unwrap();
    drop(file);
    let whole = std::fs::read(&place.0).unwrap();
    for length in [1, 23, 24, 3_000, whole.len() - 1] {
        std::fs::write(&place.0, &whole[..length]).unwrap();
        let file = SlotFile::open(&place.0, 5_000).unwrap();
        assert!(file.was_damaged() && file.newest().is_none(), "{length}");
    }
}

#[test]
fn foreign_content_is_not_taken_for_ours() {
    let place = TestFile::new("foreign");
    std::fs::write(&place.0, vec![0x5a; 5000]).unwrap();
    let file = SlotFile::open(&place.0, 64).unwrap();
    assert!(file.newest().is_none() && file.was_damaged());
    let mut file = SlotFile::open(&place.0, 64).unwrap();
    assert!(!file.was_damaged());
    file.write(1, b"ours").unwrap();
    assert!(SlotFile::open(&place.0, 0).is_err());
    assert!(SlotFile::open(&place.0, usize::MAX / 4).is_err());
}

#[test]
fn a_write_that_is_cut_after_any_store_leaves_the_previous_record() {
    let effects = Effects::default();
    let place = MemoryFile::new(&effects);
    let open = || SlotFile::in_memory(&place, 24, 2).unwrap();
    let write_part = |file: &mut SlotFile, seq, record: &[u8], stores| {
        effects.allow(stores);
        file.write(seq, record).unwrap();
        effects.allow(u64::MAX);
    };
    let (first, second) = ((1, vec![1; 24]), (2, vec![2; 20]));
    // The mark, number and length, three words of content, the checksum.
    let stores = 1 + 2 + 3 + 1;
    for cut in 0..stores {
        let mut file = open();
        file.clear();
        file.write(first.0, &first.1).unwrap();
        let next = file.next;
        write_part(&mut file, second.0, &second.1, cut);
        let mut successor = open();
        assert!(!successor.was_damaged(), "{cut} stores");
        assert_eq!(successor.newest(), Some(first.clone()), "{cut} stores");
        assert_eq!(
            successor.next, next,
            "the place of the cut record is used again"
        );
        successor.write(second.0, &second.1).unwrap();
        assert_eq!(successor.all(), [second.clone(), first.clone()]);
    }
    let mut file = open();
    write_part(&mut file, 3, &[3], stores);
    assert_eq!(open().newest(), Some((3, vec![3])));
}

#[test]
fn a_file_in_memory_grows_like_one_on_disk() {
    let place = MemoryFile::default();
    let open = || SlotFile::in_memory(&place, 8, 2).unwrap();
    assert!(!open().was_damaged() && open().newest().is_none());
    let mut file = open();
    file.write(1, &[1; 8]).unwrap();
    file.write(2, &[2; 100]).unwrap();
    assert_eq!(open().all(), [(2, vec![2; 100]), (1, vec![1; 8])]);
    let of_another_layout = SlotFile::in_memory(&place, 8, 3).unwrap();
    assert!(of_another_layout.was_damaged());
}
