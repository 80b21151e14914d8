//! `cargo drill`: see docs/simulation.md.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a program of the command line"
)]

use std::ops::Range;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use serde::Serialize;

use robocell_drill::batch::{self, Batch, Failure, Summary, examine};
use robocell_drill::draw::Level;
use robocell_drill::plan::Plan;
use robocell_drill::{draw, export, fidelity, planted, reduce};

/// An invariant did not hold.
const FAILED: u8 = 5;
/// The usage or the generator is wrong.
const WRONG: u8 = 2;
/// Plans that reached a combination of states that none before it had.
const FIRSTS: &str = "target/drill/new.jsonl";

/// Runs the whole cell under virtual time with drawn faults, and checks the invariants.
#[derive(Parser)]
struct Args {
    /// Seeds of plans, as FIRST..LAST [default: 1..200, or all from 1 with --minutes].
    #[arg(long, value_parser = range)]
    seeds: Option<Range<u64>>,
    /// What the plans are about.
    #[arg(long, value_enum, default_value_t = Level::Mixed)]
    level: Level,
    /// One seed; its events are printed.
    #[arg(long, conflicts_with = "plan")]
    seed: Option<u64>,
    /// A plan in place of seeds; its events are printed.
    #[arg(long)]
    plan: Option<PathBuf>,
    /// End after so many minutes.
    #[arg(long)]
    minutes: Option<f64>,
    /// Threads.
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Longest run of a plan (s).
    #[arg(long, default_value_t = 10)]
    longest: u64,
    /// End with the first failure.
    #[arg(long)]
    first: bool,
    /// Planted bugs, as FIRST..LAST or `all`: each is built and searched for `--minutes`.
    #[arg(long, value_name = "BUGS")]
    planted: Option<String>,
    /// So many plans are also run as real processes, and the state hashes compared.
    #[arg(long, value_name = "COUNT")]
    fidelity: Option<u64>,
    /// Also prints the states that were reached; ends with 2 where a named one was not.
    #[arg(long)]
    coverage: bool,
    /// A patch of the tree that is built and searched for `--minutes`.
    #[arg(long)]
    patch: Option<PathBuf>,
    /// The summary as a line of JSON.
    #[arg(long)]
    json: bool,
}

fn range(text: &str) -> Result<Range<u64>, String> {
    let refusal = || format!("{text:?} is not FIRST..LAST, such as 1..2000");
    let (first, last) = text.split_once("..").ok_or_else(refusal)?;
    let number = |text: &str| text.parse::<u64>().map_err(|_| refusal());
    let (first, last) = (number(first)?, number(last)?);
    if first > last {
        return Err(refusal());
    }
    Ok(first..last.saturating_add(1))
}

fn main() -> ExitCode {
    match work(&Args::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(FAILED),
        Err(why) => {
            eprintln!("drill: {why}");
            ExitCode::from(WRONG)
        }
    }
}

/// Whether all invariants held.
fn work(args: &Args) -> Result<bool, String> {
    if let Some(plan) = one_plan(args)? {
        return one(&plan);
    }
    let minutes = args.minutes.unwrap_or(10.0);
    if let Some(bugs) = &args.planted {
        return planted_bugs(bugs, minutes);
    }
    if let Some(count) = args.fidelity {
        return fidelity_of(count);
    }
    if let Some(patch) = &args.patch {
        let found = planted::search_patch(patch, minutes)?;
        print_json(&found)?;
        return Ok(!found.found);
    }
    many(args)
}

/// Runs a batch of seeds; whether all invariants held.
fn many(args: &Args) -> Result<bool, String> {
    let limit = args
        .minutes
        .map(|minutes| Duration::from_secs_f64(60.0 * minutes));
    let end = if limit.is_some() { u64::MAX } else { 201 };
    let batch = Batch {
        seeds: args.seeds.clone().unwrap_or(1..end),
        level: args.level,
        longest_ms: args.longest * 1000,
        jobs: args.jobs,
        limit,
        first: args.first,
    };
    let (summary, failures) = batch::run_all(&batch)?;
    for failure in failures.iter().take(5) {
        report(failure)?;
    }
    if args.json {
        print_json(&summary)?;
    } else {
        println!(
            "{} plans, {:.0} simulated s at {:.1} times real time, digest {}, {} failed",
            summary.schedules,
            summary.simulated_s,
            summary.x_real_time,
            summary.digest,
            summary.failed.len()
        );
        for (kind, drawn, effective) in &summary.faults {
            println!("  {kind}: {drawn} drawn, {effective} effective");
        }
    }
    // A failed invariant has priority over a weak generator.
    if !failures.is_empty() {
        return Ok(false);
    }
    if args.coverage {
        coverage(&batch, &summary)?;
    }
    // A kind that mostly hits nothing tests nothing.
    let idle = summary
        .faults
        .iter()
        .find(|(_, drawn, effective)| *drawn >= 20 && 2 * effective < *drawn);
    if let Some((kind, drawn, effective)) = idle {
        return Err(format!(
            "{kind} was effective in {effective} of {drawn} draws only"
        ));
    }
    Ok(true)
}

/// Prints what was reached, and writes the plans that reached a new combination of states.
fn coverage(batch: &Batch, summary: &Summary) -> Result<(), String> {
    let plan = |seed: &u64| draw::plan(*seed, batch.level, batch.longest_ms);
    let lines = summary.firsts.iter().map(plan);
    let lines = lines.map(|plan| serde_json::to_string(&plan).map(|line| line + "\n"));
    let lines = lines.collect::<Result<String, _>>();
    let lines = lines.map_err(|error| error.to_string())?;
    std::fs::create_dir_all("target/drill")
        .and_then(|()| std::fs::write(FIRSTS, lines))
        .map_err(|error| format!("{FIRSTS}: {error}"))?;
    println!(
        "{} combinations of states; {} plans reached a new one: {FIRSTS}",
        summary.combinations,
        summary.firsts.len()
    );
    if summary.not_reached.is_empty() {
        return Ok(());
    }
    let missing = summary.not_reached.join("; ");
    Err(format!("no plan reached: {missing}"))
}

/// Searches for planted bugs; whether each of them was found.
fn planted_bugs(bugs: &str, minutes: f64) -> Result<bool, String> {
    let wanted = if bugs == "all" {
        0..u64::MAX
    } else {
        range(bugs)?
    };
    let mut bugs = planted::all()?;
    bugs.retain(|(number, _)| wanted.contains(&u64::from(*number)));
    let mut all_found = true;
    planted::search_all(&bugs, minutes, |found| {
        all_found &= found.found;
        print_json(&found)
    })?;
    Ok(all_found)
}

/// Compares the drill with real cells; whether all are equal.
fn fidelity_of(count: u64) -> Result<bool, String> {
    let mut equal = 0;
    for seed in 1..=count {
        let compared = fidelity::compare(seed)?;
        equal += u64::from(compared.is_equal());
        print_json(&compared)?;
    }
    println!("{equal} of {count} are equal");
    Ok(equal == count)
}

fn print_json(value: &impl Serialize) -> Result<(), String> {
    let json = serde_json::to_string(value).map_err(|error| error.to_string())?;
    println!("{json}");
    Ok(())
}

fn one_plan(args: &Args) -> Result<Option<Plan>, String> {
    if let Some(seed) = args.seed {
        return Ok(Some(draw::plan(seed, args.level, args.longest * 1000)));
    }
    let Some(path) = &args.plan else {
        return Ok(None);
    };
    let text =
        std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let plan =
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(Some(plan))
}

/// Runs `plan` and prints its events.
fn one(plan: &Plan) -> Result<bool, String> {
    let outcome = examine(plan)?;
    println!(
        "{}",
        serde_json::to_string(plan).map_err(|error| error.to_string())?
    );
    for line in &outcome.log {
        println!("{line}");
    }
    match &outcome.failed {
        Some(failed) => println!("invariant {}: {}", failed.invariant, failed.why),
        None => println!("digest {:016x}", outcome.digest),
    }
    Ok(outcome.failed.is_none())
}

/// Prints a failure and the smallest plan that has it, which is kept.
fn report(failure: &Failure) -> Result<(), String> {
    let (Failure { plan, failed }, seed) = (failure, failure.plan.seed);
    println!(
        "seed {seed}: invariant {}, {}",
        failed.invariant, failed.why
    );
    let (small, failed, runs) = reduce::reduce(plan, failed);
    println!(
        "  at {:.3} s; reduced from {} to {} faults in {runs} runs:",
        failed.at_us as f64 * 1.0e-6,
        plan.faults.len(),
        small.faults.len()
    );
    for timed in &small.faults {
        println!("  {:.3} s  {:?}", timed.at_us as f64 * 1.0e-6, timed.fault);
    }
    let dir = PathBuf::from(format!("target/drill/{seed}"));
    let path = dir.join("min.json");
    let text = serde_json::to_string_pretty(&small).map_err(|error| error.to_string())?;
    std::fs::create_dir_all(&dir)
        .and_then(|()| std::fs::write(&path, text))
        .map_err(|error| format!("{}: {error}", path.display()))?;
    println!("  again: cargo drill --plan {}", path.display());
    let ran = examine(&small)?;
    let ticks_per_ms = ran.simulated_ms as f64 / ran.ran_ms.max(1) as f64;
    let exported = export::write(&small, ticks_per_ms, &dir)
        .map_err(|error| format!("{}: {error}", dir.display()))?;
    println!("  real system: {}", exported.command);
    if exported.only_simulated > 0 {
        println!("  ({} events only simulated)", exported.only_simulated);
    }
    Ok(())
}
