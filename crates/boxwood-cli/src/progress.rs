//! How far a long command has come, and how it is stopped.

use std::{
    fmt,
    io::{self, IsTerminal},
    sync::{
        Once,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

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
        let template =
            format!("{{bar:30}} {{percent:>3}} %  {{rate}} {unit}/s, {{eta}} left  {{msg}}");
        if let Ok(style) = ProgressStyle::with_template(&template) {
            let rate = |state: &ProgressState, to: &mut dyn fmt::Write| {
                let _ = to.write_str(&short(state.per_sec()));
            };
            bar.set_style(style.with_key("rate", rate).progress_chars("=> "));
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

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Becomes true when the user presses Ctrl-C (or the system asks the process to end). From the first call on Ctrl-C no
/// longer ends the process; a second Ctrl-C does.
pub(crate) fn interrupted() -> &'static AtomicBool {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let handler = || {
            if INTERRUPTED.swap(true, Ordering::SeqCst) {
                // The shell's number for a process that ended by Ctrl-C.
                std::process::exit(130);
            }
        };
        // Without a handler Ctrl-C ends the process, as ever.
        let _ = ctrlc::set_handler(handler);
    });
    &INTERRUPTED
}
