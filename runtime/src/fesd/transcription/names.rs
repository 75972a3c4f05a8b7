//! Names of variables, rows and pairs: what, which element, when.

use super::{
    Element, Interval, Place, Provisions, SUMS, Transcription, conditions, corrections, joints,
    ramps, start,
};

/// Interval `k`, with its physical time if that is known before the solution.
fn interval_name(transcription: &Transcription<'_>, k: usize) -> String {
    if transcription.horizon.is_some() {
        return format!("interval {k}");
    }
    let duration = transcription.task.horizon / transcription.task.intervals as f64;
    let from = transcription.task.start.time + k as f64 * duration;
    format!("interval {k}, {from:.4} to {:.4} s", from + duration)
}

/// Element `e` of the whole motion, as element of its interval.
fn element_name(transcription: &Transcription<'_>, e: usize) -> String {
    let count = transcription.task.elements;
    let interval = interval_name(transcription, e / count);
    format!("element {} of {interval}", e % count)
}

fn contact_name(transcription: &Transcription<'_>, contact: usize) -> &'static str {
    let declaration = transcription.dcs.system.model.declaration();
    declaration
        .contacts
        .get(contact)
        .map_or("contact", |c| c.name)
}

fn control_name(transcription: &Transcription<'_>, control: usize) -> &'static str {
    let controls = transcription.dcs.system.model.declaration().controls;
    controls.get(control).map_or("control", |c| c.name)
}

/// Stage or end of an element.
fn block_name(transcription: &Transcription<'_>, e: usize, block: usize) -> String {
    if transcription.elements[e].blocks[block].boundary {
        format!("the end of {}", element_name(transcription, e))
    } else {
        format!("stage {block} of {}", element_name(transcription, e))
    }
}

/// Local variable `k`, in the words of the model.
fn local_name(transcription: &Transcription<'_>, k: usize) -> String {
    let declaration = transcription.dcs.system.model.declaration();
    let n = transcription.dcs.system.coordinates();
    let coordinate = |k: usize| declaration.coordinates.get(k).map_or("", |c| c.name);
    if k < n {
        return coordinate(k).into();
    }
    if k < 2 * n {
        return format!("dot({})", coordinate(k - n));
    }
    if k == transcription.dcs.layout.time() {
        return "clock".into();
    }
    if let Some(contact) = transcription.dcs.layout.dip_of(k) {
        return format!("dip of {}", contact_name(transcription, contact));
    }
    if k < transcription.dcs.layout.states() {
        return format!(
            "lifted gap of {}",
            contact_name(transcription, k - transcription.dcs.layout.lifted_gap(0))
        );
    }
    let control = k - transcription.dcs.layout.states();
    if control < transcription.dcs.layout.controls() {
        return control_name(transcription, control).into();
    }
    match transcription.dcs.layout.algebraic_symbol(k) {
        Some((symbol, contact)) => format!("{symbol} of {}", contact_name(transcription, contact)),
        None => "product of step functions".into(),
    }
}

/// Symbol and contact of what cross complementarity sum `sum`, counted over all groups, adds up.
fn summed(transcription: &Transcription<'_>, sum: usize) -> (&'static str, usize) {
    let place = transcription.groups[sum / SUMS].places[sum % SUMS];
    transcription
        .dcs
        .layout
        .algebraic_symbol(place)
        .unwrap_or(("", 0))
}

/// A force or an impulse, or a sum over impacts, whose variable and row are those.
fn name_of_provision(
    transcription: &Transcription<'_>,
    own: impl Fn((usize, usize)) -> bool,
) -> Option<String> {
    let Provisions { all, sums, .. } = &transcription.provisions;
    if let Some(k) = sums.iter().position(|&sum| own(sum)) {
        return Some(format!("sum {k} over impacts"));
    }
    let provision = all.iter().find(|p| own((p.variable, p.row)))?;
    let contacts = transcription.contacts();
    let contact = contact_name(transcription, provision.number % contacts);
    let along = if provision.number < contacts {
        ""
    } else {
        "along the sliding velocity "
    };
    Some(match provision.place {
        Place::Stage { element, stage } => {
            let place = block_name(transcription, element, stage);
            format!("force {along}of {contact} at {place}")
        }
        Place::Impact { first } => {
            let place = element_name(transcription, first);
            format!("impulse {along}of {contact} from {place} on")
        }
    })
}

pub(super) fn name_of_variable(transcription: &Transcription<'_>, index: usize) -> String {
    if transcription.horizon == Some(index) {
        return "final time".into();
    }
    if let Some(k) = start::local_of(transcription, index) {
        return format!("{} at the start", local_name(transcription, k));
    }
    if let Some(name) = name_of_provision(transcription, |own| own.0 == index) {
        return name;
    }
    let before = |interval: &Interval| interval.length <= index;
    let k = transcription
        .intervals
        .partition_point(before)
        .saturating_sub(1);
    let interval = &transcription.intervals[k];
    if interval.length == index {
        return format!("numerical length of {}", interval_name(transcription, k));
    }
    if let Some(control) = interval.controls.iter().position(|&c| c == index) {
        let name = control_name(transcription, control);
        let place = if interval.ends.is_empty() {
            "in"
        } else {
            "at the start of"
        };
        return format!("{name} {place} {}", interval_name(transcription, k));
    }
    if let Some(control) = interval.ends.iter().position(|&c| c == index) {
        let name = control_name(transcription, control);
        return format!("{name} at the end of {}", interval_name(transcription, k));
    }
    let before = |element: &Element| element.first <= index;
    let e = transcription
        .elements
        .partition_point(before)
        .saturating_sub(1);
    let element = &transcription.elements[e];
    if element.length == index {
        return format!("length of {}", element_name(transcription, e));
    }
    if let Some(sum) = index.checked_sub(element.sums) {
        let (symbol, contact) = summed(transcription, sum);
        let contact = contact_name(transcription, contact);
        return format!(
            "sum of {symbol} of {contact} in {}",
            element_name(transcription, e)
        );
    }
    if let Some((contact, block)) = corrections::corrected_by(element, index) {
        return format!(
            "correction along {} at {}",
            contact_name(transcription, contact),
            block_name(transcription, e, block)
        );
    }
    for (block, at) in element.blocks.iter().enumerate() {
        if let Some(k) = at.variables.iter().position(|&v| v == Some(index)) {
            return format!(
                "{} at {}",
                local_name(transcription, k),
                block_name(transcription, e, block)
            );
        }
    }
    format!("x[{index}]")
}

pub(super) fn name_of_constraint(transcription: &Transcription<'_>, index: usize) -> String {
    if start::owns_row(transcription, index) {
        return "switching functions at the start".into();
    }
    if let Some(name) = name_of_provision(transcription, |own| own.1 == index) {
        return name;
    }
    if let Some((name, place)) = joints::named(transcription, index) {
        let place = place.map(|(e, block)| block_name(transcription, e, block));
        return format!("{name} at {}", place.as_deref().unwrap_or("the start"));
    }
    let before = |interval: &Interval| interval.rows <= index;
    let k = transcription
        .intervals
        .partition_point(before)
        .saturating_sub(1);
    let interval = || interval_name(transcription, k);
    if let Some(name) = conditions::row_name(transcription, index, interval) {
        return name;
    }
    match index - transcription.intervals[k].rows {
        0 => format!(
            "sum of the element lengths of {}",
            interval_name(transcription, k)
        ),
        1 => format!("clock at the end of {}", interval_name(transcription, k)),
        _ => {
            let before = |element: &Element| element.collocation_rows <= index;
            let e = transcription
                .elements
                .partition_point(before)
                .saturating_sub(1);
            if let Some(control) = ramps::control_of_row(transcription, index) {
                return format!("line of {}", name_of_variable(transcription, control));
            }
            let element = &transcription.elements[e];
            let kind = if index >= element.sum_rows {
                "cross complementarity"
            } else if corrections::owns_row(element, index) {
                "gaps"
            } else if index >= element.blocks[0].algebraic_rows {
                "switching functions"
            } else {
                "collocation"
            };
            format!("{kind} of {}", element_name(transcription, e))
        }
    }
}

pub(super) fn name_of_pair(transcription: &Transcription<'_>, index: usize) -> String {
    let (i, j) = transcription.pairs[index];
    if start::local_of(transcription, i).is_some() {
        let name = |index| name_of_variable(transcription, index);
        return format!("{} _|_ {}", name(i), name(j));
    }
    let before = |element: &Element| element.first <= i;
    let e = transcription
        .elements
        .partition_point(before)
        .saturating_sub(1);
    let element = &transcription.elements[e];
    if let Some(sum) = i.checked_sub(element.sums) {
        let (first, contact) = summed(transcription, sum);
        let (second, _) = summed(transcription, sum + 1);
        let contact = contact_name(transcription, contact);
        return format!(
            "{first} _|_ {second} of {contact} in {}",
            element_name(transcription, e)
        );
    }
    for (block, at) in element.blocks.iter().enumerate() {
        for (first, second) in transcription.dcs.layout.stage_pairs() {
            let symbols = (
                transcription.dcs.layout.algebraic_symbol(first),
                transcription.dcs.layout.algebraic_symbol(second),
            );
            if at.variables[first] == Some(i)
                && let (Some((first, contact)), Some((second, _))) = symbols
            {
                let contact = contact_name(transcription, contact);
                let place = block_name(transcription, e, block);
                return format!("{first} _|_ {second} of {contact} at {place}");
            }
        }
    }
    format!("pair {index}")
}
