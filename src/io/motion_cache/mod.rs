//! `motion.toile`: how the particles of a garment move, frame by frame.
//!
//! A file that grows: each frame is a record of fixed size with a checksum of its own, so that a run that is killed
//! leaves all its whole frames readable, and goes on after the last of them. All numbers little-endian:
//!
//! ```text
//! 8 bytes   "TOILEM\r\n"      the line break shows transfers that mend line ends
//! u32       version           1
//! u32       number size       8 for f64, 4 for f32
//! u64       particles         of the finest level of the state
//! f64       frame rate        frames a second
//! 32 bytes  SHA-256           of the file `state.toile` whose particles move
//! u32       CRC-32            of everything before it (IEEE 802.3)
//!
//! then frame after frame:
//! u64       number            0, 1, 2 ...
//! numbers   x y z             of each particle, m, world
//! u32       CRC-32            of the record before it
//! ```
//!
//! What follows the last whole frame is the rest of a frame that was being written; readers leave it alone.

mod header;
mod reader;
mod writer;

pub use header::{MotionHeader, Precision};
pub use reader::MotionReader;
pub use writer::MotionWriter;

#[cfg(test)]
mod tests;
