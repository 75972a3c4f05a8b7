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
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::{io, thread};

use crate::Scene;
use crate::arguments::{SweepArguments, SweepTask};
use crate::failure::BadInput;
use crate::host::HostScene;
use crate::progress::Progress;
use crate::report::Report;

pub use plan::{SweepPlan, SweepWork};
use table::Table;

/// Stack of a worker \[bytes\], that of a program's first thread on common systems: a point runs there as alone.
const STACK: usize = 8 << 20;

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
    let plan = SweepPlan::read(scene, &arguments.over, &work)?;
    let (shard, shards) = arguments.shard;
    let chains: Vec<usize> = (shard - 1..plan.chains()).step_by(shards).collect();
    let points = chains.iter().flat_map(|&chain| plan.chain(chain));
    let points: Vec<usize> = points.collect();
    let (mut table, done) = Table::open(out, &plan, &points, arguments.resume)?;
    let counted = compute(&plan, &chains, &points[done..], &mut table)?;
    let mut text = format!("{} points", points.len());
    if done > 0 {
        let _ = write!(text, ", {done} of them from before");
    }
    for (status, count) in counted {
        let _ = write!(text, ", {count} {status}");
    }
    let _ = writeln!(text, "\nwrote {}", out.display());
    Ok(Report::of(text))
}

/// Computes chains of points side by side and appends the rows of `points`, the last ones of them, in order; returns how often there
/// was each status.
fn compute(
    plan: &SweepPlan,
    chains: &[usize],
    points: &[usize],
    table: &mut Table<'_>,
) -> Result<BTreeMap<String, usize>, BadInput> {
    // A chain that was begun is computed anew: its next point starts from the motion of the one before it.
    let first = points.first().copied();
    let first = first.and_then(|first| chains.iter().position(|&k| plan.chain(k).contains(&first)));
    let chains = &chains[first.unwrap_or(chains.len())..];
    // Workers are threads of their own: one of the pool could, while a solve waits for its parts, begin another point.
    let workers = rayon::current_num_threads().min(chains.len());
    let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    let goes_on = || !stopped.load(Ordering::Relaxed);
    let work = |sender: mpsc::Sender<(usize, Vec<String>)>| {
        while goes_on() {
            let place = next.fetch_add(1, Ordering::Relaxed);
            let Some(&chain) = chains.get(place) else {
                break;
            };
            if sender.send((place, plan.rows(chain, &goes_on))).is_err() {
                break;
            }
        }
    };
    // Points are far fewer than 2^53.
    let mut progress = Progress::new("sweep", points.len() as f64);
    let mut counted = BTreeMap::new();
    let axes = plan.status_column();
    thread::scope(|scope| {
        let (sender, found) = mpsc::channel();
        for _ in 0..workers {
            let (sender, work) = (sender.clone(), &work);
            let builder = thread::Builder::new().stack_size(STACK);
            builder
                .spawn_scoped(scope, move || work(sender))
                .map_err(no_thread)?;
        }
        drop(sender);
        let mut early = BTreeMap::new();
        let (mut place, mut written) = (0, 0);
        for (number, rows) in found {
            early.insert(number, rows);
            while let Some(rows) = early.remove(&place) {
                let numbered = plan.chain(chains[place]).zip(rows);
                for (_, row) in numbered.filter(|(point, _)| Some(point) >= points.first()) {
                    if let Err(refusal) = table.append(&row) {
                        stopped.store(true, Ordering::Relaxed);
                        return Err(refusal);
                    }
                    let status = row.split(',').nth(axes).unwrap_or_default();
                    *counted.entry(status.to_owned()).or_insert(0) += 1;
                    written += 1;
                }
                place += 1;
                progress.reach(f64::from(written));
            }
        }
        Ok(counted)
    })
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
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut file =
        tempfile::NamedTempFile::new_in(folder.unwrap_or(Path::new("."))).map_err(failed)?;
    io::Write::write_all(&mut file, text.as_bytes()).map_err(failed)?;
    file.persist(out).map_err(|error| failed(error.error))?;
    Ok(Report::of(format!(
        "{count} points\nwrote {}\n",
        out.display()
    )))
}
