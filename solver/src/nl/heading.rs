//! The ten lines at the head of a file.

use super::error::ReadError;
use super::source::Source;

/// What the heading says.
#[derive(Debug)]
pub(super) struct Heading {
    pub(super) options: Vec<String>,
    pub(super) variables: usize,
    pub(super) rows: usize,
    pub(super) objectives: usize,
    /// Common expressions, all kinds together.
    pub(super) common: usize,
    /// Nonzeros of the rows and of the objectives.
    pub(super) nonzeros: [usize; 2],
    /// The first variable that must be whole, if there is one.
    pub(super) whole: Option<usize>,
}

impl Heading {
    /// Reads the heading; the source is at the first segment then, in the right encoding.
    ///
    /// # Errors
    /// [`ReadError`] if it is none, if its counts cannot be those of the file, or if the problem is of a kind that
    /// is not solved here.
    pub(super) fn read(source: &mut Source) -> Result<Self, ReadError> {
        let (is_binary, options) = first_line(source)?;
        let mut line = |name: &str, least: usize| -> Result<Vec<usize>, ReadError> {
            let numbers = source.heading_line()?.split_whitespace();
            let numbers: Option<Vec<usize>> = numbers
                .map(|word| word.parse::<u32>().ok().map(|number| number as usize))
                .collect();
            match numbers {
                Some(mut numbers) if numbers.len() >= least => {
                    numbers.resize(numbers.len().max(6), 0);
                    Ok(numbers)
                }
                _ => Err(source.error(format!(
                    "the line before holds {name}: give at least {least} whole numbers"
                ))),
            }
        };
        let sizes = line("the counts of variables, rows and objectives", 3)?;
        line("the counts of nonlinear rows and objectives", 2)?;
        let network = line("the counts of network rows", 1)?;
        let nonlinear = line("the counts of nonlinear variables", 2)?;
        line("the counts of functions", 1)?;
        let discrete = line("the counts of discrete variables", 2)?;
        let nonzeros = line("the counts of nonzeros", 2)?;
        line("the lengths of names", 1)?;
        let common = line("the counts of common expressions", 1)?;
        let [variables, rows, objectives] = [sizes[0], sizes[1], sizes[2]];
        let common = common.iter().take(5).sum();
        check_counts(
            source.remaining(),
            [
                ("variables", variables),
                ("rows", rows),
                ("objectives", objectives),
                ("common expressions", common),
            ],
        )?;
        if sizes[5] > 0 {
            return Err(ReadError::at_line(
                2,
                "the problem has logical constraints, which are not solved here; state them by inequalities",
            ));
        }
        if network[0] > 0 || network.len() > 1 && network[1] > 0 {
            return Err(ReadError::at_line(
                4,
                "the problem has network constraints; let the writer state them as ordinary rows",
            ));
        }
        if is_binary {
            source.turn_binary();
        }
        let whole = first_whole(variables, &nonlinear, &discrete);
        Ok(Self {
            options,
            variables,
            rows,
            objectives,
            common,
            nonzeros: [nonzeros[0], nonzeros[1]],
            whole,
        })
    }
}

/// Whether the file is binary, and the options of its first line.
fn first_line(source: &mut Source) -> Result<(bool, Vec<String>), ReadError> {
    let first = source.heading_line()?;
    let is_binary = first.starts_with('b');
    if !is_binary && !first.starts_with('g') {
        return Err(ReadError::at_line(
            1,
            "a .nl file begins with `g` (text) or `b` (binary); write the problem with `write gFILE;` of AMPL or with \
             a writer of .nl files",
        ));
    }
    let mut options: Vec<String> = first[1..].split_whitespace().map(str::to_owned).collect();
    // the first number counts those that belong to it
    let count = options.first().and_then(|count| count.parse().ok());
    options.truncate(count.unwrap_or(0_usize).saturating_add(1).min(10));
    Ok((is_binary, options))
}

/// Options and the counts of variables and rows, of which a file without values tells as well.
pub(super) fn counts(source: &mut Source) -> Result<(Vec<String>, usize, usize), ReadError> {
    let (_, options) = first_line(source)?;
    let mut words = source.heading_line()?.split_whitespace();
    let mut count = || words.next().and_then(|word| word.parse().ok());
    match (count(), count()) {
        (Some(variables), Some(rows)) => Ok((options, variables, rows)),
        _ => Err(source.error("the line before holds the counts of variables and rows")),
    }
}

/// Refuses counts that cannot be those of a file of `most` bytes.
fn check_counts(most: usize, counts: [(&str, usize); 4]) -> Result<(), ReadError> {
    for (what, count) in counts {
        if count > most {
            return Err(ReadError::at_line(
                2,
                format!(
                    "{count} {what}, but only {most} bytes follow the heading; the file is cut off or damaged"
                ),
            ));
        }
    }
    Ok(())
}

/// The first variable that must be whole. Variables are ordered: nonlinear in rows and objectives, in rows, in
/// objectives, then linear ones; in each class those that must be whole come last.
fn first_whole(variables: usize, nonlinear: &[usize], discrete: &[usize]) -> Option<usize> {
    let [in_rows, in_objectives, in_both] = [nonlinear[0], nonlinear[1], nonlinear[2]];
    let [binary, integer, both, rows, objectives] = [0, 1, 2, 3, 4].map(|k| discrete[k]);
    let ends = [
        (in_both, both),
        (in_rows, rows),
        (in_objectives.max(in_rows), objectives),
        (variables, binary.saturating_add(integer)),
    ];
    let firsts = ends
        .iter()
        .filter(|(_, count)| *count > 0)
        .map(|(end, count)| end.saturating_sub(*count));
    firsts.min()
}
