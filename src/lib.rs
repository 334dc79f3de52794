//! From a sewing pattern and a body to the garment already sewn and resting on the body.
#![forbid(unsafe_code)]

pub mod arrangement;
pub mod assess;
pub mod body;
pub mod check;
pub mod cli;
pub mod contact;
pub mod dynamics;
pub mod energy;
pub mod error;
pub mod garment;
pub mod geometry;
pub mod io;
pub mod minimize;
pub mod pattern;
pub mod prepositioning;

pub use error::{Code, Error, Severity, Warning};
