//! Names: what is declared, what may not be, what is taken.

use super::Checker;
use crate::ast::{Name, Quantity, Statement};
use crate::diagnostics::{Checked, Reported};
use crate::evaluate::{Meaning, Value};
use crate::graph::{Compose, Sym, Variable};
use crate::scene::{self, Coordinate, Parameter};
use crate::words;

/// Most coordinates, and most parameters or controls, of one scene.
const MOST: usize = 500;

impl Checker<'_> {
    /// Declares parameters, coordinates and controls, wherever they stand; notes the names of
    /// abbreviations and functions that come later.
    pub(super) fn declare_all(&mut self, statements: &[Statement]) {
        for statement in statements {
            match statement {
                Statement::Parameters(quantities) => {
                    self.declare(quantities, |checker, quantity| checker.parameter(quantity));
                }
                Statement::Coordinates(quantities) => {
                    self.declare(quantities, |checker, quantity| {
                        checker.coordinate(quantity, false)
                    });
                }
                Statement::Controls(quantities) => {
                    self.declare(quantities, |checker, quantity| {
                        checker.coordinate(quantity, true)
                    });
                }
                Statement::Let { name, .. } | Statement::Function { name, .. } => {
                    self.scope.later.insert(name.text.clone());
                }
                _ => {}
            }
        }
    }

    fn declare(
        &mut self,
        quantities: &[Quantity],
        one: impl Fn(&mut Self, &Quantity) -> Checked<()>,
    ) {
        for quantity in quantities {
            // Reported where it fails; the others are declared all the same.
            if one(self, quantity).is_err() {
                self.diagnostics.poison(&quantity.name.text);
            }
        }
    }

    /// Whether a name may be declared.
    pub(super) fn new_name(&mut self, name: &Name, what: &str) -> Checked<()> {
        let text = name.text.as_str();
        let place = name.place();
        if self.scope.names.contains_key(text) {
            return Err(self.diagnostics.report(
                "E19",
                place,
                format!("`{text}` is declared twice; rename this {what}"),
            ));
        }
        if words::RESERVED.contains(&text) {
            let meaning = match text {
                "t" | "time" => "the physical time",
                "pi" => "the number pi",
                _ => "the clock of the time-freezing reformulation",
            };
            return Err(self.diagnostics.report(
                "E11",
                place,
                format!("`{text}` is reserved for {meaning}; choose another name"),
            ));
        }
        if words::is_rust_word(text) {
            return Err(self.diagnostics.report(
                "E11",
                place,
                format!("`{text}` is a word of Rust and cannot be a field; choose another name"),
            ));
        }
        if text.starts_with("__") || text == "_" {
            return Err(self.diagnostics.report(
                "E11",
                place,
                format!("`{text}`: names that begin with `__` are reserved; choose another name"),
            ));
        }
        if words::FUNCTIONS.contains(&text)
            || words::SPECIAL_FUNCTIONS.contains(&text)
            || words::NONSMOOTH.contains(&text)
            || text == words::INTEGRAL
        {
            return Err(self.diagnostics.report(
                "E19",
                place,
                format!("`{text}` is the name of a function; choose another name"),
            ));
        }
        Ok(())
    }

    fn parameter(&mut self, quantity: &Quantity) -> Checked<()> {
        let name = &quantity.name;
        self.new_name(name, "parameter")?;
        self.room(name, self.parameters.len())?;
        // Declared even if its value is missing or wrong, so that its uses give no second message.
        let index = self.parameters.len() as u16;
        let unit = quantity.unit.clone();
        let sym = Sym::variable(Variable::Parameter(index)).scaled(scene::scale(unit.as_ref()));
        self.declare_value(name, sym);
        let default = match &quantity.value {
            Some(value) => self.default_value(name, value, unit.as_ref()),
            None => {
                let shown = unit.as_ref().map_or("", |unit| unit.text.as_str());
                let colon = if shown.is_empty() { "" } else { ": " };
                Err(self.diagnostics.syntax(
                    name.place(),
                    format!(
                        "parameter `{0}` needs a default value, as in `{0}{colon}{shown} = 1`",
                        name.text
                    ),
                ))
            }
        };
        if let Some((lower, _)) = &quantity.bounds {
            self.diagnostics.syntax(
                lower.place,
                format!(
                    "bounds belong to coordinates and controls; parameter `{}` has none",
                    name.text
                ),
            );
        }
        self.parameters.push(Parameter {
            name: name.clone(),
            unit,
            documentation: quantity.documentation.clone(),
            default: default.unwrap_or(f64::NAN),
        });
        Ok(())
    }

    fn coordinate(&mut self, quantity: &Quantity, control: bool) -> Checked<()> {
        let name = &quantity.name;
        let what = if control { "control" } else { "coordinate" };
        self.new_name(name, what)?;
        let known = if control {
            &self.controls
        } else {
            &self.coordinates
        };
        let index = known.len();
        self.room(name, index)?;
        if let Some(value) = &quantity.value {
            self.diagnostics.syntax(
                value.place,
                if control {
                    format!(
                        "control `{}` has no value of its own; leave `= ...` out",
                        name.text
                    )
                } else {
                    format!(
                        "initial values belong to `start {{ {}: ... }}`; leave `= ...` out",
                        name.text
                    )
                },
            );
        }
        let unit = quantity.unit.clone();
        let variable = if control {
            Variable::Control(index as u16)
        } else {
            Variable::Coordinate(index as u16)
        };
        let sym = Sym::variable(variable).scaled(scene::scale(unit.as_ref()));
        self.declare_value(name, sym);
        let declared = Coordinate {
            name: name.clone(),
            unit,
            documentation: quantity.documentation.clone(),
            bounds: None,
        };
        if control {
            self.controls.push(declared);
        } else {
            self.coordinates.push(declared);
        }
        Ok(())
    }

    fn room(&mut self, name: &Name, taken: usize) -> Checked<()> {
        if taken < MOST {
            return Ok(());
        }
        let error: Reported = self.diagnostics.syntax(
            name.place(),
            format!("a scene has at most {MOST} quantities of one kind"),
        );
        Err(error)
    }

    fn declare_value(&mut self, name: &Name, sym: Sym) {
        self.scope
            .names
            .insert(name.text.clone(), Meaning::Value(Value::Scalar(sym)));
    }
}
