//! Goals that no controls reach: where that is shown, a problem is called infeasible, and elsewhere a search has found nothing.
//!
//! An affine goal on coordinates may lie beyond their bounds, whatever moves them.
//!
//! Without contacts, with a final time that is given, and where accelerations are affine in the controls and read nothing else, the final
//! state is an integral, `q(T) = q + v T + int (T - t) (c + B u) dt`, `v(T) = v + int (c + B u) dt`. For affine goals `g` and weights `y` of
//! theirs (at least 0 where a goal is an inequality) the largest `y'g` over all controls within their bounds, whatever their shape, is
//! a closed form, as each control acts by a factor that is linear in time. Where it is negative, no control reaches the goals (Farkas):
//! they need a `y'g` of at least 0. The weights are the residuals at the nearest point that can be reached, by the method of Frank and Wolfe
//! (Gilbert 1966).

use crate::model::{Function, Model};
use crate::ocp::collocation::discretization::parabolas;
use crate::ocp::problem::{Horizon, Problem, bounds};
use crate::ocp::tuning::equal::ROUNDING;
use crate::ocp::tuning::impossible::{LONGEST, PRECISION, STEPS};

/// What is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shown {
    /// Some controls come near, or it is not known.
    Nothing,
    /// No controls reach the goals in the given time; in no less than that many seconds, if any are known.
    Impossible { least_time: Option<f64> },
}

/// Whether no controls within their bounds reach the goals.
pub(super) fn shown(model: &dyn Model, problem: &Problem) -> Shown {
    if is_out_of_bounds(model, problem) {
        return Shown::Impossible { least_time: None };
    }
    let Horizon::Fixed(horizon) = problem.horizon else {
        return Shown::Nothing;
    };
    let Some(goals) = Goals::of(model, problem, horizon) else {
        return Shown::Nothing;
    };
    if !goals.are_impossible(horizon) {
        return Shown::Nothing;
    }
    let (mut short, mut long) = (horizon, 2.0 * horizon);
    while goals.are_impossible(long) {
        if long > LONGEST * horizon {
            return Shown::Impossible { least_time: None };
        }
        (short, long) = (long, 2.0 * long);
    }
    while long > short * (1.0 + PRECISION) {
        let middle = 0.5 * (short + long);
        if goals.are_impossible(middle) {
            short = middle;
        } else {
            long = middle;
        }
    }
    Shown::Impossible {
        least_time: Some(long),
    }
}

/// Whether an affine goal on coordinates lies beyond what their bounds let it be, whatever moves them.
fn is_out_of_bounds(model: &dyn Model, problem: &Problem) -> bool {
    let declaration = model.declaration();
    let Some(declared) = declaration.optimal_control else {
        return false;
    };
    if !declared.terminal_hessian.entries.is_empty() {
        return false;
    }
    let n = problem.q.len();
    let (lower, upper) = bounds(model);
    let mut z = problem.start();
    z.resize(declaration.terminal_inputs().max(2 * n + 1), 0.0);
    let mut values = vec![0.0; declared.terminal_functions()];
    let mut slopes = vec![0.0; declared.terminal_jacobian.entries.len()];
    model.values(Function::Terminal, &z, &mut values);
    model.jacobian(Function::Terminal, &z, &mut slopes);
    let first = usize::from(declared.final_cost);
    let entries = declared.terminal_jacobian.entries.iter().zip(&slopes);
    declared.goals.iter().enumerate().any(|(goal, known)| {
        let value = values[first + goal];
        let (mut least, mut most, mut size) = (value, value, value.abs());
        let own = entries
            .clone()
            .filter(|((row, _), _)| *row as usize == first + goal);
        for (&(_, column), &slope) in own {
            let k = column as usize;
            if k >= n {
                return false;
            }
            let ends = [lower[k], upper[k]].map(|bound| slope * (bound - z[k]));
            least += ends[0].min(ends[1]);
            most += ends[0].max(ends[1]);
            size += (slope * z[k]).abs();
        }
        let room = ROUNDING * size;
        most < -room || known.equality && least > room
    })
}

/// Affine goals of a motion that is an integral of its controls.
struct Goals {
    /// Values at the declared start, and slopes by the components of `(q, v)`.
    values: Vec<f64>,
    slopes: Vec<Vec<f64>>,
    equalities: Vec<bool>,
    /// Ranges of the components of `(q, v)` at the start, less the declared values.
    start: Vec<(f64, f64)>,
    /// Declared velocities.
    velocities: Vec<f64>,
    /// Accelerations without controls, and by each of them, of each coordinate.
    free: Vec<f64>,
    driven: Vec<Vec<f64>>,
    /// Ranges of the controls.
    controls: Vec<(f64, f64)>,
    /// Whether each goal can have a weight: no control without a bound acts on it.
    counts: Vec<bool>,
}

impl Goals {
    /// The goals of a problem, if they and its motion are of that kind.
    fn of(model: &dyn Model, problem: &Problem, horizon: f64) -> Option<Self> {
        let declaration = model.declaration();
        let declared = declaration.optimal_control?;
        let n = problem.q.len();
        let start = problem.start();
        let integral = parabolas(model, &start).iter().all(|&parabola| parabola);
        let affine = declared.terminal_hessian.entries.is_empty()
            && declaration.free_hessian.entries.is_empty();
        let plain = declaration.contacts.is_empty() && !declaration.explicit_time;
        if !(integral && affine && plain) || declared.goals.is_empty() {
            return None;
        }
        let mut z = start.clone();
        z.push(horizon);
        z.resize(declaration.terminal_inputs(), 0.0);
        let first = usize::from(declared.final_cost);
        let mut values = vec![0.0; declared.terminal_functions()];
        model.values(Function::Terminal, &z, &mut values);
        let entries = declared.terminal_jacobian.entries;
        let mut all = vec![0.0; entries.len()];
        model.jacobian(Function::Terminal, &z, &mut all);
        let mut slopes = vec![vec![0.0; 2 * n]; declared.goals.len()];
        for (&(row, column), &slope) in entries.iter().zip(&all) {
            let Some(goal) = (row as usize).checked_sub(first) else {
                continue;
            };
            // A goal that reads the time is another one at each.
            *slopes[goal].get_mut(column as usize)? = slope;
        }
        let (lower, upper) = bounds(model);
        let ranges = problem.start_ranges(model).into_iter().zip(&start);
        let mut x = start.clone();
        x.resize(declaration.inputs(), 0.0);
        let mut free = vec![0.0; n];
        model.free_acceleration(&x, &mut free);
        let driven = (0..declaration.controls.len()).map(|control| {
            let mut x = x.clone();
            x[2 * n + control] = 1.0;
            let mut pushed = vec![0.0; n];
            model.free_acceleration(&x, &mut pushed);
            pushed.iter().zip(&free).map(|(a, b)| a - b).collect()
        });
        let driven: Vec<Vec<f64>> = driven.collect();
        let controls: Vec<(f64, f64)> = (n..lower.len()).map(|k| (lower[k], upper[k])).collect();
        let acts = |slopes: &[f64], a: &[f64]| {
            (0..n).any(|k| a[k] != 0.0 && (slopes[k] != 0.0 || slopes[n + k] != 0.0))
        };
        let counts = slopes.iter().map(|slopes| {
            let mut pairs = controls.iter().zip(&driven);
            !pairs.any(|((lower, upper), a)| !(upper - lower).is_finite() && acts(slopes, a))
        });
        let counts = counts.collect();
        Some(Self {
            values: values[first..].to_vec(),
            slopes,
            equalities: declared.goals.iter().map(|goal| goal.equality).collect(),
            start: ranges.map(|((l, u), at)| (l - at, u - at)).collect(),
            velocities: problem.v.clone(),
            free,
            driven,
            controls,
            counts,
        })
    }

    /// Whether weights show that no controls reach the goals in that time.
    fn are_impossible(&self, horizon: f64) -> bool {
        let count = self.values.len();
        let sizes: Vec<f64> = (0..count).map(|goal| self.size(goal, horizon)).collect();
        let Some(mut reached) = self.most(&vec![0.0; count], horizon) else {
            return false;
        };
        for _ in 0..STEPS {
            // Each goal counts by its own size.
            let residuals = reached.iter().zip(&self.equalities);
            let weights: Vec<f64> = residuals
                .zip(sizes.iter().zip(&self.counts))
                .map(|((&value, &equality), (size, &counts))| {
                    if !counts {
                        return 0.0;
                    }
                    let missing = if equality { value } else { value.min(0.0) };
                    -missing / (size * size)
                })
                .collect();
            let Some(most) = self.most(&weights, horizon) else {
                return false;
            };
            let sum =
                |values: &[f64]| -> f64 { values.iter().zip(&weights).map(|(g, y)| g * y).sum() };
            let terms: f64 = weights
                .iter()
                .zip(&sizes)
                .map(|(y, size)| (y * size).abs())
                .sum();
            // The goals are reached, up to rounding.
            if terms <= ROUNDING {
                return false;
            }
            if sum(&most) < -ROUNDING * terms {
                return true;
            }
            let gain = sum(&most) - sum(&reached);
            let curvature: f64 = most
                .iter()
                .zip(&reached)
                .zip(&sizes)
                .map(|((a, b), size)| ((a - b) / size).powi(2))
                .sum();
            if !(gain > 0.0 && curvature > 0.0) {
                return false;
            }
            let share = (gain / curvature).min(1.0);
            for (reached, most) in reached.iter_mut().zip(&most) {
                *reached += share * (most - *reached);
            }
        }
        false
    }

    /// Size of what a goal adds up.
    fn size(&self, goal: usize, horizon: f64) -> f64 {
        let n = self.velocities.len();
        let slopes = &self.slopes[goal];
        let moved = (0..n).map(|k| {
            let (v, a) = (self.velocities[k].abs(), self.free[k].abs());
            (slopes[k] * horizon * (v + horizon * a)).abs() + (slopes[n + k] * horizon * a).abs()
        });
        let size = self.values[goal].abs() + moved.sum::<f64>();
        let ways = self
            .controls
            .iter()
            .zip(&self.driven)
            .map(|(&(lower, upper), a)| {
                let most = lower.abs().max(upper.abs());
                let by = (0..n).map(|k| (slopes[k] * horizon + slopes[n + k]).abs() * a[k].abs());
                by.sum::<f64>() * horizon * most
            });
        let size = ways
            .filter(|way| way.is_finite())
            .fold(size, |size, way| size + way);
        if size > 0.0 { size } else { 1.0 }
    }

    /// The goals' values that controls and start reach where their sum by weights is largest; `None` where it has no bound.
    fn most(&self, weights: &[f64], horizon: f64) -> Option<Vec<f64>> {
        let n = self.velocities.len();
        let weighted = |k: usize| -> f64 {
            weights
                .iter()
                .zip(&self.slopes)
                .map(|(y, slopes)| y * slopes[k])
                .sum()
        };
        // Change of the final `(q, v)` from the declared start.
        let mut end = vec![0.0; 2 * n];
        for k in 0..n {
            end[k] += horizon * (self.velocities[k] + 0.5 * horizon * self.free[k]);
            end[n + k] += horizon * self.free[k];
        }
        for k in 0..n {
            let position = chosen(weighted(k), self.start[k])?;
            let speed = chosen(weighted(n + k) + horizon * weighted(k), self.start[n + k])?;
            end[k] += position + horizon * speed;
            end[n + k] += speed;
        }
        for (range, a) in self.controls.iter().zip(&self.driven) {
            // The factor of the control, `at_end + rate (T - t)`, changes sign once at most.
            let sum = |weight: &dyn Fn(usize) -> f64| -> f64 {
                a.iter().enumerate().map(|(k, a)| a * weight(k)).sum()
            };
            let (rate, at_end) = (sum(&weighted), sum(&|k| weighted(n + k)));
            let turn = (-at_end / rate).clamp(0.0, horizon);
            let turn = if turn.is_finite() { turn } else { 0.0 };
            for (from, to) in [(0.0, turn), (turn, horizon)] {
                // Times to go.
                let length = to - from;
                if length <= 0.0 {
                    continue;
                }
                let u = chosen(at_end + rate * 0.5 * (from + to), *range)?;
                for k in 0..n {
                    end[k] += u * a[k] * length * 0.5 * (from + to);
                    end[n + k] += u * a[k] * length;
                }
            }
        }
        let values = self.values.iter().zip(&self.slopes);
        let values = values.map(|(value, slopes)| {
            value
                + slopes
                    .iter()
                    .zip(&end)
                    .map(|(s, change)| s * change)
                    .sum::<f64>()
        });
        Some(values.collect())
    }
}

/// The end of a range that a factor makes largest, or what is nearest to 0 in it without one; `None` where that is infinite.
fn chosen(factor: f64, (lower, upper): (f64, f64)) -> Option<f64> {
    let end = if factor > 0.0 {
        upper
    } else if factor < 0.0 {
        lower
    } else {
        0.0_f64.max(lower).min(upper)
    };
    end.is_finite().then_some(end)
}

#[cfg(test)]
mod tests {
    use super::{Shown, shown};
    use crate::ocp::problem::{Horizon, Problem};

    crate::model! {
        /// A cart that is to stop elsewhere.
        Stopped {
            parameters { m: kg = 3, far: m = 2, most: N = 5 }
            coordinates { y: m }
            controls { u: N in -most..=most }
            lagrangian m/2*dot(y)^2
            forces { y: u }
            minimize integral(u^2)
            finally { y == far, dot(y) == 0 }
            horizon 1 [s]
        }
    }

    crate::model! {
        /// A cart that nothing bounds, beside one that nothing moves.
        Idle {
            parameters { far: m = 0 }
            coordinates { y: m, z: m }
            controls { u: N }
            lagrangian (dot(y)^2 + dot(z)^2)/2*1[kg]
            forces { y: u }
            minimize integral(u^2)
            finally { y == 1 [m], z >= far }
            start { dot(z): 2 [m/s] }
            horizon 1 [s]
        }
    }

    fn within(model: &dyn crate::model::Model, horizon: f64) -> Shown {
        let problem = Problem {
            horizon: Horizon::Fixed(horizon),
            ..Problem::of(model, 5)
        };
        shown(model, &problem)
    }

    crate::model! {
        /// Two carts between walls whose mean is to be somewhere.
        Between {
            parameters { mean: m = 0 }
            coordinates { y: m in -1..=2, z: m in 0..=4 }
            controls { u: N }
            lagrangian (dot(y)^2 + dot(z)^2)/2*1[kg] - 3[J/m^3]*y^3
            forces { z: u }
            minimize time
            finally { (y + z)/2 == mean, dot(z) == 0 }
        }
    }

    #[test]
    fn goal_beyond_bounds_is_impossible_whatever_moves_it() {
        for (mean, impossible) in [(-0.6, true), (-0.4, false), (2.9, false), (3.1, true)] {
            let between = Between { mean };
            let shown = shown(&between, &Problem::of(&between, 3));
            let expected = if impossible {
                Shown::Impossible { least_time: None }
            } else {
                Shown::Nothing
            };
            assert_eq!(shown, expected, "{mean}");
        }
    }

    #[test]
    fn rest_elsewhere_takes_as_long_as_full_force_back_and_forth() {
        for (m, far, most) in [(3.0, 2.0, 5.0), (1e-6, 4e-7, 2e-9), (7e8, 3e9, 1e4)] {
            let cart = Stopped { m, far, most };
            let least = 2.0 * (m * far / most).sqrt();
            for share in [1e-2, 0.5, 0.99] {
                let Shown::Impossible {
                    least_time: Some(time),
                } = within(&cart, share * least)
                else {
                    panic!("{share} of {least}");
                };
                assert!((time / least - 1.0).abs() < 3e-3, "{time} {least}");
            }
            for share in [1.01, 3.0] {
                assert_eq!(within(&cart, share * least), Shown::Nothing);
            }
        }
    }

    #[test]
    fn what_only_drifts_is_impossible_where_it_is_not_and_unbounded_controls_show_nothing() {
        assert_eq!(within(&Idle { far: 1.9 }, 1.0), Shown::Nothing);
        let Shown::Impossible {
            least_time: Some(time),
        } = within(&Idle { far: 5.0 }, 1.0)
        else {
            panic!("it gets to 2 m");
        };
        assert!((time - 2.5).abs() < 5e-3, "{time}");
    }
}
