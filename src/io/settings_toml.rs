//! Settings in TOML: those that differ from the ones at hand, lengths with their units.

use super::length;
use super::toml_keys::{Keys, quoted, remedy_for_key};
use crate::Error;
use crate::energy::{Bending, Membrane};
use crate::minimize::Method;
use crate::prepositioning::{FinishLine, Settings};

const KEYS: [&str; 10] = [
    "levels",
    "clearance",
    "membrane",
    "bending",
    "minimizer",
    "until",
    "equilibrium_residual",
    "coarse_evaluations",
    "finest_evaluations",
    "equilibrium_evaluations",
];

/// Choices by the words that stand for them.
const FINISH_LINES: [(&str, FinishLine); 2] =
    [("handoff", FinishLine::HandOff), ("equilibrium", FinishLine::Equilibrium)];
const MEMBRANES: [(&str, Membrane); 2] = [("coupled", Membrane::Coupled), ("springs", Membrane::Springs)];
const BENDINGS: [(&str, Bending); 2] = [("quadratic", Bending::Quadratic), ("springs", Bending::Springs)];
const MINIMIZERS: [(&str, Method); 5] = [
    ("newton", Method::Newton),
    ("conjugate-gradient", Method::ConjugateGradient),
    ("lbfgs", Method::Lbfgs),
    ("dynamic-relaxation", Method::DynamicRelaxation),
    ("argmin-lbfgs", Method::ArgminLbfgs),
];

/// More evaluations than anybody waits for; a budget beyond is a slip.
const MOST_EVALUATIONS: usize = 1_000_000_000;

/// Takes over what `text` says. On an error `settings` are as they were.
pub fn apply(text: &str, settings: &mut Settings) -> Result<(), Error> {
    let keys = Keys::parse(text.trim_start_matches('\u{feff}'), &KEYS)?;
    let mut new = settings.clone();
    if let Some(levels) = keys.text("levels")? {
        new.resolutions = length::parse_list(levels).map_err(|e| e.within(keys.place("levels")))?;
    }
    if let Some(clearance) = keys.text("clearance")? {
        new.clearance = length::parse_or_zero(clearance).map_err(|e| e.within(keys.place("clearance")))?;
    }
    choose(&keys, "membrane", &MEMBRANES, &mut new.model.membrane)?;
    choose(&keys, "bending", &BENDINGS, &mut new.model.bending)?;
    choose(&keys, "minimizer", &MINIMIZERS, &mut new.minimizer)?;
    choose(&keys, "until", &FINISH_LINES, &mut new.until)?;
    if let Some(residual) = keys.number("equilibrium_residual")? {
        new.equilibrium_residual = residual;
    }
    for (key, budget) in [
        ("coarse_evaluations", &mut new.coarse_evaluations),
        ("finest_evaluations", &mut new.finest_evaluations),
        ("equilibrium_evaluations", &mut new.equilibrium_evaluations),
    ] {
        if let Some(count) = keys.count(key, MOST_EVALUATIONS)? {
            *budget = count;
        }
    }
    new.check()?;
    *settings = new;
    Ok(())
}

/// The text of a file with all settings. [`apply`] makes the same settings of it.
pub fn write(settings: &Settings) -> String {
    let Settings {
        resolutions,
        clearance,
        model,
        minimizer,
        until,
        equilibrium_residual,
        coarse_evaluations,
        finest_evaluations,
        equilibrium_evaluations,
    } = settings;
    let levels: Vec<String> = resolutions.iter().map(|r| format!("{r} m")).collect();
    format!(
        "# Settings of toile; docs/formats.md explains them.\n\
         levels = {}\n\
         clearance = \"{clearance} m\"\n\
         membrane = \"{}\"\n\
         bending = \"{}\"\n\
         minimizer = \"{}\"\n\
         until = \"{}\"\n\
         equilibrium_residual = {equilibrium_residual:?}\n\
         coarse_evaluations = {coarse_evaluations}\n\
         finest_evaluations = {finest_evaluations}\n\
         equilibrium_evaluations = {equilibrium_evaluations}\n",
        quoted(&levels.join(", ")),
        membrane_word(model.membrane),
        bending_word(model.bending),
        minimizer_word(*minimizer),
        finish_line_word(*until),
    )
}

/// The word for a finish line, as on the command line.
pub fn finish_line_word(until: FinishLine) -> &'static str {
    word(&FINISH_LINES, until)
}

/// The finish line that a word stands for.
pub fn finish_line(text: &str) -> Result<FinishLine, Error> {
    choice(text, &FINISH_LINES)
}

pub fn membrane_word(membrane: Membrane) -> &'static str {
    word(&MEMBRANES, membrane)
}

pub fn bending_word(bending: Bending) -> &'static str {
    word(&BENDINGS, bending)
}

/// The word for a minimizer, as on the command line.
pub fn minimizer_word(minimizer: Method) -> &'static str {
    word(&MINIMIZERS, minimizer)
}

/// The minimizer that a word stands for.
pub fn minimizer(text: &str) -> Result<Method, Error> {
    choice(text, &MINIMIZERS)
}

fn word<T: Copy + PartialEq>(words: &[(&'static str, T)], choice: T) -> &'static str {
    words.iter().find(|(_, c)| *c == choice).expect("every choice has a word").0
}

fn choice<T: Copy>(text: &str, words: &[(&'static str, T)]) -> Result<T, Error> {
    let known: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
    let found = words.iter().find(|(word, _)| *word == text).map(|(_, choice)| *choice);
    found.ok_or_else(|| Error::new(format!("The choice \"{text}\" is not known."), remedy_for_key(text, &known)))
}

fn choose<T: Copy>(keys: &Keys, key: &str, words: &[(&'static str, T)], to: &mut T) -> Result<(), Error> {
    if let Some(text) = keys.text(key)? {
        *to = choice(text, words).map_err(|e| e.within(format!("`{key}`")).within(keys.place(key)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn only_what_is_named_changes() {
        let mut settings = Settings::default();
        let text = "clearance = \"2 mm\"\nuntil = \"equilibrium\"\nlevels = \"40,20 mm\"\ncoarse_evaluations = 7";
        apply(text, &mut settings).unwrap();
        let expected = Settings {
            clearance: 0.002,
            until: FinishLine::Equilibrium,
            resolutions: vec![0.04, 0.02],
            coarse_evaluations: 7,
            ..Settings::default()
        };
        assert_eq!(format!("{settings:?}"), format!("{expected:?}"));
    }

    #[test]
    fn slips_are_told_with_their_line_and_change_nothing() {
        let before = Settings::default();
        for (text, place, hint) in [
            ("\nclearence = \"2 mm\"", "line 2", "clearance"),
            ("clearance = 2", "line 1", "quotes"),
            ("clearance = \"2\"", "line 1", "2 mm"),
            ("until = \"equilibrum\"", "line 1, `until`", "equilibrium"),
            ("membrane = \"fem\"", "line 1, `membrane`", "coupled, springs"),
            ("minimizer = \"lbgfs\"", "line 1, `minimizer`", "lbfgs"),
            ("coarse_evaluations = 0", "line 1", "from 1"),
            ("coarse_evaluations = 1.5", "line 1", "from 1"),
            ("clearance = \"2 m\"", "", "50 mm"),
        ] {
            let mut settings = before.clone();
            let error = apply(text, &mut settings).unwrap_err();
            assert_eq!(error.place(), place, "{text}");
            assert!(error.remedy().contains(hint), "{text}: {}", error.remedy());
            assert_eq!(format!("{settings:?}"), format!("{before:?}"));
        }
    }

    #[test]
    fn the_example_of_the_documentation_reads() {
        let example =
            include_str!("../../docs/formats.md").split("```").filter_map(|b| b.strip_prefix("toml\n")).nth(1).unwrap();
        apply(example, &mut Settings::default()).unwrap();
    }

    proptest! {
        #[test]
        fn all_settings_read_back_the_same(
            resolutions in proptest::collection::vec(1e-4..0.1f64, 1..6),
            clearance in 0.0..0.05f64,
            residual in 1e-9..1e3f64,
            (springs, cross, equilibrium) in any::<(bool, bool, bool)>(),
            minimizer in proptest::sample::select(&Method::ALL[..]),
            budgets in [1..MOST_EVALUATIONS, 1..MOST_EVALUATIONS, 1..MOST_EVALUATIONS],
        ) {
            let mut settings = Settings {
                resolutions,
                clearance: if clearance < 1e-9 { 0.0 } else { clearance },
                until: if equilibrium { FinishLine::Equilibrium } else { FinishLine::HandOff },
                equilibrium_residual: residual,
                minimizer,
                coarse_evaluations: budgets[0],
                finest_evaluations: budgets[1],
                equilibrium_evaluations: budgets[2],
                ..Settings::default()
            };
            settings.model.membrane = if springs { Membrane::Springs } else { Membrane::Coupled };
            settings.model.bending = if cross { Bending::Springs } else { Bending::Quadratic };
            let mut read = Settings::default();
            apply(&write(&settings), &mut read).unwrap();
            prop_assert_eq!(format!("{read:?}"), format!("{settings:?}"));
        }

        #[test]
        fn any_text_is_read_or_refused(text in "\\PC{0,60}") {
            let _ = apply(&text, &mut Settings::default());
        }
    }
}
