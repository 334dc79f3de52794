//! The words of the format, as serde reads and writes them.

use crate::io::length::Unit;
use crate::pattern::{BodyPart, NotchKind, SegmentLabel, Sense};
use serde::{Deserialize, Serialize};

pub type Point = [f64; 2];

/// A pattern of toile.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct File {
    /// Always "toile pattern".
    pub format: String,
    /// Always 1.
    pub version: u32,
    /// What the garment is called; else the name of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Of all lengths in the file; metres if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    pub panels: Vec<FilePanel>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub seams: Vec<FileSeam>,
}

/// One flat piece of fabric.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FilePanel {
    /// Unique, one line of text.
    pub name: String,
    /// The zone of the body that it dresses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<FilePart>,
    /// The fabric that it is cut from, where that is not the garment's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fabric: Option<String>,
    /// From one end of the line to the other: the direction of the warp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grainline: Option<[Point; 2]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drill_holes: Vec<Point>,
    /// Drawn, not cut.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub internal_lines: Vec<Vec<Point>>,
    /// Where it starts around the body; left out while it lies in the plane as drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placement: Option<FilePlacement>,
    /// One closed loop, counter-clockwise when the right side of the fabric faces the panel's own +z.
    pub outline: Vec<FileSegment>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notches: Vec<FileNotch>,
}

/// `world = rotation * (x, y, 0) + translation`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FilePlacement {
    pub translation: [f64; 3],
    /// Three rows of a rotation matrix. Instead of it `angles_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[[f64; 3]; 3]>,
    /// Turns about the fixed axes x, then y, then z, in degrees. Instead of it `rotation`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angles_deg: Option<[f64; 3]>,
    /// The panel is bent around a cylinder before it is turned and moved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bend: Option<FileBend>,
    /// How far above the place where it is worn the panel starts.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub raised: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde hands on references.
pub fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// A cylinder that touches the flat panel along a line.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FileBend {
    /// A point of that line.
    pub origin: Point,
    /// Its direction, of length one.
    pub along: Point,
    /// Positive where the axis is behind the panel, on its -z side; not zero.
    pub radius: f64,
}

/// One curve of an outline, between two corners: straight, or with one of `quadratic`, `cubic`, `arc` and `path`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FileSegment {
    /// The corner where it starts.
    pub from: Point,
    /// Where it ends, if that is not exactly where the next one starts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<Point>,
    /// What it is on the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<FileLabel>,
    /// The control point of a quadratic Bézier curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quadratic: Option<Point>,
    /// The control points of a cubic Bézier curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cubic: Option<[Point; 2]>,
    /// Of several cubic Bézier curves one after the other: control, control, end, control, control, end, ...,
    /// control, control.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<Vec<Point>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arc: Option<FileArc>,
}

/// A circular arc.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FileArc {
    pub center: Point,
    pub radius: f64,
    /// Angle from the start to the end, radians, counter-clockwise positive.
    pub sweep: f64,
}

/// An alignment mark on the outline.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FileNotch {
    /// Number of its segment in the outline, from 0.
    pub segment: usize,
    /// Of the segment's arc length, from 0 at its start to 1 at its end.
    pub fraction: f64,
    #[serde(default = "single", skip_serializing_if = "FileNotchKind::is_single")]
    pub kind: FileNotchKind,
}

/// Two segments sewn together over their whole lengths.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FileSeam {
    /// For messages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// How much longer the second side is meant to be than the first: 0.02 is 2 %. A check, not an order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ease: Option<f64>,
    #[serde(default = "opposed", skip_serializing_if = "FileSense::is_opposed")]
    pub sense: FileSense,
    pub sides: [FileSide; 2],
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FileSide {
    pub panel: String,
    /// Number in the outline, from 0.
    pub segment: usize,
}

/// Words of the file for words of ours, one for one.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident = $ours:ident { $($(#[$about:meta])* $word:ident),+ }) => {
        $(#[$doc])*
        #[derive(Serialize, Deserialize, Clone, Copy)]
        #[serde(rename_all = "snake_case")]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        pub enum $name { $($(#[$about])* $word),+ }
        impl From<$ours> for $name {
            fn from(ours: $ours) -> Self {
                match ours { $($ours::$word => Self::$word),+ }
            }
        }
        impl From<$name> for $ours {
            fn from(word: $name) -> Self {
                match word { $($name::$word => Self::$word),+ }
            }
        }
    };
}

words!(FilePart = BodyPart { Body, Arm, Leg });
words!(FileLabel = SegmentLabel { LowerInterface, Collar, Armhole, StraplessTop });
words!(FileNotchKind = NotchKind { Single, Double });
words!(
    /// Which ends of the two sides meet.
    FileSense = Sense {
        /// Start meets end: right side to right side.
        Opposed,
        /// Start meets start: right side to wrong side.
        Aligned
    }
);

impl FileNotchKind {
    pub fn is_single(&self) -> bool {
        matches!(self, Self::Single)
    }
}

pub fn single() -> FileNotchKind {
    FileNotchKind::Single
}

impl FileSense {
    pub fn is_opposed(&self) -> bool {
        matches!(self, Self::Opposed)
    }
}

pub fn opposed() -> FileSense {
    FileSense::Opposed
}
