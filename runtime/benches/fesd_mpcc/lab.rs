use crate::scenes::*;
use hangtime::model::Model;
use hangtime::mpcc::{self, Mpcc, RelaxationRule};
use hangtime::nlp::NlpProblem;
use hangtime::ocp::*;
use hangtime::rk::Scheme;

struct Case {
    name: &'static str,
    model: Box<dyn Model>,
    q: Vec<f64>,
    v: Vec<f64>,
    hs: Vec<f64>,
}

fn case(name: &'static str, model: impl Model + 'static, q: &[f64], v: &[f64], hs: &[f64]) -> Case {
    Case {
        name,
        model: Box::new(model),
        q: q.to_vec(),
        v: v.to_vec(),
        hs: hs.to_vec(),
    }
}

fn settings() -> TimeFreezingSettings {
    let mut s = TimeFreezingSettings::default();
    if let Ok(a) = std::env::var("ABAR") {
        s.auxiliary_acceleration = a.parse().unwrap();
    }
    s
}

pub fn main() {
    let only = std::env::var("ONLY").ok();
    let verbose = std::env::var("V").is_ok();
    let table = |y: f64| (((-0.0001524 * y - 0.002149) * y + 0.4162) * y - 9.154) * y + 99.15;
    let y0 = 10.2759;
    let cases = vec![
        case(
            "ball fall",
            Ball::default(),
            &[0.0, 0.5],
            &[1.0, 0.0],
            &[0.35, 0.4, 0.5, 0.7, 0.9],
        ),
        case(
            "ball slide",
            Ball::default(),
            &[0.0, 0.0],
            &[1.0, 0.0],
            &[0.02, 0.1, 0.3, 1.0],
        ),
        case(
            "ball fly",
            Ball::default(),
            &[0.0, 0.5],
            &[1.0, 2.0],
            &[0.02, 0.1, 0.3],
        ),
        case(
            "ball impact",
            Ball::default(),
            &[0.0, 0.0],
            &[1.0, -3.0],
            &[0.02, 0.1, 0.3],
        ),
        case(
            "waves slide",
            Waves::default(),
            &[0.0, 0.0],
            &[1.0, 0.2],
            &[0.02, 0.1, 0.3, 0.5],
        ),
        case(
            "waves fall",
            Waves::default(),
            &[0.0, 0.3],
            &[1.0, 0.0],
            &[0.25, 0.3, 0.4],
        ),
        case(
            "waves valley",
            Waves::default(),
            &[4.0, 0.2 * (4f64).sin()],
            &[1.0, 0.2 * (4f64).cos()],
            &[0.02, 0.1, 0.3, 0.5],
        ),
        case(
            "bowl slide",
            Bowl::default(),
            &[-1.0, 0.5],
            &[1.0, -1.0],
            &[0.02, 0.1, 0.3, 0.5],
        ),
        case(
            "bowl fall",
            Bowl::default(),
            &[-1.0, 0.8],
            &[1.0, 0.0],
            &[0.15, 0.2, 0.3, 0.5],
        ),
        case(
            "ski slide",
            SkiJump::default(),
            &[y0, table(y0)],
            &[0.0, 0.0],
            &[0.02, 0.1, 0.3],
        ),
        case(
            "ski land",
            SkiJump::default(),
            &[40.0, 25.5],
            &[18.0, -8.0],
            &[0.3, 0.5, 1.0],
        ),
        case(
            "ski on slope",
            SkiJump::default(),
            &[50.0, 20.0],
            &[18.0, -9.0],
            &[0.1, 0.5, 1.0],
        ),
        case(
            "bar flat",
            Bar::default(),
            &[0.0, 0.3, 0.0],
            &[0.5, 0.0, 0.0],
            &[0.25, 0.3, 0.4],
        ),
        case(
            "bar tilted",
            Bar::default(),
            &[0.0, 0.3, 0.2],
            &[0.5, 0.0, 0.0],
            &[0.25, 0.3, 0.4, 0.5],
        ),
        case(
            "bar resting",
            Bar::default(),
            &[0.0, 0.0, 0.0],
            &[0.5, 0.0, 0.0],
            &[0.02, 0.1, 0.5],
        ),
        case(
            "bar rocking",
            Bar::default(),
            &[0.0, 0.05, 0.1001674212],
            &[0.5, 0.0, 0.0],
            &[0.02, 0.1, 0.2],
        ),
    ];
    let schemes = [
        (Scheme::RadauIia, 1),
        (Scheme::RadauIia, 2),
        (Scheme::RadauIia, 3),
        (Scheme::GaussLegendre, 2),
    ];
    let (mut all, mut good, mut its) = (0, 0, 0);
    if only.as_deref() != Some("pump") {
        for c in &cases {
            if only.as_ref().is_some_and(|o| !c.name.contains(o.as_str())) {
                continue;
            }
            let (mut a, mut g, mut i) = (0, 0, 0);
            let mut line = String::new();
            for &h in &c.hs {
                for (scheme, stages) in schemes {
                    for elements in [3, 4] {
                        let mut p = Problem::of(&*c.model, Objective::default(), vec![], 1);
                        p.q = c.q.clone();
                        p.v = c.v.clone();
                        p.horizon = Horizon::Fixed(h);
                        let mut s = settings();
                        s.scheme = scheme;
                        s.stages = stages;
                        s.elements = elements;
                        let mut tf = TimeFreezing::new(&*c.model, &p, &s).unwrap();
                        let mut ms = mpcc::Settings::default();
                        ms.interior_point.maximum_iterations = 300;
                        if let Ok(r) = std::env::var("RULE") {
                            ms.rules = r
                                .chars()
                                .map(|c| match c {
                                    'r' => RelaxationRule::RollOff,
                                    'c' => RelaxationRule::Continuation,
                                    'p' => RelaxationRule::Proportional,
                                    _ => RelaxationRule::Homotopy,
                                })
                                .collect();
                        }
                        if let Ok(m) = std::env::var("MU") {
                            ms.interior_point.initial_barrier_parameter = m.parse().unwrap();
                        }
                        let sol = mpcc::solve(&mut tf, &ms).unwrap();
                        let r = sol.residuals;
                        a += 1;
                        i += sol.iterations;
                        let ok = r.primal.max(r.complementarity) <= 1e-7;
                        if ok {
                            g += 1;
                            line.push('.');
                        } else {
                            line.push('x');
                        }
                        if verbose {
                            println!(
                                "  {} h {h} {scheme:?} {stages} el {elements}: {:?} by {:?} it {} (crossover {}) primal {:.1e} compl {:.1e} dual {:.1e} sigma {:.1e} obj {:.3e}",
                                c.name,
                                sol.status,
                                sol.rule,
                                sol.iterations,
                                sol.crossover_iterations,
                                r.primal,
                                r.complementarity,
                                r.dual,
                                sol.relaxation_parameter,
                                sol.objective
                            );
                            let m = tf.motion(&sol.x);
                            for e in 0..m.time.len() {
                                println!(
                                    "     t {:.5} num {:.5} alpha {:?} q {:.5?} v {:.5?}",
                                    m.time[e],
                                    m.numerical_lengths[e],
                                    m.step_functions[e],
                                    m.q[e],
                                    m.v[e]
                                );
                            }
                        }
                    }
                }
                line.push(' ');
            }
            println!("{:12} {g}/{a} iterations {i} {line}", c.name);
            all += a;
            good += g;
            its += i;
        }
    }
    println!("TOTAL {good}/{all} iterations {its}");
    if only.is_none() || only.as_deref() == Some("pump") {
        pump(verbose);
    }
}

fn pump(verbose: bool) {
    let ns: Vec<usize> = std::env::var("N").map_or(vec![10], |n| vec![n.parse().unwrap()]);
    for n in ns {
        for speed in [10.0, 15.0, 22.0] {
            let mut model = PumpTrack::default();
            model.set_parameter(5, speed);
            let goal = Goal {
                component: Component::Coordinate(0),
                value: 2.0 * std::f64::consts::PI,
            };
            let p = Problem::of(&model, Objective::time(), vec![goal], n);
            let mut s = settings();
            if let Ok(m) = std::env::var("EL") {
                s.elements = m.parse().unwrap();
            }
            if let Ok(m) = std::env::var("NS") {
                s.stages = m.parse().unwrap();
            }
            let mut tf = TimeFreezing::new(&model, &p, &s).unwrap();
            let mut ms = mpcc::Settings::default();
            ms.interior_point.maximum_iterations = 1000;
            if let Ok(r) = std::env::var("RULE") {
                ms.rules = r
                    .chars()
                    .map(|c| match c {
                        'r' => RelaxationRule::RollOff,
                        'c' => RelaxationRule::Continuation,
                        'p' => RelaxationRule::Proportional,
                        _ => RelaxationRule::Homotopy,
                    })
                    .collect();
            }
            if let Ok(m) = std::env::var("MU") {
                ms.interior_point.initial_barrier_parameter = m.parse().unwrap();
            }
            let t = std::time::Instant::now();
            let sol = mpcc::solve(&mut tf, &ms).unwrap();
            let r = sol.residuals;
            println!(
                "pump N {n} {speed} km/h: n {} m {} pairs {} {:?} by {:?} it {} fact {} (crossover {}) primal {:.1e} compl {:.1e} dual {:.1e} sigma {:.1e} T {:.6} {:.2}s",
                tf.variables(),
                tf.constraints(),
                tf.complementarities().len(),
                sol.status,
                sol.rule,
                sol.iterations,
                sol.factorizations,
                sol.crossover_iterations,
                r.primal,
                r.complementarity,
                r.dual,
                sol.relaxation_parameter,
                tf.motion(&sol.x).horizon,
                t.elapsed().as_secs_f64()
            );
            if verbose {
                let mut o = std::io::stdout();
                for i in &sol.history {
                    let _ = hangtime::nlp::iteration_log::write_line(&mut o, i);
                }
                let m = tf.motion(&sol.x);
                println!("{:.2?}", m.controls);
                for e in 0..m.time.len() {
                    println!(
                        "     t {:.5} num {:.5} alpha {:.4?} q {:.5?} v {:.5?}",
                        m.time[e], m.numerical_lengths[e], m.step_functions[e], m.q[e], m.v[e]
                    );
                }
            }
        }
    }
}
