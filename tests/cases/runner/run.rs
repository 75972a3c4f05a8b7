//! The runs of a block.

use crate::block::Block;
use crate::method::Method;
use crate::prepared::{Prepared, Refused, output};
use crate::setting::{Control, Setting};
use crate::statement::{Claim, Expectation, Instant, Left, Which};
use hangtime::derivative::{Gradient, GradientMode};
use hangtime::ocp::{
    ControlNodes, Formulation, Guess, Previous, Settings, Solution, TimeFreezingSettings,
};
use hangtime::prelude::*;
use hangtime_scene_files::{TextMistake, TextScene};
use std::collections::BTreeMap;

/// What a block gave.
#[derive(Debug)]
pub(crate) enum Results {
    /// The scene is refused: its mistakes, and the report on them.
    Refused(Vec<TextMistake>, String),
    Simulated(Prepared, BTreeMap<Method, Runs>, Option<Box<Theirs>>),
    /// With the optimum of the scene that it is compared with.
    Solved(
        Prepared,
        Result<Box<Solution>, String>,
        Option<Box<Solution>>,
    ),
}

/// The motion that a block is compared with.
#[derive(Debug)]
pub(crate) struct Theirs {
    pub(crate) whole: Simulation,
    /// Motions that end at another time, by its bits.
    until: BTreeMap<u64, Simulation>,
}

impl Theirs {
    /// The motion until a time, or the whole.
    pub(crate) fn until(&self, time: Option<f64>) -> &Simulation {
        let ended = time.and_then(|time| self.until.get(&time.to_bits()));
        ended.unwrap_or(&self.whole)
    }
}

/// Tolerance of motions that others are compared with.
const TIGHT: f64 = 1e-13;

/// The runs by one method; of a refused one, with which words.
#[derive(Debug)]
pub(crate) struct Runs {
    pub(crate) whole: Result<Simulation, String>,
    /// Motions that end at another time, by its bits.
    until: BTreeMap<u64, Result<Simulation, String>>,
    /// Derivatives at the end of the whole motion or of another one, forwards and against it.
    gradients: BTreeMap<Option<u64>, Result<[Gradient; 2], String>>,
}

impl Runs {
    /// The motion until a time, or the whole.
    pub(crate) fn until(&self, time: Option<f64>) -> &Result<Simulation, String> {
        match time {
            Some(time) => self.until.get(&time.to_bits()).unwrap_or(&self.whole),
            None => &self.whole,
        }
    }

    pub(crate) fn gradients(&self, time: Option<f64>) -> Option<&Result<[Gradient; 2], String>> {
        self.gradients.get(&time.map(f64::to_bits))
    }
}

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
    let solves = |setting: &Setting| matches!(setting, Setting::Intervals(_));
    if block.settings.iter().any(solves) {
        let solution = solved(block, &prepared, &prepared.scene)?;
        let theirs = match Prepared::theirs(block, &prepared)? {
            Some(theirs) => Some(solved(block, &prepared, &theirs.scene)??),
            None => None,
        };
        return match theirs {
            Some(theirs) if !theirs.status.is_solved() => {
                Err(format!("what it is compared with: {theirs}"))
            }
            theirs => Ok(Results::Solved(prepared, solution, theirs)),
        };
    }
    let mut runs = BTreeMap::new();
    for method in methods(block) {
        let run = simulated(block, &prepared, &method)?;
        runs.insert(method, run);
    }
    let theirs = theirs(block, &prepared, &runs)?;
    Ok(Results::Simulated(prepared, runs, theirs))
}

/// Simulates the scene that a block is compared with.
fn theirs(
    block: &Block,
    own: &Prepared,
    runs: &BTreeMap<Method, Runs>,
) -> Result<Option<Box<Theirs>>, String> {
    let Some(prepared) = Prepared::theirs(block, own)? else {
        return Ok(None);
    };
    let first = runs.values().find_map(|runs| runs.whole.as_ref().ok());
    let begun = |end: Option<f64>| {
        let mut run = simulate(&prepared.scene);
        run = run.method(EventDriven::default()).tolerance(TIGHT);
        for setting in &block.settings {
            run = match setting {
                Setting::Horizon(id) => run.horizon(own.in_unit(*id, "s")?),
                Setting::TheirStart(name, id) => {
                    let begin = first.and_then(|run| run.at(0.0).ok()?.get(&output(*id)));
                    run.start(name, begin.ok_or("there is no start to begin from")?)
                }
                _ => run,
            };
        }
        if let Some(end) = end {
            run = run.horizon(end);
        }
        run.run().map_err(|error| error.to_string())
    };
    let mut until = BTreeMap::new();
    for expectation in &block.expectations {
        if let Claim::Value(_, instant, ..) = &expectation.claim
            && let Some(end) = own_end(own, instant)?
        {
            until.insert(end.to_bits(), begun(Some(end))?);
        }
    }
    let whole = begun(None)?;
    match whole.status.is_solved() {
        true => Ok(Some(Box::new(Theirs { whole, until }))),
        false => Err(format!("what it is compared with: {}", whole.status)),
    }
}

/// The methods that a block asks for.
pub(crate) fn methods(block: &Block) -> Vec<Method> {
    let mut methods = Vec::new();
    for expectation in &block.expectations {
        methods.extend(named(block, expectation));
    }
    methods.sort();
    methods.dedup();
    methods
}

/// The methods that an expectation is about.
pub(crate) fn named(block: &Block, expectation: &Expectation) -> Vec<Method> {
    if !expectation.by.is_empty() {
        return expectation.by.clone();
    }
    let chosen = block.settings.iter().find_map(|setting| match setting {
        Setting::By(methods) => Some(methods.clone()),
        _ => None,
    });
    chosen.unwrap_or_else(Method::usual)
}

/// The time at which an instant ends a motion of its own.
pub(crate) fn own_end(prepared: &Prepared, instant: &Instant) -> Result<Option<f64>, String> {
    match instant {
        Instant::Time(id) => {
            if prepared.has_units() {
                prepared.same_unit(*id, "s")?;
            }
            prepared.constant(*id).map(Some)
        }
        _ => Ok(None),
    }
}

/// A simulation by a method that is about to run.
fn begun<'a>(
    block: &Block,
    prepared: &'a Prepared,
    method: &Method,
) -> Result<Simulate<'a>, String> {
    let mut run = method.chosen(simulate(&prepared.scene), &block.settings);
    let declaration = prepared.scene.declaration();
    let mut controls = Vec::new();
    for setting in &block.settings {
        run = match setting {
            Setting::Horizon(id) => run.horizon(prepared.in_unit(*id, "s")?),
            Setting::Tolerance(tolerance) if method.has_tolerance() => run.tolerance(*tolerance),
            Setting::Steps(steps) => run.steps(*steps),
            Setting::Start(name, id) => {
                let unit = unit_of_start(declaration, name);
                run.start(name, prepared.in_unit(*id, &unit)?)
            }
            Setting::Control(control) => {
                controls.push(control);
                run
            }
            _ => run,
        };
    }
    match signal(prepared, &controls)? {
        Some(signal) => Ok(run.controls(signal)),
        None => Ok(run),
    }
}

/// The unit that an initial value is in.
fn unit_of_start(declaration: &hangtime::model::Declaration, name: &str) -> String {
    let inner = name
        .strip_prefix("dot(")
        .and_then(|rest| rest.strip_suffix(')'));
    let of = inner.unwrap_or(name);
    let known = declaration.coordinates.iter().chain(declaration.states);
    let mut unit = known
        .filter(|known| known.name == of)
        .map(|known| known.unit);
    match (unit.next_back().unwrap_or_default(), inner) {
        ("", _) => String::new(),
        (unit, Some(_)) => format!("{unit}/s"),
        (unit, None) => unit.to_owned(),
    }
}

fn signal(prepared: &Prepared, controls: &[&Control]) -> Result<Option<ControlSignal>, String> {
    let Some(first) = controls.first() else {
        return Ok(None);
    };
    let known = prepared.scene.declaration().controls;
    let mut times = Vec::new();
    for (time, _) in &first.nodes {
        times.push(time.map_or(Ok(0.0), |time| prepared.constant(time))?);
    }
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

/// The derivatives that are asked for: at the whole end or at another time, of what, and by what.
type Asked = BTreeMap<Option<u64>, (Vec<String>, Vec<String>)>;

fn simulated(block: &Block, prepared: &Prepared, method: &Method) -> Result<Runs, String> {
    let whole = begun(block, prepared, method)?.run();
    let whole = whole.map_err(|error| error.to_string());
    let mut runs = Runs {
        whole,
        until: BTreeMap::new(),
        gradients: BTreeMap::new(),
    };
    let mut asked = Asked::new();
    for expectation in &block.expectations {
        if !named(block, expectation).contains(method) {
            continue;
        }
        if let Claim::Limit(by, ..) | Claim::Obstacle(by, ..) = &expectation.claim {
            asked.entry(None).or_default().1.push(by.clone());
        }
        let Claim::Value(left, instant, ..) = &expectation.claim else {
            continue;
        };
        let end = own_end(prepared, instant)?;
        if let Left::Derivative(of, by, _) = left {
            let of = name_of(prepared, of, &runs.whole)?;
            let (ofs, bys) = asked.entry(end.map(f64::to_bits)).or_default();
            ofs.push(of);
            bys.push(by.clone());
        } else if let Some(end) = end.filter(|_| method.locates()) {
            let run = begun(block, prepared, method)?.horizon(end).run();
            let run = run.map_err(|error| error.to_string());
            runs.until.insert(end.to_bits(), run);
        }
    }
    for (end, (mut of, mut by)) in asked {
        for names in [&mut of, &mut by] {
            names.sort();
            names.dedup();
        }
        let gradient = |mode| {
            let mut run = begun(block, prepared, method)?;
            if let Some(end) = end {
                run = run.horizon(f64::from_bits(end));
            }
            let run = run
                .gradient_of(of.iter().map(String::as_str))
                .gradient_mode(mode);
            let run = run.gradient(by.iter().map(String::as_str));
            run.map(|(_, gradient)| gradient)
                .map_err(|error| error.to_string())
        };
        let both = gradient(GradientMode::Forward)
            .and_then(|forward| Ok([forward, gradient(GradientMode::Adjoint)?]));
        runs.gradients.insert(end, both);
    }
    Ok(runs)
}

/// What a value is called where derivatives are asked for.
pub(crate) fn name_of(
    prepared: &Prepared,
    left: &Left,
    run: &Result<Simulation, String>,
) -> Result<String, String> {
    match left {
        Left::EventTime(None, which) => {
            let run = run.as_ref().map_err(Clone::clone)?;
            let index = event(run, which).ok_or("there is no such event")?;
            Ok(format!("event_times[{index}]"))
        }
        Left::Expression(id, text) => {
            let declaration = prepared.scene.declaration();
            let inner = text
                .strip_prefix("dot(")
                .and_then(|rest| rest.strip_suffix(')'));
            let name = inner.unwrap_or(text);
            let mechanical = &declaration.coordinates[..declaration.mechanical()];
            let known = mechanical.iter().any(|known| known.name == name);
            let state = declaration.states.iter().any(|known| known.name == text);
            Ok(match known || state {
                true => text.clone(),
                false => output(*id),
            })
        }
        Left::Fact(name) => Ok(name.clone()),
        _ => Err("this has no derivative".to_owned()),
    }
}

/// The place of an event among all of a motion.
pub(crate) fn event(run: &Simulation, which: &Which) -> Option<usize> {
    let mut events = run.events.iter().enumerate();
    let is = |event: &Event| {
        let name = which.name.as_deref();
        event.kind == which.kind && name.is_none_or(|name| name == event.contact_name)
    };
    let found = events
        .by_ref()
        .filter(|(_, event)| is(event))
        .nth(which.number - 1)?;
    Some(found.0)
}

/// The optimum of a scene, of the block itself or of what it is compared with.
fn solved(
    block: &Block,
    prepared: &Prepared,
    scene: &TextScene,
) -> Result<Result<Box<Solution>, String>, String> {
    let mut task = solve(scene).settings(chosen(block));
    if let Some(previous) = previous(block)? {
        task = task.guess(Guess::Previous(Box::new(previous)));
    }
    for setting in &block.settings {
        task = match setting {
            Setting::Intervals(intervals) => task.intervals(*intervals),
            Setting::Tolerance(tolerance) => task.tolerance(*tolerance),
            Setting::Horizon(id) => task.horizon(prepared.in_unit(*id, "s")?),
            Setting::Start(name, id) => {
                let unit = unit_of_start(prepared.scene.declaration(), name);
                task.start(name, prepared.in_unit(*id, &unit)?)
            }
            _ => task,
        };
    }
    let by = block
        .expectations
        .iter()
        .filter_map(|expectation| match &expectation.claim {
            Claim::Value(Left::Derivative(_, by, _), ..)
            | Claim::Limit(by, ..)
            | Claim::Obstacle(by, ..) => Some(by.as_str()),
            _ => None,
        });
    let mut by: Vec<&str> = by.collect();
    by.sort_unstable();
    by.dedup();
    let run = task.gradient(by).run();
    Ok(run.map(Box::new).map_err(|error| error.to_string()))
}

/// What a block says of how an optimum is looked for.
fn chosen(block: &Block) -> Settings {
    let mut settings = Settings::default();
    let mut freezing = TimeFreezingSettings::default();
    let frozen = |setting: &Setting| matches!(setting, Setting::Freezing);
    let frozen = block.settings.iter().any(frozen);
    for setting in &block.settings {
        match setting {
            Setting::Starts(starts) => settings.starts = Some(*starts),
            Setting::Programs(most) => settings.maximum_programs = *most,
            Setting::Shape(shape) => settings.controls = *shape,
            Setting::Aligned => settings.grid = ControlNodes::Aligned,
            Setting::Stages(stages) if frozen => freezing.stages = *stages,
            Setting::Stages(stages) => settings.stages = *stages,
            Setting::Elements(elements) if frozen => freezing.elements = *elements,
            Setting::Elements(elements) => settings.elements = *elements,
            _ => {}
        }
    }
    if frozen {
        settings.formulation = Formulation::TimeFreezing(freezing);
    }
    settings
}

/// The motion that a block starts from.
fn previous(block: &Block) -> Result<Option<Previous>, String> {
    let mut before = block.clone();
    let (mut own, mut changed) = (Vec::new(), Vec::new());
    for setting in &block.settings {
        match setting {
            Setting::Previous(inner) => changed.push(Setting::clone(inner)),
            other => own.push(other.clone()),
        }
    }
    if changed.is_empty() {
        return Ok(None);
    }
    // The last one of a name counts.
    before.settings = [own, changed].concat();
    let prepared = match Prepared::of(&before) {
        Ok(prepared) => prepared,
        Err(_) => return Err("the run before has no scene".to_owned()),
    };
    let found = solved(&before, &prepared, &prepared.scene)??.previous;
    found
        .map(Some)
        .ok_or("the run before has no motion".to_owned())
}
