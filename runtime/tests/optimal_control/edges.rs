//! Outer edges, against closed forms and brute force: of the pieces of a `max` the largest acts, and which that is may
//! change during the motion. Bodies slide through kinks, and on where a surface goes over into the next one.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{attempt, kinds, one_start, solve, time_freezing};
use hangtime::model::Model;
use hangtime::ocp::{ControlShape, Settings, Solution};
use hangtime::simulation::EventKind;

const G: f64 = 9.81;
const INTERVALS: usize = 10;

hangtime::model! {
    /// A block is pushed off a table, to land at a given place at a given time.
    Push {
        parameters { m: kg = 2, g: m/s^2 = 9.81, height: m = 0.8, edge: m = 1, goal: m = 1.4 }
        coordinates { y: m, z: m }
        controls { u: N in -20..=20 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: u }
        surface table: max(z - height, y - edge) >= 0
        surface floor: z >= 0
        impact table, floor: inelastic
        minimize integral(u^2)
        finally { y == goal, z == 0 [m] }
        start { z: height }
        horizon 1.3 [s]
    }
}

hangtime::model! {
    /// A ball is thrown over a roof.
    Roof {
        parameters { m: kg = 1, g: m/s^2 = 9.81, slope = 2, top: m = 3 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface roof: z >= top - |slope*y|
        impact roof: inelastic
        minimize m/2*|dot((y, z))|^2
        finally { y == 3 [m], z == 1 [m], time <= 5 [s] }
        free { dot(y) in 0..=20, dot(z) in 0..=20 }
        start { y: -3 [m], z: 0.5 [m], dot(y): 5, dot(z): 5 }
        horizon 1.5 [s]
    }
}

hangtime::model! {
    /// A ball is thrown over a box.
    Box {
        parameters { m: kg = 1, g: m/s^2 = 9.81, width: m = 0.5, top: m = 3 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface box: max(z - top, |y| - width) >= 0
        surface floor: z >= 0
        impact box, floor: inelastic
        minimize m/2*|dot((y, z))|^2
        finally { y == 3 [m], z == 1 [m], time <= 5 [s] }
        free { dot(y) in 0..=20, dot(z) in 0..=20 }
        start { y: -2.5 [m], z: 0.5 [m], dot(y): 5, dot(z): 5 }
        horizon 1.5 [s]
    }
}

hangtime::model! {
    /// A mass is thrown onto a rough step and slides there to rest, as soon as it can.
    Step {
        parameters { m: kg = 1, g: m/s^2 = 9.81, mu = 0.3, height: m = 0.4, edge: m = 1, goal: m = 1.5 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface step: max(z - height, edge - y) >= 0
        impact step: inelastic, friction mu
        minimize time
        finally { y == goal, dot(y) == 0 [m/s] }
        free { dot(y) in 0..=20, dot(z) in 0..=20 }
        start { z: 0.1 [m], dot(y): 2, dot(z): 4 }
        horizon 1.5 [s]
    }
}

hangtime::model! {
    /// A block is pushed down a ramp that goes over into a flat, to stop there.
    Kink {
        parameters { m: kg = 2, g: m/s^2 = 9.81, mu = 0, slope = 0.5, goal: m = 1 }
        coordinates { y: m, z: m }
        controls { u: N in -40..=40 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: u }
        surface ground: z >= max(0 [m], -slope*y)
        impact ground: inelastic, friction mu
        minimize integral(u^2)
        finally { y == goal, dot(y) == 0 [m/s] }
        start { y: -1 [m], z: slope*1 [m] }
        horizon 1.5 [s]
    }
}

hangtime::model! {
    /// The same without friction in its law.
    SmoothKink {
        parameters { m: kg = 2, g: m/s^2 = 9.81, slope = 0.5, goal: m = 1 }
        coordinates { y: m, z: m }
        controls { u: N in -40..=40 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: u }
        surface ground: z >= max(0 [m], -slope*y)
        impact ground: inelastic
        minimize integral(u^2)
        finally { y == goal, dot(y) == 0 [m/s] }
        start { y: -1 [m], z: slope*1 [m] }
        horizon 1.5 [s]
    }
}

hangtime::model! {
    /// A block is pushed down a ramp that goes over into an arc, to rest there.
    Hollow {
        parameters { m: kg = 2, g: m/s^2 = 9.81, slope = 0.5, radius: m = 1, steep = 2, goal: m = 1 }
        coordinates { y: m, z: m }
        controls { u: N in -40..=40 }
        fn ramp(y) = -slope*y
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: u }
        surface ground: z >= max(ramp(y), min(ramp(y) + y^2/(2*radius), ramp(y) + steep*y))
        impact ground: inelastic
        minimize integral(u^2)
        finally { y == goal, dot(y) == 0 [m/s] }
        start { y: -1 [m], z: slope*1 [m] }
        horizon 1.5 [s]
    }
}

hangtime::model! {
    /// A block is pushed over the end of a flat that goes over into a round shoulder, to stop there.
    Shoulder {
        parameters { m: kg = 1, g: m/s^2 = 9.81, radius: m = 0.8, goal: m = 0.4 }
        coordinates { y: m, z: m }
        controls { u: N in -15..=15 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: u }
        surface top: min(max(z, y), z + y^2/(2*radius)) >= 0
        impact top: inelastic
        minimize integral(u^2)
        finally { y == goal, dot(y) == 0 [m/s] }
        start { y: -0.6 [m] }
        horizon 1.6 [s]
    }
}

/// A block on a ground of one slope up to `y = 0`, whose curvature is constant from there on.
struct Slide {
    mass: f64,
    slope: f64,
    curvature: f64,
    start: f64,
    goal: f64,
    horizon: f64,
}

impl Slide {
    /// Place and speed along y at the end, by small steps, one of which ends where the curvature begins.
    fn end(&self, forces: &[f64]) -> [f64; 2] {
        const STEPS: usize = 100;
        let h = self.horizon / (forces.len() * STEPS) as f64;
        let (mut state, mut curved) = ([self.start, 0.0], false);
        for &force in forces {
            for _ in 0..STEPS {
                let whole = self.step(state, h, force, curved);
                if curved || whole[0] <= 0.0 {
                    state = whole;
                    continue;
                }
                let (mut early, mut late) = (0.0, h);
                for _ in 0..60 {
                    let middle = 0.5 * (early + late);
                    let beyond = self.step(state, middle, force, false)[0] > 0.0;
                    *(if beyond { &mut late } else { &mut early }) = middle;
                }
                state = self.step(state, early, force, false);
                curved = true;
                state = self.step(state, h - early, force, true);
            }
        }
        state
    }

    /// A Runge-Kutta step of order 4 on one of the two parts of the ground.
    fn step(&self, state: [f64; 2], h: f64, force: f64, curved: bool) -> [f64; 2] {
        let curvature = if curved { self.curvature } else { 0.0 };
        let rate = |[y, v]: [f64; 2]| {
            let slope = self.slope + curvature * y;
            let along = force / self.mass - slope * (curvature * v * v + G);
            [v, along / (1.0 + slope * slope)]
        };
        let moved = |k: [f64; 2], h: f64| [state[0] + h * k[0], state[1] + h * k[1]];
        let k1 = rate(state);
        let k2 = rate(moved(k1, 0.5 * h));
        let k3 = rate(moved(k2, 0.5 * h));
        let k4 = rate(moved(k3, h));
        moved(
            std::array::from_fn(|i| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0),
            h,
        )
    }

    /// The least effort that brings it to rest at the goal: forces `J' y` that meet the goal, where `J` is how the end
    /// depends on them.
    fn least_effort(&self) -> f64 {
        let mut forces = vec![0.0; INTERVALS];
        for _ in 0..100 {
            let end = self.end(&forces);
            let columns: Vec<[f64; 2]> = (0..INTERVALS)
                .map(|k| {
                    let [more, less] = [1e-4, -1e-4].map(|change| {
                        let mut forces = forces.clone();
                        forces[k] += change;
                        self.end(&forces)
                    });
                    [0, 1].map(|i| (more[i] - less[i]) / 2e-4)
                })
                .collect();
            let wanted = [0, 1].map(|i| {
                let moved: f64 = columns.iter().zip(&forces).map(|(c, u)| c[i] * u).sum();
                moved - end[i] + if i == 0 { self.goal } else { 0.0 }
            });
            let dot = |i: usize, j: usize| -> f64 { columns.iter().map(|c| c[i] * c[j]).sum() };
            let (a, b, c) = (dot(0, 0), dot(0, 1), dot(1, 1));
            let determinant = a * c - b * b;
            let y = [
                (c * wanted[0] - b * wanted[1]) / determinant,
                (a * wanted[1] - b * wanted[0]) / determinant,
            ];
            for (force, column) in forces.iter_mut().zip(&columns) {
                *force = column[0] * y[0] + column[1] * y[1];
            }
        }
        let squares: f64 = forces.iter().map(|u| u * u).sum();
        self.horizon / INTERVALS as f64 * squares
    }
}

/// The least effort with which a block that slides without flight is at the kink at time `t` and rests at the goal in the
/// end: of the forces that solve three linear equations the shortest.
fn effort_through_the_kink(kink: &Kink, t: f64) -> f64 {
    let Kink {
        m, mu, slope, goal, ..
    } = *kink;
    let (end, h) = (1.5, 1.5 / INTERVALS as f64);
    let cosine = 1.0 / (1.0 + slope * slope).sqrt();
    let sine = slope * cosine;
    // Accelerations along y by the force and by the weight, on the ramp and on the flat.
    let ramp = (
        (cosine + mu * sine) * cosine / m,
        G * (sine - mu * cosine) * cosine,
    );
    let flat = (1.0 / m, -mu * G);
    // The impact takes what moves down, and `mu` times that.
    let kept = 1.0 - mu * slope;
    // Place and speed at a time, by an acceleration between two others.
    let moved = |from: f64, to: f64, at: f64| {
        let (from, to) = (from.min(at), to.min(at));
        [0.5 * ((at - from).powi(2) - (at - to).powi(2)), to - from]
    };
    let on_ramp = moved(0.0, t, t);
    let on_flat = moved(t, end, end);
    let speed = ramp.1 * on_ramp[1];
    let wanted = [
        1.0 - ramp.1 * on_ramp[0],
        goal - flat.1 * on_flat[0] - kept * speed * (end - t),
        -flat.1 * on_flat[1] - kept * speed,
    ];
    let rows: Vec<[f64; 3]> = (0..INTERVALS)
        .map(|k| {
            let (from, to) = (k as f64 * h, (k + 1) as f64 * h);
            let before = moved(from, to.min(t).max(from), t).map(|way| ramp.0 * way);
            let after = moved(from.max(t).min(to), to, end).map(|way| flat.0 * way);
            [
                before[0],
                after[0] + kept * before[1] * (end - t),
                after[1] + kept * before[1],
            ]
        })
        .collect();
    let dot = |i: usize, j: usize| -> f64 { rows.iter().map(|row| row[i] * row[j]).sum() };
    let a: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| dot(i, j)));
    let determinant = |a: [[f64; 3]; 3]| -> f64 {
        let minor = |i: usize, j: usize| a[1][i] * a[2][j] - a[1][j] * a[2][i];
        a[0][0] * minor(1, 2) - a[0][1] * minor(0, 2) + a[0][2] * minor(0, 1)
    };
    let multipliers = (0..3).map(|i| {
        let mut replaced = a;
        replaced[i] = wanted;
        determinant(replaced) / determinant(a)
    });
    let pairs = multipliers.zip(wanted);
    h * pairs.map(|(y, b)| y * b).sum::<f64>()
}

/// The least of a function of one unknown on a grid that is refined around its best point.
fn least(mut from: f64, mut to: f64, value: impl Fn(f64) -> f64) -> f64 {
    const POINTS: usize = 2000;
    let mut best = f64::INFINITY;
    for _ in 0..6 {
        let step = (to - from) / POINTS as f64;
        let places = (0..=POINTS).map(|i| from + i as f64 * step);
        let (place, least) = places
            .map(|place| (place, value(place)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap();
        best = least.min(best);
        (from, to) = (place - step, place + step);
    }
    best
}

/// The landing at the end of the motion is a switch of the plan, or where it ends.
fn assert_lifts_off_once(solution: &Solution) {
    let kinds = kinds(solution);
    let both = [EventKind::LiftOff, EventKind::Impact];
    assert!(kinds == both || kinds == both[..1], "{kinds:?}");
}

#[test]
fn block_is_pushed_off_a_table_with_the_least_effort_of_its_closed_form() {
    let push = Push::default();
    let solution = solve(&push, INTERVALS, &Settings::default());
    assert_lifts_off_once(&solution);
    let pushed = Pushed::off_a_table(&push);
    let effort = pushed.least_effort();
    let off = (solution.objective - effort).abs();
    assert!(off < 1e-7 * effort, "{} {effort}", solution.objective);
    assert!((solution.planned_events[0].0 - pushed.at).abs() < 1e-7);
}

#[test]
fn block_goes_through_a_kink_with_the_least_effort_of_its_closed_form() {
    let rough = Kink {
        mu: 0.2,
        ..Kink::default()
    };
    let smooth = SmoothKink::default();
    let models: [(&dyn Model, Kink); 2] = [(&rough, rough.clone()), (&smooth, Kink::default())];
    for (model, kink) in models {
        let solution = solve(model, INTERVALS, &Settings::default());
        assert!(solution.status.is_solved());
        assert_eq!(
            kinds(&solution),
            [EventKind::Impact, EventKind::LiftOff],
            "{:?}",
            solution.planned_events
        );
        let [struck, left] = [0, 1].map(|i| solution.planned_events[i].0);
        assert_eq!(struck, left);
        let best = least(0.5, 1.1, |t| effort_through_the_kink(&kink, t));
        let off = (solution.objective - best).abs();
        assert!(off < 1e-7 * best, "{} {best}", solution.objective);
    }
}

fn over_the_shoulder(shoulder: &Shoulder) -> Slide {
    Slide {
        mass: shoulder.m,
        slope: 0.0,
        curvature: -1.0 / shoulder.radius,
        start: -0.6,
        goal: shoulder.goal,
        horizon: 1.6,
    }
}

#[test]
fn block_slides_on_into_an_arc_and_over_a_shoulder_with_the_least_effort_of_one_coordinate() {
    let hollow = Hollow::default();
    let shoulder = Shoulder::default();
    let into_the_arc = Slide {
        mass: hollow.m,
        slope: -hollow.slope,
        curvature: 1.0 / hollow.radius,
        start: -1.0,
        goal: hollow.goal,
        horizon: 1.5,
    };
    let models: [(&dyn Model, Slide); 2] = [
        (&hollow, into_the_arc),
        (&shoulder, over_the_shoulder(&shoulder)),
    ];
    for (model, slide) in models {
        let solution = attempt(model, INTERVALS, &one_start());
        assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
        assert_eq!(
            kinds(&solution),
            [EventKind::LiftOff, EventKind::Contact],
            "{:?}",
            solution.planned_events
        );
        let best = slide.least_effort();
        // Four stages an interval follow the arc to about 1e-6.
        let off = (solution.objective - best).abs();
        assert!(off < 5e-6 * best, "{} {best}", solution.objective);
    }
}

#[test]
fn ball_is_thrown_over_the_ridge_of_a_roof_with_the_least_energy() {
    let roof = Roof::default();
    let solution = solve(&roof, INTERVALS, &Settings::default());
    assert_eq!(solution.planned_events, []);
    // Half of the time after its start it passes the ridge, t^2 g / 8 above the middle between start and goal.
    let margin = Settings::default().gap_margin;
    let best = |margin: f64| {
        let time = (8.0 / G * (roof.top + margin - 0.75)).sqrt();
        let (across, up) = (6.0 / time, (0.5 + 0.5 * G * time * time) / time);
        (time, 0.5 * (across * across + (up - G * time).powi(2)))
    };
    let (time, energy) = best(margin);
    let (objective, horizon) = (solution.objective, solution.horizon);
    assert!(
        (objective - energy).abs() < 1e-7 * energy,
        "{objective} {energy}"
    );
    assert!((horizon - time).abs() < 1e-7, "{horizon} {time}");
    // What it would gain without the margin, to first order: the second is a part in a million of that.
    let [kept] = &solution.margins[..] else {
        panic!("{:?}", solution.margins);
    };
    assert_eq!(
        (kept.amount, &kept.unit[..], kept.chosen),
        (margin, "m", true)
    );
    let gains = energy - best(0.0).1;
    assert!(
        (kept.cost - gains).abs() < 1e-4 * gains,
        "{} {gains}",
        kept.cost
    );
}

#[test]
fn ball_is_thrown_over_a_box_as_brute_force_does() {
    let thrown = Box::default();
    let solution = solve(&thrown, INTERVALS, &Settings::default());
    let (from, to) = ([-2.5, 0.5], [3.0, 1.0]);
    let margin = Settings::default().gap_margin;
    let energy = |time: f64| {
        let across = (to[0] - from[0]) / time;
        let up = (to[1] - from[1] + 0.5 * G * time * time) / time;
        // The ball is above the corners, and so above what is between them.
        let corners = [-1.0, 1.0].map(|side| side * (thrown.width + margin));
        let clears = corners.into_iter().all(|corner| {
            let t = (corner - from[0]) / across;
            from[1] + up * t - 0.5 * G * t * t >= thrown.top + margin
        });
        let down = up - G * time;
        if clears {
            0.5 * (across * across + down * down)
        } else {
            f64::INFINITY
        }
    };
    let best = least(0.1, 5.0, energy);
    let off = (solution.objective - best).abs();
    assert!(off < 1e-7 * best, "{} {best}", solution.objective);
}

#[test]
fn mass_is_thrown_onto_a_rough_step_as_brute_force_does() {
    let step = Step::default();
    let solution = solve(&step, INTERVALS, &Settings::default());
    let time = |up: f64| {
        let rise = step.height - 0.1;
        let flight = (up + (up * up - 2.0 * G * rise).sqrt()) / G;
        let (struck, brake) = (step.mu * (G * flight - up), step.mu * G);
        // Slides on with w = v - struck: (w + struck) flight + w^2 / (2 brake) = goal.
        let missing = step.goal - struck * flight;
        let w = brake * ((flight * flight + 2.0 * missing / brake).sqrt() - flight);
        let v = w + struck;
        let at_edge = step.edge / v;
        let height = 0.1 + up * at_edge - 0.5 * G * at_edge * at_edge;
        if missing >= 0.0 && flight >= at_edge && height >= step.height {
            flight + w / brake
        } else {
            f64::INFINITY
        }
    };
    let best = least(2.43, 12.0, time);
    let cost = solution.horizon - best;
    assert!((-1e-7..1e-4).contains(&cost), "{} {best}", solution.horizon);
}

#[test]
fn linear_controls_push_off_a_table_with_less_effort() {
    let push = Push::default();
    let constant = solve(&push, INTERVALS, &Settings::default());
    let mut settings = Settings::default();
    settings.controls = ControlShape::Linear;
    let linear = solve(&push, INTERVALS, &settings);
    assert_lifts_off_once(&linear);
    assert_lifts_off_once(&constant);
    let (less, more) = (linear.objective, constant.objective);
    // Both are above the least effort of all controls, which constant ones miss by more.
    assert!(less < more && less > 0.97 * more, "{less} {more}");
}

/// A mass at rest that is pushed along a line by constant forces on intervals, to one place at a time and to another one at the end.
struct Pushed {
    m: f64,
    at: f64,
    place: f64,
    end: f64,
    goal: f64,
}

impl Pushed {
    /// A block that is pushed off a table: it lands at the end, so it passes the edge one fall before.
    fn off_a_table(push: &Push) -> Self {
        let end = 1.3;
        Self {
            m: push.m,
            at: end - (2.0 * push.height / G).sqrt(),
            place: push.edge,
            end,
            goal: push.goal,
        }
    }

    /// Products of the rows that give both places: forces `u_k` on intervals of length `h` move the place at `t` by `a_k(t) u_k`.
    fn products(&self) -> [f64; 3] {
        let h = self.end / INTERVALS as f64;
        let row = |t: f64| -> Vec<f64> {
            let way = |from: f64| 0.5 * (t - from).max(0.0).powi(2) / self.m;
            let ways = (0..INTERVALS).map(|k| way(k as f64 * h) - way((k + 1) as f64 * h));
            ways.collect()
        };
        let rows = [self.at, self.end].map(row);
        [(0, 0), (0, 1), (1, 1)].map(|(i, j)| {
            let pairs = rows[i].iter().zip(&rows[j]);
            pairs.map(|(a, b)| a * b).sum()
        })
    }

    /// The least effort: of all forces that lead to both places the shortest is a combination of the two rows.
    fn least_effort(&self) -> f64 {
        let [a, b, c] = self.products();
        let (p, q) = (self.place, self.goal);
        self.end / INTERVALS as f64 * (c * p * p - 2.0 * b * p * q + a * q * q) / (a * c - b * b)
    }

    /// The least effort where it may be short of the first place.
    fn least_effort_before(&self) -> f64 {
        let [_, b, c] = self.products();
        let place = b / c * self.goal;
        let place = place.min(self.place);
        Self { place, ..*self }.least_effort()
    }
}

/// The time-freezing program knows which piece of an edge acts: what it comes to is the same motion.
#[test]
fn time_freezing_program_pushes_off_a_table_and_over_a_shoulder_as_closed_forms_do() {
    let push = Push::default();
    let solution = attempt(&push, INTERVALS, &time_freezing());
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    assert!(solution.time_freezing.is_some());
    let pushed = Pushed::off_a_table(&push);
    let effort = pushed.least_effort();
    let off = (solution.objective - effort).abs();
    assert!(off < 1e-7 * effort, "{} {effort}", solution.objective);
    assert!((solution.planned_events[0].0 - pushed.at).abs() < 1e-7);

    let shoulder = Shoulder::default();
    let solution = attempt(&shoulder, INTERVALS, &time_freezing());
    assert!(solution.status.is_solved(), "{:?}", solution.diagnosis());
    let best = over_the_shoulder(&shoulder).least_effort();
    let off = (solution.objective - best).abs();
    // Four stages an interval follow the arc to about 1e-6.
    assert!(off < 5e-6 * best, "{} {best}", solution.objective);
}

hangtime::model! {
    /// A ball falls on a table, is pushed aside meanwhile, and has to be beside it and far away at the end.
    Dropped {
        parameters { m: kg = 2, g: m/s^2 = 9.81, height: m = 0.8, drop: m = 0.2, edge: m = 0.1, goal: m = 1.4 }
        coordinates { y: m, z: m }
        controls { u: N in -40..=40 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: u }
        surface table: max(z - height, y - edge) >= 0
        impact table: inelastic
        minimize integral(u^2)
        finally { y == goal, z >= -1 [m] }
        start { z: height + drop }
        horizon 0.65 [s]
    }
}

/// A contact of no length at all: the ball strikes the very edge and is beyond it at once.
#[test]
fn ball_strikes_the_very_edge_of_a_table_and_falls_on_with_the_least_effort_of_its_closed_form() {
    let dropped = Dropped::default();
    let strikes = (2.0 * dropped.drop / dropped.g).sqrt();
    let pushed = Pushed {
        m: dropped.m,
        at: strikes,
        place: dropped.edge,
        end: 0.65,
        goal: dropped.goal,
    };
    let effort = pushed.least_effort_before();
    let solution = solve(&dropped, INTERVALS, &one_start());
    assert_eq!(kinds(&solution), [EventKind::Impact]);
    assert!(solution.margins.is_empty(), "{:?}", solution.margins);
    let off = (solution.objective - effort).abs();
    assert!(off < 1e-7 * effort, "{} {effort}", solution.objective);
    assert!((solution.planned_events[0].0 - strikes).abs() < 1e-7);
}

hangtime::model! {
    /// A ball falls on a table that throws it back, is pushed aside meanwhile, and has to be beside it and no lower at the end.
    Rubber {
        parameters { m: kg = 2, g: m/s^2 = 9.81, height: m = 0.8, drop: m = 0.2, edge: m = 0.1, goal: m = 0.5, e = 0.5 }
        coordinates { y: m, z: m }
        controls { u: N in -40..=40 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: u }
        surface table: max(z - height, y - edge) >= 0
        impact table: restitution e
        minimize integral(u^2)
        finally { y == goal, z >= height }
        start { z: height + drop }
        horizon 0.35 [s]
    }
}

#[test]
fn time_freezing_program_bounces_at_an_edge_as_closed_forms_do() {
    // Where the ball strikes the very edge, and where it strikes next to it, nearer than a bounce of the time-freezing system is deep.
    for edge in [0.1, 0.2] {
        let rubber = Rubber {
            edge,
            ..Rubber::default()
        };
        let solution = attempt(&rubber, INTERVALS, &time_freezing());
        assert!(
            solution.status.is_solved(),
            "{edge} {:?}",
            solution.diagnosis()
        );
        let report = solution.time_freezing.as_ref().unwrap();
        assert!(report.left_out.is_empty());
        let strikes = (2.0 * rubber.drop / rubber.g).sqrt();
        let pushed = Pushed {
            m: rubber.m,
            at: strikes,
            place: edge,
            end: 0.35,
            goal: rubber.goal,
        };
        let effort = pushed.least_effort_before();
        for (name, objective) in [
            ("motion", solution.objective),
            ("program", report.objective),
        ] {
            let off = (objective - effort).abs();
            assert!(off < 1e-7 * effort, "{edge} {name} {objective} {effort}");
        }
        assert!((solution.planned_events[0].0 - strikes).abs() < 1e-7);
    }
}

hangtime::model! {
    /// A ball is thrown over a fence with sharp edges into a window, pushed by wind.
    Fence {
        parameters { m: kg = 0.2, g: m/s^2 = 9.81, e = 0.6, fence: m = 0.8, unit: m^2/s^3 = 1, one: N = 1 }
        coordinates { y: m, z: m }
        controls { wind: N in -0.6..=0.6 }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: wind }
        surface floor: z >= 0
        surface post: max(z - fence, |y - 2[m]| - 0.05[m]) >= 0
        impact floor, post: restitution e
        minimize dot(z)^2 + integral((wind/one)^2)*unit
        finally { y == 4 [m], z == 0.3 [m], time <= 3 [s] }
        free { dot(y) in 0..=6, dot(z) in 0..=4.5 }
        start { z: 1 [m], dot(y): 2.5, dot(z): 3 }
        horizon 1.6 [s]
    }
}

#[test]
fn edge_that_is_passed_right_before_its_top_is_struck_takes_a_phase_as_short_as_it_needs() {
    // A quadratic program in the wind for every throw. The shortest phase that is usual costs 1.2e-4.
    let fence = Fence::default();
    let solution = solve(&fence, 20, &Settings::default());
    let known = 0.954_988_30;
    let off = (solution.objective - known) / known;
    assert!(off.abs() < 1e-6, "{}", solution.objective);
}
