//! One control interval: what switches at its start, its phases, and the bounds over the whole of it.

use super::builder::Builder;
use super::discretization::{Lengths, Span};
use super::impact_map::Instant;
use super::layout::{Distance, Kept};
use super::phase::Element;
use super::stage_inputs::Elapsed;
use super::turns::Turns;
use super::{impact_map, interval_bounds, phase, start_conditions};
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::mode::is_condition;
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::simulation::ContactMode;

/// Least distance of a guessed switch from the ends of its interval and from other switches, relative to the length
/// of the interval.
const GUESS_MARGIN: f64 = 0.02;

/// Shortest phase relative to its interval: in a phase of no length the contact forces are undetermined.
const SHORTEST: f64 = 2e-3;

/// Shortest interval of free length without a switch inside, relative to the length of all if they were equal.
const SHORTEST_INTERVAL: f64 = 0.1;

/// What the switches at the end of a phase ask of it.
#[derive(Default)]
struct Ended {
    /// Contacts that close or are touched.
    closing: Vec<usize>,
    /// Contacts that take over from one that opens.
    taking: Vec<usize>,
    /// Pieces of edges that act from there on.
    passed: Vec<usize>,
}

/// What the switches before a phase leave to it.
#[derive(Default)]
struct Left {
    /// Contacts that open.
    opened: Vec<usize>,
    /// Contacts that are touched.
    touched: Vec<usize>,
    turns: Turns,
}

impl Left {
    /// Adds what the switches of an instant leave; `jumps` where the controls may jump between intervals.
    fn add(&mut self, instant: &Instant, modes: &[ContactMode], jumps: bool) {
        for switch in instant.all() {
            if switch.closes && !instant.first.closes {
                // What takes over slides on as before.
                continue;
            }
            let before = modes[switch.contact];
            if switch.sets {
                // What is set decides how its function goes on, which may jump.
                continue;
            }
            self.turns
                .start(switch, before, instant.first.closes, jumps);
        }
        self.touched.extend(instant.touched());
        let landing = instant.all().filter(|switch| switch.stays());
        self.turns
            .landed
            .extend(landing.map(|switch| switch.contact));
        if instant.first.opens() && !instant.ends_at_edge() {
            self.opened.push(instant.first.contact);
        }
    }
}

/// Adds the phases of an interval and its bounds.
pub(super) fn add(builder: &mut Builder, interval: usize, switches: &[Switch]) {
    let jumps = builder.setting.shape == ControlShape::Constant;
    let mut before = builder.state.clone();
    let mut left = switch_at_start(builder, interval, switches, &mut before);
    let inside: Vec<usize> = instants(switches, interval, Place::Inside).collect();
    let ends = guessed_ends(interval, switches, &inside);
    let durations = durations(builder, interval, &ends);
    let intervals = builder.setting.problem.intervals;
    let parts = builder.setting.ends(interval, builder.elements[interval]);
    let (elements, count) = (parts.len(), ends.len());
    let parts = [vec![0.0], parts].concat();
    let mut elapsed = Elapsed::none(builder.frame.horizon, intervals);
    let mut begin = 0.0;
    for (p, &end) in ends.iter().enumerate() {
        let (scale, factor) = match durations.get(p) {
            Some(&duration) => duration,
            None => (builder.frame.horizon, 1.0 / intervals as f64),
        };
        let (from, to) = (
            builder.guessed_time(interval, begin),
            builder.guessed_time(interval, end),
        );
        left.turns.finishing = interval + 1 == intervals && p + 1 == count;
        let ending = inside.get(p).copied();
        let ended = switch_at_end(builder, interval, switches, ending, &mut left.turns);
        for e in 0..elements {
            let (first, last) = (e == 0, e + 1 == elements);
            let time = |e: usize| from + parts[e] * (to - from);
            let factor = match builder.setting.mesh {
                Some(_) => factor * (parts[e + 1] - parts[e]),
                None => factor / elements as f64,
            };
            let element = Element {
                interval,
                index: (p * elements + e, count * elements),
                scale,
                factor,
                elapsed: &elapsed,
                from: time(e),
                to: time(e + 1),
                ends_with: ending.filter(|_| last),
                closing: if last { &ended.closing } else { &[] },
                taking: if last { &ended.taking } else { &[] },
                passed: if last { &ended.passed } else { &[] },
                opened: if first { &left.opened } else { &[] },
                touched: if first { &left.touched } else { &[] },
                turns: &left.turns.of_element(first, last),
            };
            phase::add(builder, &element);
            elapsed = elapsed.later(scale, factor);
        }
        left = Left::default();
        if let Some(index) = ending {
            let instant = Instant::at(switches, index);
            left.add(&instant, &builder.modes, jumps);
            if instant.first.closes {
                let label = format!("interval {interval}, phase {p}");
                impact_map::close(builder, &instant, &label, to);
            } else {
                impact_map::let_go(builder, &instant);
            }
        }
        begin = end;
    }
    let whole = match builder.setting.lengths {
        Lengths::Phases(_) => durations[0],
        Lengths::Equal | Lengths::Free => (builder.frame.horizon, 1.0 / intervals as f64),
    };
    interval_bounds::add(builder, interval, &before, whole);
}

/// Indices of the first switches of the instants at a place of an interval.
fn instants(
    switches: &[Switch],
    interval: usize,
    place: Place,
) -> impl Iterator<Item = usize> + '_ {
    let here = move |s: &Switch| s.interval == interval && s.place == place && !s.accompanies;
    (0..switches.len()).filter(move |&index| here(&switches[index]))
}

/// Goes through the switches at the start of an interval; `before` becomes the state after the last impact there.
fn switch_at_start(
    builder: &mut Builder,
    interval: usize,
    switches: &[Switch],
    before: &mut Vec<usize>,
) -> Left {
    let jumps = builder.setting.shape == ControlShape::Constant;
    let mut left = Left::default();
    if interval == 0 {
        left.turns.pulled = start_conditions::pulled(builder);
    }
    for index in instants(switches, interval, Place::Start) {
        let instant = Instant::at(switches, index);
        left.add(&instant, &builder.modes, jumps);
        if instant.first.closes {
            let time = match builder.setting.lengths {
                Lengths::Phases(_) => builder.guessed_time(interval, 0.0),
                Lengths::Equal | Lengths::Free => {
                    let share = 1.0 / builder.setting.problem.intervals as f64;
                    builder.guess.horizon * interval as f64 * share
                }
            };
            let label = format!("interval {}", interval - 1);
            impact_map::close(builder, &instant, &label, time);
            before.clone_from(&builder.state);
        } else if jumps {
            impact_map::enter(builder, &instant);
            before.clone_from(&builder.state);
        } else {
            // Controls that do not jump let go of a contact where its force vanishes.
            impact_map::let_go(builder, &instant);
        }
    }
    left
}

/// What happens at the end of a phase, with the switch `ending` or at the start of the next interval; to contacts with
/// friction it is added to `turns`.
fn switch_at_end(
    builder: &Builder,
    interval: usize,
    switches: &[Switch],
    ending: Option<usize>,
    turns: &mut Turns,
) -> Ended {
    let jumps = builder.setting.shape == ControlShape::Constant;
    let ends = |index: usize, switch: &Switch| match ending {
        Some(first) => {
            let companions = Sequence::companions(switches, first).len();
            (first..=first + companions).contains(&index)
        }
        None => switch.interval == interval + 1 && switch.place == Place::Start,
    };
    let (mut ended, mut impact) = (Ended::default(), false);
    for (index, switch) in switches.iter().enumerate() {
        impact =
            switch.closes && !Sequence::takes_over(switches, index) || impact && switch.accompanies;
        if !ends(index, switch) {
            continue;
        }
        if Sequence::takes_over(switches, index) {
            ended.taking.push(switch.contact);
        } else if switch.closes {
            ended.closing.push(switch.contact);
        } else if switch.passes {
            ended.passed.push(switch.contact);
        } else if impact && is_condition(builder.setting.model, switch.contact) {
            turns.stopping.push(switch.contact);
        } else if !impact && !Sequence::ends_at_edge(switches, index) {
            turns.end(switch, builder.modes[switch.contact], jumps);
        }
    }
    ended
}

/// Ends of the phases of an interval in the guess, as shares of it: the switches `inside`, kept apart.
fn guessed_ends(interval: usize, switches: &[Switch], inside: &[usize]) -> Vec<f64> {
    let count = inside.len() + 1;
    let margin = GUESS_MARGIN.min(0.5 / count as f64);
    let mut ends: Vec<f64> = Vec::with_capacity(count);
    for (p, &index) in inside.iter().enumerate() {
        let before = ends.last().copied().unwrap_or(0.0);
        let least = before + margin;
        let most = 1.0 - (count - 1 - p) as f64 * margin;
        ends.push(
            (switches[index].time - interval as f64)
                .max(least)
                .min(most),
        );
    }
    ends.push(1.0);
    ends
}

/// Adds the lengths of the phases of an interval, as a variable and a factor, which make it up; empty where it is one phase of the length
/// of all intervals.
fn durations(builder: &mut Builder, interval: usize, ends: &[f64]) -> Vec<(usize, f64)> {
    if let Some((span, place)) = builder.setting.lengths.span(interval) {
        return vec![duration_of(builder, interval, span, place)];
    }
    let count = ends.len();
    let free = builder.setting.lengths == Lengths::Free;
    if count == 1 && !free {
        return Vec::new();
    }
    let (share, length) = (
        1.0 / builder.setting.problem.intervals as f64,
        builder.interval_length(),
    );
    let (program, horizon) = (&mut builder.program, builder.frame.horizon);
    let row = (!free).then(|| {
        let row = program.row(format!("length of interval {interval}"), 0.0, 0.0);
        program.linear(row, horizon, -share);
        row
    });
    let shortest = if count == 1 {
        SHORTEST_INTERVAL
    } else {
        SHORTEST * builder.setting.kept
    } * length;
    let durations = (0..count).map(|p| {
        let begin = if p == 0 { 0.0 } else { ends[p - 1] };
        let duration = program.variable(
            format!("length of phase {p} of interval {interval}"),
            (shortest, f64::INFINITY),
            (ends[p] - begin) * length,
            length,
        );
        if let Some(row) = row {
            program.linear(row, duration, 1.0);
        }
        builder.distances.push(Distance {
            name: format!("shortest phase {p} of interval {interval}"),
            kept: Kept::Variable(duration),
            amount: shortest,
            unit: "s".to_owned(),
            chosen: false,
        });
        (duration, 1.0)
    });
    durations.collect()
}

/// The length of an interval of a phase whose switches may be at any time: a part of that of the phase, or its own.
fn duration_of(builder: &mut Builder, interval: usize, span: &Span, place: usize) -> (usize, f64) {
    let own = if span.free { span.pieces } else { 1 };
    let share = own as f64 / span.pieces as f64;
    if let Some(duration) = builder.duration.filter(|_| place > 0 && !span.free) {
        return (duration, share);
    }
    let shortest = SHORTEST * builder.setting.kept * builder.interval_length();
    let duration = builder.program.variable(
        format!("length of the phase from interval {interval} on"),
        (shortest, f64::INFINITY),
        span.duration / own as f64,
        builder.interval_length() * span.pieces as f64 / own as f64,
    );
    builder.duration = Some(duration);
    if let Some(longest) = span.longest {
        let name = format!("longest phase from interval {interval} on");
        let row = builder.program.row(name, 0.0, f64::INFINITY);
        let unit = builder.interval_length();
        builder
            .program
            .linear(row, builder.frame.horizon, longest / unit);
        builder.program.linear(row, duration, -1.0 / unit);
    }
    (duration, share)
}

/// Intervals of free lengths make up the motion.
pub(super) fn add_up(builder: &mut Builder) {
    if builder.setting.lengths != Lengths::Equal {
        let phases = builder.passed(builder.setting.problem.intervals);
        let program = &mut builder.program;
        let row = program.row("length of all intervals".to_owned(), 0.0, 0.0);
        program.linear(row, builder.frame.horizon, -1.0);
        for (length, factor) in phases {
            program.linear(row, length, factor);
        }
    }
}
