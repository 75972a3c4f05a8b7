//! Scenes that the language derived: one [`Model`] over a description and kernels.
//!
//! The description says what is declared, and of which kernels what solvers ask for is made: a kernel's values, the solution of a
//! linear system and its derivatives, a direction by an inertia that contacts share. Kernels are functions in a scene that
//! [`model!`](crate::model!) declares, and [programs](TextScene) in one that was read from a text. What has to know more of some
//! parameters, derivatives by them or optimal control that finds them, is derived once more from the text, which every
//! scene carries.

mod again;
mod derivatives;
mod functions;
mod inertia;
mod model;
mod places;
mod program;
mod run;
mod solved;
mod steps;
mod system;
pub mod tape;
mod text;
mod thread;

pub use derivatives::ParameterDerivatives;
pub use functions::{Function, Signature};
pub use hangtime_dsl::description::{inverse_root, piecewise, root};
pub use model::Model;
pub use places::{contact_point, tangent_point};
pub use program::TooLarge;
pub use text::{Declared, Shared, TextScene};
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
