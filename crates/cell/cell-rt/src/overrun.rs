//! Causes of late cycles: changes of the kernel's counters between two readings.

use std::fs::File;
use std::os::unix::fs::FileExt;

/// Counters of the calling thread and its machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Page faults that needed a disk.
    pub major_faults: u64,
    /// Page faults that did not.
    pub minor_faults: u64,
    /// Times the kernel took the core away.
    pub preemptions: u64,
    /// Time it was ready to run and had no core (ns).
    pub run_delay_ns: u64,
    /// Time in which other virtual machines had the cores of this one (ns, in steps of 10 ms).
    pub steal_ns: u64,
}

impl Counters {
    /// Changes since `before`.
    pub fn since(&self, before: &Self) -> Self {
        Self {
            major_faults: self.major_faults.saturating_sub(before.major_faults),
            minor_faults: self.minor_faults.saturating_sub(before.minor_faults),
            preemptions: self.preemptions.saturating_sub(before.preemptions),
            run_delay_ns: self.run_delay_ns.saturating_sub(before.run_delay_ns),
            steal_ns: self.steal_ns.saturating_sub(before.steal_ns),
        }
    }
}

/// Reads [`Counters`] without allocating: three system calls, about 15 µs, so not in every
/// cycle. Counters that the kernel does not have are 0.
#[derive(Debug)]
struct Probe {
    schedstat: Option<File>,
    stat: Option<File>,
}

impl Probe {
    /// Of the calling thread, also when another one looks later.
    fn of_this_thread() -> Self {
        Self {
            schedstat: File::open("/proc/thread-self/schedstat").ok(),
            stat: File::open("/proc/stat").ok(),
        }
    }

    fn look(&self) -> Counters {
        let usage = usage();
        let count = |value: libc::c_long| u64::try_from(value).unwrap_or(0);
        Counters {
            major_faults: count(usage.ru_majflt),
            minor_faults: count(usage.ru_minflt),
            preemptions: count(usage.ru_nivcsw),
            run_delay_ns: number(self.schedstat.as_ref(), 1),
            // The first line is `cpu`, then user, nice, system, idle, iowait, irq,
            // softirq, steal in ticks of 10 ms (proc_stat(5)).
            steal_ns: number(self.stat.as_ref(), 8) * 10_000_000,
        }
    }
}

/// The word number `index` of the first line of a file; 0 where there is none.
fn number(file: Option<&File>, index: usize) -> u64 {
    let mut text = [0_u8; 256];
    let length = file.map_or(0, |file| file.read_at(&mut text, 0).unwrap_or(0));
    let line = text[..length].split(|byte| *byte == b'\n').next();
    let line = line.and_then(|line| core::str::from_utf8(line).ok());
    let word = line.and_then(|line| line.split_ascii_whitespace().nth(index));
    word.and_then(|word| word.parse().ok()).unwrap_or(0)
}

fn usage() -> libc::rusage {
    // SAFETY: rusage is plain data, all zeros is a value of it.
    let mut usage: libc::rusage = unsafe { core::mem::zeroed() };
    // SAFETY: the pointer is to a live value; where it fails, that stays zero.
    unsafe { libc::getrusage(libc::RUSAGE_THREAD, &raw mut usage) };
    usage
}

/// Cycles between two readings of the counters while no cycle is late.
// At 1 kHz that is 15 µs in 100 ms, and the counters cover 100 ms at most.
const LOOK: u32 = 100;

/// Finds the cause of each late or long cycle of the thread that made it.
#[derive(Debug)]
pub struct OverrunWatch {
    probe: Probe,
    before: Counters,
    cycles: u32,
    late_limit_ns: u64,
    body_limit_ns: u64,
}

impl OverrunWatch {
    /// A cycle is an overrun when it starts later than `late_limit_ns` after its
    /// deadline, or takes longer than `body_limit_ns`.
    pub fn of_this_thread(late_limit_ns: u64, body_limit_ns: u64) -> Self {
        let probe = Probe::of_this_thread();
        Self {
            before: probe.look(),
            probe,
            cycles: 0,
            late_limit_ns,
            body_limit_ns,
        }
    }

    /// Changes the limits of an overrun, as in [`Self::of_this_thread`].
    pub fn set_limits(&mut self, late_limit_ns: u64, body_limit_ns: u64) {
        self.late_limit_ns = late_limit_ns;
        self.body_limit_ns = body_limit_ns;
    }

    /// The cause, for a cycle that is an overrun. Called after each cycle.
    pub fn cycle(&mut self, late_ns: u64, body_ns: u64) -> Option<Cause> {
        self.cycles += 1;
        let is_overrun = late_ns > self.late_limit_ns || body_ns > self.body_limit_ns;
        // Read now and then without an overrun as well: otherwise a delay would be blamed on
        // faults that are minutes old.
        if !is_overrun && self.cycles < LOOK {
            return None;
        }
        self.cycles = 0;
        // Only after an overrun: the 15 µs come on top of a cycle that is late already.
        let now = self.probe.look();
        let counted = now.since(&self.before);
        self.before = now;
        is_overrun.then(|| cause(late_ns, body_ns, &counted))
    }
}

/// The main cause of a delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// Its own work took too long.
    OwnWork,
    /// A page was not in memory.
    PageFault,
    /// Another thread had the core.
    Preemption,
    /// Another virtual machine had the core.
    StealTime,
    /// The kernel woke it up late, for none of these reasons.
    WakeUp,
}

impl Cause {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::OwnWork,
        Self::PageFault,
        Self::Preemption,
        Self::StealTime,
        Self::WakeUp,
    ];

    /// Name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::OwnWork => "own work",
            Self::PageFault => "page fault",
            Self::Preemption => "preemption",
            Self::StealTime => "steal time",
            Self::WakeUp => "wake-up",
        }
    }
}

/// Minor faults that explain a delay: one takes about a microsecond.
const MANY_FAULTS: u64 = 20;

/// The cause of a cycle that started `late_ns` after its deadline and worked for `body_ns`;
/// `counted` are the changes of the counters around it.
pub fn cause(late_ns: u64, body_ns: u64, counted: &Counters) -> Cause {
    let delay_ns = late_ns.max(body_ns);
    // In this order: a fault also lets the thread wait, and that wait is counted as well.
    if counted.major_faults > 0 || counted.minor_faults >= MANY_FAULTS {
        Cause::PageFault
    // Half of the delay, as the counters also cover cycles before this one.
    } else if counted.run_delay_ns >= delay_ns / 2 {
        Cause::Preemption
    } else if counted.steal_ns > 0 {
        Cause::StealTime
    // The work was short, so it is the start that was late,
    // and none of the counters explains it.
    } else if body_ns < late_ns {
        Cause::WakeUp
    } else if counted.preemptions > 0 {
        Cause::Preemption
    } else {
        Cause::OwnWork
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cause_is_told_from_what_was_counted() {
        let none = Counters::default();
        let ms = 1_000_000;
        assert_eq!(cause(2 * ms, 100_000, &none), Cause::WakeUp);
        assert_eq!(cause(0, 2 * ms, &none), Cause::OwnWork);
        let counted = |change: fn(&mut Counters)| {
            let mut counted = none;
            change(&mut counted);
            cause(2 * ms, 100_000, &counted)
        };
        assert_eq!(counted(|c| c.run_delay_ns = 1_900_000), Cause::Preemption);
        assert_eq!(counted(|c| c.run_delay_ns = 100_000), Cause::WakeUp);
        assert_eq!(counted(|c| c.steal_ns = 10_000_000), Cause::StealTime);
        assert_eq!(counted(|c| c.major_faults = 1), Cause::PageFault);
        assert_eq!(counted(|c| c.minor_faults = 3), Cause::WakeUp);
        let preempted = Counters {
            preemptions: 1,
            ..none
        };
        assert_eq!(cause(0, 2 * ms, &preempted), Cause::Preemption);
    }

    #[test]
    fn counters_of_this_thread_only_grow() {
        let probe = Probe::of_this_thread();
        let before = probe.look();
        let block = vec![1_u8; 8 << 20];
        let after = probe.look();
        assert!(core::hint::black_box(&block)[4096] == 1);
        assert!(after.since(&before).minor_faults > 0, "{after:?}");
        assert_eq!(before.since(&after).minor_faults, 0);
    }

    #[test]
    fn only_an_overrun_has_a_cause() {
        let ms = 1_000_000;
        let mut watch = OverrunWatch::of_this_thread(ms, ms);
        let block = vec![1_u8; 8 << 20];
        assert!(core::hint::black_box(&block)[4096] == 1);
        assert_eq!(watch.cycle(0, 2 * ms), Some(Cause::PageFault));
        for _ in 0..3 * LOOK {
            assert_eq!(watch.cycle(ms, ms), None);
        }
    }
}
