//! `solve(&model)`.

use super::StartValues;
use crate::model::Model;
use crate::ocp::{self, ControlShape, Formulation, Guess, Horizon, Problem, Settings, Solution};
use crate::refusal;
use crate::simulation::InputError;
use crate::{Observer, Progress};

/// Control intervals, unless others are asked for.
const INTERVALS: usize = 30;

/// Solves the optimal control problem that a scene declares, with constant controls on 30 intervals.
/// [`Solve`] changes any of that.
///
/// ```
/// use hangtime::prelude::*;
///
/// hangtime::model! {
///     /// A cart that is pushed to 1 m and has to stop there.
///     pub Cart {
///         parameters { m: kg = 2 }
///         coordinates { y: m }
///         controls { u: N in -1..=1 }
///         lagrangian m/2*dot(y)^2
///         forces { y: u }
///         minimize time
///         finally { y == 1[m], dot(y) == 0[m/s] }
///     }
/// }
///
/// let solution = solve(&Cart::default()).intervals(4).run()?;
/// println!("{solution}");
/// // Full push to the middle, full brake from there: t = 2 sqrt(m y / u).
/// assert!((solution.horizon - 2.0 * 2.0_f64.sqrt()).abs() < 1e-6);
/// assert!((solution.at(solution.horizon / 2.0)?["y"] - 0.5).abs() < 1e-6);
/// # Ok::<(), InputError>(())
/// ```
pub fn solve(model: &dyn Model) -> Solve<'_> {
    Solve {
        model,
        intervals: INTERVALS,
        horizon: None,
        start: StartValues::default(),
        settings: Settings::default(),
        gradient: Vec::new(),
        observer: None,
    }
}

/// An optimal control problem that is about to be solved by [`run`](Self::run); made by [`solve`].
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A cart that is pushed to 1 m.
/// #     pub Cart {
/// #         parameters { m: kg = 2 }
/// #         coordinates { y: m }
/// #         controls { u: N in -1..=1 }
/// #         lagrangian m/2*dot(y)^2
/// #         forces { y: u }
/// #         minimize time
/// #         finally { y == 1[m] }
/// #     }
/// # }
/// let cart = Cart::default();
/// let mut iterations = 0;
/// let solution = solve(&cart)
///     .intervals(6)
///     .controls(ControlShape::Linear)
///     .start("dot(y)", 1.0)
///     .observer(|progress| {
///         iterations = progress.iterations;
///         progress.seconds < 60.0
///     })
///     .run()?;
/// assert!(solution.status.is_solved() && iterations > 0);
/// # Ok::<(), InputError>(())
/// ```
#[must_use = "nothing is solved before `run`"]
pub struct Solve<'a> {
    model: &'a dyn Model,
    intervals: usize,
    horizon: Option<f64>,
    start: StartValues,
    settings: Settings,
    gradient: Vec<String>,
    observer: Option<Box<Observer<'a>>>,
}

impl<'a> Solve<'a> {
    /// Number of control intervals, all of equal length; default 30.
    pub fn intervals(mut self, intervals: usize) -> Self {
        self.intervals = intervals;
        self
    }

    /// Final time \[s\], where the declared one is not meant. A free one is fixed by it; `--horizon` of the command line is a guess of that.
    pub fn horizon(mut self, seconds: f64) -> Self {
        self.horizon = Some(seconds);
        self
    }

    /// Initial value of a coordinate, `"z"`, or of a velocity, `"dot(z)"`, in the unit of the coordinate; default the
    /// declared one. Where it is free, a guess.
    pub fn start(mut self, name: &str, value: f64) -> Self {
        self.start.set(name, value);
        self
    }

    /// All settings at once; those that are named after this call change them.
    pub fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }

    /// Number of starts, see [`Settings::starts`].
    pub fn starts(mut self, starts: usize) -> Self {
        self.settings.starts = Some(starts);
        self
    }

    /// Controls on each interval, see [`Settings::controls`].
    pub fn controls(mut self, controls: ControlShape) -> Self {
        self.settings.controls = controls;
        self
    }

    /// Where the search for the contact sequence starts, see [`Settings::guess`].
    pub fn guess(mut self, guess: Guess) -> Self {
        self.settings.guess = guess;
        self
    }

    /// How the contact sequence is found, see [`Settings::formulation`].
    pub fn formulation(mut self, formulation: Formulation) -> Self {
        self.settings.formulation = formulation;
        self
    }

    /// Tolerance of the programs, see [`Settings::tolerance`].
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.settings.tolerance = tolerance;
        self
    }

    /// Names of parameters by which the optimum is differentiated, see [`Solution::gradient`]; for scenes with a text, as from files.
    pub fn gradient<'n>(mut self, names: impl IntoIterator<Item = &'n str>) -> Self {
        self.gradient.extend(names.into_iter().map(str::to_owned));
        self
    }

    /// Sees the progress after every interior point iteration; where it returns `false`, the run ends as
    /// [`Interrupted`](ocp::Status::Interrupted) with the best motion found so far.
    pub fn observer(mut self, observer: impl FnMut(&Progress) -> bool + Send + 'a) -> Self {
        self.observer = Some(Box::new(observer));
        self
    }

    /// Solves.
    ///
    /// # Errors
    /// [`InputError`] if the scene declares nothing to optimize, or anything that was asked for is refused; what
    /// happens later is the [`status`](Solution::status) of the result.
    pub fn run(self) -> Result<Solution, InputError> {
        let declaration = self.model.declaration();
        if declaration.optimal_control.is_none() {
            return Err(refusal::unsupported(
                format!(
                    "optimal control of `{}`, which declares no objective,",
                    declaration.name
                ),
                "declare `minimize`, or simulate it",
            ));
        }
        let mut problem = Problem::of(self.model, self.intervals);
        if let Some(horizon) = self.horizon {
            problem.horizon = Horizon::Fixed(horizon);
        }
        self.start
            .write(declaration, &mut problem.q, &mut problem.v)?;
        let mut settings = self.settings;
        for name in &self.gradient {
            settings
                .gradient
                .push(ocp::parameter_named(self.model, name)?);
        }
        match self.observer {
            Some(mut observer) => ocp::solve(self.model, &problem, &settings, &mut *observer),
            None => ocp::solve(self.model, &problem, &settings, &mut |_| true),
        }
    }
}
