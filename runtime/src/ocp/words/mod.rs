//! The search over words: in which order contacts close and open, whatever the control grid.
//!
//! A *word* is the order of contact modes of a motion, without times. Its program has a phase of free length for each mode and a few
//! control pieces in each phase, so that nothing but the word itself has to be guessed: when the switches happen is part of the
//! solution. Goals may be missed at a price, so that a word without a motion still has a merit, and multipliers that say what it lacks.
//!
//! ```text
//! beginnings   words of simulated motions under random controls, of what they begin with, of the ride, and the empty one
//! library      cycles and walks between modes that these motions went through
//! off_grid     a word and a guess -> its program with free lengths, solved
//! edits        named rules that make a word into another one, each with a price
//! search       best first over price, rank and merit of the parent, until nothing more is gained
//! on_grid      the best words with their switches in, at and around the ends of the control intervals
//! ```

pub(in crate::ocp) mod aligned;
pub(in crate::ocp) mod beginnings;
mod edits;
pub(in crate::ocp) mod library;
pub(in crate::ocp) mod off_grid;
pub(in crate::ocp) mod on_grid;
pub(in crate::ocp) mod search;
mod word;
