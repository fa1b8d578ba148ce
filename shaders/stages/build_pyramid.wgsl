// The farthest depth of ever larger blocks of pixels. Level k has blocks of 2^(k + 1) pixels a side, cut off at the picture's
// rim, so odd sizes lose nothing. Twin: crowd-stages/src/cpu/build_pyramid.rs.

@group(0) @binding(0) var<uniform> pyramid: PyramidConfig;
@group(0) @binding(1) var<uniform> step: PyramidStep;
@group(0) @binding(2) var<storage, read_write> farthest: array<f32>;
@group(0) @binding(3) var depth: texture_depth_2d;
@group(0) @binding(4) var depth_samples: texture_depth_multisampled_2d;

// 0 near, 1 far, whichever way the texture has it.
fn ascending(depth: f32) -> f32 {
    return select(depth, 1.0 - depth, pyramid.reversed != 0u);
}

fn depth_of(x: u32, y: u32) -> f32 {
    return ascending(textureLoad(depth, vec2u(x, y), 0));
}

fn depth_of_samples(x: u32, y: u32) -> f32 {
    var most = 0.0;
    for (var s = 0u; s < pyramid.sample_count; s++) {
        most = max(most, ascending(textureLoad(depth_samples, vec2u(x, y), s)));
    }
    return most;
}

// The block of the finest level that a number is of: left, upper, right and lower pixels.
fn pixels_of(i: u32) -> vec4u {
    let width = pyramid.levels[0].width;
    let x = 2u * (i % width);
    let y = 2u * (i / width);
    return vec4u(x, y, min(x + 1u, pyramid.width_px - 1u), min(y + 1u, pyramid.height_px - 1u));
}

fn finest_count() -> u32 {
    return pyramid.levels[0].width * pyramid.levels[0].height;
}

// The finest level, from a depth of one sample a pixel.
@compute @workgroup_size(BLOCK_SIZE)
fn read_depth(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i < finest_count() {
        let p = pixels_of(i);
        let upper = max(depth_of(p.x, p.y), depth_of(p.z, p.y));
        farthest[i] = max(upper, max(depth_of(p.x, p.w), depth_of(p.z, p.w)));
    }
}

// The same from several samples a pixel: the farthest of all. A texture of another kind cannot be an argument.
@compute @workgroup_size(BLOCK_SIZE)
fn read_samples(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i < finest_count() {
        let p = pixels_of(i);
        let upper = max(depth_of_samples(p.x, p.y), depth_of_samples(p.z, p.y));
        farthest[i] = max(upper, max(depth_of_samples(p.x, p.w), depth_of_samples(p.z, p.w)));
    }
}

// Number i of a level from the level before.
fn halved(number: u32, i: u32) -> f32 {
    let level = pyramid.levels[number];
    let finer = pyramid.levels[number - 1u];
    let x = 2u * (i % level.width);
    let y = 2u * (i / level.width);
    let right = min(x + 1u, finer.width - 1u);
    let upper = finer.offset + y * finer.width;
    let lower = finer.offset + min(y + 1u, finer.height - 1u) * finer.width;
    let most = max(farthest[upper + x], farthest[upper + right]);
    return max(most, max(farthest[lower + x], farthest[lower + right]));
}

// A coarser level from the one before.
@compute @workgroup_size(BLOCK_SIZE)
fn halve(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    let level = pyramid.levels[step.level];
    if i >= level.width * level.height {
        return;
    }
    farthest[level.offset + i] = halved(step.level, i);
}

// One group: that level and all coarser ones, which are so small that dispatches of their own would cost more.
@compute @workgroup_size(BLOCK_SIZE)
fn finish(@builtin(local_invocation_index) lane: u32) {
    for (var number = step.level; number < pyramid.level_count; number++) {
        let level = pyramid.levels[number];
        for (var i = lane; i < level.width * level.height; i += BLOCK_SIZE) {
            farthest[level.offset + i] = halved(number, i);
        }
        storageBarrier();
    }
}
