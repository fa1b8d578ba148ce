//! The numbers of the overlay: what the frame came to, the graph of frame times, times by stage.

use super::{GRAPH_FRAMES, Knobs, Readings};
use crate::memory::MEGABYTE;
use crowd_stages::{BudgetIn, Fit};
use egui::{Color32, RichText, Sense, Stroke, Ui, pos2, vec2};
use std::collections::VecDeque;

/// Frames a second, and what the newest frame came to.
pub(super) fn numbers(ui: &mut Ui, knobs: &Knobs, readings: &Readings) {
    let totals = &readings.totals;
    let last_ms = readings.frame_ms.back().copied().unwrap_or(0.0);
    ui.label(RichText::new(format!("{:.0} fps   {last_ms:.1} ms", readings.fps())).strong().size(16.0));
    egui::Grid::new("numbers").num_columns(2).spacing([8.0, 0.0]).show(ui, |ui| {
        row(ui, "Instances", grouped(u64::from(readings.instances)));
        row(ui, "Visible", grouped(u64::from(totals.visible_count)));
        row(ui, "Left out", left_out(knobs, readings));
        for (name, value) in budget_rows(knobs, readings) {
            row(ui, name, value);
        }
        let share = 100.0 * f64::from(totals.triangle_count) / readings.triangles_full.max(1) as f64;
        let triangles = grouped(u64::from(totals.triangle_count));
        row(ui, "Triangles", format!("{triangles} of {} ({share:.1} %)", grouped(readings.triangles_full)));
        row(ui, "Vertices", grouped(u64::from(totals.vertex_count)));
        if let Some(runs) = readings.vertex_runs {
            row(ui, "Vertex runs", format!("{} of the shader", grouped(runs)));
        }
        row(ui, "Draws", grouped(u64::from(totals.draw_count)));
        if readings.gpu_bytes > 0 {
            let taken = format!("{:.1} MB", readings.gpu_bytes as f64 / MEGABYTE as f64);
            let of = readings.vram_bytes.map(|most| format!(" of {:.1}", most as f64 / MEGABYTE as f64));
            row(ui, "GPU memory", taken + &of.unwrap_or_default());
        }
        ui.label("Drawn by");
        ui.add(egui::Label::new(RichText::new(&readings.adapter).monospace()).truncate());
        ui.end_row();
    });
}

fn row(ui: &mut Ui, name: &str, value: String) {
    ui.label(name);
    ui.label(RichText::new(value).monospace());
    ui.end_row();
}

fn left_out(knobs: &Knobs, readings: &Readings) -> String {
    let totals = &readings.totals;
    let mut words = format!("{} outside", grouped(u64::from(totals.outside_count)));
    if knobs.draw.occludes() {
        words += &format!(", {} hidden", grouped(u64::from(totals.occluded_count)));
    }
    if totals.refused_count > 0 {
        words += &format!(", {} refused", grouped(u64::from(totals.refused_count)));
    }
    words
}

/// What the budget was used for: what it counts, how much of it, and what Eq. 1 as printed or the error come to.
fn budget_rows(knobs: &Knobs, readings: &Readings) -> Vec<(&'static str, String)> {
    let totals = &readings.totals;
    if !knobs.draw.technique.has_budget() {
        return vec![("Budget", "none".to_owned())];
    }
    let budget_in = knobs.counts();
    let counted = if budget_in == BudgetIn::Triangles { totals.triangle_count } else { totals.vertex_count };
    let percent = |count: u32| 100.0 * f64::from(count) / f64::from(knobs.budget.max(1));
    let (of, used) = (grouped(u64::from(knobs.budget)), percent(counted));
    let mut rows = vec![("Budget", format!("{used:.1} % of {of} {}", budget_in.name()))];
    if totals.wanted_count > 0 {
        // Filled up it is what the papers' way would have used; as printed it is what was asked for before that was made to fit.
        let what = if knobs.draw.fit == Fit::Fill { "would use" } else { "asked for" };
        rows.push(("Eq. 1", format!("{what} {:.1} %", percent(totals.wanted_count))));
    }
    if totals.threshold_px > 0.0 {
        rows.push(("Error", format!("{:.2} px at most", totals.threshold_px)));
    }
    rows
}

/// Bars of the last frames; lines at 60 and 30 frames a second.
pub(super) fn graph(ui: &mut Ui, frame_ms: &VecDeque<f32>) {
    let (area, _) = ui.allocate_exact_size(vec2(ui.available_width().max(260.0), 44.0), Sense::hover());
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(120));
    let longest = frame_ms.iter().copied().fold(20.0, f32::max) * 1.1;
    let y_of = |ms: f32| area.bottom() - area.height() * (ms / longest).min(1.0);
    let bar = area.width() / GRAPH_FRAMES as f32;
    for (i, &ms) in frame_ms.iter().enumerate() {
        let x = area.left() + bar * (i as f32 + 0.5);
        let color = match ms {
            ms if ms <= 17.5 => Color32::from_rgb(110, 200, 120),
            ms if ms <= 34.0 => Color32::from_rgb(220, 200, 90),
            _ => Color32::from_rgb(230, 120, 80),
        };
        painter.line_segment([pos2(x, area.bottom()), pos2(x, y_of(ms))], Stroke::new(bar.max(1.0), color));
    }
    for (ms, name) in [(1e3 / 60.0, "60"), (1e3 / 30.0, "30")] {
        // Of slow frames the lines would lie on each other at the bottom.
        if (0.25..1.0).contains(&(ms / longest)) {
            let line = Stroke::new(1.0, Color32::from_white_alpha(90));
            painter.line_segment([pos2(area.left(), y_of(ms)), pos2(area.right(), y_of(ms))], line);
            let at = pos2(area.right() - 2.0, y_of(ms));
            let font = egui::FontId::proportional(10.0);
            painter.text(at, egui::Align2::RIGHT_BOTTOM, name, font, Color32::from_white_alpha(160));
        }
    }
}

/// Milliseconds by stage, and their sum.
pub(super) fn stages(ui: &mut Ui, stages_ms: &[(&'static str, f32)]) {
    let sum: f32 = stages_ms.iter().map(|(_, ms)| ms).sum();
    egui::Grid::new("stages").num_columns(2).spacing([8.0, 0.0]).show(ui, |ui| {
        for (stage, ms) in stages_ms.iter().copied().chain([("all", sum)]) {
            ui.label(stage.replace('_', " "));
            ui.label(RichText::new(format!("{ms:9.3} ms")).monospace());
            ui.end_row();
        }
    });
}

/// 1234567 as 1,234,567.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_stages::{FrameTotals, Technique};

    #[test]
    fn numbers_are_grouped() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_000), "1,000");
        assert_eq!(grouped(1_234_567), "1,234,567");
    }

    #[test]
    fn a_budget_says_what_it_counts_and_what_of_it_was_used() {
        let totals = FrameTotals { vertex_count: 900, triangle_count: 400, wanted_count: 700, ..Default::default() };
        let readings = Readings { totals, ..Readings::default() };
        let mut knobs = Knobs { budget: 1_000, ..Knobs::default() };
        let words =
            |knobs: &Knobs| budget_rows(knobs, &readings).into_iter().map(|(_, words)| words).collect::<Vec<_>>();
        assert_eq!(words(&knobs), ["90.0 % of 1,000 vertices", "would use 70.0 %"]);
        knobs.budget_in = BudgetIn::Triangles;
        assert_eq!(words(&knobs)[0], "40.0 % of 1,000 triangles");
        // Eq. 1 as printed knows vertices alone.
        knobs.draw.fit = Fit::Plain;
        assert_eq!(words(&knobs), ["90.0 % of 1,000 vertices", "asked for 70.0 %"]);
        knobs.draw.technique = Technique::Instanced;
        assert_eq!(words(&knobs), ["none"]);
    }
}
