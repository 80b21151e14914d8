//! A cycle allocates nothing, in any motion.

use cell_rt::alloc::count;

use crate::support::Bench;

#[test]
fn no_cycle_allocates() {
    for (controller, generator) in [(0, 0), (0, 1), (1, 2), (1, 3), (2, 4)] {
        let mut bench = Bench::new();
        assert_eq!(bench.start(controller, generator), 1);
        let first = bench.state();
        let pose = crate::support::numbers(&first, 8, 16);
        let before = count();
        for cycle in 0..400 {
            let mut answer = bench.answer();
            answer.pose.copy_from_slice(&pose);
            // Some answers are lost.
            let answer = (cycle % 7 != 6).then_some(answer);
            bench.cycle(answer.as_ref());
            std::hint::black_box(bench.state());
        }
        let after = count();
        assert!(bench.arm.is_running(), "{:?}", bench.arm.take_reflex());
        // A reflex, and the brake after it.
        for _ in 0..40 {
            bench.cycle(None);
        }
        assert_eq!(count() - before, 0, "allocations of generator {generator}");
        assert_eq!(after, before);
        assert!(!bench.arm.is_running());
    }
}
