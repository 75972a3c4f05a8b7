//! What a scene declares, as static data like that of a compiled one.

use hangtime::model::{
    ConstraintDeclaration, ContactDeclaration, ContactTerms, Declaration, Equation, Experiment,
    FrictionDeclaration, Given, Held, ImpactLaw, JointDeclaration, JointsDeclaration, Kernel,
    Measured, MeasuredQuantity, OptimalControlDeclaration, ParameterDeclaration, Picture, Shape,
    SparsityPattern, Switching, VariableDeclaration,
};
use hangtime_dsl::description::{
    self, Condition, Contact, Description, Joints, OptimalControl, Outputs, Pattern, Rows, Variable,
};

/// The declaration of a described scene. It is never freed: solvers and results keep names of it.
pub(crate) fn of(scene: &Description) -> &'static Declaration {
    let parameters = scene.parameters.iter().map(|known| ParameterDeclaration {
        name: text(&known.name),
        unit: text(&known.unit),
        default: known.default,
        positive: known.positive,
        documentation: text(&known.documentation),
    });
    let kernels = scene.listed().map(|kernel| Kernel {
        name: text(&kernel.name),
        operations: kernel.cost(),
        outputs: kernel.outputs.len(),
    });
    let equations = scene.equations.iter().map(|[left, right]| Equation {
        left: text(left),
        right: text(right),
    });
    Box::leak(Box::new(Declaration {
        name: text(&scene.name),
        documentation: text(&scene.documentation),
        parameters: list(parameters),
        coordinates: list(scene.coordinates.iter().map(variable)),
        controls: list(scene.controls.iter().map(variable)),
        states: list(scene.states.iter().map(variable)),
        contacts: list(scene.contacts.iter().map(contact)),
        joints: scene.joints.as_ref().map(joints),
        explicit_time: scene.explicit_time,
        free_jacobian: pattern(&scene.motion.jacobian),
        free_hessian: pattern(&scene.motion.hessian),
        optimal_control: scene.optimal_control.as_ref().map(optimal_control),
        kernels: list(kernels),
        equations: list(equations),
    }))
}

/// What a described scene records.
pub(crate) fn outputs(outputs: Option<&Outputs>) -> &'static [VariableDeclaration] {
    let outputs = outputs.into_iter().flat_map(|known| &known.quantities);
    list(outputs.map(variable))
}

/// How a described scene is drawn.
pub(crate) fn picture(picture: &description::Picture) -> Picture {
    use description::Shape as Described;
    Picture {
        unit: text(&picture.unit),
        axes: [0, 1].map(|axis| text(&picture.axes[axis])),
        ground: picture.ground,
        shapes: list(picture.shapes.iter().map(|shape| match shape {
            Described::Point(name) => Shape::Point(text(name)),
            Described::Circle(name) => Shape::Circle(text(name)),
            Described::Rectangle(name) => Shape::Rectangle(text(name)),
            Described::Polygon(name, corners) => Shape::Polygon(text(name), *corners),
            Described::Link => Shape::Link,
            Described::Spring => Shape::Spring,
            Described::Curve(name) => Shape::Curve(text(name)),
            Described::Arc(name) => Shape::Arc(text(name)),
        })),
    }
}

/// The parameters of a described scene that are to be found.
pub(crate) fn free_parameters(scene: &Description) -> &'static [usize] {
    let free = scene.free_parameters.iter();
    list(free.flat_map(|free| free.parameters.iter().copied()))
}

/// The measured motions that a described scene compares with.
pub(crate) fn experiments(scene: &Description) -> &'static [Experiment] {
    use description::Measured as Described;
    list(scene.experiments.iter().map(|known| Experiment {
        name: text(&known.name),
        documentation: text(&known.documentation),
        file: text(&known.file),
        quantities: list(known.quantities.iter().map(|quantity| MeasuredQuantity {
            name: text(&quantity.name),
            unit: text(&quantity.unit),
            measured: match quantity.measured {
                Described::Coordinate(k) => Measured::Coordinate(k),
                Described::Velocity(k) => Measured::Velocity(k),
                Described::Output(k) => Measured::Output(k),
            },
            within: quantity.within,
        })),
        huber: known.huber,
        own_start: known.start.is_some(),
    }))
}

/// What functions of optimal control remember of a start that is to be found.
pub(crate) fn remembered(scene: &Description) -> &'static [usize] {
    list(scene.remembered.iter().copied())
}

/// The parameters of a described scene that are coordinates without motion.
pub(crate) fn held(held: &description::Held) -> Held {
    use description::GivenBy;
    Held {
        parameters: list(held.parameters.iter().copied()),
        starts: list(held.starts.iter().copied()),
        given: list(held.given.iter().map(|given| match *given {
            GivenBy::Start(k) => Given::Start(k),
            GivenBy::Horizon => Given::Horizon,
            GivenBy::Restitution(contact) => Given::Restitution(contact),
            GivenBy::Friction(contact) => Given::Friction(contact),
        })),
        jacobian: pattern(&held.functions.jacobian),
        hessian: pattern(&held.functions.hessian),
    }
}

fn text(text: &str) -> &'static str {
    text.to_owned().leak()
}

fn list<T>(items: impl Iterator<Item = T>) -> &'static [T] {
    items.collect::<Vec<T>>().leak()
}

fn pattern(pattern: &Pattern) -> SparsityPattern {
    let entries = pattern.entries.iter();
    SparsityPattern {
        rows: pattern.rows,
        columns: pattern.columns,
        entries: list(entries.map(|&(row, column)| (row as u32, column as u32))),
    }
}

fn variable(variable: &Variable) -> VariableDeclaration {
    VariableDeclaration {
        name: text(&variable.name),
        unit: text(&variable.unit),
        documentation: text(&variable.documentation),
    }
}

fn contact(contact: &Contact) -> ContactDeclaration {
    let patterns = |rows: &Rows| [pattern(&rows.jacobian), pattern(&rows.hessian)];
    let [jacobian, hessian] = patterns(&contact.rows);
    let friction = contact.friction.as_ref().map(|friction| {
        let [jacobian, hessian] = patterns(&friction.rows);
        FrictionDeclaration {
            jacobian,
            hessian,
            kinetic: friction.kinetic.is_some(),
            share: friction.share.is_some(),
            across: friction
                .across
                .as_ref()
                .map(|(_, rows)| pattern(&rows.jacobian)),
        }
    });
    ContactDeclaration {
        name: text(&contact.name),
        unit: text(&contact.unit),
        law: match contact.restitution {
            Some(_) => ImpactLaw::Restitution,
            None => ImpactLaw::Inelastic,
        },
        friction,
        dry: contact.dry,
        loads: list(
            contact
                .loads
                .iter()
                .flat_map(|(surfaces, _)| surfaces.iter().copied()),
        ),
        switch: contact.switch.map(|passes| match passes {
            _ if contact.reset.is_some() => Switching::Resets,
            true => Switching::Passes,
            false => Switching::Slides,
        }),
        custom_direction: contact.custom_direction,
        held: list(contact.held.iter().copied()),
        sequence: contact.sequence,
        alternatives: list(contact.alternatives.iter().copied()),
        jacobian,
        hessian,
        documentation: text(&contact.documentation),
    }
}

fn joints(joints: &Joints) -> JointsDeclaration {
    JointsDeclaration {
        list: list(joints.list.iter().map(|joint| JointDeclaration {
            name: text(&joint.name),
            unit: text(&joint.unit),
            rows: joint.rows,
            holonomic: joint.holonomic,
            documentation: text(&joint.documentation),
        })),
        jacobian: pattern(&joints.pattern),
        hessian: pattern(&joints.hessian_pattern),
    }
}

fn optimal_control(task: &OptimalControl) -> OptimalControlDeclaration {
    let conditions = |conditions: &[Condition]| {
        list(conditions.iter().map(|condition| ConstraintDeclaration {
            name: text(&condition.name),
            unit: text(&condition.unit),
            equality: condition.equality,
            documentation: text(&condition.documentation),
        }))
    };
    OptimalControlDeclaration {
        running_cost: task.running_cost,
        final_cost: task.final_cost,
        constraints: conditions(&task.constraints),
        goals: conditions(&task.goals),
        free_time: task.free_time,
        free_start: list(task.free_start.iter().copied()),
        path_jacobian: pattern(&task.path.jacobian),
        path_hessian: pattern(&task.path.hessian),
        terminal_jacobian: pattern(&task.terminal.jacobian),
        terminal_hessian: pattern(&task.terminal.hessian),
        contacts: ContactTerms {
            path: task.contacts.path,
            terminal: task.contacts.terminal,
            sums: task.contacts.sums,
            constraints: conditions(&task.contacts.constraints),
            impact_jacobian: pattern(&task.contacts.impact.jacobian),
            impact_hessian: pattern(&task.contacts.impact.hessian),
        },
    }
}
