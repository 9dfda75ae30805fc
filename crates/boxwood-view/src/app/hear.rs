//! What comes from the other threads.

use std::sync::Arc;

use super::App;
use crate::{
    Wish,
    picture::Painted,
    subject::{Built, Subject},
    workshop::{News, Ticket},
};

/// Warnings of a file that are passed on.
const WARNINGS: usize = 5;

impl App {
    /// Takes in all that is new; what is no longer wanted is dropped.
    pub(super) fn hear_all(&mut self) {
        while let Some((number, news)) = self.workshop.hear() {
            let jobs = &self.jobs;
            let all = [&jobs.opening, &jobs.building, &jobs.refining, &jobs.timing];
            if all.into_iter().flatten().any(|job| job.is(number)) {
                self.is_dirty = true;
                self.hear(number, news);
            }
        }
    }

    fn hear(&mut self, number: u64, news: News) {
        match news {
            News::Doing(doing) => self.jobs.doing = Some(doing),
            News::Opened(Ok((subject, built))) => self.opened(subject, built),
            News::Built(Ok(built), beside) => self.built(built, beside),
            News::Opened(Err(error)) => {
                self.not_built(error.to_string());
                self.failure = Some(error);
            }
            News::Built(Err(error), _) => self.not_built(error),
            News::Painted(painted) => self.painted(painted),
            News::Counted(counts, rays) => self.counted = Some((counts, rays)),
            News::Said(text) => self.say(text),
            News::Ended => self.ended(number),
        }
    }

    fn not_built(&mut self, error: String) {
        self.shown.split &= self.built.len() > 1;
        self.fail(error);
    }

    fn opened(&mut self, subject: Arc<Subject>, built: Arc<Built>) {
        for warning in subject.warnings().iter().take(WARNINGS) {
            self.wishes.push(Wish::Warn(warning.clone()));
        }
        let is_first = self.subject.is_none();
        if !is_first
            || self
                .message
                .as_ref()
                .is_some_and(|message| message.is_error)
        {
            self.message = None;
        }
        if let Some(asked) = self.asked.take() {
            self.watched = asked.watched;
        }
        self.camera = subject.camera;
        self.subject = Some(subject);
        self.built = vec![built];
        self.shown.split = false;
        self.picked = None;
        self.counted = None;
        self.scale.top = None;
        self.changed_look();
    }

    fn built(&mut self, built: Arc<Built>, beside: bool) {
        let end = self.built.len();
        self.built
            .insert(end - usize::from(beside && end > 0), built);
        self.built_changed();
    }

    /// A picture is there, at most as fine as the window.
    pub(super) fn painted(&mut self, painted: Painted) {
        self.exposure = self.exposure.or(painted.exposure);
        if self.look.starts_with("heat") && self.scale.top.is_none() {
            let highs = painted.scales.iter().map(|scale| scale.high);
            self.scale.top = highs.reduce(f32::max);
        }
        self.painted_share = painted.image.width as f32 / self.options.size[0] as f32;
        self.painted = Some(painted);
        if self.first_picture.is_none() {
            self.first_picture = Some(self.started.elapsed());
        }
    }

    fn ended(&mut self, number: u64) {
        let ends = |job: &mut Option<Ticket>| {
            let is_this = job.as_ref().is_some_and(|ticket| ticket.is(number));
            if is_this {
                *job = None;
            }
            is_this
        };
        let jobs = &mut self.jobs;
        ends(&mut jobs.refining);
        ends(&mut jobs.timing);
        if ends(&mut jobs.opening) | ends(&mut jobs.building) {
            jobs.doing = None;
        }
    }
}
