//! The numbers among the arguments: how they are read, and within which bounds.

use hangtime_units::Quantity;

/// Most steps of a simulation: their states stay in memory until the end, about a kilobyte each.
pub(crate) const MOST_STEPS: usize = 1_000_000;
/// Default of `--rows`.
pub(crate) const ROWS: usize = 20_000;
/// Most rows of a trajectory in files.
const MOST_ROWS: usize = 200_000;
/// Most finite elements of a step, of an interval or of a phase.
const MOST_ELEMENTS: usize = 1_000;
/// Most stages of a scheme of any method.
const MOST_STAGES: usize = 9;
/// Most control intervals: one program holds the variables of all of them.
const MOST_INTERVALS: usize = 10_000;
/// Most starts; they are solved side by side.
const MOST_STARTS: usize = 1_000;

/// Steps of a simulation.
pub(crate) fn steps(text: &str) -> Result<usize, String> {
    count(
        text,
        MOST_STEPS,
        "the states of all steps stay in memory; simulate a part of the horizon, or give a tolerance",
    )
}

/// Finite elements of a step, of an interval or of a phase.
pub(crate) fn elements(text: &str) -> Result<usize, String> {
    count(
        text,
        MOST_ELEMENTS,
        "the elements of a step are solved together; take more steps or intervals instead",
    )
}

/// Control intervals.
pub(crate) fn intervals(text: &str) -> Result<usize, String> {
    count(
        text,
        MOST_INTERVALS,
        "one program holds the variables of all intervals; more stages are a cheaper way to accuracy",
    )
}

/// Starts of a solve.
pub(crate) fn starts(text: &str) -> Result<usize, String> {
    count(
        text,
        MOST_STARTS,
        "run again with more intervals for other local optima",
    )
}

/// Stages of a scheme.
pub(crate) fn stages(text: &str) -> Result<usize, String> {
    // Each method has bounds of its own among these, which its refusal names.
    match text.parse() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err(format!("give a whole number from 1 to {MOST_STAGES}")),
    }
}

/// Rows of a trajectory in files.
pub(crate) fn rows(text: &str) -> Result<usize, String> {
    count(
        text,
        MOST_ROWS,
        "files and page hold them several times; use the library for more",
    )
}

/// A whole number from 1 to `most`; `beyond` tells why there are no more.
fn count(text: &str, most: usize, beyond: &str) -> Result<usize, String> {
    if let Ok(number) = text.parse()
        && (1..=most).contains(&number)
    {
        return Ok(number);
    }
    let too_many = text.bytes().all(|byte| byte.is_ascii_digit()) && text.contains(|c| c != '0');
    Err(if too_many {
        format!("give at most {most}: {beyond}")
    } else {
        format!("give a whole number from 1 to {most}")
    })
}

/// A share of a sweep, `I/N` with 1 <= I <= N.
pub(crate) fn shard(text: &str) -> Result<(usize, usize), String> {
    let pair = text.split_once('/').and_then(|(index, count)| {
        let [index, count] = [index, count].map(|part| part.trim().parse().ok());
        Some((index?, count?))
    });
    pair.filter(|&(index, count)| 1 <= index && index <= count)
        .ok_or_else(|| "give I/N with whole numbers 1 <= I <= N, such as 3/40".to_owned())
}

/// Points of a chain of a sweep, each of which starts from the one before it.
pub(crate) fn chain(text: &str) -> Result<usize, String> {
    let points = text.parse().ok().filter(|&points| points > 1);
    points.ok_or_else(|| {
        "give a whole number of points, at least 2: one alone hands nothing on".to_owned()
    })
}

/// A finite number above zero.
pub(crate) fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err("give a finite number above 0".into()),
    }
}

/// A number of zero or more, infinity included.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| *number >= 0.0);
    number.ok_or_else(|| "give a number of 0 or more, such as 0.5, or inf".to_owned())
}

/// A time above zero [s], in seconds or in the unit given.
pub(crate) fn duration(text: &str) -> Result<f64, String> {
    let not_finite = "give a finite time above 0, such as 5, 5s or 200ms";
    if text
        .trim()
        .parse::<f64>()
        .is_ok_and(|time| !time.is_finite())
    {
        return Err(not_finite.into());
    }
    let time = Quantity::parse(text)
        .and_then(|time| time.in_unit("s"))
        .map_err(|error| format!("{error}; give a time such as 5, 5s or 200ms"))?;
    if time.is_finite() && time > 0.0 {
        Ok(time)
    } else {
        Err(not_finite.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn duration_reads_units_and_refuses_what_is_no_time() {
        assert_eq!(duration("5"), Ok(5.0));
        assert_eq!(duration("3min"), Ok(180.0));
        for text in ["0", "-1s", "5kg", "inf", "nan", "soon", ""] {
            assert!(duration(text).is_err(), "{text}");
        }
    }

    #[test]
    fn counts_end_at_their_bounds_and_say_which() {
        assert_eq!(steps("1"), Ok(1));
        assert_eq!(starts("1000"), Ok(MOST_STARTS));
        for text in ["0", "-3", "1.5", "many", ""] {
            let message = intervals(text).unwrap_err();
            assert_eq!(message, "give a whole number from 1 to 10000", "{text}");
        }
        let message = elements("1001").unwrap_err();
        assert!(message.starts_with("give at most 1000: "), "{message}");
    }

    #[test]
    fn chain_has_points_that_hand_something_on() {
        assert_eq!(chain("2"), Ok(2));
        for text in ["1", "0", "-3", "2.5", "many"] {
            assert!(chain(text).is_err(), "{text}");
        }
    }

    #[test]
    fn shard_is_one_of_several() {
        assert_eq!(shard("3/40"), Ok((3, 40)));
        for text in ["0/4", "5/4", "3", "a/b"] {
            assert!(shard(text).is_err(), "{text}");
        }
    }
}
