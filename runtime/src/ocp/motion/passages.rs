//! The passages of edges that a motion makes: where another piece of an edge comes to be the largest.

use super::model_input::drive;
use super::sequence::{Place, Sequence, Switch};
use super::trajectory::Trajectory;
use crate::model::{Model, Pieces, edge};
use crate::simulation::ContactMode;
use crate::yardstick;

/// A passage within this share of an interval from its end is put there: at a node of the grid both pieces are kept, which a
/// motion that is not close to the edge does anyway, and a phase of no length is none.
const NEAR_NODE: f64 = 0.1;
/// Most pieces that are passed between two instants.
const DEPTH: usize = 6;

/// A state `(q, v)` and its time in units of intervals.
#[derive(Clone)]
struct Instant {
    time: f64,
    state: Vec<f64>,
}

/// A motion whose passages are read.
struct Reader<'r> {
    model: &'r dyn Model,
    /// Length of an interval \[s\], and their number.
    interval: f64,
    intervals: usize,
    instants: Vec<Instant>,
    /// Whether contacts open exactly when the sequence says so.
    exact: bool,
}

/// The sequence of a motion with the passages of edges. The motion is `exact` if its contacts open exactly when its
/// sequence says so.
pub(in crate::ocp) fn with_passages(
    model: &dyn Model,
    sequence: Sequence,
    motion: &Trajectory,
    exact: bool,
) -> Sequence {
    if edge(model).is_none() {
        return sequence;
    }
    let intervals = motion.controls.intervals();
    let interval = motion.horizon / intervals as f64;
    let plain = 2 * model.declaration().coordinates.len();
    let samples = motion.time.iter().zip(&motion.states);
    let instants = samples.map(|(time, state)| Instant {
        time: time / interval,
        state: state[..plain].to_vec(),
    });
    let reader = Reader {
        model,
        interval,
        intervals,
        instants: instants.collect(),
        exact,
    };
    reader.read(sequence)
}

impl Reader<'_> {
    fn read(&self, mut sequence: Sequence) -> Sequence {
        let Some(first) = self.instants.first() else {
            return sequence;
        };
        let mut pieces = Pieces::at(self.model, &self.input(first));
        let mut modes = sequence.initially.clone();
        for contact in (0..modes.len()).filter(|&contact| !modes[contact].is_open()) {
            pieces.pass_to(contact);
        }
        sequence.pieces = pieces.clone();
        let mut given = std::mem::take(&mut sequence.switches);
        given.sort_by(|a, b| a.time.total_cmp(&b.time));
        let mut given = given.into_iter().peekable();
        let switches = &mut sequence.switches;
        for pair in self.instants.windows(2) {
            while let Some(switch) = given.next_if(|switch| switch.time <= pair[0].time) {
                self.add(switch, switches, &mut modes, &mut pieces);
            }
            for passage in self.between(&pair[0], &pair[1], &pieces, DEPTH) {
                while let Some(switch) = given.next_if(|switch| switch.time <= passage.time) {
                    self.add(switch, switches, &mut modes, &mut pieces);
                }
                // A contact that ends at the edge passes it where it opens.
                let leaves = modes[pieces.acting(passage.contact)].is_open();
                let inside = passage.interval < self.intervals && passage.time > 0.0;
                if leaves && inside && pieces.is_idle(passage.contact) {
                    pieces.pass_to(passage.contact);
                    switches.push(passage);
                }
            }
        }
        for switch in given {
            self.add(switch, switches, &mut modes, &mut pieces);
        }
        sequence
    }

    /// Adds a switch, and the passage that it needs.
    fn add(
        &self,
        switch: Switch,
        switches: &mut Vec<Switch>,
        modes: &mut [ContactMode],
        pieces: &mut Pieces,
    ) {
        let contact = switch.contact;
        if switch.closes && pieces.is_idle(contact) {
            modes[pieces.acting(contact)] = ContactMode::Open;
            pieces.pass_to(contact);
            switches.push(Switch {
                accompanies: switch.accompanies,
                ..passage(contact, switch)
            });
        }
        switches.push(switch);
        modes[contact] = switch.mode;
        if switch.opens()
            && let Some(next) = self.beyond(&switch)
        {
            pieces.pass_to(next);
            switches.push(passage(next, switch));
        }
    }

    /// The piece to which a contact that opens ends, if it does so at an edge.
    fn beyond(&self, opening: &Switch) -> Option<usize> {
        let others = self.model.declaration().contacts[opening.contact].alternatives;
        let next = self.instants.iter().find(|i| i.time > opening.time)?;
        let acting = self.largest(opening.contact, next)?;
        let here = self.instants.iter().rfind(|i| i.time <= opening.time)?;
        // Nearer than this to the other piece, in the unit of the gap, it ends at the edge.
        let exact = !self.exact || self.gap(acting, here) > -yardstick::PROMISE;
        (others.contains(&acting) && exact).then_some(acting)
    }

    /// Passages between two instants, in order of time.
    fn between(&self, from: &Instant, to: &Instant, pieces: &Pieces, depth: usize) -> Vec<Switch> {
        let mut found = Vec::new();
        for contact in 0..self.model.declaration().contacts.len() {
            let acting = pieces.acting(contact);
            if acting == contact {
                found.extend(self.passed(from, to, acting, depth));
            }
        }
        found.sort_by(|a, b| a.time.total_cmp(&b.time));
        found
    }

    /// The passages of one edge between two instants, at the first of which `acting` acts.
    fn passed(&self, from: &Instant, to: &Instant, acting: usize, depth: usize) -> Vec<Switch> {
        let Some(next) = self.largest(acting, to).filter(|&next| next != acting) else {
            return Vec::new();
        };
        let above = |instant: &Instant| self.gap(next, instant) - self.gap(acting, instant);
        let (before, after) = (above(from), above(to));
        let share = (-before / (after - before)).clamp(0.0, 1.0);
        let share = if share.is_finite() { share } else { 0.0 };
        let pair = from.state.iter().zip(&to.state);
        let crossing = Instant {
            time: from.time + share * (to.time - from.time),
            state: pair.map(|(a, b)| a + share * (b - a)).collect(),
        };
        let third = self.largest(acting, &crossing);
        let third = third.filter(|third| ![acting, next].contains(third) && depth > 0);
        if let Some(third) = third {
            let mut found = self.passed(from, &crossing, acting, depth - 1);
            found.extend(self.passed(&crossing, to, third, depth - 1));
            return found;
        }
        let node = crossing.time.round();
        let at_node = node > 0.0 && (crossing.time - node).abs() < NEAR_NODE;
        let (time, place) = if at_node {
            (node, Place::Start)
        } else {
            (crossing.time, Place::Inside)
        };
        vec![Switch {
            place,
            ..Switch::passage(next, time)
        }]
    }

    /// The piece of the edge of a contact that is the largest; that one if others are as large.
    fn largest(&self, contact: usize, instant: &Instant) -> Option<usize> {
        let others = self.model.declaration().contacts[contact].alternatives;
        // By so much, in the unit of the gap, another one has to exceed it.
        let mut largest = (contact, self.gap(contact, instant) + yardstick::NOTHING);
        for &other in others {
            let gap = self.gap(other, instant);
            if gap > largest.1 {
                largest = (other, gap);
            }
        }
        (!others.is_empty()).then_some(largest.0)
    }

    fn gap(&self, contact: usize, instant: &Instant) -> f64 {
        self.model.gap(contact, &self.input(instant))
    }

    fn input(&self, instant: &Instant) -> Vec<f64> {
        let controls = vec![0.0; self.model.declaration().controls.len()];
        let mut input = instant.state.clone();
        input.extend(drive(self.model, &controls, instant.time * self.interval));
        input
    }
}

/// The passage to a piece at the instant of a switch.
fn passage(contact: usize, switch: Switch) -> Switch {
    Switch {
        accompanies: true,
        ..Switch::passage(contact, switch.time).at(switch.place())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ocp::motion::control_grid::ControlGrid;

    crate::model! {
        /// A block on a table with two ends.
        Table {
            parameters { m: kg = 1, g: m/s^2 = 9.81 }
            coordinates { y: m, z: m }
            lagrangian m/2*|dot((y, z))|^2 - m*g*z
            surface table: max(z, y - 1 [m], -y - 1 [m]) >= 0
            impact table: inelastic
        }
    }

    /// A motion through places `(y, z)`, one an interval of a second.
    fn through(places: &[(f64, f64)]) -> Trajectory {
        let intervals = places.len() - 1;
        Trajectory {
            horizon: intervals as f64,
            controls: ControlGrid::constant(vec![Vec::new(); intervals]),
            time: (0..places.len()).map(|i| i as f64).collect(),
            states: places.iter().map(|&(y, z)| vec![y, z, 0.0, 0.0]).collect(),
        }
    }

    fn switch(closes: bool, mode: ContactMode, time: f64) -> Switch {
        Switch::inside(0, closes, mode, time)
    }

    fn read(initially: ContactMode, switches: Vec<Switch>, motion: &Trajectory) -> Sequence {
        let mut sequence =
            Sequence::without_switches(vec![initially, ContactMode::Open, ContactMode::Open]);
        sequence.switches = switches;
        with_passages(&Table::default(), sequence, motion, false)
    }

    #[test]
    fn flight_passes_both_edges_of_a_table_between_two_instants() {
        let sequence = read(
            ContactMode::Open,
            Vec::new(),
            &through(&[(-3.0, 0.2), (3.0, 0.2)]),
        );
        assert_eq!(sequence.pieces.acting(0), 2);
        let passed: Vec<(usize, f64)> = sequence
            .switches
            .iter()
            .map(|s| (s.contact, s.time))
            .collect();
        // y = -1.2 and y = 1.2.
        assert_eq!(passed.iter().map(|p| p.0).collect::<Vec<_>>(), [0, 1]);
        assert!(
            (passed[0].1 - 0.3).abs() < 1e-12 && (passed[1].1 - 0.7).abs() < 1e-12,
            "{passed:?}"
        );
        assert!(sequence.ordered(1).is_some());
    }

    #[test]
    fn contact_that_opens_beyond_the_edge_ends_there_and_one_before_it_does_not() {
        let opening = switch(false, ContactMode::Open, 1.5);
        let places = [(0.0, 0.0), (0.9, 0.0), (1.4, -0.2)];
        let ended = read(ContactMode::Frictionless, vec![opening], &through(&places));
        assert!(Sequence::ends_at_edge(&ended.switches, 0), "{ended:?}");
        assert!(ended.ordered(2).is_some());
        let places = [(0.0, 0.0), (0.5, 0.0), (0.7, 0.1), (1.5, 0.1)];
        let flown = read(ContactMode::Frictionless, vec![opening], &through(&places));
        assert!(!Sequence::ends_at_edge(&flown.switches, 0), "{flown:?}");
        assert!(flown.switches[1].passes && !flown.switches[1].accompanies);
        assert!(flown.ordered(3).is_some());
    }

    #[test]
    fn piece_that_closes_acts_before_it_does() {
        let closing = switch(true, ContactMode::Frictionless, 0.5);
        let places = [(1.5, 0.3), (0.8, 0.0), (0.5, 0.0)];
        let landed = read(ContactMode::Open, vec![closing], &through(&places));
        assert!(
            landed.switches[0].passes && landed.switches[1].closes,
            "{landed:?}"
        );
        assert!(landed.clone().ordered(2).is_some());
        // Not without the passage, and not from another piece that is closed.
        let mut without = landed.clone();
        without.switches.remove(0);
        assert_eq!(without.ordered(2), None);
        let mut held = landed;
        held.initially[1] = ContactMode::Frictionless;
        assert_eq!(held.ordered(2), None);
    }
}
