//! Where the variables and rows of the step form stand.

use std::ops::Range;

/// Algebraic variables of one contact.
pub(super) const PER_CONTACT: usize = 6;
/// Offsets of the algebraic variables of one contact.
pub(crate) const ALPHA: usize = 0;
pub(super) const BETA: usize = 1;
pub(crate) const LAMBDA_PLUS: usize = 2;
pub(super) const LAMBDA_MINUS: usize = 3;
pub(crate) const P: usize = 4;
pub(crate) const W: usize = 5;

/// Algebraic variables of one friction, and their offsets.
pub(super) const PER_FRICTION: usize = 4;
pub(super) const SLIP_PLUS: usize = 0;
pub(super) const SLIP_MINUS: usize = 1;
pub(super) const C_PLUS: usize = 2;
pub(super) const C_MINUS: usize = 3;

/// Algebraic variables of one restitution, and their offsets.
const PER_RESTITUTION: usize = 2;
pub(super) const FALL: usize = 0;
pub(super) const RISE: usize = 1;

/// Algebraic variables of one piece that another one of its edge is compared with, and their offsets.
const PER_EDGE: usize = 2;
pub(super) const AHEAD: usize = 0;
pub(super) const BEHIND: usize = 1;

/// Two pairs of variables of a stage, `(first, against first, second, against second)`: over a finite element
/// the sum of a weight is complementary to the sum of the multiplier against it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Group {
    /// Places in `xi`: weight, multiplier, weight, multiplier.
    pub(crate) places: [usize; 4],
}

/// Numbers of what a system has, from which places and rows follow.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    /// Number of coordinates.
    pub(super) n: usize,
    /// Number of contacts that are surfaces. The others, behind them, are dry friction.
    pub(crate) contacts: usize,
    /// Number of controls.
    pub(crate) controls: usize,
    /// Contacts with friction.
    pub(super) rough: Vec<usize>,
    /// Contacts with restitution.
    pub(super) elastic: Vec<usize>,
    /// Contacts that are pieces of an outer edge, each with every other piece of it.
    pub(super) edges: Vec<(usize, usize)>,
    /// Contacts with restitution that are pieces of an outer edge.
    pub(super) dipping: Vec<usize>,
    /// Conditions that set velocities where they come true, among the dry frictions.
    pub(super) conditions: Vec<usize>,
}

impl Layout {
    /// Length of `y = (q, v, t, G, D)`.
    pub(crate) fn states(&self) -> usize {
        self.lifted_gaps().end + self.dipping.len()
    }

    /// Number of contacts with friction, dry friction among them.
    pub(crate) fn frictions(&self) -> usize {
        self.rough.len()
    }

    /// Whether a contact is dry friction, which has a friction alone.
    pub(crate) fn is_dry(&self, contact: usize) -> bool {
        contact >= self.contacts
    }

    /// Whether a contact is a condition that sets velocities.
    pub(crate) fn is_condition(&self, contact: usize) -> bool {
        self.conditions.contains(&contact)
    }

    /// Length of `z`.
    fn algebraics(&self) -> usize {
        self.first_product() - self.first_algebraic() + self.contacts.saturating_sub(1)
    }

    /// Symbol of the algebraic variable at `place`, and the contact it belongs to; none for lifted products.
    pub(crate) fn algebraic_symbol(&self, place: usize) -> Option<(&'static str, usize)> {
        let part = |place: usize, first: usize, symbols: &[&'static str], contacts: &[usize]| {
            let k = place - first;
            let contact = contacts.get(k / symbols.len())?;
            Some((symbols[k % symbols.len()], *contact))
        };
        let (friction, rebound) = (self.friction_place(0, 0), self.rebound_place(0, 0));
        if place < self.first_algebraic() || place >= self.first_product() {
            None
        } else if place < friction {
            let contacts: Vec<usize> = (0..self.contacts).collect();
            let symbols = ["alpha", "beta", "lp", "ln", "p", "w"];
            part(place, self.first_algebraic(), &symbols, &contacts)
        } else if place < rebound {
            part(place, friction, &["b+", "b-", "c+", "c-"], &self.rough)
        } else if place < self.edge_place(0, 0) {
            part(place, rebound, &["f", "r"], &self.elastic)
        } else {
            let contacts: Vec<usize> = self.edges.iter().map(|edge| edge.0).collect();
            part(
                place,
                self.edge_place(0, 0),
                &["ahead", "behind"],
                &contacts,
            )
        }
    }

    /// Length of the local vector `xi`.
    pub(crate) fn local_variables(&self) -> usize {
        self.first_algebraic() + self.algebraics()
    }

    /// Place in `xi` of the first algebraic variable.
    pub(crate) fn first_algebraic(&self) -> usize {
        self.states() + self.controls
    }

    /// Place in `xi` of algebraic variable `offset` of `contact`.
    pub(crate) fn algebraic(&self, contact: usize, offset: usize) -> usize {
        self.first_algebraic() + PER_CONTACT * contact + offset
    }

    /// Place in `xi` of variable `offset` of friction `r`.
    pub(super) fn friction_place(&self, r: usize, offset: usize) -> usize {
        self.algebraic(self.contacts, 0) + PER_FRICTION * r + offset
    }

    /// Place in `xi` of variable `offset` of restitution `j`.
    pub(super) fn rebound_place(&self, j: usize, offset: usize) -> usize {
        self.friction_place(self.rough.len(), 0) + PER_RESTITUTION * j + offset
    }

    /// Place in `xi` of variable `offset` of edge `k`.
    pub(super) fn edge_place(&self, k: usize, offset: usize) -> usize {
        self.rebound_place(self.elastic.len(), 0) + PER_EDGE * k + offset
    }

    /// Place in `xi` of the first lifted product. What comes before it is not negative.
    pub(crate) fn first_product(&self) -> usize {
        self.edge_place(self.edges.len(), 0)
    }

    /// The comparisons of a contact with the other pieces of its edge: their numbers, and these pieces.
    pub(super) fn edges_of(&self, contact: usize) -> impl Iterator<Item = (usize, usize)> {
        let edges = self.edges.iter().enumerate();
        edges.filter_map(move |(k, edge)| (edge.0 == contact).then_some((k, edge.1)))
    }

    /// Index of the restitution of `contact`, if it bounces.
    pub(super) fn rebound(&self, contact: usize) -> Option<usize> {
        self.elastic.iter().position(|&i| i == contact)
    }

    /// Whether `contact` bounces.
    pub(crate) fn bounces(&self, contact: usize) -> bool {
        self.rebound(contact).is_some()
    }

    /// Whether the lifted gap of `contact` moves during its jumps.
    pub(crate) fn moves_in_jumps(&self, contact: usize) -> bool {
        self.bounces(contact) && self.dip(contact).is_none()
    }

    /// Place in `xi` of the physical time.
    pub(crate) fn time(&self) -> usize {
        2 * self.n
    }

    /// Place in `xi` of the lifted gap of `contact`.
    pub(crate) fn lifted_gap(&self, contact: usize) -> usize {
        2 * self.n + 1 + contact
    }

    /// Places in `xi` of all lifted gaps.
    pub(crate) fn lifted_gaps(&self) -> Range<usize> {
        self.lifted_gap(0)..self.lifted_gap(self.contacts)
    }

    /// Place in `xi` of the dip of `contact`, if it bounces at an edge.
    pub(crate) fn dip(&self, contact: usize) -> Option<usize> {
        let dip = self.dipping.iter().position(|&i| i == contact)?;
        Some(self.lifted_gaps().end + dip)
    }

    /// The contact whose dip stands at `place`.
    pub(crate) fn dip_of(&self, place: usize) -> Option<usize> {
        let dip = place.checked_sub(self.lifted_gaps().end)?;
        self.dipping.get(dip).copied()
    }

    /// Place in `xi` of the product of the first `count >= 1` step functions.
    pub(super) fn product(&self, count: usize) -> usize {
        if count == 1 {
            self.algebraic(0, ALPHA)
        } else {
            self.first_product() + count - 2
        }
    }

    /// Place in `xi` of `theta`, unless there is no contact and `theta = 1`.
    pub(crate) fn theta(&self) -> Option<usize> {
        (self.contacts > 0).then(|| self.product(self.contacts))
    }

    /// What is cross-complementary over an element: first the step functions of the contacts, then the signs
    /// of sliding velocities, then those of normal velocities in bounces.
    pub(crate) fn groups(&self) -> Vec<Group> {
        let contact = |i: usize| Group {
            places: [ALPHA, LAMBDA_MINUS, BETA, LAMBDA_PLUS].map(|o| self.algebraic(i, o)),
        };
        let friction = |r: usize| Group {
            places: [SLIP_PLUS, C_MINUS, SLIP_MINUS, C_PLUS].map(|o| self.friction_place(r, o)),
        };
        let rebound = |j: usize| Group {
            places: [
                self.rebound_place(j, FALL),
                self.algebraic(self.elastic[j], P),
                self.rebound_place(j, RISE),
                self.algebraic(self.elastic[j], W),
            ],
        };
        let contacts = (0..self.contacts).map(contact);
        let frictions = (0..self.rough.len()).map(friction);
        let rebounds = (0..self.elastic.len()).map(rebound);
        contacts.chain(frictions).chain(rebounds).collect()
    }

    /// Places of what sum `sum` of a group adds up. A piece that acts in an element is the largest of its edge in all of
    /// it: what another one is ahead counts against its weight.
    pub(crate) fn summed(&self, group: usize, sum: usize) -> Vec<usize> {
        const AGAINST_BETA: usize = 3;
        let own = self.groups()[group].places[sum];
        let edges = self.edges_of(group).filter(|_| sum == AGAINST_BETA);
        let ahead = edges.map(|(k, _)| self.edge_place(k, AHEAD));
        std::iter::once(own).chain(ahead).collect()
    }

    /// Places of the variables that are complementary in each stage.
    pub(crate) fn stage_pairs(&self) -> Vec<(usize, usize)> {
        let contacts = (0..self.contacts).map(|i| (self.algebraic(i, P), self.algebraic(i, W)));
        let frictions = (0..self.rough.len()).map(|r| {
            (
                self.friction_place(r, C_PLUS),
                self.friction_place(r, C_MINUS),
            )
        });
        let edges =
            (0..self.edges.len()).map(|k| (self.edge_place(k, AHEAD), self.edge_place(k, BEHIND)));
        contacts.chain(frictions).chain(edges).collect()
    }

    /// The pairs in each stage of one surface: of its margin, its friction, its edges.
    pub(crate) fn stage_pairs_of(&self, contact: usize) -> Vec<(usize, usize)> {
        let friction = self.slip_group(contact);
        let first_edge = self.contacts + self.rough.len();
        let edges = self.edges_of(contact).map(|(k, _)| first_edge + k);
        let pairs = self.stage_pairs();
        let own = std::iter::once(contact).chain(friction).chain(edges);
        own.map(|k| pairs[k]).collect()
    }

    /// Groups of one surface: its own, and those of its friction and its restitution.
    pub(crate) fn groups_of(&self, contact: usize) -> impl Iterator<Item = usize> + use<> {
        let first = self.contacts + self.rough.len();
        let rebound = self.rebound(contact).map(|j| first + j);
        std::iter::once(contact)
            .chain(self.slip_group(contact))
            .chain(rebound)
    }

    /// Whether the variable at `place` belongs to the switching functions alone, which the end of an element
    /// without a stage there has too.
    pub(crate) fn is_switching(&self, place: usize) -> bool {
        let first = self.first_algebraic();
        let (friction, rebound) = (self.friction_place(0, 0), self.rebound_place(0, 0));
        if place < friction {
            (place - first) % PER_CONTACT >= LAMBDA_PLUS
        } else if place < rebound {
            (place - friction) % PER_FRICTION >= C_PLUS
        } else {
            (self.edge_place(0, 0)..self.first_product()).contains(&place)
        }
    }

    /// Number of the group of the friction of `contact`, if it has any.
    pub(crate) fn slip_group(&self, contact: usize) -> Option<usize> {
        let friction = self.rough.iter().position(|&i| i == contact);
        friction.map(|r| self.contacts + r)
    }
}
