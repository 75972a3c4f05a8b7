//! Functions that a scene declares for optimal control, with the variables that they read where they are evaluated.

use crate::model::{ConstraintDeclaration, Model, OptimalControlDeclaration};

/// An argument of the functions of a site.
#[derive(Clone)]
pub(super) struct Input {
    /// Its variable, or none where it is constant.
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
    /// Whether they are the terminal functions, of `(q, v, T)`, and not the path functions.
    pub(super) terminal: bool,
    pub(super) inputs: Vec<Input>,
    /// Functions that are constraints, and their rows.
    pub(super) rows: Vec<(usize, usize)>,
    /// What function 0 is multiplied by in the objective: a number and variables.
    pub(super) cost: Option<(f64, Vec<usize>)>,
}

/// The constraint that a function states; none for a cost.
pub(super) fn constraint_of(
    declared: &OptimalControlDeclaration,
    terminal: bool,
    function: usize,
) -> Option<&'static ConstraintDeclaration> {
    if terminal {
        let index = function.checked_sub(usize::from(declared.final_cost))?;
        declared.goals.get(index)
    } else {
        let index = function.checked_sub(usize::from(declared.running_cost))?;
        declared.constraints.get(index)
    }
}

/// The path functions of the program, of which `inputs` is the length of what they read beside contacts: conditions on forces are left out.
pub(super) fn path_functions(declared: &OptimalControlDeclaration, inputs: usize) -> Vec<usize> {
    let functions = 0..declared.path_functions();
    let stated = |&function: &usize| {
        constraint_of(declared, false, function).is_none()
            || !declared.path_jacobian.reads(function, inputs)
    };
    functions.filter(stated).collect()
}

/// The terminal conditions of the program, of which `inputs` is the length of what they read beside contacts.
pub(super) fn goals(declared: &OptimalControlDeclaration, inputs: usize) -> Vec<usize> {
    let functions = 0..declared.terminal_functions();
    let stated = |&function: &usize| {
        constraint_of(declared, true, function).is_some()
            && !declared.terminal_jacobian.reads(function, inputs)
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
    let constraints = constraints.filter(|&f| constraint_of(declared, false, f).is_some());
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
        if self.terminal {
            let mut values = vec![0.0; declared.terminal_functions()];
            model.terminal_functions(&input, &mut values);
            values
        } else {
            let mut values = vec![0.0; declared.path_functions()];
            model.path_functions(&input, &mut values);
            values
        }
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
        if self.terminal {
            model.terminal_jacobian(&input, &mut slopes);
        } else {
            model.path_jacobian(&input, &mut slopes);
        }
        Evaluated {
            values,
            slopes,
            input,
        }
    }

    fn jacobian(&self, declared: &OptimalControlDeclaration) -> &'static [(u32, u32)] {
        if self.terminal {
            declared.terminal_jacobian.entries
        } else {
            declared.path_jacobian.entries
        }
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
