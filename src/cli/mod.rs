//! The command line: what a terminal asks is turned into calls of the library, what comes back into
//! files, words and exit statuses. `docs/guide.md` is its manual.

mod arguments;
mod body;
mod check;
mod collide;
mod compare;
mod compare_dynamics;
mod complaint;
mod convert;
mod demo;
mod export;
mod fit;
mod floor;
mod inputs;
mod place;
mod progress;
mod results;
mod seams;
mod simulate;
mod simulation_results;
mod stopwatch;

use arguments::{Arguments, Command};
use clap::Parser;
use std::process::ExitCode;

/// How a run ends, for whoever scripts it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    Fine,
    /// What was asked for cannot be understood.
    Usage,
    /// A file or what it describes cannot be used.
    InvalidInput,
    /// Solved, but not good enough for a simulator; results are written all the same.
    GateFailed,
    /// The evaluations were used up before the equilibrium; results are written all the same.
    BudgetSpent,
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        // 1 is our own fault, see `run`; 130 is what a shell says of an interrupt.
        ExitCode::from(match status {
            Status::Fine => 0,
            Status::Usage => 2,
            Status::InvalidInput => 3,
            Status::GateFailed => 4,
            Status::BudgetSpent => 5,
        })
    }
}

/// Why a command gave no result.
#[derive(Debug)]
pub enum Failure {
    Usage(crate::Error),
    Input(crate::Error),
}

/// Input is what most goes wrong; usage is named where it is checked.
impl From<crate::Error> for Failure {
    fn from(error: crate::Error) -> Self {
        Failure::Input(error)
    }
}

/// Runs the command line of this process.
pub fn run() -> ExitCode {
    let command = Arguments::parse().command;
    // What fails here is an assertion of ours; its message is out already.
    let Ok(outcome) = std::panic::catch_unwind(|| execute(&command)) else {
        eprintln!("This is a fault of toile itself. Please report it with the message above and the files.");
        return ExitCode::from(1);
    };
    match outcome {
        Ok(status) => status.into(),
        Err(Failure::Usage(error)) => {
            complaint::print(&error);
            Status::Usage.into()
        }
        Err(Failure::Input(error)) => {
            complaint::print(&error);
            Status::InvalidInput.into()
        }
    }
}

fn execute(command: &Command) -> Result<Status, Failure> {
    match command {
        Command::Demo(demo) => demo::run(demo),
        Command::Fit(fit) => fit::run(fit),
        Command::Compare(compare) => compare::run(compare),
        Command::Check(check) => check::run(check),
        Command::Export(export) => export::run(export),
        Command::Simulate(simulate) => simulate::run(simulate),
        Command::Body(body) => body::run(body),
        Command::Convert(convert) => convert::run(convert),
        Command::Seams(asked) => seams::run(asked),
        Command::Place(asked) => place::run(asked),
    }
}
