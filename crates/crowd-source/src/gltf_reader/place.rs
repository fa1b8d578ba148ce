//! Meshes of the scene into one mesh in one bind space, and the palette of matrices that its vertices follow.

use std::collections::BTreeMap;

use glam::{DMat3, DMat4, DVec3};
use gltf::json::Root;

use super::buffers::Buffers;
use super::materials::{MaterialTable, texture_uses};
use super::nodes::{NodeTree, node_place};
use super::primitives::{Geometry, Shape};
use super::skins::{Palette, Skin, common_from_skin, is_invertible, read_skin};
use crate::part::{PartMesh, append_part, complete_normals, weld_vertices};
use crate::refusal::{Asset, Warnings};
use crate::{RawMesh, Result};

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
) -> Result<(RawMesh, Palette)> {
    let instances = list_instances(root, tree);
    let shapes = read_shapes(asset, root, buffers, &instances, warnings)?;
    let skins = read_skins(asset, root, buffers, tree, &instances)?;
    check_repeated_counts(asset, &instances, &shapes)?;
    let weight_sums = sum_weights(asset, &instances, &shapes, &skins)?;
    let mut common_from = BTreeMap::new();
    for (index, skin) in &skins {
        common_from.insert(*index, common_from_skin(skin, &tree.world_rest, &weight_sums[index], warnings));
    }

    let mut mesh = RawMesh::default();
    let mut palette = Palette::default();
    let mut morph_targets = BTreeMap::new();
    for instance in &instances {
        for shape in &shapes[&instance.mesh] {
            let skin = instance.skin.filter(|_| !shape.influences.is_empty());
            let mut part = match skin {
                Some(skin) => follow_skin(shape, &skins[&skin], common_from[&skin], &mut palette),
                None => follow_node(shape, instance.node, tree, &mut palette),
            };
            let joint_count = palette.len() as u64;
            asset.check_limit(
                node_place(root, instance.source),
                "joints",
                joint_count,
                asset.limits.joints.min(65_536),
            )?;
            if let Some(v) = part.positions.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
                let problem = format!("vertex {v} leaves the numbers' range at rest: {:?}", shape.positions[v]);
                return Err(asset.format(&shape.place, problem));
            }
            let flat = part.normals.is_empty();
            let repaired = complete_normals(&mut part);
            let message = "normals without a direction were computed from the triangles around them";
            warnings.add("normals-repaired", &shape.place, repaired, message);
            weld_vertices(&mut part);
            let material = materials.index(shape.material, flat, warnings)?;
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
    if mesh.triangles.is_empty() {
        let found =
            format!("{} mesh nodes in the scene, none with triangles; a character needs at least one", instances.len());
        return Err(asset.format("scene", found));
    }
    Ok((mesh, palette))
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

fn read_shapes(
    asset: Asset<'_>,
    root: &Root,
    buffers: &Buffers<'_>,
    instances: &[Instance],
    warnings: &mut Warnings,
) -> Result<BTreeMap<usize, Vec<Shape>>> {
    let mut geometry = Geometry { asset, root, buffers, vertices_read: 0, triangles_read: 0 };
    let textures = texture_uses(root);
    let mut shapes = BTreeMap::new();
    for instance in instances {
        if !shapes.contains_key(&instance.mesh) {
            shapes.insert(instance.mesh, geometry.read_mesh(instance.mesh, &textures, warnings)?);
        }
    }
    Ok(shapes)
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
        if skins.contains_key(&index) {
            continue;
        }
        let skin = read_skin(asset, root, buffers, tree, index)?;
        // Skins over one skeleton fall together later; sixteen times the joints leaves room for that.
        joints_read += skin.joints.len() as u64;
        let allowed = asset.limits.joints.saturating_mul(16);
        asset.check_limit(&skin.place, "joints in all skins together", joints_read, allowed)?;
        skins.insert(index, skin);
    }
    Ok(skins)
}

/// A mesh may hang from many nodes: what it comes to is known before it is made.
fn check_repeated_counts(asset: Asset<'_>, instances: &[Instance], shapes: &BTreeMap<usize, Vec<Shape>>) -> Result<()> {
    let all = || instances.iter().flat_map(|i| &shapes[&i.mesh]);
    let vertices = all().map(|s| s.positions.len() as u64).sum();
    asset.check_limit("scene", "vertices", vertices, asset.limits.vertices)?;
    let triangles = all().map(|s| s.triangles.len() as u64).sum();
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
                        return Err(asset.format(format!("{}: JOINTS", shape.place), problem));
                    };
                    *sum += f64::from(weight);
                }
            }
        }
    }
    Ok(sums)
}

/// A skinned part: `S` moves its vertices, `S^-1` its inverse bind matrices.
fn follow_skin(shape: &Shape, skin: &Skin, common_from_skin: DMat4, palette: &mut Palette) -> PartMesh {
    let mut part = moved_part(shape, &common_from_skin);
    let skin_from_common = common_from_skin.inverse();
    let mut joint_remap: Vec<Option<u16>> = vec![None; skin.joints.len()];
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

/// An unskinned part: every vertex follows the node as if it were a joint, bound where it is at rest.
fn follow_node(shape: &Shape, node: u32, tree: &NodeTree, palette: &mut Palette) -> PartMesh {
    let world = tree.world_rest[node as usize];
    // A node with no size at rest (it grows in a clip) cannot be undone: its own space is the bind space then.
    let (common_from_mesh, inverse_bind) =
        if is_invertible(&world) { (world, world.inverse()) } else { (DMat4::IDENTITY, DMat4::IDENTITY) };
    let mut part = moved_part(shape, &common_from_mesh);
    let joint = palette.index(node, inverse_bind) as u16;
    part.joints = vec![[joint, 0, 0, 0]; shape.positions.len()];
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
