//! Embree 3 or 4 through its C interface, loaded at run time.

use std::ffi::{CStr, CString, c_char, c_void};
use std::time::Instant;

use gi_bvh::ray::Ray;

use crate::meshes::Mesh;

type Handle = *mut c_void;

#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct RtcRay {
    o: [f32; 3],
    tnear: f32,
    d: [f32; 3],
    time: f32,
    tfar: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct RtcHit {
    ng: [f32; 3],
    u: f32,
    v: f32,
    prim: u32,
    geom: u32,
    inst: [u32; 5],
}

#[repr(C, align(16))]
struct RtcRayHit {
    ray: RtcRay,
    hit: RtcHit,
}

/// The context that version 3 needs with every call.
#[repr(C)]
struct Context3 {
    flags: u32,
    filter: *const c_void,
    inst: [u32; 8],
}

const NONE: u32 = u32::MAX;
const TRIANGLES: u32 = 0;
const INDEX: u32 = 0;
const VERTEX: u32 = 1;
const UINT3: u32 = 0x5003;
const FLOAT3: u32 = 0x9003;
const MEDIUM: u32 = 1;
const ROBUST: u32 = 4;
const VERSION: u32 = 0;

/// The functions of one library.
pub(crate) struct Library {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    property: unsafe extern "C" fn(Handle, u32) -> isize,
    new_scene: unsafe extern "C" fn(Handle) -> Handle,
    set_flags: unsafe extern "C" fn(Handle, u32),
    set_quality: unsafe extern "C" fn(Handle, u32),
    new_geometry: unsafe extern "C" fn(Handle, u32) -> Handle,
    set_buffer: unsafe extern "C" fn(Handle, u32, u32, u32, usize, usize) -> Handle,
    commit_geometry: unsafe extern "C" fn(Handle),
    attach: unsafe extern "C" fn(Handle, Handle) -> u32,
    release_geometry: unsafe extern "C" fn(Handle),
    commit_scene: unsafe extern "C" fn(Handle),
    release_scene: unsafe extern "C" fn(Handle),
    release_device: unsafe extern "C" fn(Handle),
    intersect: Handle,
    occluded: Handle,
}

impl Library {
    /// Load the library at `path`.
    #[expect(
        clippy::missing_transmute_annotations,
        clippy::useless_transmute,
        reason = "each field gives the type"
    )]
    pub(crate) fn open(path: &str) -> Result<Library, String> {
        let c_path = CString::new(path).map_err(|e| e.to_string())?;
        // SAFETY: the path is a C string; Embree's initialisation has no preconditions.
        let library = unsafe { libc::dlopen(c_path.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL) };
        if library.is_null() {
            // SAFETY: after a failed dlopen, dlerror gives a C string.
            return Err(unsafe { CStr::from_ptr(libc::dlerror()) }.to_string_lossy().into_owned());
        }
        macro_rules! symbol {
            ($name:literal) => {{
                // SAFETY: the handle is open and the name is a C string.
                let address = unsafe { libc::dlsym(library, concat!($name, "\0").as_ptr().cast()) };
                if address.is_null() {
                    return Err(concat!($name, " is missing").to_string());
                }
                // SAFETY: the field that receives it has the signature from Embree's header.
                unsafe { std::mem::transmute::<*mut c_void, _>(address) }
            }};
        }
        Ok(Library {
            new_device: symbol!("rtcNewDevice"),
            property: symbol!("rtcGetDeviceProperty"),
            new_scene: symbol!("rtcNewScene"),
            set_flags: symbol!("rtcSetSceneFlags"),
            set_quality: symbol!("rtcSetSceneBuildQuality"),
            new_geometry: symbol!("rtcNewGeometry"),
            set_buffer: symbol!("rtcSetNewGeometryBuffer"),
            commit_geometry: symbol!("rtcCommitGeometry"),
            attach: symbol!("rtcAttachGeometry"),
            release_geometry: symbol!("rtcReleaseGeometry"),
            commit_scene: symbol!("rtcCommitScene"),
            release_scene: symbol!("rtcReleaseScene"),
            release_device: symbol!("rtcReleaseDevice"),
            intersect: symbol!("rtcIntersect1"),
            occluded: symbol!("rtcOccluded1"),
        })
    }
}

/// A committed scene.
pub(crate) struct Embree<'a> {
    library: &'a Library,
    device: Handle,
    scene: Handle,
    version: isize,
    /// Wall-clock time of the commit.
    pub(crate) build_seconds: f64,
}

impl<'a> Embree<'a> {
    /// Build at medium quality, Embree's default.
    pub(crate) fn new(library: &'a Library, mesh: &Mesh, robust: bool, threads: usize) -> Self {
        let config = CString::new(format!("threads={threads}")).expect("no zero byte");
        // SAFETY: the calls follow the order that Embree documents, and the buffers have the sizes that are written.
        unsafe {
            let device = (library.new_device)(config.as_ptr());
            assert!(!device.is_null(), "Embree creates no device");
            let version = (library.property)(device, VERSION);
            let geometry = (library.new_geometry)(device, TRIANGLES);
            let (nv, nf) = (mesh.vertices.len(), mesh.faces.len());
            let vertices = (library.set_buffer)(geometry, VERTEX, 0, FLOAT3, 12, nv);
            std::ptr::copy_nonoverlapping(
                mesh.vertices.as_ptr().cast::<[f32; 3]>(),
                vertices.cast(),
                nv,
            );
            let indices = (library.set_buffer)(geometry, INDEX, 0, UINT3, 12, nf);
            std::ptr::copy_nonoverlapping(mesh.faces.as_ptr(), indices.cast(), nf);
            (library.commit_geometry)(geometry);
            let scene = (library.new_scene)(device);
            (library.set_flags)(scene, if robust { ROBUST } else { 0 });
            (library.set_quality)(scene, MEDIUM);
            (library.attach)(scene, geometry);
            (library.release_geometry)(geometry);
            let start = Instant::now();
            (library.commit_scene)(scene);
            Embree { library, device, scene, version, build_seconds: start.elapsed().as_secs_f64() }
        }
    }

    /// Embree's version number, such as 40400.
    pub(crate) fn version(&self) -> isize {
        self.version
    }

    fn ray(ray: &Ray) -> RtcRay {
        let (o, d) = (ray.o.to_array(), ray.d.to_array());
        RtcRay { o, tnear: ray.tmin, d, time: 0.0, tfar: ray.tmax, mask: NONE, id: 0, flags: 0 }
    }

    /// Parameter and primitive of the nearest hit.
    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<(f32, u32)> {
        type Intersect3 = unsafe extern "C" fn(Handle, *mut Context3, *mut RtcRayHit);
        type Intersect4 = unsafe extern "C" fn(Handle, *mut RtcRayHit, Handle);
        let hit = RtcHit { ng: [0.0; 3], u: 0.0, v: 0.0, prim: NONE, geom: NONE, inst: [NONE; 5] };
        let mut query = RtcRayHit { ray: Self::ray(ray), hit };
        // SAFETY: the function has the signature of its version, and our structures are at least as large as Embree's.
        unsafe {
            if self.version < 40000 {
                let mut context = Context3 { flags: 0, filter: std::ptr::null(), inst: [NONE; 8] };
                let f: Intersect3 = std::mem::transmute(self.library.intersect);
                f(self.scene, &mut context, &mut query);
            } else {
                let f: Intersect4 = std::mem::transmute(self.library.intersect);
                f(self.scene, &mut query, std::ptr::null_mut());
            }
        }
        (query.hit.geom != NONE).then_some((query.ray.tfar, query.hit.prim))
    }

    /// Whether anything is hit.
    #[inline]
    pub(crate) fn occluded(&self, ray: &Ray) -> bool {
        type Occluded3 = unsafe extern "C" fn(Handle, *mut Context3, *mut RtcRay);
        type Occluded4 = unsafe extern "C" fn(Handle, *mut RtcRay, Handle);
        let mut query = Self::ray(ray);
        // SAFETY: as in `closest`.
        unsafe {
            if self.version < 40000 {
                let mut context = Context3 { flags: 0, filter: std::ptr::null(), inst: [NONE; 8] };
                let f: Occluded3 = std::mem::transmute(self.library.occluded);
                f(self.scene, &mut context, &mut query);
            } else {
                let f: Occluded4 = std::mem::transmute(self.library.occluded);
                f(self.scene, &mut query, std::ptr::null_mut());
            }
        }
        query.tfar < 0.0
    }
}

impl Drop for Embree<'_> {
    fn drop(&mut self) {
        // SAFETY: both handles are valid and not used afterwards.
        unsafe {
            (self.library.release_scene)(self.scene);
            (self.library.release_device)(self.device);
        }
    }
}
