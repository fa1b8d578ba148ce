//! Distances as colours: the ramp of error pictures and of their legend.
//!
//! From grey, where a level fits, over yellow, orange and red to a dark red: each colour is darker than the one before, so
//! that the order shows without colour too. The ramp follows the root of the distance: small distances show first.

use crowd_raster::srgb::decode_table;

/// Distance of the ramp's end, as a share of the height.
const RED_SHARE: f32 = 0.02;
/// How bright the colours are painted: those of a lit surface then come near the legend's.
const ALBEDO: f32 = 0.66;

/// sRGB colours of the ramp, evenly spaced.
pub(crate) const RAMP: [[u8; 3]; 6] =
    [[214, 218, 222], [246, 226, 160], [248, 178, 72], [226, 96, 38], [174, 24, 40], [92, 8, 46]];

/// The distance of the ramp's end, metres, for a character of this height.
pub(crate) fn red_distance_m(height_m: f32) -> f32 {
    RED_SHARE * height_m.max(1e-6)
}

/// Linear RGBA8 of each distance.
pub(crate) fn heat_colors(distances_m: &[f32], red_at_m: f32) -> Vec<[u8; 4]> {
    distances_m.iter().map(|distance_m| heat(distance_m / red_at_m)).collect()
}

/// Colour of a distance as a share of the ramp's end.
fn heat(share: f32) -> [u8; 4] {
    let last = RAMP.len() - 1;
    let place = share.clamp(0.0, 1.0).sqrt() * last as f32;
    let low = (place as usize).min(last - 1);
    let t = place - low as f32;
    let channel = |c: usize| {
        let (from, to) = (f32::from(RAMP[low][c]), f32::from(RAMP[low + 1][c]));
        let code = (from + (to - from) * t + 0.5) as usize;
        (decode_table()[code.min(255)] * ALBEDO * 255.0 + 0.5) as u8
    };
    [channel(0), channel(1), channel(2), 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_is_grey_and_what_does_not_gets_darker() {
        let light = |share: f32| heat(share)[..3].iter().map(|&channel| u32::from(channel)).sum::<u32>();
        let shares = [0.0, 0.04, 0.16, 0.36, 0.64, 1.0];
        assert!(shares.is_sorted_by(|&a, &b| light(a) > light(b)), "{:?}", shares.map(light));
        assert_eq!(heat(7.0), heat(1.0));
        assert_eq!(heat(f32::INFINITY), heat(1.0));
    }
}
