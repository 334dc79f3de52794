//! Seams beside the file, their directions, and what is proposed, on real patterns.

mod support;

use support::{patterns, shared_patterns};
use toile::io::dxf::Options;
use toile::io::{garmentcode, pattern_file, seams_svg, seams_toml};
use toile::pattern::sewing::{SeamPlan, Stretch, find_directions, plans_of, resolve};
use toile::pattern::suggest::suggest;
use toile::pattern::surface::{Surface, pieces_of};
use toile::pattern::{Notch, NotchKind, Pattern, SegmentId, Sense};

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

#[test]
fn nine_tenths_of_real_seams_are_proposed_and_nine_tenths_of_proposals_are_real() {
    let (mut hit, mut real, mut proposed) = (0, 0, 0);
    for (name, text) in shared_patterns() {
        let (pattern, _) = garmentcode::parse(&text, &name).unwrap();
        let bare = Pattern { seams: Vec::new(), ..pattern.clone() };
        let suggestions = suggest(&bare);
        let file = seams_toml::write_suggestions(&suggestions, &bare);
        let plans = seams_toml::parse(&file, &bare).unwrap();
        assert_eq!(plans.len(), suggestions.len(), "{name}");
        let ordered = |[a, b]: [SegmentId; 2]| [a.min(b), a.max(b)];
        let sides = |plan: &SeamPlan| ordered(plan.sides.each_ref().map(|side| side[0].parts()[0].id));
        let found =
            plans.iter().filter(|plan| pattern.seams.iter().any(|seam| ordered(seam.sides) == sides(plan))).count();
        eprintln!("{name}: {found} of {} real seams in {} proposals", pattern.seams.len(), plans.len());
        (hit, real, proposed) = (hit + found, real + pattern.seams.len(), proposed + plans.len());
    }
    assert!(10 * hit >= 9 * real, "{hit} of {real} real seams are proposed");
    assert!(10 * hit >= 9 * proposed, "{hit} of {proposed} proposals are real");
}

#[test]
fn without_places_three_fifths_of_seams_are_proposed_all_the_same() {
    let (mut hit, mut real, mut proposed) = (0, 0, 0);
    for (name, text) in shared_patterns() {
        let (pattern, _) = garmentcode::parse(&text, &name).unwrap();
        let mut bare = Pattern { seams: Vec::new(), ..pattern.clone() };
        bare.panels.iter_mut().for_each(|panel| panel.placement = None);
        let suggestions = suggest(&bare);
        let ordered = |[a, b]: [SegmentId; 2]| [a.min(b), a.max(b)];
        let found = suggestions.iter().filter(|suggestion| {
            let sides = suggestion.plan.sides.each_ref().map(|side| side[0].parts()[0].id);
            let single = suggestion.plan.sides.iter().all(|side| side.len() == 1);
            single && pattern.seams.iter().any(|seam| ordered(seam.sides) == ordered(sides))
        });
        let found = found.count();
        eprintln!("{name}: {found} of {} real seams in {} proposals", pattern.seams.len(), suggestions.len());
        (hit, real, proposed) = (hit + found, real + pattern.seams.len(), proposed + suggestions.len());
    }
    eprintln!("{hit} of {real} real seams in {proposed} proposals");
    assert!(5 * hit >= 3 * real, "{hit} of {real} real seams are proposed");
    assert!(5 * hit >= 3 * proposed, "{hit} of {proposed} proposals are real");
}

/// The skirt without seams: panels back, belt and front, in the order of their names.
fn skirt() -> Pattern {
    let mut pattern = patterns::pattern_of(&patterns::skirt(60.0, 50.0));
    pattern.seams.clear();
    pattern
}

#[test]
fn a_run_is_cut_where_the_other_side_has_a_corner() {
    let pattern = skirt();
    // The waist of the back, across its closed dart, to the belt; the belt has no corner there.
    let text = "[[seam]]\nname = \"waist\"\nsides = [[\"back:1\", \"back:4\"], \"belt:0 from 4 cm to 90 %\"]\n\
                [[seam]]\nsides = [\"back:2\", \"back:3\"]";
    let sewn = seams_toml::sew(&pattern, text).unwrap();
    assert_eq!(sewn.plan_of_seam, [0, 0, 1]);
    let belt = &sewn.pattern.panels[1];
    assert_eq!(belt.segments.len(), 4 + 3);
    let [front, back] = [0, 1].map(|k| sewn.pattern.seam_lengths(&sewn.pattern.seams[k]));
    let ratio = |[a, b]: [f64; 2]| a / b;
    assert!((ratio(front) - ratio(back)).abs() < 1e-6, "both pieces have the same ease");
    assert!((belt.perimeter() - pattern.panels[1].perimeter()).abs() < 1e-9);
}

#[test]
fn what_cannot_be_sewn_names_seam_line_and_remedy() {
    let pattern = skirt();
    let error = |text: &str| seams_toml::parse(text, &pattern).unwrap_err();
    let e = error("[[seam]]\nname = \"side\"\nsides = [\"frnt:1\", \"back:5\"]");
    assert_eq!((e.place().as_str(), e.remedy()), ("line 3, seam \"side\"", "Did you mean `front`?"));
    assert!(error("[[seam]]\nsides = [\"front:9\", \"back:5\"]").remedy().contains("has 4, counted from 0 to 3"));
    assert_eq!(error("[[seam]]\nside = [\"front:1\", \"back:5\"]").remedy(), "Did you mean `sides`?");
    let twice = "[[seam]]\nsides = [\"front:1\", \"back:5\"]\n[[seam]]\nsides = [\"front:1 from 2 cm\", \"back:0\"]";
    assert!(error(twice).problem().contains("sewn already by the seam \"front:1 + back:5\""));
    for text in
        ["[[seam]]", "seam = 3", "[[seam]]\nsides = [\"front:1\"]", "[[seam]]\nsides = [\"front:1+3\", \"back:0\"]"]
    {
        assert!(!error(text).remedy().is_empty(), "{text}");
    }
}

#[test]
fn a_contradicted_direction_and_a_wrong_ease_are_told_with_the_seam() {
    let pattern = skirt();
    let side = "sides = [\"front:1\", \"back:5\"]";
    let text = format!(
        "[[seam]]\nname = \"left\"\n{side}\n[[seam]]\nname = \"right\"\n\
                        sides = [\"front:3\", \"back:0\"]\ndirection = \"aligned\"\nease = \"9 cm\""
    );
    let stated =
        format!("{text}\n[[seam]]\nname = \"dart\"\nsides = [\"back:2\", \"back:3\"]\ndirection = \"aligned\"");
    let warnings = seams_toml::sew(&pattern, &stated).unwrap().warnings;
    let told: Vec<String> = warnings.iter().map(|w| w.to_string()).collect();
    assert!(told.iter().any(|w| w.contains("seam \"right\"") && w.contains("ease")), "{told:?}");
    // A dart has one direction, whatever is turned over.
    assert!(told.iter().any(|w| w.contains("seam \"dart\"") && w.contains("contradicts")), "{told:?}");
    let codes: Vec<_> = warnings.iter().filter_map(|w| w.0.code()).collect();
    for code in [toile::Code::EaseNotAsStated, toile::Code::DirectionContradicted] {
        assert!(codes.contains(&code), "no {code:?} among {codes:?}");
    }
}

#[test]
fn notches_on_a_seam_become_corners_of_both_sides() {
    let mut pattern = skirt();
    pattern.panels[2].markings.notches.push(Notch { segment: 1, fraction: 0.4, kind: NotchKind::Single });
    pattern.panels[0].markings.notches.push(Notch { segment: 5, fraction: 0.65, kind: NotchKind::Single });
    let sewn = seams_toml::sew(&pattern, "[[seam]]\nsides = [\"front:1\", \"back:5\"]").unwrap().pattern;
    assert_eq!(sewn.seams.len(), 2);
    assert!(sewn.seams.iter().all(|seam| seam.sense == Sense::Opposed));
    // Notch meets notch: 0.4 along the front, 1 - 0.65 along the back from the same end.
    let share = |panel: usize, segment: usize| {
        let whole = pattern.panels[panel].segments[segment].curve.length();
        sewn.panels[panel].segments[segment].curve.length() / whole
    };
    assert!((share(2, 1) - 0.4).abs() < 1e-6 && (share(0, 5) - 0.65).abs() < 1e-6);
}

#[test]
fn the_drawing_shows_every_panel_and_seam() {
    let pattern = patterns::pattern_of(&patterns::skirt(60.0, 50.0));
    let svg = seams_svg::draw(&pattern, &plans_of(&pattern));
    for name in ["front", "back", "belt", "back:2 + back:3", "1a", "5b", "3"] {
        assert!(svg.contains(&format!(">{name}<")) || svg.contains(&format!(" {name}<")), "{name}");
    }
}

/// The halves of a sleeve used to be sewn to each other along cap and hem as well, so that the sleeve was a closed bag.
#[test]
fn no_part_of_a_garment_is_proposed_to_be_sewn_up_to_a_bag() {
    let mut patterns: Vec<Pattern> = Vec::new();
    for (name, text) in shared_patterns() {
        let (placed, _) = garmentcode::parse(&text, &name).unwrap();
        let mut drawn = placed.clone();
        drawn.panels.iter_mut().for_each(|panel| panel.placement = None);
        patterns.extend([placed, drawn]);
    }
    if let Some(data) = support::shared_data() {
        let tee = std::fs::read(data.join("patterns/dxf/gc_tee_aama_clo_mm.dxf")).unwrap();
        patterns.push(pattern_file::open(&tee, "tee", &Options::default()).unwrap().0);
    }
    for pattern in patterns {
        let plans: Vec<SeamPlan> = suggest(&pattern).into_iter().map(|suggestion| suggestion.plan).collect();
        let sewn = resolve(&pattern, &plans).unwrap().pattern;
        let sleeves = (0..sewn.panels.len()).filter(|&panel| sewn.panels[panel].name.to_lowercase().contains("sl"));
        let sleeves: Vec<usize> = sleeves.collect();
        for sleeve in pieces_of(&sleeves, &sewn.seams) {
            let name = &sewn.panels[sleeve[0]].name;
            assert!(!Surface::new(&sewn, &sleeve, &sewn.seams).is_bag(&sewn), "{}: {name}", sewn.name);
        }
    }
}
