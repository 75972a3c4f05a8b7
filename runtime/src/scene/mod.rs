//! Scenes that the language derived: one [`Model`](crate::model::Model) over a description and kernels.
//!
//! The description says what is declared, and of which kernels what solvers ask for is made: a kernel's values, the solution of a
//! linear system and its derivatives, a direction by an inertia that contacts share. Kernels are functions in a scene that
//! [`model!`](crate::model!) declares, and [programs](TextScene) in one that was read from a text. What has to know more of some
//! parameters, derivatives by them or optimal control that finds them, is derived once more from the text, which every
//! scene carries.

mod again;
mod derivatives;
mod inertia;
mod model;
mod places;
mod program;
mod ranges;
mod run;
mod solved;
mod steps;
mod system;
mod text;
mod thread;

pub use hangtime_dsl::description::{inverse_root, piecewise, root};
#[cfg(feature = "oracle")]
pub use num_dual;
pub use program::TooLarge;
pub use text::TextScene;
pub use thread::on_a_thread;

pub mod data {
    //! Types of descriptions.

    pub use hangtime_dsl::declaration::{
        ConstraintDeclaration, ContactDeclaration, ContactTerms, Declaration, Epigraph, Equation,
        Experiment, FrictionDeclaration, JointDeclaration, JointsDeclaration, Kernel,
        MeasuredQuantity, OptimalControlDeclaration, ParameterDeclaration, Picture,
        SparsityPattern, VariableDeclaration,
    };
    pub use hangtime_dsl::description::{
        Contact, FreeParameters, Friction, Given, Inertia, Joints, Motion, OptimalControl, Outputs,
        Places, Rows, SolvedRows, Structure, System, Vectors,
    };
}

pub mod variants {
    //! Values of the enumerations in descriptions.

    pub use hangtime_dsl::declaration::ImpactLaw::{Inelastic, Restitution};
    pub use hangtime_dsl::declaration::Measured::{Coordinate, Output, Velocity};
    pub use hangtime_dsl::declaration::Over::{End, Instants, Motion};
    pub use hangtime_dsl::declaration::Shape::{
        Arc, Circle, Curve, Link, Point, Polygon, Rectangle, Spring,
    };
    pub use hangtime_dsl::declaration::Switching::{Passes, Resets, Slides};
    pub use hangtime_dsl::description::MotionDerivatives::{Kernels, Solved};
    pub use hangtime_dsl::description::Solver::{Inertia, System};
}

use again::Known;
use data::Structure;
use std::borrow::Cow;

/// A scene whose functions are kernels: what [`model!`](crate::model!) implements.
pub trait Scene: Clone + Send + Sync + 'static {
    /// What it declares, and of which kernels it consists.
    fn declared(&self) -> &Declared;

    /// A number that kernels read besides their inputs: a parameter, in its unit, and behind those for each equation of a joint
    /// whether it is held, 1 or 0. Not a number where there is none.
    fn number(&self, index: usize) -> f64;

    /// Sets one of the [numbers](Self::number).
    fn set_number(&mut self, index: usize, value: f64);

    /// Evaluates a kernel at an input vector `x`, with multipliers or unknowns `y`.
    fn evaluate(&self, kernel: usize, x: &[f64], y: &[f64], out: &mut [f64]);

    /// Bounds of the first value of a kernel where its inputs lie between `low` and `high`; none where they are not known.
    fn range(&self, _kernel: usize, _low: &[f64], _high: &[f64]) -> Option<[f64; 2]> {
        None
    }

    /// The experiment whose start it has, if it is in one.
    fn experiment(&self) -> Option<usize> {
        None
    }

    /// The same scene from its text.
    ///
    /// # Errors
    /// The first mistake, or that it is too large.
    fn text_scene(&self) -> Result<TextScene, String> {
        again::derived(self, again::Again::Same, &[])
    }
}

/// A scene as it was declared.
#[derive(Debug)]
pub struct Declared {
    structure: &'static Structure,
    text: Cow<'static, str>,
    /// Derived once more, in all ways that were asked for.
    known: Known,
}

impl Declared {
    /// What follows from a text.
    #[must_use]
    pub const fn new(structure: &'static Structure, text: &'static str) -> Self {
        Self {
            structure,
            text: Cow::Borrowed(text),
            known: Known::new(),
        }
    }

    fn of_text(structure: Structure, text: &str) -> Self {
        Self {
            structure: Box::leak(Box::new(structure)),
            text: Cow::Owned(text.to_owned()),
            known: Known::new(),
        }
    }
}
