//! `hangtime sweep`: a scene over the values of its parameters, a row a point.
//!
//! Rows are appended to the file in the order of their points, whole lines only, so that the file is at any moment the
//! beginning of the finished table: a run that was killed is resumed from there.

mod axis;
mod plan;
mod record;
mod table;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use crate::Scene;
use crate::arguments::{SweepArguments, SweepTask};
use crate::bounds::{asked_from_outside, listen};
use crate::ending::Stop;
use crate::failure::{BadInput, one_line};
use crate::host::HostScene;
use crate::output::OutputDirectory;
use crate::progress::Progress;
use crate::report::Report;

pub use plan::{SweepPlan, SweepWork};
pub use table::SweepTable;

/// Stack of a worker \[bytes\], that of a program's first thread on common systems: a point runs there as alone.
const STACK: usize = 8 << 20;
/// How often Ctrl-C is looked for.
const PATIENCE: Duration = Duration::from_millis(100);

pub(crate) fn run(
    scenes: &'static [Scene],
    arguments: &SweepArguments,
) -> Result<Report, BadInput> {
    let out = &arguments.out;
    if !arguments.join.is_empty() {
        return joined(&arguments.join, out);
    }
    let scene = arguments.scene.as_deref();
    let scene = scene.ok_or_else(|| BadInput::new("give a scene, or tables to --join"))?;
    let scene = HostScene::find(scenes, scene)?;
    let mut words: Vec<String> = Vec::new();
    for setting in &arguments.settings {
        words.extend(["--set".to_owned(), setting.clone()]);
    }
    words.extend(arguments.options.iter().cloned());
    let work = SweepWork {
        solve: arguments.what == SweepTask::Solve,
        warm: arguments.warm.unwrap_or(1),
        words: &words,
        record: &arguments.record,
    };
    let plan = Arc::new(SweepPlan::read(scene, &arguments.over, &work)?);
    let (shard, shards) = arguments.shard;
    let chains: Vec<usize> = (shard - 1..plan.chains()).step_by(shards).collect();
    let points = chains.iter().flat_map(|&chain| plan.chain(chain));
    let points: Vec<usize> = points.collect();
    let mut done = 0;
    listen();
    let mut table = SweepTable::open(out, &plan, &points, arguments.resume, &mut |_| done += 1)?;
    let (counted, stop) = compute(&plan, &chains, &points[done..], &mut table)?;
    let mut report = Report::default();
    let new: usize = counted.values().sum();
    let count = match stop {
        None => format!("{} points", points.len()),
        Some(stop) => {
            report.diagnoses.push(one_line(&format!(
                "sweep: {}: {} of {} points are in {}; go on with --resume",
                stop.name(),
                done + new,
                points.len(),
                out.display()
            )));
            format!("{} of {} points", done + new, points.len())
        }
    };
    report.text = count;
    if done > 0 {
        let _ = write!(report.text, ", {done} of them from before");
    }
    for (status, count) in counted {
        let _ = write!(report.text, ", {count} {status}");
    }
    let _ = writeln!(report.text, "\nwrote {}", out.display());
    Ok(report)
}

/// What threads share that compute chains of points side by side.
struct Work {
    plan: Arc<SweepPlan>,
    chains: Vec<usize>,
    /// Place of the next chain that nobody has begun.
    next: AtomicUsize,
    stopped: AtomicBool,
}

impl Work {
    fn goes_on(&self) -> bool {
        !self.stopped.load(Ordering::Relaxed) && asked_from_outside().is_none()
    }

    /// What a thread does until nothing is left: it tells the rows of each chain with its place.
    fn run(&self, sender: &mpsc::Sender<(usize, Vec<String>)>) {
        while self.goes_on() {
            let place = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(&chain) = self.chains.get(place) else {
                break;
            };
            let rows = self.plan.rows(chain, &|| self.goes_on());
            if sender.send((place, rows)).is_err() {
                break;
            }
        }
    }

    /// Starts the threads; they are not waited for, as a step of a run that is not wanted any more may take long.
    fn start(self: &Arc<Self>) -> Result<mpsc::Receiver<(usize, Vec<String>)>, BadInput> {
        let (sender, found) = mpsc::channel();
        // Threads of their own: one of the pool could, while a solve waits for its parts, begin another point.
        for _ in 0..rayon::current_num_threads().min(self.chains.len()) {
            let (work, sender) = (Arc::clone(self), sender.clone());
            let builder = thread::Builder::new().stack_size(STACK);
            builder
                .spawn(move || work.run(&sender))
                .map_err(no_thread)?;
        }
        Ok(found)
    }
}

/// Computes chains of points side by side and appends the rows of `points`, the last ones of them, in order; returns how often there
/// was each status, and why it ended before the last point, if it did.
fn compute(
    plan: &Arc<SweepPlan>,
    chains: &[usize],
    points: &[usize],
    table: &mut SweepTable,
) -> Result<(BTreeMap<String, usize>, Option<Stop>), BadInput> {
    // A chain that was begun is computed anew: its next point starts from the motion of the one before it.
    let first = points.first().copied();
    let first = first.and_then(|first| chains.iter().position(|&k| plan.chain(k).contains(&first)));
    let work = Arc::new(Work {
        plan: Arc::clone(plan),
        chains: chains[first.unwrap_or(chains.len())..].to_vec(),
        next: AtomicUsize::new(0),
        stopped: AtomicBool::new(false),
    });
    let found = work.start()?;
    // Points are far fewer than 2^53.
    let mut progress = Progress::new("sweep", points.len() as f64);
    let mut counted = BTreeMap::new();
    let mut early = BTreeMap::new();
    let (mut place, mut written) = (0, 0);
    while place < work.chains.len() {
        let answer = found.recv_timeout(PATIENCE);
        // Looked at first: what was under way then has ended too early.
        if let Some(stop) = asked_from_outside() {
            return Ok((counted, Some(stop)));
        }
        match answer {
            Ok((number, rows)) => early.insert(number, rows),
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(BadInput::new(
                    "internal_error: a point came to no end; please report it, and go on with --resume",
                ));
            }
        };
        while let Some(rows) = early.remove(&place) {
            let numbered = plan.chain(work.chains[place]).zip(rows);
            for (_, row) in numbered.filter(|(point, _)| Some(point) >= points.first()) {
                if let Err(refusal) = table.add(&row) {
                    work.stopped.store(true, Ordering::Relaxed);
                    return Err(refusal);
                }
                let status = row.split(',').nth(plan.status_column()).unwrap_or_default();
                *counted.entry(status.to_owned()).or_insert(0) += 1;
                written += 1;
            }
            place += 1;
            progress.reach(f64::from(written));
        }
    }
    Ok((counted, None))
}

fn no_thread(error: io::Error) -> BadInput {
    BadInput::new(format!("{error}; set RAYON_NUM_THREADS to fewer threads"))
}

/// Writes the joined table, whole or not at all.
fn joined(files: &[std::path::PathBuf], out: &Path) -> Result<Report, BadInput> {
    let (text, count) = table::join(files)?;
    let failed = |error: io::Error| {
        BadInput::new(format!(
            "--out `{}`: {error}; give a file that can be written",
            out.display()
        ))
    };
    table::refuse_other_than_files(out).map_err(failed)?;
    let name = out.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| failed(io::Error::other("this is no name of a file")))?;
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = OutputDirectory::open(folder.unwrap_or(Path::new(".")))?;
    folder.write(&[(name.to_owned(), text)])?;
    Ok(Report::of(format!(
        "{count} points\nwrote {}\n",
        out.display()
    )))
}
