//! Two characters small enough to check by hand: a flag of two triangles and a tetrahedron with a cut edge.

use crowd_pack::{
    AnimationLayout, CharacterRecord, ClipRecord, Credits, Finish, FinishBase, FinishTexture, Finishes, ImpostorRecord,
    JointStorage, LevelRecord, LevelSetRecord, LodRecord, Manifest, ManifestBlocked, ManifestCharacter, ManifestClip,
    ManifestContact, ManifestDiscrete, ManifestJoint, ManifestLevel, ManifestMeasured, ManifestMeasuring, ManifestNode,
    ManifestPart, ManifestSeams, ManifestTarget, ManifestTrack, MaterialRecord, NONE, PackContents, Rig, VertexRecord,
    material_flags, store_frame,
};

/// A PNG of 2 x 2 pixels: red, white; white, blue.
pub const PNG: [u8; 78] = [
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 2, 0, 0, 0, 2, 8, 2, 0, 0, 0, 253, 212, 154,
    115, 0, 0, 0, 21, 73, 68, 65, 84, 120, 218, 99, 56, 33, 167, 241, 255, 255, 127, 6, 32, 150, 179, 217, 2, 0, 56,
    178, 8, 23, 74, 246, 24, 173, 0, 0, 0, 0, 73, 69, 78, 68, 174, 66, 96, 130,
];

const IDENTITY: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// The pack in one of the two animation layouts, joints as full floats.
pub fn contents(layout: AnimationLayout) -> PackContents {
    stored(layout, JointStorage::F32)
}

/// The pack with its joints stored like that, in the split layout as full floats.
pub fn stored(layout: AnimationLayout, storage: JointStorage) -> PackContents {
    let mut pack = PackContents {
        manifest: Manifest { generator: "by hand".to_owned(), animation_layout: layout, characters: Vec::new() },
        ..PackContents::default()
    };
    add_flag(&mut pack, storage);
    add_tetrahedron(&mut pack, storage);
    pack
}

/// The pack with impostors: one pose of the flag's clip, two of one of the tetrahedron's two.
pub fn with_impostors() -> PackContents {
    let mut pack = contents(AnimationLayout::Premultiplied3x4);
    for (clip_count, pose_count) in [(1, 1), (1, 2)] {
        let shape = ImpostorRecord {
            tile_px: 8,
            azimuth_count: 2,
            elevation_count: 1,
            pose_count,
            clip_count,
            ..ImpostorRecord::default()
        };
        // Nobody decodes them here.
        pack.add_impostors(shape, &PNG, &PNG[..70]);
    }
    pack
}

/// The pack with finishes: the first material has everything, the second nothing, the third lives by names alone.
pub fn with_finishes() -> PackContents {
    let mut pack = contents(AnimationLayout::Premultiplied3x4);
    let image = pack.add_finish_image(&PNG, 2, 2, 0);
    let other = pack.add_finish_image(&PNG[..70], 2, 1, 0);
    let texture = |image, sampler, weight| Some(FinishTexture { image, sampler, weight });
    let full = Finish {
        metallic: 0.75,
        roughness: 0.5,
        metallic_roughness: texture(image, 0, 1.0),
        normal: texture(other, 0b0110, -2.0),
        occlusion: texture(image, 0b1001, 0.25),
        emissive: [1.0, 0.5, 0.0],
        emissive_strength: 10.0,
        emissive_texture: texture(other, 0b0101, 1.0),
        ior: Some(1.5),
        specular: Some([0.5, 1.0, 2.0, 3.0]),
        specular_texture: texture(image, 0, 1.0),
        specular_color_texture: None,
        blend: true,
        base: Some(FinishBase { color: [0.5, 0.25, 1.0, 0.75], texture: texture(image, 0, 1.0) }),
    };
    pack.finishes = Finishes {
        materials: vec![full, Finish::default(), Finish::default()],
        image_names: vec!["coat".to_owned()],
        finish_image_names: vec!["bumps".to_owned(), String::new()],
        skin_names: vec![String::new(), "rig".to_owned()],
        rigs: vec![Rig::default(); 2],
        credits: vec![
            Credits { copyright: "CC-BY 4.0 Ada".to_owned(), extras: r#"{"title":"flag"}"#.to_owned() },
            Credits::default(),
        ],
    };
    // The tetrahedron's joints stand behind one that nothing follows; the curves of its clips come once more.
    let tetrahedron = &pack.manifest.characters[1];
    let joints = tetrahedron.joints.iter().cloned();
    pack.finishes.rigs[1] = Rig {
        joints: std::iter::once(ManifestJoint { node: 1, inverse_bind: [0.5; 16] }).chain(joints).collect(),
        places: (1..=tetrahedron.joints.len() as u32).collect(),
        tracks: tetrahedron.clips.iter().map(|clip| clip.tracks.clone()).collect(),
    };
    pack
}

/// Where the next character's elements go.
fn next_character(pack: &PackContents) -> CharacterRecord {
    let split = pack.manifest.animation_layout == AnimationLayout::Split4x4;
    CharacterRecord {
        vertex_offset: pack.vertices.len() as u32,
        triangle_offset: pack.triangles.len() as u32,
        lod_offset: pack.lods.len() as u32,
        clip_offset: pack.clips.len() as u32,
        material_offset: pack.materials.len() as u32,
        inverse_bind_offset: if split { pack.inverse_binds.len() as u32 } else { 0 },
        ..CharacterRecord::default()
    }
}

/// ```text
///   2---3     vertex 3 moves into 2: the second triangle vanishes
///   | \ |
///   0---1
/// ```
fn add_flag(pack: &mut PackContents, storage: JointStorage) {
    let image = pack.add_image(&PNG, 2, 2, 0);
    let record = CharacterRecord { joint_storage: storage.code(), ..next_character(pack) };
    for (x, y, class) in [(0.0, 1.0, 2), (1.0, 1.0, 2), (0.0, 2.0, 2), (1.0, 2.0, 0)] {
        let uv = [x, 2.0 - y];
        let joints = ([0; 4], [1.0, 0.0, 0.0, 0.0]);
        pack.vertices.push(VertexRecord::new([x, y, 0.0], [0.0, 0.0, 1.0], uv, [1.0; 4], 0, class, joints.0, joints.1));
    }
    pack.triangles.extend([[0, 1, 2], [1, 3, 2]]);
    pack.collapse_map.extend([0, 1, 2, 2]);
    let (coarse, full) =
        (LodRecord { vertex_count: 3, triangle_count: 1 }, LodRecord { vertex_count: 4, triangle_count: 2 });
    pack.lods.extend([coarse, coarse, coarse, coarse, full]);
    let sphere = [0.5, 1.5, 0.0, 0.75];
    push_clip(pack, storage, &[&[[0.0; 3]]], 0.0, sphere);
    push_inverse_binds(pack, &[IDENTITY]);
    pack.materials.push(MaterialRecord {
        base_color: [1.0; 4],
        image,
        flags: material_flags::DOUBLE_SIDED | (1 << material_flags::WRAP_U_SHIFT) | (2 << material_flags::WRAP_V_SHIFT),
        alpha_cutoff: 0.5,
        reserved: 0,
    });
    pack.characters.push(CharacterRecord {
        vertex_count: 4,
        triangle_count: 2,
        min_vertex_count: 3,
        min_triangle_count: 1,
        joint_count: 1,
        clip_count: 1,
        material_count: 1,
        sphere,
        box_min: [0.0, 1.0, 0.0],
        height_m: 1.0,
        box_max: [1.0, 2.0, 0.0],
        ..record
    });
    let first = next_set(pack);
    let measured =
        vec![push_level(pack, &[[0, 1, 2]], 3, 0.75, None), push_level(pack, &[[2, 1, 3], [0, 1, 2]], 4, 0.0, None)];
    pack.level_sets.push(LevelSetRecord { quantized_count: 2, ..first });
    pack.manifest.characters.push(ManifestCharacter {
        measured,
        name: "flag".to_owned(),
        source: "flag.glb".to_owned(),
        nodes: vec![node("cloth", None, [0.0; 3])],
        joints: vec![ManifestJoint { node: 0, inverse_bind: IDENTITY }],
        clips: vec![ManifestClip { name: "rest".to_owned(), ..ManifestClip::default() }],
        materials: vec!["checks".to_owned()],
        parts: vec![ManifestPart { name: "cloth".to_owned(), material: 0, triangle_count: 2, rigid: true }],
        criteria: "wedge".to_owned(),
        fps: 30.0,
        seams: ManifestSeams {
            position_count: 4,
            wedge_count: 4,
            fixed_count: 4,
            border_count: 4,
            ..ManifestSeams::default()
        },
        levels: vec![
            ManifestLevel { vertex_count: 3, triangle_count: 1, error_m: 0.5 },
            ManifestLevel { vertex_count: 4, triangle_count: 2, error_m: 0.0 },
        ],
        warnings: vec!["the corner \u{fb02}aps".to_owned()],
        ..ManifestCharacter::default()
    });
}

/// A tetrahedron with vertex 4 in the middle of the edge from 1 to the apex 3; vertex 4 moves into 3 and takes two triangles along.
fn add_tetrahedron(pack: &mut PackContents, storage: JointStorage) {
    let record = CharacterRecord { joint_storage: storage.code(), ..next_character(pack) };
    let corners = [[0.0, 0.0, 0.5], [0.5, 0.0, -0.5], [-0.5, 0.0, -0.5], [0.0, 1.0, 0.0], [0.25, 0.5, -0.25]];
    let normals = [[0.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0], [0.0, 1.0, 0.0], [2.0, 1.0, -1.0]];
    for (number, (corner, normal)) in corners.into_iter().zip(normals).enumerate() {
        let color = [corner[1], 0.5, 1.0 - corner[1], 1.0];
        let weights = [1.0 - corner[1], corner[1], 0.0, 0.0];
        let joints = if number == 3 { [1, 0, 0, 0] } else { [0, 1, 0, 0] };
        let weights = if number == 3 { [1.0, 0.0, 0.0, 0.0] } else { weights };
        pack.vertices.push(VertexRecord::new(
            corner,
            normal,
            [0.0; 2],
            color,
            (number == 3).into(),
            0,
            joints,
            weights,
        ));
    }
    pack.triangles.extend([[0, 2, 1], [0, 1, 4], [1, 2, 4], [2, 0, 3], [0, 4, 3], [4, 2, 3]]);
    pack.collapse_map.extend([0, 1, 2, 3, 3]);
    let (coarse, full) =
        (LodRecord { vertex_count: 4, triangle_count: 4 }, LodRecord { vertex_count: 5, triangle_count: 6 });
    pack.lods.extend([coarse, coarse, coarse, coarse, coarse, full]);
    let sphere = [0.0, 0.5, 0.0, 1.25];
    push_clip(
        pack,
        storage,
        &[&[[0.0; 3], [0.0; 3]], &[[0.0; 3], [0.25, 0.0, 0.0]], &[[0.0; 3], [0.0; 3]]],
        0.5,
        sphere,
    );
    push_clip(pack, storage, &[&[[0.0; 3], [0.0; 3]], &[[0.0, 0.0, 2.0], [0.0, 0.0, 2.0]]], 1.0, [0.0, 0.5, 1.0, 2.25]);
    let hop = pack.clips.last_mut().expect("the clip was pushed in the line above");
    (hop.ground_speed_m_s, hop.root_displacement_m) = (2.0, [0.0, 0.0, 2.0]);
    push_inverse_binds(pack, &[IDENTITY, IDENTITY]);
    let plain = MaterialRecord { base_color: [0.5, 0.25, 1.0, 1.0], image: NONE, ..MaterialRecord::default() };
    pack.materials.extend([plain, MaterialRecord { flags: material_flags::UNLIT | material_flags::FLAT, ..plain }]);
    pack.characters.push(CharacterRecord {
        vertex_count: 5,
        triangle_count: 6,
        min_vertex_count: 4,
        min_triangle_count: 4,
        joint_count: 2,
        clip_count: 2,
        material_count: 2,
        sphere: [0.0, 0.5, 0.75, 2.5],
        box_min: [-0.5, 0.0, -0.5],
        height_m: 1.0,
        box_max: [0.75, 1.0, 2.5],
        storage_error_m: 0.001_953_125,
        ..record
    });
    let first = next_set(pack);
    let measured = vec![
        ManifestMeasured {
            rms_m: 0.015_625,
            max_m: 0.062_5,
            max_frame: 1,
            uv_drift_p95_texels: 2.5,
            normal_mean_deg: 12.0,
            bound_px: 67.5,
            poked_share: 0.25,
            ..push_level(pack, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], 4, 0.093_75, None)
        },
        push_level(pack, &[[0, 2, 1], [0, 1, 4], [1, 2, 4], [0, 4, 3], [4, 2, 3], [2, 0, 3]], 5, 0.0, None),
    ];
    // The same level once more, and with its apex moved down.
    let again = push_level(pack, &[[1, 0, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]], 4, 0.093_75, None);
    let mut moved = pack.vertices[pack.vertices.len() - 5..][..4].to_vec();
    moved[3].position[1] = 0.75;
    let refitted = push_level(pack, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], 4, 0.5, Some(&moved));
    let discrete =
        |name: &str, target, reached, measured| ManifestDiscrete { name: name.to_owned(), target, reached, measured };
    let discrete = vec![
        discrete("lod1", ManifestTarget::Ratio(0.75), true, again),
        discrete("lod2", ManifestTarget::Pixels(1.0, 120.0), false, refitted),
    ];
    pack.level_sets.push(LevelSetRecord { quantized_count: 2, discrete_count: 2, ..first });
    let sway = push_track(pack, 1, 1, &[0.0, 0.25, 0.5], &[0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let tangents = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0];
    let hop = push_track(pack, 0, 2, &[0.0, 1.0], &tangents);
    let contact = ManifestContact { joint: 1, start_s: 0.25, end_s: 0.75 };
    let root_path_m = vec![[0.0, 0.5], [0.0, -0.5], [0.0, 0.5]];
    let hop_feet = ManifestClip { slide_m_s: 0.125, root_path_m, rooted_slide_m_s: 0.0625, ..ManifestClip::default() };
    pack.manifest.characters.push(ManifestCharacter {
        name: "tetrahedron".to_owned(),
        source: "tetrahedron.gltf".to_owned(),
        nodes: vec![node("root", None, [0.0; 3]), node("tip", Some(0), [0.0; 3])],
        joints: vec![
            ManifestJoint { node: 0, inverse_bind: IDENTITY },
            ManifestJoint { node: 1, inverse_bind: IDENTITY },
        ],
        clips: vec![
            ManifestClip { name: "sway".to_owned(), tracks: vec![sway], ..ManifestClip::default() },
            ManifestClip { name: "hop".to_owned(), tracks: vec![hop], contacts: vec![contact], ..hop_feet },
        ],
        materials: vec!["side".to_owned(), "tip".to_owned()],
        parts: vec![ManifestPart { name: "body".to_owned(), material: 0, triangle_count: 70_000, rigid: false }],
        criteria: "peng2011".to_owned(),
        fps: 4.0,
        seams: ManifestSeams {
            position_count: 5,
            wedge_count: 300,
            regular_count: 5,
            duplicate_triangle_count: 2,
            ..ManifestSeams::default()
        },
        levels: vec![
            ManifestLevel { vertex_count: 4, triangle_count: 4, error_m: 0.0 },
            ManifestLevel { vertex_count: 5, triangle_count: 6, error_m: 0.0 },
        ],
        measured,
        discrete,
        measuring: ManifestMeasuring { samples_per_frame: 1000, mean_frames: vec![0, 1, 4], worst_frames: vec![2] },
        blocked: ManifestBlocked { fixed: 2, seam: 1, topology: 0, flip: 0, ended: 1 },
        obstacles: vec![1, 1, 2, 5],
        ..ManifestCharacter::default()
    });
}

/// Where the next character's levels go.
fn next_set(pack: &PackContents) -> LevelSetRecord {
    LevelSetRecord {
        level_offset: pack.levels.len() as u32,
        refit_vertex_offset: pack.refit_vertices.len() as u32,
        ..LevelSetRecord::default()
    }
}

/// A level with a table of 16-bit indices, and its own vertices where it has some.
fn push_level(
    pack: &mut PackContents,
    triangles: &[[u16; 3]],
    vertex_count: u32,
    bound_m: f32,
    own: Option<&[VertexRecord]>,
) -> ManifestMeasured {
    let triangle_count = triangles.len() as u32;
    pack.levels.push(LevelRecord {
        vertex_count,
        triangle_count,
        index_offset: pack.indices_16.len() as u32,
        index_bytes: 2,
        refit_vertex_offset: own.map_or(NONE, |_| pack.refit_vertices.len() as u32),
        bound_m,
    });
    pack.indices_16.extend_from_slice(triangles.as_flattened());
    pack.refit_vertices.extend_from_slice(own.unwrap_or_default());
    ManifestMeasured { vertex_count, triangle_count, bound_m, ..ManifestMeasured::default() }
}

fn node(name: &str, parent: Option<u32>, translation: [f32; 3]) -> ManifestNode {
    ManifestNode { name: name.to_owned(), parent, translation, rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] }
}

/// A clip whose matrices only move: `frames[f][j]` is the translation of joint j in frame f.
fn push_clip(
    pack: &mut PackContents,
    storage: JointStorage,
    frames: &[&[[f32; 3]]],
    duration_s: f32,
    sphere: [f32; 4],
) {
    let texel_offset = pack.animation.len() as u32;
    for frame in frames {
        let moved = |&[x, y, z]: &[f32; 3]| [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]];
        let joints: Vec<_> = frame.iter().map(moved).collect();
        if pack.manifest.animation_layout == AnimationLayout::Split4x4 {
            let rows = joints.iter().flat_map(|&[x, y, z]| [x, y, z, [0.0, 0.0, 0.0, 1.0]]);
            pack.animation.extend(rows.map(|row| row.map(f32::to_bits)));
        } else {
            store_frame(storage, &joints, &mut pack.animation);
        }
    }
    let frame_count = frames.len() as u32;
    pack.clips.push(ClipRecord { texel_offset, frame_count, duration_s, sphere, ..ClipRecord::default() });
}

fn push_inverse_binds(pack: &mut PackContents, matrices: &[[f32; 16]]) {
    if pack.manifest.animation_layout == AnimationLayout::Split4x4 {
        let row = |m: &[f32; 16], r: usize| [m[r], m[4 + r], m[8 + r], m[12 + r]];
        pack.inverse_binds.extend(matrices.iter().flat_map(|m| [0, 1, 2, 3].map(|r| row(m, r))));
    }
}

/// A translation track.
fn push_track(pack: &mut PackContents, node: u32, interpolation: u8, times: &[f32], values: &[f32]) -> ManifestTrack {
    let time_offset = pack.track_values.len() as u32;
    pack.track_values.extend_from_slice(times);
    let value_offset = pack.track_values.len() as u32;
    pack.track_values.extend_from_slice(values);
    let (key_count, value_count) = (times.len() as u32, values.len() as u32);
    ManifestTrack { node, property: 0, interpolation, time_offset, key_count, value_offset, value_count }
}
