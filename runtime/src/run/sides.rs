//! Which sides of switches act where their functions vanish.
//!
//! A choice of sides gives a motion, and it agrees with itself if each function then has the sign of its side:
//!
//! ```text
//! v' = a - sum_k sigma_k D_k e_k,   sigma_k = +-1:     sigma_k c_k(t + h) >= 0 for all k and all small h
//! ```
//!
//! Where the rate of a function does not vanish and its side does not change it, that rate decides. Where it vanishes too, of a function
//! that is only passed or whose jump `D_k b_k' e_k` vanishes with it, the first derivative decides that does not, along the motion of each
//! choice by itself: all are followed over times that begin far below what can be seen, and the first sign that is more than rounding is
//! that of the leading derivative, whatever its order.
//!
//! One choice that agrees is the motion, two are two motions; so is a function that does not leave zero whatever its side, which matters. Where
//! none agrees every side leads back. The motion stays if it is at rest under a mixture of the sides
//! (an equilibrium of Filippov's inclusion; for certain unless motions close to it turn round it in ever longer times: those
//! have left it a finite time ago), and slides by the law of friction where a jump holds it.
//!
//! Where several functions are held at zero by their jumps, motions beside that zero may still turn round it ever farther away, although no
//! choice of sides leaves it: then there are several motions as well.
//!
//! Source: Filippov, *Differential Equations with Discontinuous Righthand Sides* (1988), paragraphs 15 and 22.

use crate::linalg::products::dot;
use crate::yardstick;
use std::ops::DerefMut;

use super::ahead::{Begun, acceleration, ahead, set_sides};
use super::place::{Place, sizes};
use super::rest::mixture;
use super::turns::turns_outwards;
use crate::contact::{Balance, Line, ModeError, Rest, View};
use crate::model::pair_size;

/// Most switches whose sides are tried in all ways; of more, those change that contradict themselves.
const MOST: usize = 6;
/// Most times that sides are chosen again, as what they change elsewhere is known.
const ROUNDS: usize = 5;
/// Powers of ten of the longest time after which functions are looked at, the shortest first: until they have a sign.
const POWERS: std::ops::RangeInclusive<i32> = -12..=-1;
/// Steps to each of them, so that also what four integrations do not move has a sign.
const LOOKAHEAD: usize = 3;
/// Share by which a function may differ with twice the steps, and how often they are doubled: a motion that is not followed says nothing.
const FOLLOWED: f64 = 0.5;
const DOUBLINGS: usize = 8;
/// Corners of a motion round the common zero of sliding switches that are followed, and the factor by which it comes closer or farther away until
/// it is known to do so. Chosen: a growth of 0.4 % at each corner is seen.
const CORNERS: usize = 1_000;
const FAR: f64 = 30.0;
/// The side of a switch, given that by its rate, if it has one.
type SideOf<'k, H> = dyn Fn(&H, usize, Option<f64>) -> Option<f64> + 'k;

/// What a method knows of the switches at a place.
pub(crate) struct Known<'k, H> {
    pub(crate) side: &'k SideOf<'k, H>,
    /// Size of the rate of a function that is none.
    pub(crate) zero: &'k dyn Fn(&H, usize) -> f64,
}

/// Why there is no balance of forces with sides that agree.
pub(crate) enum Failed<E> {
    /// The law says so.
    Law(E),
    /// The sides do.
    Sides(ModeError),
}

/// The balance of the contacts that touch, which are evaluated at the place, with the sides that act of those switches whose functions
/// vanish: they are written to the view, or the rest in which the motion is. Where sides depend on what the balance `solve`s, it is repeated.
///
/// # Errors
/// Where the law has no solution; where sides give several motions, or none.
pub(crate) fn balanced<'a, H: DerefMut<Target = View<'a>>, E>(
    host: &mut H,
    at: &Place<'_>,
    known: &Known<'_, H>,
    mut solve: impl FnMut(&mut H) -> Result<Balance, E>,
) -> Result<Balance, Failed<E>> {
    host.sides.fill(0.0);
    host.rest = None;
    let passed: Vec<usize> = passed(host, at, known);
    let mut motion = host.free_acceleration().to_vec();
    let mut chosen: Option<Vec<f64>> = None;
    let mut solved = None;
    for round in 0..ROUNDS {
        let before = host.sides.clone();
        let mut slow = Vec::new();
        for &i in &passed {
            let rate = host.line_acceleration(Line::tangent(i), &motion);
            let by_rate = (rate.abs() > (known.zero)(host, i)).then(|| rate.signum());
            let side = (known.side)(host, i, by_rate);
            slow.extend(side.is_none().then_some(i));
            host.sides[i] = side.unwrap_or(1.0);
        }
        // A rate is one of what all act on, which the first balance tells.
        let early = round == 0 && !slow.is_empty();
        if let Some(chosen) = &chosen {
            host.sides.clone_from(chosen);
        } else if !slow.is_empty() && !early {
            let open = |i: &usize| (known.side)(host, *i, None).is_none();
            let open: Vec<usize> = passed.iter().copied().filter(open).collect();
            let none: Vec<f64> = open.iter().map(|&i| (known.zero)(host, i)).collect();
            choose(host, at, (&open, &none)).map_err(Failed::Sides)?;
            chosen = Some(host.sides.clone());
        }
        if solved.is_some() && host.sides == before {
            break;
        }
        let balance = match solve(host) {
            Ok(balance) => balance,
            Err(_) if early => continue,
            Err(error) => return Err(Failed::Law(error)),
        };
        motion.copy_from_slice(host.free_acceleration());
        balance.push(host, &balance.forces, &mut motion);
        solved = Some(balance);
        if passed.is_empty() || host.rest.is_some() {
            break;
        }
    }
    let balance = match solved {
        Some(balance) => balance,
        None => solve(host).map_err(Failed::Law)?,
    };
    match turned_away(host, at, known, &balance) {
        Some(contact) => Err(Failed::Sides(ModeError::NotUnique(contact))),
        None => Ok(balance),
    }
}

/// A switch of several that slide in a balance whose common zero a motion leaves in growing turns.
fn turned_away<'a, H: DerefMut<Target = View<'a>>>(
    host: &mut H,
    at: &Place<'_>,
    known: &Known<'_, H>,
    balance: &Balance,
) -> Option<usize> {
    let rate = |k: usize| balance.slip(k).map_or(f64::INFINITY, pair_size);
    let none = |i: usize| (known.zero)(host, i);
    let switches = at.touching.iter().copied().enumerate();
    let switches = switches.filter(|&(k, i)| host.switch_of(i).is_some() && rate(k) <= none(i));
    let sliding: Vec<(usize, f64)> = switches.map(|(_, i)| (i, none(i))).collect();
    if sliding.len() < 2 || host.rest.is_some() {
        return None;
    }
    let sides = host.sides.clone();
    let leaves = [1.0, -1.0].map(|turn| turns_away(host, at, &sliding, turn));
    host.sides = sides;
    host.evaluate_free_acceleration(at.x);
    for &i in at.touching {
        host.evaluate_sides(i, at.x);
    }
    leaves.contains(&Some(true)).then_some(sliding[0].0)
}

/// Whether a motion that begins beside the common zero of the `sliding` switches, each with the size of a rate that counts as none, turns round
/// that zero ever farther away. So close to it rates depend on the signs of the functions alone, and the motion is a polygon. The functions
/// begin with signs that `turn` from each one to the next. `None` where rates are not known.
fn turns_away(
    view: &mut View<'_>,
    at: &Place<'_>,
    sliding: &[(usize, f64)],
    turn: f64,
) -> Option<bool> {
    let lines: Vec<Line> = sliding.iter().map(|&(i, _)| Line::tangent(i)).collect();
    let rows = view.couplings(&lines);
    let rows = rows.chunks_exact(lines.len());
    let units: Vec<f64> = rows.map(|row| row.iter().map(|k| k.abs()).sum()).collect();
    let begun = units.iter().enumerate();
    let mut values: Vec<f64> = begun
        .map(|(k, unit)| unit * turn.powi(k as i32) / (k + 1) as f64)
        .collect();
    for _ in 0..CORNERS {
        for (&(i, _), value) in sliding.iter().zip(&values) {
            view.sides[i] = if *value == 0.0 { 0.0 } else { value.signum() };
        }
        let motion = acceleration(view, at, at.x, false).ok()?;
        let rate = |&(i, none): &(usize, f64)| {
            let rate = view.line_acceleration(Line::tangent(i), &motion);
            if rate.abs() > none { rate } else { 0.0 }
        };
        let rates: Vec<f64> = sliding.iter().map(rate).collect();
        let meets = |(value, rate): (&f64, &f64)| match value * rate < 0.0 {
            true => -value / rate,
            false => f64::INFINITY,
        };
        let times: Vec<f64> = values.iter().zip(&rates).map(meets).collect();
        let first = times.iter().copied().fold(f64::INFINITY, f64::min);
        if first == f64::INFINITY {
            return Some(false);
        }
        for (value, (rate, time)) in values.iter_mut().zip(rates.iter().zip(times)) {
            *value = if time <= first {
                0.0
            } else {
                *value + first * rate
            };
        }
        let sizes = values.iter().zip(&units);
        let size = sizes.fold(0.0_f64, |most, (value, unit)| most.max(value.abs() / unit));
        if !(1.0 / FAR..=FAR).contains(&size) {
            return Some(size > FAR);
        }
    }
    Some(false)
}

/// The switches whose functions vanish and are only passed there, as their sides do not change their rates.
fn passed<'a, H: DerefMut<Target = View<'a>>>(
    host: &H,
    at: &Place<'_>,
    known: &Known<'_, H>,
) -> Vec<usize> {
    let vanishes = |i: usize| {
        pair_size(host.sliding(i)) <= at.zeros[i] || (known.side)(host, i, None).is_some()
    };
    let jump = |i: usize| {
        let given = -host.free_line_acceleration(Line::normal(i));
        (given * dot(host.tangent(i), host.slip_direction(i))).abs()
    };
    let touching = at.touching.iter().copied();
    let switches = touching.filter(|&i| host.switch_of(i).is_some() && vanishes(i));
    switches
        .filter(|&i| host.passes(i) || jump(i) <= (known.zero)(host, i))
        .collect()
}

/// Chooses the sides of the `open` switches by what follows, with the rates that count as `none`; no sides of those that the law of
/// friction holds.
fn choose(
    view: &mut View<'_>,
    at: &Place<'_>,
    (open, none): (&[usize], &[f64]),
) -> Result<(), ModeError> {
    let follows = follows(view, at, (open, none));
    view.evaluate_free_acceleration(at.x);
    for &i in at.touching {
        view.evaluate_sides(i, at.x);
    }
    let Ok(follows) = follows else {
        // Where no force satisfies the law the balance says so.
        set_sides(view, open, |_| 1.0);
        return Ok(());
    };
    match follows {
        Follows::Sides => Ok(()),
        Follows::Rest(rest) => {
            view.rest = Some(rest);
            Ok(())
        }
        Follows::Several(contact) => Err(ModeError::NotUnique(contact)),
        Follows::Holds => {
            // A jump that begins here pushes back to the zero from either side, as none of them agrees.
            for (&i, column) in open.iter().zip(acting(view, at, open)) {
                let acts = column.iter().any(|e| *e != 0.0);
                if view.passes(i) && acts {
                    return Err(ModeError::SecondOrder(i));
                }
                view.sides[i] = if view.passes(i) { 1.0 } else { 0.0 };
            }
            Ok(())
        }
    }
}

/// What the side 1 of each of the `open` switches takes from the acceleration, as last evaluated.
fn acting(view: &View<'_>, at: &Place<'_>, open: &[usize]) -> Vec<Vec<f64>> {
    let contacts = at.touching.iter().zip(at.columns(view));
    let open = contacts.filter(|(contact, _)| open.contains(contact));
    open.map(|(_, column)| column).collect()
}

/// What follows from a place.
enum Follows {
    /// The sides that act, which the view has now.
    Sides,
    /// The motion rests.
    Rest(Rest),
    /// There are several motions; this switch tells them apart.
    Several(usize),
    /// The motion stays where the functions vanish, and moves on otherwise.
    Holds,
}

/// The side of the `k`-th switch in a choice.
fn side(choice: usize, k: usize) -> f64 {
    if choice >> k & 1 == 0 { 1.0 } else { -1.0 }
}

/// What follows where the functions of the `open` switches vanish, and of some of them the rates: sides are written to the view.
fn follows(
    view: &mut View<'_>,
    at: &Place<'_>,
    (open, none): (&[usize], &[f64]),
) -> Result<Follows, ModeError> {
    if open.len() > MOST {
        return change_sides(view, at, (open, none));
    }
    let choices = 0..1_usize << open.len();
    let signs = choices.map(|choice| signs(view, at, (open, none), choice));
    let signs: Vec<Vec<f64>> = signs.collect::<Result<_, _>>()?;
    let never: Vec<bool> = (0..open.len())
        .map(|k| signs.iter().all(|signs| signs[k] == 0.0))
        .collect();
    let agrees = |&choice: &usize| {
        let mut all = signs[choice].iter().enumerate();
        all.all(|(k, &sign)| {
            let side = side(choice, k);
            if never[k] {
                side > 0.0
            } else {
                sign * side >= 0.0
            }
        })
    };
    let found: Vec<usize> = (0..signs.len()).filter(agrees).collect();
    if let [first, second, ..] = found[..] {
        let differ = (0..open.len()).find(|&k| side(first, k) != side(second, k));
        return Ok(Follows::Several(open[differ.unwrap_or(0)]));
    }
    for (k, contact) in open.iter().enumerate().filter(|(k, _)| never[*k]) {
        // It vanishes from here on, and its sign is anything.
        if matters(view, at, open, k)? {
            return Ok(Follows::Several(*contact));
        }
    }
    if let [only] = found[..] {
        set_sides(view, open, |k| side(only, k));
        let leaves = leaves_at_once(view, at)?;
        set_sides(view, open, |_| 0.0);
        if leaves && rest(view, at).is_some() {
            return Ok(Follows::Several(open[0]));
        }
        set_sides(view, open, |k| side(only, k));
        return Ok(Follows::Sides);
    }
    if open.iter().all(|&i| view.passes(i)) && !jumps(view, at, open)? {
        // What acts is continuous, so that there is one motion; its functions are rounding error.
        set_sides(view, open, |_| 1.0);
        return Ok(Follows::Sides);
    }
    set_sides(view, open, |_| 0.0);
    match rest(view, at) {
        None => Ok(Follows::Holds),
        Some(_) if turns_outwards(view, at, open)? => Ok(Follows::Several(open[0])),
        Some(rest) => Ok(Follows::Rest(rest)),
    }
}

/// Chooses the sides of more switches than all choices of them can be tried: those change that contradict themselves, until none does.
fn change_sides(
    view: &mut View<'_>,
    at: &Place<'_>,
    (open, none): (&[usize], &[f64]),
) -> Result<Follows, ModeError> {
    let mut choice = 0;
    for _ in 0..=2 * open.len() {
        let signs = signs(view, at, (open, none), choice)?;
        let wrong = (0..open.len()).find(|&k| signs[k] * side(choice, k) < 0.0);
        let Some(wrong) = wrong else {
            return Ok(Follows::Sides);
        };
        choice ^= 1 << wrong;
    }
    Ok(Follows::Holds)
}

/// The signs that the functions take along the motion of a choice of sides, which the view has then; 0 of those that do not leave zero.
fn signs(
    view: &mut View<'_>,
    at: &Place<'_>,
    (open, none): (&[usize], &[f64]),
    choice: usize,
) -> Result<Vec<f64>, ModeError> {
    set_sides(view, open, |k| side(choice, k));
    let start = acceleration(view, at, at.x, false)?;
    let sizes = sizes(view, &at.columns(view));
    let begun = open.iter().zip(none);
    let begun = begun.map(|(&i, &none)| Begun::of(view, i, (&start, &sizes), none));
    let begun: Vec<Begun> = begun.collect();
    let mut signs = vec![0.0; open.len()];
    for power in POWERS {
        let h = at.longest * 10.0_f64.powi(power);
        let ways = followed(view, at, (open, &begun), h)?;
        for (sign, way) in signs.iter_mut().zip(ways) {
            if *sign == 0.0 {
                *sign = way.map_or(0.0, f64::signum);
            }
        }
        if signs.iter().all(|sign| *sign != 0.0) {
            break;
        }
    }
    Ok(signs)
}

/// How far the functions of the `open` switches come in a time `h`, by as many steps as the motion asks for; none of those that do not leave
/// zero, or where no steps follow the motion.
fn followed(
    view: &mut View<'_>,
    at: &Place<'_>,
    (open, begun): (&[usize], &[Begun]),
    h: f64,
) -> Result<Vec<Option<f64>>, ModeError> {
    let mut steps = LOOKAHEAD;
    let mut coarse = ways(view, at, (open, begun), (h, steps))?;
    for _ in 0..DOUBLINGS {
        if coarse.iter().all(Option::is_none) {
            break;
        }
        steps *= 2;
        let fine = ways(view, at, (open, begun), (h, steps))?;
        let alike = |(coarse, fine): (&Option<f64>, &Option<f64>)| match (coarse, fine) {
            (Some(coarse), Some(fine)) => (coarse - fine).abs() <= FOLLOWED * fine.abs(),
            _ => coarse.is_none() && fine.is_none(),
        };
        if coarse.iter().zip(&fine).all(alike) {
            return Ok(fine);
        }
        coarse = fine;
    }
    Ok(vec![None; open.len()])
}

/// Follows the motions of all choices in so many steps.
fn ways(
    view: &mut View<'_>,
    at: &Place<'_>,
    (open, begun): (&[usize], &[Begun]),
    (h, steps): (f64, usize),
) -> Result<Vec<Option<f64>>, ModeError> {
    let x = ahead(view, at, (h, steps))?;
    view.evaluate_free_acceleration(&x);
    for &i in at.touching {
        view.evaluate_sides(i, &x);
    }
    let sizes = sizes(view, &at.columns(view));
    let ways = open.iter().zip(begun);
    Ok(ways
        .map(|(&i, begun)| begun.way(view, i, (&x, &sizes), h))
        .collect())
}

/// Whether the acceleration with the sides of the view is none of a rest.
fn leaves_at_once(view: &mut View<'_>, at: &Place<'_>) -> Result<bool, ModeError> {
    let acceleration = acceleration(view, at, at.x, false)?;
    let columns = at.columns(view);
    let scale = sizes(view, &columns);
    let mut rows = acceleration.iter().zip(&scale);
    Ok(rows.any(|(a, scale)| a.abs() > yardstick::PROMISE * scale))
}

/// Whether what acts jumps with the sides of the `open` switches.
fn jumps(view: &mut View<'_>, at: &Place<'_>, open: &[usize]) -> Result<bool, ModeError> {
    acceleration(view, at, at.x, true)?;
    let scale = sizes(view, &at.columns(view));
    Ok(acting(view, at, open).iter().any(|column| {
        let mut rows = column.iter().zip(&scale);
        rows.any(|(g, scale)| g.abs() > yardstick::NOTHING * scale)
    }))
}

/// Whether the motion depends on the side of the `k`-th of the `open` switches, with the side 1 of the others.
fn matters(
    view: &mut View<'_>,
    at: &Place<'_>,
    open: &[usize],
    k: usize,
) -> Result<bool, ModeError> {
    set_sides(view, open, |_| 1.0);
    let one = acceleration(view, at, at.x, false)?;
    let columns = at.columns(view);
    let scale = sizes(view, &columns);
    view.sides[open[k]] = -1.0;
    let other = acceleration(view, at, at.x, false)?;
    let mut rows = one.iter().zip(&other).zip(&scale);
    Ok(rows.any(|((one, other), scale)| (one - other).abs() > yardstick::NOTHING * scale))
}

/// The rest at the place and a moment later, if there is one.
fn rest(view: &mut View<'_>, at: &Place<'_>) -> Option<Rest> {
    let parts = mixture(view, at, 0.0, yardstick::NOTHING)?;
    mixture(view, at, at.later(), yardstick::NOTHING)?;
    Some(Rest {
        contacts: at.touching.to_vec(),
        parts,
    })
}
