//! The house: who may depend on whom, and that the page of bars and the README say what the pages say.

mod bars;
mod dependencies;
mod readme;
