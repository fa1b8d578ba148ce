//! Do WGSL and Rust agree? Sizes, offsets and constants by naga; no GPU needed.

use crowd_pack::{CharacterRecord, ClipRecord, LodRecord, MaterialRecord, VertexRecord, material_flags};
use crowd_raster::light;
use crowd_stages::gpu::{self, ANIMATION_HEIGHT, ANIMATION_WIDTH};
use crowd_stages::{
    BoidRecord, BoidTraits, BucketCounts, BucketPlace, BucketRange, BucketRecord, BucketSet, BudgetIn, Capacities,
    Cascade, CascadeStep, CullRecord, DiscreteConfig, DispatchArgs, DrawArgs, DrawConfig, DrawCounts, DrawnInstance,
    FeedConfig, FeedState, FillState, FlockConfig, FrameConfig, FrameTotals, GaitClipRecord, ImpostorSheet,
    InstanceBase, InstanceRecord, LodChoice, MarkConfig, MorphRecord, MotionRecord, MotionSchedule, MotionStretch,
    MoverRecord, OriginRecord, PoseCounts, PyramidConfig, PyramidLevel, PyramidStep, ROOT_PATH_POINTS, SUN_DIRECTION,
    ShadowConfig, SightTally, SkinnedVertex, SortPass, SortedBoid, View, Weight, WeightSums, cpu, dispatch, overflow,
    sight,
};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Expression, Literal, Module, StorageAccess, TypeInner};
use std::mem::{offset_of, size_of};

/// A struct's name, size and fields with their offsets.
type Layout = (&'static str, usize, Vec<(&'static str, usize)>);

/// The layout of a Rust record. The pattern makes the compiler insist on all fields.
macro_rules! layout {
    ($record:ident { $($field:ident),* $(,)? }) => {{
        #[allow(dead_code, reason = "only there to be compiled: a field left out of the list is an error")]
        fn all_fields($record { $($field: _),* }: $record) {}
        (stringify!($record), size_of::<$record>(), vec![$((stringify!($field), offset_of!($record, $field))),*])
    }};
}

fn rust_layouts() -> Vec<Layout> {
    vec![
        layout!(VertexRecord { position, normal_oct, uv, color, material_class, joints, weights }),
        layout!(LodRecord { vertex_count, triangle_count }),
        layout!(CharacterRecord {
            vertex_offset,
            vertex_count,
            triangle_offset,
            triangle_count,
            lod_offset,
            min_vertex_count,
            min_triangle_count,
            joint_count,
            clip_offset,
            clip_count,
            material_offset,
            material_count,
            sphere,
            box_min,
            height_m,
            box_max,
            inverse_bind_offset,
            joint_storage,
            storage_error_m,
            reserved,
        }),
        layout!(ClipRecord {
            texel_offset,
            frame_count,
            duration_s,
            ground_speed_m_s,
            sphere,
            root_displacement_m,
            loop_gap_m,
        }),
        layout!(MaterialRecord { base_color, image, flags, alpha_cutoff, reserved }),
        layout!(InstanceRecord {
            position,
            yaw_rad,
            scale,
            character,
            clip,
            phase_s,
            leaving_clip,
            leaving_phase_s,
            leaving_share,
            held_s,
        }),
        layout!(MotionStretch {
            start_s,
            fade_s,
            clip,
            turns,
            first_rate_hz,
            rate_hz,
            left_clip,
            left_turns,
            left_rate_hz,
            left_last_rate_hz,
            reserved_a,
            reserved_b,
        }),
        layout!(MotionSchedule { first, count, loop_s, reserved }),
        layout!(MotionRecord { schedule, ahead_s }),
        layout!(PoseCounts { pose_bits, own_pose, bucket_count, mesh_count }),
        layout!(FrameConfig {
            clip_from_world,
            planes,
            eye,
            focal_px,
            time_s,
            inverse_alpha,
            budget,
            instance_count,
            weight,
            morph,
            lod_depths_m,
            dot_area_px2,
            hold_far_m,
            hold_px,
            budget_in,
            slack,
            water_before_bits,
            fog_per_m,
            impostor_area_px2,
        }),
        layout!(CullRecord { visible, weight, area_px2, distance_m }),
        layout!(WeightSums {
            weight,
            min_vertex_count,
            visible_count,
            wanted_count,
            share,
            is_scaled,
            water_bits,
            reserved,
        }),
        layout!(LodChoice { vertex_count, triangle_count }),
        layout!(InstanceBase { vertex_base, triangle_base }),
        layout!(Capacities { vertex_count, triangle_count, window_first, window_count }),
        layout!(DrawArgs { index_count, instance_count, first_index, base_vertex, first_instance }),
        layout!(FrameTotals {
            visible_count,
            vertex_count,
            triangle_count,
            min_vertex_count,
            overflow,
            needed_vertices,
            needed_triangles,
            draw_count,
            wanted_count,
            threshold_px,
            occluded_count,
            outside_count,
            refused_count,
        }),
        layout!(FillState {
            low_bits,
            high_bits,
            low_count,
            pass_number,
            candidates,
            goal,
            high_count,
            smooth_bits,
            edge,
            low_cell,
            high_cell,
            low_slot,
            high_slot,
            cells,
            heights,
        }),
        layout!(PyramidLevel { offset, width, height, reserved }),
        layout!(PyramidConfig {
            width_px,
            height_px,
            sample_count,
            level_count,
            reversed,
            reserved_a,
            reserved_b,
            reserved_c,
            levels,
        }),
        layout!(PyramidStep { level, reserved_a, reserved_b, reserved_c }),
        layout!(SightTally { hidden_min_count, hidden_count }),
        layout!(Cascade { clip_from_world, texel_m, half_m, details_per_m, depth_per_m }),
        layout!(ShadowConfig { cascades, cascade_count, floor_m, side, reserved }),
        layout!(CascadeStep { cascade, has_choices, reserved_a, reserved_b }),
        layout!(DiscreteConfig { half_diagonal_m, reserved_a, reserved_b, reserved_c }),
        layout!(BucketRecord {
            vertex_count,
            triangle_count,
            first_index,
            coarser_vertex_count,
            vertex_offset,
            index_count
        }),
        layout!(BucketSet { first_16, count_16, first_32, level_count }),
        layout!(BucketCounts {
            bucket_count,
            count_16,
            mesh_count,
            palette_rows,
            first_impostor,
            first_fade,
            palette_slots,
            reserved,
        }),
        layout!(ImpostorSheet { tile_px, azimuth_count, elevation_count, poses_a_layer }),
        layout!(MorphRecord { coarser_vertex_count, fraction }),
        layout!(OriginRecord { position, normal_oct, uv, color, vertex, joints, weights }),
        layout!(DrawnInstance {
            position,
            scale,
            turn,
            fraction,
            blend,
            coarser_vertex_count,
            material_offset,
            first_texel,
            second_texel,
            vertex_base,
            palette_row,
            row_count,
            storage,
            leaving_first_texel,
            leaving_second_texel,
            leaving_blend,
            leaving_share,
        }),
        layout!(SkinnedVertex { x, y, z, normal_x, normal_y, normal_z }),
        layout!(BucketPlace { vertex_base, first, vertex_count, vertex_offset }),
        layout!(DispatchArgs { x, y, z }),
        layout!(BucketRange { first, end }),
        layout!(DrawCounts { count_16, count_32, dot_count, impostor_count, fade_count }),
        layout!(SortPass { shift, bits, is_first, reserved }),
        layout!(FlockConfig {
            boid_count,
            columns,
            rows,
            most_followed,
            low,
            speed_m_s,
            separation,
            alignment,
            cohesion,
            apart_m,
            sight_m,
            radius_m,
            rim,
            bodies_m,
            most_push_m,
            most_m_s2,
            turn_hz,
            step_s,
            stands_below_m_s,
            runs_from_m_s,
            time_s,
            least_clip_speed_m_s,
            shortest_gait_s,
            fade_s,
        }),
        layout!(BoidRecord {
            place,
            velocity,
            yaw_rad,
            walked_m,
            pace_m_s,
            gait,
            gait_before,
            ran_m,
            changed_s,
            wider_m,
        }),
        layout!(SortedBoid { place, velocity, wider_m, reserved }),
        layout!(BoidTraits { mover, scale, start, reserved }),
        layout!(GaitClipRecord {
            displacement_m,
            duration_s,
            ground_speed_m_s,
            clip,
            reserved_a,
            reserved_b,
            root_path_m,
        }),
        layout!(MoverRecord { clips, character, scale, run_ahead_turns, reserved }),
        layout!(FeedConfig { most, character_count, reserved_a, reserved_b }),
        layout!(FeedState { count, refused_count }),
        layout!(MarkConfig { corners, view, has_choices, reserved_a, reserved_b }),
        layout!(DrawConfig { ray_x, width_px, ray_y, height_px, ray_w, layer_side }),
    ]
}

/// Every shader as it is compiled, by name.
fn sources() -> Vec<(&'static str, String)> {
    vec![
        ("cull_instances", gpu::CullInstances::source()),
        ("sum_weights", gpu::SumWeights::source()),
        ("select_lod", gpu::SelectLod::source()),
        ("fit_budget", gpu::FitBudget::source()),
        ("scan_counts", gpu::ScanCounts::source()),
        ("place_vertices", gpu::PlaceVertices::source()),
        ("reform_triangles", gpu::ReformTriangles::source()),
        ("write_draw_args", gpu::WriteDrawArgs::source()),
        ("fill_budget", gpu::FillBudget::source()),
        ("cull_by_depth", gpu::CullByDepth::source()),
        ("key_points", gpu::KeyPoints::source()),
        ("key_instances", gpu::KeyInstances::source()),
        ("sort_instances", gpu::SortInstances::source()),
        ("sort_at_once", gpu::SortAtOnce::source()),
        ("select_casters", gpu::SelectCasters::source()),
        ("lend_vertices", gpu::LendVertices::source()),
        ("recall_seen", gpu::RecallSeen::source()),
        ("build_pyramid", gpu::BuildPyramid::source()),
        ("test_occlusion", gpu::TestOcclusion::source()),
        ("join_phases", gpu::JoinPhases::source()),
        ("write_bucket_args", gpu::WriteBucketArgs::source()),
        ("gather_drawn", gpu::GatherDrawn::source()),
        ("place_buckets", gpu::PlaceBuckets::source()),
        ("blend_palettes", gpu::BlendPalettes::source()),
        ("skin_vertices", gpu::SkinVertices::source()),
        ("play_motion", gpu::PlayMotion::source()),
        ("admit_instances", gpu::AdmitInstances::source()),
        ("cell_boids", gpu::CellBoids::source()),
        ("fill_cells", gpu::FillCells::source()),
        ("steer_boids", gpu::SteerBoids::source()),
        ("place_boids", gpu::PlaceBoids::source()),
        ("key_poses", gpu::KeyPoses::source()),
        ("find_leaders", gpu::FindLeaders::source()),
        ("share_poses", gpu::SharePoses::source()),
        ("hold_poses", gpu::HoldPoses::source()),
        ("backdrop", gpu::backdrop_source()),
        ("crowd", gpu::crowd_source()),
        ("crowd of software", gpu::crowd_source_of_software()),
        ("scenery", gpu::scenery_source()),
        ("marks", gpu::marks_source()),
    ]
}

fn parse(source: &str) -> Module {
    naga::front::wgsl::parse_str(source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)))
}

/// The first place where the WGSL's struct is not the Rust record. Fields called `reserved...` are only space.
fn layout_difference(module: &Module, layout: &Layout) -> Option<String> {
    let (name, size, fields) = layout;
    let Some(TypeInner::Struct { members, span }) =
        module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).map(|(_, ty)| &ty.inner)
    else {
        return Some(format!("{name}: no such struct in the shaders"));
    };
    if *span as usize != *size {
        return Some(format!("{name}: {span} bytes in WGSL, {size} in Rust"));
    }
    let in_wgsl: Vec<(&str, usize)> =
        members.iter().map(|m| (m.name.as_deref().unwrap_or(""), m.offset as usize)).filter(|m| !is_space(m)).collect();
    let in_rust: Vec<(&str, usize)> = fields.iter().copied().filter(|m| !is_space(m)).collect();
    (in_wgsl != in_rust).then(|| format!("{name}: {in_wgsl:?} in WGSL, {in_rust:?} in Rust"))
}

fn is_space(field: &(&str, usize)) -> bool {
    field.0.starts_with("reserved")
}

/// The numbers of a constant, one for a scalar, three for a vector.
fn constant(module: &Module, name: &str) -> Option<Vec<f64>> {
    let (_, constant) = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name))?;
    numbers(module, constant.init)
}

fn numbers(module: &Module, expression: naga::Handle<Expression>) -> Option<Vec<f64>> {
    match &module.global_expressions[expression] {
        Expression::Literal(Literal::F32(value)) => Some(vec![f64::from(*value)]),
        Expression::Literal(Literal::U32(value)) => Some(vec![f64::from(*value)]),
        Expression::Literal(Literal::I32(value)) => Some(vec![f64::from(*value)]),
        Expression::Compose { components, .. } => {
            let parts: Option<Vec<Vec<f64>>> = components.iter().map(|part| numbers(module, *part)).collect();
            Some(parts?.concat())
        }
        _ => None,
    }
}

fn constant_difference(module: &Module, name: &str, rust: &[f64]) -> Option<String> {
    let wgsl = constant(module, name);
    (wgsl.as_deref() != Some(rust)).then(|| format!("{name}: {wgsl:?} in WGSL, {rust:?} in Rust"))
}

#[test]
fn every_shader_is_valid_without_extra_capabilities() {
    for (name, source) in sources() {
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        validator.validate(&parse(&source)).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&source)));
    }
}

#[test]
fn structs_have_the_same_sizes_and_offsets() {
    let module = parse(&gpu::crowd_source());
    for layout in rust_layouts() {
        assert_eq!(layout_difference(&module, &layout), None);
    }
    let structs = module.types.iter().filter(|(_, ty)| matches!(ty.inner, TypeInner::Struct { .. })).count();
    let own = [
        "FramePair",
        "Surface",
        "MeshVertex",
        "MeshOrigin",
        "Owner",
        "Moved",
        "Dot",
        "PointSurface",
        "ShadowPlace",
        "Pose",
    ]
    .len();
    let of_impostors = ["ImpostorSurface", "FadingSurface", "Masked"].len();
    assert_eq!(structs - own - of_impostors, rust_layouts().len(), "each struct of records.wgsl has its Rust record");
}

#[test]
fn a_moved_field_a_renamed_one_and_another_size_are_seen() {
    let difference = |wgsl: &str| layout_difference(&parse(wgsl), &layout!(LodChoice { vertex_count, triangle_count }));
    assert_eq!(difference("struct LodChoice { vertex_count: u32, triangle_count: u32 }"), None);
    assert!(difference("struct LodChoice { triangle_count: u32, vertex_count: u32 }").is_some());
    assert!(difference("struct LodChoice { vertex_count: u32, triangles: u32 }").is_some());
    assert!(difference("struct LodChoice { vertex_count: u32, triangle_count: vec2u }").is_some());
    assert!(difference("struct Choice { vertex_count: u32, triangle_count: u32 }").is_some());
}

#[test]
fn constants_are_the_same() {
    let module = parse(&gpu::crowd_source());
    let numbers = [
        ("NONE", crowd_pack::NONE),
        ("FOLD_COLUMNS", dispatch::FOLD_COLUMNS),
        ("BLOCK_SIZE", dispatch::BLOCK_SIZE),
        ("INSTANCE_GROUP_SIZE", dispatch::INSTANCE_GROUP_SIZE),
        ("FILL_CANDIDATES", dispatch::FILL_CANDIDATES),
        ("FILL_TRIED", dispatch::FILL_TRIED),
        ("FILL_CHUNKS", dispatch::FILL_CHUNKS),
        ("SORT_BLOCK_SIZE", dispatch::SORT_BLOCK_SIZE),
        ("SORT_RUN", dispatch::SORT_RUN),
        ("DOT_LEVELS", dispatch::DOT_LEVELS),
        ("DOT_VERTICES", dispatch::DOT_VERTICES),
        ("POINT_LEVELS", dispatch::POINT_LEVELS),
        ("IMPOSTOR_VERTICES", dispatch::IMPOSTOR_VERTICES),
        ("IMPOSTOR_TRIANGLES", dispatch::IMPOSTOR_TRIANGLES),
        ("SORT_BLOCK_SIZE", 1 << dispatch::MAX_DIGIT_BITS),
        ("OVERFLOW_BUDGET", overflow::BUDGET),
        ("OVERFLOW_VERTICES", overflow::VERTICES),
        ("OVERFLOW_TRIANGLES", overflow::TRIANGLES),
        ("WEIGHT_AREA", Weight::Area as u32),
        ("WEIGHT_ERROR", Weight::Error as u32),
        ("ROOT_PATH_POINTS", ROOT_PATH_POINTS as u32),
        ("BUDGET_TRIANGLES", BudgetIn::Triangles as u32),
        ("MAX_CASCADES", dispatch::MAX_CASCADES),
        ("PYRAMID_LEVELS", dispatch::PYRAMID_LEVELS),
        ("RESERVE_PART", dispatch::RESERVE_PART),
        ("SIGHT_SEEN", sight::SEEN),
        ("SIGHT_HIDDEN", sight::HIDDEN),
        ("SIGHT_DRAWN", sight::DRAWN),
        ("ERROR_ENTRIES", dispatch::ERROR_ENTRIES),
        ("ERROR_FIRST_BITS", dispatch::ERROR_FIRST_BITS),
        ("ERROR_SHIFT", dispatch::ERROR_SHIFT),
        ("WEIGHT_AREA_DISTANCE", Weight::AreaDistance as u32),
        ("JOINTS_F32", crowd_pack::JointStorage::F32.code()),
        ("JOINTS_F16", crowd_pack::JointStorage::F16.code()),
        ("JOINTS_QUANTIZED", crowd_pack::JointStorage::Quantized.code()),
        ("VIEW_LEVELS", View::Levels as u32),
        ("VIEW_DENSITY", View::Density as u32),
        ("VIEW_REPRESENTATION", View::Representation as u32),
        ("VIEW_OCCLUSION", View::Occlusion as u32),
        ("MATERIAL_DOUBLE_SIDED", material_flags::DOUBLE_SIDED),
        ("MATERIAL_UNLIT", material_flags::UNLIT),
        ("MATERIAL_FLAT", material_flags::FLAT),
        ("MATERIAL_WRAP_U_SHIFT", material_flags::WRAP_U_SHIFT),
        ("MATERIAL_WRAP_V_SHIFT", material_flags::WRAP_V_SHIFT),
        ("MATERIAL_WRAP_MASK", material_flags::WRAP_MASK),
        ("ANIMATION_WIDTH", ANIMATION_WIDTH),
        ("ANIMATION_HEIGHT", ANIMATION_HEIGHT),
    ];
    for (name, rust) in numbers {
        assert_eq!(constant_difference(&module, name, &[f64::from(rust)]), None);
    }
    let fade = f64::from(crowd_stages::IMPOSTOR_FADE);
    assert_eq!(constant_difference(&module, "IMPOSTOR_FADE", &[fade]), None);
    assert!(constant_difference(&module, "BLOCK_SIZE", &[128.0]).is_some(), "the comparison can fail");
    let module = parse(&gpu::HoldPoses::source());
    let seconds = [
        ("HOLD_TICK_S", cpu::HOLD_TICK_S),
        ("HOLD_SHORTEST_S", cpu::HOLD_SHORTEST_S),
        ("HOLD_LONGEST_S", cpu::HOLD_LONGEST_S),
    ];
    for (name, rust) in seconds {
        assert_eq!(constant_difference(&module, name, &[f64::from(rust)]), None);
    }
}

#[test]
fn light_looks_along_the_axes_of_the_maps() {
    let module = parse(&gpu::crowd_source());
    let towards = glam::Vec3::from(SUN_DIRECTION).as_dvec3().normalize();
    let across = glam::DVec3::Y.cross(towards).normalize();
    for (name, axis) in [("SUN_ACROSS", across), ("SUN_ALONG", towards.cross(across))] {
        let found = constant(&module, name).expect("a vector");
        let apart = glam::DVec3::from_slice(&found).distance(axis);
        assert!(apart < 2e-7, "{name}: {found:?} in WGSL, {axis} in Rust");
    }
}

#[test]
fn every_stage_is_looked_at() {
    let looked_at: Vec<&str> = sources().into_iter().map(|(name, _)| name).collect();
    for stage in gpu::STAGES {
        assert!(looked_at.contains(&stage), "{stage} has no source here");
    }
}

#[test]
fn light_has_the_numbers_of_the_rasteriser() {
    let module = parse(&gpu::crowd_source());
    let colors = [
        ("SUN_DIRECTION", light::SUN_DIRECTION),
        ("SUN_COLOR", light::SUN_COLOR),
        ("SKY_AMBIENT", light::SKY_AMBIENT),
        ("GROUND_AMBIENT", light::GROUND_AMBIENT),
        ("SKY_HORIZON", light::SKY_HORIZON),
        ("SKY_ZENITH", light::SKY_ZENITH),
        ("GROUND", light::GROUND),
        ("GROUND_LINE", light::GROUND_LINE),
    ];
    for (name, rust) in colors {
        assert_eq!(constant_difference(&module, name, &rust.map(f64::from)), None);
    }
    let lengths = [
        ("EXPOSURE", light::EXPOSURE),
        ("FADE_M", light::FADE_M),
        ("GROUND_Y_M", light::GROUND_Y_M),
        ("LINE_WIDTH_M", light::LINE_WIDTH_M),
        ("LINE_STRENGTH", light::LINE_STRENGTH),
        ("WIDE_LINE_WIDTH_M", light::WIDE_LINE_WIDTH_M),
        ("FOG_LAYER_M", light::FOG_LAYER_M),
    ];
    for (name, rust) in lengths {
        assert_eq!(constant_difference(&module, name, &[f64::from(rust)]), None);
    }
    assert_eq!(SUN_DIRECTION, light::SUN_DIRECTION, "the maps look where the light comes from");
    let declared =
        include_str!("../../../shaders/shared/light.wgsl").lines().filter(|l| l.starts_with("const ")).count();
    assert_eq!(declared, colors.len() + lengths.len(), "each constant of light.wgsl is compared");
}

#[test]
fn no_shader_binds_more_storage_buffers_than_default_limits_allow() {
    for (name, source) in sources() {
        let module = parse(&source);
        let storage = |write: bool| {
            module
                .global_variables
                .iter()
                .filter(|(_, variable)| match variable.space {
                    AddressSpace::Storage { access } => !write || access.contains(StorageAccess::STORE),
                    _ => false,
                })
                .count()
        };
        // The materials of the draw are read by the fragment shader, the others by the vertex shader.
        let allowed = if name.starts_with("crowd") { 8 + 1 } else { 8 };
        assert!(storage(false) <= allowed, "{name}: {} storage buffers", storage(false));
        let draws = ["crowd", "crowd of software", "backdrop", "scenery", "marks"].contains(&name);
        assert_eq!(storage(true) > 0, !draws, "{name}: stages write, draws do not");
    }
}

/// What is wrong with a line: an atomic that others than its workgroup see, or one whose result says who came first.
fn depends_on_who_comes_first(line: &str) -> bool {
    let line = line.trim();
    let changes = ["atomicAdd", "atomicSub", "atomicOr", "atomicAnd", "atomicXor", "atomicMax", "atomicMin"];
    let is_shared = line.contains("var<storage") && line.contains("atomic<");
    let is_exchange = line.contains("atomicExchange") || line.contains("atomicCompare");
    is_shared || is_exchange || changes.iter().any(|word| line.contains(word) && !line.starts_with(word))
}

#[test]
fn compaction_never_appends_atomically() {
    for (name, source) in sources() {
        let line = source.lines().find(|line| depends_on_who_comes_first(line));
        assert_eq!(line, None, "{name}: places come from prefix sums, so that the order is fixed");
    }
}

#[test]
fn an_atomic_append_is_seen() {
    for line in [
        "    let place = atomicAdd(&count, 1u);",
        "@group(0) @binding(2) var<storage, read_write> count: atomic<u32>;",
        "list[atomicAdd(&count, 1u)] = i;",
    ] {
        assert!(depends_on_who_comes_first(line), "{line}");
    }
    assert!(!depends_on_who_comes_first("    atomicAdd(&tallies[digit], 1u);"));
}

/// What the last of an entry point's GLSL writer refused, OpenGL ES 3.1: the least that the player asks for.
fn glsl_refusal(source: &str) -> Option<String> {
    use naga::back::{PipelineConstants, glsl, pipeline_constants::process_overrides};
    let module = parse(source);
    let info = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).expect("it is sound");
    module.entry_points.iter().find_map(|entry| {
        let of_entry = Some((entry.stage, entry.name.as_str()));
        let (module, info) =
            process_overrides(&module, &info, of_entry, &PipelineConstants::default()).expect("defaults");
        let pipeline =
            glsl::PipelineOptions { shader_stage: entry.stage, entry_point: entry.name.clone(), multiview: None };
        let (options, mut text) = (glsl::Options::default(), String::new());
        let written = glsl::Writer::new(&mut text, &module, &info, &options, &pipeline, Default::default());
        let refusal = written.and_then(|mut writer| writer.write().map(|_| ())).err()?;
        Some(format!("{}: {refusal}", entry.name))
    })
}

#[test]
fn what_reformation_draws_with_can_be_written_for_opengl() {
    // Occlusion culling is of the bucketed technique, which OpenGL cannot draw; what software adapters draw with is of Vulkan.
    let of_others = ["build_pyramid", "crowd of software"];
    for (name, source) in sources().into_iter().filter(|(name, _)| !of_others.contains(name)) {
        assert_eq!(glsl_refusal(&source), None, "{name}");
    }
    let depth = "@group(0) @binding(0) var map: texture_depth_2d_array;
        @fragment fn look() -> @location(0) vec4f { return vec4f(textureLoad(map, vec2i(0), 0, 0)); }";
    assert!(glsl_refusal(depth).is_some(), "the test can fail");
}
