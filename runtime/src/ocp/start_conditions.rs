//! Conditions at the start of the motion.

use super::collocation::Setting;
use super::kernel::Kernel;
use super::mode::{Mode, sliding_velocity, zero_velocity};
use super::transcribe::Builder;

impl Builder<'_, '_> {
    /// Contacts that are pulled into slip from the start of the motion.
    pub(super) fn pulled_at_start(&self) -> Vec<usize> {
        let Setting { model, problem, .. } = self.setting;
        let start = problem.start();
        let zero = zero_velocity(&start[self.n..]);
        let modes = self.modes.iter().enumerate();
        modes
            .filter(|(_, mode)| matches!(mode, Mode::Slip(_)) && !problem.has_free_start(model))
            .map(|(contact, _)| contact)
            .filter(|&contact| sliding_velocity(model, contact, &start, 0.0).abs() <= zero)
            .collect()
    }

    /// Where initial values are free: contacts closed at the start touch and rest, the others are open.
    pub(super) fn free_start(&mut self) {
        let Setting {
            model,
            problem,
            units,
            ..
        } = self.setting;
        let free: Vec<usize> = (0..2 * self.n)
            .filter(|&k| {
                let (lower, upper) = self.program.bounds(self.frame.start[k]);
                lower < upper
            })
            .collect();
        if !problem.has_free_start(model) {
            return;
        }
        for (i, contact) in model.declaration().contacts.iter().enumerate() {
            let reads = |row: u32| {
                let mut entries = contact.jacobian.entries.iter();
                entries.any(|&(r, column)| r == row && free.contains(&(column as usize)))
            };
            let mode = self.modes[i];
            let closed = !mode.is_open();
            let mut uses = Vec::new();
            if reads(0) {
                let upper = if closed { 0.0 } else { f64::INFINITY };
                let name = format!("gap `{}` at the start", contact.name);
                let row = self.program.row_in(units.gap_rows[i], name, 0.0, upper);
                uses.push((row, 0, 1.0));
            }
            if closed && reads(1) {
                let name = format!("normal velocity of `{}` at the start", contact.name);
                let row = self.program.row_in(units.gap_rows[i], name, 0.0, 0.0);
                uses.push((row, 1, 1.0));
            }
            let (q, v) = self.frame.start.split_at(self.n);
            if !uses.is_empty() {
                self.program
                    .block(&Kernel::Contact(i), [q, v, &[], &[]], None, uses);
            }
            let slides = contact.friction.is_some_and(|friction| {
                let mut entries = friction.jacobian.entries.iter();
                entries.any(|&(row, column)| row == 0 && free.contains(&(column as usize)))
            });
            let (sign, upper) = match mode {
                Mode::Slip(direction) => (direction.sign(), f64::INFINITY),
                _ => (1.0, 0.0),
            };
            if slides && matches!(mode, Mode::Stick | Mode::Slip(_)) {
                let name = format!("sliding velocity of `{}` at the start", contact.name);
                let row = self.program.row_in(units.gap_rows[i], name, 0.0, upper);
                let uses = vec![(row, 0, sign)];
                self.program
                    .block(&Kernel::Sliding(i), [q, v, &[], &[]], None, uses);
            }
        }
    }
}
