//! Real characters and nasty files through `crowd-source`: everything loads as promised or is refused with its reason.

mod assets;
mod cesium;
mod damage;
mod every_file;
mod fixtures;
mod invariants;
