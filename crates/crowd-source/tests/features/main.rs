//! What the reader makes of each feature of glTF and OBJ, on documents of a few vertices built here.

mod builder;
mod clips;
mod compression;
mod documents;
mod hostile;
mod materials;
mod meshes;
mod obj;
mod skins;
mod uris;
