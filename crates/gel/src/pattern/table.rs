//! A pattern as a flat table in a file.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Motif, Pattern};

/// A [`Pattern`] as a flat table in a file.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Table {
    kind: Kind,
    #[serde(skip_serializing_if = "Option::is_none")]
    cell_mm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    dots: Option<[usize; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    dot_diameter_mm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    speckle_diameter_mm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coverage: Option<f64>,
    levels: [u8; 2],
    seed: u64,
    rotation_rad: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Colour,
    Dots,
    Speckle,
}

impl Default for Table {
    /// A colour pattern whose cell size is left open.
    fn default() -> Self {
        Self { cell_mm: None, ..(&Pattern::default()).into() }
    }
}

impl From<&Pattern> for Table {
    fn from(&Pattern { motif, levels, seed, rotation_rad }: &Pattern) -> Self {
        let mut table = Self {
            kind: Kind::Colour,
            cell_mm: None,
            dots: None,
            dot_diameter_mm: None,
            speckle_diameter_mm: None,
            coverage: None,
            levels,
            seed,
            rotation_rad,
        };
        match motif {
            Motif::Colour { cell_mm } => table.cell_mm = Some(cell_mm),
            Motif::Dots { count, diameter_mm } => {
                (table.kind, table.dots, table.dot_diameter_mm) = (Kind::Dots, Some(count), Some(diameter_mm));
            }
            Motif::Speckle { diameter_mm, coverage } => {
                table.kind = Kind::Speckle;
                (table.speckle_diameter_mm, table.coverage) = (Some(diameter_mm), Some(coverage));
            }
        }
        table
    }
}

impl Serialize for Pattern {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Table::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Pattern {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::try_from(Table::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl TryFrom<Table> for Pattern {
    type Error = String;

    fn try_from(table: Table) -> Result<Self, String> {
        let Table { kind, levels, seed, rotation_rad, .. } = table;
        let keys = [
            ("cell_mm", table.cell_mm.is_some(), Kind::Colour),
            ("dots", table.dots.is_some(), Kind::Dots),
            ("dot_diameter_mm", table.dot_diameter_mm.is_some(), Kind::Dots),
            ("speckle_diameter_mm", table.speckle_diameter_mm.is_some(), Kind::Speckle),
            ("coverage", table.coverage.is_some(), Kind::Speckle),
        ];
        if let Some((key, _, owner)) = keys.into_iter().find(|&(_, is_given, owner)| is_given && owner != kind) {
            return Err(format!("{key} is for the kind {owner:?}, not for {kind:?}").to_lowercase());
        }
        let motif = match kind {
            Kind::Colour => Motif::Colour { cell_mm: table.cell_mm.unwrap_or(Motif::CELL_MM) },
            Kind::Dots => Motif::Dots {
                count: table.dots.unwrap_or(Motif::DOTS),
                diameter_mm: table.dot_diameter_mm.unwrap_or(Motif::DOT_DIAMETER_MM),
            },
            Kind::Speckle => Motif::Speckle {
                diameter_mm: table.speckle_diameter_mm.unwrap_or(Motif::SPECKLE_DIAMETER_MM),
                coverage: table.coverage.unwrap_or(Motif::COVERAGE),
            },
        };
        Ok(Self { motif, levels, seed, rotation_rad })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Pattern, String> {
        toml::from_str(text).map_err(|error: toml::de::Error| error.message().to_string())
    }

    #[test]
    fn an_empty_table_is_the_default() {
        assert_eq!(read(""), Ok(Pattern::default()));
    }

    #[test]
    fn every_kind_comes_back_from_its_table() {
        for motif in [
            Motif::Colour { cell_mm: 0.25 },
            Motif::Dots { count: [12, 9], diameter_mm: 0.75 },
            Motif::Speckle { diameter_mm: 0.3, coverage: 0.4 },
        ] {
            let pattern = Pattern { motif, levels: [5, 250], seed: 77, rotation_rad: 0.1 };
            assert_eq!(read(&toml::to_string(&pattern).unwrap()), Ok(pattern));
        }
    }

    #[test]
    fn what_is_left_out_takes_the_default() {
        let dots = Motif::Dots { count: [15, 15], diameter_mm: 0.5 };
        assert_eq!(read("kind = 'dots'\ndot_diameter_mm = 0.5").map(|pattern| pattern.motif), Ok(dots));
        assert_eq!(read("cell_mm = 0.2").map(|pattern| pattern.motif), Ok(Motif::Colour { cell_mm: 0.2 }));
    }

    #[test]
    fn a_key_of_another_kind_is_refused() {
        let refused = |text| read(text).unwrap_err();
        assert_eq!(refused("kind = 'dots'\ncell_mm = 0.1"), "cell_mm is for the kind colour, not for dots");
        assert!(refused("cel_mm = 0.1").starts_with("unknown field `cel_mm`"));
        assert!(refused("kind = 'stripes'").starts_with("unknown variant `stripes`"));
    }
}
