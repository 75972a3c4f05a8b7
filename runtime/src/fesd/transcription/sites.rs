//! Functions that a scene declares for optimal control, with the variables that they read where they are evaluated.

use crate::model::{ConstraintDeclaration, Model, OptimalControlDeclaration, SparsityPattern};

/// Which functions of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Functions {
    /// Running cost and path constraints, of `(q, v, u[, t])` and what contacts provide.
    Path,
    /// Final cost and goals, of `(q, v, T)`, the sums over impacts and what contacts provide.
    Terminal,
    /// What is summed over impacts and conditions on them, of `(q, v, u[, t])` and the impulses.
    Impact,
}

/// A function of a site in a row of the program.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub(super) function: usize,
    pub(super) row: usize,
    pub(super) factor: f64,
}

impl Row {
    /// Functions in rows of their own, from `first` on.
    pub(super) fn each(functions: &[usize], first: usize) -> Vec<Self> {
        let rows = functions.iter().zip(first..);
        let row = |(&function, row)| Self {
            function,
            row,
            factor: 1.0,
        };
        rows.map(row).collect()
    }
}

/// An argument of the functions of a site.
#[derive(Clone)]
pub(super) struct Input {
    /// Its variable, or `None` where it is constant.
    pub(super) variable: Option<usize>,
    pub(super) unit: f64,
    /// Its value where it is constant.
    pub(super) constant: f64,
    /// Whether functions of this site depend on it.
    pub(super) read: bool,
}

/// Where functions of the scene are evaluated, and what for.
#[derive(Clone)]
pub(super) struct Site {
    pub(super) functions: Functions,
    pub(super) inputs: Vec<Input>,
    /// Functions that rows of the program contain.
    pub(super) rows: Vec<Row>,
    /// What function 0 is multiplied by in the objective: a number and variables.
    pub(super) cost: Option<(f64, Vec<usize>)>,
}

impl Functions {
    /// How many there are.
    fn count(self, declared: &OptimalControlDeclaration) -> usize {
        match self {
            Self::Path => declared.path_functions(),
            Self::Terminal => declared.terminal_functions(),
            Self::Impact => declared.contacts.impact_functions(),
        }
    }

    /// The constraint that a function states; none for a cost or a sum.
    pub(super) fn constraint(
        self,
        declared: &OptimalControlDeclaration,
        function: usize,
    ) -> Option<&'static ConstraintDeclaration> {
        let (first, constraints) = match self {
            Self::Path => (usize::from(declared.running_cost), declared.constraints),
            Self::Terminal => (usize::from(declared.final_cost), declared.goals),
            Self::Impact => (declared.contacts.sums, declared.contacts.constraints),
        };
        constraints.get(function.checked_sub(first)?)
    }

    /// Patterns of Jacobian and Hessian.
    fn patterns(self, declared: &OptimalControlDeclaration) -> [SparsityPattern; 2] {
        match self {
            Self::Path => [declared.path_jacobian, declared.path_hessian],
            Self::Terminal => [declared.terminal_jacobian, declared.terminal_hessian],
            Self::Impact => {
                let terms = declared.contacts;
                [terms.impact_jacobian, terms.impact_hessian]
            }
        }
    }

    /// Whether a function reads inputs from `first` on.
    pub(super) fn reads(
        self,
        declared: &OptimalControlDeclaration,
        function: usize,
        first: usize,
    ) -> bool {
        self.patterns(declared)[0].reads(function, first)
    }

    /// Whether a function reads one input.
    pub(super) fn reads_one(
        self,
        declared: &OptimalControlDeclaration,
        function: usize,
        input: usize,
    ) -> bool {
        let [jacobian, _] = self.patterns(declared);
        let mut entries = jacobian.entries.iter();
        entries.any(|&(row, column)| row as usize == function && column as usize == input)
    }
}

/// The path functions that read nothing but the first `inputs`, which are those beside contacts, and running costs whatever they
/// read.
pub(super) fn path_functions(declared: &OptimalControlDeclaration, inputs: usize) -> Vec<usize> {
    let functions = 0..declared.path_functions();
    let on_forces = conditions_on_forces(declared, inputs);
    functions.filter(|f| !on_forces.contains(f)).collect()
}

/// The path constraints that read forces, which stand behind the first `inputs`.
pub(super) fn conditions_on_forces(
    declared: &OptimalControlDeclaration,
    inputs: usize,
) -> Vec<usize> {
    let functions = 0..declared.path_functions();
    let on_forces = |&function: &usize| {
        Functions::Path.constraint(declared, function).is_some()
            && Functions::Path.reads(declared, function, inputs)
    };
    functions.filter(on_forces).collect()
}

/// The terminal conditions that read nothing but the first `inputs`.
pub(super) fn goals(declared: &OptimalControlDeclaration, inputs: usize) -> Vec<usize> {
    let functions = 0..declared.terminal_functions();
    let stated = |&function: &usize| {
        Functions::Terminal.constraint(declared, function).is_some()
            && !Functions::Terminal.reads(declared, function, inputs)
    };
    functions.filter(stated).collect()
}

/// Those of some path functions that read nothing but controls, whose inputs these are, and so have one value an interval; the others.
pub(super) fn by_interval(
    declared: &OptimalControlDeclaration,
    functions: Vec<usize>,
    controls: std::ops::Range<usize>,
) -> (Vec<usize>, Vec<usize>) {
    functions.into_iter().partition(|&function| {
        let entries = declared.path_jacobian.entries.iter();
        let mut own = entries.filter(|entry| entry.0 as usize == function);
        own.all(|entry| controls.contains(&(entry.1 as usize)))
    })
}

/// Those of some path functions that are constraints.
pub(super) fn constraints_of(
    declared: &OptimalControlDeclaration,
    functions: &[usize],
) -> Vec<usize> {
    let constraints = functions.iter().copied();
    let constraints = constraints.filter(|&f| Functions::Path.constraint(declared, f).is_some());
    constraints.collect()
}

/// Functions of a site with their derivatives at a point.
pub(super) struct Evaluated {
    pub(super) values: Vec<f64>,
    pub(super) slopes: Vec<f64>,
    pub(super) input: Vec<f64>,
}

impl Site {
    fn input(&self, x: &[f64]) -> Vec<f64> {
        let inputs = self.inputs.iter();
        inputs
            .map(|input| input.variable.map_or(input.constant, |v| input.unit * x[v]))
            .collect()
    }

    pub(super) fn values(
        &self,
        model: &dyn Model,
        declared: &OptimalControlDeclaration,
        x: &[f64],
    ) -> Vec<f64> {
        let input = self.input(x);
        let mut values = vec![0.0; self.functions.count(declared)];
        match self.functions {
            Functions::Path => model.path_functions(&input, &mut values),
            Functions::Terminal => model.terminal_functions(&input, &mut values),
            Functions::Impact => model.impact_functions(&input, &mut values),
        }
        values
    }

    pub(super) fn evaluate(
        &self,
        model: &dyn Model,
        declared: &OptimalControlDeclaration,
        x: &[f64],
    ) -> Evaluated {
        let input = self.input(x);
        let values = self.values(model, declared, x);
        let mut slopes = vec![0.0; self.jacobian(declared).len()];
        match self.functions {
            Functions::Path => model.path_jacobian(&input, &mut slopes),
            Functions::Terminal => model.terminal_jacobian(&input, &mut slopes),
            Functions::Impact => model.impact_jacobian(&input, &mut slopes),
        }
        Evaluated {
            values,
            slopes,
            input,
        }
    }

    fn jacobian(&self, declared: &OptimalControlDeclaration) -> &'static [(u32, u32)] {
        self.functions.patterns(declared)[0].entries
    }

    /// Entries (i, j, value) of the Hessian of the weighted functions, as variables.
    pub(super) fn curvatures(
        &self,
        model: &dyn Model,
        declared: &OptimalControlDeclaration,
        input: &[f64],
        weights: &[f64],
    ) -> Vec<(usize, usize, f64)> {
        let [_, pattern] = self.functions.patterns(declared);
        let mut curvatures = vec![0.0; pattern.entries.len()];
        match self.functions {
            Functions::Path => model.path_hessian(input, weights, &mut curvatures),
            Functions::Terminal => model.terminal_hessian(input, weights, &mut curvatures),
            Functions::Impact => model.impact_hessian(input, weights, &mut curvatures),
        }
        let entries = pattern.entries.iter().zip(&curvatures);
        let of_variables = |(&(i, j), curvature): (&(u32, u32), &f64)| {
            let ((a, of_a), (b, of_b)) = (self.argument(i)?, self.argument(j)?);
            Some((a, b, of_a * of_b * curvature))
        };
        entries.filter_map(of_variables).collect()
    }

    /// Variable and unit of an argument on which functions of this site depend.
    pub(super) fn argument(&self, k: u32) -> Option<(usize, f64)> {
        let input = &self.inputs[k as usize];
        input.variable.filter(|_| input.read).zip(Some(input.unit))
    }

    /// Variables and slopes of one function.
    pub(super) fn gradient_of(
        &self,
        declared: &OptimalControlDeclaration,
        slopes: &[f64],
        function: usize,
    ) -> impl Iterator<Item = (usize, f64)> {
        let entries = self.jacobian(declared).iter().zip(slopes);
        entries.filter_map(move |(&(row, column), slope)| {
            let (variable, unit) = self.argument(column)?;
            (row as usize == function).then_some((variable, unit * slope))
        })
    }
}

/// `factor` times the product of the variables but those at the places `left_out`.
pub(super) fn product(factor: f64, variables: &[usize], left_out: &[usize], x: &[f64]) -> f64 {
    let kept = variables.iter().enumerate();
    let kept = kept.filter(|(place, _)| !left_out.contains(place));
    kept.fold(factor, |product, (_, &variable)| product * x[variable])
}
