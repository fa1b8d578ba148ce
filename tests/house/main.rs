//! The house: who may depend on whom, and that the page of bars says what the pages say.

mod bars;
mod dependencies;
