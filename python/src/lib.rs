//! What the Python package `hangtime` calls: scenes, runs and sweeps of the command line's library, words in and JSON out.
//!
//! The package itself is written in Python, in `hangtime/`; it makes arrays and pictures of what comes from here.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use hangtime::Progress;
use hangtime_cli::{HostRun, HostScene, Refusal};
use pyo3::create_exception;
use pyo3::exceptions::{PyIndexError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

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

/// What a run does, in words.
fn words_of(now: &Progress) -> String {
    now.to_string()
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
                    interruption(py, progress.as_ref(), Some(now.time), &words_of(now))
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

    /// One solve, in a thread of its own. Ctrl-C ends it with the best motion so far; where there is none, by
    /// `KeyboardInterrupt`.
    #[pyo3(signature = (words, progress=None))]
    fn solve(
        &self,
        py: Python<'_>,
        words: Vec<String>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Run> {
        let stop = Arc::new(AtomicBool::new(false));
        let (said, heard) = mpsc::channel();
        // The wait for a word goes on without the interpreter's lock, which asks for shared access.
        let heard = Mutex::new(heard);
        let (scene, asked) = (self.inner.clone(), Arc::clone(&stop));
        let work = move || {
            let mut told = Instant::now();
            scene.solve(&words, &mut |now| {
                if told.elapsed() >= PATIENCE {
                    told = Instant::now();
                    // The listener may be about to leave.
                    let _ = said.send(words_of(now));
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
                Ok(words) => interruption(py, progress.as_ref(), None, words),
                Err(RecvTimeoutError::Timeout) => py.check_signals(),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if let Err(error) = told {
                stop.store(true, Ordering::Relaxed);
                raised.get_or_insert(error);
            }
        }
        let run = py
            .detach(|| worker.join())
            .map_err(|_| PyRuntimeError::new_err("internal_error: the solver panicked"))?
            .map_err(|r| mistake(&r))?;
        let interrupt = raised.filter(|raised| {
            let interrupt = raised.is_instance_of::<pyo3::exceptions::PyKeyboardInterrupt>(py);
            !(interrupt && run.has_motion())
        });
        match interrupt {
            Some(raised) => Err(raised),
            None => Ok(Run::new(run)),
        }
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
        over: Vec<String>,
        words: Vec<String>,
        record: Vec<String>,
    ) -> PyResult<Self> {
        let scene = scene.inner.clone();
        let plan = py.detach(|| hangtime_cli::SweepPlan::new(scene, solve, &over, &words, &record));
        plan.map(|inner| Self { inner }).map_err(|r| mistake(&r))
    }

    /// How many points there are.
    fn __len__(&self) -> usize {
        self.inner.count()
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

    /// Computes the row of a point, a line of CSV.
    fn row(&self, py: Python<'_>, number: usize) -> PyResult<String> {
        if number >= self.inner.count() {
            return Err(PyIndexError::new_err(format!(
                "point {number}: a sweep of {} points counts from 0",
                self.inner.count()
            )));
        }
        let row = py.detach(|| self.inner.row(number, &|| true));
        py.check_signals()?;
        Ok(row)
    }
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
    module.add_function(wrap_pyfunction!(scene_names, module)?)?;
    module.add_function(wrap_pyfunction!(options, module)?)
}
