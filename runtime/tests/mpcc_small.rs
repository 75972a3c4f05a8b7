mod solver_support;
use hangtime::mpcc::{self, Settings};
#[test]
fn table() {
    let only = std::env::var("ONLY").ok();
    let file = std::env::var("FILE").unwrap_or("tests/data/mpcc_small.txt".into());
    for mut p in solver_support::read_problems(&std::fs::read_to_string(file).unwrap()) {
        if let Some(o) = &only {
            if *o != p.name {
                continue;
            }
        }
        let name = p.name.clone();
        let s = mpcc::solve(&mut p, &Settings::default()).unwrap();
        if only.is_some() {
            let mut out = Vec::new();
            for i in &s.history {
                hangtime::nlp::iteration_log::write_line(&mut out, i).unwrap();
            }
            println!("{}", String::from_utf8(out).unwrap());
            println!("{:?} {:?}", s.x, s.multipliers_lower);
            println!("{:?} {:?} {:?}", s.residuals, s.violations, s.certificate);
        }
        println!(
            "{name} {:?} {:?} it {} cross {} rep {} f {:.10e} opt {:?} {:?} {:?} {:?}",
            s.status,
            s.rule,
            s.iterations,
            s.crossover_iterations,
            s.repairs,
            s.objective,
            p.optimum,
            s.residuals,
            s.certificate
                .as_ref()
                .map(|c| (c.stationarity, c.b_stationary, c.biactive.len())),
            s.violations
        );
    }
}
