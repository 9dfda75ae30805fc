//! A query explained: its steps as data.

use super::{CellVisit, Counts, InstanceVisit, Observer, PrimitiveTest, VolumeTest};
use crate::geom::Hit;

/// Everything one query did, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Walk {
    /// The steps.
    pub steps: Vec<Step>,
    /// The answer.
    pub hit: Option<Hit>,
    /// The steps added up.
    pub counts: Counts,
}

/// One step of a [`Walk`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// A bounding volume was tested or dropped.
    Volume(VolumeTest),
    /// A node that was entered has its turn: what follows is inside it, up to the next turn. (Nested objects take turns at
    /// once, and after a child the rest of a node's children follow.)
    Turn(u32),
    /// A grid cell was entered.
    Cell(CellVisit),
    /// A primitive was tested.
    Primitive(PrimitiveTest),
    /// An instance was come to or left; the steps between are inside it, with its own numbers of nodes and primitives.
    Instance(InstanceVisit),
}

impl Observer for Walk {
    fn ray(&mut self) {
        self.counts.ray();
    }

    fn volume(&mut self, test: VolumeTest) {
        self.counts.volume(test);
        self.steps.push(Step::Volume(test));
    }

    fn turn(&mut self, node: u32) {
        self.steps.push(Step::Turn(node));
    }

    fn cell(&mut self, visit: CellVisit) {
        self.counts.cell(visit);
        self.steps.push(Step::Cell(visit));
    }

    fn primitive(&mut self, test: PrimitiveTest) {
        self.counts.primitive(test);
        self.steps.push(Step::Primitive(test));
    }

    fn instance(&mut self, visit: InstanceVisit) {
        self.counts.instance(visit);
        self.steps.push(Step::Instance(visit));
    }
}
