//! Contents that obey every rule and are otherwise drawn by lot.

use crowd_pack::{
    AnimationLayout, CharacterRecord, ClipRecord, JointRows, LevelRecord, LevelSetRecord, LodRecord, ManifestBlocked,
    ManifestCharacter, ManifestClip, ManifestContact, ManifestDiscrete, ManifestJoint, ManifestLevel, ManifestMeasured,
    ManifestNode, ManifestPart, ManifestTarget, ManifestTrack, MaterialRecord, NONE, PackContents, VertexRecord,
    store_frame,
};

/// SplitMix64: numbers from a seed.
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`, which is not 0.
    pub fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    fn count(&mut self, least: u64, most: u64) -> u32 {
        (least + self.below(most - least + 1)) as u32
    }

    fn float(&mut self) -> f32 {
        self.below(20_001) as f32 / 1_000.0 - 10.0
    }

    fn floats<const N: usize>(&mut self) -> [f32; N] {
        [0.0; N].map(|_| self.float())
    }

    fn name(&mut self, stem: &str, index: u32) -> String {
        let marks = ["", "-\u{e9}", " \u{4eba}", "\"", "_a_rather_long_name_of_more_than_a_few_letters"];
        format!("{stem}{index}{}", marks[self.below(5) as usize])
    }
}

/// A pack with 0 to 4 characters.
pub fn contents(seed: u64) -> PackContents {
    let mut random = Random(seed);
    let mut pack = PackContents::default();
    pack.manifest.generator = random.name("generator", 0);
    if random.below(2) == 1 {
        pack.manifest.animation_layout = AnimationLayout::Split4x4;
    }
    for index in 0..random.count(0, 4) {
        add_character(&mut pack, index, &mut random);
    }
    pack
}

fn add_character(pack: &mut PackContents, index: u32, random: &mut Random) {
    let split = pack.manifest.animation_layout == AnimationLayout::Split4x4;
    let vertex_count = random.count(1, 40);
    let mut record = CharacterRecord {
        vertex_offset: pack.vertices.len() as u32,
        vertex_count,
        triangle_offset: pack.triangles.len() as u32,
        triangle_count: random.count(1, 60),
        lod_offset: pack.lods.len() as u32,
        min_vertex_count: random.count(1, u64::from(vertex_count)),
        joint_count: random.count(1, 5),
        clip_offset: pack.clips.len() as u32,
        clip_count: random.count(1, 3),
        material_offset: pack.materials.len() as u32,
        material_count: random.count(1, 3),
        sphere: [random.float(), random.float(), random.float(), random.float().abs()],
        box_min: [-11.0; 3],
        height_m: random.float().abs(),
        box_max: [11.0; 3],
        inverse_bind_offset: if split { pack.inverse_binds.len() as u32 } else { 0 },
        joint_storage: if split { 0 } else { random.below(3) as u32 },
        storage_error_m: random.float().abs(),
        ..CharacterRecord::default()
    };
    let levels = add_mesh(pack, &mut record, random);
    let mut character =
        ManifestCharacter { name: random.name("character", index), levels, ..ManifestCharacter::default() };
    add_skeleton(pack, &record, &mut character, random);
    for clip in 0..record.clip_count {
        add_clip(pack, &record, &mut character, clip, random);
    }
    for material in 0..record.material_count {
        let encoded: Vec<u8> = (0..random.count(1, 200)).map(|i| (i % 7) as u8).collect();
        let image = if random.below(2) == 1 { pack.add_image(&encoded, 3, 4, random.count(0, 2)) } else { NONE };
        pack.materials.push(MaterialRecord {
            base_color: random.floats(),
            image,
            alpha_cutoff: 0.5,
            ..MaterialRecord::default()
        });
        character.materials.push(random.name("material", material));
    }
    character.parts = vec![ManifestPart { material: record.material_count - 1, ..ManifestPart::default() }];
    add_tables(pack, &record, &mut character, random);
    character.blocked = ManifestBlocked { fixed: 250, seam: 251, topology: 65_535, flip: u32::MAX, ended: 0 };
    if random.below(2) == 1 {
        character.obstacles = (0..record.min_vertex_count).map(|_| random.count(1, 5) as u8).collect();
    }
    character.warnings = (0..random.count(0, 2)).map(|i| random.name("warning", i)).collect();
    pack.characters.push(record);
    pack.manifest.characters.push(character);
}

fn add_mesh(pack: &mut PackContents, record: &mut CharacterRecord, random: &mut Random) -> Vec<ManifestLevel> {
    let (vertex_count, triangle_count) = (record.vertex_count, record.triangle_count);
    for v in 0..vertex_count {
        let joints = [0; 4].map(|_: u16| random.below(record.joint_count.into()) as u16);
        let material = random.below(record.material_count.into()) as u16;
        let (position, normal, uv, color) = (random.floats(), random.floats(), random.floats(), random.floats());
        let class = random.below(3) as u16;
        pack.vertices.push(VertexRecord::new(position, normal, uv, color, material, class, joints, random.floats()));
        let stays = v < record.min_vertex_count;
        pack.collapse_map.push(if stays { v } else { random.below(v.into()) as u32 });
    }
    for _ in 0..triangle_count {
        pack.triangles.push([0; 3].map(|_: u32| random.below(vertex_count.into()) as u32));
    }
    // Levels from full detail down; some vertex counts are skipped, as companions do.
    let mut level = LodRecord { vertex_count, triangle_count };
    let mut rising = vec![level];
    while level.vertex_count > record.min_vertex_count {
        level.vertex_count = (level.vertex_count - random.count(1, 2)).max(record.min_vertex_count);
        level.triangle_count -= random.below(3).min(level.triangle_count.into()) as u32;
        rising.push(level);
    }
    rising.reverse();
    record.min_triangle_count = rising[0].triangle_count;
    for k in 0..=vertex_count {
        let fits = rising.iter().rev().find(|level| level.vertex_count <= k);
        pack.lods.push(*fits.unwrap_or(&rising[0]));
    }
    let to_level = |lod: &LodRecord| ManifestLevel {
        vertex_count: lod.vertex_count,
        triangle_count: lod.triangle_count,
        error_m: 0.5,
    };
    rising.iter().map(to_level).collect()
}

/// Tables for up to 64 of the levels, and up to three discrete ones, some with vertices of their own.
fn add_tables(
    pack: &mut PackContents,
    record: &CharacterRecord,
    character: &mut ManifestCharacter,
    random: &mut Random,
) {
    let mut set = LevelSetRecord {
        level_offset: pack.levels.len() as u32,
        refit_vertex_offset: pack.refit_vertices.len() as u32,
        ..LevelSetRecord::default()
    };
    let last = character.levels.len() - 1;
    let mut chosen: Vec<ManifestLevel> = character.levels.clone();
    let mut number = 0;
    chosen.retain(|_| {
        number += 1;
        number == 1 || number == last + 1 || random.below(2) == 1
    });
    for (index, level) in chosen.iter().enumerate() {
        let bound_m = (chosen.len() - 1 - index) as f32;
        character.measured.push(push_table(pack, level.vertex_count, level.triangle_count, bound_m, false, random));
        set.quantized_count += 1;
    }
    for number in 0..random.count(0, 3) {
        let level = chosen[random.below(chosen.len() as u64) as usize];
        let refit = random.below(2) == 1;
        if refit {
            let first = record.vertex_offset as usize;
            let own = pack.vertices[first..first + level.vertex_count as usize].to_vec();
            pack.refit_vertices.extend(own);
        }
        let measured = push_table(pack, level.vertex_count, level.triangle_count, 0.25, refit, random);
        let target = match random.below(7) {
            0 => ManifestTarget::Ratio(0.5),
            1 => ManifestTarget::ErrorM(0.01),
            2 => ManifestTarget::ErrorHeight(0.005),
            3 => ManifestTarget::RmsM(0.01),
            4 => ManifestTarget::RmsHeight(0.005),
            5 => ManifestTarget::RmsPixels(1.0, 720.0),
            _ => ManifestTarget::Pixels(1.0, 720.0),
        };
        let reached = random.below(2) == 1;
        character.discrete.push(ManifestDiscrete { name: random.name("lod", number), target, reached, measured });
        set.discrete_count += 1;
    }
    pack.level_sets.push(set);
}

/// A table whose vertices, if it has its own, are the last ones pushed.
fn push_table(
    pack: &mut PackContents,
    vertex_count: u32,
    triangle_count: u32,
    bound_m: f32,
    refit: bool,
    random: &mut Random,
) -> ManifestMeasured {
    let refit_vertex_offset = if refit { pack.refit_vertices.len() as u32 - vertex_count } else { NONE };
    pack.levels.push(LevelRecord {
        vertex_count,
        triangle_count,
        index_offset: pack.indices_16.len() as u32,
        index_bytes: 2,
        refit_vertex_offset,
        bound_m,
    });
    pack.indices_16.extend((0..triangle_count * 3).map(|_| random.below(vertex_count.into()) as u16));
    ManifestMeasured { vertex_count, triangle_count, bound_m, ..ManifestMeasured::default() }
}

fn add_skeleton(
    pack: &mut PackContents,
    record: &CharacterRecord,
    character: &mut ManifestCharacter,
    random: &mut Random,
) {
    for node in 0..random.count(1, 6) {
        let parent = (node > 0 && random.below(4) > 0).then(|| random.below(node.max(1).into()) as u32);
        let (translation, rotation, scale) = (random.floats(), random.floats(), random.floats());
        let name = random.name("node", node);
        character.nodes.push(ManifestNode { name, parent, translation, rotation, scale });
    }
    for _ in 0..record.joint_count {
        let node = random.below(character.nodes.len() as u64) as u32;
        character.joints.push(ManifestJoint { node, inverse_bind: random.floats() });
        if pack.manifest.animation_layout == AnimationLayout::Split4x4 {
            pack.inverse_binds.extend([0; 4].map(|_| random.floats::<4>()));
        }
    }
}

fn add_clip(
    pack: &mut PackContents,
    record: &CharacterRecord,
    character: &mut ManifestCharacter,
    clip: u32,
    random: &mut Random,
) {
    let (texel_offset, frame_count) = (pack.animation.len() as u32, random.count(1, 4));
    let storage = record.storage().expect("it was drawn from all there are");
    for _ in 0..frame_count {
        let joints: Vec<JointRows> = (0..record.joint_count).map(|_| [0; 3].map(|_| random.floats())).collect();
        match pack.manifest.animation_layout {
            AnimationLayout::Premultiplied3x4 => store_frame(storage, &joints, &mut pack.animation),
            AnimationLayout::Split4x4 => {
                let rows = joints.iter().flat_map(|&[x, y, z]| [x, y, z, [0.0, 0.0, 0.0, 1.0]]);
                pack.animation.extend(rows.map(|row| row.map(f32::to_bits)));
            }
        }
    }
    let sphere = [random.float(), random.float(), random.float(), random.float().abs()];
    pack.clips.push(ClipRecord { texel_offset, frame_count, duration_s: 1.5, sphere, ..ClipRecord::default() });
    let mut tracks = Vec::new();
    for _ in 0..random.count(0, 2) {
        let node = random.below(character.nodes.len() as u64) as u32;
        let (property, interpolation) = (random.count(0, 2) as u8, random.count(0, 2) as u8);
        let key_count = random.count(1, 3);
        let mut track = ManifestTrack { node, property, interpolation, key_count, ..ManifestTrack::default() };
        track.value_count = track.floats_per_key() as u32 * key_count;
        track.time_offset = pack.track_values.len() as u32;
        pack.track_values.extend((0..key_count).map(|key| key as f32 * 0.5));
        track.value_offset = pack.track_values.len() as u32;
        pack.track_values.extend((0..track.value_count).map(|_| random.float()));
        tracks.push(track);
    }
    let contact =
        |joint: u32| ManifestContact { joint, start_s: joint as f32 * 0.000_1, end_s: joint as f32 * 0.000_1 + 0.5 };
    let contacts = (0..random.below(u64::from(record.joint_count) + 1) as u32).map(contact).collect();
    let (slide_m_s, rooted_slide_m_s) = (random.float().abs(), random.float().abs());
    let mut root_path_m: Vec<[f32; 2]> = (0..random.count(0, 3)).map(|_| random.floats()).collect();
    root_path_m.extend(root_path_m.first().copied());
    character.clips.push(ManifestClip {
        name: random.name("clip", clip),
        tracks,
        contacts,
        slide_m_s,
        root_path_m,
        rooted_slide_m_s,
    });
}
