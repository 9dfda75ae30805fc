//! The boxes of a structure, those of one depth at a time.

use boxwood::query::NodeInfo;

use crate::{
    canvas::{BLUE, Canvas, ORANGE, Stroke},
    project::{Pen, Projector},
    subject::Built,
};

/// More boxes only hide each other, and take longer than a frame may.
const MOST: usize = 2000;

/// Draws the nodes at `depth`, and leaves dashed; says what it shows.
pub(crate) fn draw(
    canvas: &mut Canvas<'_>,
    projector: &Projector,
    built: &Built,
    depth: u32,
) -> String {
    let nodes = built.nodes();
    // A grid has one layer.
    let deepest = nodes.iter().map(|node| node.depth).max().unwrap_or(0);
    let depth = depth.min(deepest);
    let shown: Vec<&NodeInfo> = nodes.iter().filter(|node| node.depth == depth).collect();
    // Evenly chosen, where there are too many.
    let every = shown.len().div_ceil(MOST).max(1);
    for node in shown.iter().step_by(every) {
        let pen = match node.prims {
            None => Pen {
                color: BLUE,
                stroke: Stroke::Solid,
                is_faint: shown.len() > 200,
            },
            Some(_) => Pen {
                color: ORANGE,
                stroke: Stroke::Dashed,
                is_faint: shown.len() > 200,
            },
        };
        projector.edges(canvas, &node.bounds, pen);
    }
    let leaves = shown.iter().filter(|node| node.prims.is_some()).count();
    let part = match every {
        1 => String::new(),
        every => format!(", 1 of {every} drawn"),
    };
    match shown.len() {
        0 => format!("{} has no boxes", built.structure),
        count => format!("depth {depth} of {deepest}: {count} boxes, {leaves} leaves{part}"),
    }
}
