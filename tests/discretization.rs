mod support;
use toile::garment::Garment;
use toile::io::garmentcode;

#[test]
fn real_patterns_can_be_sewn_at_many_resolutions() {
    for (name, text) in support::shared_patterns() {
        let (pattern, _) = garmentcode::parse(&text, &name).unwrap();
        for levels in [&[0.05, 0.0232, 0.0108, 0.005][..], &[0.04, 0.02, 0.01], &[0.05], &[0.03, 0.002]] {
            let t = std::time::Instant::now();
            match Garment::build(&pattern, levels) {
                Ok(garment) => {
                    garment.open.sanity_check();
                    garment.levels.iter().for_each(|l| l.sanity_check());
                    eprintln!(
                        "{name} {levels:?} {:?} {:?}",
                        garment.levels.iter().map(|l| l.particle_count).collect::<Vec<_>>(),
                        t.elapsed()
                    );
                }
                Err(e) => eprintln!("{name} {levels:?} ERR {e}"),
            }
        }
    }
}
