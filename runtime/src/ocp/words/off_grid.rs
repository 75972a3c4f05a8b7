//! The program of a word: phases of free length with a few control pieces in each.

use super::word::{Draft, Word};
use crate::ocp::collocation::discretization::{Lengths, Setting, Span};
use crate::ocp::collocation::layout::Phase;
use crate::ocp::collocation::program::Collocation;
use crate::ocp::collocation::transcribe::transcribe;
use crate::ocp::motion::control_grid::{ControlGrid, ControlShape};
use crate::ocp::motion::final_times::FinalTimes;
use crate::ocp::motion::sequence::Sequence;
use crate::ocp::motion::targets::goal_values;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::{Horizon, Problem};
use crate::ocp::program::runner::{Run, Runner};
use crate::ocp::scale::Scale;
use crate::ocp::search::attempt::interior_point;
use crate::ocp::search::sampled::Sampled;
use crate::ocp::tuning::edits::VANISHED;
use crate::ocp::tuning::equal::MET;
use crate::ocp::tuning::off_grid::{
    BARRIER, ELEMENTS, ITERATIONS, LEAST, LEAST_SHARE, LONGEST, MOVES, PRICE, RESTORED, ROUNDED,
    TOLERANCE,
};
use crate::ocp::tuning::table::WORTH_OF_PHASE;
use crate::rk::ButcherTableau;
use crate::simulation::ContactMode;
use hangtime_solver::nlp;

/// How finely a word is stated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fineness {
    /// Control pieces of the motion, and the least number of them in a phase.
    pub(super) pieces: usize,
    pub(super) least: usize,
    /// Whether each of them has a length of its own.
    pub(super) free: bool,
}

/// What a miss of the goals costs.
#[derive(Debug, Clone)]
pub(in crate::ocp) struct Goals {
    /// Their sizes: what most random motions miss less.
    pub(super) sizes: Vec<f64>,
    /// Objective per size; set by the first program if it is not known.
    pub(super) price: Option<f64>,
    /// Size of the objective, to which programs are solved, whatever a miss costs: that of the best word that meets its goals; until there is
    /// one, and from the first program on, that of the first price.
    pub(super) size: Option<f64>,
}

impl Goals {
    /// Those of a problem of which so many motions are known.
    pub(super) fn of(setting: Setting, sampled: &Sampled) -> Self {
        Self {
            sizes: sizes(setting, &sampled.units),
            price: (sampled.cost > 0.0).then(|| Self::price_of(sampled.cost)),
            size: None,
        }
    }

    /// The price of a miss where objectives are of that size.
    pub(super) fn price_of(objective: f64) -> f64 {
        PRICE * objective
    }

    /// The same goals at another price.
    pub(super) fn at(&self, price: f64) -> Self {
        Self {
            price: Some(price),
            ..self.clone()
        }
    }

    /// Sets what is not known yet by the size of an objective from its derivatives: motions that cost nothing say nothing about a price.
    fn begin_at(&mut self, size: f64) {
        if self.size.is_none() {
            let known = self.price.unwrap_or(Self::price_of(size));
            let price = known.max(Self::price_of(LEAST_SHARE * size));
            (self.price, self.size) = (Some(price), Some(price / PRICE));
        }
    }
}

/// Sizes of the goals: what most random motions miss less, or else the start does.
fn sizes(setting: Setting, units: &[f64]) -> Vec<f64> {
    let mut z = setting.problem.start();
    z.push(setting.units.time);
    let values = goal_values(setting.model, &z).into_iter().enumerate();
    let sizes = values.map(|(goal, value)| {
        let drawn = units.get(goal).copied().unwrap_or(0.0);
        let all = [drawn, value.abs(), 1.0];
        all.into_iter()
            .find(|size| *size > 0.0 && size.is_finite())
            .unwrap_or(1.0)
    });
    sizes.collect()
}

/// What a solution presses against in a phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pressed {
    /// A gap that must not close further.
    Gap,
    /// A force that must not pull.
    Force,
    /// An edge of a friction cone, or a sliding velocity that must not turn round.
    Friction,
}

/// Where a solution presses: the share of all multipliers, and the time of the largest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Press {
    pub(super) phase: usize,
    pub(super) contact: usize,
    pub(super) against: Pressed,
    pub(super) share: f64,
    pub(super) time: f64,
}

/// A word whose program is solved.
#[derive(Debug, Clone)]
pub(in crate::ocp) struct Timed {
    pub(super) draft: Draft,
    pub(super) motion: Trajectory,
    pub(super) objective: f64,
    /// Objective and price of what is missed.
    pub(in crate::ocp) merit: f64,
    /// By how much goals are missed, in their sizes.
    pub(super) missed: f64,
    /// The price at which they are.
    pub(super) price: f64,
    pub(super) presses: Vec<Press>,
}

/// The spans of the phases of a draft, and the control intervals of each phase. An element after a landing holds all bounces until its
/// contact rests, however long these take: so it is a span of its own.
fn spans(draft: &Draft, setting: Setting, fineness: Fineness) -> (Vec<Span>, Vec<usize>) {
    let pieces = |_, share: f64| {
        let pieces = (fineness.pieces as f64 * share).round() as usize;
        fineness.least.max(pieces)
    };
    let mut spans = spans_with(draft, setting.problem, pieces);
    let total: f64 = spans.iter().map(|span| span.to - span.from).sum();
    for span in &mut spans {
        let piece = (span.to - span.from) / (total * span.pieces as f64);
        span.elements = ((ELEMENTS * piece - ROUNDED).ceil() as usize).max(1);
        span.free = fineness.free;
        span.longest = span
            .free
            .then_some(LONGEST * span.elements as f64 / ELEMENTS);
    }
    let (mut parts, mut counts) = (Vec::new(), Vec::new());
    for (phase, span) in spans.into_iter().enumerate() {
        let settles = draft.word.settles(setting.model, phase);
        counts.push(span.pieces + usize::from(settles));
        match settles {
            true => parts.extend(halves(span)),
            false => parts.push(span),
        }
    }
    (parts, counts)
}

/// A span after one of half its length that is a single element.
fn halves(span: Span) -> [Span; 2] {
    let half = Span {
        duration: 0.5 * span.duration,
        ..span
    };
    let middle = 0.5 * (span.from + span.to);
    let first = Span {
        pieces: 1,
        elements: 1,
        longest: None,
        to: middle,
        ..half
    };
    [
        first,
        Span {
            from: middle,
            ..half
        },
    ]
}

/// The spans of the phases of a draft with so many control intervals by index and share of the motion, of equal length in a phase, of one
/// finite element.
pub(super) fn spans_with(
    draft: &Draft,
    problem: &Problem,
    pieces: impl Fn(usize, f64) -> usize,
) -> Vec<Span> {
    let phases = draft.phases();
    let total: f64 = phases.iter().map(|(from, to)| to - from).sum();
    let stretch = match problem.horizon {
        Horizon::Fixed(horizon) => horizon / total,
        Horizon::Free { .. } => 1.0,
    };
    let mut begin = 0.0;
    let spans = phases.into_iter().enumerate().map(|(index, (_, to))| {
        let from = begin;
        let to = to.max(from + LEAST * total);
        begin = to;
        Span {
            pieces: pieces(index, (to - from) / total),
            free: false,
            from,
            to,
            duration: stretch * (to - from),
            longest: None,
            elements: 1,
        }
    });
    spans.collect()
}

/// Solves the program of a draft from a motion, and again from where it ends where that is an end of the final times that it looks at;
/// `None` where it has no order or no solution. What misses its goals does so in a shorter time as well.
pub(super) fn solve(
    runner: &mut Runner,
    setting: Setting,
    with: (&ButcherTableau, Fineness),
    from: (&Draft, &Trajectory),
    goals: &mut Goals,
) -> Option<Timed> {
    let mut looked_at = FinalTimes::around(setting.problem, from.1.horizon);
    let mut found = solve_around(runner, setting, with, from, goals)?;
    for _ in 0..MOVES {
        let centre = found.motion.horizon;
        let end = looked_at.end_at(centre);
        let moves = end.is_some_and(|end| found.meets() || end > looked_at.shortest);
        if !moves || runner.stopped() {
            break;
        }
        looked_at = FinalTimes::around(setting.problem, centre);
        let from = (&found.draft, &found.motion);
        let Some(moved) = solve_around(runner, setting, with, from, goals) else {
            break;
        };
        found = moved;
    }
    Some(found)
}

/// Solves the program of a draft with final times around that of the motion.
pub(super) fn solve_around(
    runner: &mut Runner,
    setting: Setting,
    (tableau, fineness): (&ButcherTableau, Fineness),
    (draft, motion): (&Draft, &Trajectory),
    goals: &mut Goals,
) -> Option<Timed> {
    let (spans, counts) = spans(draft, setting, fineness);
    let sequence = draft.word.sequence(&counts)?;
    let problem = Problem {
        intervals: counts.iter().sum(),
        ..setting.problem.clone()
    };
    let sizes = goals.sizes.clone();
    let scale = Scale::of(setting.model, setting.problem);
    let units = setting
        .units
        .of_motion(setting.model, &scale, motion, setting.bounds);
    let program_setting = Setting {
        problem: &problem,
        tableau,
        units: &units,
        shape: ControlShape::Constant,
        lengths: Lengths::Phases(&spans),
        elastic: Some(&sizes),
        ..setting
    };
    let (guess, elements) = begun(&spans, motion);
    let from = (&sequence, &guess, &elements[..]);
    let (program, solution) = solved(runner, program_setting, from, goals, (BARRIER, ITERATIONS))?;
    Some(read(&program, &solution, (draft, &counts)))
}

/// A motion to start from with these spans, driven as that one, and the finite elements of each interval.
pub(super) fn begun(spans: &[Span], motion: &Trajectory) -> (Trajectory, Vec<usize>) {
    let pieces = spans.iter().flat_map(|span| {
        let end = |j: usize| span.from + (span.to - span.from) * j as f64 / span.pieces as f64;
        (0..span.pieces).map(move |j| (end(j), end(j + 1)))
    });
    let controls = pieces.map(|(from, to)| motion.controls_between(from, to));
    let guess = Trajectory {
        horizon: spans.iter().map(|span| span.duration).sum(),
        controls: ControlGrid::constant(controls.collect()),
        ..motion.clone()
    };
    let elements = spans
        .iter()
        .flat_map(|span| std::iter::repeat_n(span.elements, span.pieces));
    (guess, elements.collect())
}

/// The program of a sequence and its solution with goals that are missed where that is worth its price; once more from where it ends where
/// joints decide what they hardly determine there.
pub(super) fn solved<'a>(
    runner: &mut Runner,
    setting: Setting<'a>,
    (sequence, guess, elements): (&Sequence, &Trajectory, &[usize]),
    goals: &mut Goals,
    with: (f64, usize),
) -> Option<(Collocation<'a>, nlp::Solution)> {
    let mut from = (guess.clone(), sequence.clone());
    for _ in 0..=MOVES {
        let mut program = transcribe(setting, &from.1, &from.0, &[], elements);
        goals.begin_at(program.program.objective_size);
        let solution = at_price(runner, &mut program, goals, with)?;
        if !program.is_singular(&solution.x) {
            return Some((program, solution));
        }
        from = program.result(&solution.x);
    }
    None
}

/// The solution at the price of the goals; without one none.
fn at_price(
    runner: &mut Runner,
    program: &mut Collocation,
    goals: &Goals,
    (barrier, iterations): (f64, usize),
) -> Option<nlp::Solution> {
    let price = goals.price?;
    let mut settings = interior_point(runner.settings);
    // Products of bounds and multipliers are measured in the unit of the objective, which is that of the largest control that is allowed.
    let size = goals.size.unwrap_or(price / PRICE);
    let small = (size / program.program.objective_unit).clamp(LEAST_SHARE, 1.0);
    settings.tolerance = small * TOLERANCE;
    settings.constraint_tolerance = TOLERANCE;
    settings.initial_barrier_parameter = small * barrier;
    settings.maximum_iterations = iterations;
    // A motion that is near its solution stays there.
    settings.bound_push = barrier;
    settings.bound_fraction = barrier;
    program.penalize(price);
    let run = Run {
        settings: &settings,
        start: None,
        restores: RESTORED,
        best: None,
    };
    let failure = runner.take_failure();
    let solution = runner.solve(&mut program.program, &run);
    runner.restore_failure(failure, true);
    solution.ok()
}

/// A solved program as a word with its times.
pub(super) fn read(
    program: &Collocation,
    solution: &nlp::Solution,
    (draft, counts): (&Draft, &[usize]),
) -> Timed {
    let (trajectory, _) = program.result(&solution.x);
    let solved = program.solved(&solution.x);
    let nodes = trajectory.controls.times(trajectory.horizon);
    let mut first = 0;
    let ends = counts.iter().map(|count| {
        first += count;
        nodes[first]
    });
    let times: Vec<f64> = ends.take(draft.word.instants.len()).collect();
    let missed = program.missed(&solution.x);
    let begins = solved
        .iter()
        .map(|phase| (phase.start, phase.length))
        .collect::<Vec<_>>();
    Timed {
        draft: Draft {
            word: draft.word.clone(),
            times,
            horizon: trajectory.horizon,
        },
        objective: solution.objective - missed * program.price(),
        merit: solution.objective,
        missed,
        price: program.price(),
        presses: presses(program, solution, counts, &begins),
        motion: trajectory,
    }
}

/// What the solution presses against, the hardest first.
fn presses(
    program: &Collocation,
    solution: &nlp::Solution,
    counts: &[usize],
    begins: &[(f64, f64)],
) -> Vec<Press> {
    let mut found: Vec<(Press, f64)> = Vec::new();
    let phase_of = |interval: usize| {
        let mut end = 0;
        counts.iter().position(|count| {
            end += count;
            interval < end
        })
    };
    for (phase, &(start, length)) in program.phases.iter().zip(begins) {
        let Some(word_phase) = phase_of(phase.interval) else {
            continue;
        };
        for (node, contact, against, weight) in pressing(program, phase, solution) {
            let time = start + node * length;
            let same = |(press, _): &&mut (Press, f64)| {
                (press.phase, press.contact, press.against) == (word_phase, contact, against)
            };
            match found.iter_mut().find(same) {
                Some((press, largest)) => {
                    press.share += weight;
                    if weight > *largest {
                        (press.time, *largest) = (time, weight);
                    }
                }
                None => found.push((
                    Press {
                        phase: word_phase,
                        contact,
                        against,
                        share: weight,
                        time,
                    },
                    weight,
                )),
            }
        }
    }
    let total: f64 = found.iter().map(|(press, _)| press.share).sum();
    let mut presses: Vec<Press> = found.into_iter().map(|(press, _)| press).collect();
    for press in &mut presses {
        press.share /= total.max(f64::MIN_POSITIVE);
    }
    presses.sort_by(|a, b| b.share.total_cmp(&a.share));
    presses
}

/// Multipliers of the conditions of an element: node, contact, what they are of, and their size.
fn pressing(
    program: &Collocation,
    phase: &Phase,
    solution: &nlp::Solution,
) -> Vec<(f64, usize, Pressed, f64)> {
    let mut found = Vec::new();
    let row = |row: usize| solution.multipliers[row].abs();
    for (stage, &node) in phase.stages.iter().zip(program.tableau.c()) {
        let gaps = stage.gap_rows.iter().enumerate();
        for (contact, gap) in gaps.filter(|(contact, _)| !phase.closed.contains(contact)) {
            let ends = phase.closing.contains(&contact) && node == 1.0;
            if let Some(gap) = gap.filter(|_| !ends) {
                found.push((node, contact, Pressed::Gap, row(gap)));
            }
        }
        for (&contact, &force) in phase.closed.iter().zip(&stage.forces) {
            let weight = solution.multipliers_lower[force];
            found.push((node, contact, Pressed::Force, weight));
        }
        for tangential in &stage.tangential {
            let weight = tangential.rows.iter().map(|&(_, edge)| row(edge)).sum();
            found.push((node, tangential.contact, Pressed::Friction, weight));
        }
    }
    let between = phase.between.iter();
    found.extend(between.map(|&(theta, i, _, cut)| (theta, i, Pressed::Friction, row(cut))));
    found
}

impl Timed {
    pub(super) fn word(&self) -> &Word {
        &self.draft.word
    }

    /// What words are compared by, where objectives are of that size: with more phases there are more control pieces, which are worth a
    /// little by themselves.
    pub(super) fn value(&self, size: f64) -> f64 {
        self.merit + WORTH_OF_PHASE * size * self.word().phases() as f64
    }

    pub(in crate::ocp) fn phases(&self) -> usize {
        self.word().phases()
    }

    pub(in crate::ocp) fn trajectory(&self) -> &Trajectory {
        &self.motion
    }

    /// Whether it meets its goals.
    pub(in crate::ocp) fn meets(&self) -> bool {
        self.missed <= MET
    }

    /// The same with a miss at that price, or at the one that it is worth where that is dearer: what is missed at a dear price is so at a lower
    /// one, whatever that leaves of the objective.
    pub(super) fn set_price(&mut self, price: f64) {
        let price = if self.meets() {
            price
        } else {
            price.max(self.price)
        };
        self.merit = self.objective + price * self.missed;
    }

    /// The modes of the phases that last.
    pub(super) fn lasting(&self) -> Vec<Vec<ContactMode>> {
        let modes = self.word().modes().into_iter();
        let phases = modes.zip(self.draft.phases());
        let least = VANISHED * self.draft.horizon;
        phases
            .filter(|(_, (from, to))| to - from >= least)
            .map(|(modes, _)| modes)
            .collect()
    }
}
