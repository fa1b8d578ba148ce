//! Records of the frame: `repr(C)`, no padding surprises; the same structs stand in `shaders/shared/records.wgsl`. By what
//! they are for, in the way of a frame.

mod buckets;
pub mod dispatch;
mod flock;
mod frame;
mod impostors;
mod motion;
mod occlusion;
mod reformation;
mod selection;
mod shadows;
mod vertices;

pub use buckets::*;
pub use flock::*;
pub use frame::*;
pub use impostors::*;
pub use motion::*;
pub use occlusion::*;
pub use reformation::*;
pub use selection::*;
pub use shadows::*;
pub use vertices::*;
