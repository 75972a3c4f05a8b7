//! One row of the table for every kind of scene.

use std::collections::BTreeMap;

use crate::judge::{AGREE, Verdict};

/// Largest share of the scenes that may end otherwise than solved.
const OTHERWISE: f64 = 0.05;

/// Counts of one kind of scene.
#[derive(Default)]
pub(crate) struct Row {
    scenes: usize,
    solved: usize,
    agree: usize,
    handed_over: usize,
    disagree: usize,
    default_off: usize,
    event_off: usize,
    worst: Option<(f64, u64)>,
    default_ended: BTreeMap<&'static str, usize>,
    event_ended: BTreeMap<&'static str, usize>,
}

impl Row {
    /// Counts the verdict on the scene with this number.
    pub(crate) fn add(&mut self, number: u64, verdict: &Verdict) {
        self.scenes += 1;
        match verdict {
            Verdict::Agree { handed_over } => {
                self.handed_over += usize::from(*handed_over);
                self.solved += 1;
                self.agree += 1;
            }
            Verdict::Disagree(difference) => {
                self.solved += 1;
                self.disagree += 1;
                if let (Some(default), Some(event)) = (difference.default, difference.event) {
                    self.default_off += usize::from(default > AGREE);
                    self.event_off += usize::from(event > AGREE);
                }
                if self.worst.is_none_or(|(worst, _)| difference.apart > worst) {
                    self.worst = Some((difference.apart, number));
                }
            }
            Verdict::Ended { default, event } => {
                for (ended, counts) in [
                    (default, &mut self.default_ended),
                    (event, &mut self.event_ended),
                ] {
                    if !ended.is_solved() {
                        *counts.entry(ended.status).or_default() += 1;
                    }
                }
            }
        }
    }

    /// Whether all solved ones agree, and few ended otherwise.
    pub(crate) fn holds(&self) -> bool {
        let otherwise = (self.scenes - self.solved) as f64;
        self.disagree == 0 && otherwise <= OTHERWISE * self.scenes as f64
    }

    /// Titles of the columns.
    pub(crate) fn titles() -> String {
        "| kind | scenes | solved both | agree | of them handed over | disagree (default off, event-driven off) | worst, seed | default ended otherwise | event-driven ended otherwise |\n|---|---|---|---|---|---|---|---|---|"
            .into()
    }

    /// The row of the kind called `name`.
    pub(crate) fn line(&self, name: &str) -> String {
        let statuses = |counts: &BTreeMap<&str, usize>| {
            let words = counts
                .iter()
                .map(|(status, count)| format!("{count} {status}"));
            words.collect::<Vec<_>>().join(", ")
        };
        let worst = self
            .worst
            .map_or_else(String::new, |(worst, seed)| format!("{worst:.1e}, {seed}"));
        format!(
            "| {name} | {} | {} | {} | {} | {} ({}, {}) | {worst} | {} | {} |",
            self.scenes,
            self.solved,
            self.agree,
            self.handed_over,
            self.disagree,
            self.default_off,
            self.event_off,
            statuses(&self.default_ended),
            statuses(&self.event_ended),
        )
    }
}
