//! Do all structures give the same answer? Rays that look for trouble, compared bit for bit with brute force.
//!
//! [`run`] checks a mesh in every structure of the tables; [`run_on`] checks structures of your own, too; [`run_instances`]
//! checks meshes that stand in many places, every structure around every other.
//!
//! ```
//! use boxwood::check::{self, Options};
//! let corners = [[0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0], [1.0, 1.0, 8.0]];
//! let faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
//! let mesh = faces.map(|face| boxwood::Triangle(face.map(|i: usize| corners[i])));
//! let report = check::run(&mesh, &Options { rays: 1000, ..Options::default() }, &mut |_| {})?;
//! assert!(report.is_clean() && report.is_closed);
//! # Ok::<(), boxwood::BuildError>(())
//! ```
//!
//! # What is compared
//!
//! Each ray is asked of each structure in four ways: `closest_hit` and `occluded`, one ray at a time and as slices on many
//! threads; the first rays once more as one slice on one thread, by a structure built on one thread; and every eighth ray
//! by `all_hits`, `list_each` and `count_each`. All bits of all hits must be those of the structure `list`, brute force.
//!
//! Where brute force or a structure is too dear for all rays, it gets the first of them, as many as
//! [`Options::budget`] allows. Rays are independent of each other, so the first are a fair sample. Beyond the sample of
//! the list the first variant stands in for it, which was itself compared with the list on the sample. The report says how
//! many rays each structure got.
//!
//! On a [closed](closed()) mesh, every valid ray is also made a whole line, which must meet the mesh an even number of times: that
//! finds holes which all structures share.

mod bits;
mod closed;
mod compare;
mod instances;
mod rays;
mod report;
mod run;
mod variants;

pub use closed::closed;
pub use instances::{Layout, run_instances};
pub use rays::Rays;
pub use report::{Failure, Progress, Question, Report, VariantReport};
pub use variants::{Variant, variants};

use crate::error::BuildError;
use crate::geom::Triangle;
use run::Check;

/// Where rays are aimed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Aim {
    /// From anywhere to anywhere, with many a zero component.
    Random,
    /// At points of edges.
    Edges,
    /// At vertices.
    Vertices,
    /// In tiles of 64 that go nearly the same way, which structures may trace together.
    Tiles,
    /// A quarter of each; tiles stay whole.
    #[default]
    Mixed,
}

/// Every [`Aim`] with its name.
pub const AIMS: &[(&str, Aim)] = &[
    ("random", Aim::Random),
    ("edges", Aim::Edges),
    ("vertices", Aim::Vertices),
    ("tiles", Aim::Tiles),
    ("mixed", Aim::Mixed),
];

/// How much to check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Default: 100,000.
    pub rays: u64,
    /// Other seeds give other rays. Default: 0.
    pub seed: u64,
    /// Default: mixed.
    pub aim: Aim,
    /// Operations (as in [`Counts::flops`](crate::Counts::flops)) that one structure may spend; it gets fewer rays if
    /// it would need more. A core does some 10^9 of them a second, nested objects far fewer. Default: 2 x 10^10.
    pub budget: u64,
    /// The same for brute force. Default: 6 x 10^10, or 2 x 10^9 triangle tests.
    pub oracle_budget: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            rays: 100_000,
            seed: 0,
            aim: Aim::Mixed,
            budget: 20_000_000_000,
            oracle_budget: 60_000_000_000,
        }
    }
}

/// Checks all [`variants`] on the threads of the caller's rayon pool, telling `progress` several times a second.
///
/// Memory: the structures of one or two variants, and 50 bytes for each of at most 2^20 rays.
///
/// # Errors
/// If a structure cannot be built. Wrong answers are no error, but in the report.
pub fn run(
    triangles: &[Triangle],
    options: &Options,
    progress: &mut dyn FnMut(&Progress<'_>),
) -> Result<Report, BuildError> {
    run_on(triangles, &variants(), options, progress)
}

/// [`run`] for a choice of variants. The first stands in for brute force where that is too dear.
///
/// # Errors
/// As [`run`]; without any variant only parity is tested, by brute force.
pub fn run_on(
    triangles: &[Triangle],
    variants: &[Variant],
    options: &Options,
    progress: &mut dyn FnMut(&Progress<'_>),
) -> Result<Report, BuildError> {
    Check::new(triangles, variants, options, progress)?.run()
}

#[cfg(test)]
mod tests {
    use super::compare::on_one_thread;
    use super::*;
    use crate::build::BuildOptions;
    use crate::geom::{Aabb, PreparedRay};
    use crate::prims::{Geometry, Primitives};
    use crate::query::NodeInfo;
    use crate::structure::{Accel, Indexed, List, Visit};
    use crate::tables::Structure;
    use crate::testing::Random;

    /// A star-shaped closed surface: an octahedron, split and dented.
    fn star() -> Vec<Triangle> {
        let corner = |axis: usize, sign: f32| -> [f32; 3] {
            std::array::from_fn(|k| if k == axis { sign } else { 0.0 })
        };
        let mut faces = Vec::new();
        for octant in 0..8 {
            let sign = |k: usize| if octant >> k & 1 == 0 { 1.0 } else { -1.0 };
            faces.push([corner(0, sign(0)), corner(1, sign(1)), corner(2, sign(2))]);
        }
        for _ in 0..3 {
            let middle = |a: [f32; 3], b: [f32; 3]| -> [f32; 3] {
                std::array::from_fn(|k| 0.5 * a[k] + 0.5 * b[k])
            };
            let split = |[a, b, c]: [[f32; 3]; 3]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            };
            faces = faces.into_iter().flat_map(split).collect();
        }
        // The same for equal vertices, so the surface stays closed.
        let dent = |p: [f32; 3]| {
            let size = 1.0 + 0.3 * (p[0] * 5.0 + p[1] * 3.0 - p[2] * 7.0).abs().fract();
            p.map(|x| x * size + 2.5)
        };
        faces
            .into_iter()
            .map(|face| Triangle(face.map(dent)))
            .collect()
    }

    fn soup(count: usize) -> Vec<Triangle> {
        let mut random = Random::new(5);
        let mut point = |at: [f32; 3], size: f32| at.map(|x| x + random.signed() * size);
        (0..count)
            .map(|_| {
                let center = point([0.0; 3], 4.0);
                Triangle([point(center, 0.7), point(center, 0.7), point(center, 0.7)])
            })
            .collect()
    }

    fn options(rays: u64) -> Options {
        Options {
            rays,
            seed: 3,
            ..Options::default()
        }
    }

    #[test]
    fn the_structures_of_the_tables_are_clean() {
        for mesh in [star(), soup(200), vec![], vec![Triangle([[1.0; 3]; 3])]] {
            let report = run(&mesh, &options(3000), &mut |_| {}).unwrap();
            assert!(
                report.is_clean(),
                "{:?}",
                report.failures.first().map(ToString::to_string)
            );
            assert_eq!((report.rays, report.oracle_rays), (3000, 3000));
            assert!(report.variants.len() > 20 && report.variants.iter().all(|v| v.rays == 3000));
        }
    }

    #[test]
    fn parity_is_tested_where_a_mesh_is_closed() {
        let report = run_on(&star(), &[], &options(20_000), &mut |_| {}).unwrap();
        assert!(report.is_closed && report.is_clean());
        assert!(
            report.parity_rays > 19_000 && report.hits > 10_000,
            "{report:?}"
        );
        let open = run_on(&soup(50), &[], &options(100), &mut |_| {}).unwrap();
        assert!(!open.is_closed && open.parity_rays == 0);
    }

    /// A list that forgets its last primitive whenever a ray runs backwards along x.
    struct Forgetful(List);

    impl Accel for Forgetful {
        fn build<P: Primitives>(
            prims: &P,
            boxes: &[Aabb],
            options: &BuildOptions,
        ) -> Result<Self, BuildError> {
            List::build(prims, boxes, options).map(Self)
        }

        fn order(&self) -> &[u32] {
            self.0.order()
        }

        fn traverse<V: Visit>(&self, ray: &PreparedRay, visit: &mut V) {
            let kept = self.order().len() as u32 - u32::from(ray.dir[0] < 0.0);
            let _ = visit.leaf(0..kept);
        }

        fn for_each_node(&self, visit: &mut dyn FnMut(NodeInfo)) {
            self.0.for_each_node(visit);
        }

        fn bytes(&self) -> usize {
            self.0.bytes()
        }
    }

    fn forgetful() -> Variant {
        Variant::new("forgetful", |geometry| match geometry {
            Geometry::Triangles(prims) => {
                Indexed::<Forgetful, _>::boxed(prims, &BuildOptions::default())
            }
            _ => Structure::named("list")?.build(geometry, &BuildOptions::default()),
        })
    }

    #[test]
    fn a_structure_that_loses_hits_is_found_out() {
        let mesh = soup(40);
        let good = variants().swap_remove(0);
        let report = run_on(&mesh, &[good, forgetful()], &options(20_000), &mut |_| {}).unwrap();
        assert!(!report.is_clean() && report.differences >= report.misses && report.misses > 10);
        let [good, bad] = &report.variants[..] else {
            panic!("two variants")
        };
        assert_eq!((good.differences, bad.differences), (0, report.differences));
        let failure = report
            .failures
            .iter()
            .find(|f| f.question == Question::ClosestHit)
            .unwrap();
        assert_eq!(failure.variant, "forgetful");
        assert!(
            failure.expected.contains("prim: 39") && failure.ray.dir[0] < 0.0,
            "{failure}"
        );
        assert!(
            failure.to_string().contains("\n    Ray { origin: ["),
            "{failure}"
        );
    }

    #[test]
    fn a_stand_in_that_loses_hits_is_found_out_by_the_list() {
        let report = run_on(&soup(40), &[forgetful()], &options(20_000), &mut |_| {}).unwrap();
        assert!(report.differences > 10, "{report:?}");
    }

    #[test]
    fn a_hole_that_all_structures_share_is_found_by_parity() {
        // Closed as a mesh, but the structure has one triangle less for half of the rays.
        let report = run_on(&star(), &[forgetful()], &options(20_000), &mut |_| {}).unwrap();
        assert!(
            report.is_closed && report.parity_errors > 0 && report.parity_errors < 1000,
            "{report:?}"
        );
        assert!(
            report
                .failures
                .iter()
                .any(|f| f.question == Question::Parity)
        );
    }

    #[test]
    fn a_small_budget_is_kept_and_said() {
        let small = Options {
            budget: 3_000_000,
            oracle_budget: 3_000_000,
            ..options(4000)
        };
        let report = run(&soup(1000), &small, &mut |_| {}).unwrap();
        assert!(
            report.is_clean() && (10..1000).contains(&report.oracle_rays),
            "{report:?}"
        );
        assert!(
            report.variants.iter().any(|v| v.rays < 4000)
                && report.variants.iter().all(|v| v.rays > 10)
        );
    }

    #[test]
    fn the_digest_does_not_depend_on_budget_or_threads() {
        let mesh = star();
        let digest = |budget| {
            let options = Options {
                budget,
                oracle_budget: budget,
                ..options(5000)
            };
            run_on(&mesh, &variants()[..1], &options, &mut |_| {})
                .unwrap()
                .digest
        };
        let here = digest(u64::MAX);
        assert_eq!(here, digest(1));
        assert_eq!(here, on_one_thread(|| digest(u64::MAX)));
    }

    #[test]
    fn progress_never_goes_back_and_ends_near_its_total() {
        let (mut last, mut total) = (0, 0);
        run(&soup(20), &options(40_000), &mut |p| {
            assert!(p.done >= last && p.done <= p.total, "{p:?}");
            (last, total) = (p.done, p.total);
        })
        .unwrap();
        assert!(last > 0 && total - last <= 40_000, "{last} of {total}");
    }
}
