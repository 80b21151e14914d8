//! The launcher's side of the bus: messages of the processes, and another bus where this
//! one is damaged.

use cell_bus::RunSite;
use ipc_types::operator::OperatorAction;

use super::{End, LiveCell};
use crate::failure::{Context, Failure};
use crate::run::bus_thread::BusThread;
use crate::run::half_made::HalfMadeSweep;
use crate::run::watch::Watch;
use crate::supervision::Event;
use crate::{leftovers, say};

/// How long the launcher's own ports may hear nothing before the run is given up (ns).
const DEAF_LIMIT_NS: u64 = 30_000_000_000;

impl LiveCell {
    pub(super) fn listen(&mut self, now: u64) {
        let news = self.bus.take(now);
        if let Some((OperatorAction::TaskStart, true)) = news.answer {
            self.start_event_given = true;
        }
        for event in self.watch.take(news) {
            self.tell(now, event);
        }
        while let Some(fault) = self.watch.next_fault() {
            say::warn(format_args!("fault of {fault}"));
        }
        if self.bus.deaf_ns(now) <= DEAF_LIMIT_NS {
            return;
        }
        if self.supervisor.has_left_bus() {
            let message = "the launcher has heard nothing from the cell's bus for 30 s: its shared \
                           memory is damaged; start the cell again";
            self.finish_with(End::GaveUp(Failure::gave_up(message)));
        } else {
            self.tell(now, Event::BusLost);
        }
    }

    /// Replaces the bus on which processes could not work. None of them runs.
    pub(super) fn new_bus(&mut self) -> Result<(), Failure> {
        let spec = &mut self.plan.spec;
        let old_root = spec.root.clone();
        (spec.root, spec.prefix) = self.plan.dir.site(spec.run.wrapping_add(1));
        spec.save(&self.plan.dir.spec())
            .map_err(Failure::configuration)?;
        let site = RunSite {
            root: spec.root.clone(),
            prefix: spec.prefix.clone(),
        };
        let bus = BusThread::start(site.clone(), spec.run, &self.processes)?;
        drop(std::mem::replace(&mut self.bus, bus));
        self.watch = Watch::new(&self.processes).with_faults_of(&mut self.watch);
        self.sweep = HalfMadeSweep::new(site);
        leftovers::sweep(&self.plan.dir, &self.plan.spec.prefix);
        leftovers::remove(&old_root).cannot(format!("remove {}", old_root.display()))
    }
}
