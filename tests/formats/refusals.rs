//! One broken rule at a time: each is refused, on writing as on reading, with a message that names the place.

use crate::tiny_pack;
use crowd_pack::{AnimationLayout, Error, JointStorage, ManifestTarget, NONE, PackContents};

type Break = fn(&mut PackContents);

/// How to break a rule, and what the message has to say.
const BROKEN: &[(&str, Break)] = &[
    ("character 0: vertices: offset", |p| p.characters[0].vertex_offset = 1),
    ("character 1: vertices: offset", |p| p.characters[1].vertex_offset = 3),
    ("character 1: vertices: elements", |p| p.characters[1].vertex_count = 6),
    ("section vertices: elements", |p| {
        p.vertices.push(p.vertices[8]);
        p.collapse_map.push(0);
    }),
    ("character 1: triangles: offset", |p| p.characters[1].triangle_offset = 0),
    ("character 1: LOD table: offset", |p| p.characters[1].lod_offset = 0),
    ("character 1: clips: offset", |p| p.characters[1].clip_offset = 0),
    ("character 1: materials: elements", |p| p.characters[1].material_count = 3),
    ("character 0: vertex count", |p| p.characters[0].vertex_count = 0),
    ("character 0: joint count", |p| p.characters[0].joint_count = 0),
    ("character 0: joint count", |p| p.characters[0].joint_count = 1_000_000),
    ("character 0: clip count", |p| p.characters[0].clip_count = 0),
    ("character 0: coarsest vertex count", |p| p.characters[0].min_vertex_count = 5),
    ("character 0: coarsest triangle count", |p| p.characters[0].min_triangle_count = 3),
    ("character 0: sphere", |p| p.characters[0].sphere[3] = -1.0),
    ("character 0: box", |p| p.characters[0].box_min[1] = 9.0),
    ("character 0: height", |p| p.characters[0].height_m = f32::NAN),
    ("character 1: vertex 2: position", |p| p.vertices[6].position[1] = f32::INFINITY),
    ("character 1: vertex 2: texture coordinates", |p| p.vertices[6].uv[0] = f32::NAN),
    ("character 1: vertex 2: material", |p| p.vertices[6].material_class = 2),
    ("character 1: vertex 2: class", |p| p.vertices[6].material_class = 3 << 16),
    ("character 1: vertex 2: joints", |p| p.vertices[6].joints = [0, 2 << 16]),
    ("character 1: vertex 2: sum of weights", |p| p.vertices[6].weights[1] = 1),
    ("character 1: triangle 5", |p| p.triangles[7][2] = 5),
    ("character 1: collapse map of vertex 4", |p| p.collapse_map[8] = 4),
    ("character 1: collapse map of vertex 2", |p| p.collapse_map[6] = 3),
    ("section collapse_map: elements", |p| p.collapse_map.push(0)),
    ("character 0: LOD table entry 2", |p| p.lods[2].vertex_count = 4),
    ("character 0: LOD table entry 2", |p| p.lods[2].vertex_count = 2),
    ("character 0: LOD table entry 2", |p| p.lods[2].triangle_count = 2),
    ("character 0: last LOD table entry", |p| p.lods[4] = p.lods[3]),
    ("character 1: clip 1: frames", |p| p.clips[2].frame_count = 0),
    ("character 1: clip 1: texels: offset", |p| p.clips[2].texel_offset += 1),
    ("character 1: clip 1: texels: elements", |p| p.clips[2].frame_count = u32::MAX),
    ("character 1: clip 1: texel 11", |p| p.animation.last_mut().unwrap()[3] = f32::NAN.to_bits()),
    ("character 1: clip 0: duration", |p| p.clips[1].duration_s = -1.0),
    ("character 1: clip 0: sphere", |p| p.clips[1].sphere[0] = f32::NAN),
    ("section animation: elements", |p| p.animation.push([0; 4])),
    ("character 1: joint storage", |p| p.characters[1].joint_storage = 3),
    ("character 1: storage error", |p| p.characters[1].storage_error_m = f32::NAN),
    ("character 1: reserved", |p| p.characters[1].reserved[1] = 1),
    // Other storages have fewer texels.
    ("character 1: clip 0: texels: offset", |p| p.characters[0].joint_storage = 1),
    ("`tetrahedron`: clip 1: slide", |p| p.manifest.characters[1].clips[1].slide_m_s = -1.0),
    ("`tetrahedron`: clip 1: slide along", |p| p.manifest.characters[1].clips[1].rooted_slide_m_s = f32::NAN),
    ("`tetrahedron`: clip 1: path", |p| p.manifest.characters[1].clips[1].root_path_m[2][1] = f32::INFINITY),
    ("`tetrahedron`: clip 1: path", |p| p.manifest.characters[1].clips[1].root_path_m[0][0] = f32::NAN),
    ("`tetrahedron`: clip 1: path", |p| p.manifest.characters[1].clips[1].root_path_m[1][0] = -3e38),
    ("`tetrahedron`: clip 1: contact 0", |p| p.manifest.characters[1].clips[1].contacts[0].joint = 2),
    ("`tetrahedron`: clip 1: contact 0", |p| p.manifest.characters[1].clips[1].contacts[0].end_s = f32::NAN),
    ("`tetrahedron`: clip 1: contact 0", |p| p.manifest.characters[1].clips[1].contacts[0].end_s = 1.5),
    ("`tetrahedron`: clip 1: path", |p| p.manifest.characters[1].clips[1].root_path_m[2] = [0.5, 0.0]),
    ("section inverse_binds: elements", |p| p.inverse_binds.push([0.0; 4])),
    ("character 1: inverse bind matrices", |p| p.characters[1].inverse_bind_offset = 4),
    ("character 0: material 0: image", |p| p.materials[0].image = 1),
    ("character 0: material 0: flags", |p| p.materials[0].flags = 1 << 31),
    ("character 0: material 0: flags", |p| p.materials[0].flags = 3 << 4),
    ("character 0: material 0: alpha cutoff", |p| p.materials[0].alpha_cutoff = f32::NAN),
    ("character 0: material 0: reserved", |p| p.materials[0].reserved = 1),
    ("image 0: byte offset", |p| p.images[0].byte_offset = 64),
    ("image 0: bytes", |p| p.images[0].byte_count = u64::MAX),
    ("image 0: width", |p| p.images[0].width = 0),
    ("image 0: encoding", |p| p.images[0].encoding = 3),
    ("section image_bytes: bytes", |p| p.image_bytes.push(0)),
    ("section image_bytes: end", |p| p.image_bytes.resize(128, 1)),
    ("manifest: characters", |p| p.manifest.characters.truncate(1)),
    ("character 1 `flag`: name", |p| p.manifest.characters[1].name = "flag".to_owned()),
    ("character 0 ``: name", |p| p.manifest.characters[0].name = String::new()),
    ("`flag`: joints", |p| p.manifest.characters[0].joints.clear()),
    ("`flag`: clips", |p| p.manifest.characters[0].clips.clear()),
    ("`flag`: materials", |p| p.manifest.characters[0].materials.clear()),
    ("`flag`: frames a second", |p| p.manifest.characters[0].fps = f32::NAN),
    ("`flag`: part 0: material", |p| p.manifest.characters[0].parts[0].material = 1),
    ("`tetrahedron`: node 1: parent", |p| p.manifest.characters[1].nodes[1].parent = Some(1)),
    ("`tetrahedron`: node 1: transform", |p| p.manifest.characters[1].nodes[1].rotation[2] = f32::NAN),
    ("`tetrahedron`: joint 1: node", |p| p.manifest.characters[1].joints[1].node = 2),
    ("`tetrahedron`: joint 1: inverse bind", |p| p.manifest.characters[1].joints[1].inverse_bind[9] = f32::NAN),
    ("`tetrahedron`: clip 1: name", |p| p.manifest.characters[1].clips[1].name = "sway".to_owned()),
    ("track 0: node", |p| p.manifest.characters[1].clips[0].tracks[0].node = 2),
    ("track 0: property", |p| p.manifest.characters[1].clips[0].tracks[0].property = 3),
    ("track 0: interpolation", |p| p.manifest.characters[1].clips[0].tracks[0].interpolation = 3),
    ("track 0: keys", |p| p.manifest.characters[1].clips[0].tracks[0].key_count = 0),
    ("track 0: values", |p| p.manifest.characters[1].clips[0].tracks[0].property = 1),
    ("track 0: values", |p| p.manifest.characters[1].clips[0].tracks[0].value_offset = u32::MAX),
    ("track 0: times", |p| p.manifest.characters[1].clips[0].tracks[0].time_offset = 1_000),
    ("track 0: times", |p| p.track_values[1] = 0.0),
    ("track 0: values", |p| p.track_values[3] = f32::NAN),
    ("`flag`: level 0", |p| p.manifest.characters[0].levels[0].triangle_count = 2),
    ("`flag`: level 1", |p| p.manifest.characters[0].levels[1] = p.manifest.characters[0].levels[0]),
    ("`flag`: level 0: error", |p| p.manifest.characters[0].levels[0].error_m = f32::NAN),
    ("`tetrahedron`: measured levels", |p| p.manifest.characters[1].measured.truncate(1)),
    ("`tetrahedron`: discrete levels", |p| p.manifest.characters[1].discrete.clear()),
    ("`tetrahedron`: measured level 0", |p| p.manifest.characters[1].measured[0].max_clip = u32::MAX),
    ("`tetrahedron`: measured level 0", |p| p.manifest.characters[1].measured[0].max_frame = 3),
    ("`tetrahedron`: measured level 0", |p| p.manifest.characters[1].measured[0].bound_m = 0.125),
    ("`tetrahedron`: measured level 1", |p| p.manifest.characters[1].measured[1].vertex_count = 4),
    ("`tetrahedron`: measured level 0: distance", |p| p.manifest.characters[1].measured[0].rms_m = f32::NAN),
    ("`tetrahedron`: measured level 0: distance", |p| p.manifest.characters[1].measured[0].normal_mean_deg = -1.0),
    ("`tetrahedron`: discrete level 1: name", |p| p.manifest.characters[1].discrete[1].name = "lod1".to_owned()),
    ("`tetrahedron`: discrete level 0: name", |p| p.manifest.characters[1].discrete[0].name.clear()),
    ("discrete level 0: target", |p| p.manifest.characters[1].discrete[0].target = ManifestTarget::Ratio(0.0)),
    ("discrete level 0: target", |p| p.manifest.characters[1].discrete[0].target = ManifestTarget::ErrorM(f32::NAN)),
    ("discrete level 1: distance", |p| p.manifest.characters[1].discrete[1].measured.max_m = f32::INFINITY),
    ("`tetrahedron`: frames measured", |p| p.manifest.characters[1].measuring.mean_frames = vec![1, 1]),
    ("`tetrahedron`: frames measured", |p| p.manifest.characters[1].measuring.worst_frames = vec![5]),
    ("`tetrahedron`: obstacles", |p| p.manifest.characters[1].obstacles.truncate(3)),
    ("`tetrahedron`: obstacle", |p| p.manifest.characters[1].obstacles[3] = 0),
    ("`tetrahedron`: obstacle", |p| p.manifest.characters[1].obstacles[3] = 9),
    ("section level_sets: elements", |p| p.level_sets.truncate(1)),
    ("section level_sets: elements", |p| p.level_sets.push(p.level_sets[1])),
    ("character 1: levels with tables: offset", |p| p.level_sets[1].level_offset = 0),
    ("character 1: levels with tables: elements", |p| p.level_sets[1].discrete_count = 3),
    ("section levels: elements", |p| p.levels.push(p.levels[0])),
    ("section indices_16: elements", |p| p.indices_16.push(0)),
    ("section indices_32: elements", |p| p.indices_32.push(0)),
    ("section refit_vertices: elements", |p| p.refit_vertices.push(p.vertices[0])),
    ("character 0: quantised levels", |p| p.level_sets[0].quantized_count = 0),
    ("character 1: refitted vertices: offset", |p| p.level_sets[1].refit_vertex_offset = 1),
    ("character 0: first quantised level", |p| p.levels[0].vertex_count = 4),
    ("character 0: last quantised level", |p| p.level_sets[0].quantized_count = 1),
    ("character 0: quantised level 1", |p| p.levels[1].bound_m = 1.0),
    ("character 0: level with table 0: bound", |p| p.levels[0].bound_m = f32::INFINITY),
    ("character 1: level with table 2: bound", |p| p.levels[4].bound_m = -1.0),
    ("character 1: level with table 2: counts", |p| p.levels[4].triangle_count = 5),
    ("character 1: level with table 2: counts", |p| p.levels[4].vertex_count = 3),
    ("character 1: level with table 2: counts", |p| p.levels[4].vertex_count = u32::MAX),
    ("character 1: level with table 0: refitted vertices", |p| p.levels[2].refit_vertex_offset = 0),
    ("character 1: level with table 3: counts", |p| p.levels[5].vertex_count = 6),
    ("character 1: level with table 3: counts", |p| p.levels[5].triangle_count = u32::MAX),
    ("character 1: level with table 3: refitted vertices: offset", |p| p.levels[5].refit_vertex_offset = 1),
    ("character 1: level with table 3: refitted vertices: elements", |p| p.refit_vertices.truncate(3)),
    ("character 1: level with table 3: vertex 3: position", |p| p.refit_vertices[3].position[0] = f32::NAN),
    ("character 1: level with table 3: vertex 1: joints", |p| p.refit_vertices[1].joints = [0, 2 << 16]),
    ("character 1: level with table 3: vertex 1: material", |p| p.refit_vertices[1].material_class = 2),
    ("character 1: level with table 1: bytes of an index", |p| p.levels[3].index_bytes = 4),
    ("character 1: level with table 1: bytes of an index", |p| p.levels[3].index_bytes = 0),
    ("character 1: level with table 1: indices: offset", |p| p.levels[3].index_offset = 0),
    ("character 1: level with table 3: indices: elements", |p| p.indices_16.truncate(p.indices_16.len() - 1)),
    ("character 1: level with table 0: indices", |p| p.indices_16[9] = 4),
    ("character 1: level with table 3: indices", |p| *p.indices_16.last_mut().unwrap() = 4),
];

#[test]
fn each_broken_rule_is_named() {
    for (number, (place, break_rule)) in BROKEN.iter().enumerate() {
        let mut contents = tiny_pack::contents(AnimationLayout::Premultiplied3x4);
        break_rule(&mut contents);
        let error = contents.to_bytes().err().unwrap_or_else(|| panic!("rule {number}, {place}: accepted"));
        let message = error.to_string();
        assert!(message.contains(place), "rule {number}: {message}, wanted {place}");
        assert!(message.contains("found") && message.contains("allowed"), "{message}");
    }
}

#[test]
fn joints_that_are_no_numbers_are_refused_in_every_storage() {
    let faults: [(JointStorage, usize, u32, &str); 5] = [
        (JointStorage::F32, 0, f32::INFINITY.to_bits(), "finite numbers"),
        (JointStorage::F16, 1, 0x7e00, "finite half floats"),
        (JointStorage::F16, 1, 0xfc00_0000, "finite half floats"),
        // Powers of two of which the shader would make infinities.
        (JointStorage::Quantized, 3, 0xff71_0000, "exponents"),
        (JointStorage::Quantized, 3, 0x71ff_0000, "exponents"),
    ];
    for (storage, word, bits, allowed) in faults {
        let mut contents = tiny_pack::stored(AnimationLayout::Premultiplied3x4, storage);
        assert!(contents.to_bytes().is_ok());
        contents.animation.last_mut().expect("it has clips")[word] = bits;
        let message = contents.to_bytes().expect_err("no pose has such joints").to_string();
        assert!(message.contains("character 1: clip 1: texel") && message.contains(allowed), "{message}");
    }
    // Half a texel that belongs to nobody, behind the flag's only joint.
    let mut contents = tiny_pack::stored(AnimationLayout::Premultiplied3x4, JointStorage::F16);
    contents.animation[1][3] = 1;
    let message = contents.to_bytes().expect_err("every byte means something").to_string();
    assert!(message.contains("character 0: clip 0: texel 1") && message.contains("zeros"), "{message}");
    let split = tiny_pack::stored(AnimationLayout::Split4x4, JointStorage::Quantized);
    let message = split.to_bytes().expect_err("the papers have floats").to_string();
    assert!(message.contains("character 0: joint storage"), "{message}");
}

#[test]
fn too_much_is_a_limit_and_not_damage() {
    let mut contents = tiny_pack::contents(AnimationLayout::Premultiplied3x4);
    contents.characters[0].joint_count = 5_000;
    let error = contents.to_bytes().unwrap_err();
    assert!(matches!(error, Error::Limit { found: 5_000, allowed: 4_096, .. }), "{error}");
}

#[test]
fn too_many_levels_are_a_limit() {
    for (wanted, discrete) in [(64, false), (32, true)] {
        let mut contents = tiny_pack::contents(AnimationLayout::Premultiplied3x4);
        let set = &mut contents.level_sets[0];
        *if discrete { &mut set.discrete_count } else { &mut set.quantized_count } = u32::MAX;
        let error = contents.to_bytes().unwrap_err();
        assert!(matches!(error, Error::Limit { allowed, .. } if allowed == wanted), "{error}");
    }
}

#[test]
fn no_image_is_allowed() {
    let mut contents = tiny_pack::contents(AnimationLayout::Premultiplied3x4);
    contents.materials[0].image = NONE;
    assert!(contents.to_bytes().is_ok());
}

/// How to break a rule of impostors, and what the message has to say.
const BROKEN_IMPOSTORS: &[(&str, Break)] = &[
    ("section impostors: elements", |p| p.impostors.truncate(1)),
    ("impostors 0: tile", |p| p.impostors[0].tile_px = 12),
    ("impostors 0: tile", |p| p.impostors[0].tile_px = 256),
    ("impostors 0: tile", |p| p.impostors[0].tile_px = 0),
    ("impostors 0: azimuths", |p| p.impostors[0].azimuth_count = 65),
    ("impostors 1: elevations", |p| p.impostors[1].elevation_count = 0),
    ("impostors 1: poses a clip", |p| p.impostors[1].pose_count = u32::MAX),
    ("impostors 1: clips", |p| p.impostors[1].clip_count = 3),
    ("impostors 1: shape", |p| p.impostors[1].azimuth_count = 3),
    ("impostors 1: shape", |p| p.impostors[1].tile_px = 16),
    ("impostors 0: reserved", |p| p.impostors[0].reserved = 1),
    ("impostors 0: colours: byte offset", |p| p.impostors[0].color_byte_offset = 64),
    ("impostors 1: normals: byte offset", |p| p.impostors[1].normal_byte_offset = u64::MAX),
    ("impostors 0: normals: byte offset", |p| p.impostors[0].color_byte_count = 1),
    ("impostors 1: normals: bytes", |p| p.impostors[1].normal_byte_count = u32::MAX),
    ("impostors 1: normals: bytes", |p| p.impostors[1].normal_byte_count = 0),
    ("impostors 0: normals: padding", |p| p.impostor_bytes[80] = 1),
    ("section impostor_bytes: bytes", |p| p.impostor_bytes.push(0)),
];

#[test]
fn every_broken_rule_of_impostors_is_named() {
    for (number, (place, break_rule)) in BROKEN_IMPOSTORS.iter().enumerate() {
        let mut contents = tiny_pack::with_impostors();
        assert!(contents.to_bytes().is_ok());
        break_rule(&mut contents);
        let error = contents.to_bytes().err().unwrap_or_else(|| panic!("rule {number}, {place}: accepted"));
        assert!(error.to_string().contains(place), "rule {number}: {error}, wanted {place}");
    }
}

/// How to break a rule of finishes, and what the message has to say.
const BROKEN_FINISHES: &[(&str, Break)] = &[
    ("finishes: materials", |p| p.finishes.materials.truncate(2)),
    ("finishes: image names", |p| p.finishes.image_names.clear()),
    ("finishes: names of finish images", |p| p.finishes.finish_image_names.push("x".into())),
    ("finishes: skin names", |p| p.finishes.skin_names.clear()),
    ("finishes: credits", |p| p.finishes.credits.truncate(1)),
    ("section finish_images: elements", |p| p.finishes = Default::default()),
    ("finish image 1: byte offset", |p| p.finish_images[1].byte_offset = 64),
    ("finish image 0: width", |p| p.finish_images[0].width = 0),
    ("finish image 1: bytes", |p| p.finish_images[1].byte_count = u64::MAX),
    ("section finish_bytes: bytes", |p| p.finish_bytes.push(0)),
    ("material 0: metalness", |p| p.finishes.materials[0].metallic = 1.5),
    ("material 1: metalness", |p| p.finishes.materials[1].roughness = f32::NAN),
    ("material 0: metalness", |p| p.finishes.materials[0].emissive[2] = -1.0),
    ("material 0: metalness", |p| p.finishes.materials[0].occlusion.as_mut().unwrap().weight = 2.0),
    ("material 0: emissive strength", |p| p.finishes.materials[0].emissive_strength = f32::INFINITY),
    ("material 0: index of refraction", |p| p.finishes.materials[0].ior = Some(0.5)),
    ("material 0: specular", |p| p.finishes.materials[0].specular = Some([2.0, 0.0, 0.0, 0.0])),
    ("material 0: base colour", |p| p.finishes.materials[0].base.as_mut().unwrap().color[3] = f32::NAN),
    ("material 0: texture: image", |p| p.finishes.materials[0].normal.as_mut().unwrap().image = 2),
    ("material 0: texture: image", |p| p.finishes.materials[0].specular_texture.as_mut().unwrap().image = NONE),
    ("material 0: texture: sampler", |p| p.finishes.materials[0].normal.as_mut().unwrap().sampler = 3),
    ("material 0: texture: sampler", |p| p.finishes.materials[0].normal.as_mut().unwrap().sampler = 12 << 4),
    ("finishes: rigs", |p| p.finishes.rigs.truncate(1)),
    ("rig 1: joint 0: node", |p| p.finishes.rigs[1].joints[0].node = 2),
    ("rig 1: joint 1: inverse bind matrix", |p| p.finishes.rigs[1].joints[1].inverse_bind[3] = f32::NAN),
    ("rig 1: places", |p| p.finishes.rigs[1].places.clear()),
    ("rig 0: places", |p| p.finishes.rigs[0].places.resize(100, 0)),
    ("rig 1: place", |p| p.finishes.rigs[1].places[0] = 100),
    ("rig 1: place", |p| p.finishes.rigs[1].places.fill(1)),
    ("rig 1: tracks", |p| p.finishes.rigs[1].tracks.truncate(1)),
    ("rig 1: track 0: node", |p| p.finishes.rigs[1].tracks.iter_mut().flatten().next().unwrap().node = 9),
    ("material 0: texture: weight", |p| p.finishes.materials[0].normal.as_mut().unwrap().weight = f32::NAN),
];

#[test]
fn every_broken_rule_of_finishes_is_named() {
    for (number, (place, break_rule)) in BROKEN_FINISHES.iter().enumerate() {
        let mut contents = tiny_pack::with_finishes();
        assert!(contents.to_bytes().is_ok());
        break_rule(&mut contents);
        let error = contents.to_bytes().err().unwrap_or_else(|| panic!("rule {number}, {place}: accepted"));
        assert!(error.to_string().contains(place), "rule {number}: {error}, wanted {place}");
    }
}

/// A few bytes that promise many texels are refused before anyone decodes them.
#[test]
fn too_many_texels_of_impostors_are_a_limit() {
    let mut contents = tiny_pack::with_impostors();
    for record in &mut contents.impostors {
        (record.tile_px, record.azimuth_count, record.elevation_count, record.pose_count) = (128, 64, 64, 4);
    }
    let error = contents.to_bytes().unwrap_err();
    assert!(matches!(error, Error::Limit { allowed, .. } if allowed == 1 << 26), "{error}");
    contents.impostors.iter_mut().for_each(|record| record.pose_count = 5);
    assert!(contents.to_bytes().unwrap_err().to_string().contains("texels high"));
}
