//! Physical units: seven SI base exponents, a scale, and a parser for what people write.
//!
//! ```
//! use hangtime_units::{Quantity, Unit, convert};
//!
//! let force: Unit = "kg m/s^2".parse()?;
//! assert_eq!(force.to_string(), "N");
//! assert_eq!(force, "N".parse()?);
//!
//! let speed = Quantity::parse("18km/h")?;
//! assert_eq!(speed.unit, Some("km/h"));
//! assert!((convert(speed.value, "km/h", "m/s")? - 5.0).abs() < 1e-15);
//! # Ok::<(), hangtime_units::UnitError>(())
//! ```
//!
//! Angles are dimensionless: `rad` is 1 and `deg` is pi/180.

mod catalogue;
mod convert;
mod error;
mod parse;
mod print;
mod ratio;
mod unit;

pub use convert::{Quantity, convert};
pub use error::UnitError;
pub use ratio::Ratio;
pub use unit::{BASES, Unit};
