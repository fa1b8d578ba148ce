// The farthest depth of ever larger blocks of pixels. Level k has blocks of 2^(k + 1) pixels a side, cut off at the picture's
// rim, so odd sizes lose nothing. Twin: crowd-stages/src/cpu/build_pyramid.rs.

@group(0) @binding(0) var<uniform> pyramid: PyramidConfig;
@group(0) @binding(1) var<uniform> step: PyramidStep;
@group(0) @binding(2) var<storage, read_write> farthest: array<f32>;
@group(0) @binding(3) var depth: texture_depth_2d;
@group(0) @binding(4) var depth_samples: texture_depth_multisampled_2d;
@group(0) @binding(5) var nearest: sampler;

// 0 near, 1 far, whichever way the texture has it.
fn ascending(depth: f32) -> f32 {
    return select(depth, 1.0 - depth, pyramid.reversed != 0u);
}

// The farthest of a block of the finest level, from a depth of one sample a pixel: one gather of four texels. The picture's rim stands for what lies beyond.
fn block_depth(block: vec2u) -> f32 {
    // The corner between the four.
    let at = vec2f(2u * block + 1u) / vec2f(f32(pyramid.width_px), f32(pyramid.height_px));
    let depths = textureGather(depth, nearest, at);
    let most = max(max(depths.x, depths.y), max(depths.z, depths.w));
    let least = min(min(depths.x, depths.y), min(depths.z, depths.w));
    return ascending(select(most, least, pyramid.reversed != 0u));
}

fn depth_of_samples(x: u32, y: u32) -> f32 {
    var most = 0.0;
    for (var s = 0u; s < pyramid.sample_count; s++) {
        most = max(most, ascending(textureLoad(depth_samples, vec2u(x, y), s)));
    }
    return most;
}

// The same from several samples a pixel: the farthest of all.
fn block_depth_of_samples(block: vec2u) -> f32 {
    let x = 2u * block.x;
    let y = 2u * block.y;
    let right = min(x + 1u, pyramid.width_px - 1u);
    let lower = min(y + 1u, pyramid.height_px - 1u);
    let upper = max(depth_of_samples(x, y), depth_of_samples(right, y));
    return max(upper, max(depth_of_samples(x, lower), depth_of_samples(right, lower)));
}

// Four blocks of the finest level side by side make one of the next: a thread has all four, so that level takes no dispatch of its own.
struct Four {
    // Whether there is anything to do.
    is_there: bool,
    // Blocks at the rim stand for those beyond it.
    left: u32,
    right: u32,
    upper: u32,
    lower: u32,
    // Number in the next level.
    next: u32,
}

fn four_of(i: u32) -> Four {
    let finest = pyramid.levels[0];
    let width = (finest.width + 1u) / 2u;
    let x = 2u * (i % width);
    let y = 2u * (i / width);
    return Four(y < finest.height, x, min(x + 1u, finest.width - 1u), y, min(y + 1u, finest.height - 1u), i);
}

fn write_four(four: Four, a: f32, b: f32, c: f32, d: f32) {
    let width = pyramid.levels[0].width;
    farthest[four.upper * width + four.left] = a;
    farthest[four.upper * width + four.right] = b;
    farthest[four.lower * width + four.left] = c;
    farthest[four.lower * width + four.right] = d;
    if pyramid.level_count > 1u {
        farthest[pyramid.levels[1].offset + four.next] = max(max(a, b), max(c, d));
    }
}

// The two finest levels, from a depth of one sample a pixel.
@compute @workgroup_size(BLOCK_SIZE)
fn read_depth(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let four = four_of(group_number(workgroup) * BLOCK_SIZE + lane);
    if four.is_there {
        write_four(
            four,
            block_depth(vec2u(four.left, four.upper)),
            block_depth(vec2u(four.right, four.upper)),
            block_depth(vec2u(four.left, four.lower)),
            block_depth(vec2u(four.right, four.lower)),
        );
    }
}

// The same from several samples a pixel. A texture of another kind cannot be an argument.
@compute @workgroup_size(BLOCK_SIZE)
fn read_samples(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let four = four_of(group_number(workgroup) * BLOCK_SIZE + lane);
    if four.is_there {
        write_four(
            four,
            block_depth_of_samples(vec2u(four.left, four.upper)),
            block_depth_of_samples(vec2u(four.right, four.upper)),
            block_depth_of_samples(vec2u(four.left, four.lower)),
            block_depth_of_samples(vec2u(four.right, four.lower)),
        );
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
