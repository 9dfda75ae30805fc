//! A build that gets no memory, or is ended, is an error and holds nothing afterwards; one that succeeds holds no more than
//! was stated.
//!
//! A binary of its own, with one test, since its allocator refuses and counts for the whole process.
#![expect(
    unsafe_code,
    reason = "a global allocator that refuses can't be written without"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use boxwood::build::BuildInput;
use boxwood::prims::{Primitives, Triangles};
use boxwood::{Aabb, BUILDERS, BuildError, BuildOptions, Progress, Triangle};

/// The system's allocator. Counts what is held, and refuses a large block after so many.
struct Refusing;

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static LEFT: AtomicUsize = AtomicUsize::new(usize::MAX);

/// Blocks that depend on the size of the scene. Small ones of fixed size may be taken without a way back.
const LARGE: usize = 16 << 10;

// SAFETY: a call either gives no block or goes on to the system's allocator with the same arguments.
unsafe impl GlobalAlloc for Refusing {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if layout.size() >= LARGE {
            let take = |left: usize| left.checked_sub(1);
            if LEFT.fetch_update(Relaxed, Relaxed, take).is_err() {
                return std::ptr::null_mut();
            }
        }
        let held = HELD.fetch_add(layout.size(), Relaxed) + layout.size();
        PEAK.fetch_max(held, Relaxed);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Refusing = Refusing;

/// Slivers, which are split, and some common triangles.
fn triangles(count: usize) -> Triangles {
    let mut seed = 7u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 24) as f32
    };
    let triangle = |i: usize| {
        let mut point = || std::array::from_fn(|_| random());
        let (a, b): ([f32; 3], [f32; 3]) = (point(), point());
        let c = if i.is_multiple_of(2) {
            b.map(|x| x + 1e-3)
        } else {
            a.map(|x| x + 1e-2)
        };
        Triangle([a, b, c])
    };
    Triangles::new((0..count).map(triangle).collect())
}

#[test]
fn refused_memory_and_an_end_are_errors_that_hold_nothing() {
    let triangles = triangles(9000);
    let boxes: Vec<Aabb> = (0..triangles.len()).map(|i| triangles.bounds(i)).collect();
    let input = BuildInput::new(&triangles, &boxes);
    for builder in BUILDERS {
        let name = builder.name;
        let build = |options: &BuildOptions| builder.build(&input, options);
        let usual = BuildOptions::with(*builder);
        // What threads of the pool keep is not the build's.
        drop(build(&usual));
        let before = HELD.load(Relaxed);
        PEAK.store(before, Relaxed);
        drop(build(&usual).unwrap());
        let peak = PEAK.load(Relaxed) - before;
        let stated = builder.memory(boxes.len(), &usual);
        // Blocks of fixed size come on top.
        assert!(
            peak <= stated + (1 << 20),
            "{name}: {peak} bytes, {stated} stated"
        );
        assert!(peak * 5 > stated, "{name}: {peak} bytes, {stated} stated");

        let slack = 64 << 10;
        for allowed in 0.. {
            LEFT.store(allowed, Relaxed);
            let built = build(&usual);
            LEFT.store(usize::MAX, Relaxed);
            match built {
                Ok(_) => break,
                Err(BuildError::OutOfMemory { bytes }) => assert!(bytes >= LARGE, "{name}"),
                Err(other) => panic!("{name}: {other}"),
            }
            let held = HELD.load(Relaxed);
            assert!(
                held <= before + slack,
                "{name}: {} bytes are left",
                held - before
            );
            assert!(allowed < 1000, "{name} takes too many blocks");
        }

        let ended = BuildOptions {
            progress: Progress::new(|done| match done < 0.5 {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            }),
            ..usual.clone()
        };
        let before = HELD.load(Relaxed);
        assert_eq!(build(&ended), Err(BuildError::Cancelled), "{name}");
        assert!(HELD.load(Relaxed) <= before + slack, "{name}");
    }
}
