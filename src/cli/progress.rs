//! What is told while a fit runs: a bar, lines, JSON lines or nothing; always on the standard error
//! stream.

use super::arguments::Progress;
use crate::io::length::describe;
use crate::io::report::termination_word;
use crate::prepositioning::{Event, Observer};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;
use std::io::IsTerminal;
use std::time::Duration;

/// Steps between two JSON lines of a level.
const JSON_INTERVAL: usize = 50;

/// Tells what happens.
pub struct Watcher {
    voice: Voice,
}

enum Voice {
    Bar(ProgressBar),
    Lines,
    Json { last: usize },
    Silent,
}

impl Watcher {
    pub fn new(progress: Progress) -> Self {
        let voice = match progress {
            Progress::Auto if std::io::stderr().is_terminal() => Voice::Bar(bar()),
            Progress::Auto => Voice::Lines,
            Progress::Json => Voice::Json { last: 0 },
            Progress::None => Voice::Silent,
        };
        Self { voice }
    }

    /// Clears the bar away.
    pub fn finish(&self) {
        if let Voice::Bar(bar) = &self.voice {
            bar.finish_and_clear();
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{spinner} {msg:44} {bar:30} {pos:>5}/{len}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message("arranging the panels");
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

impl Observer for Watcher {
    fn event(&mut self, event: &Event) {
        match &mut self.voice {
            Voice::Bar(bar) => show(bar, event),
            Voice::Lines => {
                if let Some(line) = line(event) {
                    eprintln!("{line}");
                }
            }
            Voice::Json { last } => {
                if let Some(value) = value(event, last) {
                    eprintln!("{value}");
                }
            }
            Voice::Silent => {}
        }
    }
}

fn show(bar: &ProgressBar, event: &Event) {
    match event {
        Event::GarmentStarted { .. } | Event::TogetherStarted { .. } => {
            if let Some(line) = line(event) {
                bar.println(line);
            }
        }
        Event::Arranged { .. } | Event::Sewn { .. } | Event::Checked { .. } => {}
        Event::Sewing { step, closing_steps, largest_gap, .. } => {
            bar.set_length(*closing_steps as u64);
            bar.set_position((*step).min(*closing_steps) as u64);
            bar.set_message(format!("closing seams, largest gap {:.1} mm", largest_gap * 1e3));
        }
        Event::LevelStarted { level, levels, resolution, particles, evaluations } => {
            bar.set_length(*evaluations as u64);
            bar.set_position(0);
            let at = describe(*resolution);
            bar.set_message(format!("level {} of {levels}: {at}, {particles} particles", level + 1));
        }
        Event::Step { point, .. } => bar.set_position(point.evaluations as u64),
        Event::LevelDone { .. } => {
            if let Some(line) = line(event) {
                bar.println(line);
            }
        }
    }
}

/// An event as a line, if it deserves one.
fn line(event: &Event) -> Option<String> {
    match event {
        Event::GarmentStarted { garment, garments, name } => {
            Some(format!("garment {} of {garments}: {name}", garment + 1))
        }
        Event::TogetherStarted { garments } => Some(format!("all {garments} garments together")),
        Event::Arranged { shifts } => {
            let farthest = shifts.iter().map(|s| s.norm()).fold(0.0, f64::max);
            Some(format!("arranged {} panels, moved by {:.0} mm at most", shifts.len(), farthest * 1e3))
        }
        Event::Sewing { step, closing_steps, largest_gap, .. } if step >= closing_steps => {
            Some(format!("closing seams: largest gap {:.2} mm", largest_gap * 1e3))
        }
        Event::LevelDone { level, summary, .. } => Some(format!(
            "level {}: {}, {} particles, {} evaluations, energy {:.4} J, residual {} weights",
            level + 1,
            describe(summary.resolution),
            summary.particles,
            summary.evaluations,
            summary.energies.total(),
            readable(summary.residual.rms),
        )),
        _ => None,
    }
}

/// A number with two decimals, where these are worth reading.
fn readable(number: f64) -> String {
    if number < 1e5 { format!("{number:.2}") } else { format!("{number:.1e}") }
}

/// An event as a JSON object, if it deserves one; `last` remembers the evaluations of the last step told.
fn value(event: &Event, last: &mut usize) -> Option<serde_json::Value> {
    match event {
        Event::GarmentStarted { garment, garments, name } => {
            Some(json!({"event": "garment_started", "garment": garment, "garments": garments, "name": name}))
        }
        Event::TogetherStarted { garments } => Some(json!({"event": "together_started", "garments": garments})),
        Event::Arranged { shifts } => {
            let shifts: Vec<[f64; 3]> = shifts.iter().map(|s| [s.x, s.y, s.z]).collect();
            Some(json!({"event": "arranged", "shifts_m": shifts}))
        }
        Event::Sewing { step, closing_steps, largest_gap, .. } => Some(json!({
            "event": "sewing", "step": step, "closing_steps": closing_steps, "largest_gap_m": largest_gap,
        })),
        Event::Sewn { evaluations, largest_gap, .. } => {
            Some(json!({"event": "sewn", "evaluations": evaluations, "largest_gap_m": largest_gap}))
        }
        Event::Checked { .. } => None,
        Event::LevelStarted { level, levels, resolution, particles, evaluations } => {
            *last = 0;
            Some(json!({
                "event": "level_started", "level": level, "levels": levels, "resolution_m": resolution,
                "particles": particles, "evaluations": evaluations,
            }))
        }
        Event::Step { level, point } => {
            if point.evaluations < *last + JSON_INTERVAL {
                return None;
            }
            *last = point.evaluations;
            Some(json!({
                "event": "step", "level": level, "evaluations": point.evaluations, "energy_j": point.energy,
                "residual_weights": point.residual,
            }))
        }
        Event::LevelDone { level, summary, .. } => Some(json!({
            "event": "level_done", "level": level, "evaluations": summary.evaluations,
            "energy_j": summary.energies.total(), "residual_weights": summary.residual.rms,
            "termination": termination_word(summary.termination),
        })),
    }
}
