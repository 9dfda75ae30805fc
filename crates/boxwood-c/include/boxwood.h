/* Boxwood: what does this ray hit? Exactly: one answer, bit for bit the same on every machine, for one ray or many.
 *
 *     BwScene *scene = bw_scene_new();
 *     bw_attach_triangles(scene, positions, position_count, 0, indices, triangle_count, 0);
 *     if (bw_scene_commit(scene) != BW_ERROR_NONE) puts(bw_last_error_message());
 *     BwRay ray = {{1, 2, 0}, 0, {0, 0, 1}, INFINITY};
 *     BwHit hit;
 *     if (bw_intersect1(scene, &ray, &hit)) printf("triangle %u at t = %g\n", (unsigned)hit.prim, hit.t);
 *     bw_scene_free(scene);
 *
 * Link with `pkg-config --cflags --libs boxwood`. Coming from Embree: docs/embree.md has every call beside its counterpart.
 *
 * Pointers. NULL where something is needed, a pointer that is not a multiple of 4, a stride that is none: these are errors. What
 * cannot be checked is the caller's promise: that a pointer leads to as many values as the call says, which nobody writes during
 * the call (nor reads, where they are written); that a scene came from bw_scene_new, bw_scene_open or bw_scene_read and was not
 * freed. Nothing is kept: what is attached is copied.
 *
 * Errors. A call fails with a BwError, or as its comment says, and changes nothing; bw_last_error_message has the sentence, for
 * each thread its own. Nothing unwinds into the program, and nothing ends it, unless the system has not even a few kilobytes left.
 *
 * Threads. Every function may be called from any thread at any time, but bw_scene_free last. Questions take no lock and change
 * nothing; a commit meanwhile disturbs none. The floating-point modes of the caller (FTZ, DAZ, rounding) neither matter nor
 * change. After a fork the child may go on asking. 128 KB of stack do. */


#ifndef BOXWOOD_H
#define BOXWOOD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// What does not exist: the geometry of a miss, the instance of a hit on triangles that stand in no instance.
#define BW_INVALID_ID UINT32_MAX

// Why a call failed. `bw_last_error_message` says it in a sentence.
typedef enum BwError {
  // It did not.
  BW_ERROR_NONE = 0,
  // A pointer is NULL that must not be.
  BW_ERROR_NULL_POINTER = 1,
  // A pointer is not a multiple of what its values need (4 bytes).
  BW_ERROR_MISALIGNED = 2,
  // A stride is smaller than what it steps over, or not a multiple of 4.
  BW_ERROR_BAD_STRIDE = 3,
  // More than 2^31 - 1 triangles in a scene, an array larger than memory can be, or a structure beyond 32-bit references.
  BW_ERROR_TOO_LARGE = 4,
  // A triangle names a vertex that does not exist.
  BW_ERROR_INDEX_OUT_OF_RANGE = 5,
  // The scene was never committed.
  BW_ERROR_NOT_COMMITTED = 6,
  // The scene has no geometry or instance of this number.
  BW_ERROR_NO_SUCH_ID = 7,
  // A scene holds triangles or instances, not both.
  BW_ERROR_MIXED = 8,
  // Instances stand in each other more than 8 deep, or multiply to 2^32 - 1 or more.
  BW_ERROR_NESTING = 9,
  // A matrix has a number that is not finite.
  BW_ERROR_NOT_FINITE = 10,
  // An argument is none of the values that it may have.
  BW_ERROR_INVALID_ARGUMENT = 11,
  // The question is not there for this kind of scene.
  BW_ERROR_UNSUPPORTED = 12,
  // The system did not grant the memory.
  BW_ERROR_OUT_OF_MEMORY = 13,
  // The system did not grant the threads.
  BW_ERROR_NO_THREADS = 14,
  // A mistake in Boxwood; please report it. The scene is as it was before the call.
  BW_ERROR_INTERNAL = 15,
  // The system did not let a file be read or written.
  BW_ERROR_FILE = 16,
  // A file is no scene, one of another version, or damaged.
  BW_ERROR_BAD_FILE = 17,
} BwError;

// How much a build may cost for how good a structure.
typedef enum BwQuality {
  // For scenes that are built again all the time.
  BW_QUALITY_FAST = 0,
  // Rays dear, builds cheap.
  BW_QUALITY_DEFAULT = 1,
  // For scenes that meet many rays.
  BW_QUALITY_HIGH = 2,
} BwQuality;

// A scene: triangles, or instances of scenes.
//
// It is asked as it was when it was last committed; what is attached or changed since then counts from the next commit on.
typedef struct BwScene BwScene;

// A box along the axes; `min > max` for a scene in which nothing can be hit.
typedef struct BwBounds {
  // Smallest corner.
  float min[3];
  // Largest corner.
  float max[3];
} BwBounds;

// What a committed scene holds.
typedef struct BwStats {
  // Triangles, with every instance multiplied out.
  uint64_t triangles;
  // Triangles as stored, each scene once.
  uint64_t stored;
  // Triangles, or instances in a scene of these, that can never be hit: coordinates that are not finite or beyond 2^100, a
  // matrix that cannot be undone. They keep their numbers.
  uint64_t skipped;
  // Memory, in bytes: structures and triangles, all scenes inside instances included, each once.
  uint64_t bytes;
} BwStats;

// A ray: the points `origin + t * dir` for `t_min <= t <= t_max`, both ends included.
//
// `dir` need not have unit length; `t` counts in units of `dir`. A negative `t_min` counts as 0, `t_max` may be INFINITY. A ray with
// NaN anywhere, an infinite origin or direction, a zero direction, an origin beyond 2^100, or a direction whose largest component
// is outside 2^-80..2^80 hits nothing: see `bw_ray_is_valid`.
typedef struct BwRay {
  // Where `t` is 0.
  float origin[3];
  // Smallest accepted `t`.
  float t_min;
  // Any length but zero.
  float dir[3];
  // Largest accepted `t`.
  float t_max;
} BwRay;

// Where a ray meets a triangle: the point is `(1 - u - v) * v0 + u * v1 + v * v2`.
//
// A miss has `geom == BW_INVALID_ID`, as well as `prim` and `inst`, `t` is INFINITY, the rest 0.
typedef struct BwHit {
  // Ray parameter, in units of the ray's `dir`.
  float t;
  // Weight of the second vertex, 0 to 1.
  float u;
  // Weight of the third vertex, 0 to 1.
  float v;
  // Triangle within its geometry.
  uint32_t prim;
  // Geometry within its scene, as `bw_attach_triangles` numbered it.
  uint32_t geom;
  // Instance, as `bw_attach_instance` numbered it, or BW_INVALID_ID. Where instances hold instances, the ways to scenes of
  // triangles are numbered in the order of the instances, depth first.
  uint32_t inst;
  // Normal by the order of the vertices (counter-clockwise in front), in the world; its length is twice the triangle's area.
  float ng[3];
} BwHit;

// The place of a surface that is nearest to a point: `(1 - u - v) * v0 + u * v1 + v * v2`.
//
// For a point that is not finite and in an empty scene `geom` and `prim` are BW_INVALID_ID, `point` and `distance` NaN.
typedef struct BwNearest {
  // The place.
  float point[3];
  // From the point to the place, never negative.
  float distance;
  // Weight of the second vertex, 0 to 1.
  float u;
  // Weight of the third vertex, 0 to 1.
  float v;
  // Triangle within its geometry.
  uint32_t prim;
  // Geometry within the scene.
  uint32_t geom;
} BwNearest;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The version of the library, as "0.1.0".
const char *bw_version(void);

// The code of this thread's latest failed call; BW_ERROR_NONE if there was none since `bw_clear_error`.
//
// Calls that succeed leave it as it is, so that it can be asked once after many.
enum BwError bw_last_error(void);

// What went wrong in it, in a sentence; "" if nothing did. Never NULL.
//
// The text belongs to the library and stays until this thread's next failed call, `bw_clear_error` or end: copy it to keep it.
const char *bw_last_error_message(void);

// Forgets this thread's error.
void bw_clear_error(void);

// A scene of nothing yet; NULL after an error. `bw_scene_free` ends it.
struct BwScene *bw_scene_new(void);

// Writes the scene as it was last committed to a file (`.bwx`), some 90 bytes a triangle, which `bw_scene_open` opens without a build,
// as do Rust, Python and the command line. Only triangles that are not compact are saved: BW_ERROR_UNSUPPORTED for others.
//
// The file is written beside `path` and renamed there: whoever reads what stood there, or has it mapped, keeps it, and after an error it
// stays. `path` ends with a zero byte, and is UTF-8 where the system does not take any bytes.
enum BwError bw_scene_save(const struct BwScene *scene,
                           const char *path);

// The scene in a file that `bw_scene_save` wrote, committed; NULL after an error. `bw_scene_free` ends it. All bytes are checked first.
//
// The file is mapped, not copied: all processes that open it share one copy. It must stay as it is until all scenes and instances made
// of it have gone: saving over it by renaming, as `bw_scene_save` does, is fine, but a program that writes into it in place breaks its
// readers in any way (wrong answers, a crash), and one that cuts it short ends them (SIGBUS). Where that may be, take `bw_scene_read`.
struct BwScene *bw_scene_open(const char *path);

// `bw_scene_open`, but copied into memory: what becomes of the file afterwards does not matter.
struct BwScene *bw_scene_read(const char *path);

// Ends a scene; NULL is fine. No other call may be using it. Instances of it in other scenes stay.
void bw_scene_free(struct BwScene *scene);

// Adds a mesh of triangles: three floats per position, three numbers of positions per triangle. Both are copied, so the arrays
// may go.
//
// Strides are in bytes from one position or triangle to the next, multiples of 4; 0: without gaps. Returns the number of the
// geometry, 0 for the first (`BwHit.geom`), or BW_INVALID_ID after an error: an index out of range, instances in the scene, more
// than 2^31 - 1 triangles. Positions that are not finite are no error: their triangles keep their numbers, are never hit, and are
// counted in `BwStats.skipped`.
uint32_t bw_attach_triangles(struct BwScene *scene,
                             const float *positions,
                             size_t position_count,
                             size_t position_stride,
                             const uint32_t *indices,
                             size_t triangle_count,
                             size_t index_stride);

// Puts another mesh in the place of geometry `geom`, of as many triangles as you like; no triangles remove it, and its number
// stays. It counts from the next commit on. Arguments as in `bw_attach_triangles`.
enum BwError bw_set_triangles(struct BwScene *scene,
                              uint32_t geom,
                              const float *positions,
                              size_t position_count,
                              size_t position_stride,
                              const uint32_t *indices,
                              size_t triangle_count,
                              size_t index_stride);

// Adds an instance of a committed scene, as it is now: it is shared, not copied, and `content` may change or be freed later.
//
// `world_from_object` is a 3x4 matrix of twelve floats, row by row: x' = m0 x + m1 y + m2 z + m3, and so on. Rays asked with a mask
// see the instance if it shares a bit with `mask`; 0xFFFFFFFF is seen by all. A scene is of triangles or of instances. Returns the
// number of the instance, 0 for the first (`BwHit.inst`), or BW_INVALID_ID after an error. A matrix that cannot be undone is no
// error: the instance is never hit and counted in `BwStats.skipped`.
uint32_t bw_attach_instance(struct BwScene *scene,
                            const struct BwScene *content,
                            const float *world_from_object,
                            uint32_t mask);

// Moves instance `inst`, from the next commit on. The matrix as in `bw_attach_instance`.
enum BwError bw_set_transform(struct BwScene *scene, uint32_t inst, const float *world_from_object);

// How well the next commit builds: a `BwQuality`. Answers are the same in all.
enum BwError bw_scene_set_quality(struct BwScene *scene, uint32_t quality);

// Whether the next commit builds the form that takes about 0.6 of the memory at about 0.6 of the speed. Answers are the same.
enum BwError bw_scene_set_compact(struct BwScene *scene,
                                  bool is_compact);

// On how many threads this scene is committed and answers arrays of questions: 0, as at first, for as many as the machine has; 1
// for arrays on the calling thread alone. Answers are the same. Threads are shared by all scenes of the same number, and stay.
enum BwError bw_scene_set_threads(struct BwScene *scene,
                                  uint32_t threads);

// Builds what is attached; from then on the scene is asked as it is now. After an error everything is as before.
//
// Other threads may ask the scene meanwhile: each call gets its answers from before or from after the commit, never a mixture.
enum BwError bw_scene_commit(struct BwScene *scene);

// The box around all that can be hit.
enum BwError bw_scene_bounds(const struct BwScene *scene, struct BwBounds *bounds);

// How much the scene holds.
enum BwError bw_scene_stats(const struct BwScene *scene, struct BwStats *stats);

// False for a ray that hits nothing by definition, because it is none: see `BwRay`. False for NULL.
bool bw_ray_is_valid(const struct BwRay *ray);

// The closest hit: the one with the smallest `t`, and of equal ones that with the smallest (inst, geom, prim).
//
// True for a hit. For a miss, and after an error (`bw_last_error`), false, and `hit->geom` is BW_INVALID_ID.
bool bw_intersect1(const struct BwScene *scene, const struct BwRay *ray, struct BwHit *hit);

// `bw_intersect1` among the instances whose mask shares a bit with `mask`, on every level. Triangles have no mask and are always
// there.
bool bw_intersect1_masked(const struct BwScene *scene,
                          const struct BwRay *ray,
                          uint32_t mask,
                          struct BwHit *hit);

// True if anything is hit in the ray's range. After an error (`bw_last_error`) false.
bool bw_occluded1(const struct BwScene *scene, const struct BwRay *ray);

// `bw_occluded1` by the instances whose mask shares a bit with `mask`.
bool bw_occluded1_masked(const struct BwScene *scene, const struct BwRay *ray, uint32_t mask);

// All hits in the ray's range, nearest first, each triangle at most once: the first `capacity` of them are written to `hits`, and
// how many there are in all to `total`.
//
// If `total` is larger than `capacity`, ask again with more room. `hits` may be NULL if `capacity` is 0: then they are only counted.
// Else all of them, 24 bytes each, are in memory meanwhile, however small `capacity` is; a ray may meet every triangle there is.
enum BwError bw_all_hits1(const struct BwScene *scene,
                          const struct BwRay *ray,
                          struct BwHit *hits,
                          size_t capacity,
                          size_t *total);

// `bw_intersect1` for `count` rays, on the scene's threads, and up to three times as fast on each.
//
// Strides are in bytes, multiples of 4; 0: without gaps. Rays and hits may be woven into each other. Neighbours that go the same way
// are quickest.
enum BwError bw_intersect(const struct BwScene *scene,
                          const struct BwRay *rays,
                          size_t count,
                          size_t ray_stride,
                          struct BwHit *hits,
                          size_t hit_stride);

// `bw_occluded1` for `count` rays, on the scene's threads: `occluded[i]` is the answer to ray `i`.
enum BwError bw_occluded(const struct BwScene *scene,
                         const struct BwRay *rays,
                         size_t count,
                         size_t ray_stride,
                         bool *occluded);

// The place of the surface that is nearest to each of `count` points, three floats each: of equally near ones that of the smallest
// (geom, prim). For scenes of triangles only.
enum BwError bw_closest_points(const struct BwScene *scene,
                               const float *points,
                               size_t count,
                               size_t point_stride,
                               struct BwNearest *nearest,
                               size_t nearest_stride);

// The distance of each of `count` points to the surface, negative inside: `distances[i]` is that of point `i`, NaN where
// `bw_closest_points` has no answer. For scenes of triangles only.
//
// Inside is where a ray to the outside meets an odd number of surfaces: exact on closed meshes.
enum BwError bw_signed_distances(const struct BwScene *scene,
                                 const float *points,
                                 size_t count,
                                 size_t point_stride,
                                 float *distances);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BOXWOOD_H */

#ifdef __cplusplus
static_assert(sizeof(BwRay) == 32 && sizeof(BwHit) == 36 && sizeof(BwNearest) == 32, "packed as Rust has them");
static_assert(sizeof(BwBounds) == 24 && sizeof(BwStats) == 32, "packed as Rust has them");
#elif defined(__STDC_VERSION__) && __STDC_VERSION__ >= 201112L
_Static_assert(sizeof(BwRay) == 32 && sizeof(BwHit) == 36 && sizeof(BwNearest) == 32, "packed as Rust has them");
_Static_assert(sizeof(BwBounds) == 24 && sizeof(BwStats) == 32, "packed as Rust has them");
#endif
