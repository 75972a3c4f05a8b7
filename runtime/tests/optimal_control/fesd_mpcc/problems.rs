//! Steps of scenes as problems with complementarity.

use super::scenes::{Ball, Bar, Bowl, PumpTrackWithoutInput, SkiJump, Waves};
use hangtime::model::Model;
use hangtime::ocp::{Horizon, Problem, TimeFreezing, TimeFreezingSettings};
use hangtime::rk::Scheme;
use hangtime::simulation::InputError;

/// A problem with its transcription.
pub(crate) struct Case {
    pub(crate) name: String,
    model: Box<dyn Model>,
    problem: Problem,
    settings: TimeFreezingSettings,
}

impl Case {
    /// A step of length `duration` from `(q, v)`: nothing is free but the lengths of the elements.
    fn step(
        name: &str,
        model: impl Model + 'static,
        (q, v): (&[f64], &[f64]),
        duration: f64,
        (scheme, stages, elements): (Scheme, usize, usize),
    ) -> Self {
        let mut problem = Problem::of(&model, 1);
        (problem.q, problem.v) = (q.to_vec(), v.to_vec());
        problem.horizon = Horizon::Fixed(duration);
        let mut settings = TimeFreezingSettings::default();
        (settings.scheme, settings.stages, settings.elements) = (scheme, stages, elements);
        Self {
            name: format!("{name}, {duration} s, {scheme:?} {stages}, {elements} elements"),
            model: Box::new(model),
            problem,
            settings,
        }
    }

    pub(crate) fn program(&self) -> Result<TimeFreezing<'_>, InputError> {
        TimeFreezing::new(&*self.model, &self.problem, &self.settings)
    }
}

pub(crate) fn cases() -> Vec<Case> {
    let mut cases = published_scenes();
    cases.extend(small_scenes());
    cases
}

/// Steps of the ski jump and the pump track.
fn published_scenes() -> Vec<Case> {
    use Scheme::RadauIia as Radau;
    let table = |y: f64| (((-0.0001524 * y - 0.002149) * y + 0.4162) * y - 9.154) * y + 99.15;
    let y = 10.2759;
    let link = 0.4368;
    vec![
        Case::step(
            "ski jump slides",
            SkiJump::default(),
            (&[y, table(y)], &[0.0, 0.0]),
            0.3,
            (Radau, 2, 3),
        ),
        Case::step(
            "ski jump flies",
            SkiJump::default(),
            (&[30.0, 40.0], &[18.0, -1.0]),
            0.2,
            (Radau, 2, 3),
        ),
        Case::step(
            "ski jump lands",
            SkiJump::default(),
            (&[40.0, 25.5], &[18.0, -8.0]),
            0.5,
            (Radau, 2, 3),
        ),
        Case::step(
            "ski jump lands",
            SkiJump::default(),
            (&[40.0, 25.5], &[18.0, -8.0]),
            1.0,
            (Radau, 3, 4),
        ),
        Case::step(
            "pump track rolls",
            PumpTrackWithoutInput::default(),
            (&[0.0, 0.0, link], &[4.2, 0.0, 0.0]),
            0.05,
            (Radau, 2, 3),
        ),
        Case::step(
            "pump track flies",
            PumpTrackWithoutInput::default(),
            (&[1.8, 0.1, link], &[4.2, 0.5, 0.0]),
            0.05,
            (Radau, 2, 3),
        ),
        Case::step(
            "pump track lands",
            PumpTrackWithoutInput::default(),
            (&[1.8, 0.02, link], &[4.2, -0.5, 0.0]),
            0.1,
            (Radau, 2, 3),
        ),
    ]
}

/// Steps of scenes with one motion each: a ball, a bowl, waves, a bar with two ends.
fn small_scenes() -> Vec<Case> {
    use Scheme::{GaussLegendre as Gauss, RadauIia as Radau};
    let sine = |y: f64| (0.2 * f64::sin(y), 0.2 * f64::cos(y));
    let (height, slope) = sine(4.0);
    let ball = (&[0.0, 0.5][..], &[1.0, 0.0][..]);
    let bowl = (&[-1.0, 0.5][..], &[1.0, -1.0][..]);
    vec![
        Case::step("ball falls", Ball::default(), ball, 0.5, (Radau, 2, 4)),
        Case::step("ball falls", Ball::default(), ball, 0.7, (Radau, 3, 3)),
        Case::step("ball falls", Ball::default(), ball, 0.9, (Gauss, 2, 3)),
        Case::step(
            "ball slides",
            Ball::default(),
            (&[0.0, 0.0], &[1.0, 0.0]),
            0.3,
            (Radau, 1, 3),
        ),
        Case::step("bowl slides", Bowl::default(), bowl, 0.1, (Radau, 2, 3)),
        Case::step("bowl slides", Bowl::default(), bowl, 0.3, (Radau, 3, 4)),
        Case::step(
            "bowl falls",
            Bowl::default(),
            (&[-1.0, 0.8], &[1.0, 0.0]),
            0.3,
            (Radau, 2, 3),
        ),
        Case::step(
            "waves slide",
            Waves::default(),
            (&[4.0, height], &[1.0, slope]),
            0.3,
            (Radau, 2, 3),
        ),
        Case::step(
            "waves fall",
            Waves::default(),
            (&[0.0, 0.3], &[1.0, 0.0]),
            0.4,
            (Radau, 2, 4),
        ),
        Case::step(
            "bar lands on both ends",
            Bar::default(),
            (&[0.0, 0.3, 0.0], &[0.5, 0.0, 0.0]),
            0.3,
            (Radau, 2, 3),
        ),
        Case::step(
            "bar lands on one end",
            Bar::default(),
            (&[0.0, 0.3, 0.2], &[0.5, 0.0, 0.0]),
            0.21,
            (Radau, 2, 3),
        ),
        Case::step(
            "bar rests",
            Bar::default(),
            (&[0.0, 0.0, 0.0], &[0.5, 0.0, 0.0]),
            0.1,
            (Radau, 2, 3),
        ),
    ]
}
