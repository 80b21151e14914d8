//! Orders of events, with explicit time.

use super::*;
use ipc_types::topic::Process::{Controller, Monitor, Physics, Task};

const ALL: [Process; 4] = [Physics, Controller(0), Task, Monitor];
/// As the launcher starts them.
const LAUNCHED: [Process; 4] = [Physics, Controller(0), Monitor, Task];
const REAL_TIME: Rules = Rules {
    watchdog: true,
    lockstep: false,
    python_task: false,
};

#[derive(Clone)]
struct Bench {
    supervisor: Supervisor,
    now: u64,
    cycles: u64,
    alive: Vec<(Process, u32)>,
    log: Vec<(u64, Action)>,
}

impl Bench {
    fn new(rules: Rules) -> Self {
        Self::of(&ALL, rules)
    }

    fn of(order: &[Process], rules: Rules) -> Self {
        Self {
            supervisor: Supervisor::new(order, rules),
            now: 1_000 * MS,
            cycles: 0,
            alive: vec![],
            log: vec![],
        }
    }

    fn up(rules: Rules) -> Self {
        let mut bench = Self::new(rules);
        bench.run(100);
        assert!(bench.supervisor.is_ready());
        bench.log.clear();
        bench
    }

    fn tell(&mut self, event: Event) {
        let mut out = vec![];
        self.supervisor.handle(self.now, event, &mut out);
        self.obey(out);
    }

    /// Whatever is spawned lives and shows itself; SIGTERM is obeyed at once.
    fn obey(&mut self, actions: Vec<Action>) {
        for action in actions {
            self.log.push((self.now / MS, action.clone()));
            match action {
                Action::Spawn {
                    process,
                    generation,
                } => self.alive.push((process, generation)),
                Action::Terminate { process } => self.end(process, Exit::Code(0)),
                Action::Kill { process } => self.end(process, Exit::Signal(9)),
                _ => {}
            }
        }
    }

    fn end(&mut self, process: Process, exit: Exit) {
        let Some(at) = self.alive.iter().position(|(p, _)| *p == process) else {
            return;
        };
        let (_, generation) = self.alive.remove(at);
        self.tell(Event::Exited {
            process,
            generation,
            exit,
        });
    }

    fn run_without(&mut self, ms: u64, silent: &[Process]) {
        self.run_starving(ms, silent, 0);
    }

    /// Those that are silent get no core for `starved` of every 5 ms.
    fn run_starving(&mut self, ms: u64, silent: &[Process], starved: u64) {
        for _ in 0..ms / 5 {
            self.now += 5 * MS;
            self.cycles += 5;
            for (process, generation) in self.alive.clone() {
                if !silent.contains(&process) {
                    self.tell(Event::Health {
                        process,
                        generation,
                        cycles: self.cycles,
                        fifo: true,
                    });
                }
            }
            self.tell(Event::Listened { ns: 5 * MS });
            for (process, generation) in self.alive.clone() {
                if silent.contains(&process) && starved > 0 {
                    self.tell(Event::Starved {
                        process,
                        generation,
                        ns: starved * MS,
                    });
                }
            }
            let mut out = vec![];
            self.supervisor.poll(self.now, &mut out);
            self.obey(out);
        }
    }

    fn run(&mut self, ms: u64) {
        self.run_without(ms, &[]);
    }

    fn spawns(&self, process: Process) -> Vec<u64> {
        let of = |(at, action): &(u64, Action)| match action {
            Action::Spawn { process: p, .. } if *p == process => Some(*at),
            _ => None,
        };
        self.log.iter().filter_map(of).collect()
    }

    fn gave_up(&self) -> Option<Process> {
        self.log.iter().find_map(|(_, a)| match a {
            Action::GaveUp { process, .. } => Some(*process),
            _ => None,
        })
    }
}

#[test]
fn the_task_waits_for_a_monitor_that_may_come_and_for_no_other() {
    let mut bench = Bench::of(&LAUNCHED, REAL_TIME);
    bench.run_without(1_000, &[Monitor]);
    assert!(bench.spawns(Task).is_empty(), "{:?}", bench.log);
    bench.tell(Event::Exited {
        process: Monitor,
        generation: 1,
        exit: Exit::Code(3),
    });
    bench.run(50);
    assert_eq!(bench.gave_up(), Some(Monitor));
    assert_eq!(bench.spawns(Task).len(), 1, "{:?}", bench.log);
}

#[test]
fn processes_start_one_after_the_other_and_stop_in_reverse() {
    let mut bench = Bench::new(REAL_TIME);
    bench.run(100);
    let order: Vec<_> = bench.alive.iter().map(|(p, _)| *p).collect();
    assert_eq!(order, ALL);
    bench.log.clear();
    bench.tell(Event::Stop);
    bench.run(100);
    let ended: Vec<_> = bench.log.iter().map(|(_, a)| a.clone()).collect();
    let wanted: Vec<_> = ALL
        .iter()
        .rev()
        .map(|p| Action::Terminate { process: *p })
        .collect();
    assert_eq!(ended, wanted);
    assert!(bench.supervisor.is_down());
}

#[test]
fn nothing_starts_before_its_predecessor_shows_itself() {
    let mut bench = Bench::new(REAL_TIME);
    bench.run_without(500, &[Physics]);
    assert_eq!(bench.alive, [(Physics, 1)]);
}

#[test]
fn a_dead_process_comes_back_at_once_with_a_new_generation() {
    let mut bench = Bench::up(REAL_TIME);
    bench.end(Task, Exit::Signal(9));
    bench.run(10);
    assert!(bench.alive.contains(&(Task, 2)));
    assert_eq!(bench.supervisor.restarts(Task), 1);
    assert_eq!(bench.supervisor.restarts(Physics), 0);
}

#[test]
fn a_crash_loop_slows_down_and_is_given_up() {
    let mut bench = Bench::up(REAL_TIME);
    for _ in 0..6 {
        while !bench.alive.iter().any(|(p, _)| *p == Controller(0)) {
            bench.run(5);
        }
        bench.end(Controller(0), Exit::Code(101));
    }
    let gaps: Vec<u64> = bench
        .spawns(Controller(0))
        .windows(2)
        .map(|w| w[1] - w[0])
        .collect();
    assert!(gaps.windows(2).all(|w| w[1] > w[0]), "{gaps:?}");
    assert_eq!(bench.gave_up(), Some(Controller(0)));
    bench.run(5_000);
    assert!(!bench.alive.iter().any(|(p, _)| *p == Controller(0)));
}

#[test]
fn a_process_that_had_run_for_a_while_comes_back_without_delay() {
    let mut bench = Bench::up(REAL_TIME);
    for _ in 0..4 {
        bench.run(2_000);
        bench.end(Task, Exit::Signal(9));
        let died = bench.now / MS;
        bench.run(10);
        assert!(bench.spawns(Task).last().is_some_and(|at| at - died <= 5));
    }
}

#[test]
fn crashes_far_apart_never_add_up() {
    let mut bench = Bench::up(REAL_TIME);
    for _ in 0..20 {
        bench.end(Task, Exit::Signal(11));
        bench.run(3_000);
    }
    assert_eq!(bench.gave_up(), None);
    assert!(bench.alive.contains(&(Task, 21)));
}

#[test]
fn restarts_on_command_are_no_crash_loop() {
    let mut bench = Bench::up(REAL_TIME);
    for round in 0..20 {
        let process = Task;
        bench.tell(if round % 2 == 0 {
            Event::Restart { process }
        } else {
            Event::KillAndRestart { process }
        });
        bench.run(60);
    }
    assert_eq!(bench.gave_up(), None);
    assert!(bench.alive.contains(&(Task, 21)));
}

#[test]
fn a_process_is_never_signalled_during_its_start_up() {
    let mut bench = Bench::up(REAL_TIME);
    bench.end(Task, Exit::Signal(9));
    bench.run(5);
    let born = bench.now / MS;
    bench.tell(Event::Restart { process: Task });
    bench.run(100);
    let asked = bench
        .log
        .iter()
        .find(|(_, a)| *a == Action::Terminate { process: Task })
        .unwrap()
        .0;
    assert!(asked >= born + 50, "{asked} after {born}");
    bench.end(Physics, Exit::Signal(9));
    bench.run(5);
    bench.log.clear();
    bench.tell(Event::Stop);
    bench.run(40);
    assert!(
        !bench
            .log
            .iter()
            .any(|(_, a)| *a == Action::Terminate { process: Physics })
    );
    bench.run(60);
    assert!(bench.supervisor.is_down());
}

#[test]
fn a_hang_is_killed_after_its_limit() {
    for (process, limit) in [
        (Physics, 100),
        (Controller(0), 100),
        (Task, 500),
        (Monitor, 2_000),
    ] {
        let mut bench = Bench::up(REAL_TIME);
        let from = bench.now / MS;
        bench.run_without(limit + 50, &[process]);
        let (at, _) = bench
            .log
            .iter()
            .find(|(_, a)| *a == Action::Kill { process })
            .expect("killed");
        assert!(
            at - from >= limit - 10 && at - from <= limit + 20,
            "{process:?} after {}",
            at - from
        );
        bench.run(100);
        assert!(bench.alive.contains(&(process, 2)));
    }
}

#[test]
fn messages_without_new_cycles_are_a_hang_too() {
    let mut bench = Bench::up(REAL_TIME);
    for _ in 0..40 {
        bench.run_without(5, &[Physics]);
        bench.tell(Event::Health {
            process: Physics,
            generation: 1,
            cycles: 7,
            fifo: true,
        });
    }
    assert!(
        bench
            .log
            .iter()
            .any(|(_, a)| *a == Action::Kill { process: Physics })
    );
}

#[test]
fn a_task_that_waits_in_a_pause_does_not_hang() {
    let mut bench = Bench::up(REAL_TIME);
    for _ in 0..400 {
        bench.run_without(5, &[Task]);
        bench.tell(Event::Health {
            process: Task,
            generation: 1,
            cycles: 7,
            fifo: false,
        });
    }
    assert!(bench.log.is_empty(), "{:?}", bench.log);
}

#[test]
fn a_process_that_gets_no_core_is_reported_once_and_left_running() {
    let mut bench = Bench::up(REAL_TIME);
    bench.run_starving(30_000, &ALL, 5);
    let mut reported = Vec::new();
    for (_, action) in &bench.log {
        match action {
            Action::Starves { process, .. } => reported.push(*process),
            other => panic!("{other:?}"),
        }
    }
    reported.sort_unstable();
    assert_eq!(reported, ALL);
    bench.log.clear();
    bench.run(5_000);
    bench.run_starving(5_000, &[Physics], 5);
    assert!(bench.log.is_empty(), "the same minute: {:?}", bench.log);
}

#[test]
fn a_hang_is_found_on_a_busy_machine_too_after_as_much_time_of_its_own() {
    let mut bench = Bench::up(REAL_TIME);
    bench.run_starving(390, &[Controller(0)], 4);
    assert!(
        !bench
            .log
            .iter()
            .any(|(_, a)| matches!(a, Action::Kill { .. }))
    );
    bench.run_starving(200, &[Controller(0)], 4);
    let process = Controller(0);
    assert!(
        bench
            .log
            .iter()
            .any(|(_, a)| *a == Action::Kill { process })
    );
}

#[test]
fn a_process_that_was_killed_and_takes_its_time_to_end_does_not_hang() {
    let mut bench = Bench::up(REAL_TIME);
    let (process, generation) = (Controller(0), 1);
    bench.run_starving(20, &[process], 0);
    bench.tell(Event::Dying {
        process,
        generation,
    });
    bench.run_starving(2_000, &[process], 0);
    assert!(bench.log.is_empty(), "{:?}", bench.log);
}

#[test]
fn a_start_without_a_core_is_no_start_that_hangs() {
    let mut bench = Bench::new(REAL_TIME);
    bench.run_starving(60_000, &[Physics], 5);
    assert_eq!(bench.spawns(Physics).len(), 1);
    assert_eq!(bench.gave_up(), None);
}

#[test]
fn who_is_asked_to_end_and_gets_no_core_is_waited_for_but_not_for_ever() {
    let killed_after = |starved: bool| {
        let mut supervisor = Supervisor::new(&[Task], REAL_TIME);
        let mut out = vec![];
        supervisor.poll(0, &mut out);
        let (process, generation) = (Task, 1);
        supervisor.handle(
            0,
            Event::Health {
                process,
                generation,
                cycles: 1,
                fifo: false,
            },
            &mut out,
        );
        supervisor.handle(0, Event::Stop, &mut out);
        (50..60_000).step_by(5).find(|ms| {
            out.clear();
            if starved {
                supervisor.handle(ms * MS, Event::Listened { ns: 5 * MS }, &mut out);
                supervisor.handle(
                    ms * MS,
                    Event::Starved {
                        process,
                        generation,
                        ns: 5 * MS,
                    },
                    &mut out,
                );
            }
            supervisor.poll(ms * MS, &mut out);
            out.contains(&Action::Kill { process })
        })
    };
    assert_eq!(killed_after(false), Some(1_050));
    let late = killed_after(true).unwrap();
    assert!((11_000..12_000).contains(&late), "{late}");
}

#[test]
fn a_monitor_that_was_given_up_is_tried_again_and_comes_back_when_asked() {
    let mut bench = Bench::up(REAL_TIME);
    bench.end(Monitor, Exit::Code(3));
    assert_eq!(bench.gave_up(), Some(Monitor));
    bench.run(29_000);
    assert!(bench.spawns(Monitor).is_empty());
    bench.run(2_000);
    assert_eq!(bench.spawns(Monitor).len(), 1);
    bench.end(Monitor, Exit::Code(3));
    bench.run(1_000);
    bench.log.clear();
    bench.tell(Event::Restart { process: Monitor });
    bench.run(100);
    assert_eq!(bench.spawns(Monitor).len(), 1, "{:?}", bench.log);
}

#[test]
fn a_launcher_that_was_not_scheduled_accuses_nobody() {
    let mut bench = Bench::up(REAL_TIME);
    bench.now += 3_000 * MS;
    bench.run(50);
    assert!(bench.log.is_empty(), "{:?}", bench.log);
}

#[test]
fn the_watchdog_can_be_switched_off_and_waits_in_lockstep() {
    let mut bench = Bench::up(Rules {
        watchdog: false,
        lockstep: false,
        python_task: false,
    });
    bench.run_without(10_000, &ALL);
    assert!(bench.log.is_empty());
    let mut bench = Bench::up(Rules {
        watchdog: true,
        lockstep: true,
        python_task: false,
    });
    bench.run_without(1_000, &[Physics, Controller(0), Task]);
    assert!(bench.log.is_empty(), "{:?}", bench.log);
}

#[test]
fn a_python_task_has_time_for_its_imports_and_no_more_when_it_runs() {
    let python = Rules {
        python_task: true,
        ..REAL_TIME
    };
    let mut bench = Bench::new(python);
    bench.run_without(15_000, &[Task]);
    assert_eq!(bench.spawns(Task).len(), 1, "{:?}", bench.log);
    bench.run(100);
    assert!(bench.supervisor.is_ready());
    bench.run_without(600, &[Task]);
    assert_eq!(bench.spawns(Task).len(), 2, "{:?}", bench.log);
    // The message has the limit of a Python task.
    let mut bench = Bench::new(python);
    bench.run_without(20_500, &[Task]);
    let told = |(_, action): &(u64, Action)| matches!(action, Action::Lost { what, .. } if what.contains("within 20 s"));
    assert!(bench.log.iter().any(told), "{:?}", bench.log);
}

#[test]
fn a_start_that_hangs_is_found() {
    let mut bench = Bench::new(REAL_TIME);
    bench.run_without(2_100, &[Physics]);
    assert_eq!(bench.spawns(Physics).len(), 2);
    // Three starts on the first bus, three on another one.
    bench.run_without(20_000, &[Physics]);
    assert_eq!(bench.gave_up(), Some(Physics));
    assert_eq!(bench.spawns(Physics).len(), 6);
}

#[test]
fn starts_that_hang_are_answered_with_a_new_bus_when_nothing_is_left_on_the_old_one() {
    let mut bench = Bench::up(REAL_TIME);
    bench.end(Physics, Exit::Signal(11));
    bench.run_without(6_500, &[Physics]);
    let position = |wanted: fn(&Action) -> bool| {
        let at = bench.log.iter().position(|(_, action)| wanted(action));
        at.unwrap_or_else(|| panic!("{:?}", bench.log))
    };
    let left = position(
        |action| matches!(action, Action::LeaveBus { reason } if reason.contains("physics")),
    );
    let new = position(|action| *action == Action::NewBus);
    let killed = bench.log[left..new].iter();
    let killed = killed.filter(|(_, action)| matches!(action, Action::Kill { .. }));
    assert_eq!(killed.count(), 3, "{:?}", bench.log);
    bench.run(200);
    assert_eq!(bench.gave_up(), None);
    // Its successors know that there were others, and resume.
    assert_eq!(
        bench.alive,
        [(Physics, 5), (Controller(0), 2), (Task, 2), (Monitor, 2)]
    );
}

#[test]
fn without_room_nothing_starts_and_nothing_is_given_up() {
    let mut bench = Bench::up(REAL_TIME);
    bench.tell(Event::Room(false));
    bench.end(Task, Exit::Signal(7));
    bench.end(Controller(0), Exit::Code(101));
    bench.run(20_000);
    assert!(bench.spawns(Task).is_empty() && bench.spawns(Controller(0)).is_empty());
    bench.tell(Event::Room(true));
    bench.run(100);
    assert!(bench.alive.contains(&(Task, 2)) && bench.alive.contains(&(Controller(0), 2)));
    assert_eq!(bench.gave_up(), None);
}

#[test]
fn a_bus_that_is_lost_is_replaced_once() {
    let mut bench = Bench::up(REAL_TIME);
    bench.tell(Event::BusLost);
    bench.run(300);
    assert!(bench.alive.contains(&(Physics, 2)), "{:?}", bench.log);
    assert!(bench.supervisor.has_left_bus());
}

#[test]
fn a_process_that_is_killed_while_it_works_is_no_crash_loop() {
    let mut bench = Bench::up(REAL_TIME);
    for _ in 0..20 {
        bench.run(1_200);
        bench.end(Task, Exit::Signal(9));
        bench.run(10);
    }
    assert_eq!(bench.gave_up(), None);
    // One that crashes as often is.
    for _ in 0..6 {
        bench.run(1_200);
        bench.end(Task, Exit::Signal(11));
        bench.run(10);
    }
    assert_eq!(bench.gave_up(), Some(Task));
}

#[test]
fn a_stop_during_backoff_starts_nothing() {
    let mut bench = Bench::up(REAL_TIME);
    for _ in 0..3 {
        bench.end(Task, Exit::Signal(9));
        bench.run(5);
        while !bench.alive.iter().any(|(p, _)| *p == Task) {
            bench.run(5);
        }
    }
    bench.end(Task, Exit::Signal(9));
    bench.log.clear();
    bench.tell(Event::Stop);
    bench.run(3_000);
    assert!(bench.spawns(Task).is_empty());
    assert!(bench.supervisor.is_down());
}

#[test]
fn a_configuration_error_is_not_tried_again() {
    let mut bench = Bench::up(REAL_TIME);
    bench.end(Physics, Exit::Code(3));
    assert_eq!(bench.gave_up(), Some(Physics));
}

#[test]
fn an_old_generation_changes_nothing() {
    let mut bench = Bench::up(REAL_TIME);
    bench.end(Task, Exit::Signal(9));
    bench.run(100);
    bench.log.clear();
    bench.tell(Event::Exited {
        process: Task,
        generation: 1,
        exit: Exit::Signal(9),
    });
    bench.run(50);
    assert!(bench.log.is_empty());
}

#[test]
fn abort_kills_everything_at_once() {
    let mut bench = Bench::up(REAL_TIME);
    bench.tell(Event::Abort);
    assert_eq!(bench.log.len(), 4);
    assert!(bench.supervisor.is_down());
}

/// What can happen between two looks of the launcher.
const STEPS: [fn(&mut Bench); 10] = [
    |bench| bench.run(5),
    |bench| bench.run(60),
    |bench| bench.run_without(120, &[Physics]),
    |bench| bench.run_starving(120, &[Controller(0)], 5),
    |bench| bench.end(Physics, Exit::Signal(9)),
    |bench| bench.end(Monitor, Exit::Code(3)),
    |bench| bench.tell(Event::Restart { process: Physics }),
    |bench| bench.tell(Event::KillAndRestart { process: Task }),
    |bench| bench.tell(Event::BusLost),
    |bench| {
        bench.tell(Event::Room(false));
        bench.end(Task, Exit::Signal(7));
        bench.run(5);
        bench.tell(Event::Room(true));
    },
];

/// Takes `bench` through every order of `depth` steps. After each step no process
/// exists twice, and none that runs is forgotten; a stop ends with nothing running.
fn explore(bench: &Bench, depth: u32, path: &mut Vec<usize>, seen: &mut u64) {
    *seen += 1;
    let mut processes: Vec<_> = bench.alive.iter().map(|(p, _)| *p).collect();
    processes.sort_unstable();
    processes.dedup();
    assert_eq!(processes.len(), bench.alive.len(), "{path:?}");
    let newest = |(p, generation): &(Process, u32)| bench.supervisor.generation(*p) == *generation;
    assert!(bench.alive.iter().all(newest), "{path:?}");
    if depth == 0 {
        return;
    }
    // The last ones differ by one step from what was stopped already.
    if depth > 2 {
        let mut stopped = bench.clone();
        stopped.tell(Event::Stop);
        stopped.run(200);
        assert!(
            stopped.supervisor.is_down() && stopped.alive.is_empty(),
            "{path:?}"
        );
    }
    for (number, step) in STEPS.iter().enumerate() {
        let mut next = bench.clone();
        next.log.clear();
        step(&mut next);
        path.push(number);
        explore(&next, depth - 1, path, seen);
        path.pop();
    }
}

#[test]
fn every_order_of_events_to_depth_5_ends_clean() {
    let mut seen = 0;
    explore(&Bench::new(REAL_TIME), 5, &mut Vec::new(), &mut seen);
    assert_eq!(seen, (10_u64.pow(6) - 1) / 9);
}

#[test]
#[ignore = "slow: .ci/long"]
fn every_order_of_events_to_depth_8_ends_clean() {
    explore(&Bench::new(REAL_TIME), 8, &mut Vec::new(), &mut 0);
}

#[test]
fn a_truncated_mapped_file_is_not_reported_as_full_memory() {
    let said = |has_room: bool| {
        let mut bench = Bench::up(REAL_TIME);
        bench.tell(Event::Room(has_room));
        bench.end(Physics, Exit::Signal(7));
        let what = |(_, action): &(u64, Action)| match action {
            Action::Lost { what, .. } => Some(what.clone()),
            _ => None,
        };
        bench.log.iter().find_map(what).unwrap()
    };
    let (truncated, full) = (said(true), said(false));
    assert!(truncated.contains("SIGBUS") && truncated.contains("truncated"));
    assert!(!truncated.contains("full"), "{truncated}");
    assert!(full.contains("SIGBUS") && full.contains("full"), "{full}");
}
