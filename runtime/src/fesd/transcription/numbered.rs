//! Where the variables and rows of a program begin.

use std::borrow::Cow;
use std::ops::Range;

use super::sites::Row;

/// A point at which the step form is evaluated: a Runge-Kutta stage, or the end of an element.
#[derive(Clone)]
pub(super) struct Block {
    /// Variable of each local one, unless it is constant there.
    pub(super) variables: Vec<Option<usize>>,
    /// First constraint of the algebraic rows.
    pub(super) algebraic_rows: usize,
    /// Whether this is the end of an element: only the rows of the switching functions apply.
    pub(super) boundary: bool,
}

/// One finite element: where its variables and constraints begin.
#[derive(Clone)]
pub(super) struct Element {
    pub(super) interval: usize,
    /// The first variable of its own.
    pub(super) first: usize,
    /// The variable of its length, which may be that of the element before.
    pub(super) length: usize,
    /// Its length over that of its interval where nothing else decides it.
    pub(super) even: f64,
    /// Blocks of the stages, then of the boundary if there is one.
    pub(super) blocks: Vec<Block>,
    /// First of the collocation constraints, one group of the length of `y` a block.
    pub(super) collocation_rows: usize,
    /// First sum variable, `SUMS` a group: for a contact alpha, ln, beta, lp.
    pub(super) sums: usize,
    /// First constraint that defines the sums.
    pub(super) sum_rows: usize,
    /// First row of the path constraints that hold at its stages, stage by stage.
    pub(super) path_rows: usize,
    /// What keeps coordinates on curved surfaces.
    pub(super) corrections: Vec<Correction>,
}

/// The start of the motion, where some of its values are free.
#[derive(Clone)]
pub(super) struct Beginning {
    /// Its states and switching functions; states that are given have no variable.
    pub(super) block: Block,
    /// First row `G_i - g_i(q) = 0`, one a contact where coordinates are free.
    pub(super) gap_rows: usize,
    /// End of its rows.
    pub(super) end: usize,
}

/// One control interval.
#[derive(Clone)]
pub(super) struct Interval {
    /// Variable of the numerical length \[s\].
    pub(super) length: usize,
    /// Variables of the controls, in their units; none if they are given. Where they are linear, those at the start of the interval,
    /// and those at its end, of which there are none else.
    pub(super) controls: Vec<usize>,
    pub(super) ends: Vec<usize>,
    /// Constraint `sum_e h_e = 1`; the next one is the clock, and then come the path constraints on the controls.
    pub(super) rows: usize,
}

/// What keeps coordinates on the surface of one contact in one element.
#[derive(Clone)]
pub(super) struct Correction {
    pub(super) contact: usize,
    /// First of the unknowns `mu` \[m\], one a block.
    pub(super) first: usize,
    /// First of the rows `G - g(q) = 0`, one a block.
    pub(super) rows: usize,
    /// Contact direction.
    pub(super) direction: Vec<f64>,
}

/// A control at a block that is linear between two nodes.
#[derive(Clone)]
pub(super) struct Ramp {
    pub(super) row: usize,
    /// Its variable, and those of the nodes before and after it.
    pub(super) control: usize,
    pub(super) nodes: [usize; 2],
    /// Variable of the clock at the block.
    pub(super) clock: usize,
    /// Interval, which is the number of the node before it.
    pub(super) interval: f64,
}

impl Ramp {
    /// The ramps of a block of interval `k`, their rows from `first` on; empty where controls are constant or given.
    pub(super) fn of(
        block: &Block,
        (states, time): (usize, usize),
        (k, interval): (usize, &Interval),
        first: usize,
    ) -> Vec<Self> {
        let nodes = interval.controls.iter().zip(&interval.ends);
        let controls = block.variables[states..].iter();
        let ramps = controls.zip(nodes).zip(first..);
        let ramp = |((&control, (&before, &after)), row)| {
            Some(Self {
                row,
                control: control?,
                nodes: [before, after],
                clock: block.variables[time]?,
                interval: k as f64,
            })
        };
        ramps.filter_map(ramp).collect()
    }
}

/// Where a contact provides something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// A force at a stage of an element in which the clock runs.
    Stage { element: usize, stage: usize },
    /// An impulse in the impact whose first element this is.
    Impact { first: usize },
}

/// A force or an impulse that functions read.
#[derive(Debug, Clone)]
pub(super) struct Provision {
    pub(super) variable: usize,
    pub(super) row: usize,
    pub(super) place: Place,
    /// Among all that contacts provide: the normal ones, then those along the sliding velocities.
    pub(super) number: usize,
    /// Value of one of the variable.
    pub(super) unit: f64,
    /// Places and factors of the weights that it is made of.
    pub(super) terms: Vec<(usize, f64)>,
}

/// An impact of a known motion.
#[derive(Debug, Clone)]
pub(super) struct Impact {
    /// Its elements.
    pub(super) elements: Range<usize>,
    /// What it adds to the sums, and the conditions on it.
    pub(super) rows: Vec<Row>,
}

/// What contacts provide in a known motion, where functions read it.
#[derive(Debug, Clone, Default)]
pub(super) struct Provisions {
    pub(super) all: Vec<Provision>,
    pub(super) impacts: Vec<Impact>,
    /// Variable and row of each sum over impacts.
    pub(super) sums: Vec<(usize, usize)>,
    /// First row of the path constraints on forces at the stages of each element, stage by stage; none in jumps.
    pub(super) path_rows: Vec<Option<usize>>,
}

/// Where rows of joints are evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum At {
    Start,
    Block { element: usize, block: usize },
}

/// A row of the program that is a row of `(g, w)`.
#[derive(Debug, Clone)]
pub(super) struct Use {
    pub(super) row: usize,
    /// Number in `(g, w)`.
    pub(super) output: usize,
    /// By which it is divided, so that it changes as the component that it decides.
    pub(super) size: f64,
}

/// Rows of joints at one point.
#[derive(Debug, Clone)]
pub(super) struct JointSite {
    pub(super) at: At,
    pub(super) uses: Vec<Use>,
}

/// Of each constraint, whether a joint stands in the place of its row of collocation; empty without joints.
#[derive(Debug, Clone, Default)]
pub(super) struct Replaced(pub(super) Vec<bool>);

impl Replaced {
    /// Adds entries of other rows only.
    pub(super) fn others(
        &self,
        add: &mut dyn FnMut(usize, usize, f64),
    ) -> impl FnMut(usize, usize, f64) {
        move |row, column, value| {
            if !self.0.get(row).copied().unwrap_or(false) {
                add(row, column, value);
            }
        }
    }
}

/// All rows of joints; none in a scene without.
#[derive(Debug, Clone, Default)]
pub(super) struct JointRows {
    pub(super) sites: Vec<JointSite>,
    pub(super) replaced: Replaced,
    /// First row of those at a free start.
    pub(super) first_at_start: usize,
}

impl JointRows {
    /// Which rows are replaced, until they are given back.
    pub(super) fn take_replaced(&mut self) -> Replaced {
        std::mem::take(&mut self.replaced)
    }

    /// Gives back what was taken.
    pub(super) fn give_back(&mut self, replaced: Replaced) {
        self.replaced = replaced;
    }

    /// Multipliers with none for the rows that are replaced.
    pub(super) fn without<'m>(&self, multipliers: &'m [f64]) -> Cow<'m, [f64]> {
        let mut own = Cow::Borrowed(multipliers);
        for (row, replaced) in self.replaced.0.iter().enumerate() {
            if *replaced {
                own.to_mut()[row] = 0.0;
            }
        }
        own
    }
}
