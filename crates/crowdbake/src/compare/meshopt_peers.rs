//! meshoptimizer's simplifiers, used as well as we know how: normals 0.1, texture coordinates 1, skin weights 0.5,
//! permissive, no error limit; on each primitive or over the whole character.

use super::subject::Subject;
use super::{Contender, MadeLevel};
use crate::pose::{blend, pose_mesh};
use crowd_judge::{Level, SkinnedMesh};
use glam::{Mat4, Vec3, Vec4};
use meshopt::{SimplifyOptions, SimplifyVertex, VertexDataAdapter};
use std::collections::BTreeMap;
use std::time::Instant;

const NORMAL_WEIGHT: f32 = 0.1;
const UV_WEIGHT: f32 = 1.0;
const SKIN_WEIGHT: f32 = 0.5;
/// Normal and texture coordinate.
const SURFACE_ATTRIBUTES: usize = 5;
/// Calls beyond the first, each for a fiftieth more triangles.
const RETRIES: u32 = 6;
/// The library takes so many attributes.
const MOST_ATTRIBUTES: usize = 32;

/// One level; `None` where nothing is left. The library often stops below its target, so that it is asked for a little more
/// until it comes as near as it can: the seconds are those of the call whose level is kept.
pub(super) fn make_level(subject: &Subject, contender: Contender, target: u32) -> Option<MadeLevel> {
    let mut kept: Option<MadeLevel> = None;
    for step in 0..=RETRIES {
        let made = make_once(subject, contender, target + target * step / 50);
        let count = |level: &MadeLevel| level.level.mesh.triangles.len();
        let better = |level: &MadeLevel| {
            count(level) <= target as usize && kept.as_ref().is_none_or(|k| count(level) > count(k))
        };
        if let Some(level) = made.filter(better) {
            let exact = count(&level) == target as usize;
            kept = Some(level);
            if exact {
                break;
            }
        }
    }
    kept.or_else(|| make_once(subject, contender, target))
}

fn make_once(subject: &Subject, contender: Contender, target: u32) -> Option<MadeLevel> {
    let moves = matches!(contender, Contender::MeshoptUpdate | Contender::MeshoptBest);
    let whole = matches!(contender, Contender::MeshoptGlobal | Contender::MeshoptBest);
    let triangles = &subject.raw.mesh.triangles;
    let share = f64::from(target) / triangles.len() as f64;
    let (mut level, mut seconds) = (SkinnedMesh::default(), 0.0);
    let mut simplify = |triangles: &[[u32; 3]], materials: &[u16], target: usize| {
        let mut piece = Piece::weld(subject, triangles, materials);
        let started = Instant::now();
        let indices = piece.simplify(target, moves);
        seconds += started.elapsed().as_secs_f64();
        piece.append_to(&mut level, subject, &indices);
    };
    if whole {
        simplify(triangles, &subject.triangle_materials, target as usize);
    } else {
        for part in &subject.raw.mesh.parts {
            let range = part.first_triangle as usize..(part.first_triangle + part.triangle_count) as usize;
            let target = (f64::from(part.triangle_count) * share + 1e-6) as usize;
            simplify(&triangles[range.clone()], &subject.triangle_materials[range], target);
        }
    }
    (!level.triangles.is_empty()).then_some(MadeLevel { level: Level { mesh: level, poses: None }, seconds })
}

/// What goes into one call: vertices welded where nothing tells them apart, in the pose at rest.
struct Piece {
    /// A vertex of the file for each vertex here.
    sources: Vec<u32>,
    materials: Vec<u16>,
    indices: Vec<u32>,
    positions: Vec<[f32; 3]>,
    /// `SURFACE_ATTRIBUTES`, then one weight for each of `columns`.
    attributes: Vec<f32>,
    attribute_weights: Vec<f32>,
    /// Joints whose weights are attributes: the heaviest ones.
    columns: Vec<u16>,
    moved: bool,
}

impl Piece {
    fn weld(subject: &Subject, triangles: &[[u32; 3]], materials: &[u16]) -> Self {
        let mesh = &subject.raw.mesh;
        let at_rest = pose_mesh(&mesh.positions, &mesh.normals, &mesh.joints, &mesh.weights, &subject.rest_palette);
        let bits = |v: usize, material: u16| {
            (
                at_rest.positions[v].map(f32::to_bits),
                mesh.normals[v].map(f32::to_bits),
                mesh.uvs[v].map(f32::to_bits),
                (mesh.colors[v], mesh.joints[v], mesh.weights[v].map(f32::to_bits), material),
            )
        };
        let mut seen = BTreeMap::new();
        let (mut sources, mut vertex_materials) = (Vec::new(), Vec::new());
        let mut indices = Vec::new();
        for (triangle, &material) in triangles.iter().zip(materials) {
            for &v in triangle {
                let welded = *seen.entry(bits(v as usize, material)).or_insert_with(|| {
                    sources.push(v);
                    vertex_materials.push(material);
                    sources.len() as u32 - 1
                });
                indices.push(welded);
            }
        }
        let columns = heaviest_joints(subject, &sources);
        let mut attributes = Vec::new();
        for &source in &sources {
            let v = source as usize;
            attributes.extend(at_rest.normals[v]);
            attributes.extend(mesh.uvs[v]);
            let weights = attributes.len();
            attributes.resize(weights + columns.len(), 0.0);
            for (joint, weight) in mesh.joints[v].into_iter().zip(mesh.weights[v]) {
                if let Some(column) = column_of(subject, &columns, joint) {
                    attributes[weights + column] += weight;
                }
            }
        }
        let mut attribute_weights = vec![NORMAL_WEIGHT, NORMAL_WEIGHT, NORMAL_WEIGHT, UV_WEIGHT, UV_WEIGHT];
        attribute_weights.resize(SURFACE_ATTRIBUTES + columns.len(), SKIN_WEIGHT);
        let positions = sources.iter().map(|&v| at_rest.positions[v as usize]).collect();
        let materials = vertex_materials;
        Self { sources, materials, indices, positions, attributes, attribute_weights, columns, moved: false }
    }

    /// Corners of what is left.
    fn simplify(&mut self, target: usize, moves: bool) -> Vec<u32> {
        let stride = self.attribute_weights.len() * size_of::<f32>();
        let options = SimplifyOptions::Permissive;
        let mut error = 0.0;
        if moves {
            self.moved = true;
            let mut indices = self.indices.clone();
            let count = meshopt::simplify_with_update(
                &mut indices,
                &mut self.positions,
                &mut self.attributes,
                &self.attribute_weights,
                stride,
                None,
                target * 3,
                f32::MAX,
                options,
                Some(&mut error),
            );
            indices.truncate(count);
            return indices;
        }
        let bytes = bytemuck::cast_slice(&self.positions);
        let vertices = VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0).expect("whole positions");
        meshopt::simplify_with_attributes_and_locks(
            &self.indices,
            &vertices,
            &self.attributes,
            &self.attribute_weights,
            stride,
            &vec![SimplifyVertex::None; self.positions.len()],
            target * 3,
            f32::MAX,
            options,
            Some(&mut error),
        )
    }

    /// Adds what is left to a level. A triangle whose corners come from several materials gets the one that most corners
    /// have, and where a corner has another one, the texture coordinate of the vertex at that place that has it.
    fn append_to(&self, level: &mut SkinnedMesh, subject: &Subject, indices: &[u32]) {
        let mut wedges: BTreeMap<([u32; 3], u16), u32> = BTreeMap::new();
        for (v, &source) in self.sources.iter().enumerate() {
            let place = subject.raw.mesh.positions[source as usize].map(f32::to_bits);
            wedges.entry((place, self.materials[v])).or_insert(v as u32);
        }
        let mut placed: BTreeMap<(u32, u16), u32> = BTreeMap::new();
        for corners in indices.as_chunks::<3>().0 {
            let [a, b, c] = corners.map(|v| self.materials[v as usize]);
            let material = if b == c { b } else { a };
            let triangle = corners.map(|v| {
                *placed.entry((v, material)).or_insert_with(|| {
                    let mut attributes_of = v;
                    if self.materials[v as usize] != material {
                        let source = self.sources[v as usize] as usize;
                        let place = subject.raw.mesh.positions[source].map(f32::to_bits);
                        attributes_of = wedges.get(&(place, material)).copied().unwrap_or(v);
                    }
                    self.push_vertex(level, subject, v as usize, attributes_of as usize)
                })
            });
            level.triangles.push(triangle);
            level.triangle_materials.push(material);
        }
    }

    /// Adds a vertex with the place of one and the attributes of another; gives its index.
    fn push_vertex(&self, level: &mut SkinnedMesh, subject: &Subject, place: usize, attributes: usize) -> u32 {
        let mesh = &subject.raw.mesh;
        let (source, other) = (self.sources[place] as usize, self.sources[attributes] as usize);
        level.colors.push(mesh.colors[other]);
        if self.moved {
            let width = self.attribute_weights.len();
            let of = |v: usize| &self.attributes[v * width..(v + 1) * width];
            let columns = &of(place)[SURFACE_ATTRIBUTES..];
            let folds = mesh.joints[source].map(|joint| column_of(subject, &self.columns, joint));
            let given = (mesh.joints[source], mesh.weights[source]);
            let (joints, weights) = influences_from(&self.columns, columns, given, folds);
            let rows = blend(joints, weights, &subject.rest_palette).map(Vec4::from);
            let posed_from_bind = Mat4::from_cols(rows[0], rows[1], rows[2], Vec4::W).transpose();
            let bind_from_posed = posed_from_bind.inverse();
            let bind_from_posed = if bind_from_posed.is_finite() { bind_from_posed } else { Mat4::IDENTITY };
            let surface = of(attributes);
            let normal = Vec3::new(surface[0], surface[1], surface[2]);
            // A normal goes by the inverse transpose: from the pose back to bind space, by the transpose.
            let normal = posed_from_bind.transpose().transform_vector3(normal).normalize_or_zero();
            level.positions.push(bind_from_posed.transform_point3(Vec3::from(self.positions[place])).to_array());
            level.normals.push(normal.to_array());
            level.uvs.push([surface[3], surface[4]]);
            level.joints.push(joints);
            level.weights.push(weights);
        } else {
            level.positions.push(mesh.positions[source]);
            level.normals.push(mesh.normals[other]);
            level.uvs.push(mesh.uvs[other]);
            level.joints.push(mesh.joints[source]);
            level.weights.push(mesh.weights[source]);
        }
        level.positions.len() as u32 - 1
    }
}

/// Joints by their weight over some vertices, heaviest first, as many as there is room for.
fn heaviest_joints(subject: &Subject, sources: &[u32]) -> Vec<u16> {
    let mut totals = vec![0.0_f64; subject.raw.joints.len()];
    for &v in sources {
        let v = v as usize;
        for (joint, weight) in subject.raw.mesh.joints[v].into_iter().zip(subject.raw.mesh.weights[v]) {
            totals[usize::from(joint)] += f64::from(weight);
        }
    }
    let mut joints: Vec<u16> = (0..totals.len() as u16).filter(|&joint| totals[usize::from(joint)] > 0.0).collect();
    joints.sort_by(|&a, &b| totals[usize::from(b)].total_cmp(&totals[usize::from(a)]).then(a.cmp(&b)));
    joints.truncate(MOST_ATTRIBUTES - SURFACE_ATTRIBUTES);
    joints
}

/// The column of a joint; of its nearest ancestor that has one where there were too many joints.
fn column_of(subject: &Subject, columns: &[u16], joint: u16) -> Option<usize> {
    if let Some(own) = columns.iter().position(|&column| column == joint) {
        return Some(own);
    }
    let node_of = |joint: u16| subject.raw.joints[usize::from(joint)].node;
    let parent = |&node: &u32| subject.raw.nodes[node as usize].parent;
    std::iter::successors(Some(node_of(joint)), parent)
        .find_map(|node| columns.iter().position(|&column| node_of(column) == node))
}

/// The four heaviest influences: solved ones for the joints that have a column, the file's for those that stand in another
/// one's (`folds`, a column for each influence given), which is taken off there again.
fn influences_from(
    columns: &[u16],
    solved: &[f32],
    (joints, weights): ([u16; 4], [f32; 4]),
    folds: [Option<usize>; 4],
) -> ([u16; 4], [f32; 4]) {
    let mut all: Vec<(u16, f32)> = columns.iter().copied().zip(solved.iter().copied()).collect();
    for slot in 0..4 {
        let fold = folds[slot].filter(|&column| columns[column] == joints[slot]);
        if fold.is_none() && weights[slot] > 0.0 {
            if let Some(column) = folds[slot] {
                all[column].1 -= weights[slot];
            }
            all.push((joints[slot], weights[slot]));
        }
    }
    all.iter_mut().for_each(|(_, weight)| *weight = weight.max(0.0));
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    all.truncate(4);
    let total: f32 = all.iter().map(|(_, weight)| weight).sum();
    if !(total > 0.0 && total.is_finite()) {
        return (joints, weights);
    }
    all.resize(4, (0, 0.0));
    let weight = |slot: usize| all[slot].1 / total;
    (std::array::from_fn(|slot| if weight(slot) > 0.0 { all[slot].0 } else { 0 }), std::array::from_fn(weight))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folded_joint_counts_once() {
        // Joint 9 has no column and stands in that of joint 3.
        let given = ([3, 9, 0, 0], [0.4, 0.6, 0.0, 0.0]);
        let folds = [Some(1), Some(1), None, None];
        let (joints, weights) = influences_from(&[7, 3], &[0.0, 1.0], given, folds);
        assert_eq!(joints, [9, 3, 0, 0]);
        assert!((weights[0] - 0.6).abs() < 1e-6 && (weights[1] - 0.4).abs() < 1e-6, "{weights:?}");
        // What the solver moved to joint 7 stays there.
        let (joints, weights) = influences_from(&[7, 3], &[0.5, 0.6], given, folds);
        assert_eq!((joints, weights[2]), ([9, 7, 0, 0], 0.0));
    }

    #[test]
    fn nothing_solved_leaves_the_files_influences() {
        let given = ([3, 9, 0, 0], [0.4, 0.6, 0.0, 0.0]);
        assert_eq!(influences_from(&[3], &[f32::NAN], ([3, 0, 0, 0], [1.0, 0.0, 0.0, 0.0]), [Some(0); 4]).0[0], 3);
        assert_eq!(influences_from(&[], &[], given, [None; 4]).0, [9, 3, 0, 0]);
    }
}
