//! Where a motion is, as a method tells it.

use crate::contact::edge::Zeros;
use crate::contact::{Balance, ContactState, Touching, View};

/// How a contact would bounce that is struck now.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounce {
    /// Speed up to which it does not; infinite without restitution.
    pub(crate) slowest: f64,
    /// Normal acceleration with which it is pressed on its surface.
    pub(crate) press: f64,
}

/// An instant of a motion: its state, its contact mode, and what counts as zero.
pub(crate) trait Instant<'a> {
    /// Why what happens has no single outcome.
    type Error;

    /// The contacts, as last evaluated.
    fn view(&self) -> &View<'a>;

    /// The contacts, to evaluate them elsewhere.
    fn view_mut(&mut self) -> &mut View<'a>;

    /// Time \[s\].
    fn time(&self) -> f64;

    /// Input vector of the model at the present state, `(q, v, u[, t])`.
    fn input(&mut self) -> Vec<f64>;

    /// Goes to the coordinates and velocities that begin an input vector.
    fn put(&mut self, x: &[f64]);

    /// Rates of what the model reads besides coordinates and velocities: controls, and the time.
    fn rates(&mut self) -> Vec<f64>;

    /// Accelerations in the present mode.
    fn accelerations(&mut self) -> Vec<f64>;

    /// What a contact does in the present mode.
    fn state(&self, contact: usize) -> ContactState;

    /// What counts as zero at a contact.
    fn zeros(&self, contact: usize) -> Zeros;

    /// Sliding velocity up to which a contact is at rest.
    fn rest_speed(&self, contact: usize) -> f64;

    /// Normal and sliding velocities of all contacts that the law of impacts takes for none.
    fn still(&self) -> Vec<(f64, f64)>;

    /// Coefficient of restitution of a contact.
    fn restitution(&self, contact: usize) -> f64;

    /// How these contacts would bounce, one `alone` or several.
    fn bounces(&mut self, contacts: &[usize], alone: bool) -> Vec<Bounce>;

    /// Solves the law of impacts for lines that move by `offsets`.
    ///
    /// # Errors
    /// Where no impulses fulfil it, or several do with different motions.
    fn solve(view: &View<'a>, touching: Touching, offsets: &[f64]) -> Result<Balance, Self::Error>;

    /// Two conditions that come true at one instant set the same to different values, this one among them.
    fn set_twice(&self, condition: usize) -> Self::Error;

    /// Whether impacts of these contacts one after the other may stand for one of all at once, which has failed.
    fn may_follow(&self, error: &Self::Error, struck: &[usize]) -> bool;
}
