//! Who watches the picture while it is made: a viewer with tev's protocol, and clients of the live page.

use std::time::Duration;

use gi_core::film::Film;

use crate::display::Display;
use crate::preview::Preview;
use crate::record::SoFar;
use crate::say::say;
use crate::serve::{Page, Stage};
use crate::stop::Signal;
use crate::{Common, Failure};

/// Time between two pictures of a viewer, unless they cost too much.
const EVERY: Duration = Duration::from_millis(500);

/// Who watches.
pub(crate) struct Views {
    display: Option<Display>,
    page: Option<Page>,
}

impl Views {
    /// Connect with the viewer and serve the page, as the command line says.
    pub(crate) fn open(common: &Common, program: &str, picture: String) -> Result<Self, Failure> {
        let display = common.display_server.as_ref();
        let display = display.map(|at| Display::connect(at, picture)).transpose()?;
        let scene = common.scene.display().to_string();
        let open = |address| Page::open(address, program, &scene, common.quiet);
        Ok(Views { display, page: common.serve.as_ref().map(open).transpose()? })
    }

    /// The live page.
    pub(crate) fn page(&self) -> Option<&Page> {
        self.page.as_ref()
    }

    /// Tell the page the size of the picture.
    pub(crate) fn set_size(&self, size: [usize; 2]) {
        if let Some(page) = &self.page {
            page.set_size(size);
        }
    }

    /// Tell the page what the run does from now on.
    pub(crate) fn enter(&self, stage: Stage) {
        if let Some(page) = &self.page {
            page.enter(stage);
        }
    }

    /// The previews that are sent during the run.
    pub(crate) fn previews(&mut self, size: [usize; 2]) -> Vec<Preview<'_>> {
        let mut all = Vec::new();
        if let Some(display) = &mut self.display {
            let send = |layers, _: &_| display.send(layers);
            all.push(Preview::new("live view", EVERY, size, send));
        }
        if let Some(page) = &self.page {
            let show = |layers, so_far: &SoFar| {
                page.show(layers, so_far);
                Ok(())
            };
            let preview = Preview::new("live page", EVERY, size, show);
            all.push(preview.while_watched(|| page.watched()));
        }
        all
    }

    /// Show the last picture.
    pub(crate) fn finish(&mut self, film: &Film, so_far: &SoFar) {
        if let Some(display) = &mut self.display
            && let Err(failure) = display.send(film.layers())
        {
            say(format!("warning: no live view: {}", failure.text()));
        }
        if let Some(page) = self.page.as_ref().filter(|page| page.watched().is_some()) {
            page.show(film.layers(), so_far);
        }
    }

    /// Tell the page how the run has ended.
    pub(crate) fn end(&self, result: &Result<Option<Signal>, Failure>) {
        let Some(page) = &self.page else { return };
        page.end(match result {
            Ok(None) => "finished".to_string(),
            Ok(Some(signal)) => format!("stopped by {}", signal.name()),
            Err(failure) => failure.text().trim_end().to_string(),
        });
    }
}
