//! What can be exported to.

use crate::Error;
use crate::io::toml_keys::remedy_for_key;

/// A program or a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Mesh, point cache and a script for Blender.
    Blender,
    Usd,
    /// Arrays and a script for NVIDIA's simulator.
    Newton,
    /// Arrays and a script for ContourCraft and HOOD.
    Contourcraft,
    Npz,
    Ply,
    Pc2,
    Mdd,
    Glb,
    /// A GLB file on the skeleton of a body.
    GlbSkinned,
    Obj,
}

impl Target {
    pub const ALL: [Target; 11] = [
        Target::Blender,
        Target::Usd,
        Target::Newton,
        Target::Contourcraft,
        Target::Npz,
        Target::Ply,
        Target::Pc2,
        Target::Mdd,
        Target::Glb,
        Target::GlbSkinned,
        Target::Obj,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Target::Blender => "blender",
            Target::Usd => "usd",
            Target::Newton => "newton",
            Target::Contourcraft => "contourcraft",
            Target::Npz => "npz",
            Target::Ply => "ply",
            Target::Pc2 => "pc2",
            Target::Mdd => "mdd",
            Target::Glb => "glb",
            Target::GlbSkinned => "glb-skinned",
            Target::Obj => "obj",
        }
    }

    /// The target of that name.
    pub fn named(name: &str) -> Result<Self, Error> {
        let names = Self::ALL.map(Self::name);
        Self::ALL.into_iter().find(|target| target.name() == name).ok_or_else(|| {
            let shown: String = name.chars().take(60).collect();
            Error::new(format!("There is no target named \"{shown}\"."), remedy_for_key(&name.to_lowercase(), &names))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_target_is_found_by_its_name_and_others_name_the_nearest() {
        assert!(Target::ALL.into_iter().all(|target| Target::named(target.name()) == Ok(target)));
        assert_eq!(Target::named("blendr").unwrap_err().remedy(), "Did you mean `blender`?");
        assert_eq!(Target::named("USD").unwrap_err().remedy(), "Did you mean `usd`?");
        assert!(Target::named("maya").unwrap_err().remedy().starts_with("Known are blender, usd"));
    }
}
