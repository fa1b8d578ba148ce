//! The player: open packs, run the stages, draw, show. The thin binary is `main.rs`.
