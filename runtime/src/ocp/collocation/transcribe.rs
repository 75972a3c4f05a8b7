//! Construction of the collocation program, interval by interval.

use super::builder::Builder;
use super::discretization::Setting;
use super::impact_map::Instant;
use super::layout::Cut;
use super::program::Collocation;
use super::{impact_map, interval, provided, start_conditions};
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::frame::{Frame, Provided};
use crate::program::sparse_program::Program;

/// The program of a sequence, started at `guess`, with `elements` of each interval's phases.
pub(in crate::ocp) fn transcribe<'a>(
    setting: Setting<'a>,
    sequence: &Sequence,
    guess: &Trajectory,
    cuts: &[Cut],
    elements: &[usize],
) -> Collocation<'a> {
    let (model, problem) = (setting.model, setting.problem);
    let mut program = Program::new(model);
    let mut frame = Frame::add(
        &mut program,
        model,
        problem,
        guess,
        setting.shape,
        setting.units,
        setting.bounds,
    );
    let state = frame.start.clone();
    frame.sums = provided::sums(&mut program, setting);
    let mut builder = Builder {
        setting,
        program,
        guess,
        cuts,
        elements,
        frame,
        phases: Vec::new(),
        impacts: Vec::new(),
        modes: sequence.initially.clone(),
        pieces: sequence.pieces.clone(),
        touches: Vec::new(),
        distances: Vec::new(),
        state,
        before: Vec::new(),
        duration: None,
        n: problem.q.len(),
    };
    start_conditions::add(&mut builder);
    let mut spans = Vec::with_capacity(problem.intervals);
    for interval in 0..problem.intervals {
        spans.push(builder.program.extent());
        interval::add(&mut builder, interval, &sequence.switches);
    }
    spans.push(builder.program.extent());
    let last = |switch: &Switch| switch.interval == problem.intervals;
    for (index, switch) in sequence.switches.iter().enumerate() {
        if last(switch) && !switch.accompanies {
            let instant = Instant::at(&sequence.switches, index);
            impact_map::close(&mut builder, &instant, "the last interval", guess.horizon);
        }
    }
    interval::add_up(&mut builder);
    let (frame, mut program) = (builder.frame, builder.program);
    // Right before an impact at the end.
    let forces = builder.phases.last().and_then(|phase| phase.stages.last());
    let known = Provided::Known(forces.map_or(&[], |stage| &stage.provided));
    let missed = frame.finish(&mut program, &builder.state, known, setting.elastic);
    Collocation {
        program: program
            .finish(&frame.controls, |largest| setting.units.objective(largest))
            .hasten(frame.horizon, setting.haste),
        model,
        sequence: sequence.clone(),
        phases: builder.phases,
        end: builder.state,
        impacts: builder.impacts,
        touches: builder.touches,
        distances: builder.distances,
        tableau: setting.tableau,
        spans,
        horizon: frame.horizon,
        controls: frame.controls,
        shape: setting.shape,
        aligned: setting.lengths.are_of_phases(),
        missed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Pieces;
    use crate::ocp::collocation::discretization::{Lengths, Span};
    use crate::ocp::collocation::layout::CutKind;
    use crate::ocp::collocation::test_scene::{self, Demanding};
    use crate::ocp::motion::control_grid::ControlShape;
    use crate::ocp::motion::sequence::Place;
    use crate::ocp::problem::{Horizon, Problem};
    use crate::ocp::settings::Guess;
    use crate::simulation::ContactMode;
    use hangtime_solver::nlp::{NlpProblem, check_derivatives};

    /// The central difference of a function with values and derivatives up to 1e3 is good to about 1e-7 of them.
    const DIFFERENCE: f64 = 1e-5;

    /// The demanding scene with controls of that shape, and a motion to start from.
    fn with_setting(shape: ControlShape, check: impl Fn(Setting, &Trajectory)) {
        let model = Demanding::default();
        let problem = Problem {
            horizon: Horizon::Free { guess: Some(1.2) },
            ..Problem::of(&model, 3)
        };
        let with = (shape, 3, Guess::Perturbed(3));
        test_scene::with_setting((&model, &problem), with, |setting, guessed| {
            assert_eq!(setting.parabolas, [false, false, true]);
            check(setting, guessed);
        });
    }

    /// A switch of the sledge, which lands without rebound.
    fn switch(closes: bool, interval: usize, place: Place, time: f64) -> Switch {
        let mode = if closes {
            ContactMode::Frictionless
        } else {
            ContactMode::Open
        };
        Switch {
            impulse: ContactMode::Frictionless,
            interval,
            place,
            ..Switch::inside(0, closes, mode, time)
        }
    }

    fn sequence(switches: &[Switch]) -> Sequence {
        Sequence {
            initially: vec![ContactMode::Open],
            pieces: Pieces::default(),
            switches: switches.to_vec(),
        }
    }

    #[test]
    fn lengths_are_held_of_what_a_neighbour_adds_and_of_where_a_switch_has_moved_through_a_node() {
        with_setting(ControlShape::Constant, |setting, guessed| {
            let program = |switches: &[Switch]| {
                transcribe(setting, &sequence(switches), guessed, &[], &[1, 1, 1])
            };
            let landing = switch(true, 0, Place::Inside, 0.4);
            let lift_off = switch(false, 2, Place::Inside, 2.04);
            let mut best = program(&[landing, lift_off]);
            let mut x = vec![0.0; best.program.extent().0];
            best.program.initial_point(&mut x);
            let names = |switches: &[Switch]| {
                let neighbour = program(switches);
                let lengths = neighbour.lengths_of_new_phases(&best, &x);
                let names = lengths.iter().map(|&i| neighbour.program.variable_name(i));
                names.collect::<Vec<String>>()
            };
            assert!(names(&[landing, lift_off]).is_empty());
            let flight = [
                switch(false, 1, Place::Inside, 1.4),
                switch(true, 1, Place::Inside, 1.6),
            ];
            let inserted = names(&[landing, flight[0], flight[1], lift_off]);
            assert_eq!(inserted, ["length of phase 1 of interval 1"]);
            let earlier = switch(false, 1, Place::Inside, 1.95);
            assert_eq!(
                names(&[landing, earlier]),
                ["length of phase 1 of interval 1"]
            );
            // A touch leaves the modes as they are, and is told by what came before.
            let touch = |interval, time| Switch {
                mode: ContactMode::Open,
                ..switch(true, interval, Place::Inside, time)
            };
            best = program(&[touch(1, 1.02)]);
            let mut x = vec![0.0; best.program.extent().0];
            best.program.initial_point(&mut x);
            let moved = program(&[touch(0, 0.95)]);
            let lengths = moved.lengths_of_new_phases(&best, &x);
            assert_eq!(lengths.len(), 1);
            assert_eq!(
                moved.program.variable_name(lengths[0]),
                "length of phase 1 of interval 0"
            );
        });
    }

    #[test]
    fn held_lengths_are_fixed_and_relaxed_phases_keep_their_equations() {
        with_setting(ControlShape::Constant, |setting, guessed| {
            let switches = [
                switch(true, 0, Place::Inside, 0.4),
                switch(false, 0, Place::Inside, 0.6),
            ];
            let sequence = sequence(&switches);
            let bounds = |program: &Collocation| {
                let (n, m) = program.program.extent();
                let mut rows = (vec![0.0; m], vec![0.0; m]);
                program.program.constraint_bounds(&mut rows.0, &mut rows.1);
                let variables: Vec<(f64, f64)> =
                    (0..n).map(|i| program.program.bounds(i)).collect();
                (
                    variables,
                    rows.0.into_iter().zip(rows.1).collect::<Vec<_>>(),
                )
            };
            let mut program = transcribe(setting, &sequence, guessed, &[], &[1, 1, 1]);
            let (variables, rows) = bounds(&program);
            let contact = &program.phases[1];
            let (length, own) = (contact.scale, contact.rows.clone());
            program.hold(&[length], true);
            let (held, relaxed) = bounds(&program);
            for (i, (before, after)) in variables.iter().zip(&held).enumerate() {
                let expected = if i == length {
                    (before.0, before.0)
                } else {
                    *before
                };
                assert_eq!(*after, expected);
            }
            let mut left_out = 0;
            for (row, (before, after)) in rows.iter().zip(&relaxed).enumerate() {
                let drops = own.contains(&row) && before.0 < before.1;
                left_out += usize::from(drops);
                let free = (f64::NEG_INFINITY, f64::INFINITY);
                assert_eq!(*after, if drops { free } else { *before }, "row {row}");
            }
            assert!(left_out > 0);
        });
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for shape in [ControlShape::Constant, ControlShape::Linear] {
            with_setting(shape, check_derivatives_of);
        }
        with_setting(ControlShape::Constant, |setting, guessed| {
            let lengths = Lengths::Free;
            check_derivatives_of(Setting { lengths, ..setting }, guessed);
        });
    }

    #[test]
    fn derivatives_of_phases_of_any_length_with_goals_that_may_be_missed_agree_with_differences() {
        with_setting(ControlShape::Constant, |setting, guessed| {
            let span = |pieces: usize, free: bool, from: f64, to: f64| Span {
                pieces,
                free,
                from,
                to,
                duration: 1.1 * (to - from),
                elements: 1,
                longest: free.then_some(0.4),
            };
            let end = guessed.horizon;
            let spans = [
                span(2, false, 0.0, 0.4 * end),
                span(1, true, 0.4 * end, 0.7 * end),
                span(2, true, 0.7 * end, end),
            ];
            let problem = Problem {
                intervals: 5,
                ..setting.problem.clone()
            };
            let sizes = vec![0.5; 8];
            let setting = Setting {
                problem: &problem,
                lengths: Lengths::Phases(&spans),
                elastic: Some(&sizes),
                ..setting
            };
            let guess = Trajectory {
                controls: guessed.controls.resampled(ControlShape::Constant, 5),
                ..guessed.clone()
            };
            let sequence = sequence(&[
                switch(true, 2, Place::Start, 2.0),
                switch(false, 3, Place::Start, 3.0),
            ]);
            let mut program = transcribe(setting, &sequence, &guess, &[], &[1; 5]);
            assert!(!program.missed.is_empty());
            program.penalize(7.0);
            let compared = check_derivatives(&mut program.program, None).unwrap();
            assert!(compared[0].error < DIFFERENCE, "{:?}", compared[0]);
            // A phase that is divided evenly has one length, others one an interval.
            let mut lengths: Vec<usize> = program.phases.iter().map(|phase| phase.scale).collect();
            lengths.dedup();
            assert_eq!(lengths.len(), 4);
        });
    }

    fn check_derivatives_of(setting: Setting, guessed: &Trajectory) {
        let sequence = sequence(&[
            switch(true, 0, Place::Inside, 0.4),
            switch(false, 0, Place::Inside, 0.8),
            switch(true, 1, Place::Start, 1.0),
            switch(false, 2, Place::Start, 2.0),
        ]);
        let cut = |phase, interval, kind| Cut {
            interval,
            phase,
            theta: 0.3,
            kind,
        };
        let cuts = [
            cut((0, 3), 0, CutKind::Gap(0, 1e-5)),
            cut((0, 1), 2, CutKind::Bounds(0)),
            cut((0, 1), 2, CutKind::Departure(0)),
            cut((0, 1), 2, CutKind::Approach(0)),
            cut((0, 1), 2, CutKind::Path(0)),
        ];
        let mut fine = transcribe(setting, &sequence, guessed, &cuts, &[1, 2, 1]);
        assert_eq!(fine.phases.len(), 6);
        let compared = check_derivatives(&mut fine.program, None).unwrap();
        assert!(compared[0].error < DIFFERENCE, "{:?}", compared[0]);
    }
}
