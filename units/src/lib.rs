//! Physical units: seven SI base exponents, a scale, and a parser for what people write.
