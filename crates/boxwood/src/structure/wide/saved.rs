//! A tree that was saved: which bytes are one, and how they are asked.
//!
//! Only what [`emit`](super::emit) writes is a tree: nodes one behind the other, depth first, each with its leaves behind it. So one
//! pass from front to back meets every byte once and knows at each place what must stand there: no node is missing, shared or its own
//! ancestor, no leaf lies elsewhere, and the stack of a traversal suffices.

use super::emit::{LINE, SLACK};
use super::form::{Form, Store};
use super::full::{NUMBERS, leaf_floats, leaf_granules};
use super::layout::{MAX_GRANULES, Ref, WIDTH, bounds};
use super::triangles::WideTriangles;
use super::{Full, Wide, ray};
use crate::build::{BuildOptions, MAX_DEPTH};
use crate::geom::Aabb;
use crate::prims::{Primitives, Triangles};
use crate::query::Query;
use crate::simd::{Arena, GRANULE, Kept, fetch_ends};

/// Why bytes are not taken for a tree.
#[derive(Debug)]
pub(crate) enum Flaw {
    /// A rule that they break, and at which of them.
    Broken { byte: usize, rule: &'static str },
    /// The check needs so much memory, which the system did not grant.
    OutOfMemory { bytes: usize },
}

/// The tree in `bytes` over the triangles, read where it lies.
///
/// # Errors
/// If it is none. Then nothing of it was asked.
pub(crate) fn opened(
    bytes: &Kept<u8>,
    around: Aabb,
    triangles: &Triangles,
    options: &BuildOptions,
) -> Result<Box<dyn Query>, Flaw> {
    let arena = bytes.arena().ok_or(flaw(0, "the bytes are not aligned"))?;
    if bytes.len() / GRANULE > MAX_GRANULES as usize {
        return Err(flaw(0, "the tree is too large"));
    }
    let mut check = Check::new(&arena, triangles)?;
    let stack_need = check.tree(around)?;
    let found = check.all_triangles(bytes.len())?;
    Ok(Box::new(WideTriangles(Wide::<Full> {
        root: (found > 0).then(|| Ref::node(0)),
        bounds: around,
        size: ray::size(&around),
        level: options.instructions,
        stack_need,
        #[cfg(feature = "lists")]
        has_copies: check.in_leaves > found,
        store: Store::new(arena),
    })))
}

/// A set of numbers.
struct Set(Vec<u64>);

impl Set {
    fn below(count: usize) -> Result<Self, Flaw> {
        let words = count.div_ceil(64);
        let bytes = words * size_of::<u64>();
        let mut set = Vec::new();
        set.try_reserve_exact(words)
            .map_err(|_| Flaw::OutOfMemory { bytes })?;
        set.resize(words, 0);
        Ok(Self(set))
    }

    fn insert(&mut self, number: u32) {
        self.0[number as usize / 64] |= 1 << (number % 64);
    }

    fn contains(&self, number: u32) -> bool {
        self.0[number as usize / 64] >> (number % 64) & 1 == 1
    }
}

/// A node that its parent has told of.
#[derive(Clone, Copy)]
struct Waiting {
    granule: u32,
    bounds: Aabb,
    depth: usize,
    /// References that wait in a traversal that comes here.
    below: usize,
}

/// The pass over the bytes.
struct Check<'a> {
    arena: &'a Arena,
    triangles: &'a Triangles,
    /// Those of which a leaf's box contains all.
    whole: Set,
    /// Those of which leaves' boxes contain parts, since a builder split them.
    parts: Vec<(u32, Aabb)>,
    /// Triangles of all leaves, one in several of them as many times.
    in_leaves: usize,
}

impl<'a> Check<'a> {
    fn new(arena: &'a Arena, triangles: &'a Triangles) -> Result<Self, Flaw> {
        Ok(Self {
            arena,
            triangles,
            whole: Set::below(triangles.len())?,
            parts: Vec::new(),
            in_leaves: 0,
        })
    }

    /// The whole tree; gives the most references that wait in a traversal.
    fn tree(&mut self, around: Aabb) -> Result<usize, Flaw> {
        let mut stack_need = 0;
        let mut next = 0;
        let mut waiting = Vec::new();
        if (0..self.triangles.len()).any(|prim| self.triangles.is_active(prim)) {
            waiting.push(Waiting {
                granule: 0,
                bounds: around,
                depth: 0,
                below: 0,
            });
        }
        while let Some(node) = waiting.pop() {
            let place = u64::from(next).next_multiple_of(LINE) as u32;
            self.zeros(next, place)?;
            if node.granule != place {
                return Err(flaw(place, "no node refers to what stands here"));
            }
            if node.depth >= MAX_DEPTH {
                return Err(flaw(place, "the tree is too deep"));
            }
            let count;
            (next, count) = self.node(&node, &mut waiting)?;
            stack_need = stack_need.max(node.below + count - 1);
        }
        let bytes = next as usize * GRANULE;
        if Arena::len_for(bytes + SLACK) != Some(self.arena.len()) {
            return Err(flaw(next, "the tree ends before its bytes do"));
        }
        self.zeros(next, (self.arena.len() / GRANULE) as u32)?;
        Ok(stack_need + 1)
    }

    /// Nothing between two places.
    fn zeros(&self, from: u32, to: u32) -> Result<(), Flaw> {
        let between = &self.arena.bytes()[from as usize * GRANULE..to as usize * GRANULE];
        match between.iter().all(|byte| *byte == 0) {
            true => Ok(()),
            false => Err(flaw(from, "what is unused is not zero")),
        }
    }

    /// True if so many bytes from a granule on may be read, and what kernels read beyond.
    fn has(&self, granule: u32, bytes: usize) -> bool {
        granule as usize * GRANULE + bytes + SLACK <= self.arena.len()
    }

    /// One node and its leaves; gives where they end, and how many children there are.
    fn node(&mut self, node: &Waiting, waiting: &mut Vec<Waiting>) -> Result<(u32, usize), Flaw> {
        let flaw = |rule| flaw(node.granule, rule);
        if !self.has(node.granule, Full::NODE_GRANULES as usize * GRANULE) {
            return Err(flaw("a node goes beyond the end"));
        }
        let rows = self.arena.node(node.granule);
        let refs = rows.refs().map(Ref);
        let boxes: [Aabb; WIDTH] = std::array::from_fn(|lane| bounds(rows, lane));
        let count = boxes.iter().position(Aabb::is_empty).unwrap_or(WIDTH);
        let is_unused =
            |lane: usize| bits(&boxes[lane]) == bits(&Aabb::EMPTY) && refs[lane] == Ref(0);
        if !(count..WIDTH).all(is_unused) {
            return Err(flaw("unused lanes of a node are not empty"));
        }
        if count < 2 && !(count == 1 && node.depth == 0 && refs[0].is_leaf()) {
            return Err(flaw("a node has too few children"));
        }
        let is_inside = |b: &Aabb| b.is_in_domain() && node.bounds.contains_box(b);
        if !boxes[..count].iter().all(is_inside) {
            return Err(flaw("a box is not inside that of its parent"));
        }
        let mut next = node.granule + Full::NODE_GRANULES;
        let first = waiting.len();
        self.fetch_triangles(next, &refs[..count]);
        for lane in 0..count {
            if refs[lane].is_leaf() {
                next = self.leaf(refs[lane], next, &boxes[lane])?;
            } else {
                waiting.push(Waiting {
                    granule: refs[lane].0,
                    bounds: boxes[lane],
                    depth: node.depth + 1,
                    below: node.below + count - 1,
                });
            }
        }
        // The first inner child comes next.
        waiting[first..].reverse();
        Ok((next, count))
    }

    /// Asks for the triangles of all leaves behind a node, which are all over the list, before the first is looked at.
    fn fetch_triangles(&self, from: u32, refs: &[Ref]) {
        let triangles = self.triangles.as_slice();
        let mut place = from;
        for leaf in refs.iter().filter(|child| child.is_leaf()) {
            let count = leaf.count();
            if !self.has(place, 4 * leaf_floats(count)) {
                return;
            }
            for prim in &self.arena.floats(place, leaf_floats(count))[NUMBERS * count..] {
                if let Some(triangle) = triangles.get(prim.to_bits() as usize) {
                    fetch_ends(triangle);
                }
            }
            place += leaf_granules(count);
        }
    }

    /// One leaf, which must begin at granule `place`; gives where it ends.
    fn leaf(&mut self, leaf: Ref, place: u32, around: &Aabb) -> Result<u32, Flaw> {
        let (flaw, count) = (|rule| flaw(place, rule), leaf.count());
        if leaf.granule() != place {
            return Err(flaw("a leaf does not stand behind its node"));
        }
        let floats = leaf_floats(count);
        if !self.has(place, 4 * floats) {
            return Err(flaw("a leaf goes beyond the end"));
        }
        let rows = self.arena.floats(place, floats.next_multiple_of(4));
        if rows[floats..].iter().any(|x| x.to_bits() != 0) {
            return Err(flaw("what is unused is not zero"));
        }
        self.in_leaves += count;
        let triangles = self.triangles.as_slice();
        for lane in 0..count {
            let prim = rows[NUMBERS * count + lane].to_bits();
            let known = triangles.get(prim as usize);
            let known = known.ok_or(flaw("a leaf has a triangle that is not there"))?;
            let corners = known.0.as_flattened().iter().enumerate();
            if !corners.fold(true, |same, (row, x)| {
                same & (rows[row * count + lane].to_bits() == x.to_bits())
            }) {
                return Err(flaw("a leaf has another triangle than the list"));
            }
            if known.0.iter().all(|corner| around.contains(*corner)) {
                self.whole.insert(prim);
            } else {
                if !self.triangles.is_active(prim as usize) {
                    return Err(flaw("a leaf has a triangle that cannot be hit"));
                }
                self.part(prim, around)?;
            }
        }
        Ok(place + leaf_granules(count))
    }

    /// Remembers that a leaf's box has a part of a triangle.
    fn part(&mut self, prim: u32, around: &Aabb) -> Result<(), Flaw> {
        let bytes = (self.parts.len() + 1) * size_of::<(u32, Aabb)>();
        self.parts
            .try_reserve(1)
            .map_err(|_| Flaw::OutOfMemory { bytes })?;
        self.parts.push((prim, *around));
        Ok(())
    }

    /// Every triangle that can be hit must be in the tree, all of it. Gives how many there are.
    fn all_triangles(&mut self, end: usize) -> Result<usize, Flaw> {
        self.parts.sort_unstable_by_key(|(prim, _)| *prim);
        for parts in self.parts.chunk_by(|a, b| a.0 == b.0) {
            let prim = parts[0].0;
            let all = Aabb::of_boxes(parts.iter().map(|(_, part)| part));
            if all.contains_box(&self.triangles.bounds(prim as usize)) {
                self.whole.insert(prim);
            }
        }
        let mut found = 0;
        for prim in 0..self.triangles.len() {
            let is_whole = self.whole.contains(prim as u32);
            found += usize::from(is_whole);
            if !is_whole && self.triangles.is_active(prim) {
                let rule = "a triangle is missing in the tree";
                return Err(Flaw::Broken { byte: end, rule });
            }
        }
        Ok(found)
    }
}

fn flaw(granule: u32, rule: &'static str) -> Flaw {
    let byte = granule as usize * GRANULE;
    Flaw::Broken { byte, rule }
}

fn bits(bounds: &Aabb) -> [[u32; 3]; 2] {
    [bounds.min, bounds.max].map(|corner| corner.map(f32::to_bits))
}
