//! How far a long command has come, and how it is stopped.

use std::{
    fmt,
    io::{self, IsTerminal},
    path::{Path, PathBuf},
    sync::{
        Mutex, MutexGuard, Once, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::output::short;

/// A bar with rate and remaining time on stderr; nothing where stderr is no terminal. Gone when it is dropped.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// For `total` pieces of work; `unit` is their name in the plural, as in `pixels`.
    pub(crate) fn new(total: u64, unit: &str) -> Self {
        if !io::stderr().is_terminal() {
            return Self {
                bar: ProgressBar::hidden(),
            };
        }
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr_with_hz(8));
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3} %  {pace}{msg}") {
            let unit = unit.to_owned();
            let pace = move |state: &ProgressState, to: &mut dyn fmt::Write| {
                // Before the first piece is done nobody knows.
                if state.pos() > 0 {
                    let (rate, left) = (short(state.per_sec()), HumanDuration(state.eta()));
                    let _ = write!(to, "{rate} {unit}/s, {left:#} left  ");
                }
            };
            bar.set_style(style.with_key("pace", pace).progress_chars("=> "));
        }
        bar.enable_steady_tick(Duration::from_millis(250));
        Self { bar }
    }

    /// `done` pieces are done. From any thread; a smaller number than before is ignored.
    pub(crate) fn set(&self, done: u64) {
        if done > self.bar.position() {
            self.bar.set_position(done);
        }
    }

    /// There are `total` pieces of work after all.
    pub(crate) fn limit(&self, total: u64) {
        self.bar.set_length(total);
    }

    /// What is going on, behind the bar.
    pub(crate) fn say(&self, message: impl Into<String>) {
        self.bar.set_message(message.into());
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// The user, or the system, wants the process to end.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// The command looks at [`INTERRUPTED`] and ends by itself.
static ENDS_ITSELF: AtomicBool = AtomicBool::new(false);
/// The file that is being written, which must not outlive the process.
static UNFINISHED: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Becomes true when the user presses Ctrl-C, or the system asks the process to end (SIGTERM, SIGHUP). From the first call
/// on that no longer ends the process; the second time does.
pub(crate) fn interrupted() -> &'static AtomicBool {
    ENDS_ITSELF.store(true, Ordering::SeqCst);
    handle();
    &INTERRUPTED
}

/// Runs `save` such that a process that is ended meanwhile takes the unfinished file along, whose path `save` tells to the
/// function that it is given once the file is there.
pub(crate) fn unfinished<T>(save: impl FnOnce(&mut dyn FnMut(&Path)) -> T) -> T {
    handle();
    // Held until the path is known: the process does not end in between.
    let mut slot = Some(lock());
    let result = save(&mut |path| {
        if let Some(mut slot) = slot.take() {
            *slot = Some(path.to_owned());
        }
    });
    drop(slot);
    *lock() = None;
    result
}

fn lock() -> MutexGuard<'static, Option<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Once. Without a handler signals end the process, as ever.
fn handle() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let handler = || {
            let again = INTERRUPTED.swap(true, Ordering::SeqCst);
            if again || !ENDS_ITSELF.load(Ordering::SeqCst) {
                let unfinished = lock();
                if let Some(path) = &*unfinished {
                    let _ = std::fs::remove_file(path);
                }
                // The shell's number for a process that ended by Ctrl-C.
                std::process::exit(130);
            }
        };
        // A handler would end what `nohup` is to keep alive.
        if !hangup_is_ignored() {
            let _ = ctrlc::set_handler(handler);
        }
    });
}

/// Known on Linux only.
fn hangup_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // Signal 1 is the lowest bit.
    ignored.is_some_and(|mask| mask & 1 == 1)
}
