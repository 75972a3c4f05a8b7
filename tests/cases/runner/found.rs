//! What a result holds: numbers, states and texts of one run.

use crate::prepared::{Prepared, output};
use crate::run::{Of, Outcome, event, is_one, name_of, own_end};
use crate::statement::{Expectation, Instant, Left, Side, Text, Which};
use hangtime::derivative::{OneSided, SequenceLimit, SequenceRange};
use hangtime::ocp::{OptimumGradient, Solution};
use hangtime::prelude::*;
use hangtime_units::Unit;

pub(crate) fn because<T>(why: impl Into<String>) -> Result<T, String> {
    Err(why.into())
}

/// One result, with what is needed to compare it.
#[derive(Clone, Copy)]
pub(crate) struct Found<'a> {
    pub(crate) prepared: &'a Prepared,
    pub(crate) expectation: &'a Expectation,
    pub(crate) outcome: &'a Outcome,
    pub(crate) theirs: Option<&'a Outcome>,
}

impl<'a> Found<'a> {
    /// The run itself; of a refused one the words.
    pub(crate) fn whole(&self) -> Result<&'a Of, String> {
        self.outcome.whole.as_ref().map_err(Clone::clone)
    }

    /// The whole motion.
    pub(crate) fn motion(&self) -> Result<&'a Simulation, String> {
        let motion = self.whole()?.motion();
        Ok(motion.ok_or("there is no motion")?)
    }

    /// What the scene gave that this one is compared with.
    pub(crate) fn theirs(&self) -> Result<Self, String> {
        let words = "there is no scene to compare with; a fence `hang like` has one";
        let outcome = self.theirs.ok_or(words)?;
        Ok(Self { outcome, ..*self })
    }

    /// The number on the left.
    pub(crate) fn number(&self, left: &Left, instant: &Instant) -> Result<f64, String> {
        let recorded = |name: &str, shown: &str| {
            let value = self.state(instant)?.get(name);
            value.ok_or_else(|| format!("`{shown}` is not recorded"))
        };
        match left {
            Left::Expression(id, text) => {
                if let Of::Optimum(solution) = self.whole()?
                    && let Some(known) = solution.parameters.iter().find(|p| p.name == text)
                {
                    let unit = known.unit.parse::<Unit>().map_or(1.0, |unit| unit.scale);
                    return Ok(known.value * unit);
                }
                recorded(&output(*id), text)
            }
            Left::Named(name) => recorded(name, name),
            Left::Fact(name) => self.fact(name),
            Left::Count(which) => {
                let events = self.motion()?.events.iter();
                Ok(events.filter(|event| is_one(event, which)).count() as f64)
            }
            Left::Derivative(of, by, side) => match self.whole()? {
                Of::Motion(_) => self.derivative(of, by, *side, instant),
                Of::Optimum(solution) => of_optimum(solution, of, by, *side),
            },
            Left::EventTime(from, to) => {
                let from = from.as_ref().map_or(Ok(0.0), |from| self.time_of(from))?;
                Ok(self.time_of(to)? - from)
            }
            Left::Limit(text) => match self.limit(text)? {
                Some(limit) => Ok(limit.change),
                None => because("nothing ends it"),
            },
        }
    }

    fn time_of(&self, which: &Which) -> Result<f64, String> {
        let motion = self.motion()?;
        let index = event(motion, which).ok_or("there is no such event")?;
        Ok(motion.events[index].time)
    }

    /// The state at an instant.
    fn state(&self, instant: &Instant) -> Result<State, String> {
        let mut motion = self.motion()?;
        let state = match instant {
            Instant::Start => motion.at(motion.trajectory.time.first().copied().unwrap_or(0.0)),
            Instant::Before(which) => motion.just_before(self.time_of(which)?),
            Instant::After(which) => motion.at(self.time_of(which)?),
            Instant::End | Instant::Always | Instant::Time(_) => {
                let time = own_end(self.prepared, instant)?;
                let ended = time.and_then(|time| self.outcome.until.get(&time.to_bits()));
                if let Some(ended) = ended {
                    motion = ended.as_ref().map_err(Clone::clone)?;
                }
                let last = motion.trajectory.time.last().copied();
                let within = time.filter(|_| ended.is_none());
                motion.at(within.or(last).unwrap_or_default())
            }
        };
        state.map_err(|error| error.to_string())
    }

    pub(crate) fn fact(&self, name: &str) -> Result<f64, String> {
        let value = match self.whole()? {
            Of::Motion(run) => of_name(OF_MOTION, name, run),
            Of::Optimum(found) => of_name(OF_OPTIMUM, name, found),
        };
        value.ok_or_else(|| format!("the result has no `{name}`"))
    }

    fn derivative(
        &self,
        of: &Left,
        by: &str,
        side: Option<Side>,
        instant: &Instant,
    ) -> Result<f64, String> {
        let end = own_end(self.prepared, instant)?;
        let both = self.outcome.gradients.get(&end.map(f64::to_bits));
        let both = both.ok_or("it was not differentiated")?;
        let name = name_of(self.prepared, of, self.outcome)?;
        let mut found = Vec::new();
        for gradient in both.as_ref().map_err(Clone::clone)? {
            let column = column(&gradient.with_respect_to, by)?;
            let rows = match (side, &gradient.one_sided) {
                (None, _) => {
                    obstructed(&gradient.obstacles[column])?;
                    gradient.values.iter().map(|known| &known.1).collect()
                }
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
    fn reach(&self, by: &str) -> Result<(&'a str, Option<&'a SequenceRange>), String> {
        let (column, obstacles, ranges) = match self.whole()? {
            Of::Motion(_) => {
                let both = self.outcome.gradients.get(&None);
                let both = both.ok_or("it was not differentiated")?;
                let [of, _] = both.as_ref().map_err(Clone::clone)?;
                (column(&of.with_respect_to, by)?, &of.obstacles, &of.ranges)
            }
            Of::Optimum(solution) => {
                let of = differentiated(solution)?;
                (column(&of.names, by)?, &of.obstacles, &of.ranges)
            }
        };
        let obstacle = obstacles[column].as_deref().unwrap_or_default();
        Ok((obstacle, ranges.get(column)))
    }

    fn limit(&self, text: &Text) -> Result<Option<&'a SequenceLimit>, String> {
        let range = self.reach(&text.of)?.1;
        let range = range.ok_or("there are no ranges")?;
        Ok(match text.kind {
            "limit above" => range.above.as_ref(),
            _ => range.below.as_ref(),
        })
    }

    /// A text that the result has.
    pub(crate) fn text(&self, text: &Text) -> Result<String, String> {
        if text.kind == "refusal" {
            let refusal = self.outcome.whole.as_ref().err().cloned();
            return Ok(refusal.ok_or("it was not refused")?);
        }
        let whole = self.whole()?;
        Ok(match (text.kind, whole) {
            ("note", _) => self.motion()?.notes.join("\n"),
            ("warning", _) => self.prepared.scene.warnings().to_owned(),
            ("obstacle", _) => self.reach(&text.of)?.0.to_owned(),
            ("status", Of::Motion(run)) => run.status.name().to_owned(),
            ("status", Of::Optimum(found)) => found.status.name().to_owned(),
            ("certificate", Of::Optimum(found)) => found.stationarity.name().to_owned(),
            ("diagnosis", Of::Optimum(found)) => found.diagnosis().unwrap_or_default(),
            ("diagnosis", Of::Motion(run)) => {
                let contacts = run.declaration.contacts;
                let known = run.status.diagnosis();
                known.map_or_else(String::new, |known| match known.contact {
                    Some(contact) => format!("{} at {}", known.message, contacts[contact].name),
                    None => known.message.clone(),
                })
            }
            ("certificate", _) => return because("only optima have a certificate"),
            _ => self
                .limit(text)?
                .map_or_else(String::new, |limit| limit.because.clone()),
        })
    }

    /// The events of its motion, and its status, a line each.
    pub(crate) fn listed(&self) -> String {
        let Ok(whole) = self.whole() else {
            return String::new();
        };
        let events = whole
            .motion()
            .map_or(&[][..], |motion| &motion.events)
            .iter();
        let events = events.map(|event| {
            let kind = event.kind.name();
            format!("\n{kind} {} at {:?}", event.contact_name, event.time)
        });
        let status = match whole {
            Of::Motion(run) => run.status.to_string(),
            Of::Optimum(found) => found.to_string(),
        };
        events.chain(["\n".to_owned(), status]).collect()
    }
}

fn column(names: &[impl AsRef<str>], by: &str) -> Result<usize, String> {
    let column = names.iter().position(|known| known.as_ref() == by);
    column.ok_or_else(|| format!("there are no derivatives by `{by}`"))
}

fn obstructed(obstacle: &Option<String>) -> Result<(), String> {
    obstacle.as_ref().map_or(Ok(()), because)
}

/// The rows of chosen values to one side; none where all factors of roots are 0.
fn rows_of(sides: &OneSided, side: Side) -> Vec<&Vec<f64>> {
    let of = match side.above {
        true => &sides.above,
        false => &sides.below,
    };
    match side.root {
        true => of.roots.iter().skip(of.q.len() + of.v.len()).collect(),
        false => of.values.iter().map(|known| &known.1).collect(),
    }
}

/// Numbers of a result by their names.
type Facts<T> = &'static [(&'static str, fn(&T) -> Option<f64>)];

macro_rules! facts {
    ($name:ident of $found:ident: $of:ty, $($fact:literal: $value:expr;)*) => {
        const $name: Facts<$of> = &[$(($fact, |$found| $value.into())),*];
    };
}

facts! { OF_MOTION of run: Simulation,
    "final_time": run.trajectory.time.last().copied();
    "numerical_time": run.trajectory.numerical_time.last().copied();
    "error_estimate": run.error_estimate;
    "diagnosed_at": run.status.diagnosis().map(|known| known.time);
    "residuals.primal": run.residuals.primal;
    "residuals.dual": run.residuals.dual;
    "residuals.complementarity": run.residuals.complementarity;
    "counts.elements": run.counts.elements as f64;
    "counts.events": run.counts.events as f64;
    "counts.evaluations": run.counts.evaluations as f64;
    "counts.newton": run.counts.newton as f64;
}

facts! { OF_OPTIMUM of found: Solution,
    "objective": found.objective;
    "final_time": found.horizon;
    "bound": found.bound;
    "least_time": found.least_time;
    "shortest_time": found.final_times.0;
    "longest_time": found.final_times.1;
    "starts": found.starts as f64;
    "size.variables": found.size.variables as f64;
    "resimulation_error": found.resimulation_error;
    "resimulated_objective": found.resimulated_objective;
    "objective_error": found.resimulated_objective - found.objective;
    "residuals.primal": found.residuals.primal;
    "residuals.complementarity": found.residuals.complementarity;
    "counts.programs": found.counts.programs as f64;
    "counts.iterations": found.counts.iterations as f64;
    "counts.contact_implicit": found.counts.global_iterations as f64;
    "counts.margins": found.margins.len() as f64;
    // What the distances that the method keeps cost together.
    "margins": found.margins.iter().map(|margin| margin.cost).sum::<f64>();
    // Largest violation between the places where conditions are imposed.
    "excess": found.excess.iter().map(|excess| excess.amount).fold(0.0, f64::max);
    "time_freezing.objective": found.time_freezing.as_ref()?.objective;
    "time_freezing.error": {
        let apart = found.time_freezing.as_ref()?.objective - found.objective;
        apart.abs() / found.objective.abs().max(1.0)
    };
    "time_freezing.led_to_motion": f64::from(u8::from(found.time_freezing.as_ref()?.relaxed.led_to_motion));
    "time_freezing.residuals.primal": found.time_freezing.as_ref()?.residuals.primal;
    "time_freezing.residuals.complementarity": found.time_freezing.as_ref()?.residuals.complementarity;
    "time_freezing.left_out": found.time_freezing.as_ref()?.left_out.len() as f64;
}

fn of_name<T>(facts: Facts<T>, name: &str, found: &T) -> Option<f64> {
    facts.iter().find(|known| known.0 == name)?.1(found)
}

/// The number of a result that has this name.
pub(crate) fn fact(name: &str) -> Option<&'static str> {
    let names = OF_OPTIMUM.iter().map(|known| known.0);
    let mut names = names.chain(OF_MOTION.iter().map(|known| known.0));
    names.find(|known| *known == name)
}

fn differentiated(solution: &Solution) -> Result<&OptimumGradient, String> {
    let gradient = solution.gradient.as_ref();
    Ok(gradient.ok_or("the optimum has no derivatives")?)
}

/// A derivative of an optimum.
fn of_optimum(solution: &Solution, of: &Left, by: &str, side: Option<Side>) -> Result<f64, String> {
    let gradient = differentiated(solution)?;
    let column = column(&gradient.names, by)?;
    let is_objective = match of {
        Left::Fact("objective") => true,
        Left::Fact("final_time") => false,
        _ => return because("of an optimum `objective` and `final_time` are differentiated"),
    };
    let open = "the final time is open";
    match (side, &gradient.sides[column]) {
        (None, _) if is_objective => Ok(gradient.objective[column]),
        (None, _) => Ok(gradient.final_time[column].ok_or(open)?),
        (Some(side), Some(sides)) => {
            let both = match is_objective {
                true => Some(sides.objective),
                false => sides.final_time,
            };
            Ok(both.ok_or(open)?[usize::from(side.above)])
        }
        (Some(_), None) => because("it has derivatives to both sides"),
    }
}
