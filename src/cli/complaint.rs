//! Errors and warnings as a terminal shows them.

use crate::{Error, Warning};
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, Severity};
use std::fmt;
use std::io::IsTerminal;

/// An error or a warning, dressed for miette.
#[derive(Debug)]
struct Complaint<'a> {
    error: &'a Error,
    severity: Severity,
}

impl fmt::Display for Complaint<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.error.fmt(f)
    }
}

impl std::error::Error for Complaint<'_> {}

impl Diagnostic for Complaint<'_> {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.error.code().map(|code| Box::new(code) as Box<dyn fmt::Display>)
    }

    fn severity(&self) -> Option<Severity> {
        Some(self.severity)
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(self.error.remedy()))
    }
}

/// Tells on the standard error stream why nothing came of it, and what to do: of an error that carries others, all.
pub fn print(error: &Error) {
    error.clone().each().iter().for_each(|error| eprint!("{}", rendered(error, Severity::Error)));
}

pub fn print_warning(warning: &Warning) {
    eprint!("{}", rendered(&warning.0, Severity::Warning));
}

fn rendered(error: &Error, severity: Severity) -> String {
    // Whoever reads a log wants a line that can be searched; a terminal has a width.
    if !std::io::stderr().is_terminal() {
        let word = if severity == Severity::Error { "error" } else { "warning" };
        let code = error.code().map_or_else(String::new, |code| format!("[{code}]"));
        return format!("{word}{code}: {error}\n  help: {}\n", error.remedy());
    }
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::default());
    match handler.render_report(&mut text, &Complaint { error, severity }) {
        Ok(()) => text,
        Err(_) => format!("{error}\n  help: {}\n", error.remedy()),
    }
}
