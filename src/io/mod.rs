//! The doors: everything that reads or writes a file, and the only place that converts units.

pub mod body_obj;
pub mod embedded;
pub mod garmentcode;
pub mod picture;
