//! The table of a run, column by column.

/// The numbers or words of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// Numbers; an empty cell is not a number.
    Numbers(Vec<f64>),
    /// Words, where a cell is not a number.
    Words(Vec<String>),
}

/// The columns of `readings.csv`, with their names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RunTable {
    /// Name and content of each column.
    pub columns: Vec<(String, Column)>,
}

/// The one column of words, even if all its cells are empty.
const WORDS: &str = "flags";

impl RunTable {
    /// The table with this text. A last line that was cut off is left out.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let rows: Vec<Vec<&str>> =
            lines.map(|line| line.split(',').collect::<Vec<_>>()).filter(|row| row.len() == names.len()).collect();
        let column = |(index, name): (usize, &&str)| {
            let cells = || rows.iter().filter_map(move |row| row.get(index).copied());
            let number = |cell: &str| if cell.is_empty() { Some(f64::NAN) } else { cell.parse().ok() };
            let numbers = if *name == WORDS { None } else { cells().map(number).collect() };
            let words = || Column::Words(cells().map(Into::into).collect());
            ((*name).to_owned(), numbers.map_or_else(words, Column::Numbers))
        };
        Self { columns: names.iter().enumerate().map(column).collect() }
    }
}

impl Column {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Words(words) => words.len(),
        }
    }

    /// The type as in `.npy` files: `<f8`, or `<U9` for words of up to nine letters.
    #[must_use]
    pub fn descr(&self) -> String {
        match self {
            Self::Numbers(_) => "<f8".into(),
            Self::Words(words) => format!("<U{}", longest(words)),
        }
    }

    /// The values as in `.npy` files.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Numbers(numbers) => numbers.iter().flat_map(|number| number.to_le_bytes()).collect(),
            Self::Words(words) => {
                let longest = longest(words);
                let padded = |word: &String| {
                    let padding = std::iter::repeat('\0');
                    word.chars().chain(padding).take(longest).map(u32::from).collect::<Vec<u32>>()
                };
                words.iter().flat_map(padded).flat_map(u32::to_le_bytes).collect()
            }
        }
    }
}

/// Letters of the longest word, at least one: the type has no empty words.
fn longest(words: &[String]) -> usize {
    words.iter().map(|word| word.chars().count()).max().unwrap_or(0).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_numbers_or_words() {
        let table = RunTable::of("sequence,force_z_n,flags\n0,,\n1,0.5,lost+dropped\n2,0.7");
        assert_eq!(table.columns[0], ("sequence".into(), Column::Numbers(vec![0.0, 1.0])));
        let Column::Numbers(force) = &table.columns[1].1 else { panic!("numbers") };
        assert!(force[0].is_nan() && (force[1] - 0.5).abs() < 1e-12);
        let flags = &table.columns[2].1;
        assert_eq!((flags.descr().as_str(), flags.rows(), flags.bytes().len()), ("<U12", 2, 2 * 12 * 4));
        assert_eq!(RunTable::of("a,flags\n1,").columns[1].1.descr(), "<U1");
    }
}
