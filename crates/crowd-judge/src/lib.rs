//! Says how far a level of a character is from the original: in shape, normals, colour, texture and in pictures.
//!
//! It knows nothing of how levels are made, and shares no code with the simplifier: a mistake cannot hide in both. Levels
//! of ours and of other tools are judged alike, from the original as its file has it, over poses that the caller chooses
//! (held-out ones: not those that a simplifier was shown).
//! What it leaves to others: files (`crowd-source`), poses (`crowd-anim`), who is compared (`crowdbake compare`).
//!
//! The steps of [`Judge::judge`]: `spread` points over each surface, `pose` both, find the `nearest` points of the other
//! surface, sum up in `verdict`; and draw both in `pictures`.

mod joints;
mod judge;
mod nearest;
mod pictures;
mod pose;
mod spread;
#[cfg(test)]
mod tests;
mod types;
mod verdict;

pub use judge::Judge;
pub use types::*;
