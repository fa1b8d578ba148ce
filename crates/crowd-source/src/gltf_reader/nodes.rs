//! The node tree: parents before children, every transform as translation, rotation and scale.

use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::json::Root;
use gltf::json::scene::Node;

use super::document::describe;
use crate::names::name_or;
use crate::refusal::{Asset, Warnings};
use crate::{RawNode, Result};

/// The nodes that are kept, and how the document's indices map to them.
pub(super) struct NodeTree {
    pub(super) nodes: Vec<RawNode>,
    /// By document index; `None` for nodes outside the scene whose tree holds no joint.
    pub(super) node_remap: Vec<Option<u32>>,
    /// World transform at rest, by kept node.
    pub(super) world_rest: Vec<DMat4>,
    /// Document indices of the nodes that the scene shows, in kept order.
    pub(super) shown: Vec<usize>,
}

/// Orders the tree and refuses loops and nodes with two parents.
pub(super) fn order_nodes(asset: Asset<'_>, root: &Root, warnings: &mut Warnings) -> Result<NodeTree> {
    let count = root.nodes.len();
    asset.check_limit("nodes", "nodes", count as u64, asset.limits.nodes)?;
    let parents = find_parents(asset, root)?;
    let listed = listed_in_scene(asset, root, &parents)?;
    let joints = joint_nodes(asset, root)?;

    let mut tree =
        NodeTree { nodes: Vec::new(), node_remap: vec![None; count], world_rest: Vec::new(), shown: Vec::new() };
    let mut reached = vec![false; count];
    for top in (0..count).filter(|n| parents[*n].is_none()) {
        let members = walk_depth_first(root, top, &listed);
        for (member, _) in &members {
            reached[*member] = true;
        }
        if members.iter().any(|(member, shown)| *shown || joints[*member]) {
            keep_tree(asset, root, &parents, &members, &mut tree, warnings)?;
        }
    }
    if let Some(node) = reached.iter().position(|r| !r) {
        return Err(asset.format(node_place(root, node), "its ancestors form a loop; a node tree has a top"));
    }
    Ok(tree)
}

fn find_parents(asset: Asset<'_>, root: &Root) -> Result<Vec<Option<usize>>> {
    let mut parents = vec![None; root.nodes.len()];
    for (index, node) in root.nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            let Some(parent) = parents.get_mut(child.value()) else {
                let problem = format!("child {}, the file has {} nodes", child.value(), root.nodes.len());
                return Err(asset.format(node_place(root, index), problem));
            };
            if let Some(other) = parent.replace(index) {
                let problem = format!("has two parents, nodes {other} and {index}; allowed is one");
                return Err(asset.format(node_place(root, child.value()), problem));
            }
        }
    }
    Ok(parents)
}

/// The tops that the default scene lists. A file without scenes shows everything.
fn listed_in_scene(asset: Asset<'_>, root: &Root, parents: &[Option<usize>]) -> Result<Vec<bool>> {
    let mut listed = vec![false; root.nodes.len()];
    if root.scenes.is_empty() {
        for (node, parent) in parents.iter().enumerate() {
            listed[node] = parent.is_none();
        }
        return Ok(listed);
    }
    let default = root.scene.map_or(0, |s| s.value());
    let Some(scene) = root.scenes.get(default) else {
        return Err(asset.format("scene", format!("scene {default}, the file has {}", root.scenes.len())));
    };
    for node in &scene.nodes {
        let Some(listed) = listed.get_mut(node.value()) else {
            let problem = format!("node {}, the file has {}", node.value(), root.nodes.len());
            return Err(asset.format(describe("scene", default, scene.name.as_ref()), problem));
        };
        *listed = true;
    }
    Ok(listed)
}

fn joint_nodes(asset: Asset<'_>, root: &Root) -> Result<Vec<bool>> {
    let mut joints = vec![false; root.nodes.len()];
    for (index, skin) in root.skins.iter().enumerate() {
        for joint in &skin.joints {
            let Some(joint) = joints.get_mut(joint.value()) else {
                let problem = format!("joint node {}, the file has {} nodes", joint.value(), root.nodes.len());
                return Err(asset.format(describe("skin", index, skin.name.as_ref()), problem));
            };
            *joint = true;
        }
    }
    Ok(joints)
}

/// The tree under `top`, parents first, children in the file's order; with each node, whether the scene shows it.
fn walk_depth_first(root: &Root, top: usize, listed: &[bool]) -> Vec<(usize, bool)> {
    let mut members = Vec::new();
    let mut waiting = vec![(top, false)];
    while let Some((node, parent_shown)) = waiting.pop() {
        let shown = parent_shown || listed[node];
        members.push((node, shown));
        waiting.extend(root.nodes[node].children.iter().flatten().rev().map(|c| (c.value(), shown)));
    }
    members
}

fn keep_tree(
    asset: Asset<'_>,
    root: &Root,
    parents: &[Option<usize>],
    members: &[(usize, bool)],
    tree: &mut NodeTree,
    warnings: &mut Warnings,
) -> Result<()> {
    for &(member, shown) in members {
        let node = &root.nodes[member];
        let place = node_place(root, member);
        let (translation, rotation, scale) = read_transform(asset, &place, node, warnings)?;
        let parent =
            parents[member].map(|p| tree.node_remap[p].expect("walk_depth_first lists parents before children"));
        // What others will see of the transform is its f32 form; the world transforms are made from that.
        let (translation, rotation, scale) = (translation.as_vec3(), rotation.as_quat(), scale.as_vec3());
        let local =
            DMat4::from_scale_rotation_translation(scale.as_dvec3(), rotation.as_dquat(), translation.as_dvec3());
        let world = parent.map_or(local, |p| tree.world_rest[p as usize] * local);
        tree.node_remap[member] = Some(tree.nodes.len() as u32);
        tree.world_rest.push(world);
        tree.nodes.push(RawNode {
            name: name_or(node.name.as_deref(), || format!("node {member}")),
            parent,
            translation: translation.to_array(),
            rotation: rotation.to_array(),
            scale: scale.to_array(),
        });
        if shown {
            tree.shown.push(member);
        }
    }
    Ok(())
}

fn read_transform(
    asset: Asset<'_>,
    place: &str,
    node: &Node,
    warnings: &mut Warnings,
) -> Result<(DVec3, DQuat, DVec3)> {
    let finite = |what: &str, numbers: &[f32]| match numbers.iter().all(|n| n.is_finite()) {
        true => Ok(()),
        false => Err(asset.format(place, format!("{what} is not finite: {numbers:?}"))),
    };
    if let Some(matrix) = &node.matrix {
        finite("matrix", matrix)?;
        return Ok(decompose_matrix(place, &DMat4::from_cols_array(&matrix.map(f64::from)), warnings));
    }
    let translation = node.translation.unwrap_or([0.0; 3]);
    let rotation = node.rotation.unwrap_or_default().0;
    let scale = node.scale.unwrap_or([1.0; 3]);
    finite("translation", &translation)?;
    finite("rotation", &rotation)?;
    finite("scale", &scale)?;
    let quaternion = DQuat::from_array(rotation.map(f64::from));
    let rotation = if quaternion.length_squared() > 1e-12 {
        quaternion.normalize()
    } else {
        let message = "a rotation of length zero was taken as none";
        warnings.add("rotation-repaired", place, 1, message);
        DQuat::IDENTITY
    };
    Ok((DVec3::from_array(translation.map(f64::from)), rotation, DVec3::from_array(scale.map(f64::from))))
}

/// Splits a matrix into translation, rotation and scale; tolerates zero scales, drops shear with a warning.
fn decompose_matrix(place: &str, matrix: &DMat4, warnings: &mut Warnings) -> (DVec3, DQuat, DVec3) {
    let axes = [matrix.x_axis.truncate(), matrix.y_axis.truncate(), matrix.z_axis.truncate()];
    let mut scale = DVec3::new(axes[0].length(), axes[1].length(), axes[2].length());
    // Gram-Schmidt; an axis that is gone is replaced by one that completes the frame.
    let x = axes[0].try_normalize().unwrap_or_else(|| match axes[1].cross(axes[2]).try_normalize() {
        Some(x) => x,
        None => (axes[1] + axes[2]).try_normalize().map_or(DVec3::X, |other| other.any_orthonormal_vector()),
    });
    let y = (axes[1] - x * x.dot(axes[1])).try_normalize().filter(|_| scale.y > 0.0);
    let y = y.unwrap_or_else(|| axes[2].cross(x).try_normalize().unwrap_or_else(|| x.any_orthonormal_vector()));
    let z = x.cross(y);
    if z.dot(axes[2]) < 0.0 {
        scale.z = -scale.z;
    }
    let rotation = DQuat::from_mat3(&DMat3::from_cols(x, y, z)).normalize();
    let translation = matrix.w_axis.truncate();
    let again = DMat4::from_scale_rotation_translation(scale, rotation, translation);
    let size = scale.abs().max_element().max(1e-30);
    let off = (0..3).map(|c| (again.col(c) - matrix.col(c)).truncate().length()).fold(0.0, f64::max);
    if off > 1e-3 * size {
        let percent = off / size * 100.0;
        let message = format!(
            "the node's matrix shears, which translation, rotation and scale cannot say; it is off by {percent:.1} % of its scale. Apply transforms before export"
        );
        warnings.add("shear-dropped", place, 1, message);
    }
    (translation, rotation, scale)
}

/// How messages name a node.
pub(super) fn node_place(root: &Root, node: usize) -> String {
    describe("node", node, root.nodes.get(node).and_then(|n| n.name.as_ref()))
}
