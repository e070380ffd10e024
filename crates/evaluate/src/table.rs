//! Tables of figures: the required value beside the measured one.

use serde::Serialize;
use std::fmt;

/// The required value of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Asked {
    /// Small is good: at most this value.
    AtMost(f64),
    /// Large is good: at least this value.
    AtLeast(f64),
}

impl Asked {
    /// Whether a figure meets the requirement. A figure that is not a number never does.
    #[must_use]
    pub fn is_met(self, figure: f64) -> bool {
        match self {
            Self::AtMost(limit) => figure <= limit,
            Self::AtLeast(limit) => figure >= limit,
        }
    }
}

impl fmt::Display for Asked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtMost(limit) => write!(f, "≤ {limit}"),
            Self::AtLeast(limit) => write!(f, "≥ {limit}"),
        }
    }
}

/// One quantity, measured in several ways.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What is measured.
    pub name: String,
    /// The requirement on the first value.
    pub asked: Option<Asked>,
    /// The measured figures, one per column; not a number where a column has none.
    pub values: Vec<f64>,
}

impl Row {
    /// Whether the first value does not meet its requirement.
    #[must_use]
    pub fn is_short(&self) -> bool {
        let first = self.values.first().copied().unwrap_or(f64::NAN);
        self.asked.is_some_and(|asked| !asked.is_met(first))
    }
}

/// Rows of figures under one heading. Prints as aligned text, with a mark on every row that does not meet its
/// requirement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// What the table shows, with its unit.
    pub title: String,
    /// The name of each column; requirements apply to the first one.
    pub columns: Vec<String>,
    /// The rows.
    pub rows: Vec<Row>,
}

impl Table {
    /// An empty table.
    #[must_use]
    pub fn new(title: &str, columns: &[&str]) -> Self {
        Self { title: title.into(), columns: columns.iter().map(ToString::to_string).collect(), rows: Vec::new() }
    }

    /// Appends a row.
    pub fn push(&mut self, name: impl Into<String>, asked: Option<Asked>, values: Vec<f64>) {
        self.rows.push(Row { name: name.into(), asked, values });
    }

    /// The rows that do not meet their requirement.
    pub fn short(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.is_short())
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = |texts: &mut dyn Iterator<Item = usize>| texts.max().unwrap_or(0);
        let name_width = width(&mut self.rows.iter().map(|row| row.name.chars().count()));
        let asked = |row: &Row| row.asked.map(|asked| asked.to_string()).unwrap_or_default();
        let asked_width = width(&mut self.rows.iter().map(|row| asked(row).chars().count()).chain([5]));
        let widths: Vec<usize> = self.columns.iter().map(|column| column.chars().count().max(8)).collect();

        writeln!(f, "{}", self.title)?;
        write!(f, "  {:name_width$}  {:>asked_width$}", "", "asked")?;
        for (column, width) in self.columns.iter().zip(&widths) {
            write!(f, "  {column:>width$}")?;
        }
        writeln!(f)?;
        for row in &self.rows {
            write!(f, "  {:name_width$}  {:>asked_width$}", row.name, asked(row))?;
            for (value, width) in row.values.iter().zip(&widths) {
                if value.is_nan() {
                    write!(f, "  {:>width$}", "–")?;
                } else {
                    write!(f, "  {value:>width$.4}")?;
                }
            }
            writeln!(f, "{}", if row.is_short() { "  ← short" } else { "" })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_aligned_and_marks_what_is_short() {
        let mut table = Table::new("Errors, px", &["ours", "others"]);
        table.push("still", Some(Asked::AtMost(0.01)), vec![0.005, 0.02]);
        table.push("a long way", Some(Asked::AtLeast(0.99)), vec![0.5, f64::NAN]);
        let expected = "Errors, px\n\
                        \x20              asked      ours    others\n\
                        \x20 still       ≤ 0.01    0.0050    0.0200\n\
                        \x20 a long way  ≥ 0.99    0.5000         –  ← short\n";
        assert_eq!(table.to_string(), expected);
        assert_eq!(table.short().count(), 1);
    }

    #[test]
    fn no_number_meets_nothing() {
        assert!(!Asked::AtMost(1.0).is_met(f64::NAN));
        assert!(!Asked::AtLeast(1.0).is_met(f64::NAN));
    }
}
