//! The small worlds of the figures that need no scene: the price of a frame, one ray and one triangle, and two seen from
//! above, where all is flat: a grid, and volumes around a shape.

mod grid;
mod volumes;

pub use grid::{CellStep, GridAnswer, grid_walk};
pub use volumes::{VolumeAnswer, VolumesAnswer, volumes};

use boxwood::{
    Ray, Triangle,
    geom::PreparedRay,
    lecture::{Exit, cramer, price::Price},
};
use serde::Serialize;

/// Operations of a frame by brute force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are those of boxwood::lecture::price::Price"
)]
pub struct PriceAnswer {
    pub pixels: u64,
    pub flops_per_test: u64,
    pub flops: u64,
    /// On the slides' laptop of 100 GFLOPS.
    pub seconds_at_100_gflops: f64,
}

/// *Ray tracing is expensive. How expensive?*
pub fn price(width: u32, height: u32, triangles: u32) -> PriceAnswer {
    let price = Price {
        width: width.into(),
        height: height.into(),
        ..Price::of_720p(triangles.into())
    };
    PriceAnswer {
        pixels: price.pixels(),
        flops_per_test: price.flops_per_test,
        flops: price.flops(),
        seconds_at_100_gflops: price.seconds_at(100.0),
    }
}

/// One ray against one triangle, by the exact test and by the slides' formula.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TestAnswer {
    /// The edge functions opposite to each corner.
    pub edges: [f64; 3],
    /// -1 or 1 each; all equal: a hit. A zero edge has a sign by the rule of ties.
    pub signs: [i8; 3],
    /// Ray parameter and weights of the second and third corner, if it is hit.
    pub hit: Option<[f32; 3]>,
    /// Operations of the exact test.
    pub flops: u32,
    /// Cramer's rule: beta, gamma and t, if it finds a hit.
    pub cramer: Option<[f32; 3]>,
    /// Where Cramer's rule stopped: `beta`, `gamma` or `t`.
    pub cramer_exit: &'static str,
    /// Operations up to there.
    pub cramer_flops: u32,
}

/// Tests the ray `origin + t * dir` against a triangle; `Err` if it is no ray.
pub fn test(corners: [[f32; 3]; 3], origin: [f32; 3], dir: [f32; 3]) -> Result<TestAnswer, String> {
    let (ray, triangle) = (Ray::new(origin, dir), Triangle(corners));
    let prepared = PreparedRay::new(&ray).ok_or("this is no ray: it has no direction")?;
    let trace = triangle.trace(&prepared);
    let (found, exit) = cramer::intersect(&ray, &triangle);
    let (cramer_exit, cramer_flops) = match exit {
        Exit::Beta => ("beta", cramer::FLOPS[0]),
        Exit::Gamma => ("gamma", cramer::FLOPS[1]),
        Exit::Full => ("t", cramer::FLOPS[2]),
    };
    Ok(TestAnswer {
        edges: trace.edges,
        signs: trace.signs,
        hit: trace.candidate.map(|c| [c.t, c.u, c.v]),
        flops: match trace.candidate {
            Some(_) => Triangle::FLOPS_HIT,
            None => Triangle::FLOPS_MISS,
        },
        cramer: found.map(|b| [b.beta, b.gamma, b.t]),
        cramer_exit,
        cramer_flops,
    })
}

/// Half the height of walls: low, so that the grid has one layer.
const HALF_HEIGHT: f32 = 0.25;

/// A wall as two triangles.
fn upright(&[x0, y0, x1, y1]: &[f32; 4]) -> [Triangle; 2] {
    let [low, high] = [-HALF_HEIGHT, HALF_HEIGHT];
    [
        Triangle([[x0, y0, low], [x1, y1, low], [x1, y1, high]]),
        Triangle([[x0, y0, low], [x1, y1, high], [x0, y0, high]]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slides_price_is_995_gigaflop() {
        let found = price(1280, 720, 40_000);
        assert_eq!((found.pixels, found.flops), (921_600, 995_328_000_000));
        assert_eq!(price(1280, 720, 114).flops, 2_836_684_800);
    }

    #[test]
    fn a_point_on_a_shared_edge_hits_exactly_one_of_two_triangles() {
        let [a, b] = [[-1.5, -1.0, 3.0], [1.5, 1.0, 4.0]];
        let [left, right] = [[-1.0, 2.0, 5.0], [2.0, -1.5, 3.5]];
        for share in [0.25, 0.5, 0.75] {
            let at = [0, 1].map(|k| a[k] + share * (b[k] - a[k]));
            let hit = |corners| {
                let found = test(corners, [at[0], at[1], 0.0], [0.0, 0.0, 1.0]).unwrap();
                u32::from(found.hit.is_some())
            };
            assert_eq!(hit([a, b, left]) + hit([b, a, right]), 1, "{share}");
        }
        assert!(test([a, b, left], [0.0; 3], [0.0; 3]).is_err());
    }

    #[test]
    fn cramer_stops_early_where_beta_says_no() {
        let corners = [[0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0]];
        let at = |x: f32, y: f32| test(corners, [x, y, 0.0], [0.0, 0.0, 1.0]).unwrap();
        let miss = at(-1.0, 1.0);
        assert_eq!(
            (miss.cramer_exit, miss.cramer_flops, miss.hit),
            ("beta", 29, None)
        );
        let hit = at(1.0, 2.0);
        assert_eq!((hit.cramer_exit, hit.hit), ("t", Some([5.0, 0.25, 0.5])));
        assert_eq!(hit.cramer, Some([0.25, 0.5, 5.0]));
    }
}
