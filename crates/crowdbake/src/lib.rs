//! The command: plan, run the steps in order, report. The thin binary is `main.rs`.
