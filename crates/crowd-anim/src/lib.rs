//! Skeleton and clips in, sampled matrix palettes and animated bounds out.
//!
//! Curves are evaluated as glTF 2.0 appendix C says; palettes are what the papers store in animation textures
//! (Peng 2011 §5.3, Dong 2019 §5.1). What it leaves to others: reading files (`crowd-source`), laying the palettes out in
//! a pack (`crowd-pack`).

mod animated_bounds;
mod between_frames;
mod check_input;
mod evaluate_track;
mod foot_contacts;
mod frames_apart;
mod ground_speed;
mod key_rate;
mod pose_nodes;
mod sample_clip;
mod skin;
mod types;

pub use animated_bounds::{animated_bounds, union_bounds};
pub use between_frames::between_frames;
pub use foot_contacts::{FootContact, FootContacts, foot_contacts};
pub use frames_apart::frames_apart;
pub use ground_speed::ground_speed;
pub use key_rate::{USUAL_FPS, key_steps};
pub use pose_nodes::pose_at;
pub use sample_clip::{FRAME_TOLERANCE, MAX_FRAMES, MAX_MATRICES, rest_clip, sample_clip, sample_frames};
pub use types::*;
