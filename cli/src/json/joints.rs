//! Joints of a simulation: their forces in the rows of the trajectory.

use hangtime::model::Model;
use hangtime::simulation::{Trajectory, joint_forces};
use serde::{Serialize, Serializer};

use super::columns::kept_instants;

/// All joints by name, in order of declaration.
pub(super) struct JointsEntry {
    joints: Vec<(&'static str, Forces)>,
}

/// The force of a joint in each row: a number, or as many as it has equations.
#[derive(Serialize)]
struct Forces {
    /// Its force at each instant: a number, or as many as it has equations.
    force: Vec<Force>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Force {
    One(f64),
    Many(Vec<f64>),
}

impl JointsEntry {
    /// None for a scene without joints.
    pub(super) fn of(model: &dyn Model, trajectory: &Trajectory, most: usize) -> Option<Self> {
        let declared = model.declaration().joints?;
        let lists = declared.list.iter();
        let mut joints: Vec<(&'static str, Forces)> = lists
            .map(|joint| (joint.name, Forces { force: Vec::new() }))
            .collect();
        for k in kept_instants(trajectory, most) {
            let mut x = [&trajectory.q[k][..], &trajectory.v[k], &trajectory.u[k]].concat();
            x.push(trajectory.time[k]);
            let rubs = trajectory.friction_force.get(k).map_or(&[][..], |row| row);
            let forces = joint_forces(model, &x, &trajectory.contact_force[k], rubs);
            let mut rest = &forces[..];
            for (joint, (_, own)) in declared.list.iter().zip(&mut joints) {
                let (of_joint, others) = rest.split_at(joint.rows);
                rest = others;
                own.force.push(match of_joint {
                    [force] => Force::One(*force),
                    forces => Force::Many(forces.to_vec()),
                });
            }
        }
        Some(Self { joints })
    }
}

impl Serialize for JointsEntry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeMap as _;
        let mut map = serializer.serialize_map(Some(self.joints.len()))?;
        for (name, forces) in &self.joints {
            map.serialize_entry(name, forces)?;
        }
        map.end()
    }
}
