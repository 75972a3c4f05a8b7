//! Derivatives of a motion.

use std::collections::BTreeMap;

use hangtime::derivative::{Gradient, GradientMode, SequenceLimit, SequenceRange, Side};
use hangtime::model::Model;
use serde::{Serialize, Serializer};

/// Matrices with a row for each value, and a column for each quantity that it is differentiated by.
#[derive(Serialize)]
pub(super) struct GradientEntry<'a> {
    /// What is differentiated by: the columns.
    with_respect_to: &'a [String],
    /// `forward`, or `adjoint`, which has nothing but chosen values and the objective.
    mode: &'static str,
    /// Of chosen values at the end, and of chosen times of events, by name. Only where they were chosen.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    values: BTreeMap<&'a str, &'a [f64]>,
    /// Of the end of the motion.
    #[serde(rename = "final", skip_serializing_if = "Option::is_none")]
    last: Option<LastEntry<'a>>,
    /// Of the times of events, a row an event.
    #[serde(skip_serializing_if = "Option::is_none")]
    event_times: Option<&'a [Vec<f64>]>,
    /// Of outputs, by name, a row for each row of the trajectory.
    #[serde(skip_serializing_if = "Option::is_none")]
    outputs: Option<BTreeMap<&'static str, Vec<&'a [f64]>>>,
    /// Of the objective. Only of scenes that declare one that reads nothing of contacts.
    #[serde(skip_serializing_if = "Option::is_none")]
    objective: Option<&'a [f64]>,
    /// How far each quantity may go until the motion has another sequence of events, to first order. Only of `forward` derivatives.
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<Vec<RangeEntry<'a>>>,
    /// `true`, or why there is no derivative by some quantity.
    exists: Existence<'a>,
    /// By quantity `true`, or why there is no derivative by it. Only where there is none by some of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    exists_by: Option<Vec<Existence<'a>>>,
    /// Of the end to both sides, only where there are no others; null by other quantities.
    #[serde(skip_serializing_if = "Option::is_none")]
    one_sided: Option<OneSidedEntry<'a>>,
}

/// Null to a side that nothing ends.
#[derive(Serialize)]
pub(super) struct RangeEntry<'a> {
    /// Towards smaller values.
    below: Option<LimitEntry<'a>>,
    /// Towards larger values.
    above: Option<LimitEntry<'a>>,
}

/// What ends a range.
#[derive(Serialize)]
struct LimitEntry<'a> {
    /// Change of the quantity, in its unit; below 0 towards smaller values.
    change: f64,
    /// What is another then.
    because: &'a str,
}

impl<'a> RangeEntry<'a> {
    pub(super) fn new(range: &'a SequenceRange) -> Self {
        let side = |limit: &'a Option<SequenceLimit>| {
            limit.as_ref().map(|limit| LimitEntry {
                change: limit.change,
                because: &limit.because,
            })
        };
        Self {
            below: side(&range.below),
            above: side(&range.above),
        }
    }
}

/// Null where there is no derivative to that side.
#[derive(Serialize)]
struct OneSidedEntry<'a> {
    /// Below the value of the parameter; null where there is none.
    below: SideEntry<'a>,
    /// Above it; null where there is none.
    above: SideEntry<'a>,
}

/// Derivatives to one side.
#[derive(Serialize)]
struct SideEntry<'a> {
    /// Of the end of the motion.
    #[serde(rename = "final")]
    last: LastEntry<'a>,
    /// Of the objective.
    #[serde(skip_serializing_if = "Option::is_none")]
    objective: Option<&'a [f64]>,
    /// Of chosen values at the end, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    values: BTreeMap<&'a str, &'a [f64]>,
    /// Numbers `a` of values that move by `a sqrt(h)` with the distance `h`, whose derivatives are infinite and null above; 0 of others.
    #[serde(skip_serializing_if = "Option::is_none")]
    square_root: Option<Box<SideEntry<'a>>>,
}

impl<'a> SideEntry<'a> {
    fn new(side: &'a Side, mechanical: usize) -> Self {
        let (n, values) = (side.q.len(), side.values.len());
        let roots = &side.roots;
        let of = || Self {
            last: LastEntry::new(&roots[..n], &roots[n..2 * n], mechanical),
            objective: roots.get(2 * n + values).map(Vec::as_slice),
            values: (side.values.iter().zip(&roots[2 * n..]))
                .map(|((name, _), row)| (name.as_str(), &row[..]))
                .collect(),
            square_root: None,
        };
        Self {
            square_root: (!roots.is_empty()).then(|| Box::new(of())),
            last: LastEntry::new(&side.q, &side.v, mechanical),
            objective: side.objective.as_deref(),
            values: by_name(&side.values),
        }
    }
}

fn by_name(values: &[(String, Vec<f64>)]) -> BTreeMap<&str, &[f64]> {
    let rows = values.iter();
    rows.map(|(name, row)| (name.as_str(), &row[..])).collect()
}

/// Derivatives of the end.
#[derive(Serialize)]
struct LastEntry<'a> {
    /// Of coordinates.
    q: &'a [Vec<f64>],
    /// Of velocities.
    v: &'a [Vec<f64>],
    /// Of states. Only for scenes that declare states.
    #[serde(skip_serializing_if = "<[Vec<f64>]>::is_empty")]
    states: &'a [Vec<f64>],
}

impl<'a> LastEntry<'a> {
    fn new(q: &'a [Vec<f64>], v: &'a [Vec<f64>], mechanical: usize) -> Self {
        // None where there is no derivative.
        let (velocities, states) = v.split_at(mechanical.min(v.len()));
        Self {
            q: &q[..mechanical.min(q.len())],
            v: velocities,
            states,
        }
    }
}

/// Why there are no derivatives, if there are none.
pub(super) struct Existence<'a>(Option<&'a str>);

impl<'a> Existence<'a> {
    /// What an obstacle, if there is one, says of it.
    pub(super) fn of(obstacle: &'a Option<String>) -> Self {
        Self(obstacle.as_deref())
    }
}

impl Serialize for Existence<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            None => serializer.serialize_bool(true),
            Some(reason) => serializer.serialize_str(reason),
        }
    }
}

impl<'a> GradientEntry<'a> {
    /// Of a motion of whose trajectory the instants `kept` are written.
    pub(super) fn new(model: &dyn Model, gradient: &'a Gradient, kept: &[usize]) -> Self {
        let outputs = model.outputs().iter().zip(&gradient.outputs);
        let mechanical = model.declaration().mechanical();
        let sides = gradient.one_sided.as_deref();
        let forward = gradient.mode == GradientMode::Forward;
        Self {
            with_respect_to: &gradient.with_respect_to,
            mode: gradient.mode.name(),
            values: by_name(&gradient.values),
            last: forward.then(|| LastEntry::new(&gradient.q, &gradient.v, mechanical)),
            one_sided: sides.map(|sides| OneSidedEntry {
                below: SideEntry::new(&sides.below, mechanical),
                above: SideEntry::new(&sides.above, mechanical),
            }),
            event_times: forward.then_some(&gradient.event_times),
            outputs: forward.then(|| {
                let rows = outputs.map(|(output, rows)| {
                    let rows = kept.iter().filter_map(|&k| rows.get(k));
                    (output.name, rows.map(Vec::as_slice).collect())
                });
                rows.collect()
            }),
            objective: gradient.objective.as_deref(),
            range: (!gradient.ranges.is_empty())
                .then(|| gradient.ranges.iter().map(RangeEntry::new).collect()),
            exists: Existence::of(&gradient.obstacle),
            exists_by: gradient.obstacle.is_some().then(|| {
                let obstacles = gradient.obstacles.iter();
                obstacles.map(Existence::of).collect()
            }),
        }
    }
}
