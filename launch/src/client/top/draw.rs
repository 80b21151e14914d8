//! One frame of `top`.

use ipc_types::equipment::BreakLimit;
use ipc_types::world::FLAG_PAUSED;
use ipc_types::{ArmState, GripperState};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Block, Paragraph};

use super::View;
use super::equipment::Names;
use crate::client::process_table;
use crate::client::status::{breakpoint, pace, processes, waits_for, word};

/// Draws everything.
pub(super) fn draw(frame: &mut Frame<'_>, view: &View) {
    let arms = view.picture.state().map_or(0, |s| s.arms().len());
    let arm_rows = u16::try_from(4 * arms).unwrap_or(6).max(1) + 2;
    let process_rows = u16::try_from(view.picture.healths().count()).unwrap_or(4) + 3;
    let equipment = equipment_lines(view);
    let equipment_rows = match u16::try_from(equipment.len()).unwrap_or(0) {
        0 => 0,
        rows => rows + 2,
    };
    let active = view.trace.active();
    let heights = [
        Constraint::Length(2 + u16::from(!active.is_empty())),
        Constraint::Length(process_rows),
        Constraint::Length(arm_rows),
        Constraint::Length(equipment_rows),
        Constraint::Min(3),
    ];
    let [head, processes, joints, devices, log] = Layout::vertical(heights).areas(frame.area());
    frame.render_widget(Paragraph::new(headline(view, &active)), head);
    draw_processes(frame, processes, view);
    draw_arms(frame, joints, view);
    let block = Block::bordered().title("equipment");
    frame.render_widget(Paragraph::new(equipment).block(block), devices);
    draw_log(frame, log, view);
}

/// Nothing in a cell without equipment.
fn equipment_lines(view: &View) -> Vec<Line<'static>> {
    let state = view.picture.state();
    let lines = state.map(|state| view.names.lines(&state.equipment));
    lines
        .unwrap_or_default()
        .into_iter()
        .map(Line::from)
        .collect()
}

fn headline(view: &View, active: &[String]) -> Vec<Line<'static>> {
    let spec = &view.session.spec;
    let (state, decision) = (view.picture.state(), view.picture.decision());
    let time = state.map_or_else(
        || "no state".to_owned(),
        |s| format!("{:.2} s", s.header.sim_time_ns as f64 * 1e-9),
    );
    let pace = pace(view.picture.real_time_factor());
    let pause = match breakpoint(state, decision) {
        Some(name) => format!("  PAUSED by breakpoint {name}"),
        None if state.is_some_and(|s| s.has(FLAG_PAUSED)) => "  PAUSED".to_owned(),
        None => String::new(),
    };
    let first = format!(
        "{}  cell `{}`  seed {}  {time}{pace}{pause}  (q quits)",
        spec.demo, spec.cell, spec.seed
    );
    let second = decision.map_or_else(
        || "no decision".to_owned(),
        |d| {
            let outcome = word(d.outcome);
            let waits = waits_for(&outcome);
            format!(
                "{}: {outcome}{waits} {}  phase {}  placed {}  drops {}  resyncs {}  aborts {}",
                d.policy, d.reason, d.phase, d.placed_count, d.drops, d.resyncs, d.aborts
            )
        },
    );
    let mut lines = vec![
        Line::from(first).style(Style::new().add_modifier(Modifier::BOLD)),
        Line::from(second),
    ];
    if !active.is_empty() {
        lines.push(Line::from(format!("active: {}", active.join(" | "))));
    }
    lines
}

fn draw_processes(frame: &mut Frame<'_>, area: Rect, view: &View) {
    let width = usize::from(area.width.saturating_sub(2));
    let lines = process_table::lines(&processes(&view.picture), width);
    let mut lines: Vec<Line<'_>> = lines.into_iter().map(Line::from).collect();
    if let Some(titles) = lines.first_mut() {
        *titles = std::mem::take(titles).style(Style::new().add_modifier(Modifier::BOLD));
    }
    let block = Block::bordered().title("processes");
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn draw_arms(frame: &mut Frame<'_>, area: Rect, view: &View) {
    let arms = view
        .picture
        .state()
        .map(ipc_types::WorldState::arms)
        .unwrap_or_default();
    let mut lines: Vec<Line<'_>> = arms
        .iter()
        .enumerate()
        .flat_map(|(i, arm)| arm_lines(i, arm, &view.names))
        .collect();
    if lines.is_empty() {
        lines.push(Line::from("no state of physics"));
    }
    frame.render_widget(
        Paragraph::new(lines).block(Block::bordered().title("arms")),
        area,
    );
}

fn arm_lines(index: usize, arm: &ArmState, names: &Names) -> [Line<'static>; 4] {
    let count = (arm.joint_count as usize).min(arm.joint_positions.len());
    let list = |values: &[f64]| {
        let texts: Vec<_> = values.iter().map(|v| format!("{v:>8.3}")).collect();
        texts.concat()
    };
    let [x, y, z] = arm.tcp.position;
    let gripper = &arm.gripper;
    let held = names.object(gripper.held_object, "nothing");
    let gripper = if names.has_suction(index) {
        suction_text(gripper)
    } else {
        fingers_text(gripper)
    };
    [
        Line::from(format!(
            "{index} joints rad  {}",
            list(&arm.joint_positions[..count])
        )),
        Line::from(format!(
            "  efforts     {}",
            list(&arm.joint_efforts[..count])
        )),
        Line::from(format!(
            "  tcp {x:.3} {y:.3} {z:.3} m, limit violations {}",
            arm.limit_violations
        )),
        Line::from(if names.has_no_gripper(index) {
            "  no gripper".to_owned()
        } else {
            format!("  {gripper}, holds {held}")
        }),
    ]
}

fn suction_text(gripper: &GripperState) -> String {
    let limit = match BreakLimit::from_code(gripper.break_limit) {
        Some(BreakLimit::Force) => " (force limit)",
        Some(BreakLimit::Torque) => " (torque limit)",
        _ => "",
    };
    format!(
        "suction {}, {:.1} N {:.2} Nm, load {:.0} %, broke {} times{limit}, refused {}",
        if gripper.suction == 1 { "on" } else { "off" },
        gripper.suction_force,
        gripper.suction_torque,
        gripper.load * 100.0,
        gripper.breaks,
        gripper.refusals
    )
}

fn fingers_text(gripper: &GripperState) -> String {
    let beam = if gripper.beam_object == 0 {
        "free"
    } else {
        "interrupted"
    };
    format!(
        "gripper {:.1} mm {:.1} N, beam {beam}",
        gripper.width * 1e3,
        gripper.grip_force
    )
}

fn draw_log(frame: &mut Frame<'_>, area: Rect, view: &View) {
    let room = usize::from(area.height.saturating_sub(2));
    let first = view.trace.log.len().saturating_sub(room);
    let lines: Vec<_> = view
        .trace
        .log
        .iter()
        .skip(first)
        .map(|(at, text)| Line::from(format!("{at:>9.3}  {text}")))
        .collect();
    frame.render_widget(
        Paragraph::new(lines).block(Block::bordered().title("task")),
        area,
    );
}
