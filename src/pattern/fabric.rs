//! Fabrics: figures that belong to the cloth, never to a mesh.
//!
//! Every preset says how its figures were found. Weights, thicknesses and friction are everyday
//! values of such cloth; the membrane and bending figures of the measured ones come from Wang,
//! O'Brien and Ramamoorthi, *Data-driven elastic models for cloth* (2011).

use crate::Error;

/// A figure along the warp and along the weft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directional {
    pub warp: f64,
    pub weft: f64,
}

/// What a garment is cut from. On a panel the warp runs along +y, the weft along +x.
#[derive(Clone, Debug, PartialEq)]
pub struct Fabric {
    pub name: String,
    /// kg/m².
    pub areal_density: f64,
    /// m; sets how far two layers stay apart.
    pub thickness: f64,
    /// Young's modulus times thickness, N/m: tension of a strip, per metre of its width and per
    /// unit of strain.
    pub stretch: Directional,
    /// Shear modulus times thickness, N/m.
    pub shear: f64,
    /// Narrowing across over lengthening along; 0.3 where nothing better is known.
    pub poisson_ratio: f64,
    /// Bending rigidity, N·m: moment per metre of width and per unit of curvature.
    pub bending: Directional,
    /// Coulomb friction against the body.
    pub friction: f64,
    /// Strain at which the cloth is taut or tears; more than this in a result is worth a warning.
    pub stretch_limit: f64,
}

/// Where the figures of a preset come from, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Stiffness measured on a cloth of this kind, in the named source.
    Measured,
    /// Guessed, but for the bending, which is such that the drape test (`tests/drape.rs`) finds what is
    /// published of such cloth.
    Calibrated,
    /// Guessed from published ranges of such cloth.
    Guessed,
    /// Chosen for comparisons; no real cloth.
    Convention,
}

impl Quality {
    pub fn describe(self) -> &'static str {
        match self {
            Quality::Measured => {
                "stiffness measured (Wang, O'Brien and Ramamoorthi 2011); thickness and friction are everyday values"
            }
            Quality::Calibrated => {
                "guessed from published ranges of such cloth, its bending calibrated to published drape coefficients"
            }
            Quality::Guessed => "guessed from published ranges of such cloth; not measured, not calibrated",
            Quality::Convention => "a convention for comparing solvers; no real cloth",
        }
    }
}

/// One row of the table of presets, in the units in which cloth is sold.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    pub name: &'static str,
    pub grams_per_square_metre: f64,
    /// Warp, weft and shear, N/m.
    pub membrane: [f64; 3],
    /// Warp and weft, N·m.
    pub bending: [f64; 2],
    pub thickness_mm: f64,
    pub friction: f64,
    pub stretch_limit_percent: f64,
    pub quality: Quality,
}

const fn preset(
    name: &'static str,
    grams_per_square_metre: f64,
    membrane: [f64; 3],
    bending: [f64; 2],
    [thickness_mm, friction, stretch_limit_percent]: [f64; 3],
    quality: Quality,
) -> Preset {
    Preset { name, grams_per_square_metre, membrane, bending, thickness_mm, friction, stretch_limit_percent, quality }
}

/// The fabrics that toile knows by name.
#[rustfmt::skip]
pub const PRESETS: [Preset; 12] = [
    preset("neutral",         200.0, [500.0, 500.0, 192.3],   [1.0e-5, 1.0e-5], [0.50, 0.50, 5.0],  Quality::Convention),
    preset("silk_habotai",     70.0, [60.0, 50.0, 8.0],       [2.0e-6, 1.5e-6], [0.12, 0.25, 6.0],  Quality::Guessed),
    preset("cotton_shirting", 120.0, [500.0, 250.0, 25.0],    [1.1e-5, 8.0e-6], [0.25, 0.35, 5.0],  Quality::Calibrated),
    preset("cotton_jersey",   187.0, [34.0, 17.0, 37.0],      [2.3e-5, 1.4e-5], [0.70, 0.40, 25.0], Quality::Measured),
    preset("linen",           152.0, [600.0, 400.0, 25.0],    [1.5e-5, 1.2e-5], [0.35, 0.40, 4.0],  Quality::Guessed),
    preset("wool_suiting",    250.0, [300.0, 200.0, 30.0],    [1.5e-5, 1.1e-5], [0.50, 0.40, 8.0],  Quality::Guessed),
    preset("denim_11oz",      324.0, [1014.0, 205.0, 53.0],   [6.4e-5, 9.7e-5], [0.80, 0.50, 3.0],  Quality::Measured),
    preset("ponte_roma",      284.0, [44.0, 31.0, 32.0],      [3.6e-5, 3.7e-5], [0.90, 0.40, 20.0], Quality::Measured),
    preset("fleece",          191.0, [40.0, 40.0, 25.0],      [4.0e-5, 4.0e-5], [2.00, 0.45, 12.0], Quality::Guessed),
    preset("leather_garment", 600.0, [1300.0, 1100.0, 120.0], [4.0e-5, 4.0e-5], [0.80, 0.50, 2.0],  Quality::Calibrated),
    preset("nylon_ripstop",    59.0, [700.0, 600.0, 30.0],    [8.0e-6, 7.0e-6], [0.08, 0.25, 4.0],  Quality::Guessed),
    preset("canvas",          393.0, [1500.0, 1200.0, 80.0],  [1.2e-4, 1.0e-4], [0.80, 0.55, 2.5],  Quality::Guessed),
];

/// Poisson's ratio of the presets. The sources give none that can be trusted.
const PRESET_POISSON_RATIO: f64 = 0.3;

impl Preset {
    pub fn fabric(&self) -> Fabric {
        let [warp, weft, shear] = self.membrane;
        Fabric {
            name: self.name.to_owned(),
            areal_density: self.grams_per_square_metre / 1000.0,
            thickness: self.thickness_mm / 1000.0,
            stretch: Directional { warp, weft },
            shear,
            poisson_ratio: PRESET_POISSON_RATIO,
            bending: Directional { warp: self.bending[0], weft: self.bending[1] },
            friction: self.friction,
            stretch_limit: self.stretch_limit_percent / 100.0,
        }
    }
}

/// What the panels of a level are cut from.
#[derive(Clone, Copy, Debug)]
pub enum Cut<'a> {
    /// All from one fabric.
    Of(&'a Fabric),
    /// Each from its own.
    ByPanel(&'a [&'a Fabric]),
}

impl<'a> From<&'a Fabric> for Cut<'a> {
    fn from(fabric: &'a Fabric) -> Self {
        Cut::Of(fabric)
    }
}

impl<'a> Cut<'a> {
    pub fn of_panel(&self, panel: usize) -> &'a Fabric {
        match self {
            Cut::Of(fabric) => fabric,
            Cut::ByPanel(fabrics) => fabrics[panel],
        }
    }
}

impl Default for Fabric {
    /// `neutral`, the figures with which solvers are compared.
    fn default() -> Self {
        PRESETS[0].fabric()
    }
}

impl Fabric {
    /// How fabrics that are worn together touch: as stiff as the stiffest, as thick as the thickest, and no rougher than
    /// the smoothest. There is at least one.
    pub fn touching(fabrics: &[&Fabric]) -> Fabric {
        let most = |of: fn(&Fabric) -> f64| fabrics.iter().map(|fabric| of(fabric)).fold(0.0, f64::max);
        Fabric {
            thickness: most(|f| f.thickness),
            stretch: Directional { warp: most(|f| f.stretch.warp), weft: most(|f| f.stretch.weft) },
            shear: most(|f| f.shear),
            friction: fabrics.iter().map(|fabric| fabric.friction).fold(f64::INFINITY, f64::min),
            ..fabrics[0].clone()
        }
    }

    /// Of contact with the body, N/m. It is as stiff as the membrane: stiffer would slow a minimizer down, softer would
    /// let tight cloth sink in.
    pub fn contact_stiffness(&self) -> f64 {
        self.stretch.warp.max(self.stretch.weft).max(self.shear)
    }

    /// The preset of that name.
    pub fn named(name: &str) -> Result<Self, Error> {
        PRESETS.iter().find(|p| p.name == name).map(Preset::fabric).ok_or_else(|| {
            let known: Vec<&str> = PRESETS.iter().map(|p| p.name).collect();
            Error::new(
                format!("There is no fabric named \"{name}\"."),
                format!("Take one of {}, or give the path of a fabric file in TOML.", known.join(", ")),
            )
        })
    }

    /// Are the figures those of a possible cloth?
    pub fn check(&self) -> Result<(), Error> {
        // Limits are far outside any textile: they catch wrong units, not unusual cloth.
        let ranges = [
            ("areal density", "kg/m²", self.areal_density, 0.005..=5.0),
            ("thickness", "m", self.thickness, 1e-5..=0.02),
            ("stretch stiffness along the warp", "N/m", self.stretch.warp, 0.1..=1e6),
            ("stretch stiffness along the weft", "N/m", self.stretch.weft, 0.1..=1e6),
            ("shear stiffness", "N/m", self.shear, 0.1..=1e6),
            ("Poisson's ratio", "", self.poisson_ratio, 0.0..=0.49),
            ("bending rigidity along the warp", "N·m", self.bending.warp, 1e-8..=0.1),
            ("bending rigidity along the weft", "N·m", self.bending.weft, 1e-8..=0.1),
            ("friction", "", self.friction, 0.0..=5.0),
            ("stretch limit", "", self.stretch_limit, 0.001..=5.0),
        ];
        for (what, unit, value, range) in ranges {
            if !range.contains(&value) {
                let (low, high) = range.into_inner();
                return Err(Error::new(
                    format!("The {what} of fabric \"{}\" is {value} {unit}.", self.name),
                    format!("Give a value from {low} to {high} {unit}; is it in the right unit?"),
                ));
            }
        }
        Ok(())
    }

    /// Bending rigidity for curvature across a direction that makes `angle` with the warp, N·m.
    pub fn bending_along(&self, cos_to_warp: f64) -> f64 {
        let along = cos_to_warp * cos_to_warp;
        self.bending.warp * along + self.bending.weft * (1.0 - along)
    }

    /// The plane-stress stiffness for strains `(weft, warp, shear angle)`, N/m, symmetric.
    pub fn membrane_matrix(&self) -> nalgebra::Matrix3<f64> {
        let nu = self.poisson_ratio;
        let (weft, warp) = (self.stretch.weft, self.stretch.warp);
        let scale = 1.0 / (1.0 - nu * nu);
        let coupling = nu * (weft * warp).sqrt() * scale;
        nalgebra::matrix![
            weft * scale, coupling, 0.0;
            coupling, warp * scale, 0.0;
            0.0, 0.0, self.shear
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_possible_cloth() {
        for preset in PRESETS {
            preset.fabric().check().unwrap();
        }
    }

    #[test]
    fn bending_lengths_are_those_of_cloth() {
        // (B / weight)^(1/3), between 1 and 4.2 cm for all that is worn.
        for preset in PRESETS {
            let fabric = preset.fabric();
            let mean = (fabric.bending.warp * fabric.bending.weft).sqrt();
            let length = (mean / (fabric.areal_density * 9.81)).cbrt();
            assert!((0.010..0.042).contains(&length), "{}: {length}", preset.name);
        }
    }

    #[test]
    fn neutral_is_isotropic() {
        let c = Fabric::default().membrane_matrix();
        assert!((c[(0, 0)] - c[(0, 1)] - 2.0 * c[(2, 2)]).abs() < 0.05);
    }

    #[test]
    fn an_unknown_name_lists_the_known_ones() {
        let error = Fabric::named("velvet").unwrap_err();
        assert!(error.remedy().contains("cotton_shirting"));
    }
}
