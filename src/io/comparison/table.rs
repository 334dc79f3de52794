//! The table of a comparison, in Markdown that is a table on a terminal too.

use super::{Comparison, RunPart, RunTimesPart};
use crate::io::length::describe;
use std::fmt::Write as _;

const HEAD: [&str; 13] = [
    "method",
    "levels",
    "evaluations: seams + levels",
    "curvatures",
    "fine-equivalent",
    "ratio",
    "CPU s",
    "ratio",
    "gap mJ",
    "gap mm",
    "residual",
    "strain p99 / max %",
    "finish line",
];

/// The runs of a comparison, a row each. Ratios are to the first run.
pub fn table(comparison: &Comparison) -> String {
    let mut rows = vec![HEAD.map(str::to_owned)];
    // What the first has not reached is no measure for others.
    let first = comparison.runs.first().filter(|run| run.reached.is_some()).zip(comparison.times.runs.first());
    let first = first.map(|(run, times)| cost(run, times));
    for (run, times) in comparison.runs.iter().zip(&comparison.times.runs) {
        rows.push(row(run, times, first));
    }
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: [usize; HEAD.len()] = std::array::from_fn(width);
    let mut text = String::new();
    for (number, row) in rows.iter().enumerate() {
        let cells: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        let _ = writeln!(text, "| {} |", cells.join(" | "));
        if number == 0 {
            let rules: Vec<String> = widths.iter().map(|&width| "-".repeat(width)).collect();
            let _ = writeln!(text, "|-{}-|", rules.join("-|-"));
        }
    }
    text
}

/// What was compared, where, and how the table is to be read.
pub fn heading(comparison: &Comparison) -> String {
    let Comparison { inputs, finish_line, times, .. } = comparison;
    let percent = |share: Option<f64>| format!("{} %", 100.0 * share.unwrap_or(f64::NAN));
    let line = match finish_line.residual_weights {
        Some(residual) => format!("equilibrium, rms residual {residual} weights"),
        None => format!(
            "hand-off, strain p99 at most {}, mean at most {}",
            percent(finish_line.strain_p99),
            percent(finish_line.strain_mean)
        ),
    };
    let start = comparison.perturbation.as_ref().map_or_else(String::new, |p| {
        format!("\nThe start was disturbed by up to {}, seed {}.", describe(p.amplitude_m), p.seed)
    });
    let host = &times.host;
    format!(
        "# {} on {}, {}\n\nFinish line: {line}. At most {} evaluations on the finest level.{start}\n\n\
         toile {}, {}, {}, {} threads. Ratios are to the first row. An evaluation of a level counts as particles of the level\n\
         over particles of the finest; those for closing the seams are counted, curvatures are not. The gap is that of the final\n\
         energy to the lowest of all runs, also as a mean height of the garment, which weighs {:.3} N.\n",
        inputs.pattern.name,
        inputs.body.name,
        inputs.fabric,
        comparison.cap,
        comparison.toile_version,
        host.cpu.as_deref().unwrap_or("unknown processor"),
        host.system,
        host.threads,
        comparison.weight_n,
    )
}

/// What a run cost until its finish line, or in all if it did not get there: evaluations and seconds.
fn cost(run: &RunPart, times: &RunTimesPart) -> [f64; 2] {
    [
        run.reached.as_ref().map_or(run.fine_equivalent, |reached| reached.fine_equivalent),
        times.reached.as_ref().unwrap_or(&times.total).cpu_seconds,
    ]
}

fn row(run: &RunPart, times: &RunTimesPart, first: Option<[f64; 2]>) -> [String; HEAD.len()] {
    let [evaluations, seconds] = cost(run, times);
    let beyond = if run.reached.is_some() { "" } else { "> " };
    let ratio =
        |ours: f64, k: usize| first.map_or_else(|| "–".to_owned(), |first| format!("{beyond}{:.2}", ours / first[k]));
    let levels: Vec<String> = run.levels.iter().map(|level| describe(level.resolution_m)).collect();
    let counts: Vec<String> = run.levels.iter().map(|level| level.evaluations.to_string()).collect();
    let curvatures = run.sewing.curvatures + run.levels.iter().map(|level| level.curvatures).sum::<usize>();
    [
        run.name.clone(),
        levels.join(", "),
        format!("{} + {}", run.sewing.evaluations, counts.join(", ")),
        curvatures.to_string(),
        format!("{beyond}{evaluations:.0}"),
        ratio(evaluations, 0),
        format!("{beyond}{seconds:.2}"),
        ratio(seconds, 1),
        format!("{:.2}", run.end.energy_gap_j * 1e3),
        format!("{:.2}", run.end.energy_gap_height_m * 1e3),
        format!("{:.3}", run.end.residual_weights),
        format!("{:.2} / {:.1}", run.end.strain_p99 * 100.0, run.end.strain_max * 100.0),
        verdict(run),
    ]
}

fn verdict(run: &RunPart) -> String {
    let failed = run.end.failed_checks.join(", ").replace('_', " ");
    match (&run.reached, failed.as_str()) {
        (Some(_), "") => "reached".to_owned(),
        (Some(_), failed) => format!("reached, but fails {failed}"),
        (None, "") => "not reached".to_owned(),
        (None, failed) => format!("not reached; fails {failed}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::comparison::tests::example;

    #[test]
    fn the_table_has_a_row_for_each_run_and_ratios_to_the_first() {
        let text = table(&example());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4);
        assert!(lines.iter().all(|line| line.chars().count() == lines[0].chars().count()), "{text}");
        let cells = |line: &str| line.split('|').map(|c| c.trim().to_owned()).collect::<Vec<_>>();
        let (schedule, rival) = (cells(lines[2]), cells(lines[3]));
        assert_eq!(schedule[2..9], ["20 mm, 10 mm", "1000 + 300, 40", "1328", "390", "1.00", "3.00", "1.00"]);
        assert_eq!(schedule[13], "reached");
        assert_eq!(rival[5..9], ["> 1500", "> 3.85", "> 5.00", "> 1.67"]);
        assert_eq!((rival[9].as_str(), rival[13].as_str()), ("2.50", "not reached; fails strain p99"));
        let mut unreached = example();
        unreached.runs[0].reached = None;
        assert_eq!(cells(table(&unreached).lines().nth(3).unwrap())[6], "–");
    }
}
