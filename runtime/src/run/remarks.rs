//! What a user should know of the impacts of a run.

use super::impact::{EndOfBounces, Impact};
use crate::model::Declaration;

/// What a method could not decide alone of a motion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Doubts {
    /// Whether flights or bounces are left out for being too low.
    pub flights: bool,
    /// Whether impacts that follow too fast to be told apart are joined, or rounding decides their order.
    pub clusters: bool,
    /// Whether the motion is by another method than the one that was asked for, which failed.
    pub handed_over: bool,
}

/// Collected remarks; they do not grow with the number of events.
#[derive(Debug, Clone, Default)]
pub(crate) struct Remarks {
    /// Whether flights lower than the rounding error of their gap are left out that others could feel.
    pub(crate) low_flights: bool,
    simultaneous: bool,
    /// Of clusters of impacts.
    clusters: Vec<&'static str>,
    /// One a contact.
    ends: Vec<Ends>,
    /// The first impact that raised the kinetic energy: time, contact, energy before and after; and how many
    /// did.
    gain: Option<(f64, usize, (f64, f64))>,
    gains: usize,
}

/// The bounces of one contact that were left out.
#[derive(Debug, Clone)]
struct Ends {
    contact: usize,
    time: f64,
    speed: f64,
    /// Highest of the bounces left out.
    height: f64,
    count: usize,
}

impl Remarks {
    /// Remembers what an impact at `time` has to say.
    pub(crate) fn add(&mut self, time: f64, impact: &Impact) {
        self.simultaneous |= impact.simultaneous;
        if let Some(note) = impact.cluster
            && !self.clusters.contains(&note)
        {
            self.clusters.push(note);
        }
        for &end in &impact.ended {
            self.add_end(time, end);
        }
        if let (Some(energies), Some(&contact)) = (impact.energy_gain, impact.struck.first()) {
            self.gain.get_or_insert((time, contact, energies));
            self.gains += 1;
        }
    }

    /// Remembers a bounce that was left out at `time`.
    pub(crate) fn add_end(&mut self, time: f64, end: EndOfBounces) {
        let EndOfBounces {
            contact,
            speed,
            height,
        } = end;
        match self.ends.iter_mut().find(|end| end.contact == contact) {
            Some(end) => {
                end.height = end.height.max(height);
                end.count += 1;
            }
            None => self.ends.push(Ends {
                contact,
                time,
                speed,
                height,
                count: 1,
            }),
        }
    }

    /// What the impacts leave to another method to confirm.
    pub(crate) fn doubts(&self) -> Doubts {
        Doubts {
            flights: self.low_flights || !self.ends.is_empty(),
            clusters: !self.clusters.is_empty(),
            handed_over: false,
        }
    }

    /// The remarks, one line each.
    pub(crate) fn notes(&self, declaration: &Declaration) -> Vec<String> {
        let mut notes = Vec::new();
        let contact = |i: usize| &declaration.contacts[i];
        if self.low_flights {
            notes.push("flights lower than the rounding error of their gap are left out".into());
        }
        if self.simultaneous {
            notes.push(
                "simultaneous impacts follow Moreau's law (all touching contacts in one linear complementarity problem)"
                    .into(),
            );
        }
        notes.extend(self.clusters.iter().map(|&note| note.into()));
        for end in &self.ends {
            let name = contact(end.contact).name;
            let (unit, speed_unit) = match contact(end.contact).unit {
                "" => (String::new(), "1/s".into()),
                unit => (format!(" {unit}"), format!("{unit}/s")),
            };
            let height = if end.height.is_finite() {
                format!(
                    ", which leaves out bounces up to {:.1e}{unit} high",
                    end.height
                )
            } else {
                String::new()
            };
            let more = match end.count {
                1 => String::new(),
                count => format!("; so it does {} more times", count - 1),
            };
            notes.push(format!(
                "`{name}` stops bouncing at {:.6} s, where it is struck with {:.1e} {speed_unit}{height}{more}",
                end.time, end.speed
            ));
        }
        if let Some((time, i, (before, after))) = self.gain {
            let that_raise = match self.gains {
                1 => "1 impact raises".to_owned(),
                gains => format!("{gains} impacts raise"),
            };
            notes.push(format!(
                "{that_raise} the kinetic energy, the first of `{}` at {time:.6} s from {before:.6e} to \
                 {after:.6e}: restitution in the normal direction alone does so where friction or several \
                 contacts couple; lower the restitution",
                contact(i).name
            ));
        }
        notes
    }
}
