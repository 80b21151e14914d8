//! Which messages a reader uses.

use super::*;
use ipc_types::Wire;

fn header(generation: u32, seq: u64) -> Header {
    Header {
        run: 7,
        schema: 9,
        generation,
        seq,
        ..Header::zeroed()
    }
}

/// Whether each message was used, given its port, generation and number.
fn heard(fence: &mut Fence, messages: &[(u128, u32, u64)]) -> Vec<bool> {
    let counts = fence.counts;
    let before = counts.accepted + counts.rejected + counts.fenced;
    // Published one after the other, whatever their numbers say.
    let times = before + 1..;
    let judged = messages.iter().zip(times);
    let judged = judged.map(|((port, generation, seq), publish_ns)| {
        let header = Header {
            publish_ns,
            ..header(*generation, *seq)
        };
        fence.judge(*port, &header, true) == Admission::Accept
    });
    judged.collect()
}

/// Whether messages of one writer, each published at the time that is its number, are used.
fn heard_in(order: &[u64]) -> Vec<bool> {
    let mut fence = fence();
    let judged = order.iter().map(|seq| {
        let header = Header {
            publish_ns: *seq,
            ..header(1, *seq)
        };
        fence.judge(1, &header, true) == Admission::Accept
    });
    judged.collect()
}

fn flipped(number: u64, bit: u32) -> u64 {
    number ^ (1 << bit)
}

fn fence() -> Fence {
    Fence::new(7, 9)
}

#[test]
fn a_stopped_writer_that_wakes_up_is_not_heard_again() {
    let mut fence = fence();
    let messages = [
        (1, 1, 10),
        (1, 1, 11),
        (2, 2, 1),
        (1, 1, 12),
        (2, 2, 2),
        (1, 1, 13),
    ];
    let accepted = heard(&mut fence, &messages);
    assert_eq!(accepted, [true, true, true, false, true, false]);
    assert_eq!(
        fence.counts,
        Counts {
            accepted: 4,
            rejected: 0,
            fenced: 2,
            late: 0
        }
    );
}

#[test]
fn a_successor_of_one_message_silences_the_stopped_writer_for_good() {
    let mut fence = fence();
    heard(&mut fence, &[(1, 1, 10), (1, 1, 11), (2, 2, 1)]);
    let zombie: Vec<(u128, u32, u64)> = (12..200).map(|seq| (1, 1, seq)).collect();
    assert!(!heard(&mut fence, &zombie).contains(&true));
    assert_eq!(heard(&mut fence, &[(2, 2, 2)]), [true]);
}

#[test]
fn a_flipped_bit_in_a_generation_costs_its_message_only() {
    for bit in 0..u32::BITS {
        let mut fence = fence();
        heard(&mut fence, &[(1, 2, 10), (1, 2, 11)]);
        let accepted = heard(
            &mut fence,
            &[(1, 2 ^ (1 << bit), 12), (1, 2, 13), (1, 2, 14)],
        );
        assert_eq!(accepted, [false, true, true], "bit {bit}");
        assert_eq!(fence.generation(), 2, "bit {bit}");
        let successor = heard(&mut fence, &[(2, 3, 1), (1, 2, 15), (2, 3, 2)]);
        assert_eq!(successor, [true, false, true], "bit {bit}");
    }
}

#[test]
fn a_flipped_bit_in_a_sequence_number_costs_at_most_the_next_message() {
    for bit in 0..u64::BITS {
        let mut fence = fence();
        heard(&mut fence, &[(1, 1, 10), (1, 1, 11)]);
        let accepted = heard(
            &mut fence,
            &[(1, 1, flipped(12, bit)), (1, 1, 13), (1, 1, 14)],
        );
        assert!(accepted[2], "bit {bit}");
        assert!(accepted[0] || accepted[1], "bit {bit}");
        heard(&mut fence, &[(1, 1, 15), (1, 1, 16)]);
        assert!(fence.counts.late <= 1, "bit {bit}: {:?}", fence.counts);
    }
}

#[test]
fn a_flipped_bit_in_the_first_message_does_not_shut_its_writer_out() {
    for bit in 0..u32::BITS {
        let mut fence = fence();
        heard(&mut fence, &[(1, 1, 50), (2, 2 ^ (1 << bit), 1)]);
        assert_eq!(
            heard(&mut fence, &[(2, 2, 2), (1, 1, 51), (2, 2, 3)]),
            [true, false, true],
            "bit {bit}"
        );
    }
    for bit in 0..u64::BITS {
        let mut fence = fence();
        let first = [(1, 1, flipped(8, bit)), (1, 1, 9), (1, 1, 10), (1, 1, 14)];
        assert_eq!(heard(&mut fence, &first)[2..], [true, true], "bit {bit}");
        assert!(fence.counts.late >= 3, "bit {bit}");
    }
}

#[test]
fn a_flipped_bit_of_a_replaced_writer_does_not_bring_it_back() {
    for bit in 0..u32::BITS {
        let mut fence = fence();
        heard(&mut fence, &[(1, 1, 50), (1, 1, 51), (2, 2, 1), (2, 2, 2)]);
        let messages = [(1, 1 ^ (1 << bit), 52), (2, 2, 3), (1, 1, 53), (2, 2, 4)];
        assert_eq!(
            heard(&mut fence, &messages),
            [false, true, false, true],
            "bit {bit}"
        );
    }
}

#[test]
fn a_port_that_claimed_a_newer_generation_once_gives_way_to_the_newest() {
    let mut fence = fence();
    heard(&mut fence, &[(2, 2, 1), (2, 2, 2)]);
    // Of generation 1, joined late, with a flipped bit.
    let stray = heard(&mut fence, &[(1, 1 | (1 << 20), 52), (1, 1, 53), (2, 2, 3)]);
    assert_eq!(stray, [true, false, true]);
    assert_eq!(fence.generation(), 2);
}

#[test]
fn a_process_that_opens_its_port_again_is_heard() {
    let mut fence = fence();
    let messages = [(1, 1, 50), (1, 1, 51), (2, 1, 1), (2, 1, 2)];
    assert_eq!(heard(&mut fence, &messages), [true; 4]);
}

#[test]
fn what_was_overwritten_is_counted_within_one_generation() {
    let mut fence = fence();
    heard(
        &mut fence,
        &[(1, 1, 5), (1, 1, 6), (1, 1, 10), (3, 3, 40), (3, 3, 42)],
    );
    assert_eq!(fence.counts.late, 3 + 1);
}

#[test]
fn the_same_message_twice_is_used_once() {
    let mut fence = fence();
    assert_eq!(heard(&mut fence, &[(1, 1, 1), (1, 1, 1)]), [true, false]);
    assert_eq!(fence.counts.fenced, 1);
}

#[test]
fn an_older_message_that_comes_again_or_late_is_not_used() {
    for older in 1..=11 {
        let used = heard_in(&[10, 11, older, 12, 13]);
        assert_eq!(used, [true, true, false, true, true], "{older}");
    }
    assert_eq!(heard_in(&[10, 12, 11, 13]), [true, true, false, true]);
    let used = heard_in(&[10, 13, 11, 12, 13, 14]);
    assert_eq!(used, [true, true, false, false, false, true]);
}

#[test]
fn a_flipped_bit_in_the_time_of_a_message_costs_nothing() {
    for bit in 0..u64::BITS {
        let mut fence = fence();
        let mut used = |seq, publish_ns| {
            let header = Header {
                publish_ns,
                ..header(1, seq)
            };
            fence.judge(1, &header, true) == Admission::Accept
        };
        assert!(used(10, 10) && used(11, flipped(11, bit)) && used(12, 12));
    }
}

#[test]
fn strangers_are_rejected_and_move_nothing() {
    let mut fence = fence();
    for stranger in [
        Header {
            run: 8,
            ..header(5, 5)
        },
        Header {
            schema: 1,
            ..header(5, 5)
        },
        Header {
            seq: 0,
            ..header(5, 5)
        },
    ] {
        assert_eq!(fence.judge(1, &stranger, true), Admission::Drop);
    }
    assert_eq!(fence.generation(), 0);
    assert_eq!(heard(&mut fence, &[(1, 1, 1)]), [true]);
    assert_eq!(fence.counts.rejected, 3);
}

#[test]
fn nonsense_of_a_new_writer_still_silences_the_old_one() {
    let mut fence = fence();
    fence.judge(1, &header(1, 1), true);
    assert_eq!(fence.judge(2, &header(2, 1), false), Admission::Drop);
    assert_eq!(fence.judge(1, &header(1, 2), true), Admission::Drop);
    assert_eq!(
        fence.counts,
        Counts {
            accepted: 1,
            rejected: 1,
            fenced: 1,
            late: 0
        }
    );
}
