//! What drives the motion at the stages of a phase from outside: the controls, and the time where the model reads it.
//!
//! Linear controls are those of the nodes at both ends of the interval, `u = u_k + tau (u_k+1 - u_k)`, where `tau` is
//! the share of the *physical* length `T / N` that has passed. Without a switch in the interval `tau` is a number;
//! with switches it is an unknown of its own, since the lengths of the phases before it are.

use super::builder::Builder;
use super::discretization::Lengths;
use super::layout::{FREE, Phase};
use crate::model::held::{complete_largest, first_of_stages};
use crate::ocp::motion::control_grid::ControlShape;

/// A moment in an interval: the time passed since its start as a sum of `coefficient variable`.
#[derive(Clone)]
pub(in crate::ocp) struct Elapsed {
    terms: Vec<(usize, f64)>,
    /// The time passed as a share of the interval, if that is a number: as long as the length of the motion is all
    /// that it depends on.
    share: Option<f64>,
    horizon: usize,
    intervals: usize,
}

impl Elapsed {
    /// The start of an interval, where that many make up the `horizon`.
    pub(in crate::ocp) fn none(horizon: usize, intervals: usize) -> Self {
        Self {
            terms: Vec::new(),
            share: Some(0.0),
            horizon,
            intervals,
        }
    }

    /// A moment later by `factor` times the variable `scale`.
    pub(in crate::ocp) fn later(&self, scale: usize, factor: f64) -> Self {
        let mut later = self.clone();
        later.terms.push((scale, factor));
        let known = self.share.filter(|_| scale == self.horizon);
        later.share = known.map(|share| share + factor * self.intervals as f64);
        later
    }

    /// The end of the interval.
    pub(in crate::ocp) fn all(mut self) -> Self {
        self.share = Some(1.0);
        self
    }
}

/// The controls at a moment of an interval, and the time where the model reads it; `guess` is the share of the
/// interval as far as it is known.
pub(in crate::ocp) fn drive_at(
    builder: &mut Builder,
    interval: usize,
    elapsed: &Elapsed,
    guess: f64,
    place: &str,
) -> Vec<usize> {
    let mut drive = controls_at(builder, interval, elapsed, guess, place);
    largest_at(builder, (interval, guess), &mut drive, place);
    if builder.setting.model.declaration().explicit_time {
        let share = 1.0 / builder.setting.problem.intervals as f64;
        let mut terms = match builder.setting.lengths {
            Lengths::Equal => vec![(builder.frame.horizon, interval as f64 * share)],
            Lengths::Free | Lengths::Phases(_) => builder.passed(interval),
        };
        terms.extend(&elapsed.terms);
        let time = match builder.setting.lengths {
            Lengths::Phases(_) => builder.guessed_time(interval, guess),
            Lengths::Equal | Lengths::Free => {
                builder.guess.horizon * (interval as f64 + guess) * share
            }
        };
        let name = format!("time {place}");
        drive.push(builder.frame.time(&mut builder.program, name, &terms, time));
    }
    drive
}

/// Puts unknowns of this moment in the place of the controls that are largest values of an instant; `guess` is the share of the interval as
/// far as it is known.
fn largest_at(
    builder: &mut Builder,
    (interval, guess): (usize, f64),
    drive: &mut [usize],
    place: &str,
) {
    let model = builder.setting.model;
    let first = first_of_stages(model);
    if first == drive.len() {
        return;
    }
    let sample = builder
        .guess
        .at(builder.guessed_time(interval, guess), true);
    let declaration = model.declaration();
    let mut x = sample[..2 * builder.n].to_vec();
    x.extend(drive.iter().map(|&i| builder.program.guessed(i)));
    x.resize(declaration.path_inputs(), 0.0);
    complete_largest(model, &mut x);
    for (k, variable) in drive.iter_mut().enumerate().skip(first) {
        let program = &mut builder.program;
        let name = format!("`{}` {place}", declaration.controls[k].name);
        let unit = program.unit(*variable);
        program.bound(*variable, 0.0, 0.0);
        *variable = program.variable(name, FREE, x[2 * builder.n + k], unit);
    }
}

/// The controls at a moment of an interval; `guess` is its share of the interval as far as it is known.
fn controls_at(
    builder: &mut Builder,
    interval: usize,
    elapsed: &Elapsed,
    guess: f64,
    place: &str,
) -> Vec<usize> {
    let (model, problem) = (builder.setting.model, builder.setting.problem);
    let from = builder.frame.controls[interval].clone();
    if builder.setting.shape == ControlShape::Constant || from.is_empty() {
        return from;
    }
    let to = builder.frame.controls[interval + 1].clone();
    if elapsed.share == Some(0.0) {
        return from;
    }
    if elapsed.share == Some(1.0) {
        return to;
    }
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    let horizon = builder.frame.horizon;
    let program = &mut builder.program;
    let tau = elapsed.share.is_none().then(|| {
        let name = format!("share of interval {interval} {place}");
        let tau = program.variable(name.clone(), free, guess, 1.0);
        let row = program.row(name, 0.0, 0.0);
        program.bilinear(row, horizon, tau, 1.0 / problem.intervals as f64);
        for &(variable, coefficient) in &elapsed.terms {
            program.linear(row, variable, -coefficient);
        }
        tau
    });
    let guessed = builder.guess.controls.at(interval as f64 + guess);
    let names = model.declaration().controls.iter().enumerate();
    let controls = names.zip(from.iter().zip(&to)).zip(guessed);
    let first = first_of_stages(model);
    controls
        .map(|(((k, control), (&from, &to)), guessed)| {
            if k >= first {
                return from;
            }
            let name = format!("`{}` {place}", control.name);
            let unit = program.unit(from);
            let u = program.variable(name.clone(), free, guessed, unit);
            let row = program.row(name, 0.0, 0.0);
            program.linear(row, u, 1.0 / unit);
            match (tau, elapsed.share) {
                (Some(tau), _) => {
                    program.linear(row, from, -1.0 / unit);
                    program.bilinear(row, tau, to, -1.0 / unit);
                    program.bilinear(row, tau, from, 1.0 / unit);
                }
                (None, share) => {
                    let share = share.unwrap_or(guess);
                    program.linear(row, from, -(1.0 - share) / unit);
                    program.linear(row, to, -share / unit);
                }
            }
            u
        })
        .collect()
}

/// What drives the motion at the share `theta` of a phase.
pub(in crate::ocp) fn drive_within(
    builder: &mut Builder,
    phase: &Phase,
    theta: f64,
    place: &str,
) -> Vec<usize> {
    let c = builder.setting.tableau.c();
    let (Some(first), Some(last)) = (phase.stages.first(), phase.stages.last()) else {
        return Vec::new();
    };
    let share = (theta - c[0]) / (c[c.len() - 1] - c[0]);
    let program = &mut builder.program;
    let pairs = first.drive.iter().zip(&last.drive).enumerate();
    pairs
        .map(|(k, (&from, &to))| {
            if from == to {
                return from;
            }
            let (a, b) = (program.guessed(from), program.guessed(to));
            let name = format!("drive {k} {place}");
            let free = (f64::NEG_INFINITY, f64::INFINITY);
            let unit = program.unit(from);
            let u = program.variable(name.clone(), free, a + share * (b - a), unit);
            let row = program.row(name, 0.0, 0.0);
            program.linear(row, u, 1.0 / unit);
            program.linear(row, from, -(1.0 - share) / unit);
            program.linear(row, to, -share / unit);
            u
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::model::Pieces;
    use crate::ocp::collocation::test_scene::with_setting;
    use crate::ocp::collocation::transcribe::transcribe;
    use crate::ocp::motion::control_grid::ControlShape;
    use crate::ocp::motion::sequence::{Place, Sequence, Switch};
    use crate::ocp::problem::Problem;
    use crate::ocp::settings::Guess;
    use crate::simulation::ContactMode;
    use hangtime_solver::nlp;

    crate::model! {
        /// A mass with an engine, on the ground.
        Hopper {
            parameters { m: kg = 2, g: m/s^2 = 9.81 }
            coordinates { z: m }
            controls { u: N in 0..=80 }
            lagrangian m/2*dot(z)^2 - m*g*z
            forces { z: u }
            surface ground: z >= 0
            impact ground: inelastic
            minimize integral(u^2)
            finally { z == 0.5[m] }
            horizon 1 [s]
        }
    }

    #[test]
    fn contact_that_opens_at_a_node_of_linear_controls_is_let_go_by_a_vanishing_force() {
        let model = Hopper::default();
        let problem = Problem::of(&model, 3);
        let sequence = Sequence {
            initially: vec![ContactMode::Frictionless],
            pieces: Pieces::default(),
            switches: vec![Switch {
                impulse: ContactMode::Frictionless,
                place: Place::Start,
                ..Switch::inside(0, false, ContactMode::Open, 1.0)
            }],
        };
        let with = (ControlShape::Linear, 4, Guess::Straight);
        with_setting((&model, &problem), with, |setting, start| {
            let mut program = transcribe(setting, &sequence, start, &[], &[1; 3]);
            let solution = nlp::solve(&mut program.program, &nlp::Settings::default()).unwrap();
            assert_eq!(solution.status, nlp::Status::Solved);
            let (motion, sequence) = program.result(&solution.x);
            assert_eq!(sequence.switches[0].time, 1.0);
            // The engine carries the mass there, and not before.
            let u: Vec<f64> = motion.controls.values().iter().map(|u| u[0]).collect();
            let weight = 2.0 * 9.81;
            assert!((u[1] - weight).abs() < 1e-7, "{u:?}");
            assert!(u[0] < weight && u[2] > weight, "{u:?}");
            // From then on z'' = (u - weight) / m, linear on both intervals of a third of a second.
            let h: f64 = 1.0 / 3.0;
            let (a2, a3) = ((u[2] - weight) / 2.0, (u[3] - weight) / 2.0);
            let (z, v) = (h * h * a2 / 6.0, h * a2 / 2.0);
            let height = z + v * h + h * h * (2.0 * a2 + a3) / 6.0;
            assert!((height - 0.5).abs() < 1e-9, "{height}");
        });
    }
}
