//! Data files in CSV, one header line with names and units.

use hangtime::model::{Declaration, Model};
use hangtime::simulation::{Event, Trajectory};

use crate::published::Quantity;
use crate::quantity;
use crate::sampling::State;
use crate::table::{headed, per_second};
use crate::thinning::kept;

/// CSV text of a header and rows.
pub(crate) fn csv_text(
    header: &[impl AsRef<[u8]>],
    rows: impl IntoIterator<Item = Vec<String>>,
) -> String {
    let mut writer = csv::WriterBuilder::new()
        .flexible(true)
        .from_writer(Vec::new());
    // Writing to memory does not fail, and numbers and names are text.
    let _ = writer.write_record(header);
    for row in rows {
        let _ = writer.write_record(row);
    }
    writer
        .into_inner()
        .ok()
        .and_then(|bytes| String::from_utf8(bytes).ok())
        .unwrap_or_default()
}

/// Names of the coordinates and their velocities, with units.
fn state_names(declaration: &Declaration, suffix: &str) -> Vec<String> {
    let coordinates = &declaration.coordinates[..declaration.mechanical()];
    let states = declaration.states.iter();
    let states = states.map(|z| headed(&format!("{}{suffix}", z.name), z.unit));
    let q = coordinates.iter().map(|c| headed(c.name, c.unit));
    let v = coordinates
        .iter()
        .map(|c| headed(&format!("d{}/dt{suffix}", c.name), &per_second(c.unit)));
    q.chain(v).chain(states).collect()
}

/// At most `most` rows of a trajectory.
pub(crate) fn trajectory_csv(model: &dyn Model, trajectory: &Trajectory, most: usize) -> String {
    let declaration = model.declaration();
    let mut header = vec!["time [s]".to_owned(), "numerical time [s]".to_owned()];
    header.extend(state_names(declaration, ""));
    header.extend(declaration.controls.iter().map(|u| headed(u.name, u.unit)));
    let force = |force: fn(usize) -> Quantity| {
        (0..declaration.contacts.len()).map(move |contact| {
            let force = force(contact);
            headed(
                &quantity::symbol(model, force),
                &quantity::unit(model, force),
            )
        })
    };
    header.extend(force(Quantity::ContactForce));
    if !trajectory.friction_force.is_empty() {
        header.extend(force(Quantity::FrictionForce));
    }
    let outputs = model.outputs();
    header.extend(outputs.iter().map(|known| headed(known.name, known.unit)));
    csv_text(
        &header,
        kept(&trajectory.time, most).into_iter().map(|k| {
            [trajectory.time[k], trajectory.numerical_time[k]]
                .iter()
                .chain(&trajectory.q[k][..declaration.mechanical()])
                .chain(&trajectory.v[k])
                .chain(&trajectory.u[k])
                .chain(&trajectory.contact_force[k])
                .chain(trajectory.friction_force.get(k).into_iter().flatten())
                .chain(&State::of(model, trajectory, k).outputs)
                .map(f64::to_string)
                .collect()
        }),
    )
}

/// The events; those that are no impacts have no impulses.
pub(crate) fn events_csv(model: &dyn Model, events: &[Event]) -> String {
    let declaration = model.declaration();
    let mut header: Vec<String> = ["time [s]", "event", "contact"].map(str::to_owned).into();
    header.extend(state_names(declaration, " before"));
    header.extend(state_names(declaration, " after").split_off(declaration.mechanical()));
    let surfaces: Vec<usize> = (0..declaration.contacts.len())
        .filter(|&contact| !declaration.contacts[contact].dry)
        .collect();
    let rubbing = surfaces.iter().copied();
    let rubbing = rubbing.filter(|&contact| declaration.contacts[contact].friction.is_some());
    let rubbing: Vec<usize> = rubbing.collect();
    for (contacts, kind) in [(&surfaces, "impulse"), (&rubbing, "friction impulse")] {
        header.extend(contacts.iter().map(|&contact| {
            let force = quantity::unit(model, Quantity::ContactForce(contact));
            let unit = match force.as_str() {
                "" => String::new(),
                force => format!("{force} s"),
            };
            headed(
                &format!("{kind} {}", declaration.contacts[contact].name),
                &unit,
            )
        }));
    }
    csv_text(
        &header,
        events.iter().map(|event| {
            let names = [
                event.time.to_string(),
                event.kind.name().to_owned(),
                declaration.contacts[event.contact].name.to_owned(),
            ];
            let numbers = event.q[..declaration.mechanical()]
                .iter()
                .chain(&event.v_before)
                .chain(&event.v_after)
                .map(f64::to_string);
            let impulses = [
                (&surfaces, &event.contact_impulse),
                (&rubbing, &event.friction_impulse),
            ];
            let impulses = impulses.into_iter().flat_map(|(contacts, values)| {
                contacts
                    .iter()
                    .map(|&contact| values.get(contact).map_or(String::new(), f64::to_string))
            });
            names.into_iter().chain(numbers).chain(impulses).collect()
        }),
    )
}
