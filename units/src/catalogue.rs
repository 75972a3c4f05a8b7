//! The units known by name, and the SI prefixes.

use crate::unit::Unit;

/// A named unit.
pub(crate) struct Named {
    pub(crate) symbol: &'static str,
    pub(crate) unit: Unit,
    pub(crate) prefixes: bool,
}

const fn named(symbol: &'static str, unit: Unit, scale: f64, prefixes: bool) -> Named {
    Named {
        symbol,
        unit: Unit {
            exponents: unit.exponents,
            scale,
        },
        prefixes,
    }
}

const fn base(index: usize) -> Unit {
    let mut unit = Unit::ONE;
    unit.exponents[index] = crate::Ratio::ONE;
    unit
}

const fn with_ampere(metre: i32, kilogram: i32, second: i32, ampere: i32) -> Unit {
    let mut unit = Unit::mechanical(metre, kilogram, second);
    unit.exponents[3] = crate::Ratio::integer(ampere);
    unit
}

const RADIANS_PER_DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Every named unit; scales after the SI brochure, 9th edition, tables 4 and 8.
pub(crate) const NAMED: &[Named] = &[
    named("m", base(0), 1.0, true),
    named("g", base(1), 1e-3, true),
    named("s", base(2), 1.0, true),
    named("A", base(3), 1.0, true),
    named("K", base(4), 1.0, true),
    named("mol", base(5), 1.0, true),
    named("cd", base(6), 1.0, true),
    named("N", Unit::mechanical(1, 1, -2), 1.0, true),
    named("J", Unit::mechanical(2, 1, -2), 1.0, true),
    named("W", Unit::mechanical(2, 1, -3), 1.0, true),
    named("Pa", Unit::mechanical(-1, 1, -2), 1.0, true),
    named("bar", Unit::mechanical(-1, 1, -2), 1e5, true),
    named("Hz", Unit::mechanical(0, 0, -1), 1.0, true),
    named(
        "rpm",
        Unit::mechanical(0, 0, -1),
        6.0 * RADIANS_PER_DEGREE,
        false,
    ),
    named("V", with_ampere(2, 1, -3, -1), 1.0, true),
    named("C", with_ampere(0, 0, 1, 1), 1.0, true),
    named("ohm", with_ampere(2, 1, -3, -2), 1.0, true),
    named("Ohm", with_ampere(2, 1, -3, -2), 1.0, true),
    named("S", with_ampere(-2, -1, 3, 2), 1.0, true),
    named("F", with_ampere(-2, -1, 4, 2), 1.0, true),
    named("Wb", with_ampere(2, 1, -2, -1), 1.0, true),
    named("T", with_ampere(0, 1, -2, -1), 1.0, true),
    named("H", with_ampere(2, 1, -2, -2), 1.0, true),
    named("rad", Unit::ONE, 1.0, true),
    named("deg", Unit::ONE, RADIANS_PER_DEGREE, false),
    named("rev", Unit::ONE, 360.0 * RADIANS_PER_DEGREE, false),
    named("min", Unit::mechanical(0, 0, 1), 60.0, false),
    named("h", Unit::mechanical(0, 0, 1), 3600.0, false),
    named("d", Unit::mechanical(0, 0, 1), 86_400.0, false),
    named("day", Unit::mechanical(0, 0, 1), 86_400.0, false),
    named("Wh", Unit::mechanical(2, 1, -2), 3600.0, true),
    named("Ah", with_ampere(0, 0, 1, 1), 3600.0, true),
    // The thermochemical calorie, and the international mile, pound and inch.
    named("cal", Unit::mechanical(2, 1, -2), 4.184, true),
    named("mph", Unit::mechanical(1, 0, -1), 0.44704, false),
    named(
        "psi",
        Unit::mechanical(-1, 1, -2),
        0.453_592_37 * 9.806_65 / (0.0254 * 0.0254),
        false,
    ),
    named("t", Unit::mechanical(0, 1, 0), 1000.0, false),
    named("L", Unit::mechanical(3, 0, 0), 1e-3, true),
];

const PREFIXES: [(&str, f64); 14] = [
    ("da", 1e1),
    ("T", 1e12),
    ("G", 1e9),
    ("M", 1e6),
    ("k", 1e3),
    ("h", 1e2),
    ("d", 1e-1),
    ("c", 1e-2),
    ("m", 1e-3),
    ("u", 1e-6),
    ("\u{b5}", 1e-6),
    ("n", 1e-9),
    ("p", 1e-12),
    ("f", 1e-15),
];

/// The unit with this symbol, with or without a prefix.
pub(crate) fn lookup(symbol: &str) -> Option<Unit> {
    if symbol == "kg" {
        return Some(base(1)); // exactly, not 1000 * 0.001
    }
    if let Some(named) = NAMED.iter().find(|named| named.symbol == symbol) {
        return Some(named.unit);
    }
    PREFIXES.iter().find_map(|&(prefix, scale)| {
        let rest = symbol.strip_prefix(prefix)?;
        let named = NAMED
            .iter()
            .find(|named| named.prefixes && named.symbol == rest)?;
        Some(Unit {
            exponents: named.unit.exponents,
            scale: scale * named.unit.scale,
        })
    })
}

/// A unit that a misspelt symbol may have meant.
pub(crate) fn suggest(symbol: &str) -> Option<&'static str> {
    const WORDS: &[(&[&str], &str)] = &[
        (&["sec", "second", "seconds"], "s"),
        (&["meter", "metre", "meters", "metres"], "m"),
        (&["newton"], "N"),
        (&["joule"], "J"),
        (&["watt"], "W"),
        (&["hour", "hr"], "h"),
        (&["kph", "kmh"], "km/h"),
        (&["mps"], "m/s"),
        (&["degree", "degrees"], "deg"),
        (&["radian", "radians"], "rad"),
        (&["gram"], "g"),
        (&["Kg", "KG"], "kg"),
        (&["Nm"], "N m"),
        (&["hz"], "Hz"),
        (&["liter", "l"], "L"),
        (&["ton"], "t"),
    ];
    let mut meant = WORDS.iter();
    if let Some(&(_, unit)) = meant.find(|(words, _)| words.contains(&symbol)) {
        return Some(unit);
    }
    NAMED
        .iter()
        .map(|named| named.symbol)
        .find(|name| name.eq_ignore_ascii_case(symbol))
}
