//! The table of a comparison, in Markdown that is a table on a terminal too.

use super::{Comparison, RunPart, RunTimesPart};
use crate::io::length::describe;
use crate::prepositioning::comparison::Line;
use std::fmt::Write as _;

/// The runs of a comparison, a row each. Ratios are to the first run.
pub fn table(comparison: &Comparison) -> String {
    let mut rows = vec![head(comparison)];
    for (run, times) in comparison.runs.iter().zip(&comparison.times.runs) {
        rows.push(row(comparison, run, times));
    }
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
    let mut text = String::new();
    for (number, row) in rows.iter().enumerate() {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:<width$}")).collect();
        let _ = writeln!(text, "| {} |", cells.join(" | "));
        if number == 0 {
            let rules: Vec<String> = widths.iter().map(|&width| "-".repeat(width)).collect();
            let _ = writeln!(text, "|-{}-|", rules.join("-|-"));
        }
    }
    text
}

fn head(comparison: &Comparison) -> Vec<String> {
    let mut head: Vec<String> =
        ["method", "levels", "evaluations: seams + levels", "curvatures"].map(String::from).into();
    for &line in comparison.lines() {
        head.push(format!("to {}: fine-equivalent", word(line)));
        head.extend(["ratio", "CPU s", "ratio"].map(String::from));
    }
    if is_hand_off(comparison) {
        head.push("above schedule mm".to_owned());
    }
    head.extend(["gap mJ", "gap mm", "residual", "strain p99 / max %", "reached"].map(String::from));
    head
}

fn is_hand_off(comparison: &Comparison) -> bool {
    comparison.lines().contains(&Line::Settled)
}

fn word(line: Line) -> &'static str {
    match line {
        Line::Strain => "strain",
        Line::Settled => "settled",
        Line::Equilibrium => "equilibrium",
    }
}

/// What was compared, where, and how the table is to be read.
pub fn heading(comparison: &Comparison) -> String {
    let Comparison { inputs, finish_line, times, .. } = comparison;
    let percent = |share: Option<f64>| format!("{} %", 100.0 * share.unwrap_or(f64::NAN));
    let line = match finish_line.residual_weights {
        Some(residual) => format!("equilibrium, rms residual {residual} weights"),
        None => format!(
            "hand-off; *strain*: p99 at most {}, mean at most {}; *settled*: besides, energy of the\n\
             sliding cloth at most that of the schedule and {} of mean height",
            percent(finish_line.strain_p99),
            percent(finish_line.strain_mean),
            describe(finish_line.allowance_m.unwrap_or(f64::NAN)),
        ),
    };
    let start = comparison.perturbation.as_ref().map_or_else(String::new, |p| {
        format!("\nThe start was disturbed by up to {}, seed {}.", describe(p.amplitude_m), p.seed)
    });
    let host = &times.host;
    format!(
        "# {} on {}, {}\n\nFinish line: {line}. Rivals were given up after {} evaluations.{start}\n\n\
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

/// What a run cost until a finish line, or in all if it did not get there: evaluations and seconds.
fn cost(run: &RunPart, times: &RunTimesPart, line: Line) -> [f64; 2] {
    [
        run.reached.at(line).map_or(run.fine_equivalent, |reached| reached.fine_equivalent),
        times.reached.at(line).map_or(times.total.cpu_seconds, |reached| reached.spent.cpu_seconds),
    ]
}

fn row(comparison: &Comparison, run: &RunPart, times: &RunTimesPart) -> Vec<String> {
    let levels: Vec<String> = run.levels.iter().map(|level| describe(level.resolution_m)).collect();
    let counts: Vec<String> = run.levels.iter().map(|level| level.evaluations.to_string()).collect();
    let curvatures = run.sewing.curvatures + run.levels.iter().map(|level| level.curvatures).sum::<usize>();
    let mut row = vec![
        run.name.clone(),
        levels.join(", "),
        format!("{} + {}", run.sewing.evaluations, counts.join(", ")),
        curvatures.to_string(),
    ];
    for &line in comparison.lines() {
        row.extend(costs(comparison, run, times, line));
    }
    if is_hand_off(comparison) {
        row.push(format!("{:.2}", run.end.above_schedule_m * 1e3));
    }
    row.extend([
        format!("{:.2}", run.end.energy_gap_j * 1e3),
        format!("{:.2}", run.end.energy_gap_height_m * 1e3),
        format!("{:.3}", run.end.residual_weights),
        format!("{:.2} / {:.1}", run.end.strain_p99 * 100.0, run.end.strain_max * 100.0),
        verdict(comparison.lines(), run),
    ]);
    row
}

/// Of a finish line: evaluations and seconds, each with its ratio.
fn costs(comparison: &Comparison, run: &RunPart, times: &RunTimesPart, line: Line) -> [String; 4] {
    let [evaluations, seconds] = cost(run, times, line);
    let beyond = if run.reached.at(line).is_some() { "" } else { "> " };
    // What the first has not reached is no measure for others.
    let first = comparison.runs.first().filter(|run| run.reached.at(line).is_some()).zip(comparison.times.runs.first());
    let first = first.map(|(run, times)| cost(run, times, line));
    let ratio =
        |ours: f64, k: usize| first.map_or_else(|| "–".to_owned(), |first| format!("{beyond}{:.2}", ours / first[k]));
    [format!("{beyond}{evaluations:.0}"), ratio(evaluations, 0), format!("{beyond}{seconds:.2}"), ratio(seconds, 1)]
}

fn verdict(lines: &[Line], run: &RunPart) -> String {
    let reached: Vec<&str> =
        lines.iter().filter(|&&line| run.reached.at(line).is_some()).map(|&line| word(line)).collect();
    let reached = if reached.is_empty() { "nothing".to_owned() } else { reached.join(", ") };
    match run.end.failed_checks.join(", ").replace('_', " ").as_str() {
        "" => reached,
        failed => format!("{reached}; fails {failed}"),
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
        assert_eq!(schedule[2..5], ["20 mm, 10 mm", "1000 + 300, 40", "1328"]);
        assert_eq!(schedule[5..9], ["390", "1.00", "3.00", "1.00"]);
        assert_eq!(schedule[9..14], ["390", "1.00", "3.00", "1.00", "0.00"]);
        assert_eq!(schedule[18], "strain, settled");
        // One line is soon reached and says little; the other is not.
        assert_eq!(rival[5..9], ["1020", "2.62", "4.50", "1.50"]);
        assert_eq!(rival[9..15], ["> 1500", "> 3.85", "> 5.00", "> 1.67", "1.00", "2.50"]);
        assert_eq!(rival[18], "strain; fails particles inside");
        let mut unreached = example();
        unreached.runs[0].reached.settled = None;
        assert_eq!(cells(table(&unreached).lines().nth(3).unwrap())[10], "–");
    }

    #[test]
    fn the_equilibrium_has_one_finish_line() {
        let mut example = example();
        example.finish_line.residual_weights = Some(0.1);
        for run in &mut example.runs {
            run.reached.equilibrium = run.reached.settled.take();
        }
        let text = table(&example);
        assert!(text.contains("to equilibrium") && !text.contains("settled") && !text.contains("above schedule"));
        assert!(text.contains("equilibrium; fails") || text.contains("nothing; fails"), "{text}");
    }
}
