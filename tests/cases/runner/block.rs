//! A section as runs of its scene: with which settings, and what is expected of each.

use crate::document::{Line, Section};
use crate::run::methods;
use crate::setting::{Setting, settings};
use crate::statement::{Claim, Expectation, Expressions, Id, TextKind, expectations};
use crate::words::{behind, parts, split};

/// One scene with one set of settings.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub(crate) file: String,
    /// Text of the scene, replacements made.
    pub(crate) scene: String,
    /// The same of a scene that it is compared with.
    pub(crate) like: Option<String>,
    /// What stands in the language itself between expectations: abbreviations and functions.
    pub(crate) definitions: Vec<Definition>,
    pub(crate) expressions: Expressions,
    pub(crate) settings: Vec<Setting>,
    pub(crate) expectations: Vec<Expectation>,
    /// The settings for people.
    pub(crate) shown: String,
}

/// A name for what is expected.
#[derive(Debug, Clone)]
pub(crate) enum Definition {
    /// `let ..` or `fn ..`.
    Text(Line),
    /// A number at which an expression vanishes.
    Root(Root),
}

/// `root NAME: UNIT in A..B: LEFT == RIGHT`.
#[derive(Debug, Clone)]
pub(crate) struct Root {
    pub(crate) name: String,
    pub(crate) unit: String,
    pub(crate) number: usize,
    pub(crate) between: (Id, Id),
    /// Left minus right side.
    pub(crate) vanishes: Id,
}

/// What all runs of a section share, as far as it has been read, and the lines of the next.
struct Reader<'a> {
    section: &'a Section,
    definitions: Vec<Definition>,
    expressions: Expressions,
    /// The runs that stand behind `with`, each as for each of its items the settings it stands for.
    choices: Vec<Vec<Vec<Setting>>>,
    shown: Vec<String>,
    expectations: Vec<Expectation>,
    blocks: Vec<Block>,
}

/// All runs of a section.
///
/// # Errors
/// Lines that cannot be read, with their places.
pub(crate) fn blocks(section: &Section) -> Result<Vec<Block>, String> {
    let mut reader = Reader {
        section,
        definitions: Vec::new(),
        expressions: Expressions::default(),
        choices: Vec::new(),
        shown: Vec::new(),
        expectations: Vec::new(),
        blocks: Vec::new(),
    };
    for line in &section.statements {
        let read = reader.line(line);
        read.map_err(|why| format!("{}:{}: {why}", section.file, line.number))?;
    }
    let read = reader.finish();
    read.map_err(|why| format!("{}: {why}", section.file))?;
    if reader.blocks.is_empty() {
        return Err(format!(
            "{}: nothing is expected in `{}`",
            section.file, section.heading
        ));
    }
    Ok(reader.blocks)
}

impl Block {
    /// A run of whose status nothing is said is to be solved.
    fn expect_solved(&mut self) {
        let tells = |expectation: &Expectation| {
            matches!(
                expectation.claim,
                Claim::Status(..)
                    | Claim::NotStatus(_)
                    | Claim::Message(..)
                    | Claim::Text(TextKind::Refusal, _, true)
            )
        };
        if self.expectations.iter().any(tells) {
            return;
        }
        if let Some(first) = self.expectations.first() {
            let mut solved = first.clone();
            solved.claim = Claim::Status(vec!["solved".to_owned()], None);
            solved.by = methods(self);
            solved.snapshot = false;
            self.expectations.insert(0, solved);
        }
    }
}

impl Reader<'_> {
    fn line(&mut self, line: &Line) -> Result<(), String> {
        if let Some(text) = behind(&line.text, "expect") {
            let read = expectations(line, text, &mut self.expressions)?;
            self.expectations.extend(read);
        } else if let Some(text) = behind(&line.text, "with") {
            self.finish()?;
            self.shown.push(text.to_owned());
            for run in parts(text, ";") {
                let read = settings(line.number, run, &mut self.expressions)?;
                self.choices.push(read);
            }
        } else if let Some(text) = behind(&line.text, "root") {
            let root = self.root(line.number, text)?;
            self.definitions.push(Definition::Root(root));
        } else if ["let", "fn"]
            .iter()
            .any(|word| behind(&line.text, word).is_some())
        {
            self.definitions.push(Definition::Text(line.clone()));
        } else {
            return Err(format!(
                "`{}` begins with none of `expect`, `with`, `let`, `fn`, `root`",
                line.text
            ));
        }
        Ok(())
    }

    fn root(&mut self, number: usize, text: &str) -> Result<Root, String> {
        let form = "a root is `root NAME: UNIT in A..B: LEFT == RIGHT`";
        let (named, rest) = split(text, " in ").ok_or(form)?;
        let (name, unit) = named.split_once(':').unwrap_or((named, ""));
        let (between, equation) = split(rest, ":").ok_or(form)?;
        let (low, high) = split(between, "..").ok_or(form)?;
        let (left, right) = split(equation, "==").ok_or(form)?;
        let mut add = |text: &str| self.expressions.add(number, text);
        Ok(Root {
            name: name.trim().to_owned(),
            unit: unit.trim().to_owned(),
            number,
            between: (add(low), add(high)),
            vanishes: add(&format!("({left}) - ({right})")),
        })
    }

    /// Ends the runs that have been told about.
    fn finish(&mut self) -> Result<(), String> {
        if self.expectations.is_empty() {
            return Ok(());
        }
        let expectations = std::mem::take(&mut self.expectations);
        let shown = std::mem::take(&mut self.shown).join(", ");
        let mut choices = std::mem::take(&mut self.choices);
        if choices.is_empty() {
            choices.push(Vec::new());
        }
        for settings in choices.iter().flat_map(|choices| combinations(choices)) {
            let mut scene = self.section.scene.clone();
            for setting in &settings {
                if let Setting::Replaced(from, to) = setting {
                    if !scene.contains(from.as_str()) {
                        return Err(format!("the scene has no `{from}` to be replaced"));
                    }
                    scene = scene.replace(from.as_str(), to);
                }
            }
            let mut block = Block {
                file: self.section.file.clone(),
                scene,
                like: self.section.like.clone(),
                definitions: self.definitions.clone(),
                expressions: self.expressions.clone(),
                settings,
                expectations: expectations.clone(),
                shown: shown.clone(),
            };
            block.expect_solved();
            self.blocks.push(block);
        }
        self.leave_out();
        Ok(())
    }

    /// What was expected of one run is no expression of the next.
    fn leave_out(&mut self) {
        let mut kept = Vec::new();
        for definition in &self.definitions {
            if let Definition::Root(root) = definition {
                kept.extend([root.between.0, root.between.1, root.vanishes]);
            }
        }
        for (id, expression) in self.expressions.own.iter_mut().enumerate() {
            if !kept.contains(&id) {
                "0".clone_into(&mut expression.text);
            }
        }
        for expression in &mut self.expressions.theirs {
            "0".clone_into(&mut expression.text);
        }
    }
}

/// Every choice of one setting of each item.
fn combinations(choices: &[Vec<Setting>]) -> Vec<Vec<Setting>> {
    let Some((first, rest)) = choices.split_first() else {
        return vec![Vec::new()];
    };
    let others = combinations(rest);
    let each = first.iter().flat_map(|setting| {
        others.iter().map(move |others| {
            let mut all = vec![setting.clone()];
            all.extend(others.iter().cloned());
            all
        })
    });
    each.collect()
}
