//! Skins: joint nodes and inverse bind matrices, brought into one bind space.
//!
//! Each skin of a file may have its own bind space (in metres, centimetres, quantised steps, lying down...). A bind space is
//! only a way to write things down: moving a skin's vertices by an affine S and its inverse bind matrices by S^-1
//! changes no pose. We choose S so that the skin stands where it stands at rest.

use glam::{DMat3, DMat4};
use std::collections::BTreeMap;

use gltf::json::Root;
use gltf::json::accessor::ComponentType::{F32, I8, I16, U8, U16};

use super::accessors::open_accessor;
use super::bound_nodes::{BoundNodes, are_equal};
use super::buffers::Buffers;
use super::document::describe;
use super::nodes::NodeTree;
use crate::names::name_or;
use crate::refusal::{Asset, Warnings};
use crate::{RawJoint, RawRig, Result};

/// A skin's joints: kept node and inverse bind matrix each.
pub(super) struct Skin {
    pub(super) place: String,
    pub(super) joints: Vec<(u32, DMat4)>,
}

/// Reads skin `index`.
pub(super) fn read_skin(
    asset: Asset<'_>,
    root: &Root,
    buffers: &Buffers<'_>,
    tree: &NodeTree,
    index: usize,
) -> Result<Skin> {
    let Some(skin) = root.skins.get(index) else {
        return Err(asset.format("nodes", format!("skin {index}, the file has {}", root.skins.len())));
    };
    let place = describe("skin", index, skin.name.as_ref());
    let count = skin.joints.len();
    if count == 0 {
        return Err(asset.format(place, "no joints"));
    }
    asset.check_limit(&place, "joints", count as u64, asset.limits.joints)?;
    let mut matrices = vec![DMat4::IDENTITY; count];
    if let Some(accessor) = skin.inverse_bind_matrices {
        let here = format!("{place}: inverseBindMatrices");
        let allowed = ("matrices", asset.limits.nodes);
        let elements = open_accessor(asset, root, buffers, &here, accessor.value(), allowed)?;
        elements.expect(&[16], &[F32, I8, U8, I16, U16])?;
        if elements.count < count {
            return Err(asset.format(here, format!("{} matrices, the skin has {count} joints", elements.count)));
        }
        let numbers = elements.read_floats(elements.normalized)?;
        for (joint, matrix) in numbers.chunks_exact(16).take(count).enumerate() {
            if matrix.iter().any(|n| !n.is_finite()) {
                return Err(asset.format(here, format!("matrix {joint} is not finite: {matrix:?}")));
            }
            let mut columns: [f64; 16] = std::array::from_fn(|i| f64::from(matrix[i]));
            // The last row is 0 0 0 1 by the rules; rounding in exporters leaves crumbs there.
            [columns[3], columns[7], columns[11], columns[15]] = [0.0, 0.0, 0.0, 1.0];
            matrices[joint] = DMat4::from_cols_array(&columns);
        }
    }
    let joints = skin.joints.iter().zip(matrices).map(|(node, matrix)| {
        let node = tree.node_remap[node.value()].expect("order_nodes keeps every joint's tree");
        (node, matrix)
    });
    Ok(Skin { place, joints: joints.collect() })
}

/// A skin's joints in its own order and in the common bind space, then those of the palette that it lacks; and where each of the palette
/// stands. Nothing where that is the palette.
pub(super) fn rig_of(skin: &Skin, common_from_skin: DMat4, palette: &Palette) -> RawRig {
    let skin_from_common = common_from_skin.inverse();
    let mut joints: Vec<(u32, DMat4)> =
        skin.joints.iter().map(|(node, bind)| (*node, *bind * skin_from_common)).collect();
    // Skins of other files name one node twice.
    let mut not_taken = BoundNodes::default();
    for (place, (node, bind)) in joints.iter().enumerate() {
        not_taken.insert(*node, bind, place as u32);
    }
    let mut places = Vec::with_capacity(palette.len());
    for (node, bind) in &palette.joints {
        let is_this = |place: &u32| are_equal(&joints[*place as usize].1, bind);
        let place = match not_taken.candidates(*node, bind).filter(is_this).min() {
            Some(place) => {
                not_taken.remove(*node, &joints[place as usize].1, place);
                place as usize
            }
            None => {
                joints.push((*node, *bind));
                joints.len() - 1
            }
        };
        // Vertices keep the very matrix that they are posed by.
        joints[place].1 = *bind;
        places.push(place as u32);
    }
    if places.len() == joints.len() && places.iter().enumerate().all(|(at, place)| at as u32 == *place) {
        return RawRig::default();
    }
    let joints: Vec<RawJoint> = joints.into_iter().map(raw_joint).collect();
    // What nothing follows refuses nothing: beyond all numbers, the joints that are followed stand alone.
    if joints.iter().flat_map(|joint| joint.inverse_bind).any(|number| !number.is_finite()) {
        return RawRig::default();
    }
    RawRig { joints, places }
}

fn raw_joint((node, matrix): (u32, DMat4)) -> RawJoint {
    RawJoint { node, inverse_bind: matrix.as_mat4().to_cols_array() }
}

/// The name of the first skin that the scene shows; empty where it has none.
pub(super) fn first_skin_name(root: &Root, tree: &NodeTree) -> String {
    let mut skins = tree.shown.iter().filter_map(|&node| root.nodes[node].mesh.and(root.nodes[node].skin));
    let name = skins.next().and_then(|skin| root.skins.get(skin.value())?.name.as_deref());
    name_or(name, String::new)
}

/// Groups skins that share a bind space, as far as one can tell: skins that bind one node by one matrix do.
///
/// Returns for each skin the lowest index of its group.
pub(super) fn group_bind_spaces(skins: &BTreeMap<usize, Skin>) -> BTreeMap<usize, usize> {
    let indices: Vec<usize> = skins.keys().copied().collect();
    // Disjoint sets over positions in `indices`; the root of a set is its lowest member.
    let mut toward_root: Vec<usize> = (0..indices.len()).collect();
    let mut palette = Palette::default();
    let mut first_user: Vec<usize> = Vec::new();
    for (position, skin) in skins.values().enumerate() {
        for (node, inverse_bind) in &skin.joints {
            let joint = palette.index(*node, *inverse_bind) as usize;
            if joint == first_user.len() {
                first_user.push(position);
            }
            let (one, other) = (find_root(&mut toward_root, first_user[joint]), find_root(&mut toward_root, position));
            toward_root[one.max(other)] = one.min(other);
        }
    }
    (0..indices.len()).map(|p| (indices[p], indices[find_root(&mut toward_root, p)])).collect()
}

/// Says so where skins follow skeletons that have nothing to do with each other: more than one character in a file, as a rule.
///
/// Two skins follow one skeleton where they share a joint, or where a joint of one hangs below a joint of the other.
pub(super) fn warn_of_several_skeletons(skins: &BTreeMap<usize, Skin>, tree: &NodeTree, warnings: &mut Warnings) {
    let places: Vec<&str> = skins.values().map(|skin| skin.place.as_str()).collect();
    let mut toward_root: Vec<usize> = (0..places.len()).collect();
    let mut join = |one: usize, other: usize| {
        let (one, other) = (find_root(&mut toward_root, one), find_root(&mut toward_root, other));
        toward_root[one.max(other)] = one.min(other);
    };
    let mut follower = vec![None; tree.nodes.len()];
    for (position, skin) in skins.values().enumerate() {
        for (node, _) in &skin.joints {
            join(*follower[*node as usize].get_or_insert(position), position);
        }
    }
    // Parents come first, so each node finds the follower of the nearest joint above it.
    for node in 0..tree.nodes.len() {
        let above = tree.nodes[node].parent.and_then(|parent| follower[parent as usize]);
        match (follower[node], above) {
            (Some(own), Some(above)) => join(own, above),
            (None, above) => follower[node] = above,
            (Some(_), None) => {}
        }
    }
    let first: Vec<&str> =
        (0..places.len()).filter(|&skin| toward_root[skin] == skin).map(|skin| places[skin]).collect();
    if first.len() > 1 {
        let named = first.iter().take(SKELETONS_NAMED).copied().collect::<Vec<_>>().join(", ");
        let others = if first.len() > SKELETONS_NAMED { ", ..." } else { "" };
        let message = format!(
            "{} skeletons that share no joint ({named}{others}) became one character, whose clips move all of them at once. If they are characters of their own, export each into a file of its own",
            first.len()
        );
        warnings.add("several-skeletons", "scene", first.len() as u64, message);
    }
}

/// Skeletons that the warning names.
const SKELETONS_NAMED: usize = 4;

fn find_root(toward_root: &mut [usize], mut member: usize) -> usize {
    while toward_root[member] != member {
        toward_root[member] = toward_root[toward_root[member]];
        member = toward_root[member];
    }
    member
}

/// The affine map that takes a group's bind space to where its skins stand at rest.
///
/// `weight_sums[skin][j]`: total weight of the skin's joint j over all vertices. The heaviest joint decides (the first one
/// in a tie): `world_rest(j) * inverse_bind(j)`.
pub(super) fn common_from_group(members: &[(&Skin, &[f64])], world_rest: &[DMat4], warnings: &mut Warnings) -> DMat4 {
    let mut heaviest = (members[0].0.joints[0], f64::NEG_INFINITY);
    for (skin, weight_sums) in members {
        for (joint, sum) in skin.joints.iter().zip(*weight_sums) {
            if *sum > heaviest.1 {
                heaviest = (*joint, *sum);
            }
        }
    }
    let (node, inverse_bind) = heaviest.0;
    let map = world_rest[node as usize] * inverse_bind;
    if is_invertible(&map) {
        return map;
    }
    let message = "the heaviest joint has no size at rest, so the skin's own bind space is kept; the skin may lie elsewhere than the others in bind pose. Give the joint a scale at rest";
    warnings.add("bind-space-kept", &members[0].0.place, 1, message);
    DMat4::IDENTITY
}

/// Whether an affine map can be undone in f64 and its result kept in f32.
pub(super) fn is_invertible(map: &DMat4) -> bool {
    let linear = DMat3::from_mat4(*map);
    let sizes = linear.x_axis.length() * linear.y_axis.length() * linear.z_axis.length();
    map.is_finite() && sizes > 1e-30 && sizes < 1e30 && linear.determinant().abs() > 1e-9 * sizes
}

/// The matrices that vertices follow, without doubles.
#[derive(Default)]
pub(super) struct Palette {
    joints: Vec<(u32, DMat4)>,
    /// Where they stand.
    bound: BoundNodes,
}

impl Palette {
    /// The palette index of a node and inverse bind matrix. Matrices within 1e-5 of their size count as equal: skins that
    /// share a skeleton share its joints.
    pub(super) fn index(&mut self, node: u32, inverse_bind: DMat4) -> u32 {
        let is_this = |i: &u32| are_equal(&self.joints[*i as usize].1, &inverse_bind);
        if let Some(index) = self.bound.candidates(node, &inverse_bind).filter(is_this).min() {
            return index;
        }
        let index = self.joints.len() as u32;
        self.joints.push((node, inverse_bind));
        self.bound.insert(node, &inverse_bind, index);
        index
    }

    pub(super) fn len(&self) -> usize {
        self.joints.len()
    }

    /// The joints with `used`, in their order, and old index to new (0 for those that are gone).
    pub(super) fn keep(self, used: &[bool]) -> (Self, Vec<u16>) {
        let mut kept = Self::default();
        let mut joint_remap = vec![0; used.len()];
        for (index, joint) in self.joints.into_iter().enumerate().filter(|(index, _)| used[*index]) {
            joint_remap[index] = kept.joints.len() as u16;
            kept.bound.insert(joint.0, &joint.1, kept.joints.len() as u32);
            kept.joints.push(joint);
        }
        (kept, joint_remap)
    }

    pub(super) fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.joints.iter().map(|(node, _)| *node)
    }

    pub(super) fn into_joints(self) -> Vec<RawJoint> {
        self.joints.into_iter().map(raw_joint).collect()
    }
}
