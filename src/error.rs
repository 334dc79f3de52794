//! Bad input, told so that its author can mend it.

use std::fmt;

/// Why an input cannot be used: where it is wrong, what is wrong, and what to do.
///
/// Only bad input is an `Error`. A run that does not converge is a termination in its outcome, and
/// our own mistakes are asserts.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Error {
    /// From the outermost place to the innermost: file, panel, edge or line.
    places: Vec<String>,
    problem: String,
    remedy: String,
}

impl Error {
    /// `problem` says what is wrong, `remedy` what would be right; both are whole sentences.
    pub fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { places: Vec::new(), problem: problem.into(), remedy: remedy.into() }
    }

    /// The same error, inside a further place such as `panel "sleeve"` or a file's name.
    pub fn within(mut self, place: impl fmt::Display) -> Self {
        self.places.insert(0, place.to_string());
        self
    }

    pub fn problem(&self) -> &str {
        &self.problem
    }

    pub fn remedy(&self) -> &str {
        &self.remedy
    }

    /// The places joined, `""` when none is known.
    pub fn place(&self) -> String {
        self.places.join(", ")
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.places.is_empty() {
            write!(f, "{}: ", self.place())?;
        }
        f.write_str(&self.problem)
    }
}

/// Something doubtful that does not stop the work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning(pub Error);

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
