mod support;
use toile::body::DistanceField;
use toile::geometry::Vector3;
use toile::io::body_obj;

#[test]
fn real_bodies_are_read_and_their_distance_fields_agree_with_exact_distances() {
    let Some(data) = support::shared_data() else { return };
    for name in ["mean_all", "mean_all_apart", "female_apose", "male_apose"] {
        let bytes = std::fs::read(data.join(format!("bodies/{name}.obj"))).unwrap();
        let t = std::time::Instant::now();
        let (body, warnings) = body_obj::parse(&bytes).unwrap();
        let read = t.elapsed();
        assert!(warnings.is_empty());
        let t = std::time::Instant::now();
        let field = DistanceField::new(&body, 0.006, 0.011);
        let built = t.elapsed();
        let mut worst: Vec<f64> = Vec::new();
        let mut sign = 0;
        let mut points = Vec::new();
        for (k, t) in body.triangles().iter().enumerate().step_by(5) {
            let [a, b, c] = t.map(|v| body.positions()[v as usize]);
            let n: Vector3 = (b - a).cross(&(c - a)).normalize();
            let p = (a + b + c) / 3.0 + n * (0.010 * ((k as f64 * 0.77).sin()));
            points.push(p);
        }
        let t = std::time::Instant::now();
        let exact: Vec<f64> = points.iter().map(|&p| body.signed_distance(p)).collect();
        let te = t.elapsed() / points.len() as u32;
        let t = std::time::Instant::now();
        let sampled: Vec<_> = points.iter().map(|&p| field.sample(p)).collect();
        let ts = t.elapsed() / points.len() as u32;
        for (e, s) in exact.iter().zip(&sampled) {
            let s = s.unwrap().distance;
            worst.push((e - s).abs());
            if (e.signum() != s.signum()) && e.abs() > 5e-4 {
                sign += 1;
            }
        }
        worst.sort_by(f64::total_cmp);
        eprintln!(
            "{name} read {read:?} field {built:?} exact {te:?} sample {ts:?} err median {:.2e} p99 {:.2e} max {:.2e} sign {sign} of {}",
            worst[worst.len() / 2],
            worst[worst.len() * 99 / 100],
            worst[worst.len() - 1],
            worst.len()
        );
    }
}
