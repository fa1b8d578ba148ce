//! What the tests share: where the fixtures lie, a crowd made of numbers alone, a GPU to run stages on.

pub mod folders;
pub mod gpu;
pub mod synthetic;
