//! Tables that leave out columns where the terminal is narrow.

use std::io::IsTerminal as _;

/// Between two columns.
const GAP: &str = "  ";

/// A column of a table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    pub(super) title: &'static str,
    /// Columns of the highest rank are left out first; those of rank 0 stay.
    pub(super) rank: u8,
    /// Text is aligned to the left, numbers to the right.
    pub(super) text: bool,
}

/// The lines of a table, the titles first, without empty columns. They are at most `width`
/// characters wide if the columns of rank 0 and the last column, which may be long, allow it.
pub(super) fn table(columns: &[Column], rows: &[Vec<String>], width: usize) -> Vec<String> {
    let widths: Vec<usize> = columns
        .iter()
        .enumerate()
        .map(|(index, column)| {
            let cells = rows.iter().filter_map(|row| row.get(index));
            let longest = cells.map(|cell| cell.chars().count()).max().unwrap_or(0);
            longest.max(column.title.chars().count())
        })
        .collect();
    let mut shown = fitting(columns, &widths, width);
    let is_empty = |index: &usize| {
        rows.iter()
            .all(|row| row.get(*index).is_none_or(String::is_empty))
    };
    shown.retain(|index| !is_empty(index));
    let titles: Vec<String> = columns.iter().map(|c| c.title.to_owned()).collect();
    let line = |row: &Vec<String>| {
        let cells = shown.iter().map(|index| {
            let (cell, width) = (row.get(*index).map_or("", String::as_str), widths[*index]);
            if columns[*index].text {
                format!("{cell:<width$}")
            } else {
                format!("{cell:>width$}")
            }
        });
        let cells: Vec<String> = cells.collect();
        cells.join(GAP).trim_end().to_owned()
    };
    std::iter::once(&titles).chain(rows).map(line).collect()
}

/// The columns that fit, by index.
fn fitting(columns: &[Column], widths: &[usize], width: usize) -> Vec<usize> {
    let mut shown: Vec<usize> = (0..columns.len()).collect();
    loop {
        let last = columns.len().saturating_sub(1);
        let counted = shown.iter().filter(|index| **index != last);
        let needed: usize = counted.map(|index| widths[*index] + GAP.len()).sum();
        let worst = shown
            .iter()
            .copied()
            .max_by_key(|index| columns[*index].rank);
        match worst.filter(|index| needed > width + GAP.len() && columns[*index].rank > 0) {
            Some(worst) => shown.retain(|index| *index != worst),
            None => return shown,
        }
    }
}

/// Characters in a line of the terminal; no limit where stdout is none.
pub(super) fn terminal_width() -> usize {
    let size = std::io::stdout()
        .is_terminal()
        .then(crossterm::terminal::size);
    match size {
        Some(Ok((columns, _))) => usize::from(columns),
        // `fitting` adds a gap, which must not overflow.
        _ => usize::MAX - GAP.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_table_has_fewer_columns_and_none_is_cut() {
        let column = |title, rank| Column {
            title,
            rank,
            text: rank == 0,
        };
        let columns = [column("process", 0), column("pid", 2), column("rate Hz", 1)];
        let columns = [&columns[..], &[column("note", 0)]].concat();
        let row = ["controller-0", "4711", "1000.0", "a note that may be long"];
        let rows = [row.map(str::to_owned).to_vec(), vec!["task".to_owned()]];
        let wide = table(&columns, &rows, 200);
        assert_eq!(wide[0], "process        pid  rate Hz  note");
        assert_eq!(
            wide[1],
            "controller-0  4711   1000.0  a note that may be long"
        );
        assert_eq!(wide[2], "task");
        let silent = [vec!["task".to_owned(), "7".to_owned()]];
        assert_eq!(table(&columns, &silent, 200)[0], "process  pid");
        assert_eq!(table(&columns, &rows, 24)[0], "process       rate Hz  note");
        assert_eq!(
            table(&columns, &rows, 5)[1],
            "controller-0  a note that may be long"
        );
    }
}
