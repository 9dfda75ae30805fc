//! Threads: a pool for each number that was asked for, and for each process, as a fork leaves a pool without its threads.

use crate::float_mode::Usual;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::any::Any;
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// By process and number of threads.
type Pools = HashMap<(u32, usize), Arc<ThreadPool>>;

static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

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
    let pool = pool(threads)?;
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

fn pool(threads: usize) -> PyResult<Arc<ThreadPool>> {
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let pools = pools.get_or_insert_default();
    let key = (std::process::id(), threads);
    if let Some(pool) = pools.get(&key) {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|number| format!("boxwood-{number}"))
        // Threads inherit the mode of the one that makes them.
        .start_handler(|_| std::mem::forget(Usual::enter()))
        .build()
        .map_err(|error| PyRuntimeError::new_err(format!("no {threads} threads: {error}")))?;
    let pool = Arc::new(pool);
    pools.insert(key, Arc::clone(&pool));
    Ok(pool)
}
