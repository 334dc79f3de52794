//! Fabrics in TOML: the user's own cloth, with the unit of each figure in its name.

use super::toml_keys::{Keys, quoted};
use crate::Error;
use crate::pattern::Fabric;

/// One figure of a fabric: its key, what it is, and where it lives.
struct Figure {
    key: &'static str,
    comment: &'static str,
    place: fn(&mut Fabric) -> &mut f64,
}

const FIGURES: [Figure; 10] = [
    Figure { key: "areal_density_kg_per_m2", comment: "weight: 200 g/m² are 0.2", place: |f| &mut f.areal_density },
    Figure { key: "thickness_m", comment: "0.5 mm are 0.0005", place: |f| &mut f.thickness },
    Figure {
        key: "stretch_warp_n_per_m",
        comment: "tension of a strip per metre of width and unit of strain, along the warp (y of a panel)",
        place: |f| &mut f.stretch.warp,
    },
    Figure {
        key: "stretch_weft_n_per_m",
        comment: "the same along the weft (x of a panel)",
        place: |f| &mut f.stretch.weft,
    },
    Figure { key: "shear_n_per_m", comment: "shear modulus times thickness", place: |f| &mut f.shear },
    Figure {
        key: "poisson_ratio",
        comment: "narrowing across over lengthening along; 0.3 where nothing better is known",
        place: |f| &mut f.poisson_ratio,
    },
    Figure {
        key: "bending_warp_n_m",
        comment: "bending rigidity: moment per metre of width and unit of curvature, along the warp",
        place: |f| &mut f.bending.warp,
    },
    Figure { key: "bending_weft_n_m", comment: "the same along the weft", place: |f| &mut f.bending.weft },
    Figure { key: "friction", comment: "Coulomb friction against the body", place: |f| &mut f.friction },
    Figure {
        key: "stretch_limit",
        comment: "strain at which the cloth is taut: 5 % are 0.05",
        place: |f| &mut f.stretch_limit,
    },
];

/// Keys that are not figures.
const NAME: &str = "name";
const BASED_ON: &str = "based_on";
const SOURCE: &str = "source";

/// Reads a fabric; `name` is what it is called where the text gives no `name`.
///
/// Figures that are missing come from the preset `based_on`; without one, all must be there.
pub fn parse(text: &str, name: &str) -> Result<Fabric, Error> {
    let known: Vec<&str> = [NAME, BASED_ON, SOURCE].into_iter().chain(FIGURES.iter().map(|f| f.key)).collect();
    let keys = Keys::parse(text.trim_start_matches('\u{feff}'), &known)?;
    // Free text for the reader of the file: where the figures come from.
    keys.text(SOURCE)?;
    let base = match keys.text(BASED_ON)? {
        Some(preset) => Some(Fabric::named(preset).map_err(|e| e.within(keys.place(BASED_ON)))?),
        None => None,
    };
    let mut missing = Vec::new();
    let mut fabric = base.clone().unwrap_or_default();
    fabric.name = keys.text(NAME)?.unwrap_or(name).to_owned();
    for figure in &FIGURES {
        match keys.number(figure.key)? {
            Some(number) => *(figure.place)(&mut fabric) = number,
            None if base.is_none() => missing.push(figure.key),
            None => {}
        }
    }
    if !missing.is_empty() {
        return Err(Error::new(
            format!("The fabric \"{}\" has no {}.", fabric.name, missing.join(", ")),
            "Add what is missing, or start from a preset with a line such as `based_on = \"cotton_shirting\"`.",
        ));
    }
    fabric.check()?;
    Ok(fabric)
}

/// The text of a fabric file with a comment for each figure. [`parse`] returns the same fabric.
pub fn write(fabric: &Fabric) -> String {
    let mut text = format!(
        "# A fabric for toile, figures in SI units; docs/formats.md explains them.\n\
         # With `{BASED_ON} = \"cotton_shirting\"` figures that equal the preset's may be left out,\n\
         # and `{SOURCE} = \"...\"` tells where they come from.\n\
         {NAME} = {}\n",
        quoted(&fabric.name)
    );
    let mut fabric = fabric.clone();
    for figure in &FIGURES {
        // `{:?}` has an exponent or a point, which makes it a float in TOML.
        text += &format!("\n# {}\n{} = {:?}\n", figure.comment, figure.key, (figure.place)(&mut fabric));
    }
    text
}

/// The figures of a fabric by their keys, for reports.
pub fn figures(fabric: &Fabric) -> Vec<(&'static str, f64)> {
    let mut fabric = fabric.clone();
    FIGURES.iter().map(|figure| (figure.key, *(figure.place)(&mut fabric))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::PRESETS;
    use proptest::prelude::*;

    #[test]
    fn every_preset_reads_back_the_same() {
        for preset in PRESETS {
            let fabric = preset.fabric();
            assert_eq!(parse(&write(&fabric), "other"), Ok(fabric));
        }
    }

    #[test]
    fn a_fabric_may_start_from_a_preset() {
        let fabric = parse("based_on = \"linen\"\nfriction = 1\nsource = \"KES, own\"", "mine").unwrap();
        assert_eq!(fabric, Fabric { name: "mine".into(), friction: 1.0, ..Fabric::named("linen").unwrap() });
        let error = parse("\nbased_on = \"velvet\"", "mine").unwrap_err();
        assert_eq!(error.place(), "line 2");
        assert!(error.remedy().contains("linen"));
    }

    #[test]
    fn missing_keys_are_named() {
        let all = write(&Fabric::default());
        let text: String = all
            .lines()
            .filter(|l| !l.starts_with("friction") && !l.starts_with("shear"))
            .fold(String::new(), |text, line| text + line + "\n");
        let error = parse(&text, "mine").unwrap_err();
        assert_eq!(error.problem(), "The fabric \"neutral\" has no shear_n_per_m, friction.");
    }

    #[test]
    fn wrong_keys_and_impossible_figures_are_refused() {
        let error = parse("based_on = \"linen\"\nthickness_mm = 0.3", "mine").unwrap_err();
        assert_eq!(error.remedy(), "Did you mean `thickness_m`?");
        let error = parse("based_on = \"linen\"\nareal_density_kg_per_m2 = 152", "mine").unwrap_err();
        assert!(error.problem().contains("areal density"));
        assert!(parse("based_on = \"linen\"\nfriction = \"high\"", "mine").is_err());
        assert!(parse("[linen]\nfriction = 1", "mine").is_err());
    }

    #[test]
    fn the_example_of_the_documentation_reads() {
        let example =
            include_str!("../../docs/formats.md").split("```").filter_map(|b| b.strip_prefix("toml\n")).next().unwrap();
        parse(example, "mine").unwrap();
    }

    proptest! {
        #[test]
        fn any_name_and_figure_reads_back_the_same(name in "\\PC*", figure in 0.1..1e6f64, thin in 1e-8..0.1f64) {
            let mut fabric = Fabric { name, shear: figure, ..Fabric::default() };
            fabric.bending.warp = thin;
            prop_assert_eq!(parse(&write(&fabric), ""), Ok(fabric));
        }

        #[test]
        fn any_text_is_read_or_refused(text in "\\PC{0,60}") {
            let _ = parse(&text, "any");
        }
    }
}
