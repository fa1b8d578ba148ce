//! The only place where the results of the bake become records of a pack.

use crate::bake::{BakedCharacter, warning_sentence};
use crate::bake_levels::{BakedLevel, BakedLevels};
use crate::error::{BakeError, Cause, Step};
use crate::impostors::BakedImpostors;
use crate::measure_levels::SAMPLES_PER_FRAME;
use crate::plan::criteria_name;
use crate::views::QuantizedMesh;
use crowd_anim::{FootContact, SampledClip};
use crowd_lod::{CollapseOrder, Obstacle, VertexClass};
use crowd_pack::{
    AnimationLayout, CharacterRecord, ClipRecord, Credits, JointStorage, LevelRecord, LevelSetRecord, LodRecord,
    Manifest, ManifestBlocked, ManifestCharacter, ManifestClip, ManifestContact, ManifestDiscrete, ManifestJoint,
    ManifestLevel, ManifestMeasured, ManifestMeasuring, ManifestNode, ManifestPart, ManifestSeams, ManifestTrack,
    MaterialRecord, NONE, PackContents, REFERENCE_HEIGHT_PX, Rig, Texel, VertexRecord, material_flags, obstacle,
    vertex_class,
};
use crowd_source::{
    ImageEncoding, RawCharacter, RawClip, RawCredits, RawImage, RawInterpolation, RawMaterial, RawMinFilter,
    RawProperty, RawTexture, RawTrack, RawWrap,
};
use std::collections::HashMap;

/// Puts characters into one pack, in the order given. The same characters give the same bytes.
///
/// # Errors
/// A section would outgrow its 32-bit offsets.
pub fn assemble(characters: &[BakedCharacter], layout: AnimationLayout) -> Result<PackContents, BakeError> {
    let mut pack = Assembly::default();
    pack.contents.manifest = Manifest {
        generator: format!("crowdbake {}", env!("CARGO_PKG_VERSION")),
        animation_layout: layout,
        characters: Vec::new(),
    };
    for baked in characters {
        pack.add_character(baked, layout).map_err(|cause| BakeError::of(Step::Assemble, &baked.name, cause))?;
    }
    pack.contents.finishes.drop_if_plain();
    Ok(pack.contents)
}

/// A height at rest below this share of the radius is rounding.
const FLAT: f32 = 1.0e-6;

/// Pixels a metre where the character is as high as the reference; 0 for something flat, but for rounding, which has no height to be shown at.
pub(crate) fn px_per_m(height_m: f32, radius_m: f32) -> f32 {
    if height_m > FLAT * radius_m { REFERENCE_HEIGHT_PX / height_m } else { 0.0 }
}

/// Sees that a pack can hold the character, so that a number that it cannot hold is this character's fault and not that of all.
///
/// # Errors
/// What reading the pack would refuse.
pub(crate) fn expect_storable(baked: &BakedCharacter, layout: AnimationLayout) -> Result<(), BakeError> {
    let contents = assemble(std::slice::from_ref(baked), layout)?;
    contents.check().map_err(|error| BakeError::of(Step::Assemble, &baked.name, Cause::NotStorable { error }))
}

/// Adds impostors to a pack, one entry a character.
pub fn add_impostors(contents: &mut PackContents, impostors: &[BakedImpostors]) {
    for one in impostors {
        contents.add_impostors(one.shape, &one.color, &one.normal);
    }
}

/// The pack so far, and where shared things lie in it.
#[derive(Default)]
struct Assembly {
    contents: PackContents,
    /// Runs of floats by their bits: characters of one rig often share their clips.
    track_offset: HashMap<Vec<u32>, u32>,
}

impl Assembly {
    fn add_character(&mut self, baked: &BakedCharacter, layout: AnimationLayout) -> Result<(), Cause> {
        let order = &baked.order;
        let coarsest = order.levels.first().copied().unwrap_or_default();
        let materials = used_materials(order);
        let out = &self.contents;
        let record = CharacterRecord {
            vertex_offset: offset("vertices", out.vertices.len(), order.vertex_source.len())?,
            vertex_count: order.vertex_source.len() as u32,
            triangle_offset: offset("triangles", out.triangles.len(), order.triangles.len())?,
            triangle_count: order.triangles.len() as u32,
            lod_offset: offset("LOD table", out.lods.len(), order.vertex_source.len() + 1)?,
            min_vertex_count: coarsest.vertex_count,
            min_triangle_count: coarsest.triangle_count,
            joint_count: baked.raw.joints.len() as u32,
            clip_offset: out.clips.len() as u32,
            clip_count: baked.animation.clips.len() as u32,
            material_offset: out.materials.len() as u32,
            material_count: materials.len() as u32,
            sphere: sphere(baked.bounds),
            box_min: baked.bounds.min,
            height_m: baked.height_m,
            box_max: baked.bounds.max,
            inverse_bind_offset: out.inverse_binds.len() as u32,
            joint_storage: match layout {
                AnimationLayout::Premultiplied3x4 => baked.animation.storage.code(),
                AnimationLayout::Split4x4 => JointStorage::F32.code(),
            },
            storage_error_m: baked.animation.error_m,
            reserved: [0; 2],
        };
        self.contents.vertices.extend(vertex_records(&baked.mesh, order, &materials));
        self.contents.triangles.extend_from_slice(&order.triangles);
        self.contents.collapse_map.extend_from_slice(&order.collapse_map);
        self.contents.lods.extend(lod_table(order));
        self.add_levels(&baked.levels)?;
        self.add_clips(baked, layout)?;
        for &material in &materials {
            let material = &baked.raw.materials[usize::from(material)];
            let record = self.material_record(material, &baked.raw.images);
            self.contents.materials.push(record);
            let finish = crate::finishes::finish_of(&mut self.contents, &material.finish, &baked.raw.finish_images);
            self.contents.finishes.materials.push(finish);
        }
        self.contents.finishes.skin_names.push(baked.raw.skin_name.clone());
        let RawCredits { copyright, extras } = baked.raw.credits.clone();
        self.contents.finishes.credits.push(Credits { copyright, extras });
        let manifest = self.manifest_character(baked, &materials)?;
        let rig = self.rig(&baked.raw)?;
        self.contents.finishes.rigs.push(rig);
        self.contents.characters.push(record);
        self.contents.manifest.characters.push(manifest);
        Ok(())
    }

    fn add_levels(&mut self, levels: &BakedLevels) -> Result<(), Cause> {
        let out = &mut self.contents;
        let discrete = levels.discrete.iter().map(|discrete| &discrete.level);
        out.level_sets.push(LevelSetRecord {
            level_offset: out.levels.len() as u32,
            quantized_count: levels.quantized.len() as u32,
            discrete_count: levels.discrete.len() as u32,
            refit_vertex_offset: out.refit_vertices.len() as u32,
        });
        for level in levels.quantized.iter().chain(discrete) {
            let index_bytes = LevelRecord::index_bytes_for(level.vertex_count);
            let index_offset = if index_bytes == 2 {
                offset("16-bit indices", out.indices_16.len(), level.indices.len())?
            } else {
                offset("32-bit indices", out.indices_32.len(), level.indices.len())?
            };
            let refit_vertex_offset = match &level.own {
                None => NONE,
                Some(own) => offset("refitted vertices", out.refit_vertices.len(), own.len())?,
            };
            out.levels.push(LevelRecord {
                vertex_count: level.vertex_count,
                triangle_count: (level.indices.len() / 3) as u32,
                index_offset,
                index_bytes,
                refit_vertex_offset,
                bound_m: level.error.surface.bound_m,
            });
            out.refit_vertices.extend_from_slice(level.own.as_deref().unwrap_or_default());
            if index_bytes == 2 {
                out.indices_16.extend(level.indices.iter().map(|&index| index as u16));
            } else {
                out.indices_32.extend_from_slice(&level.indices);
            }
        }
        Ok(())
    }

    fn add_clips(&mut self, baked: &BakedCharacter, layout: AnimationLayout) -> Result<(), Cause> {
        let measured = baked.clip_bounds.iter().zip(baked.feet.iter().map(|feet| feet.ground_speed_m_s));
        let stored = baked.animation.clips.iter().zip(&baked.animation.texels);
        for ((clip, texels), (bounds, ground_speed_m_s)) in stored.zip(measured) {
            let texels: &[Texel] = match layout {
                AnimationLayout::Premultiplied3x4 => texels,
                AnimationLayout::Split4x4 => bytemuck::cast_slice(&clip.worlds),
            };
            let record = ClipRecord {
                texel_offset: offset("animation texels", self.contents.animation.len(), texels.len())?,
                frame_count: clip.frame_count,
                duration_s: clip.duration_s,
                ground_speed_m_s,
                sphere: sphere(*bounds),
                root_displacement_m: clip.root_motion.displacement_m,
                loop_gap_m: clip.loop_gap_m,
            };
            self.contents.animation.extend_from_slice(texels);
            self.contents.clips.push(record);
        }
        if layout == AnimationLayout::Split4x4 {
            for joint in &baked.raw.joints {
                let columns: [[f32; 4]; 4] = bytemuck::cast(joint.inverse_bind);
                let row = |r: usize| std::array::from_fn(|c| columns[c][r]);
                self.contents.inverse_binds.extend((0..4).map(row));
            }
        }
        Ok(())
    }

    fn material_record(&mut self, material: &RawMaterial, images: &[RawImage]) -> MaterialRecord {
        use material_flags::{DOUBLE_SIDED, FLAT, UNLIT, WRAP_U_SHIFT};
        let bit = |set: bool, bit: u32| if set { bit } else { 0 };
        let mut flags =
            bit(material.double_sided, DOUBLE_SIDED) | bit(material.unlit, UNLIT) | bit(material.flat_normals, FLAT);
        let mut image = NONE;
        if let Some(texture) = material.texture {
            flags |= u32::from(sampler_code(texture)) << WRAP_U_SHIFT;
            image = self.image(&images[texture.image as usize]);
        }
        let alpha_cutoff = material.alpha_cutoff.unwrap_or(0.0);
        MaterialRecord { base_color: material.base_color, image, flags, alpha_cutoff, reserved: 0 }
    }

    /// The index of an image, stored once: characters of one family often share a texture.
    fn image(&mut self, image: &RawImage) -> u32 {
        let index = self.contents.add_image(&image.bytes, image.width, image.height, encoding_code(image.encoding));
        name_image(&mut self.contents.finishes.image_names, index, image);
        index
    }

    /// The offset of a run of floats, stored once however many tracks use it.
    fn track_floats(&mut self, floats: &[f32]) -> Result<u32, Cause> {
        let bits: Vec<u32> = floats.iter().map(|float| float.to_bits()).collect();
        if let Some(&offset) = self.track_offset.get(&bits) {
            return Ok(offset);
        }
        let offset = offset("track values", self.contents.track_values.len(), floats.len())?;
        self.contents.track_values.extend_from_slice(floats);
        self.track_offset.insert(bits, offset);
        Ok(offset)
    }

    fn manifest_clip(&mut self, clip: &RawClip) -> Result<ManifestClip, Cause> {
        let tracks = self.manifest_tracks(&clip.tracks)?;
        Ok(ManifestClip { name: clip.name.clone(), tracks, ..ManifestClip::default() })
    }

    /// The skin as the source has it.
    fn rig(&mut self, raw: &RawCharacter) -> Result<Rig, Cause> {
        let mut tracks = Vec::new();
        if raw.clips.iter().any(|clip| !clip.spare_tracks.is_empty()) {
            for clip in &raw.clips {
                tracks.push(self.manifest_tracks(&clip.spare_tracks)?);
            }
        }
        let joints = raw.rig.joints.iter().map(|j| ManifestJoint { node: j.node, inverse_bind: j.inverse_bind });
        Ok(Rig { joints: joints.collect(), places: raw.rig.places.clone(), tracks })
    }

    fn manifest_tracks(&mut self, raw: &[RawTrack]) -> Result<Vec<ManifestTrack>, Cause> {
        let mut tracks = Vec::with_capacity(raw.len());
        for track in raw {
            tracks.push(ManifestTrack {
                node: track.node,
                property: match track.property {
                    RawProperty::Translation => 0,
                    RawProperty::Rotation => 1,
                    RawProperty::Scale => 2,
                },
                interpolation: match track.interpolation {
                    RawInterpolation::Step => 0,
                    RawInterpolation::Linear => 1,
                    RawInterpolation::CubicSpline => 2,
                },
                time_offset: self.track_floats(&track.times)?,
                key_count: track.times.len() as u32,
                value_offset: self.track_floats(&track.values)?,
                value_count: track.values.len() as u32,
            });
        }
        Ok(tracks)
    }

    fn manifest_character(&mut self, baked: &BakedCharacter, materials: &[u16]) -> Result<ManifestCharacter, Cause> {
        let (raw, order) = (&baked.raw, &baked.order);
        let mut clips: Vec<ManifestClip> = if raw.clips.is_empty() {
            let name = |clip: &SampledClip| ManifestClip { name: clip.name.clone(), ..ManifestClip::default() };
            baked.animation.clips.iter().map(name).collect()
        } else {
            raw.clips.iter().map(|clip| self.manifest_clip(clip)).collect::<Result<_, _>>()?
        };
        for (clip, feet) in clips.iter_mut().zip(&baked.feet) {
            let contact = |c: &FootContact| ManifestContact { joint: c.joint, start_s: c.start_s, end_s: c.end_s };
            clip.contacts = feet.contacts.iter().map(contact).collect();
            clip.root_path_m.clone_from(&feet.root_path_m);
            (clip.slide_m_s, clip.rooted_slide_m_s) = (feet.slide_m_s, feet.rooted_slide_m_s);
        }
        let nodes = raw.nodes.iter().map(|node| ManifestNode {
            name: node.name.clone(),
            parent: node.parent,
            translation: node.translation,
            rotation: node.rotation,
            scale: node.scale,
        });
        let joints = raw.joints.iter().map(|j| ManifestJoint { node: j.node, inverse_bind: j.inverse_bind });
        let parts = raw.mesh.parts.iter().filter_map(|part| {
            let material = materials.binary_search(&(part.material as u16)).ok()? as u32;
            let (triangle_count, rigid) = (part.triangle_count, part.rigid);
            Some(ManifestPart { name: part.name.clone(), material, triangle_count, rigid })
        });
        let levels = order.levels.iter().map(|level| ManifestLevel {
            vertex_count: level.vertex_count,
            triangle_count: level.triangle_count,
            error_m: level.error_m,
        });
        let measured = baked.levels.quantized.iter().map(|level| manifest_measured(baked, level));
        let discrete = baked.levels.discrete.iter().map(|discrete| ManifestDiscrete {
            name: discrete.name.clone(),
            target: discrete.target.0,
            reached: discrete.reached,
            measured: manifest_measured(baked, &discrete.level),
        });
        let blocked = order.blocked;
        Ok(ManifestCharacter {
            name: baked.name.clone(),
            source: baked.source.clone(),
            nodes: nodes.collect(),
            joints: joints.collect(),
            clips,
            materials: materials.iter().map(|&m| raw.materials[usize::from(m)].name.clone()).collect(),
            parts: parts.collect(),
            criteria: criteria_name(baked.criteria).to_owned(),
            fps: baked.fps.code(),
            seams: manifest_seams(order),
            levels: levels.collect(),
            measured: measured.collect(),
            discrete: discrete.collect(),
            measuring: ManifestMeasuring {
                samples_per_frame: SAMPLES_PER_FRAME,
                mean_frames: baked.levels.frames.mean.clone(),
                worst_frames: baked.levels.frames.worst.clone(),
            },
            blocked: ManifestBlocked {
                fixed: blocked.fixed,
                seam: blocked.seam,
                topology: blocked.topology,
                flip: blocked.flip,
                ended: blocked.ended,
            },
            obstacles: order.obstacles.iter().copied().map(obstacle_code).collect(),
            warnings: baked.warnings.iter().map(warning_sentence).collect(),
        })
    }
}

/// What was measured of a level, as a pack says it.
pub(crate) fn manifest_measured(baked: &BakedCharacter, level: &BakedLevel) -> ManifestMeasured {
    let error = &level.error.surface;
    let (max_clip, max_frame) = clip_of_frame(baked, error.max_frame);
    let px_per_m = px_per_m(baked.height_m, baked.bounds.radius);
    ManifestMeasured {
        vertex_count: level.vertex_count,
        triangle_count: (level.indices.len() / 3) as u32,
        rms_m: error.rms_m,
        max_m: error.max_m,
        max_clip,
        max_frame,
        bound_m: error.bound_m,
        uv_drift_p95_texels: error.uv_drift_p95_texels,
        normal_mean_deg: error.normal_mean_deg,
        bound_px: error.bound_m * px_per_m,
        poked_share: level.error.poked_share,
    }
}

/// Materials that some vertex uses, rising; unused ones and their images stay out of the pack.
pub(crate) fn used_materials(order: &CollapseOrder) -> Vec<u16> {
    let mut used = order.vertex_materials.clone();
    used.sort_unstable();
    used.dedup();
    used
}

/// The vertices of the order as records. `materials`: those used, as [`used_materials`] lists them.
pub(crate) fn vertex_records<'a>(
    mesh: &'a QuantizedMesh,
    order: &'a CollapseOrder,
    materials: &'a [u16],
) -> impl Iterator<Item = VertexRecord> + 'a {
    (0..order.vertex_source.len()).map(move |vertex| {
        let material = materials
            .binary_search(&order.vertex_materials[vertex])
            .expect("used_materials lists the material of every vertex") as u32;
        let class = match order.vertex_classes[vertex] {
            VertexClass::Regular => vertex_class::REGULAR,
            VertexClass::Companion => vertex_class::COMPANION,
            VertexClass::Fixed => vertex_class::FIXED,
        };
        let place = mesh.records[order.vertex_source[vertex] as usize];
        let attributes = mesh.records[order.attribute_source[vertex] as usize];
        VertexRecord {
            material_class: material | (class << 16),
            position: place.position,
            normal_oct: mesh.records[order.normal_source[vertex] as usize].normal_oct,
            joints: place.joints,
            weights: place.weights,
            ..attributes
        }
    })
}

/// Entry `k`: the largest level of at most `k` vertices, or the coarsest one.
fn lod_table(order: &CollapseOrder) -> Vec<LodRecord> {
    let vertex_count = order.vertex_source.len();
    let mut table = Vec::with_capacity(vertex_count + 1);
    let mut level = 0;
    for k in 0..=vertex_count as u32 {
        while order.levels.get(level + 1).is_some_and(|next| next.vertex_count <= k) {
            level += 1;
        }
        let chosen = order.levels.get(level).copied().unwrap_or_default();
        table.push(LodRecord { vertex_count: chosen.vertex_count, triangle_count: chosen.triangle_count });
    }
    table
}

fn manifest_seams(order: &CollapseOrder) -> ManifestSeams {
    let seams = &order.seams;
    ManifestSeams {
        position_count: seams.position_count,
        wedge_count: seams.wedge_count,
        seam_position_count: seams.seam_position_count,
        fixed_count: seams.fixed_count,
        border_count: seams.border_count,
        companion_count: seams.companion_count,
        regular_count: seams.regular_count,
        degenerate_triangle_count: seams.degenerate_triangle_count,
        duplicate_triangle_count: seams.duplicate_triangle_count,
        coincident_triangle_count: seams.coincident_triangle_count,
        non_manifold_edge_count: seams.non_manifold_edge_count,
        non_manifold_position_count: seams.non_manifold_position_count,
    }
}

fn obstacle_code(obstacle: Obstacle) -> u8 {
    match obstacle {
        Obstacle::Fixed => obstacle::FIXED,
        Obstacle::Seam => obstacle::SEAM,
        Obstacle::Topology => obstacle::TOPOLOGY,
        Obstacle::Flip => obstacle::FLIP,
        Obstacle::Ended => obstacle::ENDED,
    }
}

/// Clip, and frame within it, of a frame counted over all clips.
fn clip_of_frame(baked: &BakedCharacter, mut frame: u32) -> (u32, u32) {
    for (index, clip) in baked.animation.clips.iter().enumerate() {
        if frame < clip.frame_count {
            return (index as u32, frame);
        }
        frame -= clip.frame_count;
    }
    (0, 0)
}

fn sphere(bounds: crowd_anim::Bounds) -> [f32; 4] {
    let [x, y, z] = bounds.center;
    [x, y, z, bounds.radius]
}

/// Wrapping and filters as bits 4 to 11 of a material's flags, shifted down.
pub(crate) fn sampler_code(texture: RawTexture) -> u8 {
    let wrap = |wrap: RawWrap| match wrap {
        RawWrap::Repeat => 0,
        RawWrap::Clamp => 1,
        RawWrap::Mirror => 2,
    };
    let min = match texture.filters.min {
        RawMinFilter::LinearMipmapLinear => 0,
        RawMinFilter::NearestMipmapNearest => 1,
        RawMinFilter::LinearMipmapNearest => 2,
        RawMinFilter::NearestMipmapLinear => 3,
        RawMinFilter::Nearest => 4,
        RawMinFilter::Linear => 5,
    };
    wrap(texture.wrap_u) | (wrap(texture.wrap_v) << 2) | (u8::from(texture.filters.mag_nearest) << 4) | (min << 5)
}

/// As image records have it.
pub(crate) fn encoding_code(encoding: ImageEncoding) -> u32 {
    match encoding {
        ImageEncoding::Png => 0,
        ImageEncoding::Jpeg => 1,
        ImageEncoding::WebP => 2,
    }
}

/// Keeps the name of a new image; one that is there already has its first name.
pub(crate) fn name_image(names: &mut Vec<String>, index: u32, image: &RawImage) {
    if index as usize == names.len() {
        names.push(if image.named { image.name.clone() } else { String::new() });
    }
}

/// The next offset of a section, if what follows still fits under 32-bit offsets.
fn offset(what: &'static str, have: usize, more: usize) -> Result<u32, Cause> {
    match u32::try_from(have + more) {
        Ok(_) => Ok(have as u32),
        Err(_) => Err(Cause::Limit {
            what,
            found: (have + more) as u64,
            allowed: u32::MAX.into(),
            remedy: "bake fewer characters into one pack",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_lod::Level;

    #[test]
    fn the_table_never_splits_a_level() {
        let level = |vertex_count, triangle_count| Level { vertex_count, triangle_count, error_m: 0.0 };
        let order = CollapseOrder {
            vertex_source: vec![0; 6],
            levels: vec![level(2, 1), level(4, 3), level(6, 5)],
            ..CollapseOrder::default()
        };
        let counts: Vec<_> = lod_table(&order).iter().map(|l| (l.vertex_count, l.triangle_count)).collect();
        assert_eq!(counts, [(2, 1), (2, 1), (2, 1), (2, 1), (4, 3), (4, 3), (6, 5)]);
    }

    #[test]
    fn floats_and_images_are_stored_once() {
        let mut pack = Assembly::default();
        assert_eq!(pack.track_floats(&[0.0, 1.0]).unwrap(), 0);
        assert_eq!(pack.track_floats(&[0.0, 2.0]).unwrap(), 2);
        assert_eq!(pack.track_floats(&[0.0, 1.0]).unwrap(), 0);
        assert_eq!(pack.contents.track_values.len(), 4);
        let image = |byte| RawImage {
            name: "i".into(),
            named: true,
            encoding: ImageEncoding::Png,
            width: 1,
            height: 1,
            bytes: vec![byte; 10],
        };
        assert_eq!([pack.image(&image(1)), pack.image(&image(2)), pack.image(&image(1))], [0, 1, 0]);
        assert_eq!(pack.contents.images[1].byte_offset, 64);
    }
}
