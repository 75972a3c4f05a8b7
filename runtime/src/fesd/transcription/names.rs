//! Names of variables, rows and pairs: what, which element, when.

use super::{Element, Interval, SUMS, Transcription};

impl Transcription<'_> {
    /// Interval `k`, with its physical time if that is known before the solution.
    fn interval_name(&self, k: usize) -> String {
        if self.horizon.is_some() {
            return format!("interval {k}");
        }
        let duration = self.task.horizon / self.task.intervals as f64;
        let from = self.task.start.time + k as f64 * duration;
        format!("interval {k}, {from:.4} to {:.4} s", from + duration)
    }

    /// Element `e` of the whole motion, as element of its interval.
    fn element_name(&self, e: usize) -> String {
        let count = self.task.elements;
        let interval = self.interval_name(e / count);
        format!("element {} of {interval}", e % count)
    }

    fn contact_name(&self, contact: usize) -> &'static str {
        let declaration = self.dcs.system.model.declaration();
        declaration
            .contacts
            .get(contact)
            .map_or("contact", |c| c.name)
    }

    /// Stage or end of an element.
    fn block_name(&self, e: usize, block: usize) -> String {
        if self.elements[e].blocks[block].boundary {
            format!("the end of {}", self.element_name(e))
        } else {
            format!("stage {block} of {}", self.element_name(e))
        }
    }

    /// Local variable `k`, in the words of the model.
    fn local_name(&self, k: usize) -> String {
        let declaration = self.dcs.system.model.declaration();
        let n = self.dcs.system.coordinates();
        let coordinate = |k: usize| declaration.coordinates.get(k).map_or("", |c| c.name);
        if k < n {
            return coordinate(k).into();
        }
        if k < 2 * n {
            return format!("dot({})", coordinate(k - n));
        }
        if k == self.dcs.layout.time() {
            return "clock".into();
        }
        if k < self.dcs.layout.states() {
            return format!(
                "lifted gap of {}",
                self.contact_name(k - self.dcs.layout.lifted_gap(0))
            );
        }
        match self.dcs.layout.algebraic_symbol(k) {
            Some((symbol, contact)) => format!("{symbol} of {}", self.contact_name(contact)),
            None => "product of step functions".into(),
        }
    }

    /// Symbol and contact of what cross complementarity sum `sum`, counted over all groups, adds up.
    fn summed(&self, sum: usize) -> (&'static str, usize) {
        let place = self.groups[sum / SUMS].places[sum % SUMS];
        self.dcs.layout.algebraic_symbol(place).unwrap_or(("", 0))
    }

    pub(super) fn name_of_variable(&self, index: usize) -> String {
        if self.horizon == Some(index) {
            return "final time".into();
        }
        let before = |interval: &Interval| interval.length <= index;
        let k = self.intervals.partition_point(before).saturating_sub(1);
        let interval = &self.intervals[k];
        if interval.length == index {
            return format!("numerical length of {}", self.interval_name(k));
        }
        if let Some(control) = interval.controls.iter().position(|&c| c == index) {
            let controls = self.dcs.system.model.declaration().controls;
            let name = controls.get(control).map_or("control", |c| c.name);
            return format!("{name} in {}", self.interval_name(k));
        }
        let before = |element: &Element| element.length <= index;
        let e = self.elements.partition_point(before).saturating_sub(1);
        let element = &self.elements[e];
        if element.length == index {
            return format!("length of {}", self.element_name(e));
        }
        if let Some(sum) = index.checked_sub(element.sums) {
            let (symbol, contact) = self.summed(sum);
            let contact = self.contact_name(contact);
            return format!("sum of {symbol} of {contact} in {}", self.element_name(e));
        }
        for (block, at) in element.blocks.iter().enumerate() {
            if let Some(k) = at.variables.iter().position(|&v| v == Some(index)) {
                return format!("{} at {}", self.local_name(k), self.block_name(e, block));
            }
        }
        format!("x[{index}]")
    }

    pub(super) fn name_of_constraint(&self, index: usize) -> String {
        if index >= self.goal_rows {
            return format!("goal {}", index - self.goal_rows);
        }
        let before = |interval: &Interval| interval.rows <= index;
        let k = self.intervals.partition_point(before).saturating_sub(1);
        match index - self.intervals[k].rows {
            0 => format!("sum of the element lengths of {}", self.interval_name(k)),
            1 => format!("clock at the end of {}", self.interval_name(k)),
            _ => {
                let before = |element: &Element| element.collocation_rows <= index;
                let e = self.elements.partition_point(before).saturating_sub(1);
                let element = &self.elements[e];
                let kind = if index >= element.sum_rows {
                    "cross complementarity"
                } else if index >= element.blocks[0].algebraic_rows {
                    "switching functions"
                } else {
                    "collocation"
                };
                format!("{kind} of {}", self.element_name(e))
            }
        }
    }

    pub(super) fn name_of_pair(&self, index: usize) -> String {
        let (i, _) = self.pairs[index];
        let before = |element: &Element| element.length <= i;
        let e = self.elements.partition_point(before).saturating_sub(1);
        let element = &self.elements[e];
        if let Some(sum) = i.checked_sub(element.sums) {
            let (first, contact) = self.summed(sum);
            let (second, _) = self.summed(sum + 1);
            let contact = self.contact_name(contact);
            return format!(
                "{first} _|_ {second} of {contact} in {}",
                self.element_name(e)
            );
        }
        for (block, at) in element.blocks.iter().enumerate() {
            for (first, second) in self.dcs.layout.stage_pairs() {
                let symbols = (
                    self.dcs.layout.algebraic_symbol(first),
                    self.dcs.layout.algebraic_symbol(second),
                );
                if at.variables[first] == Some(i)
                    && let (Some((first, contact)), Some((second, _))) = symbols
                {
                    let contact = self.contact_name(contact);
                    let place = self.block_name(e, block);
                    return format!("{first} _|_ {second} of {contact} at {place}");
                }
            }
        }
        format!("pair {index}")
    }
}
