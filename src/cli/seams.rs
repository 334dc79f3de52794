//! `toile seams`: seams proposed, drawn, and measured.

use super::arguments::Reading;
use super::inputs::PatternInput;
use super::{Failure, Status};
use crate::Error;
use crate::io::findings::seam_ease;
use crate::io::{atomic, dxf, read, seams_svg, seams_toml};
use crate::pattern::sewing::{SeamEase, SeamPlan, ease_of, plans_of};
use crate::pattern::suggest::suggest;
use clap::{Args, Subcommand};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

#[derive(Subcommand, Debug)]
pub enum Seams {
    /// Propose seams, each with a confidence and a reason, as a file to be edited
    Suggest(Suggest),
    /// Draw the panels with numbered edges, notches and seams
    Show(Show),
    /// Tell the two lengths of every seam, and how much longer the longer side is
    Ease(EaseReport),
}

#[derive(Args, Debug)]
pub struct Suggest {
    /// Sewing pattern; seams that it has already are not looked at
    pub pattern: PathBuf,
    /// File for the proposals, NAME.seams.toml [default: the standard output stream]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
}

#[derive(Args, Debug)]
pub struct Show {
    /// Sewing pattern
    pub pattern: PathBuf,
    /// Seams to draw instead of the pattern's own
    #[arg(long, value_name = "FILE")]
    pub seams: Option<PathBuf>,
    /// Picture to be written, an SVG file
    #[arg(long, value_name = "SVG")]
    pub out: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
}

#[derive(Args, Debug)]
pub struct EaseReport {
    /// Sewing pattern
    pub pattern: PathBuf,
    /// Seams to measure instead of the pattern's own
    #[arg(long, value_name = "FILE")]
    pub seams: Option<PathBuf>,
    /// Write JSON instead of a table
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub reading: Reading,
}

pub fn run(asked: &Seams) -> Result<Status, Failure> {
    match asked {
        Seams::Suggest(asked) => {
            let input = PatternInput::open(&asked.pattern, &asked.reading.options()?)?;
            let text = seams_toml::write_suggestions(&suggest(&input.pattern), &input.pattern);
            match &asked.out {
                Some(out) => atomic::write(out, text.as_bytes())?,
                None => print(&text)?,
            }
        }
        Seams::Show(asked) => {
            let (input, plans) = planned(&asked.pattern, asked.seams.as_deref(), &asked.reading.options()?)?;
            atomic::write(&asked.out, seams_svg::draw(&input.pattern, &plans).as_bytes())?;
        }
        Seams::Ease(asked) => {
            let (input, plans) = planned(&asked.pattern, asked.seams.as_deref(), &asked.reading.options()?)?;
            let ease = ease_of(&input.pattern, &plans);
            print(&if asked.json { json(&ease) } else { table(&ease) })?;
        }
    }
    Ok(Status::Fine)
}

/// The pattern as it is drawn, and its seams: those of the file, or its own.
fn planned(
    pattern: &Path,
    seams: Option<&Path>,
    options: &dxf::Options,
) -> Result<(PatternInput, Vec<SeamPlan>), Error> {
    let input = PatternInput::open(pattern, options)?;
    let plans = match seams {
        Some(file) => seams_toml::parse(&read::text(file)?, &input.pattern).map_err(|e| e.within(file.display()))?,
        None => plans_of(&input.pattern),
    };
    Ok((input, plans))
}

fn print(text: &str) -> Result<(), Error> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        // Whoever closed the pipe has read enough.
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::new(format!("The text cannot be written ({e})."), "Make room, or write it elsewhere."))
        }
        _ => Ok(()),
    }
}

fn table(seams: &[SeamEase]) -> String {
    let wide = seams.iter().map(|s| s.name.chars().count()).max().unwrap_or(0).max(4);
    let mut text =
        format!("{:<wide$} {:>10} {:>10} {:>10} {:>8}  longer\n", "seam", "first mm", "second mm", "ease mm", "ease %");
    for seam in seams {
        let longer = seam.longer().map_or("", |k| ["first", "second"][k]);
        let [a, b] = seam.lengths.map(|l| 1e3 * l);
        let _ = writeln!(
            text,
            "{:<wide$} {a:>10.1} {b:>10.1} {:>10.1} {:>8.1}  {longer}",
            seam.name,
            1e3 * seam.length(),
            1e2 * seam.share()
        );
    }
    text
}

fn json(seams: &[SeamEase]) -> String {
    let all = serde_json::json!({ "seams": seams.iter().map(seam_ease).collect::<Vec<_>>() });
    format!("{all:#}\n")
}
