//! sRGB, exactly as IEC 61966-2-1 and as GPUs do: the piecewise curve, rounded to the nearest code.

use std::sync::OnceLock;

use glam::Vec3;

/// Linear value (0 to 1) of an encoded one (0 to 1).
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::powf((encoded + 0.055) / 1.055, 2.4) }
}

/// Encoded value (0 to 1) of a linear one; values outside 0 to 1 are clamped first, NaN is 0.
pub fn srgb_from_linear(linear: f32) -> f32 {
    let c = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * libm::powf(c, 1.0 / 2.4) - 0.055 }
}

/// Linear value of each of the 256 codes.
pub fn decode_table() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0)))
}

/// Smallest linear value of each code, and for each 4096th the code to start the search from.
struct EncodeTable {
    floor: [f32; 257],
    guess: [u8; GUESSES + 1],
}

const GUESSES: usize = 4096;

fn encode_table() -> &'static EncodeTable {
    static TABLE: OnceLock<EncodeTable> = OnceLock::new();
    TABLE.get_or_init(|| {
        let floor = std::array::from_fn(|code| match code {
            0 => f32::NEG_INFINITY,
            256 => f32::INFINITY,
            _ => linear_from_srgb((code as f32 - 0.5) / 255.0),
        });
        let guess = std::array::from_fn(|i| {
            let c = i as f32 / GUESSES as f32;
            (0..256).rev().find(|&code| floor[code] <= c).unwrap_or(0) as u8
        });
        EncodeTable { floor, guess }
    })
}

/// Nearest code of a linear value: `round(255 * srgb_from_linear(linear))`, without a power.
pub fn encode(linear: f32) -> u8 {
    let table = encode_table();
    let c = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    let mut code = usize::from(table.guess[(c * GUESSES as f32) as usize]);
    while c >= table.floor[code + 1] {
        code += 1;
    }
    code as u8
}

/// Opaque pixel of a linear colour.
pub fn encode_rgb(linear: Vec3) -> [u8; 4] {
    [encode(linear.x), encode(linear.y), encode(linear.z), 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_survives_decoding_and_encoding() {
        for code in 0..=255_u8 {
            assert_eq!(encode(decode_table()[usize::from(code)]), code);
        }
    }

    #[test]
    fn the_table_rounds_as_the_formula_does() {
        for i in 0..=20_000 {
            let c = i as f32 / 20_000.0;
            let exact = 255.0 * srgb_from_linear(c);
            let code = f32::from(encode(c));
            assert!((code - exact).abs() <= 0.5 + 1e-3, "{c}: {code} for {exact}");
        }
    }

    #[test]
    fn values_out_of_range_are_clamped() {
        assert_eq!([encode(-1.0), encode(f32::NAN), encode(2.0), encode(f32::INFINITY)], [0, 0, 255, 255]);
    }
}
