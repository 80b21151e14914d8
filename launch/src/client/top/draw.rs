//! One frame of `top`.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Block, Paragraph};

use super::screen::Screen;
use crate::client::process_table;

/// At the end of a line that is longer than the screen is wide.
const CUT: char = '…';

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
    let titles = headline(screen, usize::from(head.width));
    frame.render_widget(Paragraph::new(titles), head);
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

fn headline(screen: &Screen, width: usize) -> Vec<Line<'static>> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let mut lines = vec![
        Line::from(cut(&screen.title, width)).style(bold),
        Line::from(cut(&screen.task, width)),
    ];
    if !screen.active.is_empty() {
        let active = format!("active: {}", screen.active.join(" | "));
        lines.push(Line::from(cut(&active, width)));
    }
    lines
}

/// `text`, with a mark at its end where it does not fit into `width` characters.
fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let kept = text.chars().take(width.saturating_sub(1));
    kept.chain([CUT]).collect()
}

fn draw_processes(frame: &mut Frame<'_>, area: Rect, screen: &Screen) {
    let width = usize::from(area.width.saturating_sub(2));
    let lines = process_table::lines(&screen.processes, width);
    let lines = lines.iter().map(|line| Line::from(cut(line, width)));
    let mut lines: Vec<Line<'_>> = lines.collect();
    if let Some(titles) = lines.first_mut() {
        *titles = std::mem::take(titles).style(Style::new().add_modifier(Modifier::BOLD));
    }
    let block = Block::bordered().title("processes");
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn draw_lines(frame: &mut Frame<'_>, area: Rect, title: &'static str, lines: &[String]) {
    let width = usize::from(area.width.saturating_sub(2));
    let lines = lines.iter().map(|line| Line::from(cut(line, width)));
    let lines: Vec<Line<'_>> = lines.collect();
    let block = Block::bordered().title(title);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    #[test]
    fn a_line_that_does_not_fit_ends_with_a_mark() {
        let long = "suction on, 12.0 N 0.10 Nm, load 14 %, broke 0 times, refused 0, holds bin_04";
        let screen = Screen {
            title: "ur10-bin-stack  cell `cell`  seed 0  932.30 s  1.00 times real time".to_owned(),
            arms: vec![long.to_owned(), "short".to_owned()],
            ..Screen::default()
        };
        let mut terminal = Terminal::new(TestBackend::new(60, 20)).unwrap();
        terminal.draw(|frame| draw(frame, &screen)).unwrap();
        let shown = terminal.backend().to_string();
        let line = |word: &str| shown.lines().find(|line| line.contains(word)).unwrap();
        assert!(line("ur10").contains('…'), "{shown}");
        assert!(line("suction").contains("…│"), "{shown}");
        assert!(!line("short").contains('…'), "{shown}");
    }
}
