//! Functions of a model that appear in the rows of a program, with their derivatives.

use crate::model::{
    Declaration, Function, Model, Signature, SparsityPattern, contact_point, tangent_point,
};

/// A vector-valued function of a local input vector `(q, v, u, r)`, where `r` has one entry for each
/// contact that acts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Kernel {
    /// `a(q, v, u) + sum_i d_i(q) r_i`: the acceleration in contact.
    Acceleration(Vec<usize>),
    /// `sum_i d_i(q) r_i`: the effect of impulses, or of position corrections.
    Push(Vec<usize>),
    /// `(g_i(q), v_n,i(q, v))`: gap and normal velocity of one contact.
    Contact(usize),
    /// `v_t,i(q, v)`: sliding velocity of one contact with friction.
    Sliding(usize),
    /// `e_i(q) s_i`: the effect of a tangential force or impulse of one contact with friction.
    Friction(Vec<usize>),
    /// A function of joints or of optimal control as it stands, of what it reads.
    Whole(Function),
}

impl Kernel {
    /// Contacts that act.
    fn acting(&self) -> &[usize] {
        match self {
            Self::Acceleration(contacts) | Self::Push(contacts) | Self::Friction(contacts) => {
                contacts
            }
            Self::Contact(_) | Self::Sliding(_) | Self::Whole(_) => &[],
        }
    }

    /// Contact whose gap or velocities are the outputs.
    fn observed(&self) -> Option<usize> {
        match *self {
            Self::Contact(contact) | Self::Sliding(contact) => Some(contact),
            _ => None,
        }
    }

    /// The function of a contact that the kernel reads.
    fn beside(&self, contact: usize) -> Function {
        match self {
            Self::Sliding(_) | Self::Friction(_) => Function::Tangent(contact),
            _ => Function::Contact(contact),
        }
    }

    /// Patterns of Jacobian and Hessian of a contact's functions, those of its tangential side if that is what the
    /// kernel reads, and how many of them precede the direction.
    fn side(
        &self,
        declaration: &Declaration,
        contact: usize,
    ) -> (SparsityPattern, SparsityPattern, usize) {
        let contact = &declaration.contacts[contact];
        match (self, contact.friction) {
            (Self::Sliding(_) | Self::Friction(_), Some(friction)) => {
                (friction.jacobian, friction.hessian, 1)
            }
            _ => (contact.jacobian, contact.hessian, 2),
        }
    }
}

/// Adds values at their positions in a dense matrix with that many columns.
fn scatter(entries: &[(u32, u32)], values: &[f64], matrix: &mut [f64], columns: usize) {
    for (&(row, column), value) in entries.iter().zip(values) {
        matrix[row as usize * columns + column as usize] += value;
    }
}

/// A function that stands as it is, and its signature.
fn whole(kernel: &Kernel, model: &dyn Model) -> Option<(Function, Signature)> {
    match *kernel {
        Kernel::Whole(function) => Some((function, model.signature(function)?)),
        _ => None,
    }
}

/// A kernel of a model with its structure and the memory of its last evaluation.
pub(crate) struct Evaluator<'a> {
    model: &'a dyn Model,
    kernel: Kernel,
    /// Length of `(q, v, u)`, or of what functions that the scene declares read.
    plain: usize,
    coordinates: usize,
    /// Structural nonzeros of the Jacobian as (output, input).
    pub(crate) jacobian_pattern: Vec<(usize, usize)>,
    /// Structural nonzeros of the Hessian as (input, input), lower triangle.
    pub(crate) hessian_pattern: Vec<(usize, usize)>,
    point: Vec<f64>,
    weights: Vec<f64>,
    values: Vec<f64>,
    /// Values at the last point.
    pub(crate) outputs: Vec<f64>,
    /// Dense Jacobian at the last point, row-major.
    pub(crate) jacobian: Vec<f64>,
    /// Dense weighted Hessian at the last point, row-major, lower triangle.
    pub(crate) hessian: Vec<f64>,
}

/// Which derivatives of a kernel are not always 0.
struct Structure {
    /// Dense, row-major, (output, input).
    jacobian: Vec<bool>,
    /// Dense, row-major, lower triangle.
    hessian: Vec<bool>,
    inputs: usize,
}

impl Structure {
    fn of(kernel: &Kernel, model: &dyn Model, plain: usize, outputs: usize) -> Self {
        let declaration = model.declaration();
        let inputs = plain + kernel.acting().len();
        let mut structure = Self {
            jacobian: vec![false; outputs * inputs],
            hessian: vec![false; inputs * inputs],
            inputs,
        };
        if matches!(kernel, Kernel::Acceleration(_)) {
            structure.mark_first(declaration.free_jacobian, Some);
            structure.mark_second(declaration.free_hessian);
        }
        for (index, &contact) in kernel.acting().iter().enumerate() {
            let (first, second, skipped) = kernel.side(declaration, contact);
            structure.mark_first(first, |row| row.checked_sub(skipped));
            for &(row, column) in first.entries {
                if row as usize >= skipped {
                    structure.mark(plain + index, column as usize);
                }
            }
            structure.mark_second(second);
            for output in 0..declaration.coordinates.len() {
                structure.jacobian[output * inputs + plain + index] = true;
            }
        }
        if let Some(contact) = kernel.observed() {
            let (first, second, observed) = kernel.side(declaration, contact);
            structure.mark_first(first, |row| Some(row).filter(|row| *row < observed));
            structure.mark_second(second);
        }
        if let Some((_, signature)) = whole(kernel, model) {
            structure.mark_first(signature.jacobian, Some);
            structure.mark_second(signature.hessian);
        }
        structure
    }

    fn mark(&mut self, i: usize, j: usize) {
        self.hessian[i.max(j) * self.inputs + i.min(j)] = true;
    }

    fn mark_second(&mut self, pattern: SparsityPattern) {
        for &(i, j) in pattern.entries {
            self.mark(i as usize, j as usize);
        }
    }

    /// Marks the first derivatives of those functions that are outputs.
    fn mark_first(&mut self, pattern: SparsityPattern, output: impl Fn(usize) -> Option<usize>) {
        for &(row, column) in pattern.entries {
            if let Some(output) = output(row as usize) {
                self.jacobian[output * self.inputs + column as usize] = true;
            }
        }
    }

    fn entries(&self, flags: &[bool]) -> Vec<(usize, usize)> {
        let marked = flags.iter().enumerate().filter(|&(_, &flag)| flag);
        marked
            .map(|(i, _)| (i / self.inputs, i % self.inputs))
            .collect()
    }
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(model: &'a dyn Model, kernel: Kernel) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let whole = whole(&kernel, model).map(|(_, signature)| signature);
        let plain = whole.map_or(declaration.inputs(), |whole| whole.inputs);
        let inputs = plain + kernel.acting().len();
        let outputs = match kernel {
            Kernel::Contact(_) => 2,
            Kernel::Sliding(_) => 1,
            Kernel::Whole(_) => whole.map_or(0, |whole| whole.values),
            Kernel::Acceleration(_) | Kernel::Push(_) | Kernel::Friction(_) => n,
        };
        let structure = Structure::of(&kernel, model, plain, outputs);
        let values = declaration
            .contacts
            .iter()
            .flat_map(|contact| {
                let tangential = contact.friction.map(|f| [f.jacobian, f.hessian]);
                let patterns = tangential.into_iter().flatten();
                patterns.chain([contact.jacobian, contact.hessian])
            })
            .map(|pattern| pattern.entries.len())
            .chain([
                declaration.free_jacobian.entries.len(),
                declaration.free_hessian.entries.len(),
                whole.map_or(0, |whole| whole.jacobian.entries.len()),
                whole.map_or(0, |whole| whole.hessian.entries.len()),
            ])
            .max();
        Self {
            model,
            plain,
            coordinates: n,
            jacobian_pattern: structure.entries(&structure.jacobian),
            hessian_pattern: structure.entries(&structure.hessian),
            point: vec![0.0; contact_point::length(n)],
            weights: vec![0.0; 2 + n],
            values: vec![0.0; values.unwrap_or(0)],
            outputs: vec![0.0; outputs],
            jacobian: vec![0.0; outputs * inputs],
            hessian: vec![0.0; inputs * inputs],
            kernel,
        }
    }

    pub(crate) fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// Length of the local input vector.
    pub(crate) fn inputs(&self) -> usize {
        self.plain + self.kernel.acting().len()
    }

    /// Evaluates `outputs`.
    pub(crate) fn evaluate(&mut self, x: &[f64]) {
        let (plain, forces) = x.split_at(self.plain);
        match &self.kernel {
            Kernel::Acceleration(_) => self.model.free_acceleration(plain, &mut self.outputs),
            Kernel::Push(_) | Kernel::Friction(_) => self.outputs.fill(0.0),
            Kernel::Whole(function) => self.model.values(*function, plain, &mut self.outputs),
            Kernel::Contact(contact) => {
                self.model.contact(*contact, plain, &mut self.point);
                self.outputs[0] = self.point[contact_point::GAP];
                self.outputs[1] = if self.model.declaration().contacts[*contact].dry {
                    -self.point[contact_point::CURVATURE]
                } else {
                    self.point[contact_point::NORMAL_VELOCITY]
                };
            }
            Kernel::Sliding(contact) => {
                let point = &mut self.point[..tangent_point::length(self.coordinates)];
                self.model.tangent(*contact, plain, point);
                self.outputs[0] = self.point[tangent_point::SLIDING_VELOCITY];
            }
        }
        for (index, force) in forces.iter().enumerate() {
            let direction = self.locate(index, plain);
            for (output, d) in self.outputs.iter_mut().zip(&self.point[direction..]) {
                *output += d * force;
            }
        }
    }

    /// Evaluates the direction of the acting contact with this index, which begins at the returned place.
    fn locate(&mut self, index: usize, plain: &[f64]) -> usize {
        let contact = self.kernel.acting()[index];
        match self.kernel {
            Kernel::Friction(_) => {
                let point = &mut self.point[..tangent_point::length(self.coordinates)];
                self.model.tangent(contact, plain, point);
                tangent_point::direction(self.coordinates)
            }
            _ => {
                self.model.contact(contact, plain, &mut self.point);
                contact_point::direction(self.coordinates)
            }
        }
    }

    /// Writes the Jacobian of a contact's functions to `values`; returns its pattern and how many functions precede
    /// the direction.
    fn side_jacobian(&mut self, contact: usize, plain: &[f64]) -> (SparsityPattern, usize) {
        let (pattern, _, skipped) = self.kernel.side(self.model.declaration(), contact);
        let values = &mut self.values[..pattern.entries.len()];
        self.model
            .jacobian(self.kernel.beside(contact), plain, values);
        (pattern, skipped)
    }

    /// Adds the Hessian of a contact's functions, weighted by `weights`.
    fn add_side_hessian(&mut self, contact: usize, plain: &[f64]) {
        let (_, pattern, skipped) = self.kernel.side(self.model.declaration(), contact);
        let values = &mut self.values[..pattern.entries.len()];
        let weights = &self.weights[..skipped + self.coordinates];
        let function = self.kernel.beside(contact);
        self.model.hessian(function, plain, weights, values);
        let inputs = self.inputs();
        scatter(pattern.entries, &self.values, &mut self.hessian, inputs);
    }

    /// Evaluates `outputs` and `jacobian`.
    pub(crate) fn differentiate(&mut self, x: &[f64]) {
        self.evaluate(x);
        self.jacobian.fill(0.0);
        let inputs = self.inputs();
        let (plain, forces) = x.split_at(self.plain);
        let declaration = self.model.declaration();
        if matches!(self.kernel, Kernel::Acceleration(_)) {
            let entries = declaration.free_jacobian.entries;
            self.model
                .jacobian(Function::Motion, plain, &mut self.values[..entries.len()]);
            scatter(entries, &self.values, &mut self.jacobian, inputs);
        }
        for (index, force) in forces.iter().enumerate() {
            let direction = self.locate(index, plain);
            for output in 0..self.coordinates {
                self.jacobian[output * inputs + self.plain + index] =
                    self.point[direction + output];
            }
            let (pattern, skipped) = self.side_jacobian(self.kernel.acting()[index], plain);
            for (&(row, column), value) in pattern.entries.iter().zip(&self.values) {
                if row as usize >= skipped {
                    self.jacobian[(row as usize - skipped) * inputs + column as usize] +=
                        value * force;
                }
            }
        }
        if let Some((function, Signature { jacobian, .. })) = whole(&self.kernel, self.model) {
            let values = &mut self.values[..jacobian.entries.len()];
            self.model.jacobian(function, plain, values);
            scatter(jacobian.entries, &self.values, &mut self.jacobian, inputs);
        }
        if let Some(contact) = self.kernel.observed() {
            let (pattern, observed) = self.side_jacobian(contact, plain);
            for (&(row, column), value) in pattern.entries.iter().zip(&self.values) {
                if (row as usize) < observed {
                    self.jacobian[row as usize * inputs + column as usize] += value;
                }
            }
        }
    }

    /// Evaluates the Hessian of `multipliers' outputs`; call after [`differentiate`](Self::differentiate)
    /// at the same point.
    pub(crate) fn curve(&mut self, x: &[f64], multipliers: &[f64]) {
        self.hessian.fill(0.0);
        let inputs = self.inputs();
        let (plain, forces) = x.split_at(self.plain);
        let declaration = self.model.declaration();
        if matches!(self.kernel, Kernel::Acceleration(_)) {
            let entries = declaration.free_hessian.entries;
            self.model.hessian(
                Function::Motion,
                plain,
                multipliers,
                &mut self.values[..entries.len()],
            );
            scatter(entries, &self.values, &mut self.hessian, inputs);
        }
        for (index, force) in forces.iter().enumerate() {
            let contact = self.kernel.acting()[index];
            let (.., skipped) = self.kernel.side(declaration, contact);
            self.weights[..skipped].fill(0.0);
            for (weight, multiplier) in self.weights[skipped..].iter_mut().zip(multipliers) {
                *weight = multiplier * force;
            }
            self.add_side_hessian(contact, plain);
            let (pattern, skipped) = self.side_jacobian(contact, plain);
            for (&(row, column), value) in pattern.entries.iter().zip(&self.values) {
                if row as usize >= skipped {
                    self.hessian[(self.plain + index) * inputs + column as usize] +=
                        value * multipliers[row as usize - skipped];
                }
            }
        }
        if let Some((function, Signature { hessian, .. })) = whole(&self.kernel, self.model) {
            let values = &mut self.values[..hessian.entries.len()];
            self.model.hessian(function, plain, multipliers, values);
            scatter(hessian.entries, &self.values, &mut self.hessian, inputs);
        }
        if let Some(contact) = self.kernel.observed() {
            self.weights.fill(0.0);
            self.weights[..multipliers.len()].copy_from_slice(multipliers);
            self.add_side_hessian(contact, plain);
        }
    }
}
