//! Many hits in one number, to compare machines by.

use boxwood::{
    Hit, Scene,
    check::{Aim, Rays},
    prims::Geometry,
};

/// Rays that are asked at once.
const SLICE: u64 = 4096;

/// The FNV-1a hash (Fowler, Noll, Vo, 1991; 64 bits) of what `count` rays hit, as 16 hexadecimal digits.
///
/// The rays are those of [`Rays`], a mixture aimed at edges, vertices and neighbours; every bit of `t`, `u`, `v` and the numbers of
/// each hit count. The same for every structure and on every machine. A scene that is not of triangles gives the hash of nothing.
pub fn hits_hash(scene: &Scene, count: u64, seed: u64) -> String {
    let Geometry::Triangles(triangles) = scene.geometry() else {
        return hex(START);
    };
    let rays = Rays::new(triangles.as_slice(), Aim::Mixed, seed);
    let (mut asked, mut hits) = (Vec::new(), Vec::new());
    let mut hash = START;
    for start in (0..count).step_by(SLICE as usize) {
        asked.clear();
        asked.extend((start..count.min(start + SLICE)).map(|index| rays.ray(index)));
        hits.resize(asked.len(), None);
        scene.closest_hits(&asked, &mut hits);
        hash = hits.iter().fold(hash, add_hit);
    }
    hex(hash)
}

/// The same hash of a list of hits.
pub fn hash_of_hits(hits: &[Option<Hit>]) -> String {
    hex(hits.iter().fold(START, add_hit))
}

const START: u64 = 0xcbf2_9ce4_8422_2325;

fn add_hit(hash: u64, hit: &Option<Hit>) -> u64 {
    let words = hit.map_or([u32::MAX; 6], |hit| {
        let [t, u, v] = [hit.t, hit.u, hit.v].map(f32::to_bits);
        [t, u, v, hit.prim, hit.geom, hit.inst]
    });
    let bytes = words.into_iter().flat_map(u32::to_le_bytes);
    bytes.fold(hash, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    })
}

fn hex(hash: u64) -> String {
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Lab;

    #[test]
    fn every_structure_has_the_same_hash_and_one_bit_changes_it() {
        let mut lab = Lab::open("builtin:sphere?n=500", None).unwrap();
        let mut hash_of = |structure: &str| {
            let at = lab.build(structure, "binned").unwrap().number;
            hits_hash(lab.scene(at).unwrap(), 5000, 3)
        };
        let brute_force = hash_of("list");
        for structure in ["bounded", "bvh2", "wide", "grid"] {
            assert_eq!(hash_of(structure), brute_force, "{structure}");
        }
        let hit = Hit {
            t: 2.0,
            u: 0.25,
            v: 0.5,
            prim: 7,
            geom: 0,
            inst: 0,
        };
        let next = Hit {
            v: f32::from_bits(0.5f32.to_bits() + 1),
            ..hit
        };
        assert_ne!(hash_of_hits(&[Some(hit)]), hash_of_hits(&[Some(next)]));
    }
}
