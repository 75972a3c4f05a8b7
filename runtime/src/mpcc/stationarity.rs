//! What is proved about a result.

/// What is proved about a feasible point, or about the contact sequence of a motion.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A cart that is pushed to 1 m.
/// #     pub Cart {
/// #         parameters { m: kg = 2 }
/// #         coordinates { y: m }
/// #         controls { u: N in -1..=1 }
/// #         lagrangian m/2*dot(y)^2
/// #         forces { y: u }
/// #         minimize time
/// #         finally { y == 1[m] }
/// #     }
/// # }
/// let cart = Cart::default();
/// let solution = solve(&cart).intervals(4).run()?;
/// // Without contacts there is no neighbouring contact sequence.
/// assert_eq!(solution.stationarity, Stationarity::S);
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stationarity {
    /// Strongly stationary: the optimality conditions of the program with all pairs relaxed hold. Of a motion: nowhere do
    /// gap and force of a contact vanish together, and no switch sticks to a jump of the controls, so that the sequence has
    /// no neighbours.
    S,
    /// B-stationary: there are such pairs or places, and no choice of the sides that vanish, no neighbouring sequence, is
    /// better.
    B,
    /// Nothing.
    None,
}

impl Stationarity {
    /// Name used in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::S => "S",
            Self::B => "B",
            Self::None => "none",
        }
    }
}
