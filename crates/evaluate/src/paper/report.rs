//! The whole reproduction: its numbers and its page.

use std::fmt;

use serde::Serialize;

use super::{Assumptions, Extent, Indenters, LawFit, ReferenceErrors, Speed, TableOne};
use crate::page::{Page, Section};

/// Every number of the tables and figures, and their pages.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reproduction {
    /// How much was computed.
    pub extent: Extent,
    /// Figure 4.
    pub references: Vec<ReferenceErrors>,
    /// Figure 5, one entry per sensor.
    pub laws: Vec<LawFit>,
    /// The assumptions on which the pooled correlation of figure 5 depends.
    pub assumptions: Assumptions,
    /// Figures 6 and 7, one entry per sensor.
    pub indenters: Vec<Indenters>,
    /// Table I.
    pub table_one: TableOne,
    /// Frame rate.
    pub speed: Speed,
    #[serde(skip)]
    pub(super) sections: Vec<Section>,
}

impl Reproduction {
    /// The report as a page.
    #[must_use]
    pub fn page(&self) -> Page {
        let extent = match self.extent {
            Extent::Full => "",
            Extent::Quick => {
                " This is the quick version: one sensor, draft meshes, two indenters, half as many frames."
            }
        };
        Page {
            title: "Du et al. 2021, reproduced".into(),
            lead: format!(
                "Tables and figures of “High-Resolution 3-Dimensional Contact Deformation Tracking for FingerVision Sensor With Dense \
                 Random Color Pattern” (IEEE RA-L 2021, doi 10.1109/LRA.2021.3061306), from a simulated sensor with exact truth and open \
                 code.{extent}"
            ),
            sections: self.sections.clone(),
            footer: format!(
                "fingervision {}; every number is computed by fingervision reproduce",
                env!("CARGO_PKG_VERSION")
            ),
        }
    }
}

/// The main results, one per line.
impl fmt::Display for Reproduction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for law in &self.laws {
            let least = law.correlations.iter().map(|(_, r)| *r).fold(1.0, f64::min);
            writeln!(
                f,
                "density line  {}: each press r {least:.3} or above, pooled {:.3}, slopes differ by a factor of {:.1}",
                law.setting.name(),
                law.pooled,
                law.slope_factor
            )?;
        }
        for indenters in &self.indenters {
            for errors in &indenters.errors {
                writeln!(
                    f,
                    "depth error   {}, {}: dense {:.3} mm, dots {:.3} mm; negative depth set to 0 {:.3} and {:.3} mm; elastic {:.3} mm",
                    indenters.setting.name(),
                    errors.indenter,
                    errors.dense.everywhere_mm,
                    errors.dots.everywhere_mm,
                    errors.dense_clipped.everywhere_mm,
                    errors.dots_clipped.everywhere_mm,
                    errors.elastic.depth.everywhere_mm
                )?;
            }
        }
        let TableOne { before, after, test, from_truth_px } = &self.table_one;
        writeln!(
            f,
            "camera        residual {:.4} px before, {:.4} after, {:.4} on the test grid; {from_truth_px:.4} px from the truth",
            before.mean_px, after.mean_px, test.mean_px
        )?;
        writeln!(
            f,
            "speed         {:.1} ms per frame, {:.0} frames/s",
            self.speed.median_ms,
            1e3 / self.speed.median_ms
        )
    }
}
