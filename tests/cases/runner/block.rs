//! A section as runs of its scene: with which settings, and what is expected of each.

use crate::document::{Line, Section};
use crate::method::Method;
use crate::setting::{Setting, number, settings};
use crate::statement::{Claim, Expectation, Expressions, Id, Text, expectations};
use crate::words::{behind, parts, split};

/// One scene with one set of settings.
#[derive(Debug, Clone, Default)]
pub(crate) struct Block {
    pub(crate) file: String,
    /// Text of the scene, replacements made.
    pub(crate) scene: String,
    /// The same of a scene that it is compared with.
    pub(crate) like: Option<String>,
    /// What stands in the language itself between expectations: abbreviations, functions, and parameters that are roots.
    pub(crate) definitions: Vec<Line>,
    pub(crate) roots: Vec<Root>,
    pub(crate) expressions: Expressions,
    pub(crate) settings: Vec<Setting>,
    pub(crate) expectations: Vec<Expectation>,
    /// The settings for people.
    pub(crate) shown: String,
}

/// `root NAME: UNIT in A..B: LEFT == RIGHT`.
#[derive(Debug, Clone)]
pub(crate) struct Root {
    pub(crate) name: String,
    pub(crate) between: [Id; 2],
    /// Left minus right side.
    pub(crate) vanishes: Id,
}

/// What has been read of a section.
#[derive(Default)]
struct Reader {
    /// The next run, without settings.
    next: Block,
    /// The runs that stand behind `with`, each as for each of its items the settings it stands for.
    choices: Vec<Vec<Vec<Setting>>>,
    blocks: Vec<Block>,
}

/// All runs of a section.
///
/// # Errors
/// Lines that cannot be read, with their places.
pub(crate) fn blocks(section: &Section) -> Result<Vec<Block>, String> {
    let mut reader = Reader::default();
    reader.next.file.clone_from(&section.file);
    reader.next.scene.clone_from(&section.scene);
    reader.next.like.clone_from(&section.like);
    for line in &section.statements {
        let read = reader.line(line);
        read.map_err(|why| format!("{}:{}: {why}", section.file, line.number))?;
    }
    let read = reader.finish();
    read.map_err(|why| format!("{}: {why}", section.file))?;
    match reader.blocks.is_empty() {
        true => Err(format!(
            "{}: nothing is expected in `{}`",
            section.file, section.heading
        )),
        false => Ok(reader.blocks),
    }
}

impl Block {
    /// Whether it is a problem of optimal control.
    pub(crate) fn solves(&self) -> bool {
        number(&self.settings, "intervals").is_some()
    }

    /// The methods that an expectation is about; an optimum is found by one.
    pub(crate) fn methods(&self, expectation: &Expectation) -> Vec<Method> {
        if self.solves() {
            return vec![Method::of("default")];
        }
        if !expectation.by.is_empty() {
            return expectation.by.clone();
        }
        let chosen = self.settings.iter().find_map(|setting| match setting {
            Setting::By(methods) => Some(methods.clone()),
            _ => None,
        });
        chosen.unwrap_or_else(|| vec![Method::of("default"), Method::of("event")])
    }

    /// The methods that it asks for.
    pub(crate) fn all_methods(&self) -> Vec<Method> {
        let each = self.expectations.iter();
        let mut methods: Vec<Method> = each.flat_map(|expected| self.methods(expected)).collect();
        methods.sort();
        methods.dedup();
        methods
    }

    /// A run of whose status nothing is said is to be solved.
    fn expect_solved(&mut self) {
        let tells = |expectation: &Expectation| match &expectation.claim {
            Claim::Text(text, _, present) => {
                text.kind == "status" || text.kind == "refusal" && *present
            }
            Claim::Message(..) => true,
            _ => false,
        };
        if self.expectations.iter().any(tells) {
            return;
        }
        let mut solved = self.expectations[0].clone();
        let status = Text {
            kind: "status",
            of: String::new(),
        };
        solved.claim = Claim::Text(status, vec!["solved".to_owned()], true);
        solved.by = self.all_methods();
        self.expectations.insert(0, solved);
    }
}

impl Reader {
    fn line(&mut self, line: &Line) -> Result<(), String> {
        let begins = |word| behind(&line.text, word);
        if let Some(text) = begins("expect") {
            let read = expectations(line, text, &mut self.next.expressions)?;
            self.next.expectations.extend(read);
        } else if let Some(text) = begins("with") {
            self.finish()?;
            self.next.shown = format!("{} {text}", self.next.shown);
            for run in parts(text, ";") {
                let read = settings(line.number, run, &mut self.next.expressions)?;
                self.choices.push(read);
            }
        } else if let Some(text) = begins("root") {
            self.root(line.number, text)?;
        } else if begins("let").or(begins("fn")).is_some() {
            self.next.definitions.push(line.clone());
        } else {
            return Err(
                "this begins with none of `expect`, `with`, `let`, `fn`, `root`".to_owned(),
            );
        }
        Ok(())
    }

    fn root(&mut self, number: usize, text: &str) -> Result<(), String> {
        let form = "a root is `root NAME: UNIT in A..B: LEFT == RIGHT`";
        let (named, rest) = split(text, " in ").ok_or(form)?;
        let (between, equation) = split(rest, ":").ok_or(form)?;
        let (low, high) = split(between, "..").ok_or(form)?;
        let (left, right) = split(equation, "==").ok_or(form)?;
        let mut add = |text: &str| self.next.expressions.add(number, text);
        self.next.roots.push(Root {
            name: named
                .split(':')
                .next()
                .unwrap_or_default()
                .trim()
                .to_owned(),
            between: [add(low), add(high)],
            vanishes: add(&format!("({left}) - ({right})")),
        });
        let text = format!("parameters {{ {named} = 1 }}");
        self.next.definitions.push(Line { number, text });
        Ok(())
    }

    /// Ends the runs that have been told about.
    fn finish(&mut self) -> Result<(), String> {
        if self.next.expectations.is_empty() {
            return Ok(());
        }
        let mut choices = std::mem::take(&mut self.choices);
        if choices.is_empty() {
            choices.push(Vec::new());
        }
        for settings in choices.iter().flat_map(|choices| combinations(choices)) {
            let mut block = self.next.clone();
            for setting in &settings {
                if let Setting::Replaced(from, to) = setting {
                    if !block.scene.contains(from.as_str()) {
                        return Err(format!("the scene has no `{from}` to be replaced"));
                    }
                    block.scene = block.scene.replace(from.as_str(), to);
                }
            }
            block.settings = settings;
            block.expect_solved();
            self.blocks.push(block);
        }
        self.next.expectations.clear();
        self.next.shown.clear();
        self.leave_out();
        Ok(())
    }

    /// What was expected of one run is no expression of the next.
    fn leave_out(&mut self) {
        let roots = self.next.roots.iter();
        let kept: Vec<Id> = roots
            .flat_map(|r| [r.between[0], r.between[1], r.vanishes])
            .collect();
        let Expressions { own, theirs } = &mut self.next.expressions;
        let own = own
            .iter_mut()
            .enumerate()
            .filter(|(id, _)| !kept.contains(id));
        for expression in own.map(|(_, own)| own).chain(theirs) {
            "0".clone_into(&mut expression.text);
        }
    }
}

/// Every choice of one setting of each item.
fn combinations(choices: &[Vec<Setting>]) -> Vec<Vec<Setting>> {
    let mut all = vec![Vec::new()];
    for choice in choices {
        let each = all.iter().flat_map(|before: &Vec<Setting>| {
            choice
                .iter()
                .map(|setting| [before.as_slice(), std::slice::from_ref(setting)].concat())
        });
        all = each.collect();
    }
    all
}
