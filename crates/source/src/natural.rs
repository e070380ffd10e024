//! Natural order of file names: digits are compared as numbers.

use std::cmp::Ordering;

/// Compares names so that `frame2` comes before `frame10`.
///
/// Runs of digits compare by value, everything else byte by byte; names that differ only in leading zeros fall back to
/// plain order, so that the order is total.
pub(crate) fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut left, mut right) = (a.as_bytes(), b.as_bytes());
    while let (Some(&l), Some(&r)) = (left.first(), right.first()) {
        let order = if l.is_ascii_digit() && r.is_ascii_digit() {
            let (l, r) = (take_number(&mut left), take_number(&mut right));
            l.len().cmp(&r.len()).then(l.cmp(r))
        } else {
            (left, right) = (&left[1..], &right[1..]);
            l.cmp(&r)
        };
        if order.is_ne() {
            return order;
        }
    }
    left.len().cmp(&right.len()).then_with(|| a.cmp(b))
}

/// Takes a run of digits off the front; the result has no leading zeros.
fn take_number<'a>(text: &mut &'a [u8]) -> &'a [u8] {
    let digits = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let (number, rest) = text.split_at(digits);
    *text = rest;
    let zeros = number.iter().take_while(|&&digit| digit == b'0').count();
    &number[zeros..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_compare_by_value_and_text_by_byte() {
        let mut names = ["b1", "a10", "a9", "a009", "a", "a10b", "a2-11", "a2-3", "10", "9"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["9", "10", "a", "a2-3", "a2-11", "a009", "a9", "a10", "a10b", "b1"]);
    }

    #[test]
    fn numbers_beyond_any_integer_type_compare() {
        assert_eq!(natural_order("99999999999999999999999998", "99999999999999999999999999"), Ordering::Less);
    }
}
