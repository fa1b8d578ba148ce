//! The house: who may depend on whom, and that no shader stage is an orphan of its name.

mod dependencies;
