//! The runs of a block.

use crate::block::Block;
use crate::method::Method;
use crate::prepared::{Prepared, Refused, output};
use crate::setting::{Control, Setting, count, number};
use crate::statement::{Claim, Instant, Left, Right, Which};
use hangtime::derivative::{Gradient, GradientMode};
use hangtime::model::Declaration;
use hangtime::ocp::{
    ControlNodes, ControlShape, Formulation, Guess, Previous, Settings, Solution,
    TimeFreezingSettings,
};
use hangtime::prelude::*;
use hangtime_scene_files::{TextMistake, TextScene};
use std::collections::BTreeMap;

/// What a block gave.
#[derive(Debug)]
pub(crate) enum Results {
    /// The scene is refused: its mistakes, and the report on them.
    Refused(Vec<TextMistake>, String),
    /// The scene, what each method found, and what the scene gives that it is compared with.
    Ran(
        Box<Prepared>,
        BTreeMap<Method, Outcome>,
        Option<Box<Outcome>>,
    ),
}

/// What was found by one method; of a refused run, with which words.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) whole: Result<Of, String>,
    /// Motions that end at another time, by its bits.
    pub(crate) until: BTreeMap<u64, Result<Simulation, String>>,
    /// Derivatives at the end of the whole motion or of another one, forwards and against it.
    pub(crate) gradients: BTreeMap<Option<u64>, Result<[Gradient; 2], String>>,
}

#[derive(Debug)]
pub(crate) enum Of {
    Motion(Box<Simulation>),
    Optimum(Box<Solution>),
}

impl Of {
    /// The whole motion; an impossible problem has none.
    pub(crate) fn motion(&self) -> Option<&Simulation> {
        match self {
            Self::Motion(motion) => Some(motion),
            Self::Optimum(solution) => solution.motion.as_ref(),
        }
    }
}

/// Tolerance of motions that others are compared with.
const TIGHT: f64 = 1e-13;

/// Runs a block.
///
/// # Errors
/// What is wrong about the case.
pub(crate) fn results(block: &Block) -> Result<Results, String> {
    let prepared = match Prepared::of(block) {
        Ok(prepared) => prepared,
        Err(Refused::Scene(mistakes, report)) => return Ok(Results::Refused(mistakes, report)),
        Err(Refused::Case(why)) => return Err(why),
    };
    let mut outcomes = BTreeMap::new();
    for method in block.all_methods() {
        let found = match block.solves() {
            true => solved(block, &prepared, &prepared.scene)?,
            false => simulated(block, &prepared, &method)?,
        };
        outcomes.insert(method, found);
    }
    let theirs = match Prepared::theirs(block, &prepared)? {
        Some(theirs) if block.solves() => Some(solved(block, &prepared, &theirs.scene)?),
        Some(theirs) => {
            let own = outcomes.values().find_map(|own| own.whole.as_ref().ok());
            Some(their_motion(block, &prepared, &theirs.scene, own)?)
        }
        None => None,
    };
    let wrong = |why: &dyn std::fmt::Display| Err(format!("what it is compared with: {why}"));
    match theirs.as_ref().map(|theirs| &theirs.whole) {
        Some(Err(why)) => wrong(why),
        Some(Ok(Of::Motion(run))) if !run.status.is_solved() => wrong(&run.status),
        Some(Ok(Of::Optimum(found))) if !found.status.is_solved() => wrong(found),
        _ => Ok(Results::Ran(
            Box::new(prepared),
            outcomes,
            theirs.map(Box::new),
        )),
    }
}

/// Simulates the scene that a block is compared with.
fn their_motion(
    block: &Block,
    own: &Prepared,
    scene: &TextScene,
    first: Option<&Of>,
) -> Result<Outcome, String> {
    let begin = || {
        let mut run = simulate(scene)
            .method(EventDriven::default())
            .tolerance(TIGHT);
        for setting in &block.settings {
            run = match setting {
                Setting::Value("horizon", _, id) => run.horizon(own.in_unit(*id, "s")?),
                Setting::Value("their start", name, id) => {
                    let start = first.and_then(|of| of.motion()?.at(0.0).ok()?.get(&output(*id)));
                    run.start(name, start.ok_or("there is no start to begin from")?)
                }
                _ => run,
            };
        }
        Ok(run)
    };
    let claims = block.expectations.iter().map(|expected| &expected.claim);
    let compared = claims.filter(|claim| match claim {
        Claim::Value(.., right) => matches!(right[..], [Right::Their(_)]),
        _ => false,
    });
    ran(own, compared, true, &begin)
}

/// The time at which an instant ends a motion of its own.
pub(crate) fn own_end(prepared: &Prepared, instant: &Instant) -> Result<Option<f64>, String> {
    let Instant::Time(id) = instant else {
        return Ok(None);
    };
    if prepared.has_units() {
        prepared.same_unit(*id, "s")?;
    }
    prepared.constant(*id).map(Some)
}

/// A simulation by a method that is about to run.
fn begun<'a>(
    block: &Block,
    prepared: &'a Prepared,
    method: &Method,
) -> Result<Simulate<'a>, String> {
    let mut run = method.chosen(simulate(&prepared.scene), &block.settings);
    let declaration = prepared.scene.declaration();
    if let Some(tolerance) = number(&block.settings, "tolerance").filter(|_| method.has_tolerance())
    {
        run = run.tolerance(tolerance);
    }
    if let Some(steps) = count(&block.settings, "steps") {
        run = run.steps(steps);
    }
    let mut controls = Vec::new();
    for setting in &block.settings {
        match setting {
            Setting::Value("horizon", _, id) => run = run.horizon(prepared.in_unit(*id, "s")?),
            Setting::Value("start", name, id) => {
                let unit = unit_of_start(declaration, name);
                run = run.start(name, prepared.in_unit(*id, &unit)?);
            }
            Setting::Control(control) => controls.push(control),
            _ => {}
        }
    }
    match signal(prepared, &controls)? {
        Some(signal) => Ok(run.controls(signal)),
        None => Ok(run),
    }
}

/// What a velocity is one of.
fn differentiated(name: &str) -> Option<&str> {
    name.strip_prefix("dot(")?.strip_suffix(')')
}

/// The unit that an initial value is in.
fn unit_of_start(declaration: &Declaration, name: &str) -> String {
    let inner = differentiated(name);
    let known = declaration.coordinates.iter().chain(declaration.states);
    let mut known = known.filter(|known| known.name == inner.unwrap_or(name));
    match known.next_back().map_or("", |known| known.unit) {
        "" => String::new(),
        unit if inner.is_some() => format!("{unit}/s"),
        unit => unit.to_owned(),
    }
}

fn signal(prepared: &Prepared, controls: &[&Control]) -> Result<Option<ControlSignal>, String> {
    let Some(first) = controls.first() else {
        return Ok(None);
    };
    let known = prepared.scene.declaration().controls;
    let times = first
        .nodes
        .iter()
        .map(|node| node.0.map_or(Ok(0.0), |time| prepared.constant(time)));
    let times: Vec<f64> = times.collect::<Result<_, _>>()?;
    let mut values = vec![vec![0.0; known.len()]; times.len()];
    for control in controls {
        let index = known.iter().position(|known| known.name == control.name);
        let index = index.ok_or_else(|| format!("no control `{}`", control.name))?;
        if control.nodes.len() != times.len() || control.linear != first.linear {
            return Err("all controls have the same nodes".to_owned());
        }
        for (row, (_, value)) in values.iter_mut().zip(&control.nodes) {
            row[index] = prepared.in_unit(*value, known[index].unit)?;
        }
    }
    Ok(Some(match first.linear {
        true => ControlSignal::PiecewiseLinear { times, values },
        false => ControlSignal::PiecewiseConstant { times, values },
    }))
}

fn simulated(block: &Block, prepared: &Prepared, method: &Method) -> Result<Outcome, String> {
    let of_method = block.expectations.iter();
    let of_method = of_method.filter(|expected| block.methods(expected).contains(method));
    let claims = of_method.map(|expected| &expected.claim);
    ran(prepared, claims, method.locates(), &|| {
        begun(block, prepared, method)
    })
}

/// All motions that claims need, which begin alike, with their derivatives.
fn ran<'a, 'c>(
    own: &Prepared,
    claims: impl Iterator<Item = &'c Claim>,
    locates: bool,
    begin: &dyn Fn() -> Result<Simulate<'a>, String>,
) -> Result<Outcome, String> {
    let until = |end: f64| Ok::<_, String>(begin()?.horizon(end).run().map_err(|e| e.to_string()));
    let whole = begin()?.run().map_err(|error| error.to_string());
    let mut found = Outcome {
        whole: whole.map(|run| Of::Motion(Box::new(run))),
        until: BTreeMap::new(),
        gradients: BTreeMap::new(),
    };
    // At the whole end or at another time, of what, and by what.
    let mut asked: BTreeMap<Option<u64>, [Vec<String>; 2]> = BTreeMap::new();
    for claim in claims {
        if let Some(by) = quantity(claim) {
            let (of, end) = match claim {
                Claim::Value(Left::Derivative(of, ..), instant, ..) => {
                    let of = name_of(own, of, &found)?;
                    (Some(of), own_end(own, instant)?.map(f64::to_bits))
                }
                _ => (None, None),
            };
            let [ofs, bys] = asked.entry(end).or_default();
            ofs.extend(of);
            bys.push(by.to_owned());
        } else if let Claim::Value(_, instant, ..) = claim
            && let Some(end) = own_end(own, instant)?.filter(|_| locates)
        {
            found.until.insert(end.to_bits(), until(end)?);
        }
    }
    for (end, names) in asked {
        let [of, by] = names.map(sorted);
        let gradient = |mode| {
            let mut run = begin()?;
            if let Some(end) = end {
                run = run.horizon(f64::from_bits(end));
            }
            let run = run.gradient_of(of.iter().map(String::as_str));
            let run = run
                .gradient_mode(mode)
                .gradient(by.iter().map(String::as_str));
            run.map(|(_, gradient)| gradient)
                .map_err(|error| error.to_string())
        };
        let forward = gradient(GradientMode::Forward);
        let both = forward.and_then(|forward| Ok([forward, gradient(GradientMode::Adjoint)?]));
        found.gradients.insert(end, both);
    }
    Ok(found)
}

fn sorted<T: Ord>(mut names: Vec<T>) -> Vec<T> {
    names.sort();
    names.dedup();
    names
}

/// The quantity that a claim needs derivatives by.
fn quantity(claim: &Claim) -> Option<&str> {
    match claim {
        Claim::Value(Left::Derivative(_, by, _), ..) => Some(by),
        Claim::Value(Left::Limit(text), ..) | Claim::Text(text, ..) => {
            Some(text.of.as_str()).filter(|of| !of.is_empty())
        }
        _ => None,
    }
}

/// What a value is called where derivatives are asked for.
pub(crate) fn name_of(own: &Prepared, left: &Left, found: &Outcome) -> Result<String, String> {
    match left {
        Left::EventTime(None, which) => {
            let run = found.whole.as_ref().map_err(Clone::clone)?.motion();
            let index = run.and_then(|run| event(run, which));
            Ok(format!(
                "event_times[{}]",
                index.ok_or("there is no such event")?
            ))
        }
        Left::Expression(id, text) => {
            let declaration = own.scene.declaration();
            let name = differentiated(text).unwrap_or(text);
            let mechanical = &declaration.coordinates[..declaration.mechanical()];
            let known = mechanical.iter().any(|known| known.name == name);
            let state = declaration.states.iter().any(|known| known.name == text);
            Ok(match known || state {
                true => text.clone(),
                false => output(*id),
            })
        }
        Left::Fact(name) => Ok((*name).to_owned()),
        _ => Err("this has no derivative".to_owned()),
    }
}

/// Whether an event is one of those.
pub(crate) fn is_one(event: &Event, which: &Which) -> bool {
    let name = which.name.as_deref();
    which.kind.is_none_or(|kind| kind == event.kind)
        && name.is_none_or(|name| name == event.contact_name)
}

/// The place of an event among all of a motion.
pub(crate) fn event(run: &Simulation, which: &Which) -> Option<usize> {
    let events = run.events.iter().enumerate();
    let mut events = events.filter(|(_, event)| is_one(event, which));
    Some(events.nth(which.number - 1)?.0)
}

/// The optimum of a scene, of the block itself or of what it is compared with.
fn solved(block: &Block, prepared: &Prepared, scene: &TextScene) -> Result<Outcome, String> {
    let mut task = solve(scene).settings(chosen(&block.settings));
    if let Some(previous) = previous(block)? {
        task = task.guess(Guess::Previous(Box::new(previous)));
    }
    if let Some(intervals) = count(&block.settings, "intervals") {
        task = task.intervals(intervals);
    }
    if let Some(tolerance) = number(&block.settings, "tolerance") {
        task = task.tolerance(tolerance);
    }
    for setting in &block.settings {
        task = match setting {
            Setting::Value("horizon", _, id) => task.horizon(prepared.in_unit(*id, "s")?),
            Setting::Value("start", name, id) => {
                let unit = unit_of_start(prepared.scene.declaration(), name);
                task.start(name, prepared.in_unit(*id, &unit)?)
            }
            _ => task,
        };
    }
    let by = block
        .expectations
        .iter()
        .filter_map(|expected| quantity(&expected.claim));
    let run = task.gradient(sorted(by.collect())).run();
    let whole = run.map(|found| Of::Optimum(Box::new(found)));
    Ok(Outcome {
        whole: whole.map_err(|error| error.to_string()),
        until: BTreeMap::new(),
        gradients: BTreeMap::new(),
    })
}

/// How an optimum is looked for.
fn chosen(settings: &[Setting]) -> Settings {
    let mut chosen = Settings::default();
    let mut freezing = TimeFreezingSettings::default();
    let is_frozen = number(settings, "freezing").is_some();
    for setting in settings {
        let Setting::Number(word, number) = setting else {
            continue;
        };
        let count = *number as usize;
        match *word {
            "starts" => chosen.starts = Some(count),
            "programs" => chosen.maximum_programs = count,
            "linear" => chosen.controls = ControlShape::Linear,
            "constant" => chosen.controls = ControlShape::Constant,
            "aligned" => chosen.grid = ControlNodes::Aligned,
            "stages" if is_frozen => freezing.stages = count,
            "stages" => chosen.stages = count,
            "elements" if is_frozen => freezing.elements = count,
            "elements" => chosen.elements = count,
            _ => {}
        }
    }
    if is_frozen {
        chosen.formulation = Formulation::TimeFreezing(freezing);
    }
    chosen
}

/// The motion that a block starts from.
fn previous(block: &Block) -> Result<Option<Previous>, String> {
    let is_changed = |setting: &Setting| matches!(setting, Setting::Previous(_));
    if !block.settings.iter().any(is_changed) {
        return Ok(None);
    }
    let mut before = block.clone();
    // The last one of a name counts.
    before.settings.sort_by_key(is_changed);
    for setting in &mut before.settings {
        if let Setting::Previous(inner) = setting {
            *setting = Setting::clone(inner);
        }
    }
    let Ok(prepared) = Prepared::of(&before) else {
        return Err("the run before has no scene".to_owned());
    };
    match solved(&before, &prepared, &prepared.scene)?.whole? {
        Of::Optimum(found) if found.previous.is_some() => Ok(found.previous),
        _ => Err("the run before has no motion".to_owned()),
    }
}
