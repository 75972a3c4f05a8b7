//! Parameters from measurements: the true values that data were made with, by closed forms, without noise and with.

use super::random::Random;
use hangtime::estimation::{Estimate, Measurements, Settings, Status, estimate};
use hangtime::model::Model as _;
use hangtime::simulation::ControlSignal;
use hangtime_scene_files::{TextScene, of_text};
use std::f64::consts::PI;

fn scene(text: &str) -> TextScene {
    of_text("scene.hang", text).expect("no mistakes")
}

fn fitted_from(scene: &TextScene, data: &[Measurements], starts: Option<usize>) -> Estimate {
    let mut settings = Settings::default();
    settings.starts = starts;
    estimate(scene, data, &settings, &mut |_| true).expect("accepted")
}

fn fitted(text: &str, data: &[Measurements]) -> Estimate {
    fitted_from(&scene(text), data, None)
}

/// A number of a normal distribution with deviation 1 (Box and Muller 1958).
fn normal(random: &mut Random) -> f64 {
    let radius = (-2.0 * random.number().max(f64::MIN_POSITIVE).ln()).sqrt();
    radius * (2.0 * PI * random.number()).cos()
}

/// Values of a function of the time with noise of that deviation.
fn measured(
    times: impl Iterator<Item = f64>,
    of: impl Fn(f64) -> Vec<f64>,
    (random, deviation): (&mut Random, f64),
) -> Measurements {
    let mut data = Measurements::default();
    for time in times {
        let values = of(time).into_iter();
        data.values.push(
            values
                .map(|value| value + deviation * normal(random))
                .collect(),
        );
        data.times.push(time);
    }
    data
}

/// Without noise.
fn exact(times: impl Iterator<Item = f64>, of: impl Fn(f64) -> Vec<f64>) -> Measurements {
    measured(times, of, (&mut Random(1), 0.0))
}

/// Times at equal distances behind 0.
fn every(step: f64, count: usize) -> impl Iterator<Item = f64> {
    (1..=count).map(move |k| k as f64 * step)
}

fn near(estimate: &Estimate, truth: &[f64], tolerance: f64) {
    assert_eq!(estimate.status, Status::Solved, "{:?}", estimate.diagnosis);
    for (found, truth) in estimate.parameters.iter().zip(truth) {
        let off = (found.value - truth).abs();
        assert!(
            off <= tolerance * truth.abs(),
            "{} {} {truth}",
            found.name,
            found.value
        );
    }
    assert_eq!(estimate.parameters.len(), truth.len());
}

/// Gravity of all scenes here [m/s^2].
const G: f64 = 9.81;

/// Where a small body is that is thrown at `(0, z)` with the velocity `(u, w)` onto a floor: parabolas between impacts, each of
/// which returns `e` of the normal velocity and takes `mu (1 + e)` of it, at most all, from the tangential one.
fn thrown([mut z, mut u, mut w]: [f64; 3], (e, mu): (f64, f64), time: f64) -> Vec<f64> {
    let (mut y, mut begin) = (0.0, 0.0);
    loop {
        let flight = (w + (w * w + 2.0 * G * z).sqrt()) / G;
        if time <= begin + flight {
            let t = time - begin;
            return vec![y + u * t, z + w * t - 0.5 * G * t * t];
        }
        let closing = G * flight - w;
        y += u * flight;
        (z, w, begin) = (0.0, e * closing, begin + flight);
        u = u.signum() * (u.abs() - mu * (1.0 + e) * closing).max(0.0);
    }
}

const FIRST: [f64; 3] = [1.0, 3.0, 0.0];
const SECOND: [f64; 3] = [0.5, 5.0, 2.0];

/// Two throws of a body onto a rough floor.
fn throws(free: &str, loss: &str) -> String {
    format!(
        "parameters {{ m: kg = 0.2, g: m/s^2 = 9.81 }} {free} coordinates {{ y: m, z: m }}
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface floor: z >= 0 impact floor: restitution e, friction mu, sliding dot(y)
        start {{ z: 1 [m], dot(y): 3 [m/s] }}
        measured first: \"a.csv\" {{ y within 1 [cm], z within 1 [cm] }}
        measured second: \"b.csv\" {{
            y within 1 [cm], z within 1 [cm], start {{ z: 0.5 [m], dot(y): 5 [m/s], dot(z): 2 [m/s] }}
        }}
        minimize misfit(first{loss}) + misfit(second{loss})"
    )
}

const BOTH: &str = "free e in 0..=1 = 0.5 free mu in 0..=1 = 0.3";

/// Both throws, seen 75 times in 1.5 s with noise of that deviation \[m\].
fn both(laws: (f64, f64), random: &mut Random, deviation: f64) -> [Measurements; 2] {
    [FIRST, SECOND].map(|start| {
        let motion = |t| thrown(start, laws, t);
        measured(every(0.02, 75), motion, (random, deviation))
    })
}

#[test]
fn restitution_and_friction_of_two_throws_are_the_true_ones_without_noise() {
    for (e, mu) in [(0.7, 0.2), (0.85, 0.12), (0.6, 0.3)] {
        let data = both((e, mu), &mut Random(1), 0.0);
        // Motions have a relative error of about 1e-12, and impacts multiply it.
        near(&fitted(&throws(BOTH, ""), &data), &[e, mu], 1e-9);
    }
}

/// How many of the draws have the truth within two standard deviations, for each parameter.
fn covered(draws: u64) -> [usize; 2] {
    let (scene, truth) = (scene(&throws(BOTH, "")), [0.7, 0.2]);
    let mut within = [0; 2];
    for draw in 1..=draws {
        let data = both((truth[0], truth[1]), &mut Random(1_000 + 77 * draw), 0.01);
        let estimate = fitted_from(&scene, &data, None);
        assert_eq!(estimate.status, Status::Solved, "{:?}", estimate.diagnosis);
        // The misfit has a chi-squared distribution of 298 degrees of freedom: its root over them deviates by 0.04 from 1.
        assert!(
            (estimate.spread() - 1.0).abs() < 0.2,
            "{}",
            estimate.spread()
        );
        for (k, found) in estimate.parameters.iter().enumerate() {
            let deviation = found.deviation.expect("determined");
            within[k] += usize::from((found.value - truth[k]).abs() <= 2.0 * deviation);
        }
    }
    within
}

#[test]
fn truth_lies_within_two_deviations_in_most_draws() {
    // Each of the 16 does so with a probability of 0.954: fewer than 12 have one of 3e-4.
    let within = covered(8);
    assert!(within[0] + within[1] >= 12, "{within:?}");
}

#[test]
#[ignore = "long"]
fn truth_lies_within_two_deviations_in_about_95_of_100_draws() {
    // The number is binomial with the mean 95.4 and the deviation 2.1.
    for within in covered(100) {
        assert!((90..=100).contains(&within), "{within}");
    }
}

#[test]
fn search_leads_to_the_truth_from_nearly_all_starts_half_of_it_away() {
    let truth = [0.62, 0.17];
    let data = both((truth[0], truth[1]), &mut Random(5), 0.0);
    let mut random = Random(99);
    let mut reached = 0;
    for _ in 0..20 {
        let mut scene = scene(&throws(BOTH, ""));
        for (index, truth) in [(2, truth[0]), (3, truth[1])] {
            scene.set_parameter(index, truth * random.within(0.5, 1.5));
        }
        let estimate = fitted_from(&scene, &data, Some(1));
        let found = estimate.parameters.iter().zip(truth);
        let right = found
            .into_iter()
            .all(|(found, truth)| (found.value - truth).abs() < 1e-8);
        reached += usize::from(estimate.status == Status::Solved && right);
    }
    assert!(reached >= 19, "{reached}");
}

#[test]
fn huber_finds_what_outliers_take_from_squares() {
    let truth = [0.7, 0.2];
    let mut data = both((truth[0], truth[1]), &mut Random(21), 0.01);
    // A third of a metre off, in one of 15 measurements: 33 deviations.
    for rows in data.iter_mut() {
        for row in rows.values.iter_mut().step_by(15) {
            row[1] += 0.33;
        }
    }
    let off = |loss: &str| {
        let estimate = fitted(&throws(BOTH, loss), &data);
        assert_eq!(estimate.status, Status::Solved, "{:?}", estimate.diagnosis);
        let known = estimate.parameters[0].deviation.expect("determined");
        ((estimate.parameters[0].value - truth[0]).abs(), known)
    };
    let ((robust, deviation), (squares, _)) = (off(", huber"), off(""));
    assert!(
        robust < 4.0 * deviation && 5.0 * robust < squares,
        "{robust} {squares}"
    );
}

#[test]
fn mass_and_damping_of_a_rider_follow_from_a_forced_motion() {
    // x = Re(a exp(i w t)) + transient of m x'' + c x' + k x = F cos(w t), from rest at 0.
    let (m, c, k, force, w) = (82.0_f64, 150.0_f64, 20_000.0_f64, 900.0_f64, 9.0_f64);
    let (real, imaginary) = (k - m * w * w, c * w);
    let size = force / (real * real + imaginary * imaginary);
    let (a, b) = (size * real, size * imaginary);
    let decay = c / (2.0 * m);
    let own = (k / m - decay * decay).sqrt();
    let motion = |t: f64| {
        // The transient cancels position and velocity at the start.
        let (p, q) = (-a, (-b * w - decay * a) / own);
        let steady = a * (w * t).cos() + b * (w * t).sin();
        vec![steady + (-decay * t).exp() * (p * (own * t).cos() + q * (own * t).sin())]
    };
    let text = "parameters { k: N/m = 20000, force: N = 900, w: 1/s = 9 }
        free m: kg in 20..=200 = 60 free c: N*s/m in 0..=1000 = 300
        coordinates { x: m } lagrangian m/2*dot(x)^2 - k/2*x^2 dissipation c/2*dot(x)^2
        forces { x: force*cos(w*t) } outputs { seen: mm = x }
        measured ride: \"ride.csv\" { seen within 1 [mm] } minimize misfit(ride)";
    let data = exact(every(0.05, 60), |t| vec![1e3 * motion(t)[0]]);
    near(&fitted(text, &[data]), &[m, c], 1e-9);
}

#[test]
fn experiments_share_parameters_and_have_starts_that_read_them() {
    // Drops from three heights with one unknown speed, and one unknown restitution.
    let (e, speed) = (0.6, 1.3);
    let text = "parameters { m: kg = 1, g: m/s^2 = 9.81 }
        free e in 0.1..=1 = 0.8 free speed: m/s in -5..=5 = 0
        coordinates { z: m } lagrangian m/2*dot(z)^2 - m*g*z surface floor: z >= 0 impact floor: restitution e
        start { z: 1 [m], dot(z): speed }
        measured low: \"1.csv\" { z within 1 [mm] }
        measured middle: \"2.csv\" { z within 1 [mm], start { z: 2 [m] } }
        measured high: \"3.csv\" { dot(z) within 1 [cm/s], start { z: 3 [m], dot(z): -2*speed } }
        minimize misfit(low) + misfit(middle) + misfit(high)";
    let z =
        |height: f64, speed: f64| move |t: f64| vec![thrown([height, 0.0, speed], (e, 0.0), t)[1]];
    // The data of the second begin behind its first impact, at 0.78 s; those of the third are velocities, by differences of
    // parabolas, which are exact.
    let high = |t: f64| {
        let at = z(3.0, -2.0 * speed);
        vec![(at(t + 1e-3)[0] - at(t - 1e-3)[0]) / 2e-3]
    };
    let data = [
        exact(every(0.05, 25), z(1.0, speed)),
        exact(every(0.05, 30).filter(|t| *t > 0.8), z(2.0, speed)),
        exact(every(0.06, 14), high),
    ];
    near(&fitted(text, &data), &[e, speed], 1e-9);
}

#[test]
fn friction_follows_from_where_a_block_stops() {
    // y = v t - mu g t^2/2 up to t = v/(mu g) = 1.131 s, and v^2/(2 mu g) behind that.
    let (mu, v) = (0.2703, 3.0);
    let motion = |t: f64| {
        let t = t.min(v / (mu * G));
        vec![v * t - 0.5 * mu * G * t * t]
    };
    let text = "parameters { m: kg = 1, g: m/s^2 = 9.81 } free mu in 0.01..=2 = 0.5
        coordinates { y: m, z: m } lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        surface floor: z >= 0 impact floor: inelastic, friction mu, sliding dot(y)
        start { dot(y): 3 [m/s] } measured slide: \"s.csv\" { y within 5 [mm] } minimize misfit(slide)";
    near(&fitted(text, &[exact(every(0.1, 20), motion)]), &[mu], 1e-9);
}

#[test]
fn what_the_data_do_not_determine_is_named() {
    // A free fall knows no mass.
    let fall = "parameters { g: m/s^2 = 9.81 } free m: kg in 1..=9 = 2 free v0: m/s in 0..=9 = 1
        coordinates { z: m } lagrangian m/2*dot(z)^2 - m*g*z start { dot(z): v0 }
        measured fall: \"f.csv\" { z within 1 [cm] } minimize misfit(fall)";
    let data = exact(every(0.1, 10), |t| vec![4.0 * t - 0.5 * G * t * t]);
    let estimate = fitted(fall, &[data]);
    assert_eq!(estimate.status, Status::Undetermined);
    assert_eq!(
        estimate.undetermined[0].text,
        "no measurement changes with `m`"
    );
    assert!(estimate.diagnosis.expect("said").contains("`m`"));
    let [mass, speed] = &estimate.parameters[..] else {
        panic!()
    };
    assert!(mass.deviation.is_none() && mass.value == 2.0);
    assert!((speed.value - 4.0).abs() < 1e-9 && speed.deviation.is_some());
    // A free oscillation knows the ratio of stiffness and mass only.
    let spring = "free k: N/m in 10..=90 = 30 free m: kg in 1..=9 = 2
        coordinates { x: m } lagrangian m/2*dot(x)^2 - k/2*x^2 start { x: 0.1 [m] }
        measured swing: \"s.csv\" { x within 1 [mm] } minimize misfit(swing)";
    let data = exact(every(0.05, 40), |t| vec![0.1 * (20.0_f64.sqrt() * t).cos()]);
    let estimate = fitted(spring, &[data]);
    assert_eq!(
        estimate.status,
        Status::Undetermined,
        "{:?}",
        estimate.diagnosis
    );
    let [k, m] = [0, 1].map(|j| estimate.parameters[j].value);
    assert!((k / m - 20.0).abs() < 1e-8);
    let changes = &estimate.undetermined[0].changes;
    let [(0, along_k), (1, along_m)] = changes[..] else {
        panic!("{changes:?}")
    };
    // The ratio stays along (dk, dm) = (k, m).
    assert!((along_k / along_m - 20.0).abs() < 1e-5, "{changes:?}");
}

#[test]
fn parameter_ends_at_the_bound_that_the_data_press_against() {
    let data = both((0.7, 0.2), &mut Random(1), 0.0);
    let estimate = fitted(
        &throws("free e in 0..=0.65 = 0.5 free mu in 0..=1 = 0.3", ""),
        &data,
    );
    assert_eq!(estimate.status, Status::Solved, "{:?}", estimate.diagnosis);
    let e = &estimate.parameters[0];
    assert!(e.at_bound && e.value == 0.65 && e.gradient < 0.0 && e.deviation.is_none());
    assert!(
        estimate
            .notes
            .iter()
            .any(|note| note.starts_with("`e` ends at a bound"))
    );
    assert!(
        estimate
            .notes
            .iter()
            .any(|note| note.contains("times as large as the standard"))
    );
}

#[test]
fn covariance_is_that_of_a_straight_line() {
    // z = v t without gravity, seen at t_k with the deviation s: the variance of v is s^2/sum t_k^2.
    let text = "free v: m/s in 0..=9 = 1 parameters { m: kg = 1 } coordinates { z: m } lagrangian m/2*dot(z)^2
        start { dot(z): v } measured way: \"w.csv\" { z within 2 [cm] } minimize misfit(way)";
    let data = exact(every(0.1, 10), |t| vec![2.0 * t]);
    let estimate = fitted(text, &[data]);
    near(&estimate, &[2.0], 1e-12);
    let wanted = 0.02 / (0.01_f64 * 385.0).sqrt();
    let deviation = estimate.parameters[0].deviation.expect("determined");
    assert!(
        (deviation - wanted).abs() < 1e-9 * wanted
            && (estimate.covariance[0][0] - wanted * wanted).abs() < 1e-12
    );
    assert_eq!((estimate.measurements, estimate.optima.len()), (10, 1));
}

#[test]
fn wrong_measurements_and_scenes_are_refused_by_name() {
    let text = throws(BOTH, "");
    let good = both((0.7, 0.2), &mut Random(1), 0.0);
    let refused = |text: &str, data: &[Measurements]| {
        let result = estimate(&scene(text), data, &Settings::default(), &mut |_| true);
        result.expect_err("refused").to_string()
    };
    let with = |change: fn(&mut Measurements)| {
        let mut data = good.clone();
        change(&mut data[1]);
        data
    };
    for (data, reason) in [
        (
            with(|data| data.times[3] = f64::NAN),
            "a time of `second` is NaN",
        ),
        (
            with(|data| data.times[3] = 0.0),
            "a time of `second` = 0 s: must be at least 0.06 s",
        ),
        (
            with(|data| data.values[3].truncate(1)),
            "a row of `second` has 1 components, expected 2",
        ),
        (
            with(|data| data.values.iter_mut().for_each(|row| row[1] = f64::NAN)),
            "`z` of `second` has no value at any time",
        ),
        (
            with(|data| *data = Measurements::default()),
            "nothing is measured of `second` behind the start",
        ),
    ] {
        let message = refused(&text, &data);
        assert!(message.contains(reason), "{message}");
    }
    assert!(
        refused(&text, &good[..1])
            .contains("the list of measurements has 1 components, expected 2")
    );
    let given = throws("parameters { e = 0.5, mu = 0.3 }", "");
    assert!(refused(&given, &good).contains("has no free parameter"));
}

#[test]
fn stiffness_of_a_stop_follows_through_the_kink_of_its_force() {
    let text = "
        parameters { m: kg = 0.7 } free k: N/m in 10..=100 = 30 free v0: m/s in 0.5..=3 = 1
        coordinates { x: m } lagrangian m/2*dot(x)^2 forces { x: -k*max(x, 0[m]) }
        start { x: -0.5, dot(x): v0 }
        measured run: \"a.csv\" { x within 1 [mm] } minimize misfit(run)
    ";
    let motion = |t: f64| {
        let (k, v0) = (43.0_f64, 1.2);
        let (rate, arrives) = ((k / 0.7).sqrt(), 0.5 / v0);
        let since = t - arrives;
        let x = match since {
            since if since < 0.0 => v0 * since,
            since if since < PI / rate => v0 / rate * (rate * since).sin(),
            since => -v0 * (since - PI / rate),
        };
        vec![x]
    };
    // Exact data leave the error of the motion, 1e-10 or less, over deviations of about 0.1 % a millimetre.
    near(
        &fitted(text, &[exact(every(0.05, 30), motion)]),
        &[43.0, 1.2],
        1e-7,
    );
}

#[test]
fn slope_follows_from_a_disc_that_rolls_by_a_joint() {
    let text = "
        parameters { m: kg = 2, r: m = 0.3, g: m/s^2 = 9.6 } free angle: rad in 0..=1 = 0.4 free v0: m/s in 0..=3 = 1
        coordinates { x: m, phi: rad }
        lagrangian m/2*dot(x)^2 + m*r^2/4*dot(phi)^2 + m*g*x*sin(angle)
        joint roll: dot(x) == r*dot(phi)
        start { x: 0 [m], dot(x): v0, dot(phi): v0/r*1[rad] }
        measured run: \"a.csv\" { x within 1 [mm] } minimize misfit(run)
    ";
    let motion = |t: f64| vec![0.7 * t + 9.6 * 0.25_f64.sin() * t * t / 3.0];
    near(
        &fitted(text, &[exact(every(0.05, 30), motion)]),
        &[0.25, 0.7],
        1e-7,
    );
}

#[test]
fn thresholds_of_a_thermostat_follow_from_its_temperatures() {
    let text = "
        parameters { h: 1/s = 1.3, tau: s = 2 } free warm in 1.5..=2.3 = 1.8 free cold in 0.5..=1.4 = 1
        states { x, on } rates { x: on*h - x/tau } when x >= warm { on = 0 } when x <= cold { on = 1 }
        start { x: 0.2, on: 1 }
        measured run: \"a.csv\" { x within 0.01 } minimize misfit(run)
    ";
    let (warm, cold) = (1.9_f64, 1.1);
    // Heated x goes to 2.6, cooled to 0.
    let motion = |t: f64| {
        let (mut x, mut rest, mut on) = (0.2_f64, t, true);
        loop {
            let (goal, to) = if on { (2.6, warm) } else { (0.0, cold) };
            let lasts = 2.0 * ((goal - x) / (goal - to)).ln();
            if rest <= lasts {
                return vec![goal - (goal - x) * (-rest / 2.0).exp()];
            }
            (x, rest, on) = (to, rest - lasts, !on);
        }
    };
    near(
        &fitted(text, &[exact(every(0.07, 80), motion)]),
        &[warm, cold],
        1e-8,
    );
}

/// A cart on a floor, pushed by a hand.
const CART: &str = "
    free m: kg in 0.5..=8 = 4 free mu in 0.02..=0.9 = 0.1
    controls { u: N in -50..=50 }
    coordinates { y: m, z: m } lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*9.81[m/s^2]*z
    surface floor: z >= 0 impact floor: inelastic, friction mu, sliding dot(y)
    forces { y: u }
    measured push: \"a.csv\" { y within 1 [mm] } minimize misfit(push)
";

#[test]
fn mass_and_friction_follow_from_a_cart_that_is_pushed_as_is_known() {
    let (m, mu) = (2.1, 0.23);
    let pushes = [(0.0, 12.0), (0.5, 7.0), (1.0, 0.0)];
    // With each push at a constant acceleration, until it stands.
    let motion = |t: f64| {
        let (mut y, mut v) = (0.0, 0.0);
        for (k, (from, push)) in pushes.iter().enumerate() {
            let until = pushes.get(k + 1).map_or(t, |next| t.min(next.0));
            let rate = push / m - mu * G;
            let lasts = (until - from).max(0.0);
            let moves = if rate < 0.0 {
                lasts.min(v / -rate)
            } else {
                lasts
            };
            y += v * moves + 0.5 * rate * moves * moves;
            v += rate * moves;
        }
        vec![y]
    };
    let mut data = exact(every(0.04, 60), motion);
    data.controls = ControlSignal::PiecewiseConstant {
        times: pushes.iter().map(|push| push.0).collect(),
        values: pushes.iter().map(|push| vec![push.1]).collect(),
    };
    // Exact data leave the error of the motion over what a millimetre says.
    near(&fitted(CART, &[data.clone()]), &[m, mu], 1e-8);
    data.controls = ControlSignal::Zero;
    let refused = estimate(&scene(CART), &[data], &Settings::default(), &mut |_| true);
    let refused = refused.expect_err("unknown").to_string();
    assert!(
        refused.contains("nothing says what the control `u` was in `push`"),
        "{refused}"
    );
}
