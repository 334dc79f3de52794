//! draft
mod problem;
pub use problem::Relaxation;
