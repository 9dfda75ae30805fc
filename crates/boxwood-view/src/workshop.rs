//! What takes time is done on threads of its own, which send what they make.

use std::{
    fmt,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
    thread,
};

use boxwood::Counts;

use crate::{
    ViewError,
    picture::Painted,
    subject::{Built, Subject},
};

/// Called, from any thread, when there is news.
pub type Wake = dyn Fn() + Send + Sync;

/// What a thread has to say.
#[derive(Debug)]
pub(crate) enum News {
    /// What it is at, for the user.
    Doing(String),
    /// A new subject in its first structure.
    Opened(Result<(Arc<Subject>, Arc<Built>), ViewError>),
    /// Another structure around the subject; if so, to be shown beside the present one.
    Built(Result<Arc<Built>, String>, bool),
    /// A finer picture.
    Painted(Painted),
    /// The work of so many camera rays.
    Counted(Counts, u32),
    /// A line for the user.
    Said(String),
    /// The last news of each piece of work, whatever became of it.
    Ended,
}

/// Hands out work.
pub(crate) struct Workshop {
    sender: Sender<(u64, News)>,
    news: Receiver<(u64, News)>,
    wake: Arc<Wake>,
    last: u64,
}

/// A piece of work that is wanted: drop it, and the work ends soon.
#[derive(Debug)]
pub(crate) struct Ticket {
    number: u64,
    cancel: Arc<AtomicBool>,
}

/// Where a piece of work is done.
pub(crate) struct Desk {
    number: u64,
    sender: Sender<(u64, News)>,
    wake: Arc<Wake>,
    cancel: Arc<AtomicBool>,
}

impl Workshop {
    pub(crate) fn new(wake: Arc<Wake>) -> Self {
        let (sender, news) = channel();
        Self {
            sender,
            news,
            wake,
            last: 0,
        }
    }

    /// Starts `work` on a new thread.
    pub(crate) fn start(&mut self, work: impl FnOnce(&Desk) + Send + 'static) -> Ticket {
        self.last += 1;
        let cancel = Arc::new(AtomicBool::new(false));
        let desk = Desk {
            number: self.last,
            sender: self.sender.clone(),
            wake: Arc::clone(&self.wake),
            cancel: Arc::clone(&cancel),
        };
        // Where the system grants no thread, the desk is dropped, and that is told like any end.
        let thread = thread::Builder::new().name("boxwood-view".to_owned());
        let _ = thread.spawn(move || work(&desk));
        Ticket {
            number: self.last,
            cancel,
        }
    }

    /// The next news, with the number of the work.
    pub(crate) fn hear(&self) -> Option<(u64, News)> {
        self.news.try_recv().ok()
    }
}

impl fmt::Debug for Workshop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Workshop")
            .field("last", &self.last)
            .finish_non_exhaustive()
    }
}

impl Ticket {
    /// True if news with that number are of this work.
    pub(crate) fn is(&self, number: u64) -> bool {
        self.number == number
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Desk {
    pub(crate) fn tell(&self, news: News) {
        // Nobody listens any more: then nobody misses it.
        let _ = self.sender.send((self.number, news));
        (self.wake)();
    }

    /// True once nobody wants the work.
    pub(crate) fn stop(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    pub(crate) fn cancel(&self) -> &Arc<AtomicBool> {
        &self.cancel
    }

    /// For reports from the threads of a build.
    pub(crate) fn teller(&self) -> impl Fn(News) + Send + Sync + 'static {
        let (number, sender, wake) = (self.number, self.sender.clone(), Arc::clone(&self.wake));
        move |news| {
            let _ = sender.send((number, news));
            wake();
        }
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.tell(News::Ended);
    }
}
