//! The pictures of a comparison.

use super::{Comparison, RunPart, RunTimesPart};
use crate::io::picture::{Rival, RivalChart, RivalPoint, rivals};
use crate::prepositioning::comparison::Line;

/// Energy over the lowest in which a run ended, as an SVG file.
pub fn energy(comparison: &Comparison) -> String {
    let lowest = comparison.lowest_energy_j;
    let line = comparison.finish_line.settled_energy_j.map(|settled| settled - lowest);
    chart(comparison, "Energy over the lowest that was reached, J", line, last_line, |run, times| {
        stepwise(run, times, |k| run.curve.energy_j[k] - lowest)
    })
}

/// The residual, as an SVG file.
pub fn residual(comparison: &Comparison) -> String {
    let line = comparison.finish_line.residual_weights;
    chart(comparison, "Residual, particle weights (rms)", line, last_line, |run, times| {
        stepwise(run, times, |k| run.curve.residual_weights[k])
    })
}

/// The largest strain but for a hundredth of the cloth, on the finest level, as an SVG file.
pub fn strain(comparison: &Comparison) -> String {
    let line = comparison.finish_line.strain_p99.map(|limit| 100.0 * limit);
    chart(comparison, "Strain of the finest level, 99th percentile, %", line, first_line, |run, times| {
        let point = |k: usize| RivalPoint {
            evaluations: run.strain.fine_equivalent[k],
            seconds: times.strain.cpu_seconds[k],
            y: 100.0 * run.strain.p99[k],
            coarse: false,
        };
        (0..run.strain.evaluations.len()).map(point).collect()
    })
}

/// A point for each step that was kept.
fn stepwise(run: &RunPart, times: &RunTimesPart, y: impl Fn(usize) -> f64) -> Vec<RivalPoint> {
    let point = |k: usize| RivalPoint {
        evaluations: run.curve.fine_equivalent[k],
        seconds: times.curve.cpu_seconds[k],
        y: y(k),
        coarse: run.curve.level[k] + 1 < run.levels.len(),
    };
    let mut points = Vec::new();
    for k in 0..run.curve.level.len() {
        if k > 0 && run.curve.level[k] != run.curve.level[k - 1] {
            // No line leads from one level to the next.
            points.push(RivalPoint { y: f64::NAN, ..point(k) });
        }
        points.push(point(k));
    }
    points
}

fn first_line(comparison: &Comparison) -> Line {
    comparison.lines()[0]
}

fn last_line(comparison: &Comparison) -> Line {
    comparison.lines()[comparison.lines().len() - 1]
}

fn chart(
    comparison: &Comparison,
    title: &str,
    line: Option<f64>,
    marked: impl Fn(&Comparison) -> Line,
    points: impl Fn(&RunPart, &RunTimesPart) -> Vec<RivalPoint>,
) -> String {
    let runs = || comparison.runs.iter().zip(&comparison.times.runs);
    let all: Vec<Vec<RivalPoint>> = runs().map(|(run, times)| points(run, times)).collect();
    let curves: Vec<Rival> = runs()
        .zip(&all)
        .map(|((run, _), points)| Rival {
            name: &run.name,
            points,
            finish: run.reached.at(marked(comparison)).map(|reached| reached.fine_equivalent),
        })
        .collect();
    rivals(&RivalChart { title, curves: &curves, line })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::comparison::tests::example;

    #[test]
    fn every_picture_names_the_runs() {
        for svg in [energy, residual, strain].map(|picture| picture(&example())) {
            assert!(svg.contains("multi-resolution, lbfgs") && svg.contains("single resolution, lbfgs"));
            assert!(svg.contains("</svg>"));
        }
    }
}
