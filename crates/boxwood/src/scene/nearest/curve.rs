//! Points in the order of a space-filling curve (Morton, "A computer oriented geodetic data base", IBM 1966): neighbours one after
//! the other, so that the answer of one is near that of the next, and what it read of the tree is still in the cache.

/// Cells of the grid along an axis.
const CELLS: u32 = 1 << 10;

/// Asks with the points in order, and gives back the answers in the caller's.
pub(super) fn along_curve<T: Copy>(
    points: &[[f32; 3]],
    answers: &mut [T],
    ask: impl FnOnce(&[[f32; 3]], &mut [T]),
) {
    let order = order(points);
    let sorted: Vec<_> = order.iter().map(|&place| points[place]).collect();
    let mut found: Vec<_> = order.iter().map(|&place| answers[place]).collect();
    ask(&sorted, &mut found);
    for (place, answer) in order.into_iter().zip(found) {
        answers[place] = answer;
    }
}

/// The places of the points along the curve.
fn order(points: &[[f32; 3]]) -> Vec<usize> {
    let axis = |k: usize| {
        let all = || points.iter().map(move |point| point[k]);
        let (min, max) = (
            all().fold(f32::MAX, f32::min),
            all().fold(f32::MIN, f32::max),
        );
        (min, CELLS as f32 / (max - min))
    };
    let axes = [axis(0), axis(1), axis(2)];
    let code = |point: &[f32; 3]| {
        // What is no number, or no finite one, is in some cell.
        let cell = |k: usize| ((point[k] - axes[k].0) * axes[k].1) as u32;
        let [x, y, z] = [cell(0), cell(1), cell(2)].map(|cell| spread(cell.min(CELLS - 1)));
        x << 2 | y << 1 | z
    };
    let keys = points.iter().zip(0_u64..);
    let mut keys: Vec<u64> = keys
        .map(|(point, place)| u64::from(code(point)) << 32 | place)
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|key| key as u32 as usize).collect()
}

/// Moves bit `i` of ten to place `3 i`, by halves.
fn spread(cell: u32) -> u32 {
    let bits = (cell | cell << 16) & 0x0300_00FF;
    let bits = (bits | bits << 8) & 0x0300_F00F;
    let bits = (bits | bits << 4) & 0x030C_30C3;
    (bits | bits << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_come_back_in_the_order_of_the_points() {
        let number = |k: usize| ((k * 7919) % 1000) as f32;
        let points: Vec<[f32; 3]> = (0..1000)
            .map(|k| [number(k), number(k + 3), number(k + 5)])
            .chain([[f32::NAN; 3], [f32::INFINITY, -f32::INFINITY, 1e38]])
            .collect();
        let mut answers = vec![0.0; points.len()];
        along_curve(&points, &mut answers, |points, answers| {
            for (point, answer) in points.iter().zip(answers) {
                *answer = point[0];
            }
        });
        let bits = |x: f32| x.to_bits();
        assert!(
            points
                .iter()
                .zip(&answers)
                .all(|(p, a)| bits(p[0]) == bits(*a))
        );
    }

    #[test]
    fn neighbours_along_the_curve_are_neighbours_in_space() {
        let number = |k: usize| ((k * 7919) % 1009) as f32;
        let points: Vec<[f32; 3]> = (0..1000)
            .map(|k| [number(k), number(k * k), number(k * k * k)])
            .collect();
        let length = |points: &mut dyn Iterator<Item = [f32; 3]>| {
            let points: Vec<_> = points.collect();
            let step =
                |pair: &[[f32; 3]]| (0..3).map(|k| (pair[0][k] - pair[1][k]).abs()).sum::<f32>();
            points.windows(2).map(step).sum::<f32>()
        };
        let before = length(&mut points.iter().copied());
        let after = length(&mut order(&points).into_iter().map(|place| points[place]));
        assert!(after < 0.3 * before, "{after} of {before}");
    }
}
