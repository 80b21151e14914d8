//! `robocell grasp`: the grasps of an object as it is now, and what excludes the others.

use grasp::{GraspReport, GraspRow};
use supervisor::failure::Failure;

use super::columns::{Column, table, terminal_width};
use super::follow::Follower;
use super::operate::object_index;
use super::session::Session;
use crate::args::GraspArgs;
use crate::{output, say};

/// `robocell grasp OBJECT`.
pub(crate) fn grasp(args: &GraspArgs) -> Result<(), Failure> {
    let session = Session::of(&args.of.cell.cell)?;
    let bus = session.join()?;
    let state = Follower::new(&session, &bus)?.now()?;
    let cell = session.load_cell()?;
    let object = object_index(&cell, &args.object)?;
    let arm = args.of.arm as usize;
    let report = GraspReport::of(&cell, &state, object, arm).map_err(Failure::configuration)?;
    if args.json {
        return output::print(&report);
    }
    print(&report);
    Ok(())
}

fn print(report: &GraspReport) {
    let all = &report.candidates;
    let free = all.iter().filter(|of| of.excluded.is_none()).count();
    say::line(format_args!(
        "{} by {}: {free} of {} candidates",
        report.object,
        report.arm,
        all.len()
    ));
    if let (Some(reason), Some(message)) = (report.reason, &report.message) {
        say::line(format_args!("no grasp ({reason}): {message}"));
    }
    let column = |title, text, rank| Column { title, rank, text };
    let columns = [
        column("from", true, 0),
        column("at", true, 0),
        column("x y z m", true, 0),
        column("yaw deg", false, 1),
        column("width mm", false, 2),
        column("", true, 0),
    ];
    let rows: Vec<Vec<String>> = all.iter().enumerate().map(cells).collect();
    for line in table(&columns, &rows, terminal_width()) {
        say::line(line);
    }
}

fn cells((index, of): (usize, &GraspRow)) -> Vec<String> {
    let [x, y, z] = of.tcp.position;
    let chosen = if index == 0 { "chosen" } else { "" };
    let why = of.why.clone().unwrap_or_else(|| chosen.to_owned());
    vec![
        of.approach.to_owned(),
        of.depth.to_owned(),
        format!("{x:.3} {y:.3} {z:.3}"),
        format!("{:.0}", of.yaw_rad.to_degrees()),
        format!("{:.1}", 1.0e3 * of.width_m),
        why,
    ]
}
