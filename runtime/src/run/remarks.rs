//! What a user should know of the impacts of a run.

use super::impact::{EndOfBounces, Impact};
use crate::model::Declaration;

/// Said of bounces that a run leaves out.
const STOPS: &str = "stops bouncing at";

/// Collected remarks; they do not grow with the number of events.
#[derive(Debug, Clone, Default)]
pub(crate) struct Remarks {
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

    /// The remarks, one line each.
    pub(crate) fn notes(&self, declaration: &Declaration) -> Vec<String> {
        let mut notes = Vec::new();
        let contact = |i: usize| &declaration.contacts[i];
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
                "`{name}` {STOPS} {:.6} s, where it is struck with {:.1e} {speed_unit}{height}{more}",
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

/// Whether a run with these notes has left out bounces.
pub(crate) fn leave_out_bounces(notes: &[String]) -> bool {
    notes.iter().any(|note| note.contains(STOPS))
}
