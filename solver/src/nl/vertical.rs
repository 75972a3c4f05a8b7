//! From rows that complement variables to the vertical form: pairs of variables that are bounded below by zero.
//!
//! A row `F` that complements `l <= x <= u` by its lower bound says `0 <= x - l  _|_  F >= 0`, by its upper bound
//! `0 <= u - x  _|_  -F >= 0`, by both `F >= 0` at `l`, `F <= 0` at `u` and `F = 0` between them, and by none `F = 0`.
//! Most sides need no variable of their own: `x` is measured from its bound, and so is the variable of an `F` that is
//! linear in one variable. Everything else gets a slack and a row.

use super::error::ReadError;
use super::statement::Demand;
use super::tape::Function;

/// How a variable of the file is measured: `x = offset + sign v`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measure {
    pub(super) offset: f64,
    pub(super) sign: f64,
}

impl Measure {
    const PLAIN: Self = Self {
        offset: 0.0,
        sign: 1.0,
    };
}

/// A row of the program.
#[derive(Debug, Clone)]
pub(super) struct Row {
    /// The row of the file it comes from.
    pub(super) of: usize,
    pub(super) function: Function,
    pub(super) lower: f64,
    pub(super) upper: f64,
}

/// What a slack is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slack {
    /// The distance of a variable from a bound.
    Distance { variable: usize },
    /// The positive or the negative part of a row of the file.
    Part { row: usize },
}

/// Variables, rows and pairs of a program in vertical form. The variables of the file come first.
#[derive(Debug, Default)]
pub(super) struct Vertical {
    pub(super) measures: Vec<Measure>,
    /// Bounds of the variables of the file and of the slacks, as the file measures them.
    pub(super) bounds: Vec<(f64, f64)>,
    pub(super) slacks: Vec<Slack>,
    pub(super) rows: Vec<Row>,
    pub(super) pairs: Vec<(usize, usize)>,
    /// Whether something is measured from a bound already.
    is_measured: Vec<bool>,
    /// Distances that got a slack: (variable, from its lower bound, slack).
    distances: Vec<(usize, bool, usize)>,
}

/// A row that complements a variable, by one or both bounds.
struct Complement {
    row: usize,
    function: Function,
    /// The sides `x - l` and `u - x` that take part.
    sides: [Option<usize>; 2],
}

impl Vertical {
    /// The vertical form of rows with their demands.
    ///
    /// # Errors
    /// [`ReadError`] if a row complements an absent bound.
    pub(super) fn new(
        bounds: Vec<(f64, f64)>,
        rows: Vec<(Function, Demand)>,
        names: &dyn Fn(usize) -> String,
    ) -> Result<Self, ReadError> {
        let mut vertical = Self {
            measures: vec![Measure::PLAIN; bounds.len()],
            is_measured: vec![false; bounds.len()],
            bounds,
            ..Self::default()
        };
        let mut complements = Vec::new();
        for (of, (function, demand)) in rows.into_iter().enumerate() {
            match demand {
                Demand::Bounds(lower, upper) => vertical.add_row(of, function, (lower, upper)),
                Demand::Complements {
                    variable,
                    lower,
                    upper,
                } => {
                    let (l, u) = vertical.bounds[variable];
                    // by both bounds: by those that there are
                    let (lower, upper) = if lower && upper {
                        (l.is_finite(), u.is_finite())
                    } else {
                        (lower, upper)
                    };
                    if lower && l.is_infinite() || upper && u.is_infinite() {
                        let which = if lower && l.is_infinite() {
                            "lower"
                        } else {
                            "upper"
                        };
                        return Err(ReadError::whole(format!(
                            "row {of} complements variable {0} at its {which} bound, which is infinite; give {0} this bound",
                            names(variable)
                        )));
                    }
                    let sides = match (lower, upper) {
                        // a fixed variable leaves the row free
                        (true, true) if l == u => continue,
                        (false, false) => {
                            vertical.add_row(of, function, (0.0, 0.0));
                            continue;
                        }
                        _ => [(lower, true), (upper, false)].map(|(takes_part, at_lower)| {
                            takes_part.then(|| vertical.distance(of, variable, at_lower))
                        }),
                    };
                    complements.push(Complement {
                        row: of,
                        function,
                        sides,
                    });
                }
            }
        }
        for complement in complements {
            vertical.complement(complement);
        }
        Ok(vertical)
    }

    fn add_row(&mut self, of: usize, function: Function, (lower, upper): (f64, f64)) {
        self.rows.push(Row {
            of,
            function,
            lower,
            upper,
        });
    }

    /// A new variable that is not negative.
    fn slack(&mut self, slack: Slack) -> usize {
        self.measures.push(Measure::PLAIN);
        self.is_measured.push(true);
        self.bounds.push((0.0, f64::INFINITY));
        self.slacks.push(slack);
        self.bounds.len() - 1
    }

    /// Measures a variable from a bound, unless it is measured otherwise already.
    fn measure(&mut self, variable: usize, measure: Measure) -> bool {
        if !self.is_measured[variable] {
            self.measures[variable] = measure;
            self.is_measured[variable] = true;
        }
        self.measures[variable] == measure
    }

    /// The variable that is `x - l` or `u - x`.
    fn distance(&mut self, row: usize, variable: usize, at_lower: bool) -> usize {
        let (lower, upper) = self.bounds[variable];
        let (offset, sign) = if at_lower {
            (lower, 1.0)
        } else {
            (upper, -1.0)
        };
        if self.measure(variable, Measure { offset, sign }) {
            return variable;
        }
        let mut known = self.distances.iter();
        if let Some(&(_, _, slack)) = known.find(|known| (known.0, known.1) == (variable, at_lower))
        {
            return slack;
        }
        let slack = self.slack(Slack::Distance { variable });
        self.distances.push((variable, at_lower, slack));
        let function = Function {
            linear: vec![(variable, 1.0), (slack, -sign)],
            ..Function::default()
        };
        self.add_row(row, function, (offset, offset));
        slack
    }

    /// Pairs the sides of a variable with the positive and the negative part of its row.
    fn complement(&mut self, complement: Complement) {
        let Complement {
            row,
            mut function,
            sides,
        } = complement;
        if let [Some(side), None] | [None, Some(side)] = sides {
            let sign = if sides[0].is_some() { 1.0 } else { -1.0 };
            match self.single(&function, sign) {
                // what complements itself is zero
                Some(other) if other == side => {
                    let offset = self.measures[side].offset;
                    self.bounds[side] = (offset, offset);
                    return;
                }
                Some(other) => {
                    self.pairs.push((side, other));
                    return;
                }
                None => {}
            }
        }
        for (side, sign) in sides.into_iter().zip([-1.0, 1.0]) {
            if let Some(side) = side {
                let part = self.slack(Slack::Part { row });
                function.linear.push((part, sign));
                self.pairs.push((side, part));
            }
        }
        self.add_row(row, function, (0.0, 0.0));
    }

    /// The variable that is a positive multiple of `sign F`, where `F` is linear in one variable that can be measured from
    /// where `F` vanishes.
    fn single(&mut self, function: &Function, sign: f64) -> Option<usize> {
        let ([(variable, coefficient)], []) = (&function.linear[..], &function.nodes[..]) else {
            return None;
        };
        let (variable, slope) = (*variable, sign * coefficient);
        let offset = 0.0 - function.constant / coefficient;
        let (lower, upper) = self.bounds[variable];
        let fits = offset.is_finite() && (lower..=upper).contains(&offset);
        let measure = Measure {
            offset,
            sign: slope.signum(),
        };
        if !fits || !self.measure(variable, measure) {
            return None;
        }
        let bounds = &mut self.bounds[variable];
        if slope > 0.0 {
            bounds.0 = offset;
        } else {
            bounds.1 = offset;
        }
        Some(variable)
    }
}
