//! What a process reports about itself.

use cell_bus::Subscriber;
use cell_worker::{HealthReporter, RunError};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{Decision, Health, Validate as _, Wire as _};

use crate::run::Run;

/// A period and a window of the report (ns).
const PERIOD_NS: u64 = 10_000_000;
const SECOND_NS: u64 = 1_000_000_000;

/// A reporter of the task, and its reader.
struct Reports {
    reporter: HealthReporter,
    reader: Subscriber<Health>,
    now_ns: u64,
}

impl Reports {
    /// The report at `later_ns` after the one before; `None` where none was sent.
    fn after(&mut self, later_ns: u64) -> Option<Health> {
        self.now_ns += later_ns;
        self.reporter.publish_if_due(500, self.now_ns);
        self.reader.take().copied()
    }

    fn note(&mut self) -> String {
        let health = self.after(PERIOD_NS).unwrap();
        health.note.as_str().to_owned()
    }
}

#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Failed(#[from] cell_bus::BusError);

impl RunError for Failed {
    fn is_lasting(&self) -> bool {
        false
    }
}

/// Runs `test` with the reporter of a task.
fn with_reports(name: &str, test: impl FnOnce(&mut Reports)) {
    let run = Run::new(name);
    let keeper = run.keeper();
    let mut done = false;
    run.main(|start| {
        let bus = start.join(Process::Task)?;
        let reader = bus.subscriber(TopicId::Health(Process::Task))?;
        let now_ns = cell_rt::monotonic_ns();
        let reporter = HealthReporter::new(start, &bus, Process::Task, false, now_ns)?;
        test(&mut Reports {
            reporter,
            reader,
            now_ns,
        });
        done = true;
        Ok::<(), Failed>(())
    });
    assert!(done);
    run.wipe(keeper);
}

#[test]
fn a_report_is_sent_every_ten_milliseconds_also_by_a_process_that_waits() {
    with_reports("period", |reports| {
        let first = reports.after(0).unwrap();
        assert_eq!((first.pid, first.cycles), (std::process::id(), 0));
        assert_eq!((first.header.tick, first.header.generation), (500, 2));
        assert!(reports.after(PERIOD_NS - 1).is_none());
        reports.reporter.idle();
        reports.reporter.totals(1, 2, 3);
        let next = reports.after(1).unwrap();
        assert_eq!(next.cycles, 1, "it is alive");
        assert_eq!((next.missed_cycles, next.rejected, next.fenced), (1, 2, 3));
    });
}

#[test]
fn a_fault_hides_the_note_until_it_is_over() {
    with_reports("fault", |reports| {
        reports.reporter.note("waits for physics");
        assert_eq!(reports.note(), "waits for physics");
        reports
            .reporter
            .fault(Some("a killed task would lose its checkpoint"));
        let health = reports.after(PERIOD_NS).unwrap();
        assert_eq!(
            health.fault(),
            Some("a killed task would lose its checkpoint")
        );
        reports.reporter.note("works");
        assert!(reports.note().starts_with("fault: "));
        reports.reporter.fault(None);
        assert_eq!(reports.note(), "works");
    });
}

#[test]
fn a_refused_message_is_told_for_five_seconds_where_there_is_no_other_note() {
    with_reports("refused", |reports| {
        let mut bad = Decision::zeroed();
        bad.outcome = 99;
        let invalid = bad.validate().err();
        let now_ns = reports.now_ns;
        reports.reporter.refused("decision", invalid, now_ns);
        let said = "refused a decision: outcome[0] is 99, allowed is a known code";
        assert_eq!(reports.note(), said);
        // A message that was accepted does not hide the refusal.
        reports.reporter.refused("decision", None, now_ns);
        reports.reporter.note("waits for physics");
        assert_eq!(reports.note(), "waits for physics");
        reports.reporter.note("");
        assert_eq!(reports.after(4 * SECOND_NS).unwrap().note.as_str(), said);
        assert_eq!(reports.after(SECOND_NS).unwrap().note.as_str(), "");
    });
}

#[test]
fn figures_are_those_of_the_last_second() {
    with_reports("figures", |reports| {
        for tick in 0..100 {
            let late_ns = if tick == 50 { 8_000_000 } else { 2_000 };
            let now_ns = reports.now_ns;
            let reporter = &mut reports.reporter;
            reporter.cycle(tick, now_ns, late_ns, [0.0; 4], now_ns);
        }
        assert_eq!(
            reports.after(PERIOD_NS).unwrap().rate_hz,
            0.0,
            "not over yet"
        );
        let health = reports.after(SECOND_NS).unwrap();
        assert_eq!(health.cycles, 100);
        assert!(
            (50.0..=100.0).contains(&health.rate_hz),
            "{}",
            health.rate_hz
        );
        let near = |is: f64, wanted: f64| (is / wanted - 1.0).abs() < 0.1;
        assert!(
            near(health.lateness_p50_ns, 2.0e3),
            "{}",
            health.lateness_p50_ns
        );
        assert!(
            near(health.lateness_max_ns, 8.0e6),
            "{}",
            health.lateness_max_ns
        );
        let health = reports.after(SECOND_NS).unwrap();
        assert_eq!((health.rate_hz, health.lateness_max_ns), (0.0, 0.0));
        assert_eq!(health.cycles, 100, "since the start");
    });
}
