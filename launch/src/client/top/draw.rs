//! One frame of `top`.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Block, Paragraph};

use super::screen::Screen;
use crate::client::process_table;

/// Rows of a border, above and below.
const BORDER: usize = 2;

/// Draws everything.
pub(super) fn draw(frame: &mut Frame<'_>, screen: &Screen) {
    let rows = |count: usize| Constraint::Length(u16::try_from(count).unwrap_or(u16::MAX));
    let equipment = match screen.equipment.len() {
        0 => 0,
        lines => lines + BORDER,
    };
    let heights = [
        rows(2 + usize::from(!screen.active.is_empty())),
        rows(screen.processes.len() + 1 + BORDER),
        rows(screen.arms.len().max(1) + BORDER),
        rows(equipment),
        Constraint::Min(3),
    ];
    let [head, processes, arms, devices, log] = Layout::vertical(heights).areas(frame.area());
    frame.render_widget(Paragraph::new(headline(screen)), head);
    draw_processes(frame, processes, screen);
    let none = ["no state of physics".to_owned()];
    let arm_lines = match screen.arms.as_slice() {
        [] => &none[..],
        lines => lines,
    };
    draw_lines(frame, arms, "arms", arm_lines);
    draw_lines(frame, devices, "equipment", &screen.equipment);
    let room = usize::from(log.height).saturating_sub(BORDER);
    let first = screen.log.len().saturating_sub(room);
    let said = screen.log.iter().skip(first);
    let said: Vec<String> = said
        .map(|(at, text)| format!("{at:>9.3}  {text}"))
        .collect();
    draw_lines(frame, log, "task", &said);
}

fn headline(screen: &Screen) -> Vec<Line<'_>> {
    let mut lines = vec![
        Line::from(screen.title.as_str()).style(Style::new().add_modifier(Modifier::BOLD)),
        Line::from(screen.task.as_str()),
    ];
    if !screen.active.is_empty() {
        lines.push(Line::from(format!("active: {}", screen.active.join(" | "))));
    }
    lines
}

fn draw_processes(frame: &mut Frame<'_>, area: Rect, screen: &Screen) {
    let width = usize::from(area.width.saturating_sub(2));
    let lines = process_table::lines(&screen.processes, width);
    let mut lines: Vec<Line<'_>> = lines.into_iter().map(Line::from).collect();
    if let Some(titles) = lines.first_mut() {
        *titles = std::mem::take(titles).style(Style::new().add_modifier(Modifier::BOLD));
    }
    let block = Block::bordered().title("processes");
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn draw_lines(frame: &mut Frame<'_>, area: Rect, title: &'static str, lines: &[String]) {
    let lines: Vec<Line<'_>> = lines.iter().map(|line| Line::from(line.as_str())).collect();
    let block = Block::bordered().title(title);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}
