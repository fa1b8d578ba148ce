// Records shared by all shaders. The same structs stand in crowd-pack/src/records.rs and crowd-stages/src/records.rs;
// a test compares sizes, offsets and constants.

const NONE: u32 = 0xffffffffu;

// Workgroups beyond 65,535 are folded into rows of this many.
const FOLD_COLUMNS: u32 = 32768u;
// Threads of a group that works on one element each.
const BLOCK_SIZE: u32 = 256u;
// Threads of a group that works on one instance.
const INSTANCE_GROUP_SIZE: u32 = 64u;
// Threads of a sorting group, also the most values of a digit; instances of each thread.
const SORT_BLOCK_SIZE: u32 = 64u;
const SORT_RUN: u32 = 32u;
// Most keys that are sorted in one pass, those in no bucket included; most runs of instances, a thread each, and instances of the shortest; threads of a
// group: as many as the lanes that a processor works on at a time.
const AT_ONCE_KEYS: u32 = 1024u;
const AT_ONCE_RUNS: u32 = 256u;
const AT_ONCE_SHORTEST: u32 = 256u;
const AT_ONCE_GROUP_SIZE: u32 = 8u;
// Heights that fill_budget's twin tries in one pass; those that the stage tries in a round; chunks of instances that it sums at most.
const FILL_CANDIDATES: u32 = 16u;
const FILL_TRIED: u32 = 8u;
const FILL_CHUNKS: u32 = 1024u;
// Entries of a character's error table, float bits of the first and of one.
const ERROR_ENTRIES: u32 = 1024u;
const ERROR_FIRST_BITS: u32 = 0x37800000u;
const ERROR_SHIFT: u32 = 18u;

// Levels of the largest depth pyramid.
const PYRAMID_LEVELS: u32 = 16u;
// What is known of an instance's sight, and a bit for those drawn in the newest frame.
const SIGHT_SEEN: u32 = 1u;
const SIGHT_HIDDEN: u32 = 2u;
const SIGHT_DRAWN: u32 = 4u;
// At most this part of the budget is kept for who comes into sight.
const RESERVE_PART: u32 = 128u;
// Levels of dots below a character's coarsest mesh, and vertices of a dot.
const DOT_LEVELS: u32 = 5u;
const DOT_VERTICES: u32 = 3u;
// Vertices and triangles of an impostor.
const IMPOSTOR_VERTICES: u32 = 4u;
const IMPOSTOR_TRIANGLES: u32 = 2u;
// Area from which on nobody is an impostor, over the area below which everyone is: a quarter higher on the screen.
const IMPOSTOR_FADE: f32 = 1.5625;
// Densities of points in a far character's place.
const POINT_LEVELS: u32 = 4u;

// Points of a clip's root path.
const ROOT_PATH_POINTS: u32 = 32u;

// Shadow maps of the sun.
const MAX_CASCADES: u32 = 4u;

const OVERFLOW_BUDGET: u32 = 1u;
const OVERFLOW_VERTICES: u32 = 2u;
const OVERFLOW_TRIANGLES: u32 = 4u;

const WEIGHT_AREA: u32 = 0u;
const WEIGHT_AREA_DISTANCE: u32 = 1u;
const WEIGHT_ERROR: u32 = 2u;

// The budget counts triangles, not vertices.
const BUDGET_TRIANGLES: u32 = 1u;

// How joints are stored.
const JOINTS_F32: u32 = 0u;
const JOINTS_F16: u32 = 1u;
const JOINTS_QUANTIZED: u32 = 2u;

const VIEW_LEVELS: u32 = 1u;
const VIEW_DENSITY: u32 = 2u;
const VIEW_REPRESENTATION: u32 = 3u;
const VIEW_OCCLUSION: u32 = 4u;

const MATERIAL_DOUBLE_SIDED: u32 = 1u;
const MATERIAL_UNLIT: u32 = 2u;
const MATERIAL_FLAT: u32 = 4u;
const MATERIAL_WRAP_U_SHIFT: u32 = 4u;
const MATERIAL_WRAP_V_SHIFT: u32 = 6u;
const MATERIAL_WRAP_MASK: u32 = 3u;

struct VertexRecord {
    position: vec3f,
    normal_oct: u32,
    uv: vec2f,
    color: u32,
    material_class: u32,
    joints: vec2u,
    weights: vec2u,
}

struct LodRecord {
    vertex_count: u32,
    triangle_count: u32,
}

struct CharacterRecord {
    vertex_offset: u32,
    vertex_count: u32,
    triangle_offset: u32,
    triangle_count: u32,
    lod_offset: u32,
    min_vertex_count: u32,
    min_triangle_count: u32,
    joint_count: u32,
    clip_offset: u32,
    clip_count: u32,
    material_offset: u32,
    material_count: u32,
    sphere: vec4f,
    box_min: vec3f,
    height_m: f32,
    box_max: vec3f,
    inverse_bind_offset: u32,
    joint_storage: u32,
    storage_error_m: f32,
    reserved: vec2u,
}

struct ClipRecord {
    texel_offset: u32,
    frame_count: u32,
    duration_s: f32,
    ground_speed_m_s: f32,
    sphere: vec4f,
    root_displacement_m: vec3f,
    loop_gap_m: f32,
}

struct MaterialRecord {
    base_color: vec4f,
    image: u32,
    flags: u32,
    alpha_cutoff: f32,
    reserved: u32,
}

struct InstanceRecord {
    position: vec3f,
    yaw_rad: f32,
    scale: f32,
    character: u32,
    clip: u32,
    phase_s: f32,
    leaving_clip: u32,
    leaving_phase_s: f32,
    leaving_share: f32,
    held_s: f32,
}

struct MotionStretch {
    start_s: f32,
    fade_s: f32,
    clip: u32,
    turns: f32,
    first_rate_hz: f32,
    rate_hz: f32,
    left_clip: u32,
    left_turns: f32,
    left_rate_hz: f32,
    left_last_rate_hz: f32,
    reserved_a: u32,
    reserved_b: u32,
}

struct MotionSchedule {
    first: u32,
    count: u32,
    loop_s: f32,
    reserved: u32,
}

struct MotionRecord {
    schedule: u32,
    ahead_s: f32,
}

struct PoseCounts {
    pose_bits: u32,
    own_pose: u32,
    bucket_count: u32,
    mesh_count: u32,
}

struct FrameConfig {
    clip_from_world: mat4x4f,
    planes: array<vec4f, 6>,
    eye: vec3f,
    focal_px: f32,
    time_s: f32,
    inverse_alpha: f32,
    budget: u32,
    instance_count: u32,
    weight: u32,
    morph: u32,
    lod_depths_m: vec2f,
    dot_area_px2: f32,
    hold_far_m: f32,
    hold_px: f32,
    budget_in: u32,
    slack: u32,
    water_before_bits: u32,
    fog_per_m: f32,
    impostor_area_px2: f32,
}

struct CullRecord {
    visible: u32,
    weight: f32,
    area_px2: f32,
    distance_m: f32,
}

struct WeightSums {
    weight: f32,
    min_vertex_count: u32,
    visible_count: u32,
    wanted_count: u32,
    share: u32,
    is_scaled: u32,
    water_bits: u32,
    reserved: u32,
}

struct LodChoice {
    vertex_count: u32,
    triangle_count: u32,
}

struct InstanceBase {
    vertex_base: u32,
    triangle_base: u32,
}

struct Capacities {
    vertex_count: u32,
    triangle_count: u32,
    window_first: u32,
    window_count: u32,
}

struct DrawArgs {
    index_count: u32,
    instance_count: u32,
    first_index: u32,
    base_vertex: i32,
    first_instance: u32,
}

struct FrameTotals {
    visible_count: u32,
    vertex_count: u32,
    triangle_count: u32,
    min_vertex_count: u32,
    overflow: u32,
    needed_vertices: u32,
    needed_triangles: u32,
    draw_count: u32,
    wanted_count: u32,
    threshold_px: f32,
    occluded_count: u32,
    outside_count: u32,
    refused_count: u32,
}

struct FillState {
    low_bits: u32,
    high_bits: u32,
    low_count: u32,
    pass_number: u32,
    candidates: array<u32, FILL_CANDIDATES>,
    goal: u32,
    high_count: u32,
    smooth_bits: u32,
    edge: u32,
    low_cell: u32,
    high_cell: u32,
    low_slot: u32,
    high_slot: u32,
    cells: array<u32, FILL_TRIED>,
    heights: array<u32, FILL_TRIED>,
}

struct PyramidLevel {
    offset: u32,
    width: u32,
    height: u32,
    reserved: u32,
}

struct PyramidConfig {
    width_px: u32,
    height_px: u32,
    sample_count: u32,
    level_count: u32,
    reversed: u32,
    reserved_a: u32,
    reserved_b: u32,
    reserved_c: u32,
    levels: array<PyramidLevel, PYRAMID_LEVELS>,
}

struct PyramidStep {
    level: u32,
    reserved_a: u32,
    reserved_b: u32,
    reserved_c: u32,
}

struct SightTally {
    hidden_min_count: u32,
    hidden_count: u32,
}

struct Cascade {
    clip_from_world: mat4x4f,
    texel_m: f32,
    half_m: f32,
    details_per_m: f32,
    depth_per_m: f32,
}

struct ShadowConfig {
    cascades: array<Cascade, MAX_CASCADES>,
    cascade_count: u32,
    floor_m: f32,
    side: u32,
    reserved: u32,
}

struct CascadeStep {
    cascade: u32,
    has_choices: u32,
    reserved_a: u32,
    reserved_b: u32,
}

struct DiscreteConfig {
    half_diagonal_m: f32,
    reserved_a: u32,
    reserved_b: u32,
    reserved_c: u32,
}

struct BucketRecord {
    vertex_count: u32,
    triangle_count: u32,
    first_index: u32,
    coarser_vertex_count: u32,
    vertex_offset: u32,
    index_count: u32,
}

struct BucketSet {
    first_16: u32,
    count_16: u32,
    first_32: u32,
    level_count: u32,
}

struct BucketCounts {
    bucket_count: u32,
    count_16: u32,
    mesh_count: u32,
    palette_rows: u32,
    first_impostor: u32,
    first_fade: u32,
    palette_slots: u32,
    reserved: u32,
}

struct ImpostorSheet {
    tile_px: u32,
    azimuth_count: u32,
    elevation_count: u32,
    poses_a_layer: u32,
}

struct MorphRecord {
    coarser_vertex_count: u32,
    fraction: f32,
}

struct OriginRecord {
    position: vec3f,
    normal_oct: u32,
    uv: vec2f,
    color: u32,
    vertex: u32,
    joints: vec2u,
    weights: vec2u,
}

struct DrawnInstance {
    position: vec3f,
    scale: f32,
    turn: vec2f,
    fraction: f32,
    blend: f32,
    coarser_vertex_count: u32,
    material_offset: u32,
    first_texel: u32,
    second_texel: u32,
    vertex_base: u32,
    palette_row: u32,
    row_count: u32,
    storage: u32,
    leaving_first_texel: u32,
    leaving_second_texel: u32,
    leaving_blend: f32,
    leaving_share: f32,
}

struct SkinnedVertex {
    x: f32,
    y: f32,
    z: f32,
    normal_x: f32,
    normal_y: f32,
    normal_z: f32,
}

struct BucketPlace {
    vertex_base: u32,
    first: u32,
    vertex_count: u32,
    vertex_offset: u32,
}

struct DispatchArgs {
    x: u32,
    y: u32,
    z: u32,
}

struct BucketRange {
    first: u32,
    end: u32,
}

struct DrawCounts {
    count_16: u32,
    count_32: u32,
    dot_count: u32,
    impostor_count: u32,
    fade_count: u32,
}

struct SortPass {
    shift: u32,
    bits: u32,
    is_first: u32,
    reserved: u32,
}

struct FlockConfig {
    boid_count: u32,
    columns: u32,
    rows: u32,
    most_followed: u32,
    low: vec2f,
    speed_m_s: vec2f,
    separation: f32,
    alignment: f32,
    cohesion: f32,
    apart_m: f32,
    sight_m: f32,
    radius_m: f32,
    rim: f32,
    bodies_m: f32,
    most_push_m: f32,
    most_m_s2: f32,
    turn_hz: f32,
    step_s: f32,
    stands_below_m_s: vec2f,
    runs_from_m_s: vec2f,
    time_s: f32,
    least_clip_speed_m_s: f32,
    shortest_gait_s: f32,
    fade_s: f32,
}

struct BoidRecord {
    place: vec2f,
    velocity: vec2f,
    yaw_rad: f32,
    walked_m: f32,
    pace_m_s: f32,
    gait: u32,
    gait_before: u32,
    ran_m: f32,
    changed_s: f32,
    wider_m: f32,
}

struct SortedBoid {
    place: vec2f,
    velocity: vec2f,
    wider_m: f32,
    reserved: u32,
}

struct BoidTraits {
    mover: u32,
    scale: f32,
    start: f32,
    reserved: u32,
}

struct GaitClipRecord {
    displacement_m: vec3f,
    duration_s: f32,
    ground_speed_m_s: f32,
    clip: u32,
    reserved_a: u32,
    reserved_b: u32,
    root_path_m: array<vec2f, ROOT_PATH_POINTS>,
}

struct MoverRecord {
    clips: array<GaitClipRecord, 3>,
    character: u32,
    scale: f32,
    run_ahead_turns: f32,
    reserved: u32,
}

struct FeedConfig {
    most: u32,
    character_count: u32,
    reserved_a: u32,
    reserved_b: u32,
}

struct FeedState {
    count: u32,
    refused_count: u32,
}

struct MarkConfig {
    corners: array<vec4f, 8>,
    view: u32,
    has_choices: u32,
    reserved_a: u32,
    reserved_b: u32,
}

struct DrawConfig {
    ray_x: vec3f,
    width_px: f32,
    ray_y: vec3f,
    height_px: f32,
    ray_w: vec3f,
    layer_side: f32,
}

// The number of a workgroup in a folded dispatch.
fn group_number(workgroup: vec3u) -> u32 {
    return workgroup.y * FOLD_COLUMNS + workgroup.x;
}

// a + b, or the largest number: a count that overflows must not come back small.
fn saturating_add(a: u32, b: u32) -> u32 {
    let sum = a + b;
    return select(sum, 0xffffffffu, sum < a);
}

// Whether an instance is its impostor, or crosses over to it. Of those on their way, `area_px2` is at least `impostor_area_px2`.
fn stands_in(min_vertex_count: u32, area_px2: f32, impostor_area_px2: f32) -> bool {
    return min_vertex_count > IMPOSTOR_VERTICES && area_px2 < IMPOSTOR_FADE * impostor_area_px2;
}

// Vertices that an instance has at least: of one dot where it may be dots, of its impostor where it is that, with the coarsest mesh
// where it crosses over, else of the coarsest mesh.
fn least_count(min_vertex_count: u32, area_px2: f32, dot_area_px2: f32, impostor_area_px2: f32) -> u32 {
    if area_px2 < dot_area_px2 {
        return min(min_vertex_count, DOT_VERTICES);
    }
    if stands_in(min_vertex_count, area_px2, impostor_area_px2) {
        return IMPOSTOR_VERTICES + select(0u, min_vertex_count, area_px2 >= impostor_area_px2);
    }
    return min_vertex_count;
}

// What it takes of the budget at least.
fn least_spent(
    character: CharacterRecord,
    area_px2: f32,
    dot_area_px2: f32,
    impostor_area_px2: f32,
    budget_in: u32,
) -> u32 {
    if budget_in != BUDGET_TRIANGLES {
        return least_count(character.min_vertex_count, area_px2, dot_area_px2, impostor_area_px2);
    }
    let count = character.min_triangle_count;
    if area_px2 < dot_area_px2 {
        return min(count, 1u);
    }
    if stands_in(character.min_vertex_count, area_px2, impostor_area_px2) {
        return IMPOSTOR_TRIANGLES + select(0u, count, area_px2 >= impostor_area_px2);
    }
    return count;
}

// What a level takes of the budget.
fn spent(level: vec2u, budget_in: u32) -> u32 {
    return select(level.x, level.y, budget_in == BUDGET_TRIANGLES);
}

// Bucket of a character's quantised level, 0 the coarsest.
fn bucket_of_level(levels: BucketSet, level: u32) -> u32 {
    if level < levels.count_16 {
        return levels.first_16 + level;
    }
    return levels.first_32 + level - levels.count_16;
}

// Entry of the error tables: 32 for each doubling of one over the metres allowed.
fn error_entry(character: u32, per_metre: f32) -> u32 {
    let entry = (max(bitcast<u32>(per_metre), ERROR_FIRST_BITS) - ERROR_FIRST_BITS) >> ERROR_SHIFT;
    return character * ERROR_ENTRIES + min(entry, ERROR_ENTRIES - 1u);
}

// Pixels at one over the water's height, for the error metric.
fn threshold_px(weight: u32, water_bits: u32) -> f32 {
    return select(0.0, 1.0 / max(bitcast<f32>(water_bits), 1e-30), weight == WEIGHT_ERROR);
}
