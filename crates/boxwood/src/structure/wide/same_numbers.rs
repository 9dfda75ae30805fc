//! A ray is made ready in three ways: watched, alone and in eights. All must come to the same numbers, on every instruction set.

#[cfg(test)]
mod tests {
    use super::super::prepare::{Record, prepare};
    use super::super::ray::{AXES, Ready, SlabConstants, ready};
    use crate::geom::{PreparedRay, Ray};
    use crate::simd::{InstructionSet, PlaneRow};
    use crate::testing::Random;
    use fearless_simd::dispatch;

    /// What a ray becomes.
    #[derive(Clone, Debug, PartialEq)]
    enum Outcome {
        NoRay,
        Extreme,
        Numbers(Vec<u32>, [PlaneRow; 3]),
    }

    fn numbers(parts: [&[f32]; 5], main: usize, rows: [PlaneRow; 3]) -> Outcome {
        let bits = parts.iter().copied().flatten().map(|x| x.to_bits());
        Outcome::Numbers(bits.chain([main as u32]).collect(), rows)
    }

    /// By the scalar forms: the definition.
    fn watched(ray: &Ray, size: f32) -> Outcome {
        let Some(prepared) = PreparedRay::new(ray) else {
            return Outcome::NoRay;
        };
        let Some(slabs) = SlabConstants::new(&prepared, size) else {
            return Outcome::Extreme;
        };
        let main = prepared.axes[2];
        let parts: [&[f32]; 5] = [
            &slabs.recip,
            &slabs.near,
            &slabs.far,
            &prepared.shear,
            &[prepared.t_min, 1.0 / prepared.dir[main]],
        ];
        numbers(parts, main, slabs.near_row)
    }

    fn alone(set: InstructionSet, ray: &Ray, size: f32) -> Outcome {
        dispatch!(set.0, simd => match ready(simd, ray, size) {
            Ready::Not => Outcome::NoRay,
            Ready::Extreme => Outcome::Extreme,
            Ready::Tame(slabs, edges, exact) => {
                let main = exact.axes[2];
                let lane = |lanes: [f32; 8]| lanes[5];
                let three = |v: [_; 3]| v.map(|x: fearless_simd::f32x8<_>| lane(x.into()));
                let [x, y] = edges.shear;
                assert_eq!(AXES[main], edges.axes);
                // Told, -0 is not 0.
                let told = |ray: Option<PreparedRay>| format!("{ray:?}");
                assert_eq!(told(Some(exact)), told(PreparedRay::new(ray)), "for the exact test");
                let parts: [&[f32]; 5] = [
                    &three(slabs.recip),
                    &three(slabs.near),
                    &three(slabs.far),
                    &[lane(x.into()), lane(y.into())],
                    &[lane(slabs.t_min.into()), lane(edges.recip.into())],
                ];
                numbers(parts, main, slabs.near_row)
            }
        })
    }

    fn in_eights(set: InstructionSet, rays: &[Ray; 8], size: f32) -> [Outcome; 8] {
        let mut records = [Record::EMPTY; 8];
        let prepared = dispatch!(set.0, simd => prepare(simd, rays, size, &mut records));
        std::array::from_fn(|k| {
            let record = &records[k];
            if prepared.valid >> k & 1 == 0 {
                return Outcome::NoRay;
            }
            if prepared.extreme >> k & 1 == 1 {
                return Outcome::Extreme;
            }
            let parts: [&[f32]; 5] = [
                &record.recip,
                &record.near,
                &record.far,
                &record.shear,
                &[record.t_min, record.t_per_depth],
            ];
            let [x, y, z, _] = record.rows;
            numbers(parts, record.axis as usize, [x, y, z])
        })
    }

    fn below(random: &mut Random, n: usize) -> usize {
        ((random.unit() * n as f32) as usize).min(n - 1)
    }

    #[test]
    fn all_ways_to_make_a_ray_ready_come_to_the_same_numbers() {
        let mut random = Random::new(12);
        let hostile = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            1e-42,
            -3e-39,
            1e-20,
            -1e-12,
            1e20,
            -3e37,
            f32::MAX,
            f32::INFINITY,
            f32::NAN,
        ];
        let mut seen = [0; 3];
        for round in 0..4000 {
            let mut number = || match below(&mut random, 4) {
                0 => hostile[below(&mut random, hostile.len())],
                1 => (random.unit() * 4.0).round() - 2.0,
                _ => random.signed() * 10f32.powi(below(&mut random, 9) as i32 - 4),
            };
            let rays: [Ray; 8] = std::array::from_fn(|_| {
                let [origin, dir] = [[0; 3], [0; 3]].map(|v| v.map(|_| number()));
                Ray::new(origin, dir).with_range(number(), number())
            });
            let size = [0.0, 1e-30, 1.0, 1e6, 1e30][round % 5];
            let expected = rays.each_ref().map(|ray| watched(ray, size));
            for outcome in &expected {
                seen[match outcome {
                    Outcome::NoRay => 0,
                    Outcome::Extreme => 1,
                    Outcome::Numbers(..) => 2,
                }] += 1;
            }
            for set in InstructionSet::available() {
                let eights = in_eights(set, &rays, size);
                for (k, ray) in rays.iter().enumerate() {
                    assert_eq!(
                        alone(set, ray, size),
                        expected[k],
                        "{}, {ray:?}, {size}",
                        set.name()
                    );
                    assert_eq!(eights[k], expected[k], "{}, {ray:?}, {size}", set.name());
                }
            }
        }
        assert!(seen.iter().all(|n| *n > 1000), "{seen:?}");
    }
}
