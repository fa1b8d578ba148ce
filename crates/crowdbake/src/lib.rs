//! The command: plan, run the steps in order, report. The thin binary is `main.rs`.
//!
//! `cli` holds words, `plan` meanings, `bake` the steps; [`assemble`] is the only place where the results of the bake
//! libraries become records of a pack. Data goes to stdout, talk to stderr; files appear whole or not at all.

mod appearance;
pub mod assemble;
pub mod bake;
pub mod bake_levels;
pub mod cli;
mod clip_bounds;
mod commands;
pub mod compare;
pub mod crowd_toml;
mod draw_level;
mod emission;
pub mod error;
pub mod explain;
pub mod export;
mod export_materials;
mod finishes;
mod gather_primitives;
mod glb;
mod heat;
pub mod impostors;
pub mod inspect;
mod label;
mod level_warnings;
pub mod lod_target;
pub mod measure_levels;
mod measure_packed;
pub mod ordered_mesh;
mod output;
pub mod picture;
pub mod plan;
pub mod pose;
mod refit_levels;
pub mod report;
pub mod report_page;
pub mod sample;
mod search_levels;
mod select_clips;
pub mod size;
pub mod store_animation;
mod surface_warnings;
pub mod survey;
mod talk;
mod units;
pub mod unpack;
pub mod verify;
pub mod views;

pub use bake::{BakedCharacter, bake_character, bake_file};
pub use commands::{run, run_in};
pub use error::{BakeError, Cause, Step};
