//! The front door: [`simulate`](simulate::simulate) and [`solve`](solve::solve) with everything that is not said left
//! to the declaration of the scene.

pub(crate) mod simulate;
pub(crate) mod solve;

use crate::model::Declaration;
use crate::simulation::{InputError, Quantity};

/// Initial values that replace declared ones, by name.
#[derive(Debug, Clone, Default)]
struct StartValues(Vec<(String, f64)>);

impl StartValues {
    fn set(&mut self, name: &str, value: f64) {
        self.0.push((name.to_owned(), value));
    }

    /// Puts the values into the start `(q, v)`.
    fn write(
        &self,
        declaration: &'static Declaration,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), InputError> {
        for (name, value) in &self.0 {
            match Quantity::named(declaration, &[], name) {
                Some(Quantity::Coordinate(k)) => q[k] = *value,
                Some(Quantity::Velocity(k)) => v[k] = *value,
                _ => {
                    let known = declaration.coordinates[..declaration.mechanical()].iter();
                    let known = known.map(|c| format!("{0}, dot({0})", c.name));
                    let states = declaration.states.iter().map(|known| known.name.to_owned());
                    let known = known.chain(states);
                    return Err(InputError::new(format!(
                        "the start of `{}` has no `{name}`; it has {}",
                        declaration.name,
                        known.collect::<Vec<_>>().join(", ")
                    )));
                }
            }
        }
        Ok(())
    }
}
