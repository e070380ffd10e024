//! A table in a page.

use serde::Serialize;

/// A table: a row's name, then its cells.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HtmlTable {
    /// Its caption.
    pub caption: String,
    /// Names of the columns; the first is that of the column of row names.
    pub columns: Vec<String>,
    /// Its rows.
    pub rows: Vec<HtmlRow>,
    /// Whether each column of cells contains words and no numbers.
    pub words: Vec<bool>,
}

/// Number of characters of the longest cell in a column of numbers.
const FIGURE: usize = 24;

/// A row of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HtmlRow {
    /// Its name.
    pub name: String,
    /// Its cells.
    pub cells: Vec<Cell>,
}

/// A cell of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// Its text.
    pub text: String,
    /// Whether it is the best value of its column or row.
    pub is_best: bool,
}

impl Cell {
    /// A word.
    #[must_use]
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), is_best: false }
    }

    /// A number with this many decimals; a dash if it is not a number.
    #[must_use]
    pub fn figure(value: f64, decimals: usize) -> Self {
        if value.is_finite() { Self::text(format!("{value:.decimals$}").replace('-', "−")) } else { Self::none() }
    }

    /// Nothing was measured.
    #[must_use]
    pub fn none() -> Self {
        Self::text("—")
    }
}

impl HtmlTable {
    /// A table without rows.
    #[must_use]
    pub fn new<'a>(caption: impl Into<String>, columns: impl IntoIterator<Item = &'a str>) -> Self {
        let columns: Vec<_> = columns.into_iter().map(String::from).collect();
        let words = vec![false; columns.len().saturating_sub(1)];
        Self { caption: caption.into(), columns, rows: Vec::new(), words }
    }

    /// Adds a row.
    pub fn row(&mut self, name: impl Into<String>, cells: impl IntoIterator<Item = Cell>) {
        let cells: Vec<_> = cells.into_iter().collect();
        for (words, cell) in self.words.iter_mut().zip(&cells) {
            *words |= cell.text.chars().count() > FIGURE;
        }
        self.rows.push(HtmlRow { name: name.into(), cells });
    }
}
