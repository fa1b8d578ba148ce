// A vertex of an instance at a time: Peng 2011 Eq. 2 with premultiplied matrices and interpolated frames.
// Twin: crowd-stages/src/cpu/pose_instance.rs. Needs `animation`, the texture of palette rows.

// Texels of the animation texture: row-major in layers, addressed by one number.
const ANIMATION_WIDTH: u32 = 4096u;
const ANIMATION_HEIGHT: u32 = 64u;

struct FramePair {
    first: u32,
    second: u32,
    blend: f32,
}

fn frame_pair(clip: ClipRecord, phase_s: f32, time_s: f32) -> FramePair {
    let last = max(clip.frame_count, 1u) - 1u;
    if clip.duration_s <= 0.0 || last == 0u {
        return FramePair(0u, 0u, 0.0);
    }
    let turns = (time_s + phase_s) / clip.duration_s;
    let frame = (turns - floor(turns)) * f32(last);
    let first = min(u32(max(floor(frame), 0.0)), last);
    return FramePair(first, min(first + 1u, last), frame - f32(first));
}

fn palette_row(texel: u32) -> vec4f {
    let y = texel / ANIMATION_WIDTH;
    return textureLoad(animation, vec2u(texel % ANIMATION_WIDTH, y % ANIMATION_HEIGHT), y / ANIMATION_HEIGHT, 0);
}

// Rows of the weighted sum of the joints' matrices.
fn skin_matrix(vertex: VertexRecord, clip: ClipRecord, joint_count: u32, pair: FramePair) -> mat3x4f {
    let first = clip.texel_offset + pair.first * joint_count * 3u;
    let second = clip.texel_offset + pair.second * joint_count * 3u;
    var rows = mat3x4f(vec4f(0.0), vec4f(0.0), vec4f(0.0));
    for (var influence = 0u; influence < 4u; influence++) {
        let shift = (influence & 1u) * 16u;
        let joint = (vertex.joints[influence / 2u] >> shift) & 0xffffu;
        let weight = f32((vertex.weights[influence / 2u] >> shift) & 0xffffu) / 65535.0;
        if weight > 0.0 {
            for (var r = 0u; r < 3u; r++) {
                let a = palette_row(first + joint * 3u + r);
                let b = palette_row(second + joint * 3u + r);
                rows[r] += (a + (b - a) * pair.blend) * weight;
            }
        }
    }
    return rows;
}

fn decode_normal(packed: u32) -> vec3f {
    let e = unpack2x16snorm(packed);
    var n = vec3f(e, 1.0 - abs(e.x) - abs(e.y));
    let fold = max(-n.z, 0.0);
    n.x += select(fold, -fold, n.x >= 0.0);
    n.y += select(fold, -fold, n.y >= 0.0);
    return normalize(n);
}
