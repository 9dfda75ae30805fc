//! A scene as C holds it, and what to ask it.

use boxwood::{Hit, Scene, Transform};
use boxwood_c::*;
use std::ffi::CStr;

/// A handle that frees itself. Only tests of what is allowed share it.
pub(crate) struct Handle(pub(crate) *mut BwScene);

// SAFETY: the header allows every call from every thread.
unsafe impl Sync for Handle {}
// SAFETY: as above.
unsafe impl Send for Handle {}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: made by `bw_scene_new`, freed once.
        unsafe { bw_scene_free(self.0) };
    }
}

pub(crate) type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

impl Handle {
    pub(crate) fn new() -> Self {
        let handle = bw_scene_new();
        assert!(!handle.is_null());
        Self(handle)
    }

    pub(crate) fn attach(&self, (positions, indices): &Mesh) -> u32 {
        // SAFETY: the slices are there during the call.
        unsafe {
            bw_attach_triangles(
                self.0,
                positions.as_ptr().cast(),
                positions.len(),
                12,
                indices.as_ptr().cast(),
                indices.len(),
                12,
            )
        }
    }

    pub(crate) fn set(&self, geom: u32, (positions, indices): &Mesh) -> BwError {
        let (vertices, triangles) = (positions.len(), indices.len());
        let (positions, indices) = (positions.as_ptr().cast(), indices.as_ptr().cast());
        // SAFETY: the slices are there during the call.
        unsafe { bw_set_triangles(self.0, geom, positions, vertices, 0, indices, triangles, 0) }
    }

    pub(crate) fn place(&self, content: &Self, matrix: &Transform) -> u32 {
        // SAFETY: twelve numbers.
        unsafe { bw_attach_instance(self.0, content.0, matrix.0.as_ptr().cast(), 1) }
    }

    pub(crate) fn commit(&self) -> BwError {
        // SAFETY: a scene.
        unsafe { bw_scene_commit(self.0) }
    }

    pub(crate) fn committed(meshes: &[&Mesh]) -> Self {
        let handle = Self::new();
        for (mesh, geom) in meshes.iter().zip(0..) {
            assert_eq!(handle.attach(mesh), geom);
        }
        assert_eq!(handle.commit(), BwError::None);
        handle
    }

    pub(crate) fn intersect1(&self, ray: &BwRay) -> (bool, BwHit) {
        let mut hit = BOGUS;
        // SAFETY: a ray, and room for a hit.
        (unsafe { bw_intersect1(self.0, ray, &mut hit) }, hit)
    }

    pub(crate) fn intersect(&self, rays: &[BwRay]) -> Vec<BwHit> {
        let mut hits = vec![BOGUS; rays.len()];
        // SAFETY: as many hits as rays.
        let code =
            unsafe { bw_intersect(self.0, rays.as_ptr(), rays.len(), 0, hits.as_mut_ptr(), 0) };
        assert_eq!(code, BwError::None);
        hits
    }

    pub(crate) fn stats(&self) -> BwStats {
        let mut stats = BwStats {
            triangles: 0,
            stored: 0,
            skipped: 0,
            bytes: 0,
        };
        // SAFETY: room for the answer.
        assert_eq!(unsafe { bw_scene_stats(self.0, &mut stats) }, BwError::None);
        stats
    }
}

/// What no question answers.
pub(crate) const BOGUS: BwHit = BwHit {
    t: -7.0,
    u: -7.0,
    v: -7.0,
    prim: 7,
    geom: 7,
    inst: 7,
    ng: [7.0; 3],
};

pub(crate) fn last() -> (BwError, String) {
    // SAFETY: a C string, copied before the next call.
    let text = unsafe { CStr::from_ptr(bw_last_error_message()) };
    (bw_last_error(), text.to_str().unwrap().to_owned())
}

/// Numbers in -1..1, the same every time.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u32 << 23) as f32 - 1.0
    }

    pub(crate) fn point(&mut self, size: f32) -> [f32; 3] {
        std::array::from_fn(|_| size * self.next())
    }
}

/// Triangles all over the place.
pub(crate) fn soup(seed: u64, count: u32) -> Mesh {
    let mut random = Random(seed);
    let corners = |_| {
        let centre = random.point(4.0);
        [(); 3].map(|()| {
            let off = random.point(0.7);
            std::array::from_fn(|k| centre[k] + off[k])
        })
    };
    let positions = (0..count).flat_map(corners).collect();
    (
        positions,
        (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    )
}

pub(crate) fn rays(seed: u64, count: usize) -> Vec<BwRay> {
    let mut random = Random(seed);
    let mut ray = |_| {
        let (from, to) = (random.point(6.0), random.point(3.0));
        let dir = std::array::from_fn(|k| to[k] - from[k]);
        BwRay {
            origin: from,
            t_min: 0.0,
            dir,
            t_max: 1.5,
        }
    };
    (0..count).map(&mut ray).collect()
}

pub(crate) fn ray(origin: [f32; 3], dir: [f32; 3]) -> BwRay {
    BwRay {
        origin,
        t_min: 0.0,
        dir,
        t_max: f32::INFINITY,
    }
}

/// One triangle at a height.
pub(crate) fn plate(z: f32) -> Mesh {
    (
        vec![[-9.0, -9.0, z], [9.0, -9.0, z], [0.0, 9.0, z]],
        vec![[0, 1, 2]],
    )
}

/// The bits of a hit.
pub(crate) fn bits(hit: &BwHit) -> [u32; 9] {
    let [x, y, z] = hit.ng.map(f32::to_bits);
    let [t, u, v] = [hit.t, hit.u, hit.v].map(f32::to_bits);
    [t, u, v, hit.prim, hit.geom, hit.inst, x, y, z]
}

pub(crate) fn same(scene: &Scene, expected: Option<Hit>, found: &BwHit) {
    let Some(hit) = expected else {
        assert_eq!(
            (found.geom, found.prim, found.inst),
            (BW_INVALID_ID, BW_INVALID_ID, BW_INVALID_ID)
        );
        assert_eq!(
            (found.t, found.u, found.v, found.ng),
            (f32::INFINITY, 0.0, 0.0, [0.0; 3])
        );
        return;
    };
    let Hit {
        t,
        u,
        v,
        prim,
        geom,
        inst,
    } = hit;
    let ng = scene.normal(&hit).unwrap();
    assert_eq!(
        bits(found),
        bits(&BwHit {
            t,
            u,
            v,
            prim,
            geom,
            inst,
            ng
        })
    );
}
