//! glTF 2.0 in, one character out. The steps, in the order in which the file goes through them:
//! container, document, node tree, primitives, skins, common bind space, clips; materials and images as parts ask for
//! them.

mod accessors;
mod bound_nodes;
mod buffers;
mod clips;
mod container;
mod decompress;
mod document;
mod finish;
mod images;
mod influences;
mod materials;
mod nodes;
mod place;
mod primitives;
mod skins;

pub(crate) use materials::default_material;

use crate::folder::Folder;
use crate::refusal::{Asset, Warnings};
use crate::{RawCharacter, Result};

/// The URIs of a document's buffers and images, whatever else is wrong with it.
pub(crate) fn list_uris(asset: Asset<'_>, bytes: &[u8]) -> Result<Vec<String>> {
    let json = container::split_container(asset, bytes)?.json;
    let document = document::parse_json(asset, json)?;
    let lists = ["buffers", "images"].into_iter().filter_map(|list| document.get(list)?.as_array());
    Ok(lists.flatten().filter_map(|item| Some(item.get("uri")?.as_str()?.to_owned())).collect())
}

/// Reads a `.glb` or `.gltf`, told apart by content. `name` becomes the character's.
pub(crate) fn read_gltf(asset: Asset<'_>, name: String, bytes: &[u8]) -> Result<RawCharacter> {
    let mut warnings = Warnings::default();
    let container = container::split_container(asset, bytes)?;
    let root = document::parse_document(asset, container.json, &mut warnings)?;
    let credits = document::read_credits(&root, &mut warnings);
    let folder = Folder::of(asset)?;
    let buffers = buffers::Buffers::new(asset, &root, &folder, container.bin);
    let tree = nodes::order_nodes(asset, &root, &mut warnings)?;

    let images = || images::ImageTable::new(asset, &root, &buffers, &folder);
    let mut materials = materials::MaterialTable::new(asset, &root, images(), images());
    let (mesh, palette, rig) = place::place_meshes(asset, &root, &buffers, &tree, &mut materials, &mut warnings)?;

    let moving = carrying_nodes(&tree, palette.nodes());
    let clips = clips::read_clips(asset, &root, &buffers, &tree.node_remap, &moving, &mut warnings)?;
    let skin_name = skins::first_skin_name(&root, &tree);
    Ok(RawCharacter {
        name,
        skin_name,
        credits,
        mesh,
        materials: materials.materials,
        images: materials.images.images,
        finish_images: materials.finish_images.images,
        nodes: tree.nodes,
        joints: palette.into_joints(),
        rig,
        clips,
        warnings: warnings.into_list(),
    })
}

/// For each kept node, whether it or a node below it is one of `joints`.
fn carrying_nodes(tree: &nodes::NodeTree, joints: impl Iterator<Item = u32>) -> Vec<bool> {
    let mut carrying = vec![false; tree.nodes.len()];
    for joint in joints {
        carrying[joint as usize] = true;
    }
    for node in (0..tree.nodes.len()).rev() {
        if let Some(parent) = tree.nodes[node].parent.filter(|_| carrying[node]) {
            carrying[parent as usize] = true;
        }
    }
    carrying
}
