//! What a result holds: numbers, states and texts of one run.

use crate::method::Method;
use crate::prepared::{Prepared, output};
use crate::run::{Runs, Theirs, event, name_of, own_end};
use crate::statement::{Expectation, Id, Instant, Left, Side, TextKind, Which};
use hangtime::derivative::{OneSided, SequenceRange};
use hangtime::ocp::Solution;
use hangtime::prelude::*;
use hangtime_units::Unit;

/// Why an expectation does not hold, and the number that came.
pub(crate) type Unmet = (String, Option<f64>);

pub(crate) fn because<T>(why: impl Into<String>) -> Result<T, Unmet> {
    Err((why.into(), None))
}

/// One result, with what is needed to compare it.
pub(crate) struct Found<'a> {
    pub(crate) prepared: &'a Prepared,
    pub(crate) expectation: &'a Expectation,
    pub(crate) result: Of<'a>,
    pub(crate) theirs: Option<&'a Theirs>,
    pub(crate) their_optimum: Option<&'a Solution>,
}

#[derive(Clone, Copy)]
pub(crate) enum Of<'a> {
    Run(&'a Method, &'a Runs),
    Solution(&'a Solution),
}

impl Found<'_> {
    /// The whole motion.
    pub(crate) fn motion(&self) -> Result<&Simulation, Unmet> {
        match self.result {
            Of::Run(_, runs) => runs.whole.as_ref().map_err(|error| (error.clone(), None)),
            Of::Solution(solution) => match &solution.motion {
                Some(motion) => Ok(motion),
                None => because(format!("there is no motion: {}", self.status_shown())),
            },
        }
    }

    pub(crate) fn constant_of(&self, id: Id) -> Result<f64, Unmet> {
        self.prepared.constant(id).map_err(|why| (why, None))
    }

    /// The motion that this one is compared with.
    pub(crate) fn their_motion(&self) -> Result<&Simulation, Unmet> {
        let optimal = || self.their_optimum.and_then(|their| their.motion.as_ref());
        let found = self.theirs.map(|theirs| &theirs.whole).or_else(optimal);
        match found {
            Some(motion) => Ok(motion),
            None => because("there is no scene to compare with; a fence `hang like` has one"),
        }
    }

    /// A value of the motion that this one is compared with.
    pub(crate) fn their(&self, id: Id, instant: &Instant) -> Result<f64, Unmet> {
        let Some(theirs) = self.theirs else {
            return because("there is no scene to compare with; a fence `hang like` has one");
        };
        let time = own_end(self.prepared, instant).map_err(|why| (why, None))?;
        let run = theirs.until(time);
        let at_event = |which: &Which| match event(run, which) {
            Some(index) => Ok(run.events[index].time),
            None => because(format!("no such event among their\n{}", listed(run))),
        };
        let last = run.trajectory.time.last().copied().unwrap_or_default();
        let state = match instant {
            Instant::Start => run.at(0.0),
            Instant::Before(which) => run.just_before(at_event(which)?),
            Instant::After(which) => run.at(at_event(which)?),
            Instant::End | Instant::Time(_) | Instant::Always => run.at(last),
        };
        match state.ok().and_then(|state| state.get(&output(id))) {
            Some(value) => Ok(value),
            None => because("their value is not recorded"),
        }
    }

    /// The number on the left.
    pub(crate) fn number(&self, left: &Left, instant: &Instant) -> Result<f64, Unmet> {
        match left {
            Left::Expression(id, text) => {
                if let Of::Solution(solution) = self.result
                    && let Some(known) = solution.parameters.iter().find(|p| p.name == text)
                {
                    let unit = known.unit.parse::<Unit>().map_or(1.0, |unit| unit.scale);
                    return Ok(known.value * unit);
                }
                let state = self.state(instant)?;
                match state.get(&output(*id)) {
                    Some(value) => Ok(value),
                    None => because(format!("`{text}` is not recorded")),
                }
            }
            Left::Named(name) => match self.state(instant)?.get(name) {
                Some(value) => Ok(value),
                None => because(format!("`{name}` is not recorded")),
            },
            Left::Fact(name) => self.fact(name),
            Left::Count(which) => {
                let events = self.motion()?.events.iter();
                let counted = events.filter(|event| {
                    which.as_ref().is_none_or(|which| {
                        let name = which.name.as_deref();
                        event.kind == which.kind && name.is_none_or(|n| n == event.contact_name)
                    })
                });
                Ok(counted.count() as f64)
            }
            Left::Derivative(of, by, side) => self.derivative(of, by, *side, instant),
            Left::EventTime(from, to) => {
                let from = from.as_ref().map_or(Ok(0.0), |from| self.time_of(from))?;
                Ok(self.time_of(to)? - from)
            }
        }
    }

    pub(crate) fn time_of(&self, which: &Which) -> Result<f64, Unmet> {
        let motion = self.motion()?;
        match event(motion, which) {
            Some(index) => Ok(motion.events[index].time),
            None => because(format!("no such event among\n{}", listed(motion))),
        }
    }

    /// The state at an instant.
    pub(crate) fn state(&self, instant: &Instant) -> Result<State, Unmet> {
        let motion = self.motion()?;
        let end = |motion: &Simulation| {
            let last = motion.trajectory.time.last().copied();
            motion.at(last.unwrap_or_default())
        };
        let state = match instant {
            Instant::Start => {
                motion.at(motion.trajectory.time.first().copied().unwrap_or_default())
            }
            Instant::End | Instant::Always => end(motion),
            Instant::Before(which) => motion.just_before(self.time_of(which)?),
            Instant::After(which) => motion.at(self.time_of(which)?),
            Instant::Time(id) => {
                let time = own_end(self.prepared, instant).map_err(|why| (why, None))?;
                match (self.result, time) {
                    (Of::Run(method, runs), Some(_)) if method.locates() => {
                        let run = runs.until(time).as_ref();
                        end(run.map_err(|error| (error.clone(), None))?)
                    }
                    _ => motion.at(self.constant_of(*id)?),
                }
            }
        };
        state.map_err(|error| (error.to_string(), None))
    }

    pub(crate) fn fact(&self, name: &str) -> Result<f64, Unmet> {
        let known = match self.result {
            Of::Solution(solution) => of_solution(solution, name),
            Of::Run(..) => of_motion(self.motion()?, name),
        };
        match known {
            Some(value) => Ok(value),
            None => because(format!("the result has no `{name}`")),
        }
    }

    pub(crate) fn derivative(
        &self,
        of: &Left,
        by: &str,
        side: Option<Side>,
        instant: &Instant,
    ) -> Result<f64, Unmet> {
        let unmet = |why: String| (why, None);
        let runs = match self.result {
            Of::Run(_, runs) => runs,
            Of::Solution(solution) => return of_optimum(solution, of, by, side),
        };
        let end = own_end(self.prepared, instant).map_err(unmet)?;
        let both = match runs.gradients(end) {
            Some(both) => both.as_ref().map_err(|why| unmet(why.clone()))?,
            None => return because("it was not differentiated"),
        };
        let name = name_of(self.prepared, of, &runs.whole).map_err(unmet)?;
        let mut found = Vec::new();
        for gradient in both {
            let Some(column) = gradient
                .with_respect_to
                .iter()
                .position(|known| known == by)
            else {
                return because(format!("there are no derivatives by `{by}`"));
            };
            let rows = match (side, &gradient.one_sided) {
                (None, _) if gradient.obstacles[column].is_some() => {
                    return because(gradient.obstacles[column].clone().unwrap_or_default());
                }
                (None, _) => gradient.values.iter().map(|known| &known.1).collect(),
                (Some(side), Some(sides)) => rows_of(sides, side),
                (Some(_), None) => return because("it has derivatives to both sides"),
            };
            match gradient.values.iter().position(|known| known.0 == name) {
                Some(place) => found.push(rows.get(place).map_or(0.0, |row| row[column])),
                None => return because(format!("`{name}` was not differentiated")),
            }
        }
        let (forward, adjoint) = (found[0], found[1]);
        // Two ways to the same number, which round otherwise.
        let agree = (forward - adjoint).abs() <= 1e-9 * forward.abs().max(1.0);
        match agree || forward == adjoint {
            true => Ok(forward),
            false => because(format!("{forward:?} forwards and {adjoint:?} backwards")),
        }
    }

    /// Why there are no derivatives by a quantity, and how far it may go until the order of events is another.
    pub(crate) fn reach(&self, by: &str) -> Result<(&str, Option<&SequenceRange>), Unmet> {
        let (column, obstacles, ranges) = match self.result {
            Of::Run(_, runs) => match runs.gradients(None) {
                Some(Ok([of, _])) => (
                    of.with_respect_to.iter().position(|known| known == by),
                    &of.obstacles,
                    &of.ranges,
                ),
                Some(Err(error)) => return because(error.clone()),
                None => return because("it was not differentiated"),
            },
            Of::Solution(solution) => match &solution.gradient {
                Some(of) => (
                    of.names.iter().position(|known| *known == by),
                    &of.obstacles,
                    &of.ranges,
                ),
                None => return because("the optimum has no derivatives"),
            },
        };
        match column {
            Some(column) => {
                let obstacle = obstacles[column].as_deref().unwrap_or_default();
                Ok((obstacle, ranges.get(column)))
            }
            None => because(format!("there are no derivatives by `{by}`")),
        }
    }

    pub(crate) fn status_name(&self) -> &str {
        match self.result {
            Of::Run(_, runs) => runs
                .whole
                .as_ref()
                .map_or("refused", |run| run.status.name()),
            Of::Solution(solution) => solution.status.name(),
        }
    }

    pub(crate) fn status_shown(&self) -> String {
        match self.result {
            Of::Run(_, runs) => match &runs.whole {
                Ok(run) => run.status.to_string(),
                Err(error) => error.clone(),
            },
            Of::Solution(solution) => format!(
                "{}: {}",
                solution.status.name(),
                solution.diagnosis().unwrap_or_default()
            ),
        }
    }

    /// A text that the result has.
    pub(crate) fn text(&self, kind: TextKind) -> Result<String, Unmet> {
        Ok(match (kind, self.result) {
            (TextKind::Note, _) => self.motion()?.notes.join("\n"),
            (TextKind::Warning, _) => self.prepared.scene.warnings().to_owned(),
            (TextKind::Refusal, _) => return because("it was not refused"),
            (TextKind::Diagnosis, Of::Solution(solution)) => {
                solution.diagnosis().unwrap_or_default()
            }
            (TextKind::Diagnosis, Of::Run(..)) => {
                let diagnosis = self.motion()?.status.diagnosis();
                let contacts = self.motion()?.declaration.contacts;
                diagnosis.map_or_else(String::new, |known| match known.contact {
                    Some(contact) => format!("{} at {}", known.message, contacts[contact].name),
                    None => known.message.clone(),
                })
            }
        })
    }
}

/// The rows of chosen values to one side; none where all factors of roots are 0.
fn rows_of(sides: &OneSided, side: Side) -> Vec<&Vec<f64>> {
    let of = if side.above {
        &sides.above
    } else {
        &sides.below
    };
    match side.root {
        true => of.roots.iter().skip(of.q.len() + of.v.len()).collect(),
        false => of.values.iter().map(|known| &known.1).collect(),
    }
}

fn of_solution(solution: &Solution, name: &str) -> Option<f64> {
    if let Some(name) = name.strip_prefix("time_freezing.") {
        let program = solution.time_freezing.as_ref()?;
        return Some(match name {
            "objective" => program.objective,
            "error" => {
                let apart = (program.objective - solution.objective).abs();
                apart / solution.objective.abs().max(1.0)
            }
            "residuals.primal" => program.residuals.primal,
            "residuals.complementarity" => program.residuals.complementarity,
            "left_out" => program.left_out.len() as f64,
            _ => return None,
        });
    }
    Some(match name {
        "objective" => solution.objective,
        "final_time" => solution.horizon,
        "resimulation_error" => solution.resimulation_error,
        "resimulated_objective" => solution.resimulated_objective,
        "least_time" => return solution.least_time,
        "residuals.primal" => solution.residuals.primal,
        "residuals.complementarity" => solution.residuals.complementarity,
        "starts" => solution.starts as f64,
        "bound" => return solution.bound,
        "counts.programs" => solution.counts.programs as f64,
        "counts.iterations" => solution.counts.iterations as f64,
        "counts.contact_implicit" => solution.counts.global_iterations as f64,
        // Largest violation between the places where conditions are imposed.
        "excess" => {
            let amounts = solution.excess.iter().map(|excess| excess.amount);
            amounts.fold(0.0, f64::max)
        }
        "shortest_time" => solution.final_times.0,
        "longest_time" => solution.final_times.1,
        "objective_error" => solution.resimulated_objective - solution.objective,
        "counts.margins" => solution.margins.len() as f64,
        // What the distances that the method keeps cost together.
        "margins" => solution.margins.iter().map(|margin| margin.cost).sum(),
        "size.variables" => solution.size.variables as f64,
        _ => return None,
    })
}

fn of_motion(run: &Simulation, name: &str) -> Option<f64> {
    Some(match name {
        "final_time" => *run.trajectory.time.last()?,
        "numerical_time" => *run.trajectory.numerical_time.last()?,
        "error_estimate" => return run.error_estimate,
        "residuals.primal" => run.residuals.primal,
        "residuals.dual" => run.residuals.dual,
        "residuals.complementarity" => run.residuals.complementarity,
        "counts.elements" => run.counts.elements as f64,
        "counts.events" => run.counts.events as f64,
        "counts.evaluations" => run.counts.evaluations as f64,
        "counts.factorizations" => run.counts.factorizations as f64,
        "counts.newton" => run.counts.newton as f64,
        _ => return None,
    })
}

/// A derivative of an optimum.
fn of_optimum(solution: &Solution, of: &Left, by: &str, side: Option<Side>) -> Result<f64, Unmet> {
    let Some(gradient) = &solution.gradient else {
        return because("the optimum has no derivatives");
    };
    let Some(column) = gradient.names.iter().position(|known| *known == by) else {
        return because(format!("there are no derivatives by `{by}`"));
    };
    if let Some(side) = side {
        let place = usize::from(side.above);
        return match (of, &gradient.sides[column]) {
            (Left::Fact(name), Some(sides)) if name == "objective" => Ok(sides.objective[place]),
            (_, Some(sides)) => Ok(sides.final_time.map_or(f64::NAN, |both| both[place])),
            (_, None) => because("it has derivatives to both sides"),
        };
    }
    match of {
        Left::Fact(name) if name == "objective" => Ok(gradient.objective[column]),
        Left::Fact(name) if name == "final_time" => match gradient.final_time[column] {
            Some(value) => Ok(value),
            None => because("the final time is open"),
        },
        _ => because("of an optimum `objective` and `final_time` are differentiated"),
    }
}

/// The events of a motion, and its status, a line each.
pub(crate) fn listed(motion: &Simulation) -> String {
    let events = motion.events.iter().map(|event| {
        format!(
            "{} {} at {:?}\n",
            event.kind.name(),
            event.contact_name,
            event.time
        )
    });
    events.chain([motion.status.to_string()]).collect()
}
