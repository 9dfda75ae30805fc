//! Scenes are read in the background, and again when their files change.

use std::{sync::Arc, time::Duration};

use super::{App, act::reporter};
use crate::{
    Matter, ViewError,
    subject::{Aim, Built, Subject},
    watch::Watched,
    workshop::News,
};

/// A scene by its name.
#[derive(Clone, Debug)]
pub(super) struct Asked {
    name: String,
    aim: Aim,
    pub(super) watched: Option<Watched>,
}

impl App {
    /// Reads a scene in the background; what is shown stays until it is there.
    pub(super) fn open(&mut self, name: &str, aim: Aim) {
        self.expect(name, aim);
        self.failure = None;
        let (name, open) = (name.to_owned(), Arc::clone(&self.options.open));
        let (structure, options) = (self.options.structure.name, self.options.build.clone());
        let structure = self.built.last().map_or(structure, |built| built.structure);
        let size = self.options.size;
        self.jobs.doing = Some(format!("reading {name}"));
        self.jobs.building = None;
        self.jobs.opening = Some(self.workshop.start(move |desk| {
            let refused = |cause: String| ViewError::new(Matter::Scene, cause);
            let opened = || -> Result<_, ViewError> {
                let loaded = open(&name).map_err(refused)?;
                let report = reporter(desk, structure);
                let built = Built::new(&loaded.1, structure, &options, desk.cancel(), report);
                let built = built.map_err(|error| refused(format!("{name}: {error}")))?;
                let subject = Subject::new(&name, loaded, &built.scene, &aim, size)?;
                Ok((Arc::new(subject), Arc::new(built)))
            };
            desk.tell(News::Opened(opened()));
        }));
    }

    /// Watches the file from before it is read, so that no change is missed, also where it is broken or missing.
    fn expect(&mut self, name: &str, aim: Aim) {
        let watched = Watched::new(name);
        let is_shown = self.subject.as_ref().is_some_and(|it| it.name == name);
        self.asked = (!is_shown).then(|| Asked {
            name: name.to_owned(),
            aim,
            watched: watched.clone(),
        });
        if is_shown {
            self.watched = watched;
        }
    }

    /// Reads what has changed again: what was asked for and could not be shown, else what is shown, from the same camera.
    pub(super) fn look_at_files(&mut self, time: Duration) {
        let has_changed = |watched: &mut Option<Watched>| {
            watched
                .as_mut()
                .is_some_and(|watched| watched.has_changed(time))
        };
        let asked = self.asked.as_mut().and_then(|asked| {
            has_changed(&mut asked.watched).then(|| (asked.name.clone(), asked.aim))
        });
        let shown = has_changed(&mut self.watched);
        let shown = self.subject.as_ref().filter(|_| shown);
        let shown = shown.map(|subject| (subject.name.clone(), Aim::at(&self.camera)));
        if let Some((name, aim)) = asked.or(shown) {
            self.open(&name, aim);
        }
    }
}
