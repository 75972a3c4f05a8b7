//! Derivatives of a scene by its parameters.

/// Derivatives of the functions of a [`Model`](super::Model) by its inputs `x` and by some of its parameters, at the values that
/// these had when this was made.
///
/// All are dense matrices, row-major, with a row for each value of the function and a column for each component of `x`; the
/// columns of the `p` parameters stand behind those.
pub trait ParameterDerivatives: Send + Sync {
    /// Of the initial coordinates and then velocities, by the parameters: `2 n_q` rows and `p` columns.
    fn start(&self, values: &mut [f64]);

    /// Of the declared length of a simulation, by the parameters: `p` numbers, 0 where none is declared.
    fn horizon(&self, values: &mut [f64]);

    /// Of [`Model::free_acceleration`](super::Model::free_acceleration).
    fn free_acceleration(&self, x: &[f64], values: &mut [f64]);

    /// Of [`Model::contact`](super::Model::contact), with rows in the layout of [`contact_point`](super::contact_point). Where
    /// the inverse inertia has no derivative its row is not a number.
    fn contact(&self, contact: usize, x: &[f64], values: &mut [f64]);

    /// Of [`Model::tangent`](super::Model::tangent), with rows in the layout of [`tangent_point`](super::tangent_point).
    fn tangent(&self, contact: usize, x: &[f64], values: &mut [f64]);

    /// Of [`Model::joints`](super::Model::joints). Only for scenes with joints.
    fn joints(&self, x: &[f64], values: &mut [f64]);

    /// Of [`Model::restitution`](super::Model::restitution), by the parameters.
    fn restitution(&self, contact: usize, values: &mut [f64]);

    /// Of [`Model::friction`](super::Model::friction), by the parameters.
    fn friction(&self, contact: usize, values: &mut [f64]);

    /// Of [`Model::reset`](super::Model::reset), of all velocities. Only for conditions that set something.
    fn reset(&self, contact: usize, x: &[f64], values: &mut [f64]);

    /// Of [`Model::output_values`](super::Model::output_values), by `(q, v, u, t)`, by the forces and impulses of `contacts`,
    /// by the forces of joints behind them, and by the parameters.
    fn outputs(&self, x: &[f64], contacts: &[f64], values: &mut [f64]);

    /// Of the running cost. Only for scenes whose costs read nothing of contacts.
    fn running_cost(&self, x: &[f64], values: &mut [f64]);

    /// Of the final cost, by `z = (q, v, T)` and by the parameters. Only for scenes whose costs read nothing of contacts.
    fn final_cost(&self, z: &[f64], values: &mut [f64]);
}
