//! How much of the surface has come out through a layer above it, over the levels, as inline SVG.

use super::chart::{LEFT, RIGHT, WIDTH};
use super::html::{Text, percent};
use crate::inspect::grouped;
use std::fmt::Write;

const HEIGHT: f64 = 170.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 40.0;
/// Shares that the axis may end at.
const TOPS: [f64; 10] = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0];
/// Lines across.
const LINES: u32 = 4;

/// The curve, or nothing where no level shows any: `points` are triangles and shares, 0 to 1.
pub(super) fn to_svg(character: &str, full_triangle_count: u32, points: &[(u32, f32)], id: &str) -> Option<String> {
    let mut points: Vec<(u32, f32)> = points.iter().copied().filter(|p| p.0 > 0 && p.1.is_finite()).collect();
    points.sort_by_key(|point| std::cmp::Reverse(point.0));
    let most = points.iter().map(|point| f64::from(point.1)).fold(0.0, f64::max);
    let coarsest = f64::from(points.last()?.0);
    if most <= 0.0 || points.len() < 2 {
        return None;
    }
    let top = TOPS.into_iter().find(|&top| most <= top).unwrap_or(1.0);
    let (left, right) = (libm::log(f64::from(full_triangle_count.max(1))), libm::log(coarsest));
    let x = |triangles: u32| {
        LEFT + (WIDTH - LEFT - RIGHT) * (left - libm::log(f64::from(triangles))) / (left - right).max(1e-9)
    };
    let y = |share: f64| HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * share / top;
    let mut out = String::new();
    let _ = write!(
        out,
        "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-labelledby=\"{id}-t\">\
         <title id=\"{id}-t\">Share of the surface of {} that pokes through, over the triangles of the level</title>",
        Text(character)
    );
    for line in 0..=LINES {
        let share = top * f64::from(line) / f64::from(LINES);
        let _ = write!(
            out,
            "<path class=\"grid\" d=\"M{LEFT} {:.1}H{:.1}\"/><text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"end\">{}</text>",
            y(share),
            WIDTH - RIGHT,
            LEFT - 8.0,
            y(share) + 4.0,
            share_label(share)
        );
    }
    out.push_str("<path class=\"curve max\" d=\"");
    for (place, &(triangles, share)) in points.iter().enumerate() {
        let command = if place == 0 { 'M' } else { 'L' };
        let _ = write!(out, "{command}{:.1} {:.1}", x(triangles), y(f64::from(share)));
    }
    out.push_str("\"/>");
    for &(triangles, share) in &points {
        let _ = write!(
            out,
            "<circle class=\"max\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.6\"><title>{} triangles: {} pokes through</title></circle>",
            x(triangles),
            y(f64::from(share)),
            grouped(triangles),
            share_label(f64::from(share))
        );
    }
    let ends = [(full_triangle_count, LEFT), (coarsest as u32, WIDTH - RIGHT)];
    for (triangles, x) in ends {
        let _ = write!(
            out,
            "<text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            HEIGHT - BOTTOM + 19.0,
            grouped(triangles)
        );
    }
    let _ = write!(
        out,
        "<text class=\"note\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">triangles of the level</text></svg>",
        (LEFT + WIDTH - RIGHT) / 2.0,
        HEIGHT - 8.0
    );
    Some(out)
}

/// A share as its axis needs it: with tenths and hundredths of a percent where it is small.
fn share_label(share: f64) -> String {
    match share {
        share if share >= 0.1 || share == 0.0 => percent(share),
        share if share >= 0.01 => format!("{:.1}\u{a0}%", share * 100.0),
        share => format!("{:.2}\u{a0}%", share * 100.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarser_levels_stand_to_the_right_and_more_stands_higher() {
        let svg = to_svg("<b>", 1000, &[(100, 0.016), (500, 0.0), (1000, 0.0)], "p").unwrap();
        assert!(svg.contains("&lt;b&gt;") && svg.contains("100 triangles: 1.6\u{a0}% pokes through"), "{svg}");
        // From the left at the bottom to the right, four fifths up an axis that ends at 2 %.
        let bottom = HEIGHT - BOTTOM;
        let high = bottom - (bottom - TOP) * 0.8;
        assert!(svg.contains(&format!("M{LEFT:.1} {bottom:.1}")), "{svg}");
        assert!(svg.contains(&format!("L{:.1} {high:.1}\"", WIDTH - RIGHT)), "{svg}");
    }

    #[test]
    fn nothing_that_pokes_through_is_no_curve() {
        assert!(to_svg("a", 1000, &[(100, 0.0), (500, 0.0)], "p").is_none());
        assert!(to_svg("a", 1000, &[(100, 0.5)], "p").is_none());
        assert!(to_svg("a", 1000, &[], "p").is_none());
    }
}
