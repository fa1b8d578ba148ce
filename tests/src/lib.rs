//! What the tests share: where the fixtures lie, a crowd made of numbers alone, a GPU to run stages on, what the documents teach.

pub mod folders;
pub mod gpu;
pub mod synthetic;
pub mod taught;
