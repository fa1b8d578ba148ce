//! The pack format as a contract: old files load and mean the same, damaged ones are refused by name, `docs/FORMAT.md` is enough
//! to read one.

mod contract;
mod damage;
mod independent_reader;
mod page;
mod random_pack;
mod refusals;
mod round_trip;
mod tiny_pack;
mod wide_levels;
mod writing;
