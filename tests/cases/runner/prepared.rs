//! The scene of a block, with what is expected of it as outputs, so that the language evaluates both.

use crate::block::{Block, Root};
use crate::document::Line;
use crate::setting::Setting;
use crate::statement::Id;
use hangtime::model::Model;
use hangtime_scene_files::{SceneError, TextMistake, TextScene, of_text};
use hangtime_units::Unit;

/// A scene at the parameters of a block, and its expressions.
#[derive(Debug, Clone)]
pub(crate) struct Prepared {
    pub(crate) scene: TextScene,
    /// What the expressions are that hang on parameters alone; not numbers for others.
    values: Vec<f64>,
    /// Their units; empty where there are none.
    units: Vec<String>,
    /// Texts of the expressions.
    texts: Vec<String>,
    roots: Vec<Root>,
}

/// Why there is no scene.
#[derive(Debug)]
pub(crate) enum Refused {
    /// Its own mistakes.
    Scene(Vec<TextMistake>, String),
    /// What is wrong about the case.
    Case(String),
}

/// Name of the output that an expression is.
pub(crate) fn output(id: Id) -> String {
    format!("expected_{id}")
}

/// Numbers for what hangs on the motion, more of them than anything reads.
static UNKNOWN: [f64; 4096] = [f64::NAN; 4096];

/// Share of a parameter by which it is moved: its fourth power is rounding, and rounding over it small.
const DISTANCE: f64 = 1e-3;

/// Halvings until a root is known to its last digit.
const HALVINGS: usize = 200;

impl Prepared {
    /// Derives a scene, gives its parameters their values, and finds the roots.
    pub(crate) fn of(block: &Block) -> Result<Self, Refused> {
        let text = Appended::new(&block.scene, &block.definitions, &block.expressions.own);
        let mut prepared = Self::read(&block.file, text, block.roots.clone())?;
        let set = prepared.set(&block.settings);
        set.map_err(Refused::Case)?;
        let found = prepared.find_roots();
        found.map_err(|why| Refused::Case(format!("{}: {why}", block.file)))?;
        Ok(prepared)
    }

    /// The same of the scene that a block is compared with, at the values that it shares.
    pub(crate) fn theirs(block: &Block, own: &Self) -> Result<Option<Self>, String> {
        let Some(like) = &block.like else {
            return Ok(None);
        };
        let text = Appended::new(like, &[], &block.expressions.theirs);
        let read = Self::read(&block.file, text, Vec::new());
        let mut prepared = read.map_err(|refused| match refused {
            Refused::Scene(_, report) => report,
            Refused::Case(why) => why,
        })?;
        let known = own.scene.declaration().parameters;
        for (index, their) in prepared.scene.declaration().parameters.iter().enumerate() {
            if let Some(place) = known.iter().position(|known| known.name == their.name) {
                let value = own.scene.parameter(place);
                prepared.scene.set_parameter(index, value);
            }
        }
        prepared.evaluate();
        Ok(Some(prepared))
    }

    fn read(file: &str, text: Appended, roots: Vec<Root>) -> Result<Self, Refused> {
        let derived = of_text("scene.hang", &text.text);
        let scene = derived.map_err(|error| text.refused(file, error))?;
        let outputs = scene.outputs();
        let first = outputs.len() - text.expressions.len();
        let mut prepared = Self {
            units: outputs[first..].iter().map(|o| o.unit.to_owned()).collect(),
            texts: text.expressions,
            values: Vec::new(),
            roots,
            scene,
        };
        prepared.evaluate();
        Ok(prepared)
    }

    fn evaluate(&mut self) {
        let mut values = vec![f64::NAN; self.scene.outputs().len()];
        self.scene.output_values(&UNKNOWN, &UNKNOWN, &mut values);
        self.values = values.split_off(values.len() - self.texts.len());
    }

    /// The place of a parameter, and its unit.
    fn parameter(&self, name: &str) -> Result<(usize, &'static str), String> {
        let known = self.scene.declaration().parameters;
        let index = known.iter().position(|known| known.name == name);
        let index = index.ok_or_else(|| format!("no parameter `{name}`"))?;
        Ok((index, known[index].unit))
    }

    fn set(&mut self, settings: &[Setting]) -> Result<(), String> {
        let mut chosen = Vec::new();
        for setting in settings {
            if let Setting::Value("set", name, id) = setting {
                let (index, unit) = self.parameter(name)?;
                chosen.push((index, self.in_unit(*id, unit)?));
            }
        }
        for (index, value) in chosen {
            self.scene.set_parameter(index, value);
        }
        self.evaluate();
        Ok(())
    }

    /// What does not hang on the motion, in SI units.
    pub(crate) fn constant(&self, id: Id) -> Result<f64, String> {
        let value = self.values[id];
        if value.is_nan() {
            return Err(format!(
                "`{}` is no number, or hangs on the motion",
                self.texts[id]
            ));
        }
        Ok(value)
    }

    /// The same in a unit; a number without one is in it.
    pub(crate) fn in_unit(&self, id: Id, unit: &str) -> Result<f64, String> {
        let value = self.constant(id)?;
        let is_bare = self.texts[id].parse::<f64>().is_ok();
        if is_bare || unit.is_empty() {
            return Ok(value);
        }
        let unit: Unit = unit.parse().map_err(|error| format!("{error}"))?;
        self.same_unit(id, &unit.to_string())?;
        Ok(value / unit.scale)
    }

    /// Refuses an expression whose unit is another one; what has none is in SI units.
    pub(crate) fn same_unit(&self, id: Id, unit: &str) -> Result<(), String> {
        let own = &self.units[id];
        let parsed = |text: &str| text.parse::<Unit>().ok();
        let same = match (parsed(own), parsed(unit)) {
            (Some(own), _) if own.is_dimensionless() => true,
            (Some(own), Some(unit)) => own.same_dimension(unit),
            (own, _) => own.is_none(),
        };
        if same {
            return Ok(());
        }
        Err(format!(
            "units differ: `{}` is in `{own}`, where `{unit}` is needed",
            self.texts[id]
        ))
    }

    /// The unit of an expression.
    pub(crate) fn unit(&self, id: Id) -> &str {
        &self.units[id]
    }

    /// Whether the scene tells units at all.
    pub(crate) fn has_units(&self) -> bool {
        self.units.iter().any(|unit| !unit.is_empty())
    }

    /// The derivative of what hangs on parameters alone by one of them: central differences of two distances, from which what
    /// grows with the square of the distance is taken out.
    pub(crate) fn derived(&self, id: Id, name: &str) -> Result<f64, String> {
        let (index, unit) = self.parameter(name)?;
        let value = self.scene.parameter(index);
        let scale = unit.parse::<Unit>().map_or(1.0, |unit| unit.scale);
        let difference = |distance: f64| -> Result<f64, String> {
            let at = |value: f64| {
                let mut moved = self.clone();
                moved.scene.set_parameter(index, value);
                moved.evaluate();
                moved.find_roots()?;
                moved.constant(id)
            };
            let distance = distance * value.abs().max(DISTANCE);
            Ok((at(value + distance)? - at(value - distance)?) / (2.0 * distance * scale))
        };
        let (far, near) = (difference(DISTANCE)?, difference(DISTANCE / 2.0)?);
        Ok((4.0 * near - far) / 3.0)
    }

    fn find_roots(&mut self) -> Result<(), String> {
        for root in self.roots.clone() {
            let (index, unit) = self.parameter(&root.name)?;
            let ends = root.between.map(|id| self.in_unit(id, unit));
            let [mut low, mut high] = [ends[0].clone()?, ends[1].clone()?];
            let begins = self.is_above(&root, index, low)?;
            if begins == self.is_above(&root, index, high)? {
                return Err(format!(
                    "`{}` has no change of sign",
                    self.texts[root.vanishes]
                ));
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                match self.is_above(&root, index, middle)? == begins {
                    true => low = middle,
                    false => high = middle,
                }
            }
        }
        Ok(())
    }

    /// Whether the left side of a root is the larger one at a value.
    fn is_above(&mut self, root: &Root, parameter: usize, value: f64) -> Result<bool, String> {
        self.scene.set_parameter(parameter, value);
        self.evaluate();
        Ok(self.constant(root.vanishes)? > 0.0)
    }
}

/// The text of a scene with definitions and expressions behind it.
struct Appended {
    text: String,
    /// Length of the scene itself.
    scene: usize,
    /// Where each line of the case begins.
    lines: Vec<(usize, usize)>,
    expressions: Vec<String>,
}

impl Appended {
    fn new(scene: &str, definitions: &[Line], expressions: &[Line]) -> Self {
        let mut text = scene.to_owned();
        let mut lines = Vec::new();
        for line in definitions {
            lines.push((text.len(), line.number));
            text += &format!("{}\n", line.text);
        }
        for (id, line) in expressions.iter().enumerate() {
            lines.push((text.len(), line.number));
            text += &format!("outputs {{ {} = {} }}\n", output(id), line.text);
        }
        Self {
            text,
            scene: scene.len(),
            lines,
            expressions: expressions.iter().map(|line| line.text.clone()).collect(),
        }
    }

    fn refused(&self, file: &str, error: SceneError) -> Refused {
        let SceneError::Mistakes { mistakes, .. } = error else {
            return Refused::Case(error.to_string());
        };
        let mistakes: Vec<TextMistake> = mistakes.into_iter().filter(|m| !m.warning).collect();
        if mistakes.iter().any(|known| known.place.start < self.scene) {
            // As it is refused without what is expected of it.
            return match of_text("scene.hang", &self.text[..self.scene]) {
                Err(SceneError::Mistakes { mistakes, report }) => Refused::Scene(mistakes, report),
                Err(error) => Refused::Case(error.to_string()),
                Ok(_) => Refused::Case(mistakes[0].text()),
            };
        }
        let each = mistakes.iter().map(|mistake| {
            let mut lines = self.lines.iter();
            let before = lines.rfind(|line| line.0 <= mistake.place.start);
            let line = before.map_or(0, |line| line.1);
            format!("{file}:{line}: {}", mistake.text())
        });
        Refused::Case(each.collect::<Vec<_>>().join("\n"))
    }
}
