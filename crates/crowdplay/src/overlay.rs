//! What stands over the picture: numbers, a graph of frame times, sliders, keys.

use crate::camera_control::{CameraControl, Mode};
use crate::memory::MEGABYTE;
use crate::stats;
use crowd_stages::gpu::SkinningChoice;
use crowd_stages::{BudgetIn, DrawOptions, Fit, FrameTotals, Levels, Skinning, Technique, View, Weight};
use egui::{Color32, RichText, Sense, Slider, Stroke, Ui, pos2, vec2};
use std::collections::VecDeque;

/// Frame times the graph shows.
pub const GRAPH_FRAMES: usize = 180;

/// What the user can change while it runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Knobs {
    /// Vertices, or triangles, a frame: N.
    pub budget: u32,
    /// What it counts.
    pub budget_in: BudgetIn,
    /// Percent of it that may be left over so that levels keep still.
    pub steady_percent: f32,
    /// The largest N there is room for.
    pub largest_budget: u32,
    /// Milliseconds that a frame may take; the budget follows.
    pub target_ms: Option<f32>,
    /// Exponent of the split.
    pub alpha: f32,
    /// Weight of an instance.
    pub weight: Weight,
    /// How the crowd is drawn.
    pub draw: DrawOptions,
    /// Pixels of error that should hold.
    pub max_px: Option<f32>,
    /// Height below which somebody is their impostor, pixels.
    pub impostors_px: f32,
    /// Height below which somebody may be dots, pixels.
    pub dots_px: f32,
    /// How far one sees in fog, metres; 0: no fog.
    pub sight_m: f32,
    /// People on their places go by their motion graph; `None`: there is none.
    pub motion: Option<bool>,
    /// It is known how fast clips are, so poses may be held.
    pub can_hold: bool,
    /// Time stands still.
    pub paused: bool,
    /// Seconds of the crowd a second of the clock.
    pub time_scale: f32,
    /// The overlay is shown.
    pub visible: bool,
    /// A second camera is shown in the corner.
    pub reference: bool,
    /// A picture is wanted.
    pub screenshot: bool,
}

impl Knobs {
    /// Whether the technique keeps a frame that a second camera can show.
    pub fn can_show_reference(&self) -> bool {
        !self.draw.occludes() && !matches!(self.draw.technique, Technique::PseudoInstancing | Technique::Discrete)
    }
}

/// What the overlay shows.
#[derive(Debug, Clone, Default)]
pub struct Readings {
    /// Adapter and backend.
    pub adapter: String,
    /// Instances.
    pub instances: u32,
    /// Triangles of all instances at full detail.
    pub triangles_full: u64,
    /// Newest finished frame.
    pub totals: FrameTotals,
    /// Milliseconds by stage of the newest finished frame.
    pub stages_ms: Vec<(&'static str, f32)>,
    /// Newest last, milliseconds.
    pub frame_ms: VecDeque<f32>,
    /// Bytes of GPU memory.
    pub gpu_bytes: u64,
    /// Most that may be taken, if somebody said.
    pub vram_bytes: Option<u64>,
    /// Seconds shown.
    pub time_s: f32,
    /// Where the GPU works out vertices.
    pub skinning: Option<SkinningChoice>,
    /// Last word to the user: a picture written, a failure.
    pub message: Option<String>,
}

impl Readings {
    /// Adds a frame time; the oldest goes.
    pub fn push_frame_ms(&mut self, ms: f32) {
        if self.frame_ms.len() == GRAPH_FRAMES {
            self.frame_ms.pop_front();
        }
        self.frame_ms.push_back(ms);
    }

    /// Frames a second over the last half second.
    pub fn fps(&self) -> f32 {
        let (mut frames, mut ms) = (0.0, 0.0);
        for frame_ms in self.frame_ms.iter().rev() {
            frames += 1.0;
            ms += frame_ms;
            if ms > 500.0 {
                break;
            }
        }
        if ms > 0.0 { 1e3 * frames / ms } else { 0.0 }
    }
}

/// Draws the overlay and lets it change the knobs.
pub fn show(ui: &mut Ui, knobs: &mut Knobs, readings: &Readings, control: &CameraControl) {
    if !knobs.visible {
        return;
    }
    let most_height = ui.ctx().content_rect().height() - 60.0;
    egui::Window::new("crowdplay").default_pos([8.0, 8.0]).auto_sized().show(ui.ctx(), |ui| {
        ui.set_width(280.0);
        egui::ScrollArea::vertical().max_height(most_height).show(ui, |ui| {
            compact(ui);
            everything(ui, knobs, readings, control);
        });
    });
}

fn everything(ui: &mut Ui, knobs: &mut Knobs, readings: &Readings, control: &CameraControl) {
    numbers(ui, knobs, readings);
    graph(ui, &readings.frame_ms);
    for line in stats::overflow_messages(&readings.totals, (knobs.budget, knobs.budget_in), knobs.max_px) {
        ui.label(RichText::new(line).color(Color32::from_rgb(255, 150, 90)));
    }
    ui.separator();
    sliders(ui, knobs, readings);
    if !readings.stages_ms.is_empty() {
        egui::CollapsingHeader::new("Times").default_open(true).show(ui, |ui| stages(ui, &readings.stages_ms));
    }
    egui::CollapsingHeader::new("Keys").default_open(true).show(ui, |ui| keys(ui, control));
    if let Some(message) = &readings.message {
        ui.label(RichText::new(message).color(Color32::from_rgb(150, 220, 150)));
    }
}

/// Small, so that it fits a low window and leaves the crowd in sight.
fn compact(ui: &mut Ui) {
    let style = ui.style_mut();
    for (text_style, size) in
        [(egui::TextStyle::Body, 11.5), (egui::TextStyle::Button, 11.5), (egui::TextStyle::Monospace, 11.0)]
    {
        if let Some(font) = style.text_styles.get_mut(&text_style) {
            font.size = size;
        }
    }
    style.spacing.item_spacing = vec2(6.0, 2.0);
    style.spacing.button_padding = vec2(4.0, 0.0);
    style.spacing.interact_size.y = 15.0;
}

fn numbers(ui: &mut Ui, knobs: &Knobs, readings: &Readings) {
    let totals = &readings.totals;
    let last_ms = readings.frame_ms.back().copied().unwrap_or(0.0);
    ui.label(RichText::new(format!("{:.0} fps   {last_ms:.1} ms", readings.fps())).strong().size(16.0));
    let row = |ui: &mut Ui, name: &str, value: String| {
        ui.label(name);
        ui.label(RichText::new(value).monospace());
        ui.end_row();
    };
    egui::Grid::new("numbers").num_columns(2).spacing([8.0, 0.0]).show(ui, |ui| {
        row(ui, "Instances", grouped(u64::from(readings.instances)));
        row(ui, "Visible", grouped(u64::from(totals.visible_count)));
        let culled = format!("{} outside", grouped(u64::from(totals.outside_count)));
        let hidden = format!("{culled}, {} hidden", grouped(u64::from(totals.occluded_count)));
        row(ui, "Left out", if knobs.draw.occludes() { hidden } else { culled });
        let share = 100.0 * f64::from(totals.triangle_count) / readings.triangles_full.max(1) as f64;
        let triangles = grouped(u64::from(totals.triangle_count));
        row(ui, "Triangles", format!("{triangles} of {} ({share:.1} %)", grouped(readings.triangles_full)));
        let in_triangles = knobs.budget_in == BudgetIn::Triangles;
        let counted = if in_triangles { totals.triangle_count } else { totals.vertex_count };
        let used = 100.0 * f64::from(counted) / f64::from(knobs.budget.max(1));
        let plain = 100.0 * f64::from(totals.wanted_count) / f64::from(knobs.budget.max(1));
        let vertices = grouped(u64::from(totals.vertex_count));
        row(
            ui,
            "Vertices",
            match knobs.draw.technique.has_budget() {
                true if in_triangles => format!("{vertices}; triangles {used:.1} % of N"),
                true => format!("{vertices} of N ({used:.1} %, Eq. 1 alone {plain:.1} %)"),
                false => format!("{vertices}, no budget"),
            },
        );
        if totals.threshold_px > 0.0 {
            row(ui, "Error", format!("{:.2} px at most", totals.threshold_px));
        }
        row(ui, "Draws", grouped(u64::from(totals.draw_count)));
        if readings.gpu_bytes > 0 {
            let taken = format!("{:.1} MB", readings.gpu_bytes as f64 / MEGABYTE as f64);
            let of = readings.vram_bytes.map(|most| format!(" of {:.1}", most as f64 / MEGABYTE as f64));
            row(ui, "GPU memory", taken + &of.unwrap_or_default());
        }
        row(ui, "Drawn by", readings.adapter.clone());
    });
}

/// Bars of the last frames; lines at 60 and 30 frames a second.
fn graph(ui: &mut Ui, frame_ms: &VecDeque<f32>) {
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

fn sliders(ui: &mut Ui, knobs: &mut Knobs, readings: &Readings) {
    if let Some(motion) = &mut knobs.motion {
        ui.checkbox(motion, "people change what they do").on_hover_text(
            "They go by the motion graph (--motion-graph) and fade from clip to clip; else everyone keeps one",
        );
    }
    if knobs.can_hold {
        ui.checkbox(&mut knobs.draw.holds_poses, "hold poses of far ones")
            .on_hover_text("Poses change 50 times a second nearby and 4 times far away (--pose-rates)");
        ui.checkbox(&mut knobs.draw.share_poses, "share them").on_hover_text(
            "Each held pose is worked out once for all who are in it, with --skinning palettes or compute",
        );
    }
    ui.checkbox(&mut knobs.draw.frozen, "freeze culling and levels (F)")
        .on_hover_text("Who is drawn and at which levels stays; go around and look at it");
    let largest = knobs.largest_budget.max(1_001);
    ui.add(Slider::new(&mut knobs.budget, 1_000..=largest).logarithmic(true).text("budget N"));
    ui.horizontal(|ui| {
        let mut holds = knobs.target_ms.is_some();
        ui.checkbox(&mut holds, "hold");
        let mut target_ms = knobs.target_ms.unwrap_or(16.0);
        ui.add_enabled(holds, Slider::new(&mut target_ms, 1.0..=200.0).logarithmic(true).text("ms a frame"));
        knobs.target_ms = holds.then_some(target_ms);
    });
    ui.add(Slider::new(&mut knobs.alpha, 1.0..=8.0).text("alpha"));
    ui.horizontal(|ui| {
        ui.label("Weight");
        ui.selectable_value(&mut knobs.weight, Weight::Area, "area");
        ui.selectable_value(&mut knobs.weight, Weight::AreaDistance, "area, distance");
        ui.selectable_value(&mut knobs.weight, Weight::Error, "error");
    });
    ui.horizontal_wrapped(|ui| {
        ui.label("Technique");
        for technique in Technique::ALL {
            ui.selectable_value(&mut knobs.draw.technique, technique, technique.name())
                .on_hover_text(technique.describe());
        }
    });
    if knobs.draw.technique.has_budget() {
        ui.horizontal(|ui| {
            ui.label("Budget");
            ui.selectable_value(&mut knobs.draw.fit, Fit::Fill, "filled");
            ui.selectable_value(&mut knobs.draw.fit, Fit::Plain, "Eq. 1 as printed");
        });
        ui.horizontal(|ui| {
            // With --vram what fits was found for the one that was asked for.
            if readings.vram_bytes.is_some() {
                ui.disable();
            }
            ui.label("N counts");
            ui.selectable_value(&mut knobs.budget_in, BudgetIn::Vertices, "vertices");
            ui.selectable_value(&mut knobs.budget_in, BudgetIn::Triangles, "triangles");
        });
        ui.add(Slider::new(&mut knobs.steady_percent, 0.0..=10.0).text("% left over so that levels keep still"));
    }
    if knobs.draw.technique == Technique::Bucketed && knobs.draw.fit == Fit::Fill {
        ui.horizontal(|ui| {
            ui.label("Between levels");
            ui.selectable_value(&mut knobs.draw.no_morph, false, "move");
            ui.selectable_value(&mut knobs.draw.no_morph, true, "jump");
        });
        ui.add(Slider::new(&mut knobs.dots_px, 0.0..=64.0).text("dots below px"));
        ui.add(Slider::new(&mut knobs.impostors_px, 0.0..=64.0).text("impostors below px"))
            .on_hover_text("Where the pack has them (crowdbake bake --impostors)");
    }
    if let Some(choice) = readings.skinning.as_ref().filter(|_| knobs.draw.technique == Technique::Bucketed) {
        ui.horizontal(|ui| {
            ui.label("Skinning");
            for way in [Skinning::Auto].into_iter().chain(Skinning::WAYS) {
                ui.selectable_value(&mut knobs.draw.skinning, way, way.name());
            }
        });
        ui.label(stats::skinning_words(choice).unwrap_or_else(|| format!("now: {}", choice.way.name())));
    }
    if knobs.draw.technique == Technique::Bucketed && knobs.draw.fit == Fit::Fill {
        ui.checkbox(&mut knobs.draw.occlusion, "leave out whom others hide (O)")
            .on_hover_text("Two-phase occlusion culling: who was in sight first, then who comes into it");
    }
    ui.horizontal_wrapped(|ui| {
        ui.label("View");
        for view in View::ALL {
            let can_show = DrawOptions { view, ..knobs.draw }.shown_view() == view;
            ui.add_enabled_ui(can_show, |ui| ui.selectable_value(&mut knobs.draw.view, view, view.name()));
        }
    });
    ui.add_enabled(knobs.can_show_reference(), egui::Checkbox::new(&mut knobs.reference, "reference camera (C)"))
        .on_hover_text("All of the crowd from outside, with this camera's frustum; who is culled is a dot")
        .on_disabled_hover_text("Not with occlusion culling, pseudo-instancing or discrete levels");
    ui.horizontal(|ui| {
        ui.label("Shadow maps");
        for maps in 0..=4 {
            let word = if maps == 0 { "none".to_owned() } else { maps.to_string() };
            ui.selectable_value(&mut knobs.draw.shadows, maps, word);
        }
    });
    let sight = Slider::new(&mut knobs.sight_m, 0.0..=1000.0).clamping(egui::SliderClamping::Edits);
    ui.add(sight.text("sight in fog, m"))
        .on_hover_text("Metres after which a twentieth is left of what is seen; 0: no fog");
    if knobs.draw.technique == Technique::Reform {
        ui.horizontal(|ui| {
            ui.label("Levels");
            ui.selectable_value(&mut knobs.draw.levels, Levels::Continuous, "all");
            ui.selectable_value(&mut knobs.draw.levels, Levels::Quantized, "those with tables");
        });
    }
    ui.horizontal(|ui| {
        ui.checkbox(&mut knobs.paused, "pause");
        ui.add(Slider::new(&mut knobs.time_scale, 0.0..=4.0).text("time scale"));
    });
    if ui.button("Save picture").clicked() {
        knobs.screenshot = true;
    }
}

fn stages(ui: &mut Ui, stages_ms: &[(&'static str, f32)]) {
    egui::Grid::new("stages").num_columns(2).spacing([8.0, 0.0]).show(ui, |ui| {
        for (stage, ms) in stages_ms {
            ui.label(stage.replace('_', " "));
            ui.label(RichText::new(format!("{ms:8.3} ms")).monospace());
            ui.end_row();
        }
    });
}

fn keys(ui: &mut Ui, control: &CameraControl) {
    let mode = match control.mode {
        Mode::Orbit => "orbit".to_owned(),
        Mode::Fly => format!("fly, {:.1} m/s", control.speed_m_s()),
    };
    let rows = [
        ("Tab", format!("orbit or fly (now {mode})")),
        ("Drag", "turn; with the other buttons shift".to_owned()),
        ("Wheel", "closer; in flight faster".to_owned()),
        ("W A S D Q E", "move, Shift fast".to_owned()),
        ("Space", "pause".to_owned()),
        ("O", "occlusion culling".to_owned()),
        ("F", "freeze culling and levels".to_owned()),
        ("C", "reference camera".to_owned()),
        ("R", "first view".to_owned()),
        ("P", "save picture".to_owned()),
        ("F1", "hide this".to_owned()),
        ("Esc", "leave".to_owned()),
    ];
    egui::Grid::new("keys").num_columns(2).spacing([8.0, 0.0]).show(ui, |ui| {
        for (key, meaning) in rows {
            ui.label(RichText::new(key).monospace().size(10.0));
            ui.label(RichText::new(meaning).size(10.5));
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

    #[test]
    fn numbers_are_grouped() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_000), "1,000");
        assert_eq!(grouped(1_234_567), "1,234,567");
    }

    #[test]
    fn fps_counts_the_last_half_second() {
        let mut readings = Readings::default();
        assert_eq!(readings.fps(), 0.0);
        for _ in 0..100 {
            readings.push_frame_ms(1000.0);
        }
        for _ in 0..60 {
            readings.push_frame_ms(10.0);
        }
        assert!((readings.fps() - 100.0).abs() < 1.0);
        for _ in 0..500 {
            readings.push_frame_ms(5.0);
        }
        assert_eq!(readings.frame_ms.len(), GRAPH_FRAMES);
    }
}
