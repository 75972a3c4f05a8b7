//! How far two runs of one motion are apart, and what follows from it.

use super::{
    Counts, Diagnosis, Event, EventKind, InitialValueProblem, Simulation, SimulationStatus,
};
use crate::model::{ImpactLaw, Model};
use crate::yardstick;

/// Share of the velocities at its ends by which a flight may be wrong in all runs alike: the rounding of a sum with the weights of Dormand
/// and Prince, whose sizes sum up to 13.
const OF_FLIGHT: f64 = 13.0 * f64::EPSILON;

/// What tells of an error.
#[derive(Debug, Clone, Copy, PartialEq)]
enum By {
    /// The difference of two runs.
    Runs,
    /// The errors of the steps of one.
    Steps,
    /// Rounding of the flights of one, which smaller steps leave as it is.
    Flights,
}

/// How far two runs to the same horizon are apart.
pub(super) struct Comparison {
    /// Largest difference at their ends and events, as a share of the largest values, or what the finer one knows of its
    /// steps or its flights if that is more; infinite where one has no end.
    pub(super) error: f64,
    /// What tells of the error.
    by: By,
    /// Time up to which they have the same events at the same places, to the share that is promised \[s\].
    pub(super) until: f64,
}

impl Comparison {
    /// Compares a run with a coarser one; its `error_estimate` becomes how far they are apart, unless it is more. What both runs
    /// do wrong alike, such as damping an oscillation to rest, only the errors of the steps know.
    pub(super) fn of(
        coarser: &Simulation,
        finer: &mut Simulation,
        (model, problem): (&dyn Model, &InitialValueProblem),
        promise: f64,
    ) -> Self {
        let sizes = Sizes::of(finer, model, problem);
        let known = [
            (difference(coarser, finer, &sizes), By::Runs),
            (finer.error_estimate.unwrap_or(0.0), By::Steps),
            (of_flights(finer, model, &sizes), By::Flights),
        ];
        let [first, others @ ..] = known;
        let larger =
            |most: (f64, By), other: (f64, By)| if other.0 > most.0 { other } else { most };
        let (error, by) = others.into_iter().fold(first, larger);
        finer.error_estimate = Some(error);
        Self {
            error,
            by,
            until: agreed_until(coarser, finer, &sizes, promise),
        }
    }

    /// The difference, unless the finer run knows of a larger error.
    pub(super) fn apart(&self) -> Option<f64> {
        (self.by == By::Runs).then_some(self.error)
    }

    /// Whether smaller steps leave the error as it is.
    pub(super) fn stays(&self) -> bool {
        self.by == By::Flights
    }

    /// The error in words.
    pub(super) fn words(&self) -> String {
        let error = format!("{:.1e} of the largest values", self.error);
        match self.by {
            By::Runs => format!("differ by {error} at the end"),
            By::Steps => format!("the errors of their steps sum up to {error}"),
            By::Flights => format!("rounding of their flights sums up to {error}"),
        }
    }

    /// The status of a run that differs by more than is promised.
    pub(super) fn inaccurate(&self, message: String) -> SimulationStatus {
        SimulationStatus::Inaccurate(Diagnosis {
            time: self.until,
            step: 0,
            contact: None,
            message,
        })
    }
}

/// The largest of these `errors` of the coordinates and then of the velocities, as a share of the largest values of the run;
/// infinite where one is no number.
pub(super) fn share(
    run: &Simulation,
    (model, problem): (&dyn Model, &InitialValueProblem),
    errors: &[f64],
) -> f64 {
    let sizes = Sizes::of(run, model, problem);
    let sizes = sizes.way.iter().chain(&sizes.speed);
    let pairs = errors.iter().zip(sizes);
    pairs.fold(0.0, |most, (error, &size)| worse(most, *error, size))
}

/// What differences between two runs are compared with: the largest way from the start and the largest velocity, among
/// the coordinates of one unit. So they depend neither on where a scene is nor on its units.
#[derive(Debug, Clone)]
struct Sizes {
    way: Vec<f64>,
    speed: Vec<f64>,
}

impl Sizes {
    /// Of the motion of a run with a trajectory.
    fn of(run: &Simulation, model: &dyn Model, problem: &InitialValueProblem) -> Self {
        let (n, horizon, start) = (problem.q.len(), problem.horizon, problem.input(model));
        let (mut mass, mut free) = (vec![0.0; n * n], vec![0.0; n]);
        model.mass_matrix(&start, &mut mass);
        model.free_acceleration(&start, &mut free);
        // States have no energy.
        let mechanical = model.declaration().mechanical();
        (mechanical..n).for_each(|k| mass[k * n + k] = 0.0);
        // What does not move has rounding errors only.
        let held = |(q, a): (&f64, &f64)| {
            (yardstick::ROUNDING * q.abs()).max(yardstick::NOTHING * a.abs() * horizon.powi(2))
        };
        let mut way: Vec<f64> = problem.q.iter().zip(&free).map(held).collect();
        let mut speed: Vec<f64> = way.iter().map(|way| way / horizon).collect();
        let mut energy = 0.0_f64;
        for (q, v) in run.trajectory.q.iter().zip(&run.trajectory.v) {
            for k in 0..n {
                way[k] = way[k].max((q[k] - problem.q[k]).abs());
                speed[k] = speed[k].max(v[k].abs());
            }
            energy = energy.max(squared(&mass, v));
        }
        let (mut way, mut speed) = (of_unit(run, &way), of_unit(run, &speed));
        let places: Vec<f64> = problem.q.iter().map(|q| q.abs()).collect();
        for (k, place) in of_unit(run, &places).into_iter().enumerate() {
            let still = way[k] <= yardstick::ROUNDING * place
                && speed[k] <= yardstick::ROUNDING * place / horizon;
            if still {
                // Where nothing of that unit moves, the last digit of a place is no share of a motion.
                (way[k], speed[k]) = (place, place / horizon);
            }
        }
        let diagonal: Vec<f64> = (0..n).map(|k| mass[k * n + k]).collect();
        let heaviest = of_unit(run, &diagonal);
        // A coordinate of another unit is held as well as those that would move if they were free.
        let pull = squared(&mass, &free);
        for (k, mass) in heaviest.iter().enumerate() {
            let held = yardstick::NOTHING * (pull / mass).sqrt() * horizon;
            if held.is_finite() {
                (way[k], speed[k]) = (way[k].max(held * horizon), speed[k].max(held));
            }
        }
        let times = way.iter().zip(&speed).map(|(way, speed)| way / speed);
        let time = times.filter(|time| time.is_finite()).fold(0.0, f64::max);
        // An angle that only rounding error turns has no size of its own.
        let idle: Vec<f64> = heaviest
            .iter()
            .map(|mass| yardstick::VISIBLE * (energy / mass).sqrt())
            .map(|idle| if idle.is_finite() { idle } else { 0.0 })
            .collect();
        let larger = |sizes: Vec<f64>, time: f64| {
            let pairs = sizes.into_iter().zip(&idle);
            pairs.map(|(size, idle)| size.max(idle * time)).collect()
        };
        Self {
            way: larger(way, time),
            speed: larger(speed, 1.0),
        }
    }
}

/// `v' M v`, of velocities twice the kinetic energy.
fn squared(mass: &[f64], v: &[f64]) -> f64 {
    let rows = mass.chunks_exact(v.len().max(1));
    let momentum = rows.map(|row| row.iter().zip(v).map(|(m, v)| m * v).sum::<f64>());
    momentum.zip(v).map(|(p, v)| p * v).sum()
}

/// The largest of the values among the coordinates of the same unit, for each coordinate.
fn of_unit(run: &Simulation, values: &[f64]) -> Vec<f64> {
    let coordinates = run.declaration.coordinates;
    let alike = |k: usize| {
        let same = (0..values.len()).filter(|&i| coordinates[i].unit == coordinates[k].unit);
        same.map(|i| values[i]).fold(0.0, f64::max)
    };
    (0..values.len()).map(alike).collect()
}

/// Largest difference at the ends of two runs and at their events, as a share of the `sizes`; infinite where one has no
/// end.
fn difference(a: &Simulation, b: &Simulation, sizes: &Sizes) -> f64 {
    let (from, to) = (&a.trajectory, &b.trajectory);
    let (Some(qa), Some(qb), Some(va), Some(vb)) =
        (from.q.last(), to.q.last(), from.v.last(), to.v.last())
    else {
        return f64::INFINITY;
    };
    let apart = |a: &[f64], b: &[f64], sizes: &[f64]| {
        let pairs = a.iter().zip(b).zip(sizes);
        pairs.fold(0.0, |most, ((a, b), &size)| worse(most, a - b, size))
    };
    apart(qa, qb, &sizes.way)
        .max(apart(va, vb, &sizes.speed))
        .max(at_events(&a.events, &b.events, sizes))
}

/// What rounding leaves at the end of a run with many impacts: each flight adds to the error of the velocities, of which an impact keeps
/// the share that its restitution does, and all of them go on with it.
fn of_flights(run: &Simulation, model: &dyn Model, sizes: &Sizes) -> f64 {
    let listed = run.events.len().max(1) as f64;
    let added = OF_FLIGHT * (run.counts.events as f64 / listed).max(1.0);
    let n = sizes.way.len();
    let (mut way, mut speed, mut since) = (vec![0.0; n], vec![0.0; n], 0.0);
    let mut go_on = |until: f64, speed: &[f64]| {
        let pairs = way.iter_mut().zip(speed);
        pairs.for_each(|(way, speed)| *way += (until - since) * speed);
        since = until;
    };
    for event in &run.events {
        if event.kind != EventKind::Impact {
            continue;
        }
        go_on(event.time, &speed);
        let kept = match model.declaration().contacts[event.contact].law {
            ImpactLaw::Inelastic => 0.0,
            ImpactLaw::Restitution => model.restitution(event.contact),
        };
        for (k, speed) in speed.iter_mut().enumerate() {
            let [before, after] = [&event.v_before, &event.v_after].map(|v| added * v[k].abs());
            *speed = kept * (*speed + before) + after;
        }
    }
    go_on(run.trajectory.time.last().copied().unwrap_or(0.0), &speed);
    let pairs = way
        .iter()
        .chain(&speed)
        .zip(sizes.way.iter().chain(&sizes.speed));
    pairs.fold(0.0, |most, (error, &size)| worse(most, *error, size))
}

/// The larger of `most` and a difference as a share of `size`; what is not a number is infinite.
fn worse(most: f64, difference: f64, size: f64) -> f64 {
    if difference == 0.0 {
        return most;
    }
    let share = difference.abs() / size;
    if share.is_nan() {
        f64::INFINITY
    } else {
        most.max(share)
    }
}

/// Largest distance between the coordinates at the events of one run and those of the same kind that are next to them in
/// the other: of impacts that follow each other ever faster both have another number.
fn at_events(a: &[Event], b: &[Event], sizes: &Sizes) -> f64 {
    let mut largest = 0.0_f64;
    let mut seen: Vec<(EventKind, usize)> = Vec::new();
    for event in b {
        let key = (event.kind, event.contact);
        if seen.contains(&key) {
            continue;
        }
        seen.push(key);
        let alike = |events: &'_ [Event]| -> Vec<usize> {
            let same = |&k: &usize| (events[k].kind, events[k].contact) == key;
            (0..events.len()).filter(same).collect()
        };
        let others = alike(a);
        for k in alike(b) {
            let event = &b[k];
            let after = others.partition_point(|&other| a[other].time < event.time);
            let next_to = &others[after.saturating_sub(1)..others.len().min(after + 1)];
            let nearest = next_to
                .iter()
                .map(|&other| at_event(&a[other], event, sizes));
            largest = largest.max(nearest.reduce(f64::min).unwrap_or(0.0));
        }
    }
    largest
}

/// Distance between the coordinates of two events, at the same time to first order.
fn at_event(a: &Event, b: &Event, sizes: &Sizes) -> f64 {
    let late = b.time - a.time;
    let pairs = a.q.iter().zip(&b.q).zip(&b.v_before).zip(&sizes.way);
    pairs.fold(0.0, |most, (((a, b), v), &way)| {
        worse(most, a + v * late - b, way)
    })
}

/// Time up to which two runs have the same events at the same places, to the share `promise` \[s\].
fn agreed_until(a: &Simulation, b: &Simulation, sizes: &Sizes, promise: f64) -> f64 {
    let pairs = a.events.iter().zip(&b.events);
    let agreed = pairs.take_while(|(a, b)| {
        a.kind == b.kind && a.contact == b.contact && at_event(a, b, sizes) <= promise
    });
    agreed.last().map_or(0.0, |(a, b)| a.time.min(b.time))
}

/// The work of several runs.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Spent {
    counts: Counts,
    seconds: f64,
}

impl Spent {
    pub(super) fn add(&mut self, run: &Simulation) {
        self.counts.interior_point += run.counts.interior_point;
        self.counts.crossover += run.counts.crossover;
        self.counts.newton += run.counts.newton;
        self.counts.factorizations += run.counts.factorizations;
        self.counts.evaluations += run.counts.evaluations;
        self.seconds += run.seconds.total;
    }

    /// The result with the work of all runs; elements are those of the result.
    pub(super) fn charge(mut self, mut result: Simulation) -> Simulation {
        self.counts.elements = result.counts.elements;
        self.counts.events = result.counts.events;
        result.counts = self.counts;
        result.seconds.total = self.seconds;
        result
    }
}
