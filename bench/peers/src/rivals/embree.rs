//! Embree: single rays, and packets of 16 with the coherent flag as its batches.

use super::embree_abi::{
    Arguments, COHERENT, Functions, Handle, NONE, ROBUST, RayHit, RayHit16, Valid, WIDTH,
};
use boxwood::{Hit, Ray};
use boxwood_measure::{Built, Clock, Contender, MeasureError, Mode};
use boxwood_scene::FlatMesh;
use libloading::Library;
use std::{
    ffi::CString,
    ptr::{null, null_mut},
    sync::atomic::{AtomicIsize, Ordering},
};

/// What Embree is asked to build.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Build {
    /// Its name here.
    pub(crate) name: &'static str,
    /// `RTCBuildQuality`: 0 low, 1 medium, 2 high.
    quality: i32,
    robust: bool,
}

/// Every build that is measured. `embree` is what one gets without asking for anything.
pub(crate) const BUILDS: [Build; 4] = [
    Build {
        name: "embree",
        quality: 1,
        robust: false,
    },
    Build {
        name: "embree-low",
        quality: 0,
        robust: false,
    },
    Build {
        name: "embree-high",
        quality: 2,
        robust: false,
    },
    Build {
        name: "embree-robust",
        quality: 1,
        robust: true,
    },
];

/// A scene of Embree's.
struct Embree {
    name: &'static str,
    functions: Functions,
    device: Handle,
    scene: Handle,
    /// Bytes that the device holds; the device has its address.
    _memory: Box<AtomicIsize>,
}

// SAFETY: Embree's queries may be called from any thread at once; nothing else is called after the build.
unsafe impl Sync for Embree {}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: both handles are ours, and are not used again.
        unsafe {
            (self.functions.release_scene)(self.scene);
            (self.functions.release_device)(self.device);
        }
    }
}

/// Its version, as in `4.4.0`.
pub(crate) fn version(library: &Library) -> Result<String, MeasureError> {
    let functions = functions(library)?;
    // SAFETY: a device that is released at once; property 0 is the version.
    let version = unsafe {
        let device = (functions.new_device)(null());
        let version = (functions.device_property)(device, 0);
        (functions.release_device)(device);
        version
    };
    Ok(format!(
        "{}.{}.{}",
        version / 10_000,
        version / 100 % 100,
        version % 100
    ))
}

fn functions(library: &Library) -> Result<Functions, MeasureError> {
    Functions::of(library).map_err(|cause| MeasureError::Contender {
        name: "embree".to_owned(),
        cause: cause.to_string(),
        remedy: "name a library of Embree 4 in EMBREE_LIB".to_owned(),
    })
}

/// Builds over an indexed mesh, as a user would give it; only the commit of the scene is timed.
pub(crate) fn build(
    library: &Library,
    mesh: &FlatMesh,
    build: Build,
    threads: usize,
) -> Result<Built, MeasureError> {
    let functions = functions(library)?;
    let f = &functions;
    let memory = Box::new(AtomicIsize::new(0));
    let config = CString::new(format!("threads={threads},set_affinity=0")).unwrap_or_default();
    // SAFETY: the calls and their order are those of Embree's manual; `memory` outlives the device, see `Drop`.
    let embree = unsafe {
        let device = (f.new_device)(config.as_ptr());
        let user = (&raw const *memory).cast_mut().cast();
        (f.set_monitor)(device, count_memory, user);
        let scene = (f.new_scene)(device);
        (f.set_scene_flags)(scene, if build.robust { ROBUST } else { 0 });
        (f.set_scene_quality)(scene, build.quality);
        attach(f, device, scene, mesh, build.quality);
        Embree {
            name: build.name,
            functions,
            device,
            scene,
            _memory: memory,
        }
    };
    let before = embree._memory.load(Ordering::Relaxed);
    let clock = Clock::of_work_on(threads);
    let start = clock.now();
    // SAFETY: the scene is whole.
    unsafe { (f.commit_scene)(embree.scene) };
    let time = clock.now() - start;
    let bytes = embree._memory.load(Ordering::Relaxed) - before;
    // SAFETY: the device is there.
    let error = unsafe { (f.device_error)(embree.device) };
    if error != 0 {
        return Err(MeasureError::Contender {
            name: build.name.to_owned(),
            cause: format!("RTCError {error} while building"),
            remedy: "take a smaller scene".to_owned(),
        });
    }
    Ok(Built {
        contender: Box::new(embree),
        time,
        bytes: u64::try_from(bytes).ok(),
    })
}

/// Copies the mesh into buffers of Embree's and attaches it to the scene.
///
/// # Safety
/// `device` and `scene` must be live.
unsafe fn attach(f: &Functions, device: Handle, scene: Handle, mesh: &FlatMesh, quality: i32) {
    const TRIANGLES: i32 = 0;
    const INDEX: i32 = 0;
    const VERTEX: i32 = 1;
    const UINT3: i32 = 0x5003;
    const FLOAT3: i32 = 0x9003;
    // SAFETY: buffers have the sizes asked for; the geometry is released once the scene holds it.
    unsafe {
        let geometry = (f.new_geometry)(device, TRIANGLES);
        let vertices = (f.new_buffer)(geometry, VERTEX, 0, FLOAT3, 12, mesh.positions.len());
        let indices = (f.new_buffer)(geometry, INDEX, 0, UINT3, 12, mesh.indices.len());
        vertices
            .cast::<[f32; 3]>()
            .copy_from_nonoverlapping(mesh.positions.as_ptr(), mesh.positions.len());
        indices
            .cast::<[u32; 3]>()
            .copy_from_nonoverlapping(mesh.indices.as_ptr(), mesh.indices.len());
        if quality == 0 {
            // Low is a matter of the geometry too.
            (f.set_geometry_quality)(geometry, quality);
        }
        (f.commit_geometry)(geometry);
        (f.attach_geometry)(scene, geometry);
        (f.release_geometry)(geometry);
    }
}

extern "C" fn count_memory(user: Handle, bytes: isize, _after: bool) -> bool {
    // SAFETY: the address of `Embree::_memory`, which outlives the device.
    let memory = unsafe { &*user.cast::<AtomicIsize>() };
    memory.fetch_add(bytes, Ordering::Relaxed);
    true
}

/// For single rays nothing need be said; for packets that they are coherent.
const COHERENTLY: Arguments = Arguments {
    flags: COHERENT,
    features: u32::MAX,
    context: null_mut(),
    filter: null_mut(),
    intersect: null_mut(),
    min_width: 0.0,
};

fn ray_hit(ray: &Ray) -> RayHit {
    RayHit {
        origin: ray.origin,
        t_near: ray.t_min,
        dir: ray.dir,
        time: 0.0,
        t_far: ray.t_max,
        mask: u32::MAX,
        id: 0,
        flags: 0,
        normal: [0.0; 3],
        u: 0.0,
        v: 0.0,
        prim: NONE,
        geom: NONE,
        inst: [NONE; 2],
    }
}

fn hit(t: f32, u: f32, v: f32, prim: u32) -> Hit {
    Hit {
        t,
        u,
        v,
        prim,
        geom: 0,
        inst: Hit::NO_INSTANCE,
    }
}

/// At most 16 rays side by side.
fn packet(rays: &[Ray]) -> (RayHit16, Valid) {
    let mut packet = RayHit16 {
        origin: [[0.0; WIDTH]; 3],
        t_near: [0.0; WIDTH],
        dir: [[0.0; WIDTH]; 3],
        time: [0.0; WIDTH],
        t_far: [0.0; WIDTH],
        mask: [u32::MAX; WIDTH],
        id: [0; WIDTH],
        flags: [0; WIDTH],
        normal: [[0.0; WIDTH]; 3],
        u: [0.0; WIDTH],
        v: [0.0; WIDTH],
        prim: [NONE; WIDTH],
        geom: [NONE; WIDTH],
        inst: [[NONE; WIDTH]; 2],
    };
    let mut valid = Valid([0; WIDTH]);
    for (lane, ray) in rays.iter().enumerate() {
        valid.0[lane] = -1;
        for axis in 0..3 {
            packet.origin[axis][lane] = ray.origin[axis];
            packet.dir[axis][lane] = ray.dir[axis];
        }
        packet.t_near[lane] = ray.t_min;
        packet.t_far[lane] = ray.t_max;
    }
    (packet, valid)
}

impl Contender for Embree {
    fn name(&self) -> &str {
        self.name
    }

    fn has(&self, _: Mode) -> bool {
        true
    }

    fn closest_hits(&self, mode: Mode, rays: &[Ray], hits: &mut [Option<Hit>]) {
        if mode == Mode::Single {
            for (ray, answer) in rays.iter().zip(hits) {
                let mut asked = ray_hit(ray);
                // SAFETY: a committed scene, and a ray with room for its hit.
                unsafe { (self.functions.intersect1)(self.scene, &mut asked, null()) };
                let found = asked.geom != NONE;
                *answer = found.then(|| hit(asked.t_far, asked.u, asked.v, asked.prim));
            }
            return;
        }
        for (rays, answers) in rays.chunks(WIDTH).zip(hits.chunks_mut(WIDTH)) {
            let (mut asked, valid) = packet(rays);
            // SAFETY: as above, for 16 rays of which `valid` says which are there.
            unsafe { (self.functions.intersect16)(&valid, self.scene, &mut asked, &COHERENTLY) };
            for (lane, answer) in answers.iter_mut().enumerate() {
                let found = asked.geom[lane] != NONE;
                let (u, v) = (asked.u[lane], asked.v[lane]);
                *answer = found.then(|| hit(asked.t_far[lane], u, v, asked.prim[lane]));
            }
        }
    }

    fn occluded(&self, mode: Mode, rays: &[Ray], occluded: &mut [bool]) {
        if mode == Mode::Single {
            for (ray, answer) in rays.iter().zip(occluded) {
                let mut asked = ray_hit(ray);
                // SAFETY: a committed scene; only the ray part is looked at.
                unsafe { (self.functions.occluded1)(self.scene, &mut asked, null()) };
                // Embree says it by minus infinity.
                *answer = asked.t_far < 0.0;
            }
            return;
        }
        for (rays, answers) in rays.chunks(WIDTH).zip(occluded.chunks_mut(WIDTH)) {
            let (mut asked, valid) = packet(rays);
            // SAFETY: as above, for 16 rays of which `valid` says which are there.
            unsafe { (self.functions.occluded16)(&valid, self.scene, &mut asked, &COHERENTLY) };
            answers
                .iter_mut()
                .zip(&asked.t_far)
                .for_each(|(answer, t)| *answer = *t < 0.0);
        }
    }
}
