//! A frame: the picture, as fine as time allows, and what is drawn on top.

use std::time::{Duration, Instant};

use boxwood_render::Image;

use super::{App, STILL, TIMES};
use crate::{
    canvas::{Canvas, DARK, GREY, RED, Stroke, WHITE},
    overlay,
    picture::stretch,
    project::Projector,
};

/// A picture that takes so many times as long as it may is given up.
const PATIENCE: f32 = 1.3;

impl App {
    /// Draws the frame, in the size of the window.
    ///
    /// Where what it shows has moved, the picture is made anew, coarse enough for 30 frames a second. Whoever shows the frame
    /// says how long that took to [`App::presented`].
    pub fn draw(&mut self) -> &Image {
        let start = Instant::now();
        self.is_dirty = false;
        let rays = if self.is_stale { self.paint() } else { None };
        self.compose();
        let time = start.elapsed();
        if let Some(rays) = rays {
            self.times.push_back(time);
            self.pace.rest_took(time.saturating_sub(rays));
            if self.times.len() > TIMES {
                self.times.pop_front();
            }
        }
        &self.frame
    }

    /// The frame is on the screen, which took `time`.
    pub fn presented(&mut self, time: Duration) {
        self.pace.presenting_took(time);
    }

    /// The share of the window's sides at which the camera's last move was drawn.
    pub fn share(&self) -> f32 {
        self.painted_share
    }

    /// Makes the picture anew; how long its rays took.
    fn paint(&mut self) -> Option<Duration> {
        let Some(shot) = self.shot() else {
            self.is_stale = false;
            return None;
        };
        let start = Instant::now();
        let deadline = start + self.pace.budget().mul_f32(PATIENCE);
        let share = self.pace.share();
        let painted = shot.paint(share, &|| Instant::now() > deadline);
        let time = start.elapsed();
        match painted {
            Some(painted) => {
                self.is_stale = false;
                self.pace.rays_took(time);
                self.painted(painted);
            }
            None => {
                // The old picture stays; where even the coarsest takes too long, the next one is made in the background.
                self.is_stale = self.pace.gave_up();
                self.painted_share = share * 0.5;
            }
        }
        self.refine_at = Some(Instant::now() + STILL);
        Some(time)
    }

    fn compose(&mut self) {
        match &self.painted {
            Some(painted) => stretch(&painted.image, &mut self.frame),
            None => self.frame.rgb.fill(DARK),
        }
        let mut frame = std::mem::replace(&mut self.frame, crate::picture::no_image());
        self.draw_on_top(&mut Canvas::new(&mut frame));
        self.frame = frame;
    }

    fn draw_on_top(&self, canvas: &mut Canvas<'_>) {
        let projector = Projector::new(&self.camera, self.options.size);
        let mut notes = Vec::new();
        if let (true, Some(built)) = (self.shown.boxes, self.built.last()) {
            notes.push(overlay::boxes(canvas, &projector, built, self.shown.depth));
        }
        if let Some(picked) = &self.picked {
            picked.draw(canvas, &projector);
        }
        self.draw_scales(canvas);
        if self.shown.numbers {
            let mut lines = self.numbers();
            lines.extend(notes.into_iter().map(|note| (note, WHITE)));
            canvas.paragraph(canvas.margin(), canvas.margin(), &lines);
        }
        if let Some(picked) = &self.picked {
            overlay::walk(canvas, picked);
        }
        if self.shown.graph {
            overlay::graph(canvas, &self.times);
        }
        self.draw_message(canvas);
        if self.shown.help > 0 {
            overlay::sheet(canvas, self.shown.help);
        }
    }

    /// Legends of costs and depths; in a split picture one for each half.
    fn draw_scales(&self, canvas: &mut Canvas<'_>) {
        let scales = self.painted.iter().flat_map(|painted| &painted.scales);
        let half = canvas.width() / 2;
        let is_split = self
            .painted
            .as_ref()
            .is_some_and(|painted| painted.scales.len() > 1);
        if is_split {
            let x = half as f32;
            canvas.line([x, 0.0], [x, canvas.height() as f32], WHITE, Stroke::Solid);
        }
        for (number, scale) in (0..).zip(scales) {
            let built = self.built.iter().rev().nth(number as usize);
            let name = built.map_or("", |built| built.structure);
            overlay::legend(canvas, number * half, scale, name);
        }
    }

    /// What is shown, and what it costs.
    fn numbers(&self) -> Vec<(String, [u8; 3])> {
        let (Some(subject), Some(built)) = (&self.subject, self.built.last()) else {
            return Vec::new();
        };
        let [width, height] = self.options.size;
        let samples = self.painted.as_ref().map_or(0, |painted| painted.samples);
        let fine = match (self.painted_share, samples) {
            (share, _) if share < 1.0 => format!("{:.0} % of {width} x {height}", share * 100.0),
            (_, 0 | 1) => format!("{width} x {height}"),
            (_, samples) => format!("{width} x {height} x {samples}"),
        };
        let mut lines = vec![
            (
                format!("{}: {} triangles", subject.short_name(), built.scene.len()),
                WHITE,
            ),
            (
                format!(
                    "{}: built in {:.1} ms, {:.1} MiB",
                    built.structure,
                    built.time.as_secs_f64() * 1e3,
                    built.mebibytes()
                ),
                WHITE,
            ),
        ];
        lines.push((
            match self.counted {
                Some((counts, rays)) => {
                    let per_ray = |count: u64| count as f64 / f64::from(rays.max(1));
                    format!(
                        "per ray: {:.1} boxes, {:.1} triangles",
                        per_ray(counts.boxes.max(counts.nodes)),
                        per_ray(counts.prims)
                    )
                }
                None => "per ray: ...".to_owned(),
            },
            WHITE,
        ));
        let rate = self
            .rate()
            .map_or(String::new(), |rate| format!(", {rate:.0} frames/s"));
        lines.push((format!("{}, {fine}{rate}", self.look), GREY));
        lines.push(("h: all keys".to_owned(), GREY));
        lines
    }

    /// What happens, or happened; above the middle of the lower edge.
    fn draw_message(&self, canvas: &mut Canvas<'_>) {
        let doing = self
            .jobs
            .doing
            .as_ref()
            .map(|doing| (format!("{doing} ..."), WHITE));
        let said = self.message.as_ref().map(|message| {
            let color = if message.is_error { RED } else { WHITE };
            (message.text.clone(), color)
        });
        let most = canvas
            .letters_in(canvas.width() - 4 * canvas.margin())
            .max(8);
        let lines: Vec<_> = said
            .into_iter()
            .chain(doing)
            .flat_map(|(text, color)| {
                overlay::wrapped(&text, most)
                    .into_iter()
                    .map(move |line| (line, color))
            })
            .collect();
        if lines.is_empty() {
            return;
        }
        let [width, height] = canvas.paragraph_size(&lines);
        let x = (canvas.width() - width) / 2;
        let y = match &self.painted {
            Some(painted) => {
                let below = match painted.scales.is_empty() {
                    true => 0,
                    false => overlay::legend_height(canvas),
                };
                canvas.height() - height - canvas.margin() - below
            }
            None => (canvas.height() - height) / 2,
        };
        canvas.paragraph(x, y, &lines);
    }
}
