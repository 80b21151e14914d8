//! The kills of a series in every order that matters, with time as an argument.

use super::*;

const MS: u64 = 1_000_000;
/// Between two looks of a cell in lockstep that runs at twenty times real time.
const STEP_TICKS: u64 = 100;
const LENGTH: u64 = 20_000;

/// A cell that is looked at every 5 ms. Physics that was killed is away for 40 ms and
/// goes `back` ticks.
struct Job {
    now_ns: u64,
    sight: Sight,
    away: u32,
    back: u64,
    struck_at: Vec<u64>,
}

impl Job {
    fn new(back: u64) -> Self {
        Self {
            now_ns: 0,
            sight: Sight::default(),
            away: 0,
            back,
            struck_at: Vec::new(),
        }
    }

    fn run(&mut self, kills: &mut Kills, number: u64, step: u64) {
        kills.begin_job(number, number - 1);
        self.sight = Sight {
            can_be_hit: true,
            generation: 1,
            ..Sight::default()
        };
        while self.sight.tick < LENGTH {
            self.now_ns += 5 * MS;
            self.turn(kills, step);
        }
        kills.end_of_job(Some(LENGTH));
    }

    fn turn(&mut self, kills: &mut Kills, step: u64) {
        match self.away {
            0 => self.sight.tick += step,
            1 => {
                self.away = 0;
                self.sight.generation += 1;
                self.sight.tick = self.sight.tick.saturating_sub(self.back);
                self.sight.resumed_tick = self.sight.tick;
            }
            _ => self.away -= 1,
        }
        let sight = self.sight;
        let mut struck = false;
        let strike = |_: &mut Random| {
            struck = true;
            Some(Struck {
                process: Process::Physics,
                generation: sight.generation,
                since_ns: self.now_ns,
            })
        };
        kills.turn(self.now_ns, &sight, strike, |_| sight.generation);
        if struck {
            self.away = 8;
            self.struck_at.push(sight.tick);
        }
    }
}

fn series(back: u64, step: u64) -> (Kills, Job, u64) {
    let (mut kills, mut job) = (Kills::new(20, 7), Job::new(back));
    let mut number = 0;
    while !kills.is_over() {
        number += 1;
        job.run(&mut kills, number, step);
    }
    (kills, job, number)
}

#[test]
fn a_job_in_real_time_is_hit_early_and_late_and_the_first_one_not_at_all() {
    let (kills, job, jobs) = series(500, 5);
    assert_eq!((kills.missing(), job.struck_at.len()), (0, 20));
    let done = kills.into_done();
    // A kill before tick 500 takes physics back to the start.
    let mut lost = done.iter().zip(&job.struck_at);
    assert!(lost.all(|(kill, tick)| kill.ticks_lost == Some(500.min(*tick))));
    assert!(done.iter().all(|kill| kill.back_ms == Some(40.0)));
    assert!(!done.iter().any(Kill::is_bad));
    assert_eq!(done[0].job, 2);
    assert!(jobs < 10, "{jobs}");
    let early = job.struck_at.iter().filter(|tick| **tick < LENGTH / 2);
    assert!((5..=15).contains(&early.count()), "{:?}", job.struck_at);
}

#[test]
fn a_job_that_is_over_within_a_second_is_repeated_and_hit_once_each_time() {
    let (kills, job, jobs) = series(500, STEP_TICKS);
    assert_eq!((kills.missing(), job.struck_at.len()), (0, 20));
    assert!(jobs > 20, "{jobs}");
    let late = job.struck_at.iter().filter(|tick| **tick >= LENGTH / 2);
    assert!((5..=15).contains(&late.count()), "{:?}", job.struck_at);
}

#[test]
fn a_kill_that_costs_more_than_a_second_is_bad() {
    let (kills, ..) = series(1001, 5);
    assert!(
        kills
            .into_done()
            .iter()
            .filter(|kill| kill.is_bad())
            .count()
            > 15
    );
}

#[test]
fn states_of_killed_physics_that_are_heard_late_count_as_lost() {
    let mut kills = Kills::new(1, 7);
    kills.begin_job(1, 0);
    kills.end_of_job(Some(1));
    kills.begin_job(2, 1);
    let strike = |_: &mut Random| {
        Some(Struck {
            process: Process::Physics,
            generation: 1,
            since_ns: MS,
        })
    };
    let mut sight = Sight {
        can_be_hit: true,
        tick: 1000,
        generation: 1,
        resumed_tick: 0,
    };
    kills.turn(MS, &sight, strike, |_| 1);
    sight.tick = 1010;
    kills.turn(2 * MS, &sight, strike, |_| 1);
    (sight.tick, sight.generation, sight.resumed_tick) = (510, 2, 500);
    kills.turn(50 * MS, &sight, strike, |_| 2);
    let done = kills.into_done();
    assert_eq!((done[0].tick, done[0].ticks_lost), (1010, Some(510)));
}

#[test]
fn nothing_is_repeated_for_ever() {
    // The job without a kill fails.
    let mut kills = Kills::new(20, 7);
    kills.begin_job(1, 0);
    kills.end_of_job(None);
    assert!(kills.is_over());
    // Jobs end before anything can be killed.
    let mut kills = Kills::new(20, 7);
    for job in 1..5 {
        assert!(!kills.is_over());
        kills.begin_job(job, 0);
        kills.end_of_job(Some(LENGTH));
    }
    assert!(kills.is_over());
    assert_eq!(kills.missing(), 20);
    assert_eq!(
        kills.why_over(false),
        "jobs end before their processes work"
    );
    assert_eq!(kills.why_over(true), "the series was stopped");
    // Physics never comes back: that is a result.
    let mut kills = Kills::new(1, 7);
    kills.begin_job(1, 0);
    kills.end_of_job(Some(1));
    kills.begin_job(2, 0);
    let sight = Sight {
        can_be_hit: true,
        tick: 9,
        generation: 1,
        resumed_tick: 0,
    };
    let strike = |_: &mut Random| {
        Some(Struck {
            process: Process::Physics,
            generation: 1,
            since_ns: 0,
        })
    };
    for now_ns in [0, PATIENCE_NS] {
        kills.turn(now_ns, &sight, strike, |_| 1);
    }
    kills.end_of_job(Some(9));
    assert!(kills.is_over() && kills.into_done()[0].is_bad());
}
