//! Methods by their names.

use crate::setting::{Setting, count, number};
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
const NAMES: [(&str, bool); 7] = [
    ("default", true),
    ("event", true),
    ("fesd", true),
    ("freezing", true),
    ("moreau", false),
    ("smooth", false),
    ("fixed", false),
];

impl Method {
    pub(crate) fn of(name: &'static str) -> Self {
        Self {
            name,
            steps: None,
            elements: None,
        }
    }

    /// `NAME`, `NAME(STEPS)`, or `NAME(STEPS, ELEMENTS)`.
    ///
    /// # Errors
    /// Names that no method has.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        let inner = text.strip_suffix(')').and_then(|text| text.split_once('('));
        let (name, numbers) = inner.unwrap_or((text, ""));
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
        let rest_velocity = number(settings, "rest");
        let auxiliary = number(settings, "auxiliary");
        let most = count(settings, "events");
        let fesd = |formulation| {
            let usual = Fesd::default();
            Fesd {
                elements: self.elements.unwrap_or(usual.elements),
                stages: count(settings, "stages").or(usual.stages),
                most_events: most.unwrap_or(usual.most_events),
                auxiliary_acceleration: auxiliary.unwrap_or(usual.auxiliary_acceleration),
                formulation,
                rest_velocity,
                ..usual
            }
        };
        let run = match self.name {
            "event" => {
                let usual = EventDriven::default();
                run.method(EventDriven {
                    max_events: most.unwrap_or(usual.max_events),
                    auxiliary_acceleration: auxiliary.unwrap_or(usual.auxiliary_acceleration),
                    rest_velocity,
                    ..usual
                })
            }
            "fesd" => run.method(fesd(StepFormulation::ActiveSet)),
            "freezing" => run.method(fesd(StepFormulation::TimeFreezing)),
            "moreau" => run.method(Moreau::default()),
            "smooth" => {
                let usual = Smooth::default();
                let width = number(settings, "width").unwrap_or(usual.width);
                run.method(Smooth { width, ..usual })
            }
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
