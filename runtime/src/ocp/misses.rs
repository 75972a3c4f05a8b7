//! What the simulated motion that comes nearest to its goals misses of them.

/// A condition that a motion does not meet.
#[derive(Debug, Clone, PartialEq)]
pub struct Miss {
    /// The goal or path constraint, by its name or as written, or the coordinate that leaves its bounds.
    pub name: String,
    /// By how much, in its unit.
    pub amount: f64,
    /// That unit.
    pub unit: String,
}

/// The simulated motion, under random controls within their bounds, that comes nearest to goals that no plan reaches. A better one
/// may exist.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Nearest {
    /// How many were simulated.
    pub motions: usize,
    /// What it does not meet, the hardest first; by less than a thousandth of what most motions miss counts as met.
    pub misses: Vec<Miss>,
    /// How many impacts it has.
    pub impacts: usize,
}

/// Most conditions that are named.
const NAMED: usize = 3;
/// Impacts from which on it is said that there are many.
const MANY: usize = 6;

impl Nearest {
    /// It in words.
    pub(super) fn words(&self) -> String {
        let named = self.misses.iter().take(NAMED);
        let named =
            named.map(|miss| format!("`{}` by {:.3} {}", miss.name, miss.amount, miss.unit));
        let named: Vec<String> = named.map(|words| words.trim_end().to_owned()).collect();
        let many = if self.impacts >= MANY {
            format!(
                "; it has {} impacts, and a plan states every one: where bounces are small, `inelastic` leaves them out",
                self.impacts
            )
        } else {
            String::new()
        };
        let nearest = format!(
            "the nearest of {} motions simulated under random controls",
            self.motions
        );
        if named.is_empty() {
            format!("{nearest} comes as near to all goals as can be seen, but no plan does{many}")
        } else {
            format!("{nearest} misses {}{many}", named.join(" and "))
        }
    }
}
