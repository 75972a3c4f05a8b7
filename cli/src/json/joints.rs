//! Joints of a simulation: their forces in the rows of the trajectory.

use hangtime::model::Model;
use hangtime::simulation::{Trajectory, joint_forces};
use serde_json::{Value, json};

use super::columns::kept_instants;
use super::parts::Object;

/// By joint, in order of declaration, its force at each instant: a number, or as many as it has equations. None for a scene without
/// joints.
pub(super) fn joints(model: &dyn Model, trajectory: &Trajectory, most: usize) -> Option<Object> {
    let declared = model.declaration().joints?.list;
    let mut forces: Vec<Vec<Value>> = vec![Vec::new(); declared.len()];
    for k in kept_instants(trajectory, most) {
        let mut x = [&trajectory.q[k][..], &trajectory.v[k], &trajectory.u[k]].concat();
        x.push(trajectory.time[k]);
        let rubs = trajectory.friction_force.get(k).map_or(&[][..], |row| row);
        let all = joint_forces(model, &x, &trajectory.contact_force[k], rubs);
        let mut rest = &all[..];
        for (joint, own) in declared.iter().zip(&mut forces) {
            let (of_joint, others) = rest.split_at(joint.rows);
            rest = others;
            own.push(match of_joint {
                [force] => json!(force),
                forces => json!(forces),
            });
        }
    }
    let by_name = declared.iter().zip(forces);
    Some(by_name.fold(Object::default(), |all, (joint, forces)| {
        // Its force at each instant: a number, or as many as it has equations.
        all.with(joint.name, Object::default().with("force", forces))
    }))
}
