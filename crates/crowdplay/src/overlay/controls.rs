//! What of the overlay can be changed, in three parts: levels of detail, how the crowd is drawn, what is looked at.

use super::{Knobs, Readings, Shot};
use crate::stats;
use crowd_stages::{BudgetIn, DrawOptions, Fit, Levels, Skinning, Technique, View, Weight};
use egui::{Slider, SliderClamping, Ui};

/// The budget, and what it is split by.
pub(super) fn levels_of_detail(ui: &mut Ui, knobs: &mut Knobs, readings: &Readings) {
    if knobs.draw.technique.has_budget() {
        budget(ui, knobs, readings);
    } else {
        ui.label("This technique has no budget.");
    }
    if knobs.draw.has_dots() {
        ui.horizontal(|ui| {
            ui.label("Between levels");
            ui.selectable_value(&mut knobs.draw.no_morph, false, "move");
            ui.selectable_value(&mut knobs.draw.no_morph, true, "jump");
        });
        if knobs.weight != Weight::Error {
            ui.add(Slider::new(&mut knobs.dots_px, 0.0..=64.0).text("dots below px"));
            if readings.has_impostors {
                ui.add(Slider::new(&mut knobs.impostors_px, 0.0..=64.0).text("impostors below px"));
            }
        }
    }
    if knobs.draw.technique == Technique::Reform {
        ui.horizontal(|ui| {
            ui.label("Levels");
            ui.selectable_value(&mut knobs.draw.levels, Levels::Continuous, "all");
            ui.selectable_value(&mut knobs.draw.levels, Levels::Quantized, "those with tables");
        });
    }
}

fn budget(ui: &mut Ui, knobs: &mut Knobs, readings: &Readings) {
    let largest = knobs.largest_budget.max(1_001);
    let budget = Slider::new(&mut knobs.budget, 1_000..=largest).logarithmic(true);
    ui.add(budget.clamping(SliderClamping::Edits).text("budget N"));
    ui.horizontal(|ui| {
        let mut holds = knobs.target_ms.is_some();
        ui.checkbox(&mut holds, "hold").on_hover_text("N falls and rises to hold a frame's time");
        let mut target_ms = knobs.target_ms.unwrap_or(16.0);
        let slider = Slider::new(&mut target_ms, 1.0..=200.0).logarithmic(true).clamping(SliderClamping::Edits);
        ui.add_enabled(holds, slider.text("ms a frame"));
        knobs.target_ms = holds.then_some(target_ms);
    });
    ui.horizontal(|ui| {
        ui.label("Split by");
        ui.selectable_value(&mut knobs.weight, Weight::Area, "area");
        ui.selectable_value(&mut knobs.weight, Weight::AreaDistance, "area, distance");
        ui.selectable_value(&mut knobs.weight, Weight::Error, "error");
    });
    if knobs.weight == Weight::Error {
        ui.horizontal(|ui| {
            let mut is_bound = knobs.max_px.is_some();
            ui.checkbox(&mut is_bound, "warn above").on_hover_text("Where the budget cannot hold so few pixels");
            let mut max_px = knobs.max_px.unwrap_or(1.0);
            let slider = Slider::new(&mut max_px, 0.1..=20.0).logarithmic(true).clamping(SliderClamping::Edits);
            ui.add_enabled(is_bound, slider.text("px of error"));
            knobs.max_px = is_bound.then_some(max_px);
        });
    } else {
        // With distances the exponent is divided by itself less one.
        let least = if knobs.weight == Weight::AreaDistance { 1.05 } else { 1.0 };
        knobs.alpha = knobs.alpha.max(least);
        ui.add(Slider::new(&mut knobs.alpha, least..=8.0).clamping(SliderClamping::Edits).text("alpha"));
        ui.horizontal(|ui| {
            ui.label("Budget");
            ui.selectable_value(&mut knobs.draw.fit, Fit::Fill, "filled");
            ui.selectable_value(&mut knobs.draw.fit, Fit::Plain, "Eq. 1 as printed");
        });
    }
    if !knobs.has_water() {
        return;
    }
    ui.horizontal(|ui| {
        // With --vram what fits was found for the one that was asked for.
        if readings.vram_bytes.is_some() {
            ui.disable();
        }
        ui.label("N counts");
        ui.selectable_value(&mut knobs.budget_in, BudgetIn::Vertices, "vertices");
        ui.selectable_value(&mut knobs.budget_in, BudgetIn::Triangles, "triangles");
    });
    let steady = Slider::new(&mut knobs.steady_percent, 0.0..=10.0).clamping(SliderClamping::Edits);
    ui.add(steady.text("% left so that levels keep still"));
}

/// How the crowd is drawn, and how it moves.
pub(super) fn drawing(ui: &mut Ui, knobs: &mut Knobs, readings: &Readings) {
    ui.horizontal_wrapped(|ui| {
        ui.label("Technique");
        for technique in Technique::ALL {
            ui.selectable_value(&mut knobs.draw.technique, technique, technique.name())
                .on_hover_text(technique.describe());
        }
    });
    if let Some(choice) = readings.skinning.as_ref().filter(|_| knobs.draw.technique == Technique::Bucketed) {
        ui.horizontal(|ui| {
            ui.label("Skinning");
            for way in [Skinning::Auto].into_iter().chain(Skinning::WAYS) {
                ui.selectable_value(&mut knobs.draw.skinning, way, way.name());
            }
        })
        .response
        .on_hover_text(
            stats::skinning_words(choice, knobs.draw.skinning).unwrap_or_else(|| format!("now: {}", choice.way.name())),
        );
        ui.label(match &choice.measured_ms {
            Some([vertex, palettes, compute]) => {
                format!("now {}: {vertex:.1}, {palettes:.1}, {compute:.1} ms a frame", choice.way.name())
            }
            None if choice.refused.is_some() => format!("now {}: others do not fit", choice.way.name()),
            None if stats::takes_palettes_for_fades(choice, knobs.draw.skinning) => {
                format!("now {}: somebody may fade", choice.way.name())
            }
            None => format!("now {}", choice.way.name()),
        });
    }
    if knobs.draw.has_dots() {
        ui.checkbox(&mut knobs.draw.occlusion, "leave out whom others hide (O)")
            .on_hover_text("Two-phase occlusion culling: who was in sight first, then who comes into it");
    }
    ui.horizontal(|ui| {
        ui.label("Shadow maps");
        for maps in 0..=4 {
            let word = if maps == 0 { "none".to_owned() } else { maps.to_string() };
            ui.selectable_value(&mut knobs.draw.shadows, maps, word);
        }
    });
    let sight = Slider::new(&mut knobs.sight_m, 0.0..=1000.0).clamping(SliderClamping::Edits);
    ui.add(sight.text("sight in fog, m"))
        .on_hover_text("Metres after which a twentieth is left of what is seen; 0: no fog");
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
}

/// What is looked at, and when.
pub(super) fn looking(ui: &mut Ui, knobs: &mut Knobs, readings: &Readings) {
    ui.horizontal_wrapped(|ui| {
        ui.label("View");
        for view in View::ALL {
            let can_show = readings.on_gpu && DrawOptions { view, ..knobs.draw }.shown_view() == view;
            let is_shown = knobs.draw.shown_view() == view;
            if ui.add_enabled(can_show, egui::Button::selectable(is_shown, view.name())).clicked() {
                knobs.draw.view = view;
            }
        }
    });
    ui.checkbox(&mut knobs.draw.frozen, "freeze culling and levels (F)")
        .on_hover_text("Who is drawn and at which levels stays; go around and look at it");
    let can_show = readings.on_gpu && knobs.can_show_reference();
    ui.add_enabled(can_show, egui::Checkbox::new(&mut knobs.reference, "reference camera (C)"))
        .on_hover_text("All of the crowd from outside, with this camera's frustum; who is culled is a dot")
        .on_disabled_hover_text("Not with occlusion culling, pseudo-instancing or discrete levels, nor on the CPU");
    ui.horizontal(|ui| {
        ui.checkbox(&mut knobs.paused, "pause");
        ui.add(Slider::new(&mut knobs.time_scale, 0.0..=4.0).clamping(SliderClamping::Edits).text("time scale"));
    });
    ui.horizontal(|ui| {
        ui.label("Save picture");
        for (shot, word) in [(Shot::Crowd, "of the crowd (P)"), (Shot::Window, "of the window")] {
            if ui.button(word).clicked() {
                knobs.shot = Some(shot);
            }
        }
    });
}
