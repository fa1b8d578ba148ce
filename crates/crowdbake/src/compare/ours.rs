//! Our levels: the one with the most triangles that is not above the target.

use super::subject::Subject;
use super::{Contender, MadeLevel};
use crate::appearance::ShownTextures;
use crate::bake::{bake_poses, lod_mesh};
use crowd_judge::{Level, SkinnedMesh};
use crowd_lod::{CollapseOrder, Criteria, LevelMesh, LodMesh, LodOptions, LodPoses, RefitOptions};
use std::time::Instant;

/// A level for each target; the coarsest where none is small enough.
pub(super) fn make_levels(
    subject: &Subject,
    contender: Contender,
    targets: &[u32],
) -> Result<Vec<Option<MadeLevel>>, crowd_lod::Error> {
    let criteria = if contender == Contender::Peng2011 { Criteria::Peng2011 } else { Criteria::Wedge };
    let options = LodOptions { criteria, ..LodOptions::default() };
    let shown = ShownTextures::of(&subject.raw, &subject.triangle_materials);
    let mesh = lod_mesh(&subject.raw, &subject.mesh, &subject.triangle_materials, shown.view());
    let joint_count = subject.raw.joints.len();
    let baked = bake_poses(&subject.clips);
    let at_rest = LodPoses { palettes: &subject.rest_palette, joint_count, frame_weights: &[1.0] };
    let all = LodPoses { palettes: &baked.palettes, joint_count, frame_weights: &baked.frame_weights };
    let poses = if contender == Contender::Bind { at_rest } else { all };
    let started = Instant::now();
    let order = crowd_lod::simplify(&mesh, &poses, &options, &|_| {})?;
    let order_s = started.elapsed().as_secs_f64();
    let make = |&target: &u32| {
        let small_enough = order.levels.partition_point(|level| level.triangle_count <= target);
        let level = order.levels.get(small_enough.max(1) - 1)?;
        let started = Instant::now();
        let made = if contender == Contender::Refit {
            crowd_lod::refit(&mesh, &poses, &order, level, &RefitOptions::default())
        } else {
            crowd_lod::level_mesh(&mesh, &order, level)
        };
        let seconds = order_s + started.elapsed().as_secs_f64();
        Some(MadeLevel { level: Level { mesh: skinned_mesh(&mesh, &order, made), poses: None }, seconds })
    };
    Ok(targets.iter().map(make).collect())
}

fn skinned_mesh(mesh: &LodMesh<'_>, order: &CollapseOrder, level: LevelMesh) -> SkinnedMesh {
    let material = |t: &[u32; 3]| order.vertex_materials[level.vertices[t[0] as usize] as usize];
    let color = |&v: &u32| mesh.colors[order.attribute_source[v as usize] as usize];
    SkinnedMesh {
        colors: level.vertices.iter().map(color).collect(),
        triangle_materials: level.triangles.iter().map(material).collect(),
        positions: level.positions,
        normals: level.normals,
        uvs: level.uvs,
        joints: level.joints,
        weights: level.weights,
        triangles: level.triangles,
    }
}
