//! Which contact closes, opens, begins to stick or to slip when: the contact sequence of a motion.

use crate::model::Pieces;
use crate::simulation::ContactMode;

/// Where in the grid of the controls a switch happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(in crate::ocp) enum Place {
    /// At the jump of the controls at the start of the interval; in the interval after the last one, an impact that
    /// ends the motion.
    Start,
    /// Inside the interval.
    Inside,
}

/// A place in the grid, and the time there in intervals, which inside an interval is a guess until solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::ocp) struct At {
    pub(in crate::ocp) interval: usize,
    pub(in crate::ocp) place: Place,
    pub(in crate::ocp) time: f64,
}

impl At {
    /// Inside the interval of a time.
    pub(in crate::ocp) fn inside(time: f64) -> Self {
        Self {
            interval: time as usize,
            place: Place::Inside,
            time,
        }
    }

    /// At the end of that many intervals.
    pub(in crate::ocp) fn end_of(interval: usize) -> Self {
        Self {
            interval,
            place: Place::Start,
            time: interval as f64,
        }
    }
}

/// A contact closes, opens, is touched, or changes from one way of sliding to another. A touch is an impact after which
/// the contact is open again, because it bounces, because it is pulled away, or because the motion passes an edge right there.
///
/// The gap of an edge is the largest of those of its pieces, so that one of them that is kept is enough: the one that acts.
/// Where another one comes to be as large, the motion *passes* the edge, and that one acts from there on. Where a contact
/// opens because it ends at the edge, the passage accompanies its opening. So does the closing of a contact that takes over
/// there without an impact, as where a ramp goes over into an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::ocp) struct Switch {
    pub(in crate::ocp) contact: usize,
    /// Whether there is an impact: the contact closes or is touched.
    pub(in crate::ocp) closes: bool,
    /// Whether the contact, which is open, acts from now on in place of another piece of its edge.
    pub(in crate::ocp) passes: bool,
    /// Whether it is a condition that comes true and sets velocities, whatever it is afterwards.
    pub(in crate::ocp) sets: bool,
    /// What the contact does afterwards.
    pub(in crate::ocp) mode: ContactMode,
    /// How it slides right after the impulse that belongs to the switch, if one does: its own, or that of the impact
    /// it accompanies.
    pub(in crate::ocp) impulse: ContactMode,
    /// Whether the contact switches at the same instant as another one, with the switch before it: both take part in
    /// one impact, or slide as parts of one body.
    pub(in crate::ocp) accompanies: bool,
    pub(in crate::ocp) interval: usize,
    pub(in crate::ocp) place: Place,
    /// When, in units of intervals; a guess until solved.
    pub(in crate::ocp) time: f64,
}

/// The modes of the contacts at the start, and the switches in order of time.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::ocp) struct Sequence {
    pub(in crate::ocp) initially: Vec<ContactMode>,
    /// The pieces of edges that act at the start.
    pub(in crate::ocp) pieces: Pieces,
    pub(in crate::ocp) switches: Vec<Switch>,
}

/// What tells two sequences apart, whatever the times.
pub(in crate::ocp) type Signature = (
    Vec<ContactMode>,
    Pieces,
    Vec<(usize, ContactMode, (bool, ContactMode), usize, Place)>,
);

/// What tells two sequences apart, whatever the intervals.
pub(in crate::ocp) type Order = (
    Vec<ContactMode>,
    Pieces,
    Vec<(usize, ContactMode, (bool, ContactMode))>,
);

impl Switch {
    /// A switch by itself inside an interval, with an impact or without; an impulse that belongs to it leaves the contact in its mode.
    pub(in crate::ocp) fn inside(
        contact: usize,
        closes: bool,
        mode: ContactMode,
        time: f64,
    ) -> Self {
        Self {
            contact,
            closes,
            passes: false,
            sets: false,
            mode,
            impulse: mode,
            accompanies: false,
            interval: time as usize,
            place: Place::Inside,
            time,
        }
    }

    /// A touch by itself inside an interval; how the contact slides right after the impulse is for the caller to say.
    pub(in crate::ocp) fn touch(contact: usize, impulse: ContactMode, time: f64) -> Self {
        Self {
            impulse,
            ..Self::inside(contact, true, ContactMode::Open, time)
        }
    }

    /// The passage of an edge to a piece of it, inside an interval.
    pub(in crate::ocp) fn passage(contact: usize, time: f64) -> Self {
        Self {
            passes: true,
            ..Self::inside(contact, false, ContactMode::Open, time)
        }
    }

    /// Where it happens.
    pub(in crate::ocp) fn place(&self) -> At {
        At {
            interval: self.interval,
            place: self.place,
            time: self.time,
        }
    }

    /// The same at another place.
    pub(in crate::ocp) fn at(&self, to: At) -> Self {
        Self {
            interval: to.interval,
            place: to.place,
            time: to.time,
            ..*self
        }
    }

    /// Whether the contact closes and is closed afterwards.
    pub(in crate::ocp) fn stays(&self) -> bool {
        self.closes && !self.mode.is_open()
    }

    /// Whether the contact is no more than touched.
    pub(in crate::ocp) fn touches(&self) -> bool {
        self.closes && self.mode.is_open()
    }

    /// Whether the contact opens.
    pub(in crate::ocp) fn opens(&self) -> bool {
        !self.closes && !self.passes && self.mode.is_open()
    }

    /// Whether the contact is closed before and afterwards.
    pub(in crate::ocp) fn slides(&self) -> bool {
        !self.closes && !self.mode.is_open()
    }

    /// Whether the contact may have the mode `before` until then.
    pub(super) fn follows(&self, before: ContactMode) -> bool {
        if self.passes {
            return before.is_open();
        }
        before.is_open() == self.closes && (self.closes || self.sets || before != self.mode)
    }
}

impl Sequence {
    /// One of a motion in which nothing switches and that passes no edge.
    pub(in crate::ocp) fn without_switches(initially: Vec<ContactMode>) -> Self {
        Self {
            initially,
            pieces: Pieces::default(),
            switches: Vec::new(),
        }
    }

    /// What tells it apart from others.
    pub(in crate::ocp) fn signature(&self) -> Signature {
        let switches = self.switches.iter();
        let switches = switches.map(|s| {
            let impulse = if s.closes || s.accompanies {
                s.impulse
            } else {
                ContactMode::Open
            };
            (
                s.contact,
                s.mode,
                (s.accompanies, impulse),
                s.interval,
                s.place,
            )
        });
        (
            self.initially.clone(),
            self.pieces.clone(),
            switches.collect(),
        )
    }

    /// What tells it apart from sequences with other switches or another order of them.
    pub(in crate::ocp) fn order(&self) -> Order {
        let (initially, pieces, switches) = self.signature();
        let switches = switches.into_iter();
        let switches = switches.map(|(contact, mode, impulse, ..)| (contact, mode, impulse));
        (initially, pieces, switches.collect())
    }

    /// Sorts the switches; `None` if a contact would close twice, open twice or begin what it does already, if a piece of
    /// an edge would close that does not act, or one in contact would cease to act, or for switches outside the `intervals`.
    pub(in crate::ocp) fn ordered(mut self, intervals: usize) -> Option<Self> {
        let key = |s: &Switch| (s.interval, s.place);
        self.switches
            .sort_by(|a, b| key(a).cmp(&key(b)).then(a.time.total_cmp(&b.time)));
        let (mut modes, mut pieces) = (self.initially.clone(), self.pieces.clone());
        let mut leader: Option<Switch> = None;
        for switch in &mut self.switches {
            let ends =
                switch.interval == intervals && switch.place == Place::Start && switch.closes;
            if !switch.follows(modes[switch.contact])
                || switch.interval >= intervals && !ends
                || switch.place == Place::Start && switch.interval == 0
                || pieces.is_idle(switch.contact) != switch.passes
                || switch.passes && !modes[pieces.acting(switch.contact)].is_open()
            {
                return None;
            }
            if switch.passes {
                pieces.pass_to(switch.contact);
            }
            modes[switch.contact] = switch.mode;
            let leads = |s: Switch| {
                let goes_on = switch.passes || switch.stays();
                (s.closes || s.slides() && switch.slides() || s.opens() && goes_on)
                    && key(&s) == key(switch)
                    && s.time == switch.time
            };
            switch.accompanies &= leader.is_some_and(leads);
            if !switch.accompanies {
                leader = Some(*switch);
            }
        }
        Some(self)
    }

    /// Whether an impact ends the motion.
    pub(in crate::ocp) fn ends_with_impact(&self, intervals: usize) -> bool {
        self.switches.iter().any(|s| s.interval == intervals)
    }

    /// The switches that accompany the one with this index.
    pub(in crate::ocp) fn companions(switches: &[Switch], index: usize) -> &[Switch] {
        let rest = &switches[index + 1..];
        let count = rest.iter().take_while(|switch| switch.accompanies).count();
        &rest[..count]
    }

    /// Whether the contact of the switch with this index opens because it ends at an edge, or another one takes over there.
    pub(in crate::ocp) fn ends_at_edge(switches: &[Switch], index: usize) -> bool {
        let mut companions = Self::companions(switches, index).iter();
        switches[index].opens() && companions.any(|switch| switch.passes || switch.stays())
    }

    /// Whether the switch with this index closes a contact that takes over from one that opens: without an impact.
    pub(in crate::ocp) fn takes_over(switches: &[Switch], index: usize) -> bool {
        let leader = switches[..index].iter().rfind(|s| !s.accompanies);
        let switch = &switches[index];
        switch.accompanies && switch.stays() && leader.is_some_and(Switch::opens)
    }

    /// Without the passages of edges.
    pub(in crate::ocp) fn without_passages(mut self) -> Self {
        self.switches.retain(|switch| !switch.passes);
        self
    }

    /// The pieces of edges that act before the switch with this index.
    pub(in crate::ocp) fn pieces_before(&self, index: usize) -> Pieces {
        let mut pieces = self.pieces.clone();
        for switch in self.switches[..index].iter().filter(|switch| switch.passes) {
            pieces.pass_to(switch.contact);
        }
        pieces
    }

    /// ContactMode of a contact before the switch with this index.
    pub(in crate::ocp) fn mode_before(&self, index: usize, contact: usize) -> ContactMode {
        let mut before = self.switches[..index].iter().rev();
        let last = before.find(|switch| switch.contact == contact);
        last.map_or(self.initially[contact], |switch| switch.mode)
    }

    /// Indices of neighbouring switches of the same contact, `(first, second)`.
    pub(in crate::ocp) fn neighbours(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.switches.len()).filter_map(|i| {
            let contact = self.switches[i].contact;
            let next = (i + 1..self.switches.len()).find(|&j| self.switches[j].contact == contact);
            next.map(|j| (i, j))
        })
    }

    /// Without changes that are none.
    pub(in crate::ocp) fn consistent(mut self) -> Self {
        let mut modes = self.initially.clone();
        self.switches.retain(|switch| {
            let before = std::mem::replace(&mut modes[switch.contact], switch.mode);
            switch.closes || switch.passes || switch.sets || before != switch.mode
        });
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::Direction;

    const FORWARD: ContactMode = ContactMode::Slip(Direction::Forward);

    fn switch(contact: usize, closes: bool, mode: ContactMode, time: f64) -> Switch {
        let place = if time.fract() == 0.0 {
            Place::Start
        } else {
            Place::Inside
        };
        Switch {
            place,
            ..Switch::inside(contact, closes, mode, time)
        }
    }

    fn sequence(initially: &[ContactMode], switches: &[Switch]) -> Sequence {
        Sequence {
            initially: initially.to_vec(),
            pieces: Pieces::default(),
            switches: switches.to_vec(),
        }
    }

    #[test]
    fn switches_in_any_order_are_sorted_by_place_and_time() {
        let late = switch(0, false, ContactMode::Open, 2.0);
        let early = switch(0, true, ContactMode::Frictionless, 0.7);
        let sorted = sequence(&[ContactMode::Open], &[late, early]).ordered(3);
        assert_eq!(sorted, Some(sequence(&[ContactMode::Open], &[early, late])));
    }

    #[test]
    fn sequence_that_no_contact_can_follow_is_refused() {
        let closing = switch(0, true, ContactMode::Frictionless, 0.5);
        let opening = switch(0, false, ContactMode::Open, 1.5);
        for switches in [
            vec![closing, switch(0, true, ContactMode::Frictionless, 0.9)],
            vec![opening],
            vec![closing, switch(0, false, ContactMode::Open, 4.5)],
            vec![closing.at(At::end_of(0))],
        ] {
            let refused = sequence(&[ContactMode::Open], &switches).ordered(3);
            assert_eq!(refused, None, "{switches:?}");
        }
        // An impact may end the motion, an opening may not.
        let ending = closing.at(At::end_of(3));
        let ends = sequence(&[ContactMode::Open], &[ending]).ordered(3);
        assert!(ends.is_some_and(|sequence| sequence.ends_with_impact(3)));
        let opens = Switch {
            closes: false,
            mode: ContactMode::Open,
            ..ending
        };
        assert_eq!(sequence(&[ContactMode::Stick], &[opens]).ordered(3), None);
    }

    #[test]
    fn companion_without_its_leader_stands_for_itself() {
        let impact = switch(0, true, ContactMode::Frictionless, 1.25);
        let companion = Switch {
            accompanies: true,
            ..switch(1, false, FORWARD, 1.25)
        };
        let modes = [ContactMode::Open, ContactMode::Stick];
        let both = sequence(&modes, &[impact, companion]).ordered(3).unwrap();
        assert_eq!(Sequence::companions(&both.switches, 0), [companion]);
        let alone = sequence(&modes, &[companion]).ordered(3).unwrap();
        assert!(!alone.switches[0].accompanies);
    }

    #[test]
    fn contact_takes_over_only_from_one_that_opens_at_the_same_instant() {
        let opening = switch(0, false, ContactMode::Open, 1.25);
        let closing = Switch {
            accompanies: true,
            ..switch(1, true, ContactMode::Frictionless, 1.25)
        };
        let modes = [ContactMode::Frictionless, ContactMode::Open];
        let both = sequence(&modes, &[opening, closing]).ordered(3).unwrap();
        assert!(Sequence::takes_over(&both.switches, 1));
        assert!(Sequence::ends_at_edge(&both.switches, 0));
        let later = Switch {
            time: 1.75,
            ..closing
        };
        let apart = sequence(&modes, &[opening, later]).ordered(3).unwrap();
        assert!(!Sequence::takes_over(&apart.switches, 1));
        assert!(!Sequence::ends_at_edge(&apart.switches, 0));
        assert_ne!(both.signature(), apart.signature());
    }

    #[test]
    fn signature_ignores_times_but_not_intervals() {
        let at = |time| {
            sequence(
                &[ContactMode::Open],
                &[switch(0, true, ContactMode::Frictionless, time)],
            )
        };
        assert_eq!(at(0.2).signature(), at(0.9).signature());
        assert_ne!(at(0.2).signature(), at(1.2).signature());
        assert_ne!(at(0.9).signature(), at(1.0).signature());
    }

    #[test]
    fn mode_before_a_switch_is_that_of_the_last_switch_of_the_contact() {
        let switches = [
            switch(0, true, ContactMode::Stick, 0.5),
            switch(1, true, ContactMode::Frictionless, 1.5),
            switch(0, false, FORWARD, 2.5),
        ];
        let sequence = sequence(&[ContactMode::Open; 2], &switches);
        assert_eq!(sequence.mode_before(0, 0), ContactMode::Open);
        assert_eq!(sequence.mode_before(2, 0), ContactMode::Stick);
        assert_eq!(sequence.mode_before(1, 1), ContactMode::Open);
        let pairs: Vec<(usize, usize)> = sequence.neighbours().collect();
        assert_eq!(pairs, [(0, 2)]);
    }

    #[test]
    fn change_to_the_same_mode_is_dropped_but_a_touch_is_kept() {
        let touch = switch(0, true, ContactMode::Open, 0.5);
        let nothing = switch(1, false, FORWARD, 1.5);
        let consistent = sequence(&[ContactMode::Open, FORWARD], &[touch, nothing]).consistent();
        assert_eq!(consistent.switches, [touch]);
    }
}
