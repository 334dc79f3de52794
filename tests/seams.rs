//! Seams beside the file, their directions, and what is proposed, on real patterns.

mod support;

use support::{patterns, shared_patterns};
use toile::io::{garmentcode, seams_toml};
use toile::pattern::sewing::{SeamPlan, Stretch, find_directions, plans_of, resolve};
use toile::pattern::{Pattern, Sense};

/// Even chances from a linear congruential generator (Knuth's MMIX constants): the same everywhere.
fn chances(seed: u64) -> impl FnMut() -> bool {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        state >> 63 == 1
    }
}

/// The pattern with some panels turned over, and its plans for the same edges.
fn turned(pattern: &Pattern, over: &[bool]) -> (Pattern, Vec<SeamPlan>) {
    let mut made = pattern.clone();
    for (panel, _) in made.panels.iter_mut().zip(over).filter(|(_, over)| **over) {
        *panel = panel.turned_over();
    }
    let mut plans = plans_of(pattern);
    for stretch in plans.iter_mut().flat_map(|plan| plan.sides.iter_mut().flatten()) {
        if over[stretch.panel] {
            let last = pattern.panels[stretch.panel].segments.len() - 1;
            *stretch = Stretch { segments: vec![last - stretch.segments[0]], ..stretch.clone() };
        }
    }
    (made, plans)
}

fn hidden(plans: Vec<SeamPlan>) -> Vec<SeamPlan> {
    plans.into_iter().map(|plan| SeamPlan { direction: None, ..plan }).collect()
}

#[test]
fn directions_of_real_patterns_are_found_however_their_panels_are_wound() {
    for (name, text) in shared_patterns() {
        let (pattern, _) = garmentcode::parse(&text, &name).unwrap();
        for seed in 0..4 {
            let mut chance = chances(seed);
            let over: Vec<bool> = pattern.panels.iter().map(|_| seed > 0 && chance()).collect();
            let (wound, plans) = turned(&pattern, &over);
            let found = find_directions(&wound, &hidden(plans));
            // Right is what turns all panels back, or all of them over.
            let wrong: Vec<&str> = (0..over.len())
                .filter(|&k| found.turned[k] != over[k])
                .map(|k| pattern.panels[k].name.as_str())
                .collect();
            assert!(wrong.is_empty(), "{name}, seed {seed}: {wrong:?} are the wrong way");
            assert!(found.warnings.is_empty(), "{name}: {}", found.warnings[0]);
        }
    }
}

#[test]
fn sewing_what_is_sewn_gives_the_same_seams() {
    for (name, text) in shared_patterns() {
        let (pattern, _) = garmentcode::parse(&text, &name).unwrap();
        let resolved = resolve(&pattern, &hidden(plans_of(&pattern))).unwrap();
        assert_eq!(resolved.pattern.seams, pattern.seams, "{name}");
        assert_eq!(resolved.pattern.panels, pattern.panels, "{name}");
    }
}
