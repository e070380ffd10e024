use serde::Deserialize;
use toml::de::DeTable;

use super::*;

fn read<T: for<'de> Deserialize<'de>>(text: &str) -> Result<T, Fault> {
    let root = DeValue::Table(DeTable::parse(text).unwrap().into_inner());
    T::deserialize(ValueReader::new(&root))
}

#[test]
fn an_error_is_found_in_lists_of_every_form() {
    #[derive(Deserialize, Debug)]
    #[serde(deny_unknown_fields)]
    struct Root {
        #[expect(dead_code, reason = "only its errors matter")]
        table: Option<Inner>,
        #[expect(dead_code, reason = "only its errors matter")]
        items: Option<Vec<Inner>>,
    }
    #[derive(Deserialize, Debug)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        #[expect(dead_code, reason = "only its errors matter")]
        sizes: Vec<[f64; 2]>,
    }
    for (text, path, found) in [
        ("other = 1", "", "other"),
        ("table = 1", "table", "1"),
        ("[table]", "table", "[table]"),
        ("[table]\nsizes = 1", "table.sizes", "1"),
        ("table.sizes = [[1, 2], [3, 'a']]", "table.sizes[1][1]", "'a'"),
        ("table.sizes = [[1, 2], [3]]", "table.sizes[1]", "[3]"),
        ("table.sizes = [[1, 2], [3, 4, 5]]", "table.sizes[1]", "[3, 4, 5]"),
        ("[[items]]\nsizes = []\n[[items]]\nsizes = [[1, 'a']]", "items[1].sizes[0][1]", "'a'"),
        ("[[items]]\nsizes = []\n[[items]]\nsize = 1", "items[1]", "size = 1"),
        ("items = [{ sizes = [] }, { sizes = 1 }, { sizes = [] }]", "items[1].sizes", "1 }"),
    ] {
        let fault = read::<Root>(text).unwrap_err();
        assert_eq!(fault.path(), path, "{text}: {fault}");
        let offset = fault.offset().unwrap();
        assert!(text[offset..].starts_with(found), "{text}: {fault}, at {}", &text[offset..]);
    }
}

#[test]
fn a_value_that_its_type_refuses_is_found() {
    #[derive(Deserialize, Debug, Clone, Copy)]
    #[serde(try_from = "f64")]
    struct Positive;
    impl TryFrom<f64> for Positive {
        type Error = String;

        fn try_from(value: f64) -> Result<Self, String> {
            if value > 0.0 { Ok(Self) } else { Err(format!("{value} is not positive")) }
        }
    }
    type Tables = std::collections::BTreeMap<String, std::collections::BTreeMap<String, Option<Vec<Positive>>>>;
    let text = "[a]\nb = [1]\n[c]\nd = [2,\n-3]";
    let fault = read::<Tables>(text).unwrap_err();
    assert_eq!((fault.message(), fault.path().as_str()), ("-3 is not positive", "c.d[1]"));
    assert!(text[fault.offset().unwrap()..].starts_with("-3"));
}

#[test]
fn values_of_every_kind_are_read() {
    #[derive(Deserialize, Debug, PartialEq)]
    #[serde(rename_all = "kebab-case")]
    enum Shape {
        Point,
        Ball(f64),
        Box { side: u8 },
        Pair(i8, i64),
    }
    #[derive(Deserialize, Debug, PartialEq)]
    #[serde(tag = "kind", rename_all = "kebab-case")]
    enum Tagged {
        Round { radius: f32 },
    }
    #[derive(Deserialize, Debug, PartialEq)]
    struct Named(String);
    #[derive(Deserialize, Debug, PartialEq)]
    struct All {
        shapes: Vec<Shape>,
        tagged: Tagged,
        named: Named,
        count: Option<usize>,
        absent: Option<usize>,
        pair: (bool, f64),
        limit: f64,
        map: std::collections::BTreeMap<String, i32>,
    }
    let text = "shapes = ['point', { ball = 2 }, { box = { side = 0x10 } }, { pair = [-1, 1_000] }]\ncount = 3\n\
                tagged = { kind = 'round', radius = 1.5 }\nnamed = 'a'\npair = [true, 1e3]\nlimit = inf\nother = 1979-05-27\n\
                [map]\nb = 2\na = -1\n";
    let all: All = read(text).unwrap();
    let shapes = vec![Shape::Point, Shape::Ball(2.0), Shape::Box { side: 16 }, Shape::Pair(-1, 1000)];
    assert_eq!(all.shapes, shapes);
    assert_eq!((all.tagged, all.named), (Tagged::Round { radius: 1.5 }, Named("a".into())));
    assert_eq!((all.count, all.absent, all.pair, all.limit), (Some(3), None, (true, 1000.0), f64::INFINITY));
    assert_eq!(all.map.into_iter().collect::<Vec<_>>(), [("a".into(), -1), ("b".into(), 2)]);
}

#[test]
fn the_largest_unsigned_number_is_read() {
    let numbers: std::collections::BTreeMap<String, u64> = read("a = 18446744073709551615\nb = 0").unwrap();
    assert_eq!((numbers["a"], numbers["b"]), (u64::MAX, 0));
}

#[test]
fn what_does_not_fit_is_named() {
    #[derive(Deserialize, Debug)]
    enum Shape {
        #[expect(dead_code, reason = "only its errors matter")]
        Ball(f64),
        Point,
    }
    #[derive(Deserialize, Debug)]
    struct Root {
        #[expect(dead_code, reason = "only its errors matter")]
        x: f64,
    }
    for (text, message) in [
        ("x = 'a'", "invalid type: string \"a\", expected f64"),
        ("x = 1979-05-27", "invalid type: date, expected f64"),
        ("x = true", "invalid type: boolean `true`, expected f64"),
        ("x = 1e999", "the number 1e999 is too large"),
        ("x = 99999999999999999999", "the number 99999999999999999999 has too many digits"),
        ("x = 18446744073709551616", "the number 18446744073709551616 has too many digits"),
        ("y = 1", "missing field `x`"),
    ] {
        assert_eq!(read::<Root>(text).unwrap_err().message(), message, "{text}");
    }
    for (text, message) in [
        ("x = 'Cube'", "unknown variant `Cube`, expected `Ball` or `Point`"),
        ("x = { Cube = 1 }", "unknown variant `Cube`, expected `Ball` or `Point`"),
        ("x = { Ball = 'a' }", "invalid type: string \"a\", expected f64"),
        ("x = { Point = 1 }", "invalid type: integer `1`, expected no value"),
        ("x = 2.5", "expected a word or a table with one key"),
        ("x = {}", "expected a word or a table with one key"),
    ] {
        let error = read::<std::collections::BTreeMap<String, Shape>>(text).unwrap_err();
        assert_eq!((error.message(), error.path().starts_with('x')), (message, true), "{text}");
    }
}
