//! Meshes of the scene into one mesh in one bind space, and the palette of matrices that its vertices follow.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use glam::{DMat3, DMat4, DVec3};
use gltf::json::Root;

use super::buffers::Buffers;
use super::materials::{MaterialTable, texture_uses};
use super::nodes::{NodeTree, node_place};
use super::primitives::{Geometry, Shape};
use super::skins::{
    Palette, Skin, common_from_group, group_bind_spaces, is_invertible, read_skin, rig_of, warn_of_several_skeletons,
};
use crate::part::{
    DEGENERATE, PartMesh, all_degenerate, append_part, complete_normals, is_too_far, too_far, weld_vertices,
};
use crate::refusal::{Asset, Warnings};
use crate::turned_surfaces::{TURNED, count_turned};
use crate::{RawMesh, RawRig, Result};

/// A mesh hanging from a node of the scene.
struct Instance {
    /// Kept node.
    node: u32,
    /// Document node.
    source: usize,
    mesh: usize,
    skin: Option<usize>,
}

/// Repeats every mesh for each node that shows it, moves all into the common bind space and appends them.
pub(super) fn place_meshes(
    asset: Asset<'_>,
    root: &Root,
    buffers: &Buffers<'_>,
    tree: &NodeTree,
    materials: &mut MaterialTable<'_, '_>,
    warnings: &mut Warnings,
) -> Result<(RawMesh, Palette, RawRig)> {
    let instances = list_instances(root, tree);
    let (shapes, skipped, mut degenerate_count) = read_shapes(asset, root, buffers, &instances, warnings)?;
    let skins = read_skins(asset, root, buffers, tree, &instances)?;
    warn_of_several_skeletons(&skins, tree, warnings);
    check_repeated_counts(asset, &instances, &shapes)?;
    let weight_sums = sum_weights(asset, &instances, &shapes, &skins)?;
    let common_from = choose_common_spaces(tree, &skins, &weight_sums, warnings);

    let mut mesh = RawMesh::default();
    let mut palette = Palette::default();
    let mut joint_remaps: BTreeMap<usize, Vec<Option<u16>>> = BTreeMap::new();
    let mut morph_targets = BTreeMap::new();
    for instance in &instances {
        let mut bound = None;
        for shape in &shapes[&instance.mesh] {
            let skin = instance.skin.filter(|_| !shape.influences.is_empty());
            let mut part = match skin {
                Some(index) => {
                    let remap = joint_remaps.entry(index).or_insert_with(|| vec![None; skins[&index].joints.len()]);
                    follow_skin(shape, &skins[&index], common_from[&index], remap, &mut palette)
                }
                None => {
                    let bound = bound.get_or_insert_with(|| bind_to_node(instance.node, tree, &mut palette));
                    follow_node(shape, bound)
                }
            };
            let joint_count = palette.len() as u64;
            let here = node_place(root, instance.source);
            asset.check_limit(here, "joints", joint_count, asset.limits.joints.min(65_536))?;
            if let Some(v) = part.positions.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
                let problem = format!("vertex {v} leaves the numbers' range at rest: {:?}", shape.positions[v]);
                return Err(asset.format(&shape.place, problem));
            }
            if let Some(v) = part.positions.iter().position(is_too_far) {
                return Err(asset.format(&shape.place, format!("vertex {v} {}", too_far(&part.positions[v]))));
            }
            let flat = part.normals.is_empty();
            let repaired = complete_normals(&mut part);
            let message = "normals without a direction were computed from the triangles around them";
            warnings.add("normals-repaired", &shape.place, repaired, message);
            let degenerate = weld_vertices(&mut part);
            degenerate_count += degenerate;
            warnings.add("degenerate-triangles-dropped", &shape.place, degenerate, DEGENERATE);
            if part.triangles.is_empty() {
                continue;
            }
            let material = materials.index(shape.material, flat, warnings)?;
            if !shape.normals.is_empty() && !materials.materials[material as usize].double_sided {
                warnings.add("turned-surfaces", &shape.place, count_turned(&part), TURNED);
            }
            append_part(&mut mesh, part, shape.name.clone(), material, skin.is_none());
            if shape.morph_targets > 0 {
                morph_targets.insert(instance.mesh, (shape.place.clone(), shape.morph_targets));
            }
        }
    }
    for (place, count) in morph_targets.values() {
        let message = format!(
            "{count} morph targets are not supported and were left out; the mesh shows its base shape. Bake the wanted shape into the mesh before export"
        );
        warnings.add("morph-targets-ignored", place, *count, message);
    }
    if mesh.triangles.is_empty() && degenerate_count > 0 {
        return Err(asset.format("scene", all_degenerate(degenerate_count)));
    }
    if mesh.triangles.is_empty() {
        let found = format!(
            "no triangles: {} of the file's nodes show a mesh of its {}, {skipped} primitives are points or lines; a character needs at least one triangle",
            instances.len(),
            root.meshes.len()
        );
        return Err(asset.format("scene", found));
    }
    let palette = drop_unused_joints(&mut mesh, palette);
    let first_skin = instances.iter().find_map(|instance| instance.skin);
    let rig = first_skin.map(|skin| rig_of(&skins[&skin], common_from[&skin], &palette)).unwrap_or_default();
    let rig = if rig.joints.len() as u64 <= asset.limits.joints { rig } else { RawRig::default() };
    Ok((mesh, palette, rig))
}

fn list_instances(root: &Root, tree: &NodeTree) -> Vec<Instance> {
    let shown = tree.shown.iter().filter_map(|&source| {
        let node = &root.nodes[source];
        Some(Instance {
            node: tree.node_remap[source].expect("shown nodes are kept"),
            source,
            mesh: node.mesh?.value(),
            skin: node.skin.map(|s| s.value()),
        })
    });
    shown.collect()
}

/// Shapes by mesh; how many primitives are points or lines; how many triangles use one vertex twice.
fn read_shapes(
    asset: Asset<'_>,
    root: &Root,
    buffers: &Buffers<'_>,
    instances: &[Instance],
    warnings: &mut Warnings,
) -> Result<(BTreeMap<usize, Vec<Shape>>, u64, u64)> {
    let mut geometry =
        Geometry { asset, root, buffers, vertices_read: 0, triangles_read: 0, degenerate: 0, skipped: 0 };
    let textures = texture_uses(root);
    let mut shapes = BTreeMap::new();
    for instance in instances {
        if let Entry::Vacant(fresh) = shapes.entry(instance.mesh) {
            fresh.insert(geometry.read_mesh(instance.mesh, &textures, warnings)?);
        }
    }
    Ok((shapes, geometry.skipped, geometry.degenerate))
}

fn read_skins(
    asset: Asset<'_>,
    root: &Root,
    buffers: &Buffers<'_>,
    tree: &NodeTree,
    instances: &[Instance],
) -> Result<BTreeMap<usize, Skin>> {
    let mut skins = BTreeMap::new();
    let mut joints_read = 0u64;
    for index in instances.iter().filter_map(|i| i.skin) {
        let Entry::Vacant(fresh) = skins.entry(index) else { continue };
        let skin = read_skin(asset, root, buffers, tree, index)?;
        // Skins over one skeleton fall together later; four times the joints leaves room for that.
        joints_read += skin.joints.len() as u64;
        let allowed = asset.limits.joints.saturating_mul(4);
        asset.check_limit(&skin.place, "joints in all skins together", joints_read, allowed)?;
        fresh.insert(skin);
    }
    Ok(skins)
}

/// A mesh may hang from many nodes: what it comes to is known before it is made.
fn check_repeated_counts(asset: Asset<'_>, instances: &[Instance], shapes: &BTreeMap<usize, Vec<Shape>>) -> Result<()> {
    let counts: BTreeMap<usize, (u64, u64)> = shapes
        .iter()
        .map(|(mesh, shapes)| {
            let vertices = shapes.iter().map(|s| s.positions.len() as u64).sum();
            (*mesh, (vertices, shapes.iter().map(|s| s.triangles.len() as u64).sum()))
        })
        .collect();
    let vertices = instances.iter().map(|i| counts[&i.mesh].0).sum();
    asset.check_limit("scene", "vertices", vertices, asset.limits.vertices)?;
    let triangles = instances.iter().map(|i| counts[&i.mesh].1).sum();
    asset.check_limit("scene", "triangles", triangles, asset.limits.triangles)
}

/// Total weight of each skin's joints. Refuses joints that the skin does not have.
fn sum_weights(
    asset: Asset<'_>,
    instances: &[Instance],
    shapes: &BTreeMap<usize, Vec<Shape>>,
    skins: &BTreeMap<usize, Skin>,
) -> Result<BTreeMap<usize, Vec<f64>>> {
    let mut sums: BTreeMap<usize, Vec<f64>> =
        skins.iter().map(|(index, skin)| (*index, vec![0.0; skin.joints.len()])).collect();
    for instance in instances {
        let Some(sums) = instance.skin.and_then(|skin| sums.get_mut(&skin)) else { continue };
        let joint_count = sums.len();
        for shape in &shapes[&instance.mesh] {
            for (vertex, influence) in shape.influences.iter().enumerate() {
                for (joint, weight) in influence.joints.iter().zip(influence.weights) {
                    let Some(sum) = sums.get_mut(*joint as usize) else {
                        let problem =
                            format!("vertex {vertex}: joint index {joint}, skeleton has {joint_count} joints");
                        let sets = match shape.joint_sets {
                            1 => "JOINTS_0".to_owned(),
                            sets => format!("JOINTS_0 to JOINTS_{}", sets - 1),
                        };
                        return Err(asset.format(format!("{}: {sets}", shape.place), problem));
                    };
                    *sum += f64::from(weight);
                }
            }
        }
    }
    Ok(sums)
}

/// Vertices that fell away may have been a joint's only ones.
fn drop_unused_joints(mesh: &mut RawMesh, palette: Palette) -> Palette {
    let mut used = vec![false; palette.len()];
    for (joints, weights) in mesh.joints.iter().zip(&mesh.weights) {
        (0..4).filter(|s| weights[*s] > 0.0).for_each(|s| used[joints[s] as usize] = true);
    }
    let (palette, joint_remap) = palette.keep(&used);
    for (joints, weights) in mesh.joints.iter_mut().zip(&mesh.weights) {
        for slot in 0..4 {
            joints[slot] = if weights[slot] > 0.0 { joint_remap[joints[slot] as usize] } else { 0 };
        }
    }
    palette
}

/// For each skin, the map from its own bind space into the common one.
fn choose_common_spaces(
    tree: &NodeTree,
    skins: &BTreeMap<usize, Skin>,
    weight_sums: &BTreeMap<usize, Vec<f64>>,
    warnings: &mut Warnings,
) -> BTreeMap<usize, DMat4> {
    let group_of = group_bind_spaces(skins);
    let mut members: BTreeMap<usize, Vec<(&Skin, &[f64])>> = BTreeMap::new();
    for (index, group) in &group_of {
        members.entry(*group).or_default().push((&skins[index], &weight_sums[index][..]));
    }
    let maps: BTreeMap<usize, DMat4> = members
        .iter()
        .map(|(group, members)| (*group, common_from_group(members, &tree.world_rest, warnings)))
        .collect();
    group_of.iter().map(|(index, group)| (*index, maps[group])).collect()
}

/// A skinned part: `S` moves its vertices, `S^-1` its inverse bind matrices. `joint_remap`: the palette index of each of the
/// skin's joints that a vertex has used so far.
fn follow_skin(
    shape: &Shape,
    skin: &Skin,
    common_from_skin: DMat4,
    joint_remap: &mut [Option<u16>],
    palette: &mut Palette,
) -> PartMesh {
    let mut part = moved_part(shape, &common_from_skin);
    let skin_from_common = common_from_skin.inverse();
    for influence in &shape.influences {
        let mut joints = [0; 4];
        for slot in (0..4).filter(|s| influence.weights[*s] > 0.0) {
            let joint = influence.joints[slot] as usize;
            joints[slot] = *joint_remap[joint].get_or_insert_with(|| {
                let (node, inverse_bind) = skin.joints[joint];
                palette.index(node, inverse_bind * skin_from_common) as u16
            });
        }
        part.joints.push(joints);
        part.weights.push(influence.weights);
    }
    part
}

/// How an unskinned mesh follows its node: the map into the common space, and the palette's joint.
fn bind_to_node(node: u32, tree: &NodeTree, palette: &mut Palette) -> (DMat4, u16) {
    let world = tree.world_rest[node as usize];
    // A node with no size at rest (it grows in a clip) cannot be undone: its own space is the bind space then.
    let (common_from_mesh, inverse_bind) =
        if is_invertible(&world) { (world, world.inverse()) } else { (DMat4::IDENTITY, DMat4::IDENTITY) };
    (common_from_mesh, palette.index(node, inverse_bind) as u16)
}

/// An unskinned part: every vertex follows the node as if it were a joint, bound where it is at rest.
fn follow_node(shape: &Shape, (common_from_mesh, joint): &(DMat4, u16)) -> PartMesh {
    let mut part = moved_part(shape, common_from_mesh);
    part.joints = vec![[*joint, 0, 0, 0]; shape.positions.len()];
    part.weights = vec![[1.0, 0.0, 0.0, 0.0]; shape.positions.len()];
    part
}

/// Positions by `map`, normals by its inverse transpose; a mirroring map turns the triangles round.
fn moved_part(shape: &Shape, map: &DMat4) -> PartMesh {
    let vector = |v: &[f32; 3]| DVec3::from_array(v.map(f64::from));
    let positions = shape.positions.iter().map(|p| map.transform_point3(vector(p)).as_vec3().to_array()).collect();
    let linear = DMat3::from_mat4(*map);
    let normal_map = linear.inverse().transpose();
    let normals = shape.normals.iter().map(|n| (normal_map * vector(n)).try_normalize().unwrap_or(DVec3::ZERO));
    let mirrors = linear.determinant() < 0.0;
    let turned = |t: &[u32; 3]| if mirrors { [t[0], t[2], t[1]] } else { *t };
    PartMesh {
        positions,
        normals: normals.map(|n| n.as_vec3().to_array()).collect(),
        uvs: shape.uvs.clone(),
        colors: shape.colors.clone(),
        joints: Vec::with_capacity(shape.positions.len()),
        weights: Vec::with_capacity(shape.positions.len()),
        triangles: shape.triangles.iter().map(turned).collect(),
    }
}
