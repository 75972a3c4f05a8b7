//! How good the best motion is that is known so far, over the CPU time of a search.

use hangtime::ocp::Solution;

use crate::figure::{Curve, Dot, LogLog, Look};
use crate::page::Figure;
use crate::table::seconds;

/// Objectives count as reached where they are above the best one by at most this share of it: the tolerance of the programs.
pub(crate) const REACHED: f64 = 1e-6;

/// A search and its improvements.
pub(crate) struct Search {
    /// What it is called.
    pub(crate) name: String,
    /// How its line looks.
    pub(crate) look: Look,
    /// CPU time [s] and objective of the first motion and of every better one, in order.
    pub(crate) found: Vec<(f64, f64)>,
    /// CPU time of the whole search [s].
    pub(crate) end: f64,
}

impl Search {
    /// The search that ended with a solution.
    pub(crate) fn of(name: String, look: Look, solution: &Solution) -> Self {
        let improvements = solution.improvements.iter();
        Self {
            name,
            look,
            found: improvements
                .map(|found| (found.cpu, found.objective))
                .collect(),
            end: solution.seconds.total,
        }
    }

    /// The objective of its best motion.
    pub(crate) fn best(&self) -> Option<f64> {
        self.found.last().map(|&(_, objective)| objective)
    }

    /// CPU time after which it is within [`REACHED`] of an objective [s].
    pub(crate) fn reaches(&self, objective: f64) -> Option<f64> {
        let near = |&&(_, found): &&(f64, f64)| found - objective <= tolerated(objective);
        self.found.iter().find(near).map(|&(cpu, _)| cpu)
    }
}

fn tolerated(objective: f64) -> f64 {
    REACHED * objective.abs().max(f64::MIN_POSITIVE)
}

/// Steps down to the best objective, over CPU time; what is within [`REACHED`] of it is shaded.
pub(crate) fn figure(title: &str, searches: &[Search], best: f64) -> Figure {
    let curves = searches.iter().map(|search| {
        let point = |x: f64, objective: f64, what: &str| Dot {
            x,
            // Nothing is to be seen far below the tolerance.
            y: (objective - best).max(0.1 * tolerated(best)),
            half: None,
            note: format!("{}: {what} {objective} after {}", search.name, seconds(x)),
        };
        let found = search.found.iter();
        let found = found.map(|&(cpu, objective)| point(cpu, objective, "objective"));
        let end = search
            .best()
            .map(|best| point(search.end, best, "ended with"));
        Curve {
            name: search.name.clone(),
            look: search.look,
            steps: true,
            points: found.chain(end).collect(),
        }
    });
    Figure::chart(&LogLog {
        title,
        x: "CPU time [s]",
        y: "best objective so far, above the best known",
        falling: false,
        floor: Some((tolerated(best), "within the tolerance of the programs")),
        curves: curves.collect(),
    })
}

/// Who has the best objective first, what the first one of the list takes, and how far the others stay away.
pub(crate) fn reading(searches: &[Search], best: f64) -> String {
    let mut there: Vec<(&Search, f64)> = searches
        .iter()
        .filter_map(|search| Some((search, search.reaches(best)?)))
        .collect();
    there.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut words = match there.first() {
        Some((search, cpu)) => format!(
            "The best objective known here, {best:.7}, is there first by {}, after {}",
            search.name,
            seconds(*cpu)
        ),
        None => format!("The best objective known here, {best:.7}, is found by none of these"),
    };
    if let Some(default) = searches.first() {
        let name = &default.name;
        let first = default.found.first();
        if let Some((cpu, objective)) =
            first.filter(|(_, objective)| *objective > best + tolerated(best))
        {
            let above = share(objective - best, best);
            words += &format!(
                "; {name} has a first motion after {}, {above} above it",
                seconds(*cpu)
            );
        }
        match default.reaches(best) {
            Some(cpu) if there[0].0.name != *name => {
                words += &format!("; {name} has it after {}", seconds(cpu));
            }
            _ => {}
        }
    }
    let far: Vec<String> = searches
        .iter()
        .filter(|search| search.reaches(best).is_none())
        .map(|search| match search.best() {
            Some(own) => format!("{} stays {} above it", search.name, share(own - best, best)),
            None => format!("{} finds no motion", search.name),
        })
        .collect();
    for far in far {
        words += "; ";
        words += &far;
    }
    words + "."
}

/// A difference as a share of an objective, in percent; the difference itself where the objective vanishes.
fn share(difference: f64, objective: f64) -> String {
    if objective == 0.0 {
        return format!("{difference:.1e}");
    }
    let percent = 100.0 * difference / objective.abs();
    if percent < 0.01 {
        format!("{percent:.0e} %")
    } else {
        format!("{percent:.2} %")
    }
}

#[cfg(test)]
mod tests {
    use super::{Search, figure, reading};
    use crate::figure::Look;

    fn search(name: &str, found: &[(f64, f64)], end: f64) -> Search {
        Search {
            name: name.to_owned(),
            look: Look::of(name),
            found: found.to_vec(),
            end,
        }
    }

    #[test]
    fn sentence_names_the_first_to_the_best_and_how_far_others_stay() {
        let searches = [
            search("phases", &[(0.5, 2.2), (3.0, 2.0)], 4.0),
            search("one start", &[(0.25, 2.0 + 1e-7)], 0.5),
            search("time-freezing", &[(1.0, 2.01)], 9.0),
            search("other", &[], 1.0),
        ];
        assert_eq!(
            reading(&searches, 2.0),
            "The best objective known here, 2.0000000, is there first by one start, after 250.0 ms; phases has a first motion after \
             500.0 ms, 10.00 % above it; phases has it after 3.00 s; time-freezing stays 0.50 % above it; other finds no motion."
        );
        let svg = figure("x", &searches, 2.0).svg().to_owned();
        // Level steps, from the first motion to the end of the search.
        assert_eq!(svg.matches("stroke-linejoin=\"round\"").count(), 3);
        assert!(svg.contains("ended with 2.01 after 9.00 s"));
    }
}
