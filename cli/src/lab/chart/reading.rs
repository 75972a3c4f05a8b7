//! What to read off a chart of errors over CPU time, in one sentence that is made of its points.

use super::measure::Measured;
use super::sweep::{CONTROLLED, Group};
use crate::table::seconds;

/// The error at which methods are compared, where the reference is known better than that and the default method gets there.
const COMPARED: f64 = 1e-6;
/// Errors have to be this many times the uncertainty of what they are measured against, to be compared.
const CERTAIN: f64 = 10.0;
/// Most methods of which it is told that they do not get there.
const MOST_NAMED: usize = 3;

/// Who is first at which error, what the default takes and the fastest other program, and who does not get there. `unit` is that of
/// errors, if they have one.
pub(super) fn reading(measured: &[Measured], uncertainty: f64, unit: Option<&str>) -> String {
    let charted: Vec<&Measured> = measured.iter().filter(|line| line.sweep.charted).collect();
    let Some(target) = compared(&charted, uncertainty) else {
        return "No run of any method solved.".to_owned();
    };
    let mut there: Vec<(&Measured, f64)> = charted
        .iter()
        .filter_map(|line| Some((*line, line.cheapest(target)?.seconds)))
        .collect();
    there.sort_by(|a, b| a.1.total_cmp(&b.1));
    let Some(&(first, least)) = there.first() else {
        return "No run of any method solved.".to_owned();
    };
    let error = format!(
        "{target:.0e}{}",
        unit.map_or_else(String::new, |unit| format!(" {unit}"))
    );
    let mut words = format!(
        "At an error of {error}, {} is there first, after {}",
        first.sweep.name,
        seconds(least)
    );
    let is_peer = |line: &Measured| line.sweep.group == Group::Peers;
    let slowest = there.last().filter(|_| there.len() > 2);
    let others = [
        (
            "",
            there.iter().find(|(line, _)| line.sweep.name == CONTROLLED),
        ),
        (
            "of other programs, ",
            there.iter().find(|(line, _)| is_peer(line)),
        ),
        ("the last one, ", slowest),
    ];
    let mut told = vec![&first.sweep.name];
    for (what, line) in others {
        let Some((line, time)) = line.filter(|(line, _)| !told.contains(&&line.sweep.name)) else {
            continue;
        };
        told.push(&line.sweep.name);
        words += &format!(
            "; {what}{} takes {}, {} times as long",
            line.sweep.name,
            seconds(*time),
            ratio(time / least)
        );
    }
    words + &missing(&charted, target) + "."
}

/// The least error at which the default, or else any method, can be compared: a power of ten.
fn compared(charted: &[&Measured], uncertainty: f64) -> Option<f64> {
    let least = |line: &&&Measured| {
        let errors = line.solved().map(|point| point.error);
        errors.fold(f64::INFINITY, f64::min)
    };
    let default = charted.iter().find(|line| line.sweep.name == CONTROLLED);
    let own = default.iter().map(least).fold(f64::INFINITY, f64::min);
    let least = if own.is_finite() {
        own
    } else {
        charted
            .iter()
            .map(|line| least(&line))
            .fold(f64::INFINITY, f64::min)
    };
    let floor = least.max(CERTAIN * uncertainty).max(COMPARED);
    // A power of ten that is written as one has no rounding error above it.
    floor
        .is_finite()
        .then(|| 10.0_f64.powi((floor.log10() - 1e-9).ceil() as i32))
}

/// Who does not get there, and how near.
fn missing(charted: &[&Measured], target: f64) -> String {
    let mut missing: Vec<(&str, f64)> = charted
        .iter()
        .filter(|line| line.cheapest(target).is_none() && line.solved().next().is_some())
        .map(|line| {
            let errors = line.solved().map(|point| point.error);
            (&*line.sweep.name, errors.fold(f64::INFINITY, f64::min))
        })
        .collect();
    if missing.is_empty() {
        return String::new();
    }
    missing.sort_by(|a, b| a.1.total_cmp(&b.1));
    let named = missing.iter().take(MOST_NAMED);
    let names: Vec<String> = named
        .map(|(name, error)| format!("{name} ({error:.0e})"))
        .collect();
    let others = missing.len().saturating_sub(MOST_NAMED);
    let others = if others > 0 {
        format!(" and {others} more")
    } else {
        String::new()
    };
    format!(
        "; not as near with the settings tried: {}{others}",
        names.join(", ")
    )
}

/// A ratio with the digits that it is good for.
fn ratio(value: f64) -> String {
    format!("{value:.*}", usize::from(value < 9.95))
}

#[cfg(test)]
mod tests {
    use super::reading;
    use crate::figure::Look;
    use crate::lab::chart::measure::{Measured, Order, Point};
    use crate::lab::chart::sweep::{CONTROLLED, Group, Sweep};

    fn line(name: &str, group: Group, points: &[(f64, f64)]) -> Measured {
        let points = points.iter().map(|&(error, seconds)| Point {
            arguments: String::new(),
            grain: f64::NAN,
            error,
            seconds,
            half: seconds,
            counts: None,
            status: "solved",
        });
        Measured {
            sweep: Sweep {
                name: name.to_owned(),
                look: Look::of(name),
                charted: true,
                group,
                compared: true,
                theory: String::new(),
                settings: Vec::new(),
            },
            points: points.collect(),
            order: Order::Unknown,
        }
    }

    #[test]
    fn sentence_names_who_is_first_what_others_take_and_who_is_not_there() {
        let lines = [
            line("a", Group::Others, &[(1e-2, 1e-4), (5e-7, 2e-3)]),
            line(CONTROLLED, Group::Others, &[(1e-7, 3e-3), (1e-9, 9e-3)]),
            line("c", Group::Peers, &[(1e-6, 0.25)]),
            line("d", Group::Peers, &[(3e-4, 1.0)]),
        ];
        let words = reading(&lines, 1e-12, Some("m"));
        assert_eq!(
            words,
            "At an error of 1e-6 m, a is there first, after 2.0 ms; finite elements (default) takes 3.0 ms, 1.5 times as long; \
             of other programs, c takes 250.0 ms, 125 times as long; not as near with the settings tried: d (3e-4)."
        );
        // Where the reference is known to 1e-5, nothing is said below 1e-4.
        assert!(reading(&lines, 1e-5, None).starts_with("At an error of 1e-4, a is there first"));
        assert_eq!(reading(&[], 0.0, None), "No run of any method solved.");
        // The default gets to 1e-3 only.
        let rough = [line(CONTROLLED, Group::Others, &[(1e-3, 1e-3)])];
        let words = reading(&rough, 0.0, None);
        assert_eq!(
            words,
            "At an error of 1e-3, finite elements (default) is there first, after 1.0 ms."
        );
    }
}
