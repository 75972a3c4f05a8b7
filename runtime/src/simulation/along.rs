//! What the trajectories of methods that locate no switches say of their errors.

use super::{InitialValueProblem, Simulation};
use crate::enclosure::{Along, Sample, Suspect, Watched, earliest_fall};
use crate::model::{ImpactLaw, Model, Pieces, contact_point};
use crate::yardstick;

/// Halvings of the way between two places to where a gap closes.
const HALVINGS: usize = 50;

/// Largest difference of each coordinate between a run and a coarser one at the times of the latter, and zeros for the
/// velocities, which jump at other times.
pub(super) fn apart(coarser: &Simulation, finer: &Simulation) -> Vec<f64> {
    let (from, to) = (&coarser.trajectory, &finer.trajectory);
    let n = from.q.first().map_or(0, Vec::len);
    let mut largest = vec![0.0_f64; 2 * n];
    let mut x = vec![0.0; 2 * n];
    let mut next = 1;
    for (time, q) in from.time.iter().zip(&from.q) {
        while next + 1 < to.time.len() && to.time[next] < *time {
            next += 1;
        }
        if next < to.time.len() {
            place(finer, next, *time, &mut x);
            for (largest, (x, q)) in largest.iter_mut().zip(x.iter().zip(q)) {
                let apart = (x - q).abs();
                *largest = if apart.is_nan() {
                    f64::INFINITY
                } else {
                    largest.max(apart)
                };
            }
        }
    }
    largest
}

/// The state at a time between instants `next - 1` and `next` of the trajectory: coordinates by the cubic that has their
/// velocities, velocities by straight lines.
fn place(run: &Simulation, next: usize, time: f64, x: &mut [f64]) {
    let (times, q, v) = (&run.trajectory.time, &run.trajectory.q, &run.trajectory.v);
    let width = times[next] - times[next - 1];
    let share = if width > 0.0 {
        (time - times[next - 1]) / width
    } else {
        1.0
    };
    let rest = 1.0 - share;
    let n = q[next].len();
    for k in 0..n {
        let (a, b) = (q[next - 1][k], q[next][k]);
        let (from, to) = (v[next - 1][k], v[next][k]);
        let (way, slopes) = (b - a, (width * from, width * to));
        x[k] = rest * a
            + share * b
            + share * rest * (rest * (slopes.0 - way) - share * (slopes.1 - way));
        x[n + k] = rest * from + share * to;
    }
}

/// What the impacts would have changed that a run passed over: contacts that close and open again between two of its
/// instants. Of each coordinate at the end, if nothing happens later, and then of each velocity.
pub(super) fn passed_over(
    run: &Simulation,
    (model, problem): (&dyn Model, &InitialValueProblem),
) -> Vec<f64> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut missed = vec![0.0; 2 * n];
    let surfaces: Vec<usize> = (0..declaration.contacts.len())
        .filter(|&i| !declaration.contacts[i].dry)
        .collect();
    let mut between = Between::new(run, model);
    let mut along = Along::new(model, 3);
    let times = &run.trajectory.time;
    for next in (1..times.len()).filter(|&next| times[next] > times[next - 1]) {
        between.enclose(next, &mut along);
        for &i in &surfaces {
            let Some(time) = between.closing(i, next, &mut along) else {
                continue;
            };
            let restitution = match declaration.contacts[i].law {
                ImpactLaw::Inelastic => 0.0,
                ImpactLaw::Restitution => model.restitution(i),
            };
            between
                .pieces
                .contact(model, i, &between.x, &mut between.point);
            let approach = between.point[contact_point::NORMAL_VELOCITY].min(0.0);
            let left = problem.horizon - time;
            for k in 0..n {
                let direction = between.point[contact_point::direction(n) + k];
                let jump = ((1.0 + restitution) * approach * direction).abs();
                missed[k] += jump * left;
                missed[n + k] += jump;
            }
        }
    }
    missed
}

/// The first contact whose gap changes its sign without passing zero between two instants of a run, and the time \[s\]: through
/// infinity, or by a jump. Steps that locate no switches fly through it and notice nothing.
pub(super) fn leap(run: &Simulation, model: &dyn Model) -> Option<(f64, usize)> {
    let contacts = model.declaration().contacts;
    let mut between = Between::new(run, model);
    let mut largest = vec![0.0_f64; contacts.len()];
    let all = run.trajectory.q.iter().flatten();
    let size = all.fold(0.0_f64, |most, q| most.max(q.abs()));
    for next in 1..run.trajectory.time.len() {
        let times = [run.trajectory.time[next - 1], run.trajectory.time[next]];
        for i in (0..contacts.len()).filter(|&i| !contacts[i].dry) {
            let first = between.gap(i, next, times[0]);
            between.pieces.choose(model, &between.x);
            if between.pieces.is_idle(i) {
                continue;
            }
            largest[i] = largest[i].max(first.abs());
            if first <= 0.0 || times[1] <= times[0] {
                continue;
            }
            // A contact that holds has a gap of rounding, whose sign says nothing.
            let least = yardstick::PROMISE * largest[i].max(size);
            let rounding = between
                .rounding(i)
                .max(yardstick::ROUNDING * largest[i])
                .max(least);
            let last = between.gap(i, next, times[1]);
            if last >= 0.0 {
                continue;
            }
            let (open, closed) = between.around_zero(i, next, (times[0], times[1]));
            let left = between.gap(i, next, open) - between.gap(i, next, closed);
            if left > (yardstick::VISIBLE * first.max(-last)).max(rounding) {
                return Some((closed, i));
            }
        }
    }
    None
}

/// The motion between two instants of a trajectory.
struct Between<'a> {
    run: &'a Simulation,
    model: &'a dyn Model,
    pieces: Pieces,
    x: Vec<f64>,
    point: Vec<f64>,
}

impl<'a> Between<'a> {
    fn new(run: &'a Simulation, model: &'a dyn Model) -> Self {
        let declaration = model.declaration();
        Self {
            run,
            model,
            pieces: Pieces::default(),
            x: vec![0.0; declaration.inputs()],
            point: vec![0.0; contact_point::length(declaration.coordinates.len())],
        }
    }

    fn gap(&mut self, contact: usize, next: usize, time: f64) -> f64 {
        let n = self.run.trajectory.q[next].len();
        place(self.run, next, time, &mut self.x[..2 * n]);
        let controls = &self.run.trajectory.u[next];
        self.x[2 * n..2 * n + controls.len()].copy_from_slice(controls);
        if self.model.declaration().explicit_time
            && let Some(last) = self.x.last_mut()
        {
            *last = time;
        }
        self.pieces.gap(self.model, contact, &self.x)
    }

    /// Takes up the motion before instant `next`, with the pieces of edges that act at its start.
    fn enclose(&mut self, next: usize, along: &mut Along<'_>) {
        let (run, x) = (self.run, &mut self.x);
        let [start, end] = [next - 1, next].map(|at| run.trajectory.time[at]);
        let n = run.trajectory.q[next].len();
        place(run, next, start, &mut x[..2 * n]);
        self.pieces.choose(self.model, x);
        along.begin(start, end - start, &self.pieces);
        for side in [0, 1] {
            let controls = along.controls_at(side);
            controls.copy_from_slice(&run.trajectory.u[next]);
        }
        along.follow(|share, out| place(run, next, start + share * (end - start), out));
    }

    /// The time before instant `next` at which a contact closes that is open at that instant and the one before and carries
    /// no force, if it is closed somewhere between them; the state there is loaded. The motion between them is taken up.
    fn closing(&mut self, contact: usize, next: usize, along: &mut Along<'_>) -> Option<f64> {
        let run = self.run;
        let [start, end] = [next - 1, next].map(|at| run.trajectory.time[at]);
        let [first, last] = [start, end].map(|time| self.gap(contact, next, time));
        let carries = run.trajectory.contact_force[next][contact] != 0.0;
        if carries || first <= 0.0 || last <= 0.0 || self.pieces.is_idle(contact) {
            return None;
        }
        let at = |share: f64| start + share * (end - start);
        let [from, end] = [(0.0, first), (1.0, last)].map(|(at, value)| Sample { at, value });
        let suspect = Suspect {
            watched: Watched::Gap(contact),
            from,
            end,
            zero: 0.0,
            rounding: 0.0,
        };
        let gap = |_, share| self.gap(contact, next, at(share));
        let fall = earliest_fall(along, &[Some(suspect)], gap).ok()??;
        self.gap(contact, next, at(fall.root));
        Some(at(fall.root))
    }

    /// Neighbouring times before instant `next` between which a gap becomes negative that is not so at the first of these
    /// times and is at the second.
    fn around_zero(
        &mut self,
        contact: usize,
        next: usize,
        (mut open, mut closed): (f64, f64),
    ) -> (f64, f64) {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (open + closed);
            if self.gap(contact, next, middle) < 0.0 {
                closed = middle;
            } else {
                open = middle;
            }
        }
        (open, closed)
    }

    /// Rounding error of a gap at the state that is loaded, by its slopes and the coordinates.
    fn rounding(&mut self, contact: usize) -> f64 {
        let n = self.run.trajectory.q[0].len();
        self.pieces
            .contact(self.model, contact, &self.x, &mut self.point);
        let normal = &self.point[contact_point::NORMAL..][..n];
        let terms = normal.iter().zip(&self.x).map(|(n, q)| (n * q).abs());
        yardstick::ROUNDING * terms.sum::<f64>()
    }
}
