//! The `.crowdpack` file: records, limits, reading, writing, checking.
//!
//! `docs/FORMAT.md` describes the bytes for readers in other languages. GPU sections are raw little-endian records that
//! are uploaded as they lie; only the manifest is bincode. A pack is untrusted input: everything is checked before use.

mod check_contents;
mod check_impostors;
mod check_levels;
mod check_manifest;
mod contents;
mod encode_vertex;
mod error;
mod finishes;
pub mod layout;
pub mod limits;
mod manifest;
mod read_pack;
mod records;
mod store_joint;
pub mod whole_file;
mod write_pack;

pub use contents::{Pack, PackContents, WriteReport};
pub use encode_vertex::*;
pub use error::{Error, Result};
pub use finishes::{Credits, Finish, FinishBase, FinishTexture, Finishes, Rig};
pub use manifest::*;
pub use records::*;
pub use store_joint::{
    JointRows, JointStorage, ROTATION_EXPONENT, TRANSLATION_EXPONENT, Texel, store_frame, stored_frames, stored_joint,
};
