//! The error curves as inline SVG: distance over triangles, both axes logarithmic, full detail on the left as in the strips.

use super::html::{Text, length, percent};
use crate::inspect::grouped;
use std::fmt::Write;

pub(super) const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 330.0;
pub(super) const LEFT: f64 = 66.0;
pub(super) const RIGHT: f64 = 152.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 44.0;
/// Heights on the screen for which the chart says where an error is one pixel.
const SCREEN_HEIGHTS_PX: [u32; 5] = [2000, 1000, 500, 200, 100];
/// Points of a curve below which there is nothing to draw.
const FEWEST_POINTS: usize = 2;

/// A curve: its name, its CSS class, and its points as triangles and metres.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curve {
    pub name: &'static str,
    pub class: &'static str,
    pub points: Vec<(u32, f32)>,
}

/// What the chart shows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chart<'a> {
    /// Whose curves, for the title.
    pub character: &'a str,
    pub full_triangle_count: u32,
    pub height_m: f32,
    /// Shares marked along the way, with the triangles of their levels.
    pub marks: Vec<(f64, u32)>,
    pub curves: Vec<Curve>,
}

/// Where numbers stand.
struct Scale {
    /// Triangles at the left and at the right border.
    triangles: [f64; 2],
    /// Metres at the bottom and at the top, powers of ten.
    metres: [f64; 2],
}

impl Scale {
    fn x(&self, triangles: f64) -> f64 {
        let [left, right] = self.triangles.map(libm::log);
        LEFT + (WIDTH - LEFT - RIGHT) * (left - libm::log(triangles.max(1.0))) / (left - right).max(1e-9)
    }

    fn y(&self, metres: f64) -> f64 {
        let [bottom, top] = self.metres.map(libm::log10);
        HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (libm::log10(metres) - bottom) / (top - bottom).max(1e-9)
    }
}

/// The chart, or nothing where fewer than two levels were measured above zero.
pub(crate) fn to_svg(chart: &Chart<'_>, id: &str) -> Option<String> {
    let drawn: Vec<Curve> = chart.curves.iter().map(above_zero).filter(|c| c.points.len() >= FEWEST_POINTS).collect();
    let points = || drawn.iter().flat_map(|curve| curve.points.iter());
    let coarsest = points().map(|point| point.0).min()?;
    let low = points().map(|point| point.1).fold(f32::INFINITY, f32::min);
    let high = points().map(|point| point.1).fold(0.0, f32::max);
    let decade = |metres: f32, round: fn(f64) -> f64| libm::pow(10.0, round(libm::log10(f64::from(metres))));
    let bottom = decade(low, f64::floor);
    let top = decade(high, f64::ceil).max(bottom * 10.0);
    let scale = Scale { triangles: [f64::from(chart.full_triangle_count), f64::from(coarsest)], metres: [bottom, top] };
    let mut out = String::new();
    let _ = write!(
        out,
        "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-labelledby=\"{id}-t\">\
         <title id=\"{id}-t\">Distance of the levels of {} to full detail over their triangles</title>",
        Text(chart.character)
    );
    write_grid(&mut out, &scale);
    write_screen_heights(&mut out, &scale, chart.height_m);
    write_marks(&mut out, &scale, chart);
    for curve in &drawn {
        write_curve(&mut out, &scale, curve);
    }
    write_names(&mut out, &scale, &drawn);
    out.push_str("</svg>");
    Some(out)
}

fn above_zero(curve: &Curve) -> Curve {
    let mut points = curve.points.clone();
    points.retain(|point| point.1 > 0.0 && point.1.is_finite() && point.0 > 0);
    points.sort_by_key(|point| std::cmp::Reverse(point.0));
    Curve { points, ..curve.clone() }
}

fn write_grid(out: &mut String, scale: &Scale) {
    let [bottom, top] = scale.metres;
    let mut decade = bottom;
    while decade <= top * 1.001 {
        let y = scale.y(decade);
        let _ = write!(
            out,
            "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{:.1}\"/><text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"end\">{}</text>",
            WIDTH - RIGHT,
            LEFT - 8.0,
            y + 4.0,
            decade_label(decade)
        );
        if decade * 10.0 <= top * 1.001 {
            for step in 2..10 {
                let y = scale.y(decade * f64::from(step));
                let _ = write!(out, "<path class=\"fine\" d=\"M{LEFT} {y:.1}H{:.1}\"/>", WIDTH - RIGHT);
            }
        }
        decade *= 10.0;
    }
}

/// A power of ten without idle digits.
fn decade_label(metres: f64) -> String {
    let mm = metres * 1e3;
    match mm {
        mm if mm >= 999.0 => format!("{:.0} m", mm / 1e3),
        mm if mm >= 0.99 => format!("{mm:.0} mm"),
        mm if mm >= 0.099 => format!("{mm:.1} mm"),
        mm if mm >= 0.0099 => format!("{mm:.2} mm"),
        _ => length(metres as f32),
    }
}

/// Lines where the error is one pixel for a character of some height on the screen.
fn write_screen_heights(out: &mut String, scale: &Scale, height_m: f32) {
    let mut last_y = f64::INFINITY;
    for height_px in SCREEN_HEIGHTS_PX {
        let metres = f64::from(height_m) / f64::from(height_px);
        if metres < scale.metres[0] * 1.1 || metres > scale.metres[1] * 0.95 {
            continue;
        }
        let y = scale.y(metres);
        if last_y - y < 15.0 {
            continue;
        }
        last_y = y;
        let right = WIDTH - RIGHT;
        let _ = write!(
            out,
            "<path class=\"pixel\" d=\"M{LEFT} {y:.1}H{:.1}\"/><text class=\"note\" x=\"{:.1}\" y=\"{:.1}\">1 px \
             at {height_px} px tall</text>",
            right + 6.0,
            right + 10.0,
            y + 4.0
        );
    }
}

fn write_marks(out: &mut String, scale: &Scale, chart: &Chart<'_>) {
    let bottom = HEIGHT - BOTTOM;
    let full = (None, chart.full_triangle_count);
    let coarsest = (None, scale.triangles[1] as u32);
    let marks = chart.marks.iter().map(|&(share, triangles)| (Some(share), triangles));
    let mut last_x = f64::NEG_INFINITY;
    for (share, triangles) in std::iter::once(full).chain(marks).chain([coarsest]) {
        let x = scale.x(f64::from(triangles));
        if x - last_x < 40.0 {
            continue;
        }
        last_x = x;
        let _ = write!(
            out,
            "<path class=\"mark\" d=\"M{x:.1} {TOP}V{:.1}\"/><text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" \
             text-anchor=\"middle\">{}</text>",
            bottom + 5.0,
            bottom + 19.0,
            grouped(triangles)
        );
        let name = match share {
            Some(share) => percent(share),
            None if triangles == chart.full_triangle_count => "full".to_owned(),
            None => percent(f64::from(triangles) / f64::from(chart.full_triangle_count.max(1))),
        };
        let _ = write!(
            out,
            "<text class=\"share\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{name}</text>",
            TOP - 9.0
        );
    }
    let _ = write!(
        out,
        "<text class=\"note\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">triangles of the level</text>",
        (LEFT + WIDTH - RIGHT) / 2.0,
        HEIGHT - 6.0
    );
}

fn write_curve(out: &mut String, scale: &Scale, curve: &Curve) {
    let _ = write!(out, "<path class=\"curve {}\" d=\"", curve.class);
    for (place, &(triangles, metres)) in curve.points.iter().enumerate() {
        let command = if place == 0 { 'M' } else { 'L' };
        let _ = write!(out, "{command}{:.1} {:.1}", scale.x(f64::from(triangles)), scale.y(f64::from(metres)));
    }
    out.push_str("\"/>");
    for &(triangles, metres) in &curve.points {
        let _ = write!(
            out,
            "<circle class=\"{}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.6\"><title>{} triangles: {} {}</title></circle>",
            curve.class,
            scale.x(f64::from(triangles)),
            scale.y(f64::from(metres)),
            grouped(triangles),
            curve.name,
            length(metres)
        );
    }
}

/// Names of the curves where they begin, each under the one before so that none covers another.
fn write_names(out: &mut String, scale: &Scale, curves: &[Curve]) {
    let mut starts: Vec<(f64, &Curve)> =
        curves.iter().filter_map(|c| Some((scale.y(f64::from(c.points.first()?.1)), c))).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (place, (_, curve)) in starts.iter().enumerate() {
        let y = TOP + 18.0 + 18.0 * place as f64;
        let _ = write!(
            out,
            "<path class=\"curve {}\" d=\"M{:.1} {:.1}h22\"/><text class=\"name\" x=\"{:.1}\" y=\"{y:.1}\">{}</text>",
            curve.class,
            LEFT + 12.0,
            y - 4.0,
            LEFT + 40.0,
            curve.name
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<(u32, f32)>) -> Chart<'static> {
        let curves = vec![Curve { name: "largest", class: "max", points }];
        Chart { character: "<b>", full_triangle_count: 1000, height_m: 1.7, marks: vec![(0.25, 250)], curves }
    }

    #[test]
    fn distances_rise_to_the_right_and_names_are_escaped() {
        let svg = to_svg(&chart(vec![(100, 0.05), (500, 0.002)]), "c").unwrap();
        assert!(svg.contains("&lt;b&gt;") && !svg.contains("<b>"), "{svg}");
        assert!(svg.contains("25\u{a0}%") && svg.contains("1 px at 500 px tall"), "{svg}");
        let scale = Scale { triangles: [1000.0, 100.0], metres: [0.001, 0.1] };
        assert!(scale.x(100.0) > scale.x(1000.0) && scale.y(0.1) < scale.y(0.001));
        assert!((scale.x(1000.0) - LEFT).abs() < 1e-9 && (scale.y(0.1) - TOP).abs() < 1e-9);
    }

    #[test]
    fn nothing_measured_is_no_chart() {
        assert!(to_svg(&chart(vec![(100, 0.0), (500, f32::NAN), (600, 1.0)]), "c").is_none());
    }
}
