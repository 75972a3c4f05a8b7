//! Directions that are solved for with the inertia of a scene, by the operations of compiled scenes.

use hangtime::__private::{self as private, Columns, Inertia, Nonzeros};
use hangtime_dsl::description::{self, Vectors};

/// Evaluates a kernel at an input, with weights, into values.
type Evaluate<'a> = dyn Fn(usize, &[f64], &[f64], &mut [f64]) + 'a;

/// A direction at one point.
pub(crate) struct Direction<'a> {
    /// The inertia of the scene.
    pub(crate) shared: &'a description::Inertia,
    /// Number of columns of derivatives.
    pub(crate) inputs: usize,
    /// Evaluates a kernel.
    pub(crate) evaluate: &'a Evaluate<'a>,
    pub(crate) vectors: &'a Vectors,
    pub(crate) x: &'a [f64],
}

impl Direction<'_> {
    /// Lends the inertia and the vectors.
    fn with<T>(&self, work: impl FnOnce(&Inertia<'_>, &Columns<'_>) -> T) -> T {
        let (shared, evaluate) = (self.shared, self.evaluate);
        let kernel = |kernel: usize| {
            move |x: &[f64], y: &[f64], out: &mut [f64]| evaluate(kernel, x, y, out)
        };
        let (matrix, product) = (kernel(shared.matrix), kernel(shared.product.0));
        let curvature = kernel(shared.curvature.0);
        let own = self.vectors;
        let (values, jacobian) = (kernel(own.values), kernel(own.jacobian.0));
        let hessian = kernel(own.hessian.0);
        let inertia = Inertia {
            envelope: &shared.envelope,
            matrix: &matrix,
            product: Nonzeros {
                kernel: &product,
                places: &shared.product.1,
            },
            curvature: Nonzeros {
                kernel: &curvature,
                places: &shared.curvature.1,
            },
            inputs: self.inputs,
        };
        let columns = Columns {
            count: own.count,
            bordered: own.bordered,
            values: &values,
            jacobian: Nonzeros {
                kernel: &jacobian,
                places: &own.jacobian.1,
            },
            hessian: Nonzeros {
                kernel: &hessian,
                places: &own.hessian.1,
            },
        };
        work(&inertia, &columns)
    }

    /// Writes the direction; the inverse inertia along its normal.
    pub(crate) fn value(&self, direction: &mut [f64]) -> f64 {
        self.with(|inertia, columns| private::direction(inertia, columns, self.x, direction))
    }

    /// Derivatives at some places, from whose rows `above` is subtracted.
    pub(crate) fn jacobian(&self, places: (&[(usize, usize)], usize), out: &mut [f64]) {
        self.with(|inertia, columns| {
            private::direction_jacobian(inertia, columns, self.x, places, out);
        });
    }

    /// Second derivatives of the weighted direction at some places.
    pub(crate) fn hessian(&self, weights: &[f64], places: &[(usize, usize)], out: &mut [f64]) {
        self.with(|inertia, columns| {
            private::direction_hessian(inertia, columns, (self.x, weights), places, out);
        });
    }
}
