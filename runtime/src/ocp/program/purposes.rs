//! What the variables and rows of a program are there for, from their names.

use hangtime_solver::mpcc::Mpcc as _;
use hangtime_solver::nlp::NlpProblem as _;

use crate::model::Declaration;
use crate::program::sparse_program::Program;
use crate::size::{Purpose, SizeGroup, groups_of};
use crate::time_freezing::transcription::Transcription;

/// Beginnings of the names of variables and rows, without the names that the scene gives.
const BEGINNINGS: [(&str, Purpose); 34] = [
    ("final time", Purpose::FinalTime),
    ("initial ", Purpose::FreeStart),
    ("time ", Purpose::ExplicitTime),
    ("share of interval", Purpose::Control),
    ("drive ", Purpose::Control),
    ("motion of", Purpose::State),
    ("force on", Purpose::State),
    ("collocation of", Purpose::State),
    ("force of", Purpose::ContactForce),
    ("joint `", Purpose::Joint),
    ("velocity of joint", Purpose::Joint),
    ("normal velocity of", Purpose::ContactForce),
    ("correction of", Purpose::Gap),
    ("gap `", Purpose::Gap),
    ("provided ", Purpose::ForceTerm),
    ("sum ", Purpose::ForceTerm),
    ("friction", Purpose::Friction),
    ("sliding", Purpose::Friction),
    ("cone", Purpose::Friction),
    ("slip of", Purpose::Friction),
    ("length of", Purpose::SwitchTime),
    ("opening of", Purpose::SwitchTime),
    ("set of", Purpose::SwitchTime),
    ("departure of", Purpose::SwitchTime),
    ("touch of", Purpose::SwitchTime),
    ("impact o", Purpose::Impact),
    ("impact law of", Purpose::Impact),
    ("impulse of", Purpose::Impact),
    ("control point", Purpose::Bound),
    ("product ", Purpose::Bound),
    ("extremum ", Purpose::Bound),
    ("size ", Purpose::Bound),
    ("alpha ", Purpose::Bound),
    ("beta ", Purpose::Bound),
];

/// What a variable or row is there for.
fn purpose(name: &str, declaration: &Declaration) -> Purpose {
    let known = BEGINNINGS.iter().find(|(words, _)| name.starts_with(words));
    if let Some(&(_, purpose)) = known {
        return purpose;
    }
    // What is left begins with a name of the scene.
    let mut parts = name.splitn(3, '`');
    let (Some(_), Some(own), Some(place)) = (parts.next(), parts.next(), parts.next()) else {
        return Purpose::Other;
    };
    if declaration
        .controls
        .iter()
        .any(|control| control.name == own)
    {
        return Purpose::Control;
    }
    if declaration
        .coordinates
        .iter()
        .any(|known| known.name == own)
    {
        return match place {
            place if place.contains("after the impact") => Purpose::Impact,
            place if place.contains("between the stages") => Purpose::Bound,
            _ => Purpose::State,
        };
    }
    Purpose::PathConstraint
}

/// What a row is there for: its name may begin with that of a condition that the scene declares.
fn purpose_of_row(name: &str, declaration: &Declaration) -> Purpose {
    let goals = declaration
        .optimal_control
        .map_or(&[][..], |task| task.goals);
    let is_goal = |own: &str| goals.iter().any(|goal| goal.name == own);
    if let Some(rest) = name.strip_prefix('`') {
        // What a scene declares may hold any characters, so the name is what stands before the place.
        return match rest.strip_suffix("` at the end") {
            Some(own) if is_goal(own) => Purpose::Goal,
            _ => purpose(name, declaration),
        };
    }
    purpose(name, declaration)
}

/// The groups of a program.
pub(in crate::ocp) fn groups(program: &Program, declaration: &Declaration) -> Vec<SizeGroup> {
    groups_of(
        program,
        program.complementarities(),
        &|index| purpose(program.name(index), declaration),
        &|index| purpose_of_row(&program.constraint_name(index), declaration),
    )
}

/// The groups of a program of the time-freezing system, whose own variables and rows tell what they are there for.
pub(in crate::ocp) fn groups_of_step_form(
    own: &Transcription<'_>,
    declaration: &Declaration,
) -> Vec<SizeGroup> {
    let program = &own.program;
    let of_variable = |index| purpose(program.name(index), declaration);
    let of_row = |index| purpose_of_row(&program.constraint_name(index), declaration);
    groups_of(
        program,
        program.complementarities(),
        &|index| {
            own.purpose_of_variable(index)
                .unwrap_or_else(|| of_variable(index))
        },
        &|index| own.purpose_of_row(index).unwrap_or_else(|| of_row(index)),
    )
}
