//! Packing and unpacking the fields of a [`VertexRecord`]: normals, weights, joints, colours, material and class.
//!
//! The shaders unpack the same words with `unpack2x16snorm`, `unpack4x8unorm` and shifts; `docs/FORMAT.md` has the tables.

use crate::VertexRecord;

/// Vertex classes (Peng 2011 §4.2), as kept in [`VertexRecord::material_class`].
pub mod vertex_class {
    /// May collapse alone.
    pub const REGULAR: u32 = 0;
    /// Lies on a seam and collapses together with its partner.
    pub const COMPANION: u32 = 1;
    /// Never collapses.
    pub const FIXED: u32 = 2;
}

/// The octahedral code of a direction: two signed normalised 16-bit numbers, x in the low half.
///
/// The length does not matter; a zero or non-finite direction becomes +Z. The decoded direction is within 0.006 degrees.
pub fn encode_normal(normal: [f32; 3]) -> u32 {
    let sum = normal[0].abs() + normal[1].abs() + normal[2].abs();
    if !(sum.is_finite() && sum > 0.0) {
        return 0;
    }
    let [x, y, z] = normal.map(|c| c / sum);
    let (u, v) = if z >= 0.0 { (x, y) } else { ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)) };
    snorm16(u) | (snorm16(v) << 16)
}

/// The unit direction of an octahedral code; any 32 bits give one.
pub fn decode_normal(code: u32) -> [f32; 3] {
    let u = from_snorm16(code as u16);
    let v = from_snorm16((code >> 16) as u16);
    let z = 1.0 - u.abs() - v.abs();
    let fold = (-z).max(0.0);
    let (x, y) = (u - sign(u) * fold, v - sign(v) * fold);
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

/// Weights as unsigned normalised 16-bit numbers that sum to exactly 65535.
///
/// Each is rounded down and the rest goes to the largest remainders, the first of equals first. Negative and non-finite
/// weights count as 0; if nothing is left the first joint takes all.
pub fn quantize_weights(weights: [f32; 4]) -> [u16; 4] {
    let kept = weights.map(|w| if w.is_finite() && w > 0.0 { f64::from(w) } else { 0.0 });
    let sum: f64 = kept.iter().sum();
    if sum <= 0.0 {
        return [u16::MAX, 0, 0, 0];
    }
    let ideal = kept.map(|w| w / sum * 65_535.0);
    let mut quantized = ideal.map(|w| w as u16);
    let mut order = [0_usize, 1, 2, 3];
    order.sort_by(|&a, &b| ideal[b].fract().total_cmp(&ideal[a].fract()).then(a.cmp(&b)));
    let missing = 65_535_u32.saturating_sub(quantized.iter().map(|&w| u32::from(w)).sum());
    for slot in order.into_iter().cycle().take(missing as usize) {
        quantized[slot] = quantized[slot].saturating_add(1);
    }
    quantized
}

/// A linear colour as RGBA8, red in the low byte; clamped to 0..=1, NaN becomes 0.
pub fn encode_color(color: [f32; 4]) -> u32 {
    u32::from_le_bytes(color.map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8))
}

/// The linear colour of RGBA8, each channel in 0..=1.
pub fn decode_color(code: u32) -> [f32; 4] {
    code.to_le_bytes().map(|c| f32::from(c) / 255.0)
}

impl VertexRecord {
    /// Packs a vertex.
    ///
    /// `position`: metres, bind space. `normal`: any length. `uv`: v down. `color`: linear RGBA, 0..=1. `material`: local
    /// to the character. `class`: see [`vertex_class`]. `joints`: local to the character. `weights`: any positive sum.
    pub fn new(
        position: [f32; 3],
        normal: [f32; 3],
        uv: [f32; 2],
        color: [f32; 4],
        material: u16,
        class: u16,
        joints: [u16; 4],
        weights: [f32; 4],
    ) -> Self {
        Self {
            position,
            normal_oct: encode_normal(normal),
            uv,
            color: encode_color(color),
            material_class: u32::from(material) | (u32::from(class) << 16),
            joints: pack_u16x4(joints),
            weights: pack_u16x4(quantize_weights(weights)),
        }
    }

    /// Unit normal in bind space.
    pub fn normal(&self) -> [f32; 3] {
        decode_normal(self.normal_oct)
    }

    /// Linear RGBA colour, 0..=1.
    pub fn color_f32(&self) -> [f32; 4] {
        decode_color(self.color)
    }

    /// Joints, local to the character.
    pub fn joint_indices(&self) -> [u16; 4] {
        unpack_u16x4(self.joints)
    }

    /// Weights as stored; they sum to 65535.
    pub fn weights_unorm16(&self) -> [u16; 4] {
        unpack_u16x4(self.weights)
    }

    /// Weights as the shader sees them, each `stored / 65535`.
    pub fn weights_f32(&self) -> [f32; 4] {
        self.weights_unorm16().map(|w| f32::from(w) / 65_535.0)
    }

    /// Material, local to the character.
    pub fn material(&self) -> u32 {
        self.material_class & 0xffff
    }

    /// Class, see [`vertex_class`].
    pub fn class(&self) -> u32 {
        self.material_class >> 16
    }
}

/// +1 for zero, so that the fold has no hole on the axes (`f32::signum(-0.0)` is -1).
fn sign(value: f32) -> f32 {
    if value >= 0.0 { 1.0 } else { -1.0 }
}

/// WGSL's `pack2x16snorm` for one number.
fn snorm16(value: f32) -> u32 {
    let rounded = (value.clamp(-1.0, 1.0) * 32_767.0 + 0.5).floor() as i16;
    u32::from(rounded as u16)
}

/// WGSL's `unpack2x16snorm` for one number.
fn from_snorm16(bits: u16) -> f32 {
    (f32::from(bits as i16) / 32_767.0).max(-1.0)
}

fn pack_u16x4(values: [u16; 4]) -> [u32; 2] {
    let [a, b, c, d] = values.map(u32::from);
    [a | (b << 16), c | (d << 16)]
}

fn unpack_u16x4(words: [u32; 2]) -> [u16; 4] {
    [words[0] as u16, (words[0] >> 16) as u16, words[1] as u16, (words[1] >> 16) as u16]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn axes_survive_exactly() {
        for axis in
            [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]
        {
            assert_eq!(decode_normal(encode_normal(axis)), axis);
        }
    }

    #[test]
    fn senseless_normals_become_plus_z() {
        for bad in [[0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]] {
            assert_eq!(decode_normal(encode_normal(bad)), [0.0, 0.0, 1.0]);
        }
    }

    #[test]
    fn thirds_give_the_rest_to_the_first() {
        // 65535 / 3 = 21845 exactly; sevenths leave remainders to hand out.
        assert_eq!(quantize_weights([1.0, 1.0, 1.0, 0.0]), [21_845, 21_845, 21_845, 0]);
        assert_eq!(quantize_weights([0.5, 0.5, 0.0, 0.0]), [32_768, 32_767, 0, 0]);
        assert_eq!(quantize_weights([0.25; 4]), [16_384, 16_384, 16_384, 16_383]);
        assert_eq!(quantize_weights([f32::NAN, -1.0, 0.0, 0.0]), [65_535, 0, 0, 0]);
    }

    #[test]
    fn fields_come_back_from_their_words() {
        let vertex = VertexRecord::new(
            [1.0, 2.0, 3.0],
            [0.0, 1.0, 0.0],
            [0.25, 0.75],
            [1.0, 0.5, 0.0, 1.0],
            7,
            vertex_class::FIXED as u16,
            [1, 2, 300, 65_535],
            [0.1, 0.2, 0.3, 0.4],
        );
        assert_eq!(vertex.material(), 7);
        assert_eq!(vertex.class(), vertex_class::FIXED);
        assert_eq!(vertex.joint_indices(), [1, 2, 300, 65_535]);
        assert_eq!(vertex.color, 0xff00_80ff);
        assert_eq!(vertex.weights_unorm16().iter().map(|&w| u32::from(w)).sum::<u32>(), 65_535);
    }

    proptest! {
        #[test]
        fn normals_turn_by_less_than_0_006_degrees(x in -1.0_f32..1.0, y in -1.0_f32..1.0, z in -1.0_f32..1.0) {
            let length = (x * x + y * y + z * z).sqrt();
            prop_assume!(length > 0.01);
            let unit = [x / length, y / length, z / length];
            let back = decode_normal(encode_normal(unit));
            let distance = (0..3).map(|i| (unit[i] - back[i]) * (unit[i] - back[i])).sum::<f32>().sqrt();
            prop_assert!(distance < 1.05e-4, "{distance}");
        }

        #[test]
        fn any_code_is_a_unit_normal(code: u32) {
            let n = decode_normal(code);
            let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
            prop_assert!((length - 1.0).abs() < 1e-5);
        }

        #[test]
        fn weights_sum_to_65535_and_stay_within_one_step(w in prop::array::uniform4(0.0_f32..1.0)) {
            let sum: f32 = w.iter().sum();
            prop_assume!(sum > 1e-3);
            let q = quantize_weights(w);
            prop_assert_eq!(q.iter().map(|&v| u32::from(v)).sum::<u32>(), 65_535);
            for i in 0..4 {
                prop_assert!((f32::from(q[i]) - w[i] / sum * 65_535.0).abs() < 1.1);
            }
        }
    }
}
