//! The doors: everything that reads or writes a file, and the only place that converts units.
//!
//! Each format is a file of small pure functions from data to bytes and back; only [`read`] and
//! [`atomic`] touch a disk, and only [`process`] asks the machine. `docs/formats.md` describes the
//! formats themselves.

pub mod arrangement_toml;
pub mod atomic;
pub mod body_obj;
pub mod comparison;
pub mod embedded;
pub mod fabric_toml;
pub mod garment_obj;
pub mod garmentcode;
pub mod glb;
pub mod length;
pub mod outfit_report;
pub mod picture;
pub mod process;
pub mod read;
pub mod report;
pub mod settings_toml;
pub mod state;

mod toml_keys;

#[cfg(test)]
mod sample;
