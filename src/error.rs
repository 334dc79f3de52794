//! Bad input, told so that its author can mend it.

mod code;

pub use code::{Code, Severity};

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
    code: Option<Code>,
    /// Further errors of the same input.
    others: Vec<Error>,
}

impl Error {
    /// `problem` says what is wrong, `remedy` what would be right; both are whole sentences.
    pub fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { places: Vec::new(), problem: problem.into(), remedy: remedy.into(), code: None, others: Vec::new() }
    }

    /// Several errors of one input as one: the first, which carries the others; none of none.
    pub fn all(errors: impl IntoIterator<Item = Error>) -> Option<Self> {
        let mut errors = errors.into_iter().flat_map(Error::each);
        let first = errors.next()?;
        Some(Self { others: errors.collect(), ..first })
    }

    /// The error alone, then those that it carries, each alone.
    pub fn each(mut self) -> Vec<Error> {
        let others = std::mem::take(&mut self.others);
        [self].into_iter().chain(others).collect()
    }

    /// The same error, inside a further place such as `panel "sleeve"` or a file's name.
    pub fn within(mut self, place: impl fmt::Display) -> Self {
        let place = place.to_string();
        self.others.iter_mut().for_each(|other| other.places.insert(0, place.clone()));
        self.places.insert(0, place);
        self
    }

    /// The same error with a code, unless it has one already: who finds it knows best.
    pub fn coded(mut self, code: Code) -> Self {
        self.code.get_or_insert(code);
        self.others.iter_mut().for_each(|other| _ = other.code.get_or_insert(code));
        self
    }

    pub fn code(&self) -> Option<Code> {
        self.code
    }

    pub fn problem(&self) -> &str {
        &self.problem
    }

    pub fn remedy(&self) -> &str {
        &self.remedy
    }

    /// From the outermost place to the innermost.
    pub fn places(&self) -> &[String] {
        &self.places
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

impl Warning {
    /// The same warning with a code, unless it has one already.
    pub fn coded(self, code: Code) -> Self {
        Self(self.0.coded(code))
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_carries_others_along_to_its_place_and_lets_them_go() {
        let edge = |k: usize| Error::new(format!("Edge {k} is bad."), "Mend it.");
        let both = Error::all([edge(1).coded(Code::OutlineOpen), edge(2)]).unwrap().within("panel \"a\"");
        let each = both.coded(Code::PatternUnreadable).within("a.json").each();
        assert_eq!(each[1].to_string(), "a.json, panel \"a\": Edge 2 is bad.");
        assert_eq!(
            each.iter().map(|e| e.code()).collect::<Vec<_>>(),
            [Some(Code::OutlineOpen), Some(Code::PatternUnreadable)]
        );
        assert_eq!(Error::all([]), None);
    }
}
