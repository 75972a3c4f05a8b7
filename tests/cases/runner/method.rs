//! Methods by their names.

use crate::setting::Setting;
use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::prelude::*;
use hangtime::simulation::StepFormulation;

/// Which method, with its number of steps, and of elements in each of them, if one is asked for.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Method {
    name: &'static str,
    steps: Option<usize>,
    elements: Option<usize>,
}

/// Names of methods, and whether they locate events.
const NAMES: [(&str, bool); 8] = [
    ("default", true),
    ("event", true),
    ("fesd", true),
    ("freezing", true),
    ("complementarity", true),
    ("moreau", false),
    ("smooth", false),
    ("fixed", false),
];

impl Method {
    /// Those that run a case of which nothing else is said.
    pub(crate) fn usual() -> Vec<Self> {
        let of = |name| Self {
            name,
            steps: None,
            elements: None,
        };
        vec![of("default"), of("event")]
    }

    /// `NAME`, `NAME(STEPS)`, or `NAME(STEPS, ELEMENTS)`.
    ///
    /// # Errors
    /// Names that no method has.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        let (name, numbers) = match text.strip_suffix(')').and_then(|text| text.split_once('(')) {
            Some((name, numbers)) => (name, numbers),
            None => (text, ""),
        };
        let numbers = numbers.split(',').filter(|number| !number.is_empty());
        let numbers: Result<Vec<usize>, _> = numbers.map(|text| text.trim().parse()).collect();
        let known = NAMES.iter().find(|known| known.0 == name.trim());
        match (known, numbers) {
            (Some(&(name, _)), Ok(numbers)) => Ok(Self {
                name,
                steps: numbers.first().copied(),
                elements: numbers.get(1).copied(),
            }),
            _ => Err(format!("`{text}` is no method")),
        }
    }

    /// Whether it locates events.
    pub(crate) fn locates(&self) -> bool {
        NAMES.contains(&(self.name, true))
    }

    /// Whether a tolerance sets its accuracy.
    pub(crate) fn has_tolerance(&self) -> bool {
        self.locates() || self.name == "smooth"
    }

    /// The simulation by it, with those of the settings that it alone has.
    pub(crate) fn chosen<'a>(&self, run: Simulate<'a>, settings: &[Setting]) -> Simulate<'a> {
        let rest_velocity = settings.iter().find_map(|setting| match setting {
            Setting::Rest(speed) => Some(*speed),
            _ => None,
        });
        let width = settings.iter().find_map(|setting| match setting {
            Setting::Width(width) => Some(*width),
            _ => None,
        });
        let fesd = |formulation| {
            let mut fesd = Fesd {
                elements: self.elements.unwrap_or(Fesd::default().elements),
                formulation,
                rest_velocity,
                ..Fesd::default()
            };
            for setting in settings {
                match *setting {
                    Setting::Stages(stages) => fesd.stages = Some(stages),
                    Setting::Events(most) => fesd.most_events = most,
                    Setting::Auxiliary(a) => fesd.auxiliary_acceleration = a,
                    _ => {}
                }
            }
            fesd
        };
        let run = match self.name {
            "event" => {
                let mut event = EventDriven {
                    rest_velocity,
                    ..EventDriven::default()
                };
                for setting in settings {
                    match *setting {
                        Setting::Events(most) => event.max_events = most,
                        Setting::Auxiliary(a) => event.auxiliary_acceleration = a,
                        _ => {}
                    }
                }
                run.method(event)
            }
            "fesd" => run.method(fesd(StepFormulation::ActiveSet)),
            "freezing" => run.method(fesd(StepFormulation::TimeFreezing)),
            "moreau" => run.method(Moreau::default()),
            "smooth" => run.method(Smooth {
                width: width.unwrap_or(Smooth::default().width),
                ..Smooth::default()
            }),
            "fixed" => run.method(FixedStep::default()),
            _ => run,
        };
        match self.steps {
            Some(steps) => run.steps(steps),
            None => run,
        }
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.steps, self.elements) {
            (Some(steps), Some(elements)) => write!(f, "{}({steps}, {elements})", self.name),
            (Some(steps), None) => write!(f, "{}({steps})", self.name),
            _ => f.write_str(self.name),
        }
    }
}
