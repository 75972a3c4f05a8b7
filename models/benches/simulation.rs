//! Time of a whole ski jump of 5 s, by finite elements and event-driven, at equal tolerances.
//!
//! `cargo bench -p hangtime-models --bench simulation`. Times are compared within one run; BENCHMARKS.md
//! records one.

#![expect(clippy::unwrap_used, reason = "a failed step ends the benchmark")]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use hangtime::rk::Scheme;
use hangtime::simulation::{EventDriven, Fesd, InitialValueProblem, Simulator};
use hangtime_models::SkiJump;
use std::hint::black_box;

fn ski_jump(criterion: &mut Criterion) {
    let model = SkiJump::default();
    let problem = InitialValueProblem::of(&model, None).unwrap();
    let mut group = criterion.benchmark_group("ski-jump");
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let event = EventDriven {
            tolerance,
            ..EventDriven::default()
        };
        let simulators: [(&str, &dyn Simulator); 3] = [
            ("event", &event),
            (
                "fesd radau-iia 4",
                &Fesd::default()
                    .with_scheme(Scheme::RadauIia, 4)
                    .with_grid(1, 1)
                    .with_tolerance(tolerance),
            ),
            (
                "fesd radau-iia 6",
                &Fesd::default()
                    .with_scheme(Scheme::RadauIia, 6)
                    .with_grid(1, 1)
                    .with_tolerance(tolerance),
            ),
        ];
        for (name, simulator) in simulators {
            group.bench_function(BenchmarkId::new(name, tolerance), |bencher| {
                bencher.iter(|| {
                    black_box(simulator.simulate(&model, &problem, &mut |_| true)).unwrap()
                });
            });
        }
    }
    group.bench_function("fesd default settings", |bencher| {
        bencher
            .iter(|| black_box(Fesd::default().simulate(&model, &problem, &mut |_| true)).unwrap());
    });
    group.finish();
}

criterion_group!(benches, ski_jump);
criterion_main!(benches);
