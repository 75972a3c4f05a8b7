//! The colours of all figures, in one table: a method has the same one wherever it is drawn.

/// Colours of lines on light and on dark pages. The first [`OWN`] are for methods of this library: those of Okabe and Ito, moved
/// apart until any two differ for normal and for colour-blind eyes. The others are for other programs, whose lines are
/// dashed as well: found by a search over the colours that differ from the page and from all before them.
pub(super) const LINES: [(&str, &str); 12] = [
    ("#009bdc", "#4e7cff"),
    ("#e86b00", "#ec713b"),
    ("#007b42", "#06f99c"),
    ("#952788", "#c873c2"),
    ("#1f2430", "#ffdbf6"),
    ("#8a0000", "#b3f81b"),
    ("#8f9495", "#7d7b6c"),
    ("#ff005a", "#ffd269"),
    ("#c32dff", "#b400b4"),
    ("#1e00ff", "#782dff"),
    ("#000f5a", "#3cc3a5"),
    ("#0000a5", "#008700"),
];
/// How many of them are for methods of this library.
const OWN: usize = 7;

/// The methods and their colours. A name that begins with one of these is a variant of that method, in the same colour
/// with another mark.
const METHODS: [(&str, usize); 14] = [
    ("finite elements", 0),
    ("Radau", 0),
    ("Gauss", 0),
    ("phases", 0),
    ("fixed steps", 1),
    ("Moreau-Jean", 2),
    ("smoothed", 3),
    ("time-freezing", 4),
    ("event-driven", 6),
    ("scipy DOP853", 7),
    ("scipy Radau", 8),
    ("nosnoc", 9),
    ("Siconos", 10),
    ("MuJoCo", 11),
];

/// How a line of a chart looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Look {
    /// Index into the colours of lines.
    pub(crate) colour: usize,
    /// Dashed with open marks, instead of solid.
    pub(crate) dashed: bool,
    /// Which mark its points have: variants of one method differ in it.
    pub(crate) mark: usize,
}

impl Look {
    /// That of the method with this name; other programs are dashed. A name that nobody has listed is grey.
    pub(crate) fn of(method: &str) -> Self {
        let listed = METHODS.iter().find(|(name, _)| method.starts_with(name));
        let colour = listed.map_or(OWN - 1, |&(_, colour)| colour);
        Self {
            colour,
            dashed: colour >= OWN,
            mark: colour,
        }
    }

    /// This look with the mark of a variant.
    pub(crate) fn variant(self, mark: usize) -> Self {
        Self { mark, ..self }
    }

    /// This look, dashed.
    pub(crate) fn dashed(self) -> Self {
        Self {
            dashed: true,
            ..self
        }
    }
}

/// Colours of bodies and quantities, with enough contrast on white and on near-black.
pub(crate) const COLOURS: [&str; 9] = [
    "#2f7ed8", "#d9601a", "#2a9d5c", "#9a63d8", "#d6409f", "#0e9aa7", "#a67c2d", "#7c8594",
    "#c2483d",
];
/// Ground and reference lines.
pub(crate) const GREY: &str = "#8a919e";

/// Colours of a chart of this class that is opened by itself or shown on a page.
pub(super) fn style(class: &str) -> String {
    let colours = |dark: bool| -> String {
        let lines = LINES.iter().enumerate();
        lines
            .map(|(index, (light, on_dark))| {
                format!(
                    ".{class} .k{index}{{color:{}}}",
                    if dark { on_dark } else { light }
                )
            })
            .collect()
    };
    format!(
        "<style>.{class}{{color:#1f2430;background:#ffffff}}.{class} .open{{fill:#ffffff}}\
         .{class} .grid{{stroke:#8a919e;stroke-opacity:.35;fill:none}}.{class} .half{{fill:none}}\
         .{class} .leader{{stroke:currentColor;stroke-dasharray:1 4;fill:none}}.{class} .axis{{stroke:currentColor;fill:none}}\
         .{class} .shade{{fill:#8a919e;fill-opacity:.2}}{}@media screen and (prefers-color-scheme:dark){{\
         .{class}{{color:#dfe3ea;background:#14171c}}.{class} .open{{fill:#14171c}}{}}}</style>",
        colours(false),
        colours(true)
    )
}

#[cfg(test)]
mod tests {
    use super::{LINES, Look, METHODS, OWN};

    #[test]
    fn methods_have_a_colour_each_and_other_programs_are_dashed() {
        let own = METHODS.iter().filter(|(_, colour)| *colour < OWN);
        let others = METHODS.iter().filter(|(_, colour)| *colour >= OWN);
        for (name, _) in own {
            assert!(!Look::of(name).dashed, "{name}");
        }
        for (name, colour) in others {
            assert!(Look::of(name).dashed, "{name}");
            // No two programs share one.
            let alike = METHODS.iter().filter(|(_, other)| other == colour);
            assert_eq!(alike.count(), 1, "{name}");
        }
        let same = |a: &str, b: &str| Look::of(a).colour == Look::of(b).colour;
        assert!(same("nosnoc", "nosnoc, stored 2026-11-21"));
        assert!(same("Radau-3", "finite elements (default)"));
        assert!(!same("time-freezing Radau-3", "Radau-3"));
    }

    /// Red, green and blue of light, from a colour as in CSS.
    fn linear(colour: &str) -> [f64; 3] {
        [1, 3, 5].map(|at| {
            let share = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
            if share <= 0.04045 {
                share / 12.92
            } else {
                ((share + 0.055) / 1.055).powf(2.4)
            }
        })
    }

    fn product(matrix: [[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum::<f64>())
    }

    /// Lightness and two opponent colours (CIE 1976 L*a*b*).
    fn lab(light: [f64; 3]) -> [f64; 3] {
        let xyz = product(
            [
                [0.4124, 0.3576, 0.1805],
                [0.2126, 0.7152, 0.0722],
                [0.0193, 0.1192, 0.9505],
            ],
            light,
        );
        let white = [0.9505, 1.0, 1.089];
        let f = |i: usize| {
            let share = (xyz[i] / white[i]).max(0.0);
            if share > 0.008_856 {
                share.cbrt()
            } else {
                7.787 * share + 16.0 / 116.0
            }
        };
        [
            116.0 * f(1) - 16.0,
            500.0 * (f(0) - f(1)),
            200.0 * (f(1) - f(2)),
        ]
    }

    #[test]
    fn colours_stay_apart_for_colour_blind_eyes_and_from_the_page() {
        // Machado, Oliveira, Fernandes (2009), severity 1: protanopia, deuteranopia, tritanopia; and normal sight.
        let eyes = [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [
                [0.152_286, 1.052_583, -0.204_868],
                [0.114_503, 0.786_281, 0.099_216],
                [-0.003_882, -0.048_116, 1.051_998],
            ],
            [
                [0.367_322, 0.860_646, -0.227_968],
                [0.280_085, 0.672_501, 0.047_413],
                [-0.011_820, 0.042_940, 0.968_881],
            ],
            [
                [1.255_528, -0.076_749, -0.178_779],
                [-0.078_411, 0.930_809, 0.147_602],
                [0.004_733, 0.691_367, 0.303_900],
            ],
        ];
        let luminance = |colour: &str| {
            let [r, g, b] = linear(colour);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for (page, colours) in [
            ("#ffffff", LINES.map(|line| line.0)),
            ("#14171c", LINES.map(|line| line.1)),
        ] {
            for (index, one) in colours.iter().enumerate() {
                let (a, b) = (luminance(page) + 0.05, luminance(one) + 0.05);
                // WCAG 2.1 asks for 3 between graphics and what is behind them.
                assert!(
                    a.max(b) / a.min(b) >= 3.0,
                    "{one} on {page}: {}",
                    a.max(b) / a.min(b)
                );
                for other in &colours[..index] {
                    for eye in eyes {
                        let [a, b] = [one, other].map(|colour| lab(product(eye, linear(colour))));
                        let distance = a
                            .iter()
                            .zip(b)
                            .map(|(a, b)| (a - b).powi(2))
                            .sum::<f64>()
                            .sqrt();
                        // A just noticeable difference is 2.3; marks differ as well, and other programs are dashed.
                        let least = if index < OWN { 25.0 } else { 18.0 };
                        assert!(distance > least, "{one} and {other}: {distance}");
                    }
                }
            }
        }
    }
}
