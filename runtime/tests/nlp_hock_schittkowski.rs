//! explore
mod solver_support;
use hangtime::nlp::{self, Settings};
#[test]
fn table() {
    let only = std::env::var("ONLY").ok();
    let mut total = 0;
    let mut bad = 0;
    for mut p in solver_support::read_problems(include_str!("data/hock_schittkowski.txt")) {
        if let Some(o) = &only {
            if *o != p.name {
                continue;
            }
        }
        let name = p.name.clone();
        let opt = p.optimum.first().copied().unwrap_or(f64::NAN);
        let mut out = Vec::new();
        let s = {
            let mut obs = |i: &nlp::IterationInfo| {
                nlp::iteration_log::write_line(&mut out, i).unwrap();
                true
            };
            let mut st = Settings::default();
            st.maximum_iterations = 500;
            nlp::solve_from(&mut p, &st, None, Some(&mut obs)).unwrap()
        };
        if only.is_some() {
            println!("{}", String::from_utf8(out).unwrap());
            println!("{:?}", s.x);
            println!("{:?} {:?}", s.residuals, s.violations);
        }
        let gap = (s.objective - opt) / opt.abs().max(1.0);
        total += s.counts.iterations;
        let flag = if !s.status.is_solved() || gap.abs() > 1e-6 {
            bad += 1;
            "***"
        } else {
            ""
        };
        println!(
            "{name} {:?} it {} r {} fac {} f {:.10e} opt {:.10e} gap {:.1e} pr {:.1e} du {:.1e} {flag}",
            s.status,
            s.counts.iterations,
            s.counts.restoration_iterations,
            s.counts.factorizations,
            s.objective,
            opt,
            gap,
            s.residuals.primal,
            s.residuals.dual
        );
    }
    println!("total {total} bad {bad}");
}
