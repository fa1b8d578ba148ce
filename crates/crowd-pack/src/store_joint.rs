//! How a joint's matrix is stored in a frame, and read again: 48, 24 or 16 bytes. Twin of `shaders/shared/frames.wgsl`.

/// 16 bytes of the animation section.
pub type Texel = [u32; 4];

/// Rows of an affine matrix, `out[r] = row.x * x + row.y * y + row.z * z + row.w`.
pub type JointRows = [[f32; 4]; 3];

/// Largest exponent of a quantised rotation: components below 2^15, scales below 2^32.
pub const ROTATION_EXPONENT: u32 = 127;
/// Largest exponent of a quantised translation: below 2^30 metres.
pub const TRANSLATION_EXPONENT: u32 = 142;

/// How the joints of a character are stored, [`crate::CharacterRecord::joint_storage`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum JointStorage {
    /// Rows of three RGBA32F texels a joint; 48 bytes.
    #[default]
    F32 = 0,
    /// Rows of half floats, two joints in three texels; 24 bytes.
    F16 = 1,
    /// A quaternion whose length is the root of a uniform scale, and a translation, 16 bits a number, with an exponent each; 16 bytes.
    Quantized = 2,
}

impl JointStorage {
    /// All, largest first.
    pub const ALL: [Self; 3] = [Self::F32, Self::F16, Self::Quantized];

    /// Its number in records.
    pub fn code(self) -> u32 {
        self as u32
    }

    /// The storage of that number.
    pub fn of_code(code: u32) -> Option<Self> {
        Self::ALL.get(code as usize).copied()
    }

    /// Its name on command lines and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F16 => "f16",
            Self::Quantized => "quantized",
        }
    }

    /// Texels of a frame of that many joints. Frames begin at whole texels.
    pub fn frame_texels(self, joint_count: u32) -> u32 {
        match self {
            Self::F32 => joint_count * 3,
            Self::F16 => (joint_count * 3).div_ceil(2),
            Self::Quantized => joint_count,
        }
    }
}

/// Adds a frame to `texels`: `joints`, one matrix each, as `storage` says. Of what it cannot hold it keeps what comes nearest (a rotation and
/// a scale of a matrix that shears, the largest half float of a number beyond): whoever stores measures what came out.
pub fn store_frame(storage: JointStorage, joints: &[JointRows], texels: &mut Vec<Texel>) {
    match storage {
        JointStorage::F32 => texels.extend(joints.iter().flatten().map(|row| row.map(f32::to_bits))),
        JointStorage::F16 => {
            let pair = |numbers: &[f32]| u32::from(to_half(numbers[0])) | u32::from(to_half(numbers[1])) << 16;
            let mut words = joints.iter().flatten().flat_map(|row| [pair(&row[..2]), pair(&row[2..])]);
            while let Some(first) = words.next() {
                texels.push([first, words.next().unwrap_or(0), words.next().unwrap_or(0), words.next().unwrap_or(0)]);
            }
        }
        JointStorage::Quantized => texels.extend(joints.iter().map(quantize_joint)),
    }
}

/// The matrix of a joint in a frame's texels.
pub fn stored_joint(storage: JointStorage, frame: &[Texel], joint: usize) -> JointRows {
    match storage {
        JointStorage::F32 => [0, 1, 2].map(|row| frame[joint * 3 + row].map(f32::from_bits)),
        JointStorage::F16 => [0, 1, 2].map(|row| {
            let half = joint * 3 + row;
            let texel = frame[half / 2];
            let [a, b] = [texel[half % 2 * 2], texel[half % 2 * 2 + 1]];
            [a as u16, (a >> 16) as u16, b as u16, (b >> 16) as u16].map(of_half)
        }),
        JointStorage::Quantized => dequantize_joint(frame[joint]),
    }
}

/// All matrices of frames stored one behind the other.
pub fn stored_frames(storage: JointStorage, texels: &[Texel], joint_count: u32) -> Vec<JointRows> {
    let frames = texels.chunks_exact(storage.frame_texels(joint_count).max(1) as usize);
    let joints = 0..joint_count as usize;
    frames.flat_map(|frame| joints.clone().map(move |joint| stored_joint(storage, frame, joint))).collect()
}

/// Bits of a texel: x y, z w of the quaternion, x y of the translation, its z with the exponents of both, each number signed.
fn quantize_joint(rows: &JointRows) -> Texel {
    let (rotation, scale) = rotation_and_scale(rows);
    let length = scale.max(0.0).sqrt();
    let ([x, y, z, w], rotation_exponent) = quantize(rotation.map(|c| c * length), ROTATION_EXPONENT);
    let translation = [0, 1, 2].map(|r| f64::from(rows[r][3]));
    let ([tx, ty, tz], translation_exponent) = quantize(translation, TRANSLATION_EXPONENT);
    let pair = |low: i16, high: i16| u32::from(low as u16) | u32::from(high as u16) << 16;
    let last = u32::from(tz as u16) | rotation_exponent << 16 | translation_exponent << 24;
    [pair(x, y), pair(z, w), pair(tx, ty), last]
}

/// The numbers as multiples of a power of two, and its exponent: the smallest that all of them fit under, at most `largest`.
fn quantize<const N: usize>(numbers: [f64; N], largest: u32) -> ([i16; N], u32) {
    let most = numbers.iter().fold(0.0_f64, |most, number| most.max(number.abs()));
    // The exponent of the quotient or the one above it.
    let about = (most / f64::from(i16::MAX)).to_bits() >> 52;
    let mut exponent = (about as u32 + 127).saturating_sub(1023).min(largest);
    while exponent < largest && (most / step(exponent)).round() > f64::from(i16::MAX) {
        exponent += 1;
    }
    // Exponent 0 stands for nothing at all: no number is that small.
    if exponent == 0 {
        return ([0; N], 0);
    }
    (numbers.map(|number| (number / step(exponent)).round() as i16), exponent)
}

fn step(exponent: u32) -> f64 {
    f64::from(f32::from_bits(exponent.max(1) << 23))
}

fn dequantize_joint(texel: Texel) -> JointRows {
    let [low, high] = [|word: u32| f32::from(word as i16), |word: u32| f32::from((word >> 16) as i16)];
    let rotation_step = f32::from_bits((texel[3] >> 16 & 0xff) << 23);
    let translation_step = f32::from_bits((texel[3] >> 24) << 23);
    let [x, y, z, w] = [low(texel[0]), high(texel[0]), low(texel[1]), high(texel[1])].map(|c| c * rotation_step);
    let [tx, ty, tz] = [low(texel[2]), high(texel[2]), low(texel[3])].map(|c| c * translation_step);
    let [xx, yy, zz, ww] = [x * x, y * y, z * z, w * w];
    [
        [(ww + xx) - (yy + zz), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w), tx],
        [2.0 * (x * y + z * w), (ww + yy) - (xx + zz), 2.0 * (y * z - x * w), ty],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), (ww + zz) - (xx + yy), tz],
    ]
}

/// The rotation nearest to a matrix, x y z w of a unit quaternion, and the scale that then comes nearest; 0 for what mirrors or is flat.
fn rotation_and_scale(rows: &JointRows) -> ([f64; 4], f64) {
    let matrix: [[f64; 3]; 3] = [0, 1, 2].map(|r| [0, 1, 2].map(|c| f64::from(rows[r][c])));
    let determinant = determinant(&matrix);
    let identity = [0.0, 0.0, 0.0, 1.0];
    if !(determinant.is_finite() && determinant > 0.0) {
        return (identity, 0.0);
    }
    let rotation = nearest_rotation(&matrix, determinant);
    // The scale s of least squares of |matrix - s rotation|.
    let scale = (0..9).map(|i| rotation[i / 3][i % 3] * matrix[i / 3][i % 3]).sum::<f64>() / 3.0;
    (quaternion_of(&rotation), scale)
}

/// The polar factor of a matrix of positive determinant: Newton's iteration (Higham 1986), the size taken out first.
fn nearest_rotation(matrix: &[[f64; 3]; 3], determinant_of_it: f64) -> [[f64; 3]; 3] {
    let size = libm::cbrt(determinant_of_it);
    let mut rotation = matrix.map(|row| row.map(|entry| entry / size));
    for _ in 0..32 {
        let cofactors = cofactors(&rotation);
        let determinant = determinant(&rotation);
        let mut change = 0.0_f64;
        for r in 0..3 {
            for c in 0..3 {
                let next = 0.5 * (rotation[r][c] + cofactors[r][c] / determinant);
                change = change.max((next - rotation[r][c]).abs());
                rotation[r][c] = next;
            }
        }
        if change < 1e-12 {
            break;
        }
    }
    rotation
}

fn cofactors(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let minor = |r: usize, c: usize| {
        let ([a, b], [d, e]) = ([(r + 1) % 3, (r + 2) % 3], [(c + 1) % 3, (c + 2) % 3]);
        m[a][d] * m[b][e] - m[a][e] * m[b][d]
    };
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| minor(r, c)))
}

fn determinant(m: &[[f64; 3]; 3]) -> f64 {
    let cofactors = cofactors(m);
    m[0][0] * cofactors[0][0] + m[0][1] * cofactors[0][1] + m[0][2] * cofactors[0][2]
}

/// Shepperd's method: the largest of the four components comes from a square root, the others from sums of two entries.
fn quaternion_of(m: &[[f64; 3]; 3]) -> [f64; 4] {
    let trace = m[0][0] + m[1][1] + m[2][2];
    let squares = [m[0][0], m[1][1], m[2][2], trace];
    let largest = (0..4).fold(0, |best, i| if squares[i] > squares[best] { i } else { best });
    let mut q = [0.0; 4];
    if largest == 3 {
        q[3] = 1.0 + trace;
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            q[i] = m[k][j] - m[j][k];
        }
    } else {
        let (i, j, k) = (largest, (largest + 1) % 3, (largest + 2) % 3);
        q[i] = 1.0 + m[i][i] - m[j][j] - m[k][k];
        q[j] = m[j][i] + m[i][j];
        q[k] = m[k][i] + m[i][k];
        q[3] = m[k][j] - m[j][k];
    }
    let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() { q.map(|c| c / length) } else { [0.0, 0.0, 0.0, 1.0] }
}

/// The nearest half float, ties to even; beyond the largest that one, and zero for what is smaller than normal ones: not all adapters keep
/// those. NaN is zero.
fn to_half(number: f32) -> u16 {
    const LARGEST: f32 = 65_504.0;
    const SMALLEST: f32 = 6.103_515_6e-5;
    let sign = if number.is_sign_negative() { 0x8000 } else { 0 };
    let size = number.abs().min(LARGEST);
    if number.is_nan() || size < SMALLEST {
        return 0;
    }
    let bits = size.to_bits();
    let rounded = bits + 0xfff + (bits >> 13 & 1);
    sign | ((rounded >> 13) - (112 << 10)) as u16
}

/// The number of a half float that is finite; of others one beyond the largest.
fn of_half(half: u16) -> f32 {
    let (exponent, mantissa) = (u32::from(half >> 10 & 0x1f), u32::from(half & 0x3ff));
    let size = match exponent {
        // Below the normal ones: multiples of 2^-24.
        0 => mantissa as f32 * f32::from_bits((127 - 24) << 23),
        _ => f32::from_bits((exponent + 112) << 23 | mantissa << 13),
    };
    if half & 0x8000 != 0 { -size } else { size }
}

/// What is wrong with a frame's texels, if something is: numbers that are not finite, exponents too large, bits that belong to no joint.
pub(crate) fn find_fault(storage: JointStorage, frame: &[Texel], joint_count: u32) -> Option<(usize, &'static str)> {
    let fault = |texel: &Texel| match storage {
        JointStorage::F32 => {
            let finite = texel.iter().all(|&bits| f32::from_bits(bits).is_finite());
            (!finite).then_some("finite numbers")
        }
        JointStorage::F16 => {
            let is_finite = |half: u32| half & 0x7c00 != 0x7c00;
            let finite = texel.iter().all(|&word| is_finite(word) && is_finite(word >> 16));
            (!finite).then_some("finite half floats")
        }
        JointStorage::Quantized => {
            let fits = texel[3] >> 16 & 0xff <= ROTATION_EXPONENT && texel[3] >> 24 <= TRANSLATION_EXPONENT;
            (!fits).then_some("exponents of at most 127 for the rotation and 142 for the translation")
        }
    };
    if let Some(found) = frame.iter().enumerate().find_map(|(at, texel)| Some((at, fault(texel)?))) {
        return Some(found);
    }
    let last = frame.last().filter(|_| storage == JointStorage::F16 && joint_count % 2 == 1)?;
    (last[2..] != [0, 0]).then_some((frame.len() - 1, "zeros behind the last joint"))
}

#[cfg(test)]
mod tests;
