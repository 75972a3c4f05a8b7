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
        let mut st = Settings::default();
        if std::env::var("HOM").is_ok() {
            st.rules = vec![mpcc::RelaxationRule::Homotopy];
        }
        if std::env::var("ROLL").is_ok() {
            st.rules = vec![mpcc::RelaxationRule::RollOff];
        }
        if std::env::var("CONT").is_ok() {
            st.rules = vec![mpcc::RelaxationRule::Continuation];
        }
        if std::env::var("PROP").is_ok() {
            st.rules = vec![mpcc::RelaxationRule::Proportional];
        }
        if std::env::var("STATIC").is_ok() {
            st.interior_point.linear_solver = hangtime::nlp::LinearSolver::Static;
        }
        st.interior_point.maximum_seconds = 20.0;
        let t = std::time::Instant::now();
        let s = mpcc::solve(&mut p, &st).unwrap();
        let t = t.elapsed().as_secs_f64();
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
