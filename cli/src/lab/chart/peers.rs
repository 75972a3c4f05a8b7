//! Runs of other programs, as a script measured them: those that are stored, and fresh ones from the output directory.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;
use std::process::{Command, Stdio};

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use super::measure::{Measured, Order, Point};
use super::study::{Reference, distance};
use super::sweep::{Group, Sweep};
use crate::failure::BadInput;
use crate::figure::Look;

/// Where fresh ones are looked for.
pub(super) const FILE: &str = "peers.csv";
/// What runs a script.
const PYTHON: &str = "python3";
/// Most bytes of that file.
const LARGEST: u64 = 1 << 20;

/// One run of another program, a row of a table.
#[derive(Debug, Clone, PartialEq, Deserialize)]
struct PeerRun {
    date: String,
    machine: String,
    /// The title of the study that it belongs to.
    study: String,
    /// The name of its line.
    curve: String,
    settings: String,
    #[serde(rename = "CPU time [s]")]
    seconds: f64,
    /// Coordinates at the end; empty where it did not get there.
    #[serde(rename = "coordinates at the end", deserialize_with = "numbers")]
    end: Vec<f64>,
    /// "stored", or "measured" for a fresh one.
    #[serde(skip)]
    how: &'static str,
}

/// Finite numbers with spaces between them.
fn numbers<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    let text = String::deserialize(deserializer)?;
    let number = |text: &str| {
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| D::Error::custom(format!("`{text}` is not a number")))
    };
    text.split_whitespace().map(number).collect()
}

/// All runs of other programs that are known.
#[derive(Debug, Default)]
pub(super) struct Peers {
    runs: Vec<PeerRun>,
}

impl Peers {
    /// The runs of the `stored` text, unless the output directory has fresh ones of the same line.
    pub(super) fn of(stored: &str, directory: &Path) -> Result<Self, BadInput> {
        let path = directory.join(FILE);
        let Ok(file) = File::open(&path) else {
            return Self::read(stored, "stored", "the stored runs");
        };
        let name = path.display().to_string();
        let mut fresh = String::new();
        let read = file.take(LARGEST).read_to_string(&mut fresh);
        read.map_err(|error| {
            BadInput::new(format!(
                "`{name}`: {error}; remove it, or write it by tools/peers"
            ))
        })?;
        Self::read(&fresh, "measured", &name)?.and(stored)
    }

    /// The runs of the `stored` text, but for those that a `script` of Python measures now, of these scenes; with its text, and
    /// what it left out.
    pub(super) fn measured_by(
        script: &Path,
        scenes: &[&str],
        stored: &str,
    ) -> Result<(Self, String, String), BadInput> {
        let name = script.display();
        if !script.is_file() {
            return Err(BadInput::new(format!(
                "--peers: there is no file `{name}` here; give the path of the script, --peers=PATH, or leave the option out"
            )));
        }
        let mut command = Command::new(PYTHON);
        command.arg(script).arg("-").arg("--only").args(scenes);
        let run = command.stdin(Stdio::null()).output().map_err(|error| {
            BadInput::new(format!(
                "--peers: `{PYTHON}`: {error}; install it, or leave the option out"
            ))
        })?;
        let [text, told] =
            [run.stdout, run.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        if !run.status.success() {
            let last = told.lines().last().unwrap_or_default();
            return Err(BadInput::new(format!(
                "--peers: `{PYTHON} {name}` failed: {last}; mend it, or leave the option out"
            )));
        }
        let left_out: String = told
            .lines()
            .filter(|line| line.contains(": left out, "))
            .map(|line| format!("{line}\n"))
            .collect();
        let known = Self::read(&text, "measured", &name.to_string())?;
        Ok((known.and(stored)?, text, left_out))
    }

    /// These, and the stored ones of other lines.
    fn and(self, stored: &str) -> Result<Self, BadInput> {
        let mut runs = self.runs;
        let known = runs.len();
        for run in Self::read(stored, "stored", "the stored runs")?.runs {
            let same = |fresh: &PeerRun| (&fresh.study, &fresh.curve) == (&run.study, &run.curve);
            if !runs[..known].iter().any(same) {
                runs.push(run);
            }
        }
        Ok(Self { runs })
    }

    /// The runs of a text in CSV; an empty one has none.
    fn read(text: &str, how: &'static str, name: &str) -> Result<Self, BadInput> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let rows = reader.deserialize::<PeerRun>();
        let runs = rows.map(|row| row.map(|run| PeerRun { how, ..run }));
        let runs = runs.collect::<Result<_, _>>().map_err(|error| {
            BadInput::new(format!(
                "`{name}`: {error}; remove the file, or write it by tools/peers"
            ))
        })?;
        Ok(Self { runs })
    }

    /// The lines of a study, in the order of their first runs.
    pub(super) fn measured(&self, study: &str, reference: &Reference) -> Vec<Measured> {
        let mut lines: Vec<(&str, Measured)> = Vec::new();
        for run in self.runs.iter().filter(|run| run.study == study) {
            let point = run.point(&reference.coordinates);
            match lines.iter_mut().find(|(curve, _)| *curve == run.curve) {
                Some((_, line)) => line.points.push(point),
                None => lines.push((&run.curve, run.line(point))),
            }
        }
        lines.into_iter().map(|(_, line)| line).collect()
    }

    /// When and on what the runs of a study were measured, for people; empty without runs.
    pub(super) fn origin(&self, study: &str) -> String {
        let mut origins: Vec<String> = Vec::new();
        for run in self.runs.iter().filter(|run| run.study == study) {
            let origin = format!("{} on {} on {}", run.how, run.date, run.machine);
            if !origins.contains(&origin) {
                origins.push(origin);
            }
        }
        origins.join("; ")
    }
}

impl PeerRun {
    fn point(&self, reference: &[f64]) -> Point {
        let comparable = self.end.len() == reference.len();
        Point {
            arguments: format!(
                "{}, {} on {} on {}",
                self.settings, self.how, self.date, self.machine
            ),
            grain: f64::NAN,
            error: if comparable {
                distance(&self.end, reference)
            } else {
                f64::NAN
            },
            seconds: self.seconds,
            half: f64::NAN,
            counts: None,
            status: self.how,
        }
    }

    fn line(&self, point: Point) -> Measured {
        Measured {
            sweep: Sweep {
                name: format!("{} ({} {})", self.curve, self.how, self.date),
                look: Look::of(&self.curve).dashed(),
                charted: true,
                group: Group::Peers,
                compared: false,
                theory: "-".to_owned(),
                settings: Vec::new(),
            },
            points: vec![point],
            order: Order::Unknown,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{Peers, Reference};

    const STORED: &str = "date,machine,study,curve,settings,CPU time [s],coordinates at the end\n\
        2026-01-02,Abacus,drop,one,coarse,2e-3,1.5 2\n\
        2026-01-02,Abacus,drop,one,fine,4e-3,1 2.25\n\
        2026-01-02,Abacus,drop,two,,1e-3,\n\
        2026-01-02,Abacus,ride,one,,1e-3,3\n";

    fn reference() -> Reference {
        Reference {
            coordinates: vec![1.0, 2.0],
            confirming: vec![1.0, 2.0],
            uncertainty: 0.0,
            what: String::new(),
        }
    }

    #[test]
    fn stored_runs_are_lines_with_their_errors_and_say_where_they_are_from() {
        let peers = Peers::read(STORED, "stored", "x").unwrap();
        let lines = peers.measured("drop", &reference());
        let names: Vec<&str> = lines.iter().map(|line| line.sweep.name.as_str()).collect();
        assert_eq!(
            names,
            ["one (stored 2026-01-02)", "two (stored 2026-01-02)"]
        );
        let errors: Vec<f64> = lines[0].points.iter().map(|point| point.error).collect();
        assert_eq!(errors, [0.5, 0.25]);
        assert_eq!(lines[0].points[1].seconds, 4e-3);
        // Without an end there is no error.
        assert!(lines[1].points[0].error.is_nan());
        assert_eq!(peers.origin("drop"), "stored on 2026-01-02 on Abacus");
        assert!(peers.measured("jump", &reference()).is_empty());
        assert!(peers.origin("jump").is_empty());
    }

    #[test]
    fn fresh_runs_of_the_output_directory_take_the_place_of_stored_ones() {
        let directory = tempfile::tempdir().unwrap();
        assert_eq!(
            Peers::of(STORED, directory.path()).unwrap().runs,
            Peers::read(STORED, "stored", "x").unwrap().runs
        );
        let fresh = "date,machine,study,curve,settings,CPU time [s],coordinates at the end\n\
            2026-01-03,Slide rule,drop,one,fine,1e-3,1 2\n";
        fs::write(directory.path().join("peers.csv"), fresh).unwrap();
        let peers = Peers::of(STORED, directory.path()).unwrap();
        let lines = peers.measured("drop", &reference());
        let names: Vec<&str> = lines.iter().map(|line| line.sweep.name.as_str()).collect();
        assert_eq!(
            names,
            ["one (measured 2026-01-03)", "two (stored 2026-01-02)"]
        );
        assert_eq!(lines[0].points.len(), 1);
        assert_eq!(lines[0].points[0].error, 0.0);
    }

    #[test]
    fn runs_that_a_script_measures_take_the_place_of_stored_ones_and_what_it_lacks_is_told() {
        let directory = tempfile::tempdir().unwrap();
        let script = directory.path().join("measure.py");
        let write = |text: &str| fs::write(&script, text).unwrap();
        let row = "2026-01-04,Here,{},one,fine,1e-3,1 2";
        write(&format!(
            "import sys\nprint('two: left out, no module', file=sys.stderr)\nprint('drop: one', file=sys.stderr)\n\
             print('{}')\nfor scene in sys.argv[3:]:\n    print('{row}'.format(scene))\n",
            STORED.lines().next().unwrap()
        ));
        // Where there is no Python, nothing can be measured.
        if std::process::Command::new(super::PYTHON)
            .arg("-V")
            .output()
            .is_err()
        {
            return;
        }
        let (peers, text, left_out) = Peers::measured_by(&script, &["drop"], STORED).unwrap();
        let lines = peers.measured("drop", &reference());
        let names: Vec<&str> = lines.iter().map(|line| line.sweep.name.as_str()).collect();
        assert_eq!(
            names,
            ["one (measured 2026-01-04)", "two (stored 2026-01-02)"]
        );
        assert_eq!(lines[0].points[0].error, 0.0);
        assert_eq!(text.lines().count(), 2);
        assert_eq!(left_out, "two: left out, no module\n");
        let refusal = || {
            let refused = Peers::measured_by(&script, &[], STORED).unwrap_err();
            refused.to_string()
        };
        write("raise SystemExit('no disk')\n");
        assert!(refusal().ends_with("failed: no disk; mend it, or leave the option out"));
        fs::remove_file(&script).unwrap();
        assert!(
            refusal().starts_with("--peers: there is no file `"),
            "{}",
            refusal()
        );
    }

    #[test]
    fn text_that_is_no_table_of_runs_is_refused_with_its_line() {
        let refusal = |text: &str| {
            Peers::read(text, "stored", "p.csv")
                .unwrap_err()
                .to_string()
        };
        for (text, words) in [
            ("a,b\n1,2\n".to_owned(), ["line: 2", "missing field `date`"]),
            (
                STORED.replace("2.25", "NaN"),
                ["line: 3", "`NaN` is not a number"],
            ),
            (format!("{STORED}1,2\n"), ["line: 6", "2 fields"]),
        ] {
            let refusal = refusal(&text);
            assert!(words.iter().all(|said| refusal.contains(said)), "{refusal}");
            assert!(refusal.ends_with("remove the file, or write it by tools/peers"));
        }
    }
}
