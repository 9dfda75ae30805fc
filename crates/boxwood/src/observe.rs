//! Watching a query at work. The watcher is a type parameter: the one that ignores everything compiles to nothing.

use crate::geom::Candidate;
use std::ops::{Add, AddAssign};

/// Told of every test that a query makes.
pub trait Observer {
    /// A ray is asked about.
    fn ray(&mut self) {}
    /// A volume was tested, or a node was dropped without a test.
    fn volume(&mut self, _test: VolumeTest) {}
    /// A node that the ray enters has its turn: what follows is inside it, up to the next turn.
    fn turn(&mut self, _node: u32) {}
    /// A grid cell was entered.
    fn cell(&mut self, _visit: CellVisit) {}
    /// A primitive was tested.
    fn primitive(&mut self, _test: PrimitiveTest) {}
    /// An instance was come to, or left again.
    fn instance(&mut self, _visit: InstanceVisit) {}
    /// False if nothing is done with all this: then scenes inside scenes need not tell.
    fn is_watching(&self) -> bool {
        true
    }
}

/// Who watches a query whose type knows no observer; `None` costs nothing.
pub type Watch<'a> = Option<&'a mut dyn Observer>;

/// The observer as scenes inside scenes take it.
#[inline]
pub(crate) fn watch<O: Observer>(observer: &mut O) -> Watch<'_> {
    observer
        .is_watching()
        .then_some(observer as &mut dyn Observer)
}

impl<O: Observer + ?Sized> Observer for &mut O {
    fn ray(&mut self) {
        (**self).ray();
    }

    fn volume(&mut self, test: VolumeTest) {
        (**self).volume(test);
    }

    fn turn(&mut self, node: u32) {
        (**self).turn(node);
    }

    fn cell(&mut self, visit: CellVisit) {
        (**self).cell(visit);
    }

    fn primitive(&mut self, test: PrimitiveTest) {
        (**self).primitive(test);
    }

    fn instance(&mut self, visit: InstanceVisit) {
        (**self).instance(visit);
    }

    fn is_watching(&self) -> bool {
        (**self).is_watching()
    }
}

/// One bounding volume against the ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeTest {
    /// Number of the node.
    pub node: u32,
    /// Where the ray enters the volume, in `t`.
    pub near: f32,
    /// Where it leaves; before `near` for a miss.
    pub far: f32,
    /// What follows.
    pub verdict: VolumeVerdict,
    /// Operations spent.
    pub flops: u32,
    /// Memory read.
    pub bytes: u32,
}

/// Why a node is looked into or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VolumeVerdict {
    /// The ray meets the volume: its content is asked.
    Enter,
    /// The line misses the volume, or meets it only outside the ray's range.
    Miss,
    /// The volume begins behind the closest hit so far.
    Farther,
    /// It was to be entered, but by its turn a closer hit was known. No test: 0 operations.
    Dropped,
}

/// One cell of the uniform grid on the ray's way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellVisit {
    /// Column, row, layer.
    pub cell: [u32; 3],
    /// Where the ray enters, in `t`.
    pub enter: f64,
    /// The lecture's constant offset: `t` between two faces of each axis; infinite across a zero direction, NaN for a
    /// ray from so far away that it walks whole layers.
    pub t_delta: [f64; 3],
    /// `t` of the next face of each axis. The smallest is where the ray goes on.
    pub t_next: [f64; 3],
    /// References in the cell.
    pub prims: u32,
    /// Operations of the step.
    pub flops: u32,
    /// Memory read.
    pub bytes: u32,
}

/// One primitive against the ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveTest {
    /// Number in the scene.
    pub prim: u32,
    /// What the test found in the ray's range.
    pub candidate: Option<Candidate>,
    /// What follows.
    pub verdict: PrimitiveVerdict,
    /// Operations spent.
    pub flops: u32,
    /// Memory read.
    pub bytes: u32,
}

/// What a primitive test means for the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrimitiveVerdict {
    /// Not hit in the ray's range.
    Miss,
    /// Hit, but not before the best so far.
    Farther,
    /// The new best.
    Closest,
}

/// One instance on the ray's way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstanceVisit {
    /// Number of the instance in the scene that it stands in.
    pub instance: u32,
    /// What follows.
    pub verdict: InstanceVerdict,
    /// Operations spent on turning the ray.
    pub flops: u32,
    /// Memory read.
    pub bytes: u32,
}

/// What becomes of the ray at an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstanceVerdict {
    /// It goes on inside, turned into the instance's own space.
    Enter,
    /// It and the instance have no bit of their masks in common.
    Masked,
    /// In the instance's space it would not be a ray: out of range.
    Miss,
    /// It comes out again.
    Leave,
}

/// Ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoObserver;

impl Observer for NoObserver {
    #[inline(always)]
    fn is_watching(&self) -> bool {
        false
    }
}

/// The work of queries, added up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays asked about.
    pub rays: u64,
    /// Nodes or grid cells looked into.
    pub nodes: u64,
    /// Bounding volume tests.
    pub boxes: u64,
    /// Primitive tests.
    pub prims: u64,
    /// Instances entered.
    pub instances: u64,
    /// Floating-point operations of the tests above: additions, subtractions, products, quotients, roots, minima and
    /// maxima, by the constants that stand beside each test. As on the slides, a comparison that only decides where to
    /// go on is not counted, nor is preparing a ray.
    pub flops: u64,
    /// Bytes of nodes, cells, references and primitives read, whether cached or not.
    pub bytes: u64,
}

impl Observer for Counts {
    #[inline]
    fn ray(&mut self) {
        self.rays += 1;
    }

    #[inline]
    fn volume(&mut self, test: VolumeTest) {
        self.nodes += u64::from(test.verdict == VolumeVerdict::Enter);
        self.boxes += u64::from(test.verdict != VolumeVerdict::Dropped);
        self.flops += u64::from(test.flops);
        self.bytes += u64::from(test.bytes);
    }

    #[inline]
    fn cell(&mut self, visit: CellVisit) {
        self.nodes += 1;
        self.flops += u64::from(visit.flops);
        self.bytes += u64::from(visit.bytes);
    }

    #[inline]
    fn primitive(&mut self, test: PrimitiveTest) {
        self.prims += 1;
        self.flops += u64::from(test.flops);
        self.bytes += u64::from(test.bytes);
    }

    #[inline]
    fn instance(&mut self, visit: InstanceVisit) {
        self.instances += u64::from(visit.verdict == InstanceVerdict::Enter);
        self.flops += u64::from(visit.flops);
        self.bytes += u64::from(visit.bytes);
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.nodes += other.nodes;
        self.boxes += other.boxes;
        self.prims += other.prims;
        self.instances += other.instances;
        self.flops += other.flops;
        self.bytes += other.bytes;
    }
}

impl Add for Counts {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl std::iter::Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), Add::add)
    }
}
