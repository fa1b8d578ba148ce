//! The per-frame pipeline of a crowd: cull -> weigh -> select levels -> fit the budget -> scan -> reform -> draw.
//!
//! Each stage stands four times under one name: `shaders/stages/<stage>.wgsl`, [`cpu`]`/<stage>.rs` (the twin, a plain
//! function that follows the paper), [`gpu`]`/<stage>.rs` (the dispatch) and `tests/twins/<stage>.rs`.
//! There is no window and no event loop in here: an engine hands in a device and a command encoder.

pub mod cpu;
mod data;
pub mod gpu;
mod records;

pub use data::{CrowdData, Error, Result, TextureLayer};
pub use records::*;
