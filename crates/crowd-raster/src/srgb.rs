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

/// [`srgb_from_linear`] of three channels at once, to the bit.
///
/// The power is that of `libm` (FreeBSD's `e_powf.c`) for one exponent and for bases from 0.0031308 to 1 alone: what is left of it has no branches, so
/// that channels fill vector operations.
pub fn srgb_from_linear_rgb(linear: [f32; 3]) -> [f32; 3] {
    let [r, g, b] = linear.map(|c| if c > 0.0 { c.min(1.0) } else { 0.0 });
    let channels = [r, g, b, b];
    let mut encoded = [0.0; 4];
    for (encoded, c) in encoded.iter_mut().zip(channels) {
        // Below, and at 1 itself, something is computed too, and not used.
        let power = encoding_power(c.max(0.003_130_8));
        *encoded = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * power - 0.055 };
    }
    let [r, g, b, _] = encoded;
    [r, g, b]
}

// What follows comes from FreeBSD's /usr/src/lib/msun/src/e_powf.c, by way of `libm`. Conversion to float by Ian Lance Taylor, Cygnus Support.
//
// Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
//
// Developed at SunPro, a Sun Microsystems, Inc. business. Permission to use, copy, modify, and distribute this software is freely granted, provided
// that this notice is preserved.

/// `libm::powf(x, 1.0 / 2.4)` for x from 0.0031308 to 1.
#[inline(always)]
#[expect(clippy::excessive_precision, reason = "as the source has them")]
fn encoding_power(x: f32) -> f32 {
    const Y: f32 = 1.0 / 2.4;
    const L1: f32 = 6.0000002384e-01;
    const L2: f32 = 4.2857143283e-01;
    const L3: f32 = 3.3333334327e-01;
    const L4: f32 = 2.7272811532e-01;
    const L5: f32 = 2.3066075146e-01;
    const L6: f32 = 2.0697501302e-01;
    const P1: f32 = 1.6666667163e-01;
    const P2: f32 = -2.7777778450e-03;
    const P3: f32 = 6.6137559770e-05;
    const P4: f32 = -1.6533901999e-06;
    const P5: f32 = 4.1381369442e-08;
    const LG2: f32 = 6.9314718246e-01;
    const LG2_H: f32 = 6.93145752e-01;
    const LG2_L: f32 = 1.42860654e-06;
    const CP: f32 = 9.6179670095e-01;
    const CP_H: f32 = 9.6191406250e-01;
    const CP_L: f32 = -1.1736857402e-04;
    let high = |value: f32| f32::from_bits(value.to_bits() & 0xffff_f000);

    // The base is 2^n times something from sqrt(3)/2 to sqrt(3), near 1 or near 1.5.
    let bits = x.to_bits();
    let fraction = bits & 0x007f_ffff;
    let (near_middle, near_end) = ((fraction > 0x1c_c471) & (fraction < 0x5d_b3d7), fraction >= 0x5d_b3d7);
    let n = (bits >> 23) as i32 - 0x7f + i32::from(near_end);
    let ix = (fraction | 0x3f80_0000) - if near_end { 0x0080_0000 } else { 0 };
    let ax = f32::from_bits(ix);
    let (bp, dp_h, dp_l) = if near_middle { (1.5, 5.84960938e-01, 1.56322085e-06) } else { (1.0, 0.0, 0.0) };
    let (u, v) = (ax - bp, 1.0 / (ax + bp));
    let s = u * v;
    let s_h = high(s);
    let t_h = ((ix >> 1) & 0xffff_f000) | 0x2000_0000;
    let t_h = f32::from_bits(t_h + 0x0040_0000 + if near_middle { 0x0020_0000 } else { 0 });
    let t_l = ax - (t_h - bp);
    let s_l = v * ((u - s_h * t_h) - s_h * t_l);
    // Its logarithm, in two parts.
    let s2 = s * s;
    let r = s2 * s2 * (L1 + s2 * (L2 + s2 * (L3 + s2 * (L4 + s2 * (L5 + s2 * L6)))));
    let r = r + s_l * (s_h + s);
    let s2 = s_h * s_h;
    let t_h = high(3.0 + s2 + r);
    let t_l = r - ((t_h - 3.0) - s2);
    let u = s_h * t_h;
    let v = s_l * t_h + t_l * s;
    let p_h = high(u + v);
    let p_l = v - (p_h - u);
    let z_h = CP_H * p_h;
    let z_l = CP_L * p_h + p_l * CP + dp_l;
    let t = n as f32;
    let t1 = high(((z_h + z_l) + dp_h) + t);
    let t2 = z_l - (((t1 - t) - dp_h) - z_h);
    // Times the exponent.
    let y1 = high(Y);
    let p_l = (Y - y1) * t1 + Y * t2;
    let p_h = y1 * t1;
    let z = p_l + p_h;
    // Two to that, from -3.5 to 0: a whole number, rounded, and the rest.
    let size = -z;
    let n = -(i32::from(size > 0.5) + i32::from(size >= 1.5) + i32::from(size >= 2.5) + i32::from(size >= 3.5));
    let p_h = p_h - n as f32;
    let t = f32::from_bits((p_l + p_h).to_bits() & 0xffff_8000);
    let u = t * LG2_H;
    let v = (p_l - (t - p_h)) * LG2 + t * LG2_L;
    let z = u + v;
    let w = v - (z - u);
    let t = z * z;
    let t1 = z - t * (P1 + t * (P2 + t * (P3 + t * (P4 + t * P5))));
    let r = (z * t1) / (t1 - 2.0) - (w + z * w);
    let z = 1.0 - (r - z);
    f32::from_bits((z.to_bits() as i32 + (n << 23)) as u32)
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
    fn three_channels_are_what_each_is_alone_to_the_bit() {
        let alike = |values: [f32; 3]| {
            let alone = values.map(|c| srgb_from_linear(c).to_bits());
            assert_eq!(srgb_from_linear_rgb(values).map(f32::to_bits), alone, "{values:?}");
        };
        // Every float from 0.0031308 to 1, and a few beyond both ends.
        let (first, last) = (0.003_130_8_f32.to_bits() - 3000, 1.0_f32.to_bits() + 3000);
        for bits in (first..last).step_by(3) {
            alike([bits, bits + 1, bits + 2].map(f32::from_bits));
        }
        alike([0.0, f32::NAN, -1.0]);
        alike([-0.0, f32::INFINITY, 1.0e-20]);
    }

    #[test]
    fn values_out_of_range_are_clamped() {
        assert_eq!([encode(-1.0), encode(f32::NAN), encode(2.0), encode(f32::INFINITY)], [0, 0, 255, 255]);
    }
}
