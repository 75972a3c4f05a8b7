//! `hangtime solve`: the optimal control problem of a scene.

use super::Report;
use super::arguments::SolveArguments;
use super::failure::BadInput;
use super::settings::ChosenScene;

pub(super) fn run(arguments: &SolveArguments) -> Result<Report, BadInput> {
    let chosen = ChosenScene::from_arguments(&arguments.scene)?;
    Err(BadInput::new(format!(
        "scene `{0}` declares no objective, so there is nothing to optimize; run `hangtime \
         simulate {0}` instead",
        chosen.scene.name
    )))
}
