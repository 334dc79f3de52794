//! The codes of all that can be wrong or doubtful with an input: stable, so that scripts can rely on them.
//!
//! A number is given once and never again. The letter tells the room of the input: pattern, seams, arrangement, fabric,
//! body. `docs/checks` has a page for each.

use std::fmt;

/// Does a finding stop the work?
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The input cannot be used.
    Error,
    /// Something doubtful that does not stop the work.
    Warning,
}

impl Severity {
    pub fn name(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
        }
    }
}

macro_rules! codes {
    ($($name:ident = $id:literal, $severity:ident, $title:literal;)*) => {
        /// What is wrong or doubtful, in the order of the registry.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code {
            $(#[doc = $title] $name,)*
        }

        impl Code {
            /// All of them, in order.
            pub const ALL: &[Code] = &[$(Code::$name,)*];

            /// `TOILE-P012`.
            pub fn id(self) -> &'static str {
                match self { $(Code::$name => concat!("TOILE-", $id),)* }
            }

            /// What `toile check` makes of it. `toile fit` stops at panels without a place or without seams as well, of which
            /// `check` merely says that they are still to come.
            pub fn severity(self) -> Severity {
                match self { $(Code::$name => Severity::$severity,)* }
            }

            /// What it is about, in a few words.
            pub fn title(self) -> &'static str {
                match self { $(Code::$name => $title,)* }
            }
        }
    };
}

codes! {
    PatternUnreadable = "P001", Error, "The pattern cannot be read";
    LeftAside = "P002", Warning, "Something in the pattern file is left aside or assumed";
    UnitDoubtful = "P003", Warning, "The unit of the pattern is doubtful";
    TooFar = "P004", Error, "A panel is too large or too far away";
    NameUnusable = "P005", Error, "A panel has no usable name";
    NameTwice = "P006", Error, "Two panels have the same name";
    OutlineOpen = "P007", Error, "An outline is open";
    OutlineCrosses = "P008", Error, "An outline crosses itself";
    EdgeWithoutLength = "P009", Error, "An edge has no length";
    PanelWithoutArea = "P010", Error, "A panel encloses no area";
    NumberUnusable = "P011", Error, "A number is not finite";
    EdgeShort = "P012", Warning, "An edge is shorter than the resolution";
    PanelTooNarrow = "P013", Error, "A panel is too narrow for the resolution";
    TooManyParticles = "P014", Error, "The resolution asks for too many particles";
    NoPanels = "P015", Error, "The pattern has no panels";

    SeamUnusable = "S001", Error, "A seam cannot be used";
    SeamUnknownEdge = "S002", Error, "A seam names what does not exist";
    EdgeSewnTwice = "S003", Error, "An edge is sewn twice";
    SeamWithoutPartner = "S004", Error, "A seam has not two sides";
    NoSeams = "S005", Warning, "The pattern has no seams";
    PieceApart = "S006", Warning, "Panels are not sewn to the rest";
    MirrorUnsewn = "S007", Warning, "An edge is free whose mirror image is sewn";
    SeamTwisted = "S008", Warning, "A seam looks twisted";
    DirectionContradicted = "S009", Warning, "A stated direction contradicts the other seams";
    SeamsCross = "S010", Warning, "Seams cross";
    OneSided = "S011", Warning, "The right side is sewn to the wrong side all around";
    SeamUnequal = "S012", Warning, "The sides of a seam differ in length";
    EaseNotAsStated = "S013", Warning, "The ease of a seam is not the one stated";
    SeamNote = "S014", Warning, "Sewing differs from what is drawn";
    SewnShut = "S015", Error, "Seams leave no opening";

    Unplaced = "A001", Warning, "A panel has no place around the body";
    PlacedElsewhere = "A002", Error, "The pattern is placed elsewhere than the body";
    StartsInside = "A003", Warning, "A panel starts inside the body";
    MovedFar = "A004", Warning, "A panel will be moved far before it is sewn";
    PlacingDoubtful = "A005", Warning, "The placement that was found is doubtful";
    PlacingFailed = "A006", Error, "The panels cannot be placed";
    SmallerThanBody = "A007", Warning, "The garment is smaller than the body";
    NothingHolds = "A008", Warning, "Nothing would hold the garment up";

    FabricUnusable = "F001", Error, "The fabric cannot be used";
    OtherFabric = "F002", Warning, "A panel asks for another fabric";
    ThickerThanClearance = "F003", Warning, "The fabric is too thick for the clearance or the resolution";

    BodyUnreadable = "B001", Error, "The body cannot be read";
    BodyWrongSize = "B002", Error, "The body has the size of no body";
    BodyNotManifold = "B003", Error, "The body's triangles do not fit together";
    BodyOpen = "B004", Error, "The body is not closed";
    BodyWithoutVolume = "B005", Error, "The body encloses no volume";
    BodyInsideOut = "B006", Error, "The body is inside out";
    BodyNotUpright = "B007", Error, "The body does not stand upright";
    BodyOffFloor = "B008", Warning, "The body does not stand on the floor";
    BodyMisplaced = "B009", Warning, "The body stands elsewhere, or faces another way";
    ArmNearTorso = "B010", Warning, "Arm and torso are too near for cloth between them";
    LandmarksUnknown = "B011", Warning, "The body's landmarks were not found";
    WornElsewhere = "B012", Warning, "What the body wears was fitted on another body";
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_unique_and_numbered_from_one_in_each_room() {
        let mut last = ('?', 0);
        for code in Code::ALL {
            let id = code.id().strip_prefix("TOILE-").unwrap();
            let (room, number) = (id.chars().next().unwrap(), id[1..].parse::<u32>().unwrap());
            assert_eq!(number, if room == last.0 { last.1 + 1 } else { 1 }, "{id}");
            assert!("PSAFB".contains(room) && id.len() == 4, "{id}");
            last = (room, number);
        }
    }
}
