//! The points of a sweep and the row of each: what a row holds depends on nothing but the sweep and its number.

use std::ops::Range;

use crate::arguments::{SimulateArguments, SolveArguments};
use crate::failure::BadInput;
use crate::host::{HostScene, Refusal};
use crate::job::Run;
use crate::settings::ChosenScene;

use super::axis::{Axis, MOST_POINTS};
use super::record::{Record, sequence};

/// A sweep of one scene over the values of its parameters.
///
/// Points are numbered from 0; the last parameter changes fastest. A row begins with the number of its point and ends
/// with the mark of the sweep: two tables with the same mark hold parts of the same sweep.
pub struct SweepPlan {
    scene: HostScene,
    solve: bool,
    words: Vec<String>,
    axes: Vec<Axis>,
    records: Vec<Record>,
    /// Points of a chain, each of which starts from the one before it; 1: all start from nothing.
    warm: usize,
    mark: String,
}

/// What a sweep does beside its points: the parts of a command that is no scene and no values.
#[derive(Debug, Clone, Copy)]
pub struct SweepWork<'a> {
    /// Solve instead of simulate.
    pub solve: bool,
    /// Points of a chain, each of which starts from the motion found at the one before it; 1 for none. Chains go along the last
    /// parameter.
    pub warm: usize,
    /// The words that stand behind the scene on the command line.
    pub words: &'a [String],
    /// Names of the numbers to record.
    pub record: &'a [String],
}

impl std::fmt::Debug for SweepPlan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SweepPlan")
            .field("mark", &self.mark)
            .finish_non_exhaustive()
    }
}

impl SweepPlan {
    /// The sweep of `scene` over `over`, each `NAME=from:to:count[UNIT]` or `NAME=a,b,c`.
    ///
    /// # Errors
    /// Names that the scene or its runs do not have, values without meaning, and words that the command refuses.
    pub fn new(scene: HostScene, over: &[String], work: &SweepWork<'_>) -> Result<Self, Refusal> {
        Ok(Self::read(scene, over, work)?)
    }

    pub(super) fn read(
        scene: HostScene,
        over: &[String],
        work: &SweepWork<'_>,
    ) -> Result<Self, BadInput> {
        let &SweepWork {
            solve,
            warm,
            words,
            record,
        } = work;
        // As they are understood, so that other spellings of the same words are the same sweep.
        let (settings, understood) = if solve {
            let arguments: SolveArguments = scene.arguments("solve", words)?;
            let understood = format!("{arguments:?}");
            (arguments.scene.settings, understood)
        } else {
            let arguments: SimulateArguments = scene.arguments("simulate", words)?;
            let understood = format!("{arguments:?}");
            (arguments.scene.settings, understood)
        };
        let chosen = scene.chosen(&settings)?;
        if solve && chosen.model.declaration().optimal_control.is_none() {
            return Err(BadInput::new(format!(
                "scene `{}` declares no objective, so there is nothing to optimize; sweep with --what simulate",
                scene.name()
            )));
        }
        if over.is_empty() {
            return Err(BadInput::new(
                "a sweep needs values; add --over NAME=from:to:count or --over NAME=a,b,c",
            ));
        }
        let axes = read_axes(&chosen, over, &settings)?;
        check_warm(work, &axes)?;
        let count = axes.iter().try_fold(1_usize, |product, axis| {
            let product = product.checked_mul(axis.values.len());
            product.filter(|&count| count <= MOST_POINTS)
        });
        let count = count.ok_or_else(|| {
            BadInput::new(format!(
                "--over: more than {MOST_POINTS} points; take fewer values, or several sweeps"
            ))
        })?;
        let records = record.iter().map(|name| Record::read(&chosen, name, solve));
        let records = records.collect::<Result<Vec<_>, _>>()?;
        let parts = [scene.name(), scene.identity(), env!("CARGO_PKG_VERSION")];
        let parts = parts
            .into_iter()
            .chain([if solve { "solve" } else { "simulate" }]);
        let parts = parts.chain([understood.as_str()]);
        let axis_parts = axes
            .iter()
            .flat_map(|axis| std::iter::once(axis.name.clone()).chain(axis.compared()));
        let axis_parts: Vec<String> = axis_parts.collect();
        let parts = parts
            .chain(axis_parts.iter().map(String::as_str))
            .chain(record.iter().map(String::as_str));
        let chains = (warm > 1).then(|| format!("warm={warm}"));
        let parts = parts.chain(chains.as_deref());
        let mark = format!("{:016x}/{count}", digest(parts));
        Ok(Self {
            scene,
            solve,
            words: words.to_vec(),
            axes,
            records,
            warm,
            mark,
        })
    }

    /// How many points there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// How many chains there are; without warm starts every point is one.
    #[must_use]
    pub fn chains(&self) -> usize {
        match self.axes.last().map_or(0, |axis| axis.values.len()) {
            0 => 0,
            length => self.count() / length * length.div_ceil(self.warm),
        }
    }

    /// The points of a chain, below [`SweepPlan::chains`], which follow each other along the last parameter.
    #[must_use]
    pub fn chain(&self, number: usize) -> Range<usize> {
        let length = self.axes.last().map_or(1, |axis| axis.values.len());
        let of_a_line = length.div_ceil(self.warm);
        let (line, place) = (number / of_a_line, number % of_a_line);
        let first = place * self.warm;
        let last = (first + self.warm).min(length);
        line * length + first..line * length + last
    }

    /// The mark of the sweep, `digest/count`: of the scene's text, the command, its words, the values and the records.
    #[must_use]
    pub fn mark(&self) -> &str {
        &self.mark
    }

    /// The headings of the columns, as a line of CSV without its end.
    #[must_use]
    pub fn header(&self) -> String {
        let mut cells = vec!["point".to_owned()];
        cells.extend(self.axes.iter().map(Axis::heading));
        cells.extend(["status", "message", "sequence"].map(str::to_owned));
        cells.extend(self.records.iter().map(|record| record.heading.clone()));
        cells.push("sweep".to_owned());
        line(&cells)
    }

    /// The place of the column with the status; the cells before it hold no commas.
    pub(super) fn status_column(&self) -> usize {
        1 + self.axes.len()
    }

    /// The values of point `number`, one of each parameter.
    fn values(&self, number: usize) -> Vec<&str> {
        let mut rest = number;
        let mut values: Vec<&str> = Vec::with_capacity(self.axes.len());
        for axis in self.axes.iter().rev() {
            values.push(&axis.values[rest % axis.values.len()]);
            rest /= axis.values.len();
        }
        values.reverse();
        values
    }

    /// Computes the rows of the points of a chain, below [`SweepPlan::chains`], as lines of CSV without their ends. The first point
    /// starts from nothing; another one starts from the motion found at the one before it, if there is one, and from nothing where
    /// that leads to no solution: so that a row depends on the points before it in its chain, and on nothing else. A point that is
    /// refused has the status `refused`, and the message says why. `goes_on` is asked now and then.
    #[must_use]
    pub fn rows(&self, chain: usize, goes_on: &(dyn Fn() -> bool + Sync)) -> Vec<String> {
        let mut before = None;
        let points = self.chain(chain);
        let row = points.map(|number| {
            let (row, run) = self.row(number, before.as_ref(), goes_on);
            before = run;
            row
        });
        row.collect()
    }

    /// The row of a point that starts from the motion of another run, if there is one; and its run.
    fn row(
        &self,
        number: usize,
        before: Option<&Run>,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> (String, Option<Run>) {
        let values = self.values(number);
        let mut words = self.words.clone();
        for (axis, value) in self.axes.iter().zip(&values) {
            words.push(format!("--set={}={value}", axis.name));
        }
        let run = self.run(&words, before, goes_on);
        let mut cells = vec![number.to_string()];
        cells.extend(values.into_iter().map(str::to_owned));
        match &run {
            Ok(run) => {
                // A document is JSON.
                let document = serde_json::from_str(&run.json()).unwrap_or_default();
                let message = run.diagnosis().unwrap_or_default();
                cells.extend([run.status(), message, &sequence(&document)].map(str::to_owned));
                cells.extend(
                    self.records
                        .iter()
                        .map(|record| record.cell(run, &document)),
                );
            }
            Err(refusal) => {
                let refusal = refusal.to_string();
                let message = refusal.strip_prefix("error: ").unwrap_or(&refusal);
                cells.extend(["refused", message, ""].map(str::to_owned));
                cells.extend(self.records.iter().map(|_| String::new()));
            }
        }
        cells.push(self.mark.clone());
        (line(&cells), run.ok())
    }

    /// The run of a point, from the motion of another one where that leads to a solution.
    fn run(
        &self,
        words: &[String],
        before: Option<&Run>,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Run, Refusal> {
        if !self.solve {
            return self.scene.simulate(words, &mut |_| goes_on());
        }
        if let Some(before) = before.filter(|before| before.is_start()) {
            let run = self.scene.solve_from(words, before, &mut |_| goes_on())?;
            if run.is_solved() || !goes_on() {
                return Ok(run);
            }
        }
        self.scene.solve(words, &mut |_| goes_on())
    }
}

/// The values of the parameters, none of which may be given twice.
fn read_axes(
    chosen: &ChosenScene,
    over: &[String],
    settings: &[String],
) -> Result<Vec<Axis>, BadInput> {
    let axes = over.iter().map(|text| Axis::read(chosen, text));
    let axes = axes.collect::<Result<Vec<_>, _>>()?;
    for (index, axis) in axes.iter().enumerate() {
        let names = axes[..index].iter().map(|earlier| earlier.name.as_str());
        let given = settings
            .iter()
            .filter_map(|setting| setting.split_once('='));
        let mut names = names.chain(given.map(|(name, _)| name.trim()));
        if names.any(|name| name == axis.name) {
            return Err(BadInput::new(format!(
                "--over: `{}` is given twice; keep one of them",
                axis.name
            )));
        }
    }
    Ok(axes)
}

/// Refuses chains of what has no start to hand on.
fn check_warm(work: &SweepWork<'_>, axes: &[Axis]) -> Result<(), BadInput> {
    if work.warm <= 1 {
        return Ok(());
    }
    if !work.solve {
        return Err(BadInput::new(
            "--warm: simulations start from nothing else than their scene; leave it out, or sweep with --what solve",
        ));
    }
    match axes.last() {
        Some(axis) if axis.is_choice => Err(BadInput::new(format!(
            "--warm: the last parameter, `{}`, chooses a form of the scene, whose motions are no starts for another form; name a \
             parameter with numbers last",
            axis.name
        ))),
        _ => Ok(()),
    }
}

/// Cells as a line of CSV without its end; line ends within cells become spaces, so that a row is a line.
fn line(cells: &[String]) -> String {
    let cell = |text: &String| {
        let text = text.replace(['\n', '\r'], " ");
        if text.contains([',', '"']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text
        }
    };
    cells.iter().map(cell).collect::<Vec<_>>().join(",")
}

/// FNV-1a with 64 bits (Fowler, Noll, Vo) of parts of a text, which are told apart by their ends.
fn digest<'a>(parts: impl Iterator<Item = &'a str>) -> u64 {
    /// Offset basis and prime of that function.
    const FNV: (u64, u64) = (0xcbf2_9ce4_8422_2325, 0x0000_0100_0000_01b3);
    let bytes = parts.flat_map(|part| part.bytes().chain([0xff]));
    bytes.fold(FNV.0, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(FNV.1)
    })
}

#[cfg(test)]
mod tests {
    use super::{digest, line};

    #[test]
    fn digest_is_that_of_the_published_function_and_tells_parts_apart() {
        // Of nothing: the offset basis; of one part `a`: FNV-1a("a\xff").
        assert_eq!(digest([].into_iter()), 0xcbf2_9ce4_8422_2325);
        assert_ne!(digest(["ab"].into_iter()), digest(["a", "b"].into_iter()));
        assert_ne!(
            digest(["a", "b"].into_iter()),
            digest(["b", "a"].into_iter())
        );
    }

    #[test]
    fn row_is_one_line_whatever_its_cells_hold() {
        let cells = ["1", "a, b", "say \"no\"\nor\r", ""].map(str::to_owned);
        assert_eq!(line(&cells), "1,\"a, b\",\"say \"\"no\"\" or \",");
    }
}
