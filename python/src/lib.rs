//! What the Python package `hangtime` calls: scenes, runs and sweeps of the command line's library, words in and JSON out.
//!
//! The package itself is written in Python, in `hangtime/`; it makes arrays and pictures of what comes from here.

use std::ffi::OsString;
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use hangtime_cli::{HostProgram, HostRun, HostScene, Refusal, SweepWork};
use pyo3::create_exception;
use pyo3::exceptions::{PyIndexError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

create_exception!(
    _core,
    Mistake,
    PyValueError,
    "Bad input. Its text is what the command line prints: what is wrong, where, and how to mend it."
);

/// How often a run looks for Ctrl-C and tells its progress.
const PATIENCE: Duration = Duration::from_millis(100);
/// Stack of the thread of a solve \[bytes\], that of a program's first thread on common systems.
const STACK: usize = 8 << 20;

fn mistake(refusal: &Refusal) -> PyErr {
    Mistake::new_err(refusal.to_string())
}

/// Whether Ctrl-C was pressed, or `progress` raised: then the run is to stop, and why.
fn interruption(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    share: Option<f64>,
    words: &str,
) -> PyResult<()> {
    py.check_signals()?;
    match progress {
        Some(progress) => progress.call1(py, (share, words)).map(|_| ()),
        None => Ok(()),
    }
}

/// What long work calls with what it is doing; it goes on while that answers true.
type Say<'a> = &'a mut (dyn FnMut(&dyn Display) -> bool + Send);

/// Does long work in a thread of its own and tells `progress` what it says. Once Ctrl-C is pressed, or `progress` raises, `stop` is set:
/// what was raised comes back beside what the work came to.
fn watched<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    stop: &Arc<AtomicBool>,
    work: impl FnOnce(Say<'_>) -> T + Send + 'static,
) -> PyResult<(T, Option<PyErr>)> {
    let (said, heard) = mpsc::channel();
    // The wait for a word goes on without the interpreter's lock, which asks for shared access.
    let heard = Mutex::new(heard);
    let asked = Arc::clone(stop);
    let work = move || {
        let mut told = Instant::now();
        work(&mut |now| {
            if told.elapsed() >= PATIENCE {
                told = Instant::now();
                // The listener may be about to leave.
                let _ = said.send(now.to_string());
            }
            !asked.load(Ordering::Relaxed)
        })
    };
    let worker = thread::Builder::new().stack_size(STACK).spawn(work)?;
    let mut raised = None;
    loop {
        let word = py.detach(|| match heard.lock() {
            Ok(heard) => heard.recv_timeout(PATIENCE),
            Err(poisoned) => poisoned.into_inner().recv_timeout(PATIENCE),
        });
        let told = match &word {
            Ok(words) => interruption(py, progress, None, words),
            Err(RecvTimeoutError::Timeout) => py.check_signals(),
            Err(RecvTimeoutError::Disconnected) => break,
        };
        if let Err(error) = told {
            stop.store(true, Ordering::Relaxed);
            raised.get_or_insert(error);
        }
    }
    let done = py.detach(|| worker.join());
    let done = done.map_err(|_| PyRuntimeError::new_err("internal_error: the solver panicked"))?;
    Ok((done, raised))
}

/// What is left of something raised where work came to a result: Ctrl-C asked for that result, all else counts.
fn left(py: Python<'_>, raised: Option<PyErr>) -> PyResult<()> {
    let interrupts =
        |raised: &PyErr| raised.is_instance_of::<pyo3::exceptions::PyKeyboardInterrupt>(py);
    match raised.filter(|raised| !interrupts(raised)) {
        Some(raised) => Err(raised),
        None => Ok(()),
    }
}

/// Numbers as bytes, which arrays are views of.
fn bytes<'py>(py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyBytes>> {
    PyBytes::new_with(py, size_of_val(values), |bytes| {
        let chunks = bytes.chunks_exact_mut(size_of::<f64>());
        for (bytes, value) in chunks.zip(values) {
            bytes.copy_from_slice(&value.to_ne_bytes());
        }
        Ok(())
    })
}

/// A scene that was derived.
#[pyclass(frozen, module = "hangtime._core")]
struct Scene {
    inner: HostScene,
}

#[pymethods]
impl Scene {
    /// The scene of a text, under a name.
    #[staticmethod]
    fn of_text(py: Python<'_>, name: &str, text: &str) -> PyResult<Self> {
        let inner = py.detach(|| HostScene::of_text(name, text));
        inner.map(|inner| Self { inner }).map_err(|r| mistake(&r))
    }

    /// A shipped scene by name, or that of a file by its path.
    #[staticmethod]
    fn open(py: Python<'_>, name: &str) -> PyResult<Self> {
        let inner = py.detach(|| HostScene::open(hangtime_models::scenes(), name));
        inner.map(|inner| Self { inner }).map_err(|r| mistake(&r))
    }

    /// Name of the scene.
    #[getter]
    fn name(&self) -> &'static str {
        self.inner.name()
    }

    /// What it is, in one line.
    #[getter]
    fn title(&self) -> &'static str {
        self.inner.title()
    }

    /// Warnings about its text.
    #[getter]
    fn warnings(&self) -> &'static str {
        self.inner.warnings()
    }

    /// Name, unit, value and documentation of every parameter.
    fn parameters(&self) -> PyResult<Vec<(&'static str, &'static str, f64, &'static str)>> {
        self.inner.parameters().map_err(|r| mistake(&r))
    }

    /// What the command `explain` prints.
    fn explain(&self, py: Python<'_>, words: Vec<String>) -> PyResult<String> {
        let text = py.detach(|| self.inner.explain(&words));
        text.map_err(|r| mistake(&r))
    }

    /// One simulation, in the thread of the caller. Ctrl-C ends it by `KeyboardInterrupt`.
    #[pyo3(signature = (words, progress=None))]
    fn simulate(
        &self,
        py: Python<'_>,
        words: Vec<String>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Run> {
        let mut next = PATIENCE.as_secs_f64();
        let mut raised = None;
        let run = py.detach(|| {
            self.inner.simulate(&words, &mut |now| {
                if now.seconds < next {
                    return true;
                }
                next = now.seconds + PATIENCE.as_secs_f64();
                let told = Python::attach(|py| {
                    interruption(py, progress.as_ref(), Some(now.time), &now.to_string())
                });
                raised = told.err();
                raised.is_none()
            })
        });
        match raised {
            Some(raised) => Err(raised),
            None => run.map(Run::new).map_err(|r| mistake(&r)),
        }
    }

    /// One solve, in a thread of its own, from the motion of the run `start` if that is given. Ctrl-C ends it with the best motion so
    /// far; where there is none, by `KeyboardInterrupt`.
    #[pyo3(signature = (words, progress=None, start=None))]
    fn solve(
        &self,
        py: Python<'_>,
        words: Vec<String>,
        progress: Option<Py<PyAny>>,
        start: Option<Py<Run>>,
    ) -> PyResult<Run> {
        let stop = Arc::new(AtomicBool::new(false));
        let scene = self.inner.clone();
        let (run, raised) = watched(py, progress.as_ref(), &stop, move |say| {
            let observer = &mut |now: &hangtime::Progress| say(now);
            match &start {
                Some(start) => scene.solve_from(&words, &start.get().inner, observer),
                None => scene.solve(&words, observer),
            }
        })?;
        let run = run.map_err(|r| mistake(&r))?;
        match raised {
            Some(raised) if !run.has_motion() => return Err(raised),
            raised => left(py, raised)?,
        }
        Ok(Run::new(run))
    }
}

/// Solves the program of a `.nl` file, in a thread of its own, with options as pairs of name and value. Ctrl-C ends it with the point that
/// it has reached.
#[pyfunction]
#[pyo3(signature = (path, options, progress=None))]
fn solve_program(
    py: Python<'_>,
    path: String,
    options: Vec<(String, String)>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Program> {
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    let (answer, raised) = watched(py, progress.as_ref(), &stop, move |say| {
        HostProgram::solve(&path, &options, &asked, &mut |now| say(&now))
    })?;
    let inner = answer.map_err(|r| mistake(&r))?;
    left(py, raised)?;
    Ok(Program { inner })
}

/// Names of the options of [`solve_program`].
#[pyfunction]
fn program_options() -> Vec<&'static str> {
    hangtime_cli::program_options()
}

/// A program of a `.nl` file that was solved.
#[pyclass(frozen, module = "hangtime._core")]
struct Program {
    inner: HostProgram,
}

#[pymethods]
impl Program {
    /// Name of the status.
    #[getter]
    fn status(&self) -> &'static str {
        self.inner.status()
    }

    /// What the command prints with `--json`.
    #[getter]
    fn json(&self) -> String {
        self.inner.json()
    }

    /// The `.sol` file.
    #[getter]
    fn sol(&self) -> String {
        self.inner.sol()
    }

    /// Names of the variables and of the rows.
    fn names(&self) -> [Vec<String>; 2] {
        self.inner.names()
    }

    /// The variables, the multipliers of the rows, and those of lower and of upper bounds, each as bytes.
    fn numbers<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyBytes>; 4]> {
        let [lower, upper] = self.inner.bound_multipliers();
        Ok([
            bytes(py, self.inner.x())?,
            bytes(py, self.inner.multipliers())?,
            bytes(py, lower)?,
            bytes(py, upper)?,
        ])
    }
}

/// A run that has ended; its document is written when it is asked for.
#[pyclass(frozen, module = "hangtime._core")]
struct Run {
    inner: HostRun,
    json: OnceLock<String>,
}

impl Run {
    fn new(inner: HostRun) -> Self {
        Self {
            inner,
            json: OnceLock::new(),
        }
    }
}

#[pymethods]
impl Run {
    /// Name of the status.
    #[getter]
    fn status(&self) -> &'static str {
        self.inner.status()
    }

    /// Whether parameters were estimated.
    #[getter]
    fn is_estimate(&self) -> bool {
        self.inner.is_estimate()
    }

    /// What the command prints with `--json`.
    #[getter]
    fn json(&self) -> &str {
        self.json.get_or_init(|| self.inner.json())
    }

    /// A part of the trajectory: numbers of a row, and all numbers as bytes; `None` where there is no such part.
    fn part<'py>(
        &self,
        py: Python<'py>,
        name: &str,
    ) -> PyResult<Option<(usize, Bound<'py, PyBytes>)>> {
        let part = self.inner.part(name);
        part.map(|part| Ok((part.width, bytes(py, &part.values)?)))
            .transpose()
    }

    /// Name and unit of every column of a part.
    fn quantities(&self, part: &str) -> Vec<(String, String)> {
        self.inner.quantities(part)
    }

    /// What the command writes with `--out`, as pairs of name and content.
    fn files(&self, py: Python<'_>) -> Vec<(String, String)> {
        py.detach(|| self.inner.files())
    }
}

/// The points of a sweep, and the row of each.
#[pyclass(frozen, module = "hangtime._core")]
struct SweepPlan {
    inner: hangtime_cli::SweepPlan,
}

#[pymethods]
impl SweepPlan {
    #[new]
    fn new(
        py: Python<'_>,
        scene: &Scene,
        solve: bool,
        warm: usize,
        over: Vec<String>,
        words: Vec<String>,
        record: Vec<String>,
    ) -> PyResult<Self> {
        let scene = scene.inner.clone();
        let work = SweepWork {
            solve,
            warm,
            words: &words,
            record: &record,
        };
        let plan = py.detach(|| hangtime_cli::SweepPlan::new(scene, &over, &work));
        plan.map(|inner| Self { inner }).map_err(|r| mistake(&r))
    }

    /// How many points there are.
    fn __len__(&self) -> usize {
        self.inner.count()
    }

    /// How many chains of points there are, each of which is computed by itself.
    #[getter]
    fn chains(&self) -> usize {
        self.inner.chains()
    }

    /// The headings of the columns, a line of CSV.
    #[getter]
    fn header(&self) -> String {
        self.inner.header()
    }

    /// The mark at the end of every row.
    #[getter]
    fn mark(&self) -> &str {
        self.inner.mark()
    }

    /// The first point of a chain, and the one after its last.
    fn chain(&self, number: usize) -> PyResult<(usize, usize)> {
        let points = self.inner.chain(self.checked(number)?);
        Ok((points.start, points.end))
    }

    /// Computes the rows of a chain, lines of CSV. Ctrl-C ends it by `KeyboardInterrupt`.
    fn rows(&self, py: Python<'_>, number: usize) -> PyResult<Vec<String>> {
        let number = self.checked(number)?;
        let raised = Mutex::new((Instant::now(), None));
        let goes_on = || {
            // Whoever comes while another thread asks goes on.
            let Ok(mut raised) = raised.try_lock() else {
                return true;
            };
            if raised.1.is_none() && raised.0.elapsed() >= PATIENCE {
                let signals = Python::attach(|py| py.check_signals());
                *raised = (Instant::now(), signals.err());
            }
            raised.1.is_none()
        };
        let rows = py.detach(|| self.inner.rows(number, &goes_on));
        let raised = raised.into_inner().unwrap_or_else(PoisonError::into_inner);
        raised.1.map_or(Ok(rows), Err)
    }
}

/// The file of a sweep's table, which nobody else writes until it is closed.
#[pyclass(module = "hangtime._core")]
struct SweepTable {
    inner: Option<hangtime_cli::SweepTable>,
    rows: Vec<String>,
}

#[pymethods]
impl SweepTable {
    /// Goes on with the table at a path, or begins it.
    #[new]
    fn new(py: Python<'_>, path: PathBuf, plan: Py<SweepPlan>) -> PyResult<Self> {
        let plan = plan.get();
        let opened = py.detach(|| hangtime_cli::SweepTable::resume(&path, &plan.inner));
        let (inner, rows) = opened.map_err(|r| mistake(&r))?;
        let inner = Some(inner);
        Ok(Self { inner, rows })
    }

    /// The rows that were in it, lines of CSV.
    #[getter]
    fn rows(&self) -> Vec<String> {
        self.rows.clone()
    }

    /// Appends a row.
    fn append(&mut self, row: &str) -> PyResult<()> {
        match &mut self.inner {
            Some(table) => table.append(row).map_err(|r| mistake(&r)),
            None => Ok(()),
        }
    }

    /// Lets others write it.
    fn close(&mut self) {
        self.inner = None;
    }
}

impl SweepPlan {
    fn checked(&self, number: usize) -> PyResult<usize> {
        if number < self.inner.chains() {
            return Ok(number);
        }
        Err(PyIndexError::new_err(format!(
            "chain {number}: a sweep of {} chains counts from 0",
            self.inner.chains()
        )))
    }
}

/// The command line: arguments begin with the name of the program. It prints, and gives the exit status.
#[pyfunction]
fn run(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    let command_line = hangtime_cli::CommandLine::new(hangtime_models::scenes())
        .with_hard(hangtime_models::hard_scenes())
        .with_hard_optima(hangtime_models::hard_optima())
        .with_peers(hangtime_models::peers());
    py.detach(|| command_line.status(arguments))
}

/// Names of the shipped scenes.
#[pyfunction]
fn scene_names() -> Vec<&'static str> {
    let scenes = hangtime_models::scenes().iter();
    scenes.map(|scene| scene.name).collect()
}

/// Names of the options of a command, without dashes.
#[pyfunction]
fn options(command: &str) -> Vec<String> {
    hangtime_cli::options(command)
}

/// The native part of the package `hangtime`.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("Mistake", module.py().get_type::<Mistake>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<Scene>()?;
    module.add_class::<Run>()?;
    module.add_class::<SweepPlan>()?;
    module.add_class::<SweepTable>()?;
    module.add_class::<Program>()?;
    module.add("WARM_CHAIN", hangtime_cli::WARM_CHAIN)?;
    module.add_function(wrap_pyfunction!(solve_program, module)?)?;
    module.add_function(wrap_pyfunction!(program_options, module)?)?;
    module.add_function(wrap_pyfunction!(run, module)?)?;
    module.add_function(wrap_pyfunction!(scene_names, module)?)?;
    module.add_function(wrap_pyfunction!(options, module)?)
}
