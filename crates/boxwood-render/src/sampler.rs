//! Numbers that look random, are spread evenly, and are the same on every machine and for any
//! number of threads.

/// The random numbers of one sample of one pixel.
///
/// A sample asks for its numbers in order; the `n`-th pair of sample `i` is point `i` of an
/// Owen-scrambled (0,2)-sequence that is shuffled anew for each pixel and each pair ("padding"). So
/// the samples of a pixel fill the square evenly for each decision, and nothing depends on which
/// thread asks, or when.
///
/// Burley, "Practical Hash-based Owen Scrambling", JCGT 2020; the hash is the one of Laine and
/// Karras 2011 as improved by Vegdahl 2021.
#[derive(Clone, Debug)]
pub(crate) struct Sampler {
    pixel_seed: u32,
    sample: u32,
    dimension: u32,
}

impl Sampler {
    /// The numbers of sample number `sample` of the pixel `(x, y)` under the user's `seed`.
    pub(crate) fn new(seed: u64, x: u32, y: u32, sample: u32) -> Self {
        let pixel = hash(hash(x.wrapping_add(0x9e37_79b9)) ^ y);
        let pixel_seed =
            hash(pixel ^ hash(low(seed) ^ hash(low(seed >> 32).wrapping_add(0x85eb_ca6b))));
        Self {
            pixel_seed,
            sample,
            dimension: 0,
        }
    }

    /// A number in `0..1`.
    pub(crate) fn next(&mut self) -> f32 {
        self.next_pair()[0]
    }

    /// Two numbers in `0..1`, well spread as a pair over the samples of the pixel.
    pub(crate) fn next_pair(&mut self) -> [f32; 2] {
        let seed = self.next_seed();
        pair_at(self.sample, seed)
    }

    /// `N` pairs for one decision taken `N` times, well spread together with those of the other
    /// samples.
    pub(crate) fn next_pairs<const N: usize>(&mut self) -> [[f32; 2]; N] {
        let seed = self.next_seed();
        let first = self.sample.wrapping_mul(N as u32);
        std::array::from_fn(|k| pair_at(first.wrapping_add(k as u32), seed))
    }

    fn next_seed(&mut self) -> u32 {
        self.dimension += 1;
        hash(self.pixel_seed ^ hash(self.dimension))
    }
}

/// Point `index` of the sequence that `seed` shuffles and scrambles.
fn pair_at(index: u32, seed: u32) -> [f32; 2] {
    let point = owen_scramble(index, seed);
    let x = owen_scramble(point.reverse_bits(), hash(seed ^ 0x5bd1_e995));
    let y = owen_scramble(sobol_second(point), hash(seed ^ 0x1b87_3593));
    [unit(x), unit(y)]
}

/// A 32-bit hash in which each input bit flips each output bit about half the time (Wellons,
/// "lowbias32", 2018).
pub(crate) fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Nested uniform scramble: a random flip for each node of the binary tree over the digits of `x`.
fn owen_scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// Dimension 2 of Sobol's sequence; dimension 1 is the reversal of the bits.
fn sobol_second(mut index: u32) -> u32 {
    let (mut result, mut direction) = (0, 1u32 << 31);
    while index != 0 {
        if index & 1 == 1 {
            result ^= direction;
        }
        direction ^= direction >> 1;
        index >>= 1;
    }
    result
}

/// The upper 24 bits as a float in `0..1`, exact.
fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

fn low(x: u64) -> u32 {
    (x & 0xffff_ffff) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_samples_hit_each_cell_of_a_four_by_four_board_once() {
        for dimension in 0..5 {
            let mut cells = [0; 16];
            for sample in 0..16 {
                let mut sampler = Sampler::new(7, 31, 5, sample);
                let pair = (0..=dimension).map(|_| sampler.next_pair()).last().unwrap();
                cells[(pair[0] * 4.0) as usize * 4 + (pair[1] * 4.0) as usize] += 1;
            }
            assert_eq!(cells, [1; 16], "dimension {dimension}");
        }
    }

    #[test]
    fn numbers_stay_below_one_and_average_to_a_half() {
        let numbers: Vec<f32> = (0..4099)
            .map(|i| Sampler::new(1, i, i / 7, i % 3).next())
            .collect();
        assert!(numbers.iter().all(|x| (0.0..1.0).contains(x)));
        let mean = numbers.iter().sum::<f32>() / numbers.len() as f32;
        assert!((mean - 0.5).abs() < 0.02, "{mean}");
    }

    #[test]
    fn pixel_sample_and_seed_each_change_the_numbers() {
        let first = |seed, x, y, sample| Sampler::new(seed, x, y, sample).next_pair();
        let base = first(0, 3, 4, 0);
        for other in [
            first(1, 3, 4, 0),
            first(1 << 32, 3, 4, 0),
            first(0, 4, 3, 0),
            first(0, 3, 4, 1),
        ] {
            assert_ne!(base, other);
        }
    }
}
