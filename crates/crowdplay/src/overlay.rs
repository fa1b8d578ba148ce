//! What stands over the picture: numbers and controls on the left, times by stage and keys on the right.

mod controls;
mod numbers;

use crate::camera_control::{CameraControl, Mode};
use crate::stats;
use crowd_stages::gpu::SkinningChoice;
use crowd_stages::{BudgetIn, DrawOptions, Fit, FrameTotals, Technique, Weight};
use egui::{Align2, Color32, RichText, ScrollArea, Ui, vec2};
use std::collections::VecDeque;

/// Frame times the graph shows.
pub const GRAPH_FRAMES: usize = 180;

/// Width of what stands on the left, points.
const LEFT_WIDTH: f32 = 316.0;
/// Width of what stands on the right, points.
const RIGHT_WIDTH: f32 = 204.0;
/// Bar and margins of a panel, points.
const FRAME_HEIGHT: f32 = 60.0;

/// A picture to be saved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shot {
    /// The crowd alone.
    Crowd,
    /// All that the window shows.
    Window,
}

/// What the user can change while it runs.
#[derive(Debug, Clone, PartialEq, Default)]
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
    pub shot: Option<Shot>,
}

impl Knobs {
    /// Whether the budget is filled up, by water or by error; Eq. 1 as printed does not.
    pub fn has_water(&self) -> bool {
        self.draw.fit == Fit::Fill || self.weight == Weight::Error
    }

    /// What the budget counts in fact: Eq. 1 as printed knows vertices alone.
    pub fn counts(&self) -> BudgetIn {
        if self.has_water() { self.budget_in } else { BudgetIn::Vertices }
    }

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
    /// A GPU draws, or software that plays one.
    pub on_gpu: bool,
    /// The pack has impostors.
    pub has_impostors: bool,
    /// Instances.
    pub instances: u32,
    /// Triangles of all instances at full detail.
    pub triangles_full: u64,
    /// Newest finished frame.
    pub totals: FrameTotals,
    /// Runs of the vertex shader over the crowd in it, where the adapter counts them.
    pub vertex_runs: Option<u64>,
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
    let room = ui.ctx().content_rect().size();
    let has_right = room.x >= LEFT_WIDTH + RIGHT_WIDTH + 80.0;
    panel("crowdplay", Align2::LEFT_TOP, 8.0).show(ui.ctx(), |ui| {
        scrolled(ui, LEFT_WIDTH, room.y, |ui| {
            numbers::numbers(ui, knobs, readings);
            numbers::graph(ui, &readings.frame_ms);
            for line in stats::overflow_messages(&readings.totals, (knobs.budget, knobs.counts()), knobs.max_px) {
                ui.label(RichText::new(line).color(Color32::from_rgb(255, 150, 90)));
            }
            if let Some(message) = &readings.message {
                ui.label(RichText::new(message).color(Color32::from_rgb(150, 220, 150)));
            }
            section(ui, "Level of detail", |ui| controls::levels_of_detail(ui, knobs, readings));
            section(ui, "Drawing", |ui| controls::drawing(ui, knobs, readings));
            section(ui, "Looking", |ui| controls::looking(ui, knobs, readings));
            if !has_right {
                times_and_keys(ui, readings, control);
            }
        });
    });
    if has_right {
        panel("times and keys", Align2::RIGHT_TOP, -8.0).show(ui.ctx(), |ui| {
            // The lower third is the reference camera's.
            scrolled(ui, RIGHT_WIDTH, room.y * if knobs.reference { 0.66 } else { 1.0 }, |ui| {
                times_and_keys(ui, readings, control);
            });
        });
    }
}

fn panel(title: &'static str, corner: Align2, margin: f32) -> egui::Window<'static> {
    egui::Window::new(title).anchor(corner, [margin, 8.0]).auto_sized()
}

/// Small, and scrolled where the window is low, so that it leaves the crowd in sight.
fn scrolled(ui: &mut Ui, width: f32, room_height: f32, show: impl FnOnce(&mut Ui)) {
    ui.set_width(width);
    // Without the least height it would stay as low as the lowest window so far.
    let height = (room_height - FRAME_HEIGHT).max(40.0);
    ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
        compact(ui);
        show(ui);
    });
}

fn section(ui: &mut Ui, title: &str, show: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(title).default_open(true).show_unindented(ui, show);
}

fn times_and_keys(ui: &mut Ui, readings: &Readings, control: &CameraControl) {
    if !readings.stages_ms.is_empty() {
        section(ui, "Times", |ui| numbers::stages(ui, &readings.stages_ms));
    }
    section(ui, "Keys", |ui| keys(ui, control));
}

/// Small letters in close rows.
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

fn keys(ui: &mut Ui, control: &CameraControl) {
    let mode = match control.mode {
        Mode::Orbit => "orbit".to_owned(),
        Mode::Fly => format!("fly, {:.1} m/s", control.speed_m_s()),
    };
    let rows = [
        ("Tab", format!("orbit or fly ({mode})")),
        ("Drag", "turn; other buttons shift".to_owned()),
        ("Wheel", "closer; in flight faster".to_owned()),
        ("W A S D Q E", "move, Shift fast".to_owned()),
        ("Space", "pause".to_owned()),
        ("O", "occlusion culling".to_owned()),
        ("F", "freeze culling and levels".to_owned()),
        ("C", "reference camera".to_owned()),
        ("V", "next view".to_owned()),
        ("R", "first view".to_owned()),
        ("P", "save picture of the crowd".to_owned()),
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

#[cfg(test)]
mod tests {
    use super::*;

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

    /// Lays the overlay out in a window of a size, twice as egui needs to know sizes.
    fn shown(size: [f32; 2], knobs: &mut Knobs) -> (egui::Context, egui::FullOutput) {
        let egui = egui::Context::default();
        let control = CameraControl::new(crowd_scene::Camera::orbit(glam::Vec3::Y, 10.0, 0.0, 0.2));
        let stages_ms = vec![("cull_instances", 0.5), ("draw", 9.0)];
        let readings = Readings { stages_ms, on_gpu: true, ..Readings::default() };
        let input = || egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size.into())),
            ..Default::default()
        };
        let _ = egui.run_ui(input(), |ui| show(ui, knobs, &readings, &control));
        let output = egui.run_ui(input(), |ui| show(ui, knobs, &readings, &control));
        (egui, output)
    }

    #[test]
    fn a_look_at_the_overlay_changes_no_knob() {
        for technique in Technique::ALL {
            for fit in [Fit::Fill, Fit::Plain] {
                let draw = DrawOptions { fit, ..technique.into() };
                // Outside of what the sliders offer, as words may ask for.
                let mut knobs = Knobs { budget: 500, largest_budget: 100, alpha: 30.0, draw, ..Knobs::default() };
                knobs = Knobs { visible: true, target_ms: Some(0.5), sight_m: 5e3, steady_percent: 40.0, ..knobs };
                let before = knobs.clone();
                let _ = shown([1280.0, 720.0], &mut knobs);
                assert_eq!(knobs, before, "{technique} {fit:?}");
            }
        }
    }

    #[test]
    fn a_window_of_any_size_has_an_overlay() {
        let mut knobs = Knobs { visible: true, ..Knobs::default() };
        for size in [[1.0, 1.0], [300.0, 200.0], [700.0, 400.0], [4000.0, 3000.0]] {
            let (_, output) = shown(size, &mut knobs);
            assert!(!output.shapes.is_empty(), "{size:?}");
        }
        knobs.visible = false;
        assert!(shown([1280.0, 720.0], &mut knobs).1.shapes.is_empty());
    }
}
