//! Long work: it runs on another thread, without the lock of the interpreter.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use tables::cli::Refused;

use crate::refusal;

/// Time between two looks for Ctrl-C.
const TICK: Duration = Duration::from_millis(50);

/// News of the work: its pieces, the number of those done, and the number of all if it is known.
type News = (String, u64, Option<u64>);

/// The side of the work: it tells what is done, and looks whether it is to stop.
pub(crate) struct Host {
    news: Mutex<Option<News>>,
    /// True if the work is to stop.
    pub(crate) stop: AtomicBool,
}

impl Host {
    /// Tells which pieces are done; may be called from any thread.
    pub(crate) fn tell(&self, what: &str, done: u64, of: Option<u64>) {
        let mut news = self.news.lock().unwrap_or_else(PoisonError::into_inner);
        *news = Some((what.to_owned(), done, of));
    }

    /// Returns the latest news, if there are any that were not told.
    fn take(&self) -> Option<News> {
        let mut news = self.news.lock().unwrap_or_else(PoisonError::into_inner);
        news.take()
    }
}

/// Does `work`, and tells `progress` of it some times a second.
///
/// # Errors
/// Returns what `work` refuses, what `progress` raises, and `KeyboardInterrupt` after Ctrl-C.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&Host) -> Result<T, Refused> + Send,
) -> PyResult<T> {
    let host = Host {
        news: Mutex::new(None),
        stop: AtomicBool::new(false),
    };
    let (made, raised) = py.detach(|| {
        thread::scope(|scope| {
            let (sender, receiver) = channel();
            let host = &host;
            let worker = scope.spawn(move || {
                let made = work(host);
                // The receiver waits until the sender is gone.
                let _ = sender.send(());
                made
            });
            let mut raised = None;
            while receiver.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                if let Err(error) = Python::attach(|py| look(py, host, progress.as_ref())) {
                    host.stop.store(true, Ordering::Relaxed);
                    raised.get_or_insert(error);
                }
            }
            (worker.join(), raised)
        })
    });
    match (raised, made) {
        (Some(error), _) => Err(error),
        (None, Ok(made)) => made.map_err(refusal),
        (None, Err(_)) => Err(refusal(
            "a fault inside of midair; report it with the lines above and what you called",
        )),
    }
}

/// Looks for Ctrl-C and hands on the news.
fn look(py: Python<'_>, host: &Host, progress: Option<&Py<PyAny>>) -> PyResult<()> {
    py.check_signals()?;
    if let (Some(progress), Some(news)) = (progress, host.take()) {
        progress.call1(py, news)?;
    }
    Ok(())
}
