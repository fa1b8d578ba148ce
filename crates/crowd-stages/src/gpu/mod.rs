//! The dispatches, and a renderer that records them into an engine's command encoder.
//!
//! A stage's type compiles its shader (`new`), binds typed buffers (`bind`) and records its dispatches (`record`); each can
//! be run alone. No stage binds more than eight storage buffers, and none appends atomically: places come from prefix sums,
//! so the same input gives the same buffers.

mod allocate;
mod blend_palettes;
mod bucket_draws;
mod build_pyramid;
mod cull_by_depth;
mod cull_instances;
mod draw_crowd;
mod draw_scenery;
mod fill_budget;
mod fit_budget;
mod gather_drawn;
mod join_phases;
mod kernel;
mod key_instances;
mod occlusion;
mod open_device;
mod place_buckets;
mod place_vertices;
mod play_motion;
mod pre_skinning;
mod read_back;
mod recall_seen;
mod reform_triangles;
mod renderer;
mod scan_counts;
mod select_casters;
mod select_lod;
mod selection;
mod shadows;
mod skin_vertices;
mod skinning_trial;
mod sort_instances;
mod stage_recorder;
mod sum_weights;
mod techniques;
mod test_occlusion;
mod upload;
mod vertex_inputs;
mod write_bucket_args;
mod write_draw_args;

pub use allocate::{buffer_or_error, texture_or_error};
pub use blend_palettes::BlendPalettes;
pub use build_pyramid::{BoundPyramid, BuildPyramid};
pub use cull_by_depth::CullByDepth;
pub use cull_instances::CullInstances;
pub use draw_crowd::{backdrop_source, crowd_source};
pub use draw_scenery::scenery_source;
pub use fill_budget::FillBudget;
pub use fit_budget::FitBudget;
pub use gather_drawn::GatherDrawn;
pub use join_phases::JoinPhases;
pub use key_instances::KeyInstances;
pub use open_device::{open_device, wanted_features, wanted_limits};
pub use place_buckets::PlaceBuckets;
pub use place_vertices::PlaceVertices;
pub use play_motion::{MotionPlan, PlayMotion};
pub use recall_seen::RecallSeen;
pub use reform_triangles::ReformTriangles;
pub use renderer::{CrowdRenderer, RendererOptions, STAGES};
pub use scan_counts::ScanCounts;
pub use select_casters::SelectCasters;
pub use select_lod::SelectLod;
pub use skin_vertices::SkinVertices;
pub use skinning_trial::SkinningChoice;
pub use sort_instances::SortInstances;
pub use sum_weights::SumWeights;
pub use techniques::supports;
pub use test_occlusion::TestOcclusion;
pub use upload::{ANIMATION_HEIGHT, ANIMATION_WIDTH};
pub use write_bucket_args::WriteBucketArgs;
pub use write_draw_args::WriteDrawArgs;
