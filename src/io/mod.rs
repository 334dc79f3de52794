//! The doors: everything that reads or writes a file, and the only place that converts units.
//!
//! Each format is a file of small pure functions from data to bytes and back. Only [`read`] and [`atomic`] touch a
//! disk, [`motion_cache`], whose file grows, and [`export`], which fills a folder; only [`process`] asks the machine.
//! `docs/formats.md` describes the formats themselves.

pub mod arrangement_toml;
pub mod atomic;
pub mod body_obj;
pub mod checkpoint;
pub mod comparison;
pub mod draft;
pub mod dxf;
pub mod embedded;
pub mod export;
pub mod fabric_toml;
pub mod findings;
pub mod freesewing;
pub mod garment_obj;
pub mod garmentcode;
pub mod glb;
pub mod length;
pub mod motion_cache;
pub mod moving_body;
pub mod outfit_report;
pub mod pattern_file;
pub mod picture;
pub mod process;
pub mod read;
pub mod report;
pub mod seams_svg;
pub mod seams_toml;
pub mod settings_toml;
pub mod simulation_report;
pub mod state;
pub mod toile_pattern;

mod stretch_text;
mod toml_keys;

#[cfg(test)]
mod sample;
