//! Twins: each stage alone on the GPU against the plain function that follows the paper, and the whole chain.

mod blend_palettes;
mod build_pyramid;
mod cases;
mod cull_by_depth;
mod cull_instances;
mod fill_budget;
mod fit_budget;
mod gather_drawn;
mod join_phases;
mod key_instances;
mod occlusion;
mod orphans;
mod place_buckets;
mod place_vertices;
mod recall_seen;
mod reform_triangles;
mod scan_counts;
mod select_lod;
mod skin_vertices;
mod sort_instances;
mod sum_weights;
mod techniques;
mod test_occlusion;
mod whole_chain;
mod write_bucket_args;
mod write_draw_args;
