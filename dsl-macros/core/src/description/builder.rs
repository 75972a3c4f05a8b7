//! Collects kernels and linear systems.

use super::kernel::Kernel;
use super::renamed::Renamed;
use crate::declaration::{SparsityPattern, list};
use crate::derive::{Columns, Implicit, Names, SharedInertia, Sparse, WRITTEN_OUT};
use crate::graph::Sym;
use crate::scene::CheckedScene;
use crate::tape;

/// Positions of nonzeros: row, column.
pub type Places = &'static [(u32, u32)];

/// A linear system `K(x) y = b(x)` and what the derivatives of its solution need; `F(x, y) = K y - b`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct System {
    /// Order of `K`.
    pub size: usize,
    /// Kernel of `K`, row-major, and then `b`.
    pub solve: usize,
    /// Kernel and pattern of `F_x`, of `(x, y)` with the solution behind as many other weights.
    pub jacobian: (usize, Places),
    /// Kernel and pattern of `(mu' F)_xx` (lower triangle), with `mu` and then the solution as weights.
    pub hessian: (usize, Places),
    /// Kernel and pattern of `P = d(K' mu)/dx`, with `mu` and then the solution as weights.
    pub cross: (usize, Places),
}

/// The inertia `K(x)` that directions of several contacts are solved for with: the mass matrix, bordered by joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// Order of `K`.
    pub size: usize,
    /// For each row of the lower triangle, the first column that elimination in this order may fill.
    pub envelope: &'static [usize],
    /// Kernel of `K`, row-major.
    pub matrix: usize,
    /// Kernel and pattern of `d(K y)/dx`, with `y` as weights.
    pub product: (usize, Places),
    /// Kernel and pattern of `(mu' K y)_xx` (lower triangle), with `mu` and then `y` as weights.
    pub curvature: (usize, Places),
}

/// The vectors `c_k` by which a direction is solved for with the [`Inertia`] of the scene: `K y_k = c_k r`, and if they are
/// bordered, `n' y_m = 1` with the last of them, the normal `n`; `r = 1` otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vectors {
    /// Number of vectors.
    pub count: usize,
    /// Whether the last one is the normal that scales all.
    pub bordered: bool,
    /// Kernel of all components, of one vector after the other.
    pub values: usize,
    /// Kernel and pattern of their derivatives.
    pub jacobian: (usize, Places),
    /// Kernel and pattern of the second derivatives (lower triangle) of their sum weighted by as many weights.
    pub hessian: (usize, Places),
}

/// Positions that live as long as the program.
pub(super) fn places(entries: &[(usize, usize)]) -> Places {
    list(
        entries
            .iter()
            .map(|&(row, column)| (row as u32, column as u32)),
    )
}

/// The pattern of a sparse matrix.
pub(super) fn pattern(sparse: &Sparse) -> SparsityPattern {
    SparsityPattern {
        rows: sparse.rows,
        columns: sparse.columns,
        entries: places(&sparse.entries),
    }
}

pub(super) struct Builder<'a> {
    pub(super) scene: &'a CheckedScene,
    pub(super) inputs: usize,
    /// Whether kernels from now on read `(q, v, T)` with the final time `T` and what follows it instead of the input
    /// vector.
    pub(super) at_the_end: bool,
    pub(super) renamed: Renamed,
    pub(super) kernels: Vec<Kernel>,
    pub(super) systems: Vec<System>,
    pub(super) inertia: Option<&'a SharedInertia>,
    /// Kernels of the motion that the inertia may consist of, and what they compute.
    of_motion: Vec<(Vec<Sym>, usize)>,
}

impl<'a> Builder<'a> {
    /// Without kernels.
    pub(super) fn new(
        scene: &'a CheckedScene,
        inputs: usize,
        inertia: Option<&'a SharedInertia>,
    ) -> Self {
        Self {
            scene,
            inputs,
            at_the_end: false,
            renamed: Renamed::default(),
            kernels: Vec::new(),
            systems: Vec::new(),
            inertia,
            of_motion: Vec::new(),
        }
    }

    /// Adds a kernel of the motion that the inertia may use as well; its index.
    pub(super) fn of_motion(&mut self, name: &str, outputs: &[Sym]) -> usize {
        let kernel = self.kernel(name, outputs);
        self.of_motion.push((outputs.to_vec(), kernel));
        kernel
    }

    /// The kernel of the motion that computes the same, or a new one.
    fn of_motion_or_new(&mut self, name: &str, outputs: &[Sym]) -> usize {
        let mut known = self.of_motion.iter();
        match known.find(|(values, _)| values == outputs) {
            Some(&(_, kernel)) => kernel,
            None => self.kernel(name, outputs),
        }
    }

    /// Number of switches whose kernels have been added.
    pub(super) fn switches(&self) -> usize {
        let of_switch = |kernel: &&Kernel| kernel.name.starts_with("gap_switching_function_");
        self.kernels.iter().filter(of_switch).count()
    }

    /// Adds a kernel; its index.
    pub(super) fn kernel(&mut self, name: &str, outputs: &[Sym]) -> usize {
        self.add(name, outputs, true)
    }

    /// Adds a kernel of the parameters alone; its index.
    pub(super) fn unlisted(&mut self, name: &str, outputs: &[Sym]) -> usize {
        self.add(name, outputs, false)
    }

    /// Adds kernels of lower and upper bounds, infinite where none is declared; their indices.
    pub(super) fn bounds(
        &mut self,
        [lower, upper]: [&str; 2],
        bounds: impl Iterator<Item = Option<(Sym, Sym)>>,
    ) -> (usize, usize) {
        let open = [f64::NEG_INFINITY, f64::INFINITY].map(Sym::number);
        let bounds = bounds.map(|bounds| bounds.unwrap_or(open.into()));
        let (low, high): (Vec<Sym>, Vec<Sym>) = bounds.unzip();
        (self.unlisted(lower, &low), self.unlisted(upper, &high))
    }

    fn add(&mut self, name: &str, outputs: &[Sym], listed: bool) -> usize {
        let tape = if self.scene.coordinates.len() > WRITTEN_OUT {
            self.renamed.shortest(outputs)
        } else {
            tape::shortest(outputs)
        };
        let kernel = Kernel::new(self.scene, name, tape, (listed, self.at_the_end));
        self.kernels.push(kernel);
        self.kernels.len() - 1
    }

    /// Adds a kernel that is like another one with other names of coordinates, those of inputs, and of weights behind the first `rows`;
    /// its index.
    pub(super) fn like(&mut self, kernel: usize, name: &str, names: (&Names, usize)) -> usize {
        let kernel = self.kernels[kernel].renamed(kernel, name, names);
        self.kernels.push(kernel);
        self.kernels.len() - 1
    }

    /// The same of a kernel with some values followed by vectors of the coordinates.
    pub(super) fn like_vectors(
        &mut self,
        kernel: usize,
        name: &str,
        first: usize,
        names: &Names,
    ) -> usize {
        let index = self.like(kernel, name, (names, first));
        self.kernels[index].outputs = names.spread(&self.kernels[kernel].outputs, first);
        index
    }

    fn nonzeros(&mut self, name: &str, sparse: &Sparse) -> (usize, Places) {
        (self.kernel(name, &sparse.values), places(&sparse.entries))
    }

    /// Adds the inertia that contacts share, if there is one.
    pub(super) fn inertia(&mut self) -> Option<Inertia> {
        let shared = self.inertia?;
        Some(Inertia {
            size: shared.size,
            envelope: list(shared.envelope()),
            matrix: self.of_motion_or_new("inertia", &shared.matrix),
            product: (
                self.of_motion_or_new("inertia_product", &shared.product.values),
                places(&shared.product.entries),
            ),
            curvature: self.nonzeros("inertia_curvature", &shared.curvature),
        })
    }

    /// Adds the vectors of a direction.
    pub(super) fn vectors(&mut self, name: &str, columns: &Columns) -> Vectors {
        Vectors {
            count: columns.count,
            bordered: columns.bordered,
            values: self.kernel(&format!("{name}_vectors"), &columns.values),
            jacobian: self.nonzeros(&format!("{name}_jacobian"), &columns.jacobian),
            hessian: self.nonzeros(&format!("{name}_hessian"), &columns.hessian),
        }
    }

    /// Adds a linear system and what the derivatives of its solution need; its index.
    pub(super) fn system(&mut self, name: &str, implicit: &Implicit) -> usize {
        let mut system = implicit.matrix.clone();
        system.extend(&implicit.right);
        let solve = self.kernel(&format!("{name}_system"), &system);
        let mut part = |suffix: &str, sparse: &Sparse| {
            let kernel = self.of_motion(&format!("{name}_{suffix}"), &sparse.values);
            (kernel, places(&sparse.entries))
        };
        let system = System {
            size: implicit.size,
            solve,
            jacobian: part("jacobian", &implicit.residual_jacobian),
            hessian: part("hessian", &implicit.residual_hessian),
            cross: part("cross", &implicit.cross),
        };
        self.systems.push(system);
        self.systems.len() - 1
    }
}
