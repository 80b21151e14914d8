//! Faults of processes and of the machine.

use ipc_types::topic::Process;
use supervisor::supervision::Exit;

use super::Model;

impl Model {
    /// Kills `process`, after `effect` effects of its next turn or now.
    pub fn kill(&mut self, process: Process, effect: Option<u64>) -> bool {
        let Some(index) = self.index(process) else {
            return false;
        };
        let began = self.running[index].turns.is_some();
        if let Some(effect) = effect.filter(|_| began) {
            self.running[index].cut = Some(effect);
        } else {
            let one = self.running.remove(index);
            self.gone(one, Exit::Signal(9));
        }
        true
    }

    /// Stops `process` until `until_ns`.
    pub fn stop(&mut self, process: Process, until_ns: u64) -> bool {
        let one = self.running.iter_mut().find(|one| one.process == process);
        one.map(|one| one.frozen_until_ns = until_ns).is_some()
    }

    /// Gives `process` no core until `until_ns`.
    pub fn starve(&mut self, process: Process, until_ns: u64) -> bool {
        let one = self.running.iter_mut().find(|one| one.process == process);
        one.map(|one| one.starved_until_ns = until_ns).is_some()
    }

    /// Whether `process` exists.
    pub fn exists(&self, process: Process) -> bool {
        self.index(process).is_some()
    }

    /// Lets `process` work for ever on its next turn.
    pub fn hang(&mut self, process: Process) -> bool {
        let now_ns = self.now_ns();
        let one = self.running.iter_mut().find(|one| one.process == process);
        one.map(|one| one.hangs_since_ns = Some(now_ns)).is_some()
    }

    /// Makes each turn of `process` take `turn_ns` until `until_ns`.
    pub fn slow_down(&mut self, process: Process, turn_ns: u64, until_ns: u64) -> bool {
        let one = self.running.iter_mut().find(|one| one.process == process);
        one.map(|one| one.slow = (turn_ns, until_ns)).is_some()
    }

    /// Takes the core of `process` for `gap_ns` within each turn until `until_ns`.
    pub fn preempt(&mut self, process: Process, gap_ns: u64, until_ns: u64) -> bool {
        let one = self.running.iter_mut().find(|one| one.process == process);
        one.map(|one| one.preempted = (gap_ns, until_ns)).is_some()
    }

    /// Kills physics after so many steps of its next write.
    pub fn cut_write(&mut self, steps: u64) {
        self.disk.cut_next(steps);
    }

    /// Leaves no room until `until_ns`.
    pub fn fill(&mut self, until_ns: u64) {
        // A shorter fault does not end a longer one.
        self.full_until_ns = self.full_until_ns.max(until_ns);
    }

    /// Makes each write of a state take `write_ms` until `until_ns`.
    pub fn slow_disk(&mut self, write_ms: u64, until_ns: u64) {
        self.slow_disk_until_ns = until_ns;
        self.disk.set_write_ms(write_ms);
    }

    /// Makes the next start of `process` fail.
    pub fn fail_start(&mut self, process: Process) {
        self.failing.push(process);
    }

    /// Makes the next start of `process` take `ms`.
    pub fn slow_start(&mut self, process: Process, ms: u64) {
        self.slow.push((process, ms));
    }
}
