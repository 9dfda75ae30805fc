//! Work on the package's own threads, while the interpreter is let go.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

/// How often a call looks whether the user wants to end it.
const LOOK: Duration = Duration::from_millis(50);

/// Lets the interpreter go and runs `work` on so many threads. Ctrl-C sets the flag, after which `work` should end soon; its
/// answer is then dropped and the interrupt raised.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    threads: usize,
    work: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    // While the interpreter is held, so that no other thread of Python forks the process in the middle of it.
    let pool = boxwood_host::pool(threads)
        .map_err(|error| PyRuntimeError::new_err(format!("no {threads} threads: {error}")))?;
    let cancel = AtomicBool::new(false);
    let run = || {
        let (sender, answer) = sync_channel(1);
        pool.in_place_scope(|scope| {
            // A panic drops the sender, and the scope passes it on.
            let cancel = &cancel;
            scope.spawn(move |_| {
                let _ = sender.send(work(cancel));
            });
            loop {
                match answer.recv_timeout(LOOK) {
                    Ok(answer) => return Ok(answer),
                    Err(RecvTimeoutError::Disconnected) => return Err(fault("")),
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(interrupt) = Python::attach(|py| py.check_signals()) {
                            cancel.store(true, Ordering::Relaxed);
                            return Err(interrupt);
                        }
                    }
                }
            }
        })
    };
    py.detach(|| catch_unwind(AssertUnwindSafe(run)))
        .unwrap_or_else(|panic| Err(fault(message(&*panic))))
}

/// What is our own mistake, told as an error that programs can catch.
fn fault(text: &str) -> PyErr {
    PyRuntimeError::new_err(format!("Boxwood made a mistake, please report it: {text}"))
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("")
}
