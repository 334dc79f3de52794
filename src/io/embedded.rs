//! The body and the patterns that travel within the program, so that a demonstration needs no file.
//!
//! `data/README.md` tells where they come from and how they are made again.

/// The default mannequin, for [`body_obj::parse`](super::body_obj::parse).
pub const MANNEQUIN_OBJ: &[u8] = include_bytes!("../../data/mannequin.obj");
/// A T-shirt for it, for [`garmentcode::parse`](super::garmentcode::parse).
pub const TEE: &str = include_str!("../../data/tee.json");
/// A sleeveless dress for it, for [`garmentcode::parse`](super::garmentcode::parse).
pub const DRESS: &str = include_str!("../../data/dress.json");
