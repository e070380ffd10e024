//! A report as one HTML file: headings, text, tables and pictures, self-contained.
//!
//! A [`Page`] is made of [`Section`]s, a section of [`Block`]s. Pictures are embedded as PNG, so that the file can be
//! sent, archived and opened anywhere; there is no script in it.

mod table;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use fingervision_image::Image;
use fingervision_sink::png;
use minijinja::{AutoEscape, Environment};
use serde::Serialize;

pub use table::{Cell, HtmlTable};

const TEMPLATE: &str = include_str!("page.html");

/// Narrower pictures are enlarged pixel by pixel.
const PIXELATED_BELOW: usize = 200;

/// A report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Page {
    /// Its name.
    pub title: String,
    /// A description in one or two sentences.
    pub lead: String,
    /// Its parts, in order.
    pub sections: Vec<Section>,
    /// The last line: the program and the inputs that it was made with.
    pub footer: String,
}

/// A part of a report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Section {
    /// The anchor for links, in lower case without spaces.
    pub anchor: String,
    /// Its heading.
    pub title: String,
    /// Its content.
    pub blocks: Vec<Block>,
}

/// A piece of a section.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Block {
    /// A paragraph.
    Text {
        /// Plain text.
        text: String,
    },
    /// A highlighted paragraph.
    Warning {
        /// Plain text.
        text: String,
    },
    /// A table with its caption.
    Table(HtmlTable),
    /// A picture with its caption.
    Picture(Picture),
    /// Small pictures side by side.
    Gallery {
        /// Number of pictures per row.
        columns: usize,
        /// From left to right.
        pictures: Vec<Picture>,
    },
}

/// A picture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Picture {
    /// A data URI.
    pub source: String,
    /// A description, plain text.
    pub caption: String,
    /// Whether it is shown pixel by pixel, without smoothing.
    pub is_pixelated: bool,
}

impl Section {
    /// A section without blocks.
    #[must_use]
    pub fn new(anchor: &str, title: impl Into<String>) -> Self {
        Self { anchor: anchor.into(), title: title.into(), blocks: Vec::new() }
    }

    /// Adds a paragraph.
    pub fn text(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Text { text: text.into() });
    }

    /// Adds a highlighted paragraph.
    pub fn warning(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Warning { text: text.into() });
    }

    /// Adds a table.
    pub fn table(&mut self, table: HtmlTable) {
        self.blocks.push(Block::Table(table));
    }

    /// Adds a picture.
    ///
    /// # Errors
    ///
    /// [`fingervision_sink::SinkError`] if it cannot be encoded.
    pub fn picture(
        &mut self,
        image: &Image<[u8; 3]>,
        caption: impl Into<String>,
    ) -> Result<(), fingervision_sink::SinkError> {
        let is_pixelated = image.width() < PIXELATED_BELOW;
        self.blocks.push(Block::Picture(Picture { source: embedded(image)?, caption: caption.into(), is_pixelated }));
        Ok(())
    }

    /// Adds pictures side by side, this many in a row.
    ///
    /// # Errors
    ///
    /// [`fingervision_sink::SinkError`] if one cannot be encoded.
    pub fn gallery<'a>(
        &mut self,
        columns: usize,
        pictures: impl IntoIterator<Item = (&'a Image<[u8; 3]>, String)>,
    ) -> Result<(), fingervision_sink::SinkError> {
        let picture = |(image, caption)| Ok(Picture { source: embedded(image)?, caption, is_pixelated: false });
        let pictures = pictures.into_iter().map(picture).collect::<Result<_, fingervision_sink::SinkError>>()?;
        self.blocks.push(Block::Gallery { columns, pictures });
        Ok(())
    }
}

impl Page {
    /// The whole file.
    ///
    /// # Panics
    ///
    /// Never: the template is part of the program, and a test renders every kind of block.
    #[must_use]
    pub fn html(&self) -> String {
        let mut environment = Environment::new();
        environment.set_auto_escape_callback(|_| AutoEscape::Html);
        environment.render_str(TEMPLATE, minijinja::value::Serde(self)).expect("the page's own template")
    }
}

/// An image as a data URI.
fn embedded(image: &Image<[u8; 3]>) -> Result<String, fingervision_sink::SinkError> {
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(png(image)?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_block_is_drawn_and_text_is_escaped() {
        let mut section = Section::new("depth", "Depth <of> a press");
        section.text("a & b");
        section.warning("it does not hold");
        let mut table = HtmlTable::new("Errors, mm", ["method", "mean"]);
        table.row("density", [Cell::figure(0.25, 3)]);
        table.row("none", [Cell::none()]);
        section.table(table);
        section.picture(&Image::filled(2, 2, [1, 2, 3]), "a picture").unwrap();
        let page = Page { title: "T".into(), lead: "L".into(), sections: vec![section], footer: "F".into() };
        let html = page.html();
        for part in
            ["Depth &lt;of&gt; a press", "a &amp; b", "it does not hold", "0.250", "—", "data:image/png;base64,"]
        {
            assert!(html.contains(part), "no {part} in\n{html}");
        }
        assert!(!html.contains("http"), "the page is self-contained");
    }
}
