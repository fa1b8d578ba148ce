// Boxes against the depth pyramid: who is hidden is remembered for the next frame, who has waited and is not comes into the
// second phase. Twin: crowd-stages/src/cpu/test_occlusion.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> pyramid: PyramidConfig;
@group(0) @binding(2) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(3) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(4) var<storage, read> clips: array<ClipRecord>;
@group(0) @binding(5) var<storage, read> farthest: array<f32>;
@group(0) @binding(6) var<storage, read_write> culled: array<CullRecord>;
@group(0) @binding(7) var<storage, read_write> seen: array<u32>;

// Pixels that a box is wider than it is: corners snap to a grid, and sines may be off.
const SLACK_PX: f32 = 1.0;
// Depth that a box is nearer than it is: rounding of the transform and of the interpolation.
const SLACK_DEPTH: f32 = 1e-6;
// Blocks of the pyramid that a box may span a side.
const MOST_BLOCKS: u32 = 8u;

fn is_occluded(instance: InstanceRecord) -> bool {
    let character = characters[instance.character];
    let sphere = clips[instance.clip].sphere;
    // Both hold every pose of the clip.
    let low = max(character.box_min, sphere.xyz - sphere.w);
    let high = min(character.box_max, sphere.xyz + sphere.w);
    let size_px = vec2f(f32(pyramid.width_px), f32(pyramid.height_px));
    var least = vec3f(1e9);
    var most = vec2f(-1e9);
    for (var c = 0u; c < 8u; c++) {
        let corner = select(low, high, vec3<bool>((c & 1u) != 0u, (c & 2u) != 0u, (c & 4u) != 0u));
        let clip = config.clip_from_world * vec4f(world_from_local(instance, corner), 1.0);
        // Behind the eye, or too near to say.
        if !(clip.w > 1e-4) {
            return false;
        }
        let ndc = clip.xyz / clip.w;
        let px = vec2f(ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5) * size_px;
        let depth = select(ndc.z, 1.0 - ndc.z, pyramid.reversed != 0u);
        least = min(least, vec3f(px, depth));
        most = max(most, px);
    }
    let first = vec2u(clamp(least.xy - SLACK_PX, vec2f(0.0), size_px - 1.0));
    let last = vec2u(clamp(most + SLACK_PX, vec2f(0.0), size_px - 1.0));
    var k = 0u;
    while k + 1u < pyramid.level_count && any((last >> vec2u(k + 1u)) - (first >> vec2u(k + 1u)) >= vec2u(MOST_BLOCKS)) {
        k++;
    }
    let level = pyramid.levels[k];
    let begin = first >> vec2u(k + 1u);
    let end = last >> vec2u(k + 1u);
    var depth = 0.0;
    for (var y = begin.y; y <= end.y; y++) {
        for (var x = begin.x; x <= end.x; x++) {
            depth = max(depth, farthest[level.offset + y * level.width + x]);
        }
    }
    return least.z - SLACK_DEPTH > depth;
}

@compute @workgroup_size(BLOCK_SIZE)
fn test_occlusion(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    if i == 0u {
        seen[0] = config.instance_count;
    }
    let was_drawn = culled[i].visible != 0u;
    let waits = !was_drawn && culled[i].weight > 0.0;
    if !was_drawn && !waits {
        seen[1u + i] = 0u;
        return;
    }
    let is_hidden = is_occluded(instances[i]);
    let comes = waits && !is_hidden;
    culled[i].visible = select(0u, instances[i].character + 1u, comes);
    seen[1u + i] = select(SIGHT_SEEN, SIGHT_HIDDEN, is_hidden) | select(0u, SIGHT_DRAWN, was_drawn || comes);
}
