//! The motions that the page opens with.

use hangtime::ocp::{self, Problem, Settings};
use hangtime::simulation::Simulation;

use super::case::Case;
use crate::animation::Animation;
use crate::bounds::Bounds;
use crate::drawing::Drawing;
use crate::failure::BadInput;
use crate::page::Player;
use crate::settings::{ChosenScene, find};
use crate::table::seconds;
use crate::{OpeningRide, PublishedData, Scene};

/// The motion of a case beside what was published, to play; `None` if nothing moves in a plane.
pub(super) fn player(case: &Case, simulation: &Simulation) -> Option<Player> {
    let published = case.published;
    let caption = format!(
        "{}: computed; rings and dots: published ({})",
        published.title, published.source
    );
    of(&case.chosen, simulation, &case.data, caption)
}

fn of(
    chosen: &ChosenScene,
    simulation: &Simulation,
    published: &PublishedData,
    caption: String,
) -> Option<Player> {
    let model = chosen.model.as_ref();
    let drawing = Drawing::of(model, chosen.scene.name)?;
    Some(Player {
        caption,
        animation: Animation::new(&drawing, model, simulation, published)?,
        result: String::new(),
        plays: true,
    })
}

/// The ride that the program opens with, solved: its motion to play, or a word on why there is none.
pub(super) fn ride(
    scenes: &'static [Scene],
    ride: &OpeningRide,
    bounds: &Bounds,
) -> Result<Result<Player, String>, BadInput> {
    let chosen = ChosenScene::new(find(scenes, ride.scene)?, &[])?;
    let model = chosen.model.as_ref();
    let mut settings = Settings::default();
    settings.starts = Some(ride.starts);
    let problem = Problem::of(model, ride.intervals);
    let solution = ocp::solve(model, &problem, &settings, &mut |_| {
        bounds.asked().is_none()
    })
    .map_err(|error| chosen.refuse(&error))?;
    let name = ride.scene;
    let intervals = ride.intervals;
    let title = chosen.scene.title;
    if !solution.status.is_solved() {
        let status = solution.status.name();
        return Ok(Err(format!(
            "{title} ({name}): {status} on {intervals} control intervals"
        )));
    }
    let caption = format!(
        "{title}: {:.3} s, found on {intervals} control intervals in {} of CPU time",
        solution.horizon,
        seconds(solution.seconds.total)
    );
    let motion = solution.motion.as_ref();
    let player = motion.and_then(|motion| of(&chosen, motion, &PublishedData::default(), caption));
    Ok(player.ok_or_else(|| format!("{title} ({name}): nothing to draw")))
}
