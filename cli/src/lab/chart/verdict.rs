//! What a method made of a problem on which methods fail, and how often it came to what.

/// What a method made of a problem.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Verdict {
    /// Within the stated bound of what is right, with its relative error.
    Right(f64),
    /// Within that bound by another method, to which the one that was asked for has handed over, with its relative error.
    HandedOver(f64),
    /// Farther off than the bound, with its relative error, and says itself that it may be.
    Rough(f64),
    /// Solved, and farther off than the bound and than it says, or solved where there is no solution.
    Wrong(Option<f64>),
    /// Stopped with this status where it should have gone on.
    Stopped(&'static str),
    /// Stopped with this status, as is right.
    RightlyStopped(&'static str),
    /// Solved where there is no solution, with an error that it estimates to be as large as the motion.
    Disclaimed(f64),
    /// Still running when its time was over.
    NoEnd,
    /// The method does not know a feature of the scene.
    NotApplicable,
    /// There is nothing to compare with.
    Unknown,
}

impl Verdict {
    pub(super) fn cell(&self) -> String {
        match self {
            Self::Right(error) => format!("right {error:.0e}"),
            Self::HandedOver(error) => format!("handed over {error:.0e}"),
            Self::Rough(error) => format!("rough {error:.0e}"),
            Self::Wrong(Some(error)) => format!("WRONG {error:.0e}"),
            Self::Wrong(None) => "WRONG solved".to_owned(),
            Self::Stopped(status) => format!("stopped {status}"),
            Self::RightlyStopped(status) => format!("right {status}"),
            Self::Disclaimed(estimate) => format!("disclaimed {estimate:.0e}"),
            Self::NoEnd => "no end".to_owned(),
            Self::NotApplicable => "not applicable".to_owned(),
            Self::Unknown => "-".to_owned(),
        }
    }
}

/// What to read off the verdicts of one method: how many there are, how many are right, and where it is not.
pub(super) fn reading(name: &str, index: usize, rows: &[Row]) -> String {
    let own = || {
        rows.iter()
            .filter_map(|row| Some((row, row.verdicts.get(index)?)))
    };
    let right = |verdict: &Verdict| {
        matches!(
            verdict,
            Verdict::Right(_) | Verdict::RightlyStopped(_) | Verdict::HandedOver(_)
        )
    };
    let others: Vec<String> = own()
        .filter(|(_, verdict)| !right(verdict))
        .map(|(row, verdict)| format!("{} ({})", row.name, verdict.cell()))
        .collect();
    let handed = own().filter(|(_, verdict)| matches!(verdict, Verdict::HandedOver(_)));
    let handed = match handed.count() {
        0 => String::new(),
        count => format!(", {count} of them by handing over to another method"),
    };
    let others = if others.is_empty() {
        String::new()
    } else {
        format!("; it is not on {}", others.join(", "))
    };
    let count = own().filter(|(_, verdict)| right(verdict)).count();
    format!(
        "{name}: right on {count} of {}{handed}{others}.",
        own().count()
    )
}

/// A problem, why its right outcome is right, and the verdict of each method.
pub(super) struct Row {
    pub(super) name: String,
    pub(super) phenomenon: String,
    pub(super) why: String,
    pub(super) verdicts: Vec<Verdict>,
}

impl Row {
    pub(super) fn cells(&self) -> Vec<String> {
        let mut cells = vec![self.name.clone()];
        cells.extend(self.verdicts.iter().map(Verdict::cell));
        cells
    }

    /// For the table of reasons.
    pub(super) fn reason(&self) -> Vec<String> {
        vec![self.name.clone(), self.phenomenon.clone(), self.why.clone()]
    }
}

/// The first line of [`sums`].
pub(super) fn sums_header() -> [&'static str; 9] {
    [
        "method",
        "right",
        "handed over",
        "rough, and says so",
        "disclaimed",
        "wrong silently",
        "stopped",
        "no end",
        "not applicable",
    ]
}

/// How often each of the methods comes to each verdict.
pub(super) fn sums<'m>(
    methods: impl IntoIterator<Item = &'m str>,
    rows: &[Row],
) -> Vec<Vec<String>> {
    let sums = methods.into_iter().enumerate().map(|(index, name)| {
        let count = |is: &dyn Fn(&Verdict) -> bool| {
            let all = rows.iter().filter_map(|row| row.verdicts.get(index));
            all.filter(|verdict| is(verdict)).count().to_string()
        };
        vec![
            name.to_owned(),
            count(&|verdict| matches!(verdict, Verdict::Right(_) | Verdict::RightlyStopped(_))),
            count(&|verdict| matches!(verdict, Verdict::HandedOver(_))),
            count(&|verdict| matches!(verdict, Verdict::Rough(_))),
            count(&|verdict| matches!(verdict, Verdict::Disclaimed(_))),
            count(&|verdict| matches!(verdict, Verdict::Wrong(_))),
            count(&|verdict| matches!(verdict, Verdict::Stopped(_))),
            count(&|verdict| matches!(verdict, Verdict::NoEnd)),
            count(&|verdict| matches!(verdict, Verdict::NotApplicable)),
        ]
    });
    sums.collect()
}
