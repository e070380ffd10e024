//! The benchmark as a page.

use super::report::percent;
use super::{BenchmarkReport, Method, MethodMeans, MethodScore};
use crate::page::{Cell, HtmlTable, Page, Section};

const DECIMALS: usize = 3;

impl BenchmarkReport {
    /// The table of means, then every case.
    #[must_use]
    pub fn page(&self) -> Page {
        let mut sections = vec![self.methods_section()];
        for variation in &self.variations {
            let mut section = Section::new(variation.name, format!("{}: {}", variation.name, variation.about));
            section.table(self.means_table(variation.name));
            section.table(self.contact_table(variation.name));
            section.table(self.cases_table(variation.name, "Mean absolute error over the whole image, mm", |score| {
                score.score.everywhere_mm
            }));
            section.table(self.cases_table(variation.name, "Inside contact, mm", |score| score.score.inside_mm));
            section.table(
                self.cases_table(variation.name, "Within 1 mm of the contact's border, mm", |score| {
                    score.score.border_mm
                }),
            );
            sections.push(section);
        }
        Page {
            title: "Depth against exact truth".into(),
            lead: format!(
                "{} simulated presses, images rendered and tracked; errors of depth in the last frame, over every pixel \
                 that is seen, trusted or not.",
                self.cases.len()
            ),
            sections,
            footer: format!("fingervision {}", env!("CARGO_PKG_VERSION")),
        }
    }

    fn methods_section(&self) -> Section {
        let mut section = Section::new("methods", "Methods");
        section.text(
            "Every method that needs calibration had the nine calibration presses of its own sensor: squares of 1, 2 and 3 mm \
             at the centre, midway and near a corner, tracked from images, sticking contact.",
        );
        let mut table = HtmlTable::new("The methods", ["method", "description"]);
        for name in self.methods() {
            let known = Method::ALL.into_iter().find(|method| method.name() == name);
            table.row(name, [Cell::text(known.map_or("another program's depth.npy", Method::about))]);
        }
        section.table(table);
        if !self.assignments.is_empty() {
            let mut table =
                HtmlTable::new("Values of the tracker that differ from the simulated sensor", ["key", "value"]);
            self.assignments.iter().for_each(|(key, value)| table.row(key.as_str(), [Cell::text(value.as_str())]));
            section.table(table);
        }
        if !self.unsolved.is_empty() {
            section
                .text(format!("Presses that were not solved to their end are left out: {}.", self.unsolved.join("; ")));
        }
        section
    }

    fn means_table(&self, variation: &str) -> HtmlTable {
        let mut table = HtmlTable::new(
            "Mean absolute error over the scenes, mm",
            ["method", "everywhere", "inside", "near border", "outside", "worst inside", "worse than depth 0"],
        );
        let rows: Vec<&MethodMeans> = self.means.iter().filter(|means| means.variation == variation).collect();
        let figures = |means: &MethodMeans| {
            [means.everywhere_mm, means.inside_mm, means.border_mm, means.outside_mm, means.worst_inside_mm]
        };
        let least = |column: usize| rows.iter().map(|means| figures(means)[column]).fold(f64::INFINITY, f64::min);
        for means in &rows {
            let cells = figures(means)
                .into_iter()
                .enumerate()
                .map(|(column, figure)| Cell { is_best: figure <= least(column), ..Cell::figure(figure, DECIMALS) });
            let worse = Cell::text(format!("{} of {}", means.worse_than_nothing, means.cases));
            table.row(means.method.as_str(), cells.chain([worse]));
        }
        table
    }

    /// Contact and force of the methods that estimate them.
    fn contact_table(&self, variation: &str) -> HtmlTable {
        let mut table = HtmlTable::new(
            "Contact and force, means over the scenes: overlap of contact, and errors as parts of the true value",
            ["method", "contact overlap", "normal force", "shear force", "torque"],
        );
        let means = self.means.iter().filter(|means| means.variation == variation && means.contact_overlap.is_some());
        for means in means {
            table.row(means.method.as_str(), means.contact_and_force().map(|part| Cell::text(percent(part))));
        }
        table
    }

    fn cases_table(&self, variation: &str, caption: &str, figure: impl Fn(&MethodScore) -> f64) -> HtmlTable {
        let methods = self.methods();
        let mut table = HtmlTable::new(caption, ["scene"].into_iter().chain(methods.iter().copied()));
        for case in self.cases.iter().filter(|case| case.variation == variation) {
            let figures: Vec<f64> = methods
                .iter()
                .map(|name| case.scores.iter().find(|score| score.method == *name).map_or(f64::NAN, &figure))
                .collect();
            let least = figures.iter().copied().fold(f64::INFINITY, f64::min);
            let cells = figures.iter().map(|&value| Cell { is_best: value <= least, ..Cell::figure(value, DECIMALS) });
            table.row(case.scene, cells.collect::<Vec<_>>());
        }
        table
    }
}
