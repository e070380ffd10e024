//! Residual maps, before and after.

use fingervision_image::Image;
use fingervision_plot::{HeatPanel, HeatPanels, HeatScale};

use super::report::CameraReport;

/// This part of a map lies within its scale.
const SHOWN_PART: f64 = 0.995;

impl CameraReport {
    /// Draws the residuals of every slide over the picture, before and after.
    #[must_use]
    pub fn draw(&self) -> Image<[u8; 3]> {
        let maps = self.maps();
        let table = self.residuals;
        let title = format!(
            "Camera from {} slides: residual {:.4} px before, {:.4} px after",
            maps.len(),
            table.before.mean_px,
            table.after.mean_px
        );
        let title = if maps.len() == 1 { title.replacen("1 slides", "a slide", 1) } else { title };
        let facts = format!(
            "Length of the difference between the camera's flow and the board's, px  ·  mean of {} fitted nodes  ·  {} kept for the test: {:.4} px",
            table.after.nodes, table.test.nodes, table.test.mean_px
        );
        let rows = maps.iter().zip(&self.slides).map(|(map, slide)| {
            let direction = format!("{:.0}°", slide.direction_deg);
            let limit_px = limit(&map.before_px);
            let panel = |values, heading: &str, limit_px, note: &str| HeatPanel {
                heading: format!("{heading}, slide along {direction}, px"),
                values,
                scale: HeatScale::from_zero(limit_px),
                note: note.into(),
            };
            vec![
                panel(&map.before_px, "Before", limit_px, "The plain camera: upright, no distortion."),
                panel(&map.after_px, "After", limit_px, "The fitted camera, on the same scale."),
                panel(&map.after_px, "After", limit(&map.after_px), "The fitted camera, on its own scale."),
            ]
        });
        let size = maps.first().map_or((1, 1), |map| map.size);
        HeatPanels { title: &title, facts: &facts, size, rows: rows.collect() }.draw()
    }
}

/// The length that nearly all residuals of a map do not exceed, px.
fn limit(map: &Image<f32>) -> f32 {
    let mut lengths: Vec<f32> = map.values().iter().copied().filter(|value| value.is_finite()).collect();
    lengths.sort_by(f32::total_cmp);
    lengths.get((SHOWN_PART * lengths.len() as f64) as usize).copied().unwrap_or(1.0)
}
