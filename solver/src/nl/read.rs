//! From the bytes of a file to what it states.

use std::collections::HashMap;

use super::error::ReadError;
use super::expression::{self, Names};
use super::graph::{Graph, NodeId};
use super::heading::Heading;
use super::source::Source;
use super::statement::{Body, Demand, Duals, Statement};

/// Bounds of this size are none.
const ABSENT: f64 = 1e20;

/// What is known of a file while it is read.
struct Reader<'a> {
    source: Source<'a>,
    statement: Statement,
    /// Nodes of the common expressions.
    common: Vec<Option<NodeId>>,
    functions: Vec<(usize, String)>,
    objectives: usize,
    /// The segments that were there, by key and index; of `J` and `G` with their numbers of terms.
    segments: HashMap<(u8, usize), usize>,
}

/// Reads a file, text or binary. Suffixes, but for initial multipliers of bounds, and column counts are checked for their form and
/// skipped; of several objectives the first counts.
///
/// # Errors
/// [`ReadError`] says what in the file is not understood, and where.
pub(super) fn read(bytes: &[u8], names: &dyn Fn(usize) -> String) -> Result<Statement, ReadError> {
    let mut source = Source::new(bytes);
    let heading = Heading::read(&mut source)?;
    if let Some(variable) = heading.whole {
        return Err(ReadError::at_line(
            7,
            format!(
                "variable {} must be a whole number, but only continuous problems are solved here; relax it",
                names(variable)
            ),
        ));
    }
    let unbounded = Demand::Bounds(f64::NEG_INFINITY, f64::INFINITY);
    let mut reader = Reader {
        source,
        statement: Statement {
            options: heading.options.clone(),
            graph: Graph::new(heading.variables),
            bounds: vec![(f64::NEG_INFINITY, f64::INFINITY); heading.variables],
            start: vec![0.0; heading.variables],
            duals: Duals::default(),
            rows: vec![(Body::default(), unbounded); heading.rows],
            objective: Body::default(),
            maximizes: false,
        },
        common: vec![None; heading.common],
        functions: Vec::new(),
        objectives: heading.objectives,
        segments: HashMap::new(),
    };
    while let Some(key) = reader.source.key() {
        reader.segment(key)?;
    }
    reader.check_whole(&heading)?;
    Ok(reader.statement)
}

impl Reader<'_> {
    /// Finds out whether segments are missing that the heading counts.
    fn check_whole(&self, heading: &Heading) -> Result<(), ReadError> {
        let has = |key: u8| self.segments.contains_key(&(key, 0));
        if heading.rows > 0 && !has(b'r') {
            return Err(ReadError::whole(
                "it has no `r` segment, the bounds of the rows; it is cut off or damaged",
            ));
        }
        if heading.variables > 0 && !has(b'b') {
            return Err(ReadError::whole(
                "it has no `b` segment, the bounds of the variables; it is cut off or damaged",
            ));
        }
        let of = |key: u8| self.segments.iter().filter(move |((k, _), _)| *k == key);
        if of(b'O').count() < heading.objectives {
            return Err(ReadError::whole(format!(
                "it has {} of {} `O` segments, the objectives; it is cut off or damaged",
                of(b'O').count(),
                heading.objectives
            )));
        }
        for (key, what, counted) in [
            ('J', "rows", heading.nonzeros[0]),
            ('G', "objectives", heading.nonzeros[1]),
        ] {
            let found: usize = of(key as u8).map(|(_, terms)| terms).sum();
            if found != counted {
                return Err(ReadError::whole(format!(
                    "its heading counts {counted} nonzeros of the {what}, but its `{key}` segments have {found}; it is cut off or damaged"
                )));
            }
        }
        Ok(())
    }

    /// Notes a segment, of which there is one of each key and index.
    fn note(&mut self, key: u8, index: usize, terms: usize) -> Result<(), ReadError> {
        if self.segments.insert((key, index), terms).is_none() {
            return Ok(());
        }
        let key = char::from(key);
        let index = if matches!(key, 'r' | 'b') {
            String::new()
        } else {
            index.to_string()
        };
        Err(self
            .source
            .error(format!("a second segment `{key}{index}`; give each once")))
    }

    fn segment(&mut self, key: u8) -> Result<(), ReadError> {
        match key {
            b'C' => {
                let row = self.row()?;
                self.note(key, row, 0)?;
                let node = self.expression()?;
                self.statement.rows[row].0.expression = Some(node);
            }
            b'O' => {
                let index = self.below(self.objectives, "objective")?;
                self.note(key, index, 0)?;
                let maximizes = self.source.index()? != 0;
                let node = self.expression()?;
                if index == 0 {
                    self.statement.objective.expression = Some(node);
                    self.statement.maximizes = maximizes;
                }
            }
            b'V' => self.common_expression()?,
            b'F' => {
                let index = self.source.index()?;
                self.source.index()?;
                // a function may take any number of arguments, which is said by a negative number
                self.source.real()?;
                let name = self.source.name()?;
                self.functions.push((index, name));
            }
            b'L' => {
                return Err(self.source.error(
                    "a logical constraint, which is not solved here; state it by inequalities",
                ));
            }
            b'S' => self.suffix()?,
            b'd' => {
                self.statement.duals.rows = self.pairs("row", self.statement.rows.len())?;
            }
            b'x' => {
                for (variable, value) in self.pairs("variable", self.statement.start.len())? {
                    self.statement.start[variable] = value;
                }
            }
            b'r' => {
                self.note(key, 0, 0)?;
                self.row_bounds()?;
            }
            b'b' => {
                self.note(key, 0, 0)?;
                self.variable_bounds()?;
            }
            b'k' | b'K' => {
                let count = self.source.index()?;
                for _ in 0..count {
                    self.source.index()?;
                }
            }
            b'J' => {
                let row = self.row()?;
                let terms = self.terms()?;
                self.note(key, row, terms.len())?;
                self.statement.rows[row].0.linear = linear(terms);
            }
            b'G' => {
                let index = self.below(self.objectives, "objective")?;
                let terms = self.terms()?;
                self.note(key, index, terms.len())?;
                if index == 0 {
                    self.statement.objective.linear = linear(terms);
                }
            }
            _ => {
                return Err(self.source.error(format!(
                    "expected a segment, found `{}`; segments begin with one of C O V F S d x r b k J G",
                    char::from(key).escape_default()
                )));
            }
        }
        Ok(())
    }

    /// An index below a bound.
    fn below(&mut self, count: usize, what: &str) -> Result<usize, ReadError> {
        let index = self.source.index()?;
        if index < count {
            return Ok(index);
        }
        Err(self.source.error(format!(
            "there is no {what} {index}: there are {count}, counted from 0"
        )))
    }

    fn row(&mut self) -> Result<usize, ReadError> {
        self.below(self.statement.rows.len(), "row")
    }

    fn expression(&mut self) -> Result<NodeId, ReadError> {
        let names = Names {
            variables: self.statement.start.len(),
            common: &self.common,
            functions: &self.functions,
        };
        expression::read(&mut self.source, &mut self.statement.graph, &names)
    }

    /// `V index terms where`, linear terms, and an expression.
    fn common_expression(&mut self) -> Result<(), ReadError> {
        let variables = self.statement.start.len();
        let index = self.source.index()?;
        let place = index.checked_sub(variables);
        let Some(place) = place.filter(|&place| place < self.common.len()) else {
            return Err(self.source.error(format!(
                "there is no common expression v{index}: they are v{variables} to v{}",
                variables + self.common.len()
            )));
        };
        let count = self.source.index()?;
        self.source.index()?;
        let mut terms = Vec::new();
        for _ in 0..count {
            let variable = self.below(variables, "variable")?;
            terms.push((variable as NodeId, self.source.finite()?));
        }
        terms.push((self.expression()?, 1.0));
        let node = self.statement.graph.sum(0.0, &terms);
        self.statement.graph.share(node);
        self.common[place] = Some(node);
        Ok(())
    }

    /// `S kind count name` and as many pairs: multipliers of bounds, or what says nothing that counts here.
    fn suffix(&mut self) -> Result<(), ReadError> {
        let kind = self.source.index()?;
        let count = self.source.index()?;
        let name = self.source.name()?;
        let variables = self.statement.start.len();
        let mut pairs = Vec::new();
        for _ in 0..count {
            let index = self.source.index()?;
            // bit 2 says that the values are real
            let value = if kind & 4 != 0 {
                self.source.real()?
            } else {
                self.source.whole(false)?
            };
            if index < variables && value.is_finite() {
                pairs.push((index, value));
            }
        }
        // bits 0 and 1 say what the indices count: variables
        match (kind & 3, name.as_str()) {
            (0, "ipopt_zL_in") => self.statement.duals.lower = pairs,
            (0, "ipopt_zU_in") => self.statement.duals.upper = pairs,
            _ => {}
        }
        Ok(())
    }

    /// `count` pairs of an index and a finite number.
    fn pairs(&mut self, what: &str, most: usize) -> Result<Vec<(usize, f64)>, ReadError> {
        let count = self.source.index()?;
        let mut pairs = Vec::new();
        for _ in 0..count {
            let index = self.below(most, what)?;
            pairs.push((index, self.source.finite()?));
        }
        Ok(pairs)
    }

    /// The linear terms of a row or an objective.
    fn terms(&mut self) -> Result<Vec<(usize, f64)>, ReadError> {
        self.pairs("variable", self.statement.start.len())
    }

    /// Bounds of a kind: 0 both, 1 upper, 2 lower, 3 none, 4 equality.
    fn bounds(&mut self, kind: usize) -> Result<(f64, f64), ReadError> {
        let (lower, upper) = match kind {
            0 => (self.source.real()?, self.source.real()?),
            1 => (f64::NEG_INFINITY, self.source.real()?),
            2 => (self.source.real()?, f64::INFINITY),
            3 => (f64::NEG_INFINITY, f64::INFINITY),
            4 => {
                let value = self.source.finite()?;
                (value, value)
            }
            _ => {
                return Err(self.source.error(format!(
                    "there is no bound of kind {kind}; kinds are 0 to 4, and 5 for a row that complements a variable"
                )));
            }
        };
        // modelling languages write such numbers where there is no bound
        let lower = if lower <= -ABSENT {
            f64::NEG_INFINITY
        } else {
            lower
        };
        let upper = if upper >= ABSENT {
            f64::INFINITY
        } else {
            upper
        };
        if lower > upper || lower == f64::INFINITY || upper == f64::NEG_INFINITY {
            return Err(self.source.error(format!(
                "lower bound {lower}, upper bound {upper}; give bounds with lower <= upper"
            )));
        }
        Ok((lower, upper))
    }

    fn variable_bounds(&mut self) -> Result<(), ReadError> {
        for variable in 0..self.statement.bounds.len() {
            let kind = self.source.digit()?;
            self.statement.bounds[variable] = self.bounds(kind)?;
        }
        Ok(())
    }

    fn row_bounds(&mut self) -> Result<(), ReadError> {
        for row in 0..self.statement.rows.len() {
            let kind = self.source.digit()?;
            self.statement.rows[row].1 = if kind == 5 {
                let flags = self.source.index()?;
                let variable = self.source.index()?;
                let variables = self.statement.start.len();
                if variable == 0 || variable > variables {
                    return Err(self.source.error(format!(
                        "row {row} complements variable {variable}, but there are {variables}, counted from 1"
                    )));
                }
                Demand::Complements {
                    variable: variable - 1,
                    lower: flags & 1 != 0,
                    upper: flags & 2 != 0,
                }
            } else {
                let (lower, upper) = self.bounds(kind)?;
                Demand::Bounds(lower, upper)
            };
        }
        Ok(())
    }
}

/// Linear terms, each variable at most once and without those that are zero.
fn linear(mut terms: Vec<(usize, f64)>) -> Vec<(usize, f64)> {
    terms.sort_unstable_by_key(|term| term.0);
    terms.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    terms.retain(|term| term.1 != 0.0);
    terms
}
