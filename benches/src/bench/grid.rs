//! Text in columns, each as wide as its widest cell.

use std::fmt::Write;

/// Between two columns.
const GAP: &str = "  ";

/// Lines of cells.
pub(super) struct Grid {
    /// `<` or `>` for each column; the last is for all further ones too.
    sides: &'static str,
    lines: Vec<Vec<String>>,
}

impl Grid {
    /// No lines yet.
    pub(super) fn new(sides: &'static str) -> Self {
        Self {
            sides,
            lines: Vec::new(),
        }
    }

    /// Adds a line.
    pub(super) fn line(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        self.lines.push(cells.into_iter().map(Into::into).collect());
    }

    /// Writes all lines, each behind `indent`.
    pub(super) fn write(&self, indent: &str, text: &mut String) {
        let columns = self.lines.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            let cells = self.lines.iter().filter_map(|line| line.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for line in &self.lines {
            let mut out = indent.to_owned();
            for (column, (cell, width)) in line.iter().zip(&widths).enumerate() {
                let gap = if column == 0 { "" } else { GAP };
                // Writing to a string cannot fail.
                let _ = match self
                    .sides
                    .as_bytes()
                    .get(column)
                    .or(self.sides.as_bytes().last())
                {
                    Some(b'<') => write!(out, "{gap}{cell:<width$}"),
                    _ => write!(out, "{gap}{cell:>width$}"),
                };
            }
            text.push_str(out.trim_end());
            text.push('\n');
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let mut grid = Grid::new("<>");
        grid.line(["mode", "÷"]);
        grid.line(["a", "12.5"]);
        let mut text = String::new();
        grid.write("  ", &mut text);
        assert_eq!(text, "  mode     ÷\n  a     12.5\n");
    }
}
