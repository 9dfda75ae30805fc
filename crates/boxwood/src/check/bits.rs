//! Hits, bit for bit.

use super::rays::mix;
use crate::geom::Hit;

/// The same bits in all.
pub(super) fn same(a: Option<&Hit>, b: Option<&Hit>) -> bool {
    a.map(bits) == b.map(bits)
}

fn bits(hit: &Hit) -> [u32; 6] {
    let Hit {
        t,
        u,
        v,
        prim,
        geom,
        inst,
    } = *hit;
    [t.to_bits(), u.to_bits(), v.to_bits(), prim, geom, inst]
}

/// Depends on every bit of every hit and on their order.
pub(super) fn digest<'a>(hits: impl IntoIterator<Item = &'a Hit>) -> u64 {
    let words = hits.into_iter().flat_map(bits);
    words.fold(0, |sum, word| mix(sum ^ (u64::from(word) << 1 | 1)))
}
