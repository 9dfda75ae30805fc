//! Embree 4's C interface, as far as it is called here (rtcore.h of Embree 4.4).

use libloading::Library;
use std::ffi::{c_char, c_void};

/// Any of Embree's handles.
pub(crate) type Handle = *mut c_void;

/// `RTCRay` and, behind it, `RTCHit`.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
pub(crate) struct RayHit {
    pub(crate) origin: [f32; 3],
    pub(crate) t_near: f32,
    pub(crate) dir: [f32; 3],
    pub(crate) time: f32,
    pub(crate) t_far: f32,
    pub(crate) mask: u32,
    pub(crate) id: u32,
    pub(crate) flags: u32,
    pub(crate) normal: [f32; 3],
    pub(crate) u: f32,
    pub(crate) v: f32,
    pub(crate) prim: u32,
    pub(crate) geom: u32,
    pub(crate) inst: [u32; 2],
}

/// Rays of a packet.
pub(crate) const WIDTH: usize = 16;

/// `RTCRay16` and, behind it, `RTCHit16`.
#[repr(C, align(64))]
pub(crate) struct RayHit16 {
    pub(crate) origin: [[f32; WIDTH]; 3],
    pub(crate) t_near: [f32; WIDTH],
    pub(crate) dir: [[f32; WIDTH]; 3],
    pub(crate) time: [f32; WIDTH],
    pub(crate) t_far: [f32; WIDTH],
    pub(crate) mask: [u32; WIDTH],
    pub(crate) id: [u32; WIDTH],
    pub(crate) flags: [u32; WIDTH],
    pub(crate) normal: [[f32; WIDTH]; 3],
    pub(crate) u: [f32; WIDTH],
    pub(crate) v: [f32; WIDTH],
    pub(crate) prim: [u32; WIDTH],
    pub(crate) geom: [u32; WIDTH],
    pub(crate) inst: [[u32; WIDTH]; 2],
}

/// Which rays of a packet are there: -1, else 0.
#[repr(C, align(64))]
pub(crate) struct Valid(pub(crate) [i32; WIDTH]);

/// `RTCIntersectArguments`, which `RTCOccludedArguments` equals.
#[repr(C)]
pub(crate) struct Arguments {
    pub(crate) flags: u32,
    pub(crate) features: u32,
    pub(crate) context: Handle,
    pub(crate) filter: Handle,
    pub(crate) intersect: Handle,
    pub(crate) min_width: f32,
}

/// `RTC_RAY_QUERY_FLAG_COHERENT`: the fast path for packets whose rays go the same way.
pub(crate) const COHERENT: u32 = 1 << 16;
/// `RTC_SCENE_FLAG_ROBUST`.
pub(crate) const ROBUST: u32 = 1 << 2;
/// `RTC_INVALID_GEOMETRY_ID`.
pub(crate) const NONE: u32 = u32::MAX;

/// `RTCMemoryMonitorFunction`.
pub(crate) type Monitor = extern "C" fn(user: Handle, bytes: isize, after: bool) -> bool;

macro_rules! functions {
    ($($field:ident = $symbol:literal: fn($($arg:ty),*) $(-> $ret:ty)?;)*) => {
        /// The functions, found by their names.
        #[derive(Clone, Copy)]
        pub(crate) struct Functions {
            $(pub(crate) $field: unsafe extern "C" fn($($arg),*) $(-> $ret)?,)*
        }

        impl Functions {
            /// Looks all of them up; the error names the first that is missing.
            pub(crate) fn of(library: &Library) -> Result<Self, libloading::Error> {
                // SAFETY: the signatures are those of rtcore.h.
                unsafe {
                    Ok(Self { $($field: *library.get($symbol.as_bytes())?,)* })
                }
            }
        }
    };
}

functions! {
    new_device = "rtcNewDevice": fn(*const c_char) -> Handle;
    release_device = "rtcReleaseDevice": fn(Handle);
    device_error = "rtcGetDeviceError": fn(Handle) -> i32;
    device_property = "rtcGetDeviceProperty": fn(Handle, i32) -> isize;
    set_monitor = "rtcSetDeviceMemoryMonitorFunction": fn(Handle, Monitor, Handle);
    new_scene = "rtcNewScene": fn(Handle) -> Handle;
    release_scene = "rtcReleaseScene": fn(Handle);
    set_scene_flags = "rtcSetSceneFlags": fn(Handle, u32);
    set_scene_quality = "rtcSetSceneBuildQuality": fn(Handle, i32);
    commit_scene = "rtcCommitScene": fn(Handle);
    new_geometry = "rtcNewGeometry": fn(Handle, i32) -> Handle;
    release_geometry = "rtcReleaseGeometry": fn(Handle);
    set_geometry_quality = "rtcSetGeometryBuildQuality": fn(Handle, i32);
    new_buffer = "rtcSetNewGeometryBuffer": fn(Handle, i32, u32, i32, usize, usize) -> Handle;
    commit_geometry = "rtcCommitGeometry": fn(Handle);
    attach_geometry = "rtcAttachGeometry": fn(Handle, Handle) -> u32;
    intersect1 = "rtcIntersect1": fn(Handle, *mut RayHit, *const Arguments);
    occluded1 = "rtcOccluded1": fn(Handle, *mut RayHit, *const Arguments);
    intersect16 = "rtcIntersect16": fn(*const Valid, Handle, *mut RayHit16, *const Arguments);
    occluded16 = "rtcOccluded16": fn(*const Valid, Handle, *mut RayHit16, *const Arguments);
}

const _: () = assert!(size_of::<RayHit>() == 96 && align_of::<RayHit>() == 16);
const _: () = assert!(size_of::<RayHit16>() == 21 * 64);
