//! The commands as people and pipelines meet them: exit code, words, and the files left behind, each in a fresh folder.

mod bench;
mod comparisons;
mod determinism;
mod explanations;
mod exports;
mod frames;
mod hostile;
mod inputs;
mod levels;
mod materials;
mod outputs;
mod pictures;
mod processes;
mod report_pages;
mod reports;
mod surveys;
mod verification;
mod words;
