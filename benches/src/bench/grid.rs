//! Text in columns, each as wide as its widest cell.

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
        self.lines
            .push(cells.into_iter().map(Into::into).collect());
    }

    /// Writes all lines, each behind `indent`.
    pub(super) fn write(&self, indent: &str, text: &mut String) {
        let widths = self.widths();
        for line in &self.lines {
            let cells = line.iter().zip(&widths).enumerate();
            let cells: Vec<String> = cells
                .map(|(column, (cell, width))| self.cell(column, cell, *width))
                .collect();
            text.push_str(format!("{indent}{}", cells.join(GAP)).trim_end());
            text.push('\n');
        }
    }

    fn widths(&self) -> Vec<usize> {
        let columns = self
            .lines
            .iter()
            .map(Vec::len)
            .max()
            .unwrap_or(0);
        (0..columns)
            .map(|column| self.width(column))
            .collect()
    }

    fn width(&self, column: usize) -> usize {
        let cells = self
            .lines
            .iter()
            .filter_map(|line| line.get(column));
        cells
            .map(|cell| cell.chars().count())
            .max()
            .unwrap_or(0)
    }

    fn cell(&self, column: usize, cell: &str, width: usize) -> String {
        let sides = self.sides.as_bytes();
        match sides.get(column).or(sides.last()) {
            Some(b'<') => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
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
