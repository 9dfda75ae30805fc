//! A picked ray and its walk through the structure, step by step.

use std::collections::HashMap;

use boxwood::{Aabb, Ray, Scene, geom::PreparedRay, query::NodeInfo};
use boxwood_trace::{BoxVerdict, Event, PrimitiveVerdict, WalkStep, WalkTrace};

use crate::{
    canvas::{BLUE, Canvas, Color, GREEN, GREY, ORANGE, Stroke, WHITE, YELLOW},
    overlay::wrapped,
    project::{Pen, Projector},
    subject::Built,
};

/// Steps that stay in the picture behind the one at work.
const TRAIL: usize = 400;
/// Most lines of the list of steps before the one at work, and after it.
const AROUND: usize = 7;

/// A ray, and how it found its answer.
#[derive(Debug)]
pub(crate) struct Picked {
    pub(crate) ray: Ray,
    walk: WalkTrace,
    /// What each step looked at.
    shapes: Vec<Shape>,
    /// Steps that are done.
    done: usize,
    /// Where the ray leaves the scene, or ends.
    end: f32,
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    Box(Aabb),
    Triangle([[f32; 3]; 3]),
    None,
}

impl Picked {
    /// Asks the structure how it answers `ray`; the first step is done.
    pub(crate) fn new(built: &Built, ray: Ray) -> Self {
        let walk = boxwood_trace::walk(&built.scene, &ray);
        let boxes = Boxes::of(built);
        let shape = |step: &WalkStep| match &step.event {
            Event::Box(test) => boxes.node(test.node),
            Event::Cell(visit) => boxes.cell(visit.cell),
            Event::Primitive(test) => match built.scene.triangle_in_scene(test.prim) {
                Some(triangle) => Shape::Triangle(triangle.0),
                None => Shape::None,
            },
            Event::Instance(_) => Shape::None,
        };
        let end = walk
            .hit
            .as_ref()
            .map(|hit| hit.t)
            .or_else(|| leaves(&built.scene, &ray));
        Self {
            shapes: walk.steps.iter().map(shape).collect(),
            done: walk.steps.len().min(1),
            end: end.unwrap_or(0.0),
            walk,
            ray,
        }
    }

    /// Goes so many steps on, or back.
    pub(crate) fn step(&mut self, steps: isize) {
        self.done = self
            .done
            .saturating_add_signed(steps)
            .min(self.walk.steps.len());
    }

    /// `step 14 of 63`.
    pub(crate) fn place(&self) -> String {
        format!("step {} of {}", self.done, self.walk.steps.len())
    }

    /// Draws the ray and what it looked at so far, the latest on top.
    pub(crate) fn draw(&self, canvas: &mut Canvas<'_>, projector: &Projector) {
        let first = self.done.saturating_sub(TRAIL);
        for number in first..self.done {
            let mut pen = pen_of(&self.walk.steps[number]);
            pen.is_faint = number + 1 < self.done;
            match &self.shapes[number] {
                Shape::Box(bounds) => projector.edges(canvas, bounds, pen),
                Shape::Triangle([a, b, c]) => {
                    for [from, to] in [[a, b], [b, c], [c, a]] {
                        projector.line(canvas, *from, *to, pen);
                    }
                }
                Shape::None => {}
            }
        }
        self.draw_ray(canvas, projector);
    }

    fn draw_ray(&self, canvas: &mut Canvas<'_>, projector: &Projector) {
        let at = |t: f32| [0, 1, 2].map(|k| self.ray.origin[k] + t * self.ray.dir[k]);
        let pen = Pen {
            color: WHITE,
            stroke: Stroke::Solid,
            is_faint: false,
        };
        projector.line(canvas, at(0.0), at(self.end), pen);
        // Where it ends, and, seen along the ray, where it is.
        if let Some([_, [x, y]]) = projector.segment(at(0.0), at(self.end)) {
            let arm = canvas.margin() as f32;
            canvas.line([x - arm, y], [x + arm, y], WHITE, Stroke::Solid);
            canvas.line([x, y - arm], [x, y + arm], WHITE, Stroke::Solid);
        }
    }

    /// The steps around the one at work, that one in full, who waits, and the answer: about so many rows of so many letters.
    pub(crate) fn lines(&self, rows: usize, letters: usize) -> Vec<(String, Color)> {
        let steps = &self.walk.steps;
        let at = self.done.saturating_sub(1);
        let mut end = vec![String::new()];
        if let Some(step) = steps.get(at) {
            end.extend(wrapped(&step.event.to_string(), letters));
            end.extend(wrapped(&waiting(step), letters).into_iter().take(2));
        }
        end.extend(wrapped(&self.walk.answer(), letters));
        end.extend(wrapped(&self.walk.cost(), letters));
        let around = (rows.saturating_sub(end.len() + 2) / 2).clamp(1, AROUND);
        let last = (at.saturating_sub(around) + 2 * around + 1).min(steps.len());
        let first = last.saturating_sub(2 * around + 1);
        let list = steps.iter().enumerate().take(last).skip(first);
        let list = list.map(|(number, step)| {
            let mark = if number == at { ">" } else { " " };
            let color = if number > at {
                GREY
            } else {
                pen_of(step).color
            };
            let text = format!("{mark} {:>4}  {}", number + 1, step.event);
            (cut(&text, letters), color)
        });
        let end = end.into_iter().map(|line| (line, WHITE));
        [(self.place(), WHITE)]
            .into_iter()
            .chain(list)
            .chain(end)
            .collect()
    }
}

/// The nodes that wait after a step, the next one first.
fn waiting(step: &WalkStep) -> String {
    match &step.stack_after[..] {
        [] => "nothing waits".to_owned(),
        nodes => {
            let numbers: Vec<String> = nodes.iter().rev().map(u32::to_string).collect();
            format!("waiting: {}", numbers.join(" "))
        }
    }
}

/// The beginning of a text that is too long.
fn cut(text: &str, letters: usize) -> String {
    match text.char_indices().nth(letters) {
        Some(_) => text
            .chars()
            .take(letters - 3)
            .chain("...".chars())
            .collect(),
        None => text.to_owned(),
    }
}

/// Where a ray leaves the bounds of a scene, if it meets them.
fn leaves(scene: &Scene, ray: &Ray) -> Option<f32> {
    let inside = scene.bounds().slab(&PreparedRay::new(ray)?, 0.0);
    (inside.near <= inside.far && inside.far.is_finite()).then_some(inside.far)
}

/// Colour and stroke both say what became of a step.
fn pen_of(step: &WalkStep) -> Pen {
    let (color, stroke) = match &step.event {
        Event::Box(test) => match test.verdict {
            BoxVerdict::Enter => (GREEN, Stroke::Solid),
            BoxVerdict::Miss => (BLUE, Stroke::Dotted),
            BoxVerdict::Farther | BoxVerdict::Dropped => (ORANGE, Stroke::Dashed),
        },
        Event::Cell(_) => (GREEN, Stroke::Solid),
        Event::Primitive(test) => match test.verdict {
            PrimitiveVerdict::Closest => (YELLOW, Stroke::Solid),
            PrimitiveVerdict::Farther | PrimitiveVerdict::OutOfRange => (ORANGE, Stroke::Dashed),
            PrimitiveVerdict::Miss => (BLUE, Stroke::Dotted),
        },
        Event::Instance(_) => (WHITE, Stroke::Solid),
    };
    Pen {
        color,
        stroke,
        is_faint: false,
    }
}

/// What the pens mean, for those who see the walk.
pub(crate) const MEANINGS: &[(&str, Color, Stroke)] = &[
    ("entered", GREEN, Stroke::Solid),
    ("missed", BLUE, Stroke::Dotted),
    ("culled: too far", ORANGE, Stroke::Dashed),
    ("closest so far", YELLOW, Stroke::Solid),
];

/// Where the nodes of a structure are.
struct Boxes<'a> {
    by_node: HashMap<u32, &'a NodeInfo>,
    /// Of a grid: its lower corner, and the size of a cell.
    grid: Option<([f32; 3], [f32; 3])>,
}

impl<'a> Boxes<'a> {
    fn of(built: &'a Built) -> Self {
        let nodes = built.nodes();
        let bounds = built.scene.bounds();
        // All cells are of one size, also those that hold nothing and are not listed.
        let cell = nodes.first().filter(|_| built.structure == "grid");
        let size = |node: &NodeInfo| [0, 1, 2].map(|k| node.bounds.max[k] - node.bounds.min[k]);
        Self {
            by_node: nodes.iter().map(|node| (node.node, node)).collect(),
            grid: cell.map(|node| (bounds.min, size(node))),
        }
    }

    fn node(&self, number: u32) -> Shape {
        self.by_node
            .get(&number)
            .map_or(Shape::None, |node| Shape::Box(node.bounds))
    }

    fn cell(&self, cell: [u32; 3]) -> Shape {
        let Some((origin, size)) = self.grid else {
            return Shape::None;
        };
        let face = |k: usize, i: u32| origin[k] + size[k] * i as f32;
        Shape::Box(Aabb {
            min: [0, 1, 2].map(|k| face(k, cell[k])),
            max: [0, 1, 2].map(|k| face(k, cell[k] + 1)),
        })
    }
}
