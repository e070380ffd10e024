//! Puts tables into a Markdown page, between the comments that mark their places.

use anyhow::{Context, Result};

/// Replaces what stands between `<!-- begin NAME -->` and `<!-- end NAME -->`.
pub(super) fn replace(page: &str, name: &str, table: &str) -> Result<String> {
    let (begin, end) = (format!("<!-- begin {name} -->\n"), format!("<!-- end {name} -->"));
    let missing = || format!("the page has no place for {name}: {} … {end}", begin.trim_end());
    let (before, rest) = page.split_once(&begin).with_context(missing)?;
    let (_, after) = rest.split_once(&end).with_context(missing)?;
    Ok(format!("{before}{begin}\n{}\n\n{end}{after}", table.trim()))
}

/// A Markdown table.
pub(crate) fn table(heads: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let owned = |text: &&str| (*text).to_owned();
    let heads: Vec<String> = heads.iter().map(owned).collect();
    let rule = vec!["---".to_owned(); heads.len()];
    [line(&heads), line(&rule)].into_iter().chain(rows.iter().map(|row| line(row))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_named_place_changes() {
        let page = "a\n<!-- begin one -->\nold\n<!-- end one -->\nb\n<!-- begin two -->\n<!-- end two -->\n";
        let new = replace(page, "one", "| new |\n").unwrap();
        assert_eq!(
            new,
            "a\n<!-- begin one -->\n\n| new |\n\n<!-- end one -->\nb\n<!-- begin two -->\n<!-- end two -->\n"
        );
        assert_eq!(replace(&new, "one", "| new |").unwrap(), new);
        assert!(replace(page, "three", "x").is_err());
    }

    #[test]
    fn a_table_has_a_rule_below_its_heads() {
        assert_eq!(table(&["a", "b"], &[vec!["1".into(), "2".into()]]), "| a | b |\n| --- | --- |\n| 1 | 2 |\n");
    }
}
