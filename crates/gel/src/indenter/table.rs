//! An indenter as a flat table in a file.

use std::path::PathBuf;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Indenter, IndenterShape};

/// An [`Indenter`] as a flat table in a file.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    shape: Kind,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    radius_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    inner_radius_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    outer_radius_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    side_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bar_mm: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    points_mm: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    centres_mm: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    text: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    file: Option<PathBuf>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    scale: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    size_mm: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    height_mm: Option<f64>,
    #[serde(default = "fillet_mm")]
    fillet_mm: f64,
    #[serde(default = "wall_slope")]
    wall_slope: f64,
    #[serde(default)]
    rotation_rad: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Circle,
    Rectangle,
    Triangle,
    Polygon,
    Crossing,
    Ring,
    Sphere,
    Pins,
    Letter,
    HeightMap,
    Stl,
}

fn fillet_mm() -> f64 {
    Indenter::FILLET_MM
}

fn wall_slope() -> f64 {
    Indenter::WALL_SLOPE
}

impl Kind {
    fn name(self) -> String {
        match self {
            Self::HeightMap => "height-map".into(),
            other => format!("{other:?}").to_lowercase(),
        }
    }

    /// The keys of the shape.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Circle | Self::Sphere => &["radius_mm"],
            Self::Rectangle => &["size_mm"],
            Self::Triangle => &["side_mm"],
            Self::Polygon => &["points_mm"],
            Self::Crossing => &["bar_mm"],
            Self::Ring => &["inner_radius_mm", "outer_radius_mm"],
            Self::Pins => &["radius_mm", "centres_mm"],
            Self::Letter => &["text", "height_mm"],
            Self::HeightMap => &["file", "size_mm", "height_mm"],
            Self::Stl => &["file", "scale"],
        }
    }
}

impl Table {
    fn new(shape: Kind, indenter: &Indenter) -> Self {
        Self {
            shape,
            radius_mm: None,
            inner_radius_mm: None,
            outer_radius_mm: None,
            side_mm: None,
            bar_mm: None,
            points_mm: None,
            centres_mm: None,
            text: None,
            file: None,
            scale: None,
            size_mm: None,
            height_mm: None,
            fillet_mm: indenter.fillet_mm,
            wall_slope: indenter.wall_slope,
            rotation_rad: indenter.rotation_rad,
        }
    }

    /// Names the first key that belongs only to another shape, with the message for a key that no shape has.
    fn refuse_foreign_key(&self) -> Result<(), String> {
        let given = [
            ("radius_mm", self.radius_mm.is_some()),
            ("inner_radius_mm", self.inner_radius_mm.is_some()),
            ("outer_radius_mm", self.outer_radius_mm.is_some()),
            ("side_mm", self.side_mm.is_some()),
            ("bar_mm", self.bar_mm.is_some()),
            ("points_mm", self.points_mm.is_some()),
            ("centres_mm", self.centres_mm.is_some()),
            ("text", self.text.is_some()),
            ("file", self.file.is_some()),
            ("scale", self.scale.is_some()),
            ("size_mm", self.size_mm.is_some()),
            ("height_mm", self.height_mm.is_some()),
        ];
        let known = self.shape.keys();
        match given.into_iter().find(|(key, is_given)| *is_given && !known.contains(key)) {
            Some((key, _)) => {
                let own = ["shape"].iter().chain(known).chain(&["fillet_mm", "wall_slope", "rotation_rad"]);
                let own: Vec<_> = own.map(|key| format!("`{key}`")).collect();
                Err(format!("unknown field `{key}`, expected one of {}", own.join(", ")))
            }
            None => Ok(()),
        }
    }
}

fn needed<T>(value: Option<T>, key: &str, shape: Kind) -> Result<T, String> {
    value.ok_or_else(|| format!("missing {key}, which the shape {} takes", shape.name()))
}

impl Serialize for Indenter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Table::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Indenter {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::try_from(Table::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl TryFrom<Table> for Indenter {
    type Error = String;

    fn try_from(table: Table) -> Result<Self, String> {
        table.refuse_foreign_key()?;
        let kind = table.shape;
        let number = |value: Option<f64>, key: &str| needed(value, key, kind);
        let pair = |value: Option<[f64; 2]>, key: &str| needed(value, key, kind);
        let shape = match kind {
            Kind::Circle => IndenterShape::Circle { radius_mm: number(table.radius_mm, "radius_mm")? },
            Kind::Sphere => IndenterShape::Sphere { radius_mm: number(table.radius_mm, "radius_mm")? },
            Kind::Rectangle => IndenterShape::Rectangle { size_mm: pair(table.size_mm, "size_mm")? },
            Kind::Triangle => IndenterShape::Triangle { side_mm: number(table.side_mm, "side_mm")? },
            Kind::Polygon => IndenterShape::Polygon { points_mm: needed(table.points_mm, "points_mm", kind)? },
            Kind::Crossing => IndenterShape::Crossing { bar_mm: pair(table.bar_mm, "bar_mm")? },
            Kind::Ring => IndenterShape::Ring {
                inner_radius_mm: number(table.inner_radius_mm, "inner_radius_mm")?,
                outer_radius_mm: number(table.outer_radius_mm, "outer_radius_mm")?,
            },
            Kind::Pins => IndenterShape::Pins {
                radius_mm: number(table.radius_mm, "radius_mm")?,
                centres_mm: needed(table.centres_mm, "centres_mm", kind)?,
            },
            Kind::Letter => IndenterShape::Letter {
                text: needed(table.text, "text", kind)?,
                height_mm: number(table.height_mm, "height_mm")?,
            },
            Kind::HeightMap => IndenterShape::HeightMap {
                file: needed(table.file, "file", kind)?,
                size_mm: pair(table.size_mm, "size_mm")?,
                height_mm: number(table.height_mm, "height_mm")?,
            },
            Kind::Stl => {
                IndenterShape::Stl { file: needed(table.file, "file", kind)?, scale: table.scale.unwrap_or(1.0) }
            }
        };
        let Table { fillet_mm, wall_slope, rotation_rad, .. } = table;
        Ok(Self { shape, fillet_mm, wall_slope, rotation_rad })
    }
}

impl From<&Indenter> for Table {
    fn from(indenter: &Indenter) -> Self {
        let table = |shape: Kind| Self::new(shape, indenter);
        match indenter.shape.clone() {
            IndenterShape::Circle { radius_mm } => Self { radius_mm: Some(radius_mm), ..table(Kind::Circle) },
            IndenterShape::Sphere { radius_mm } => Self { radius_mm: Some(radius_mm), ..table(Kind::Sphere) },
            IndenterShape::Rectangle { size_mm } => Self { size_mm: Some(size_mm), ..table(Kind::Rectangle) },
            IndenterShape::Triangle { side_mm } => Self { side_mm: Some(side_mm), ..table(Kind::Triangle) },
            IndenterShape::Polygon { points_mm } => Self { points_mm: Some(points_mm), ..table(Kind::Polygon) },
            IndenterShape::Crossing { bar_mm } => Self { bar_mm: Some(bar_mm), ..table(Kind::Crossing) },
            IndenterShape::Ring { inner_radius_mm, outer_radius_mm } => Self {
                inner_radius_mm: Some(inner_radius_mm),
                outer_radius_mm: Some(outer_radius_mm),
                ..table(Kind::Ring)
            },
            IndenterShape::Pins { radius_mm, centres_mm } => {
                Self { radius_mm: Some(radius_mm), centres_mm: Some(centres_mm), ..table(Kind::Pins) }
            }
            IndenterShape::Letter { text, height_mm } => {
                Self { text: Some(text), height_mm: Some(height_mm), ..table(Kind::Letter) }
            }
            IndenterShape::HeightMap { file, size_mm, height_mm } => {
                Self { file: Some(file), size_mm: Some(size_mm), height_mm: Some(height_mm), ..table(Kind::HeightMap) }
            }
            IndenterShape::Stl { file, scale } => Self { file: Some(file), scale: Some(scale), ..table(Kind::Stl) },
        }
    }
}

#[cfg(test)]
mod tests {
    use fingervision_settings::Document;

    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Scene {
        indenter: Indenter,
    }

    fn read(table: &str) -> Result<Indenter, (String, String)> {
        let scene = Document::new("scene").parse::<Scene>(&format!("[indenter]\n{table}"));
        scene.map(|scene| scene.indenter).map_err(|error| (error.to_string(), error.hint().unwrap_or_default()))
    }

    #[test]
    fn every_shape_comes_back_from_its_table() {
        let file = PathBuf::from("shapes/tool.bin");
        let shapes = [
            IndenterShape::Circle { radius_mm: 4.0 },
            IndenterShape::Rectangle { size_mm: [10.0, 5.0] },
            IndenterShape::Triangle { side_mm: 8.0 },
            IndenterShape::Polygon { points_mm: vec![[0.0, 0.0], [3.0, 0.5], [1.0, 2.0]] },
            IndenterShape::Crossing { bar_mm: [12.0, 2.4] },
            IndenterShape::Ring { inner_radius_mm: 2.5, outer_radius_mm: 4.0 },
            IndenterShape::Sphere { radius_mm: 6.0 },
            IndenterShape::Pins { radius_mm: 0.5, centres_mm: vec![[-2.0, 0.0], [2.0, 0.25]] },
            IndenterShape::Letter { text: "Aé".into(), height_mm: 6.0 },
            IndenterShape::HeightMap { file: file.clone(), size_mm: [8.0, 6.0], height_mm: 1.5 },
            IndenterShape::Stl { file, scale: 25.4 },
        ];
        for shape in shapes {
            let indenter = Indenter { shape, fillet_mm: 0.25, wall_slope: 2.5, rotation_rad: 0.125 };
            let text = toml::to_string(&indenter).unwrap();
            assert_eq!(read(&text), Ok(indenter), "{text}");
        }
    }

    #[test]
    fn what_is_left_out_takes_the_default() {
        assert_eq!(read("shape = 'circle'\nradius_mm = 4"), Ok(Indenter::default()));
        let stl = Indenter::new(IndenterShape::Stl { file: "a.stl".into(), scale: 1.0 });
        assert_eq!(read("shape = 'stl'\nfile = 'a.stl'"), Ok(stl));
    }

    #[test]
    fn a_key_that_the_shape_does_not_know_is_refused() {
        let (message, hint) = read("shape = 'rectangle'\nradius_mm = 2").unwrap_err();
        assert_eq!(message, "line 1: unknown key indenter.radius_mm");
        assert!(hint.contains("size_mm"), "{hint}");
        let (message, hint) = read("shape = 'circle'\nradius = 2").unwrap_err();
        assert_eq!(message, "line 3: unknown key indenter.radius");
        assert_eq!(hint, "did you mean indenter.radius_mm?");
    }

    #[test]
    fn a_missing_size_and_an_unknown_shape_are_named() {
        let (message, _) = read("shape = 'height-map'\nsize_mm = [1, 2]\nheight_mm = 1").unwrap_err();
        assert!(message.ends_with("indenter: missing file, which the shape height-map takes"), "{message}");
        let (message, hint) = read("shape = 'cirle'\nradius_mm = 2").unwrap_err();
        assert!(message.contains("unknown variant `cirle`"), "{message}");
        assert_eq!(hint, "did you mean circle?");
        assert!(read("radius_mm = 2").unwrap_err().0.contains("missing field `shape`"));
    }
}
