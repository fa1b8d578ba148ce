//! Measures levels of a character against its full detail: while it is baked, and again by `verify`.

use crate::ordered_mesh::{DecodedVertices, OrderedMesh};
use crate::pose::Mat3x4;
use crowd_lod::{
    LayeredMesh, Level, LevelSurface, LodPoses, SurfaceError, SurfaceMeasure, find_layers, measure_interpenetration,
    measured_frames, worse_frames, worst_frames,
};
use rayon::prelude::*;

/// Frames that the mean is taken over.
const MEAN_FRAMES: u32 = 8;
/// Levels that each name a frame in which they are worst.
const LEVELS_ASKED: usize = 16;
/// Points a side and frame that the mean is taken over.
pub const SAMPLES_PER_FRAME: u32 = 500;
/// Points and frames that look for layers that have come through each other.
const LAYER_SAMPLES: u32 = 300;

/// The triangles of a level.
#[derive(Debug, Clone)]
pub enum LevelShape {
    /// Over the character's vertices, in the order's sequence.
    Shared(Vec<[u32; 3]>),
    /// Over vertices of its own, in the order's sequence.
    Own(DecodedVertices, Vec<[u32; 3]>),
}

/// The frames to measure, counted over all clips.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeasuredFrames {
    /// For mean and maximum; rising.
    pub mean: Vec<u32>,
    /// For the maximum too: where some level is worst; rising.
    pub worst: Vec<u32>,
}

impl MeasuredFrames {
    /// Some frames drawn evenly along their weights, and the worst of a few levels. `levels`: coarsest first.
    pub fn choose(mesh: &OrderedMesh, levels: &[Level], poses: &LodPoses<'_>) -> Self {
        let mean: Vec<u32> =
            measured_frames(poses.frame_weights, MEAN_FRAMES).into_iter().map(|frame| frame as u32).collect();
        let step = levels.len().div_ceil(LEVELS_ASKED).max(1);
        let asked: Vec<Vec<[u32; 3]>> = levels.iter().step_by(step).map(|level| mesh.level_triangles(level)).collect();
        let slices: Vec<&[[u32; 3]]> = asked.iter().map(Vec::as_slice).collect();
        let worst = worst_frames(&mesh.surface(), &slices, poses, &mean);
        Self { mean, worst }
    }

    /// All of them, those of the mean first.
    pub fn all(&self) -> impl Iterator<Item = u32> + '_ {
        self.mean.iter().chain(&self.worst).copied()
    }

    /// Their palettes. `poses`: those of all clips.
    pub fn palettes(&self, poses: &LodPoses<'_>) -> Vec<Mat3x4> {
        let of = |frame: u32| &poses.palettes[frame as usize * poses.joint_count..][..poses.joint_count];
        self.all().flat_map(|frame| of(frame).iter().copied()).collect()
    }
}

/// What was measured of a level.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LevelError {
    /// Distances, texture drift, normals. The frame of the maximum is counted over all clips.
    pub surface: SurfaceError,
    /// Share of the surface that has come out through a layer which covers it at full detail.
    pub poked_share: f32,
}

/// Measures levels of a character, one call after another.
pub struct LevelMeasure<'a> {
    /// Numbers of the frames, counted over all clips.
    numbers: Vec<u32>,
    surfaces: SurfaceMeasure<'a>,
}

impl<'a> LevelMeasure<'a> {
    /// Makes ready for measuring. `palettes`: those of `frames`, in their order, `joint_count` matrices each. `samples`: points a
    /// side and frame that the mean is taken over.
    pub fn new(
        mesh: &'a OrderedMesh,
        frames: &MeasuredFrames,
        palettes: &'a [Mat3x4],
        joint_count: usize,
        samples: u32,
    ) -> Self {
        let poses = LodPoses { palettes, joint_count, frame_weights: &[] };
        Self {
            numbers: frames.all().collect(),
            surfaces: SurfaceMeasure::new(&mesh.surface(), &mesh.texels, &poses, frames.mean.len(), samples),
        }
    }

    /// What is measured of each level.
    pub fn measure(&self, shapes: &[LevelShape]) -> Vec<SurfaceError> {
        let levels: Vec<LevelSurface<'_>> = shapes
            .iter()
            .map(|shape| match shape {
                LevelShape::Shared(triangles) => LevelSurface::Shared(triangles),
                LevelShape::Own(vertices, triangles) => LevelSurface::Own(vertices.surface(triangles)),
            })
            .collect();
        let number = |error: SurfaceError| SurfaceError {
            max_frame: self.numbers.get(error.max_frame as usize).copied().unwrap_or_default(),
            ..error
        };
        self.surfaces.measure(&levels).into_iter().map(number).collect()
    }
}

/// Measures refitted levels again, each in the frame where it lies farthest off if that is farther than in `frames`: moved vertices are
/// worst elsewhere than those of the order. `errors`: what was measured in `frames`. `poses`: all frames of all clips.
pub fn measure_worse_frames(
    mesh: &OrderedMesh,
    frames: &MeasuredFrames,
    poses: &LodPoses<'_>,
    shapes: &[LevelShape],
    errors: &mut [SurfaceError],
) {
    let surfaces = shapes.iter().map(|shape| match shape {
        LevelShape::Own(vertices, triangles) => vertices.surface(triangles),
        LevelShape::Shared(triangles) => mesh.vertices.surface(triangles),
    });
    let levels: Vec<_> = surfaces.zip(errors.iter().map(|error| error.max_m)).collect();
    let known: Vec<u32> = frames.all().collect();
    let worse = worse_frames(&mesh.surface(), &levels, poses, &known);
    shapes.par_iter().zip(errors).zip(worse).for_each(|((shape, error), frame)| {
        if let Some(frame) = frame {
            let palette = &poses.palettes[frame as usize * poses.joint_count..][..poses.joint_count];
            *error = measure_in_frame_too(mesh, shape, *error, frame, palette);
        }
    });
}

/// What was measured of a level, with a further frame, counted over all clips: its maximum where that is larger.
pub fn measure_in_frame_too(
    mesh: &OrderedMesh,
    shape: &LevelShape,
    error: SurfaceError,
    frame: u32,
    palette: &[Mat3x4],
) -> SurfaceError {
    let alone = MeasuredFrames { mean: Vec::new(), worst: vec![frame] };
    let found = LevelMeasure::new(mesh, &alone, palette, palette.len(), 0).measure(std::slice::from_ref(shape))[0];
    if found.max_m > error.max_m {
        let bound_m = found.bound_m.max(error.bound_m);
        SurfaceError { max_m: found.max_m, max_frame: frame, bound_m, ..error }
    } else {
        error
    }
}

/// For each level the share of the surface that has come out through a layer, mean over `frames.mean`.
pub fn poked_shares(
    mesh: &OrderedMesh,
    shapes: &[LevelShape],
    frames: &MeasuredFrames,
    palettes: &[Mat3x4],
    joint_count: usize,
) -> Vec<f32> {
    let weights = vec![1.0 / frames.mean.len().max(1) as f32; frames.mean.len()];
    let poses =
        LodPoses { palettes: &palettes[..frames.mean.len() * joint_count], joint_count, frame_weights: &weights };
    let layers = find_layers(&mesh.vertices.positions, &mesh.order.triangles);
    let full = layered_mesh(&mesh.vertices, &mesh.order.triangles, &layers);
    let levels: Vec<LayeredMesh<'_>> = shapes
        .iter()
        .map(|shape| match shape {
            LevelShape::Shared(triangles) => layered_mesh(&mesh.vertices, triangles, &layers),
            LevelShape::Own(vertices, triangles) => layered_mesh(vertices, triangles, &layers),
        })
        .collect();
    let numbers: Vec<usize> = (0..frames.mean.len()).collect();
    let measured = measure_interpenetration(&full, &levels, &poses, &numbers, LAYER_SAMPLES);
    measured.into_iter().map(|level| level.mean_share).collect()
}

/// Layers are those of the order's triangles, of which a level keeps the first ones.
fn layered_mesh<'a>(vertices: &'a DecodedVertices, triangles: &'a [[u32; 3]], layers: &'a [u32]) -> LayeredMesh<'a> {
    LayeredMesh {
        positions: &vertices.positions,
        joints: &vertices.joints,
        weights: &vertices.weights,
        triangles,
        triangle_layers: &layers[..triangles.len()],
    }
}
