//! Shared helpers of the tests: where the fixtures lie, a crowd made of numbers alone, a GPU to run stages on, how images
//! are compared.

pub mod folders;
pub mod gpu;
pub mod images;
pub mod synthetic;
