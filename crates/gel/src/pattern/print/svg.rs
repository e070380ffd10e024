//! The page as SVG.

use std::fmt::Write;

use svg::Document;
use svg::node::element::{Circle, ClipPath, Definitions, Description, Group, Path, Polyline, Rectangle, Title};
use svg::node::{Text, Value};

use super::page::{Artwork, Page};

pub(super) fn write(page: &Page) -> String {
    let [width, height] = page.size_mm;
    let [x, y] = page.origin_mm;
    let mut lines = Group::new().set("fill", "none").set("stroke", "#000000");
    lines = lines.set("stroke-linecap", "round").set("stroke-linejoin", "round");
    for stroke in &page.strokes {
        let mut points = String::new();
        for [x, y] in &stroke.points_mm {
            // Writing to a string does not fail.
            let _ = write!(points, "{} {} ", decimal(*x), decimal(*y));
        }
        lines =
            lines.add(Polyline::new().set("points", points.trim_end()).set("stroke-width", decimal(stroke.width_mm)));
    }
    let pattern =
        artwork(page).set("id", "pattern").set("transform", format!("translate({} {})", decimal(x), decimal(y)));
    let document = Document::new()
        .set("width", format!("{}mm", decimal(width)))
        .set("height", format!("{}mm", decimal(height)))
        .set("viewBox", format!("0 0 {} {}", decimal(width), decimal(height)))
        .add(Title::new("Pattern at true scale"))
        .add(Description::new().add(Text::new(page.caption.as_str())))
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "#ffffff"))
        .add(pattern)
        .add(lines);
    format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{document}\n")
}

/// The pattern, from its own upper left corner.
fn artwork(page: &Page) -> Group {
    let [width, height] = page.pattern_mm;
    match &page.artwork {
        Artwork::Cells(cells) => {
            let scale = format!("scale({})", width / cells.width() as f64);
            let mut group = Group::new().set("transform", scale).set("shape-rendering", "crispEdges");
            for (y, row) in cells.rows().enumerate() {
                for (x, [red, green, blue]) in row.iter().enumerate() {
                    let fill = format!("#{red:02x}{green:02x}{blue:02x}");
                    group = group.add(Path::new().set("d", format!("M{x} {y}h1v1h-1z")).set("fill", fill));
                }
            }
            Group::new().add(group)
        }
        Artwork::Discs { discs, dark, bright } => {
            let area = || Rectangle::new().set("width", decimal(width)).set("height", decimal(height));
            let mut group = Group::new().set("fill", grey(*dark)).set("clip-path", "url(#area)");
            for disc in discs {
                let [x, y] = disc.centre_mm.map(decimal);
                group = group.add(Circle::new().set("cx", x).set("cy", y).set("r", decimal(disc.radius_mm)));
            }
            let clip = Definitions::new().add(ClipPath::new().set("id", "area").add(area()));
            Group::new().add(clip).add(area().set("fill", grey(*bright))).add(group)
        }
    }
}

fn grey(level: u8) -> String {
    format!("#{level:02x}{level:02x}{level:02x}")
}

/// A length to a nanometre.
fn decimal(mm: f64) -> Value {
    let text = format!("{mm:.6}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}
