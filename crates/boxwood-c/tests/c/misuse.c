/* Everything that C can do wrong and a library can notice, and what a host may do around it: each has its code, nothing leaks,
 * nothing falls over. Prints what failed; says at the end how much was tried. */
#if defined(__linux__)
#define _POSIX_C_SOURCE 200809L
#endif
#include <boxwood.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

static int tried = 0, failed = 0;

#define CHECK(truth)                                                                                                   \
    do {                                                                                                               \
        tried++;                                                                                                       \
        if (!(truth)) {                                                                                                \
            failed++;                                                                                                  \
            printf("line %d: %s (%s)\n", __LINE__, #truth, bw_last_error_message());                                   \
        }                                                                                                              \
    } while (0)

/* The call has failed with this code, and its thread can read of it what `part` says. */
#define FAILS(call, code, part)                                                                                        \
    do {                                                                                                               \
        bw_clear_error();                                                                                              \
        CHECK((call));                                                                                                 \
        CHECK(bw_last_error() == (code));                                                                              \
        CHECK(strstr(bw_last_error_message(), (part)) != NULL);                                                        \
    } while (0)

static const float CORNERS[][3] = {{-4, -4, 5}, {4, -4, 5}, {0, 4, 5}};
static const uint32_t TRIANGLE[3] = {0, 1, 2};

static BwScene *plate(void) {
    BwScene *scene = bw_scene_new();
    CHECK(bw_attach_triangles(scene, CORNERS[0], 3, 0, TRIANGLE, 1, 0) == 0);
    CHECK(bw_scene_commit(scene) == BW_ERROR_NONE);
    return scene;
}

static void null_pointers(BwScene *scene) {
    BwRay ray = {{0, 0, 0}, 0, {0, 0, 1}, INFINITY};
    BwHit hit;
    BwBounds bounds;
    BwStats stats;
    size_t total;
    float number[12] = {0};
    BwNearest nearest;
    bool occluded;
    const BwError null = BW_ERROR_NULL_POINTER;
    FAILS(bw_attach_triangles(NULL, CORNERS[0], 3, 0, TRIANGLE, 1, 0) == BW_INVALID_ID, null, "scene is NULL");
    FAILS(bw_attach_triangles(scene, NULL, 3, 0, TRIANGLE, 1, 0) == BW_INVALID_ID, null, "positions is NULL");
    FAILS(bw_attach_triangles(scene, CORNERS[0], 3, 0, NULL, 1, 0) == BW_INVALID_ID, null, "indices is NULL");
    FAILS(bw_set_triangles(NULL, 0, CORNERS[0], 3, 0, TRIANGLE, 1, 0) == null, null, "scene");
    FAILS(bw_set_triangles(scene, 0, CORNERS[0], 3, 0, NULL, 1, 0) == null, null, "indices");
    FAILS(bw_attach_instance(scene, NULL, number, 1) == BW_INVALID_ID, null, "content");
    FAILS(bw_attach_instance(scene, scene, NULL, 1) == BW_INVALID_ID, null, "world_from_object");
    FAILS(bw_set_transform(scene, 0, NULL) == null, null, "world_from_object");
    FAILS(bw_scene_set_quality(NULL, BW_QUALITY_HIGH) == null, null, "scene");
    FAILS(bw_scene_set_compact(NULL, true) == null, null, "scene");
    FAILS(bw_scene_set_threads(NULL, 1) == null, null, "scene");
    FAILS(bw_scene_commit(NULL) == null, null, "scene");
    FAILS(bw_scene_bounds(NULL, &bounds) == null, null, "scene");
    FAILS(bw_scene_bounds(scene, NULL) == null, null, "bounds");
    FAILS(bw_scene_stats(NULL, &stats) == null, null, "scene");
    FAILS(bw_scene_stats(scene, NULL) == null, null, "stats");
    FAILS(!bw_ray_is_valid(NULL), null, "ray");
    FAILS(!bw_intersect1(NULL, &ray, &hit), null, "scene");
    CHECK(hit.geom == BW_INVALID_ID);
    FAILS(!bw_intersect1(scene, NULL, &hit), null, "ray");
    FAILS(!bw_intersect1(scene, &ray, NULL), null, "hit");
    FAILS(!bw_intersect1_masked(NULL, &ray, 1, &hit), null, "scene");
    FAILS(!bw_occluded1(NULL, &ray), null, "scene");
    FAILS(!bw_occluded1(scene, NULL), null, "ray");
    FAILS(!bw_occluded1_masked(scene, NULL, 1), null, "ray");
    FAILS(bw_all_hits1(scene, &ray, NULL, 4, &total) == null, null, "hits");
    FAILS(bw_all_hits1(scene, &ray, &hit, 1, NULL) == null, null, "total");
    FAILS(bw_intersect(NULL, &ray, 1, 0, &hit, 0) == null, null, "scene");
    FAILS(bw_intersect(scene, NULL, 1, 0, &hit, 0) == null, null, "rays");
    FAILS(bw_intersect(scene, &ray, 1, 0, NULL, 0) == null, null, "hits");
    FAILS(bw_occluded(scene, &ray, 1, 0, NULL) == null, null, "occluded");
    FAILS(bw_occluded(scene, NULL, 1, 0, &occluded) == null, null, "rays");
    FAILS(bw_closest_points(scene, NULL, 1, 0, &nearest, 0) == null, null, "points");
    FAILS(bw_closest_points(scene, number, 1, 0, NULL, 0) == null, null, "nearest");
    FAILS(bw_signed_distances(scene, number, 1, 0, NULL) == null, null, "distances");
    FAILS(bw_scene_save(NULL, "a.bwx") == null, null, "scene");
    FAILS(bw_scene_save(scene, NULL) == null, null, "path");
    FAILS(bw_scene_open(NULL) == NULL, null, "path");
    FAILS(bw_scene_read(NULL) == NULL, null, "path");
    bw_scene_free(NULL);
}

/* A scene that was saved answers as before; what is no scene, or cannot be written, is refused. */
static void files(void) {
    const BwRay ray = {{0, 0, 0}, 0, {0, 0, 1}, INFINITY};
    char folder[256], path[sizeof folder + 8], nowhere[sizeof folder + 16];
    const char *temporary = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/boxwood-XXXXXX", temporary != NULL ? temporary : "/tmp");
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof path, "%s/a.bwx", folder);
    snprintf(nowhere, sizeof nowhere, "%s/no/a.bwx", folder);
    BwScene *scene = plate(), *fresh = bw_scene_new();
    FAILS(bw_scene_open(path) == NULL, BW_ERROR_FILE, "a.bwx");
    FAILS(bw_scene_save(fresh, path) == BW_ERROR_NOT_COMMITTED, BW_ERROR_NOT_COMMITTED, "bw_scene_commit");
    FAILS(bw_scene_save(scene, nowhere) == BW_ERROR_FILE, BW_ERROR_FILE, "no/a.bwx");
    FAILS(bw_scene_save(scene, "") == BW_ERROR_INVALID_ARGUMENT, BW_ERROR_INVALID_ARGUMENT, "empty");
    CHECK(bw_scene_save(scene, path) == BW_ERROR_NONE);
    BwScene *opened[2] = {bw_scene_open(path), bw_scene_read(path)};
    CHECK(bw_scene_save(scene, path) == BW_ERROR_NONE);
    for (int i = 0; i < 2; i++) {
        BwHit hit;
        CHECK(bw_intersect1(opened[i], &ray, &hit) && hit.t == 5);
        CHECK(bw_attach_triangles(opened[i], CORNERS[0], 3, 0, TRIANGLE, 1, 0) == 1);
        CHECK(bw_scene_commit(opened[i]) == BW_ERROR_NONE);
        bw_scene_free(opened[i]);
    }
    CHECK(bw_scene_set_compact(scene, true) == BW_ERROR_NONE && bw_scene_commit(scene) == BW_ERROR_NONE);
    FAILS(bw_scene_save(scene, path) == BW_ERROR_UNSUPPORTED, BW_ERROR_UNSUPPORTED, "compact");
    FILE *file = fopen(path, "wb");
    CHECK(file != NULL && fputs("no scene", file) >= 0 && fclose(file) == 0);
    FAILS(bw_scene_open(path) == NULL, BW_ERROR_BAD_FILE, "no saved scene");
    CHECK(remove(path) == 0 && rmdir(folder) == 0);
    bw_scene_free(scene);
    bw_scene_free(fresh);
}

static void strides_and_counts(BwScene *scene) {
    BwRay rays[2] = {{{0, 0, 0}, 0, {0, 0, 1}, INFINITY}, {{0, 0, 0}, 0, {0, 0, 1}, INFINITY}};
    BwHit hits[2];
    const char *odd = (const char *)CORNERS + 1;
    const BwError bad = BW_ERROR_BAD_STRIDE, large = BW_ERROR_TOO_LARGE;
    FAILS(bw_attach_triangles(scene, CORNERS[0], 3, 8, TRIANGLE, 1, 0) == BW_INVALID_ID, bad, "positions: 8 bytes");
    FAILS(bw_attach_triangles(scene, CORNERS[0], 3, 13, TRIANGLE, 1, 0) == BW_INVALID_ID, bad, "multiple of 4");
    FAILS(bw_attach_triangles(scene, CORNERS[0], 3, 0, TRIANGLE, 1, 4) == BW_INVALID_ID, bad, "indices");
    FAILS(bw_intersect(scene, rays, 2, 28, hits, 0) == bad, bad, "rays");
    FAILS(bw_intersect(scene, rays, 2, 0, hits, 38) == bad, bad, "hits");
    FAILS(bw_intersect(scene, rays, SIZE_MAX / 2, 0, hits, 0) == large, large, "more than memory");
    FAILS(bw_intersect(scene, rays, 2, SIZE_MAX - 3, hits, 0) == large, large, "more than memory");
    FAILS(bw_attach_triangles(scene, CORNERS[0], 3, 0, TRIANGLE, (size_t)1 << 31, 0) == BW_INVALID_ID, large,
          "2147483648");
    FAILS(bw_attach_triangles(scene, (const float *)(const void *)odd, 2, 0, TRIANGLE, 1, 0) == BW_INVALID_ID,
          BW_ERROR_MISALIGNED, "multiple of 4");
    CHECK(bw_intersect(scene, NULL, 0, 0, NULL, 0) == BW_ERROR_NONE);
}

static void scenes(void) {
    const float still[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const uint32_t wrong[3] = {0, 1, 3};
    const BwRay ray = {{0, 0, 0}, 0, {0, 0, 1}, INFINITY};
    BwHit hit;
    BwStats stats;
    BwScene *scene = bw_scene_new();
    const BwError none = BW_ERROR_NOT_COMMITTED;
    FAILS(!bw_intersect1(scene, &ray, &hit), none, "bw_scene_commit");
    FAILS(!bw_occluded1(scene, &ray), none, "bw_scene_commit");
    FAILS(bw_scene_stats(scene, &stats) == none, none, "bw_scene_commit");
    FAILS(bw_attach_instance(scene, scene, still, 1) == BW_INVALID_ID, none, "bw_scene_commit");
    FAILS(bw_attach_triangles(scene, CORNERS[0], 3, 0, wrong, 1, 0) == BW_INVALID_ID, BW_ERROR_INDEX_OUT_OF_RANGE,
          "triangle 0: vertex 3 of 3");
    FAILS(bw_set_triangles(scene, 5, CORNERS[0], 3, 0, TRIANGLE, 1, 0) == BW_ERROR_NO_SUCH_ID, BW_ERROR_NO_SUCH_ID,
          "mesh 5");
    FAILS(bw_set_transform(scene, 2, still) == BW_ERROR_NO_SUCH_ID, BW_ERROR_NO_SUCH_ID, "instance 2");
    FAILS(bw_scene_set_quality(scene, 77) == BW_ERROR_INVALID_ARGUMENT, BW_ERROR_INVALID_ARGUMENT, "quality 77");
    FAILS(bw_scene_set_threads(scene, 1000000) == BW_ERROR_INVALID_ARGUMENT, BW_ERROR_INVALID_ARGUMENT, "1000000");
    CHECK(bw_scene_commit(scene) == BW_ERROR_NONE);
    CHECK(!bw_intersect1(scene, &ray, &hit));
    bw_scene_free(scene);

    BwScene *content = plate(), *world = bw_scene_new();
    float broken[12] = {1, 0, 0, NAN, 0, 1, 0, 0, 0, 0, 1, 0};
    FAILS(bw_attach_instance(world, content, broken, 1) == BW_INVALID_ID, BW_ERROR_NOT_FINITE, "matrix[3]");
    CHECK(bw_attach_instance(world, content, still, 1) == 0);
    FAILS(bw_attach_triangles(world, CORNERS[0], 3, 0, TRIANGLE, 1, 0) == BW_INVALID_ID, BW_ERROR_MIXED, "instances");
    bw_scene_free(content);
    CHECK(bw_scene_commit(world) == BW_ERROR_NONE);
    CHECK(bw_intersect1(world, &ray, &hit) && hit.inst == 0 && hit.t == 5);
    float distance;
    FAILS(bw_signed_distances(world, ray.origin, 1, 0, &distance) == BW_ERROR_UNSUPPORTED, BW_ERROR_UNSUPPORTED,
          "distances");
    bw_scene_free(world);
}

static void not_numbers(void) {
    float corners[6][3] = {{-4, -4, 5}, {4, -4, 5}, {0, 4, 5}, {-4, -4, 3}, {4, NAN, 3}, {0, 4, 3}};
    const uint32_t both[][3] = {{0, 1, 2}, {3, 4, 5}};
    BwScene *scene = bw_scene_new();
    BwStats stats;
    BwHit hit;
    CHECK(bw_attach_triangles(scene, corners[0], 6, 0, both[0], 2, 0) == 0);
    CHECK(bw_scene_commit(scene) == BW_ERROR_NONE);
    CHECK(bw_scene_stats(scene, &stats) == BW_ERROR_NONE && stats.triangles == 2 && stats.skipped == 1);
    BwRay ray = {{0, 0, 0}, 0, {0, 0, 1}, INFINITY};
    CHECK(bw_ray_is_valid(&ray) && bw_intersect1(scene, &ray, &hit) && hit.prim == 0);
    ray.dir[1] = NAN;
    CHECK(!bw_ray_is_valid(&ray) && !bw_intersect1(scene, &ray, &hit) && !bw_occluded1(scene, &ray));
    bw_scene_free(scene);
}

/* A thread has its own error, and none at first. */
static void *other_thread(void *scene) {
    CHECK(bw_last_error() == BW_ERROR_NONE && bw_last_error_message()[0] == '\0');
    FAILS(bw_scene_set_quality(scene, 9) == BW_ERROR_INVALID_ARGUMENT, BW_ERROR_INVALID_ARGUMENT, "quality 9");
    return NULL;
}

static void threads(BwScene *scene) {
    pthread_t thread;
    FAILS(bw_scene_commit(NULL) == BW_ERROR_NULL_POINTER, BW_ERROR_NULL_POINTER, "scene");
    CHECK(pthread_create(&thread, NULL, other_thread, scene) == 0);
    pthread_join(thread, NULL);
    CHECK(strcmp(bw_last_error_message(), "scene is NULL") == 0);
}

enum { SOME = 5000, CORNER_COUNT = 300 };

/* A mesh and rays so small that a processor that takes denormals for zero sees nothing of them, and some of usual size. */
static float corners[CORNER_COUNT][3], points[SOME][3];
static uint32_t indices[CORNER_COUNT];
static BwRay rays[SOME];

static float any(int power) {
    static uint32_t state = 1;
    state = state * 1664525u + 1013904223u;
    return ldexpf((float)(int)((state >> 8) % 2001) - 1000.0f, power);
}

static void make_small_and_usual(void) {
    for (uint32_t i = 0; i < CORNER_COUNT; i++) {
        indices[i] = i;
        for (int k = 0; k < 3; k++) {
            corners[i][k] = any(i / 3 % 2 ? -10 : -140);
        }
    }
    for (int i = 0; i < SOME; i++) {
        int power = i % 3 ? -10 : -140;
        for (int k = 0; k < 3; k++) {
            points[i][k] = any(power);
            rays[i].origin[k] = i % 2 ? any(power) : 0.0f;
            rays[i].dir[k] = any(-10);
        }
        rays[i].t_min = ldexpf(1, -140);
        rays[i].t_max = INFINITY;
    }
}

/* Every bit that the library answers. */
typedef struct Answers {
    BwHit hits[SOME];
    BwNearest nearest[SOME];
    float distances[SOME];
} Answers;

static void ask_all(Answers *answers) {
    BwScene *scene = bw_scene_new();
    CHECK(bw_attach_triangles(scene, corners[0], CORNER_COUNT, 0, indices, CORNER_COUNT / 3, 0) == 0);
    CHECK(bw_scene_commit(scene) == BW_ERROR_NONE);
    for (int i = 0; i < SOME / 2; i++) {
        bw_intersect1(scene, &rays[i], &answers->hits[i]);
    }
    CHECK(bw_intersect(scene, rays + SOME / 2, SOME / 2, 0, answers->hits + SOME / 2, 0) == BW_ERROR_NONE);
    CHECK(bw_closest_points(scene, points[0], SOME, 0, answers->nearest, 0) == BW_ERROR_NONE);
    CHECK(bw_signed_distances(scene, points[0], SOME, 0, answers->distances) == BW_ERROR_NONE);
    bw_scene_free(scene);
}

/* Embree's advice, and -ffast-math's doing: denormals are zero. And worse: rounding up. Neither matters, neither changes. */
static void floating_point_modes(void) {
#if defined(__SSE2__)
    static Answers usual, other;
    ask_all(&usual);
    const unsigned before = _mm_getcsr(), modes[] = {0x8040u, 0x4000u, 0xE040u};
    for (int i = 0; i < 3; i++) {
        _mm_setcsr(before | modes[i]);
        ask_all(&other);
        const unsigned after = _mm_getcsr();
        _mm_setcsr(before);
        CHECK((after & ~0x3Fu) == ((before | modes[i]) & ~0x3Fu));
        CHECK(memcmp(&usual, &other, sizeof usual) == 0);
    }
    int hits = 0, small = 0;
    for (int i = 0; i < SOME; i++) {
        hits += usual.hits[i].geom != BW_INVALID_ID;
        small += usual.hits[i].geom != BW_INVALID_ID && usual.hits[i].prim % 2 == 0;
    }
    CHECK(hits > SOME / 10 && hits < SOME && small > SOME / 100);
#endif
}

/* The header promises that 128 KB of stack do; instances in instances take most. */
static void *ask_with_little_stack(void *scene) {
    static BwHit found[SOME];
    CHECK(bw_intersect(scene, rays, SOME, 0, found, 0) == BW_ERROR_NONE);
    CHECK(bw_intersect1(scene, &rays[0], &found[0]) == (found[0].geom != BW_INVALID_ID));
    CHECK(bw_all_hits1(scene, &rays[0], found, SOME, &(size_t){0}) == BW_ERROR_NONE);
    return NULL;
}

static void little_stack(void) {
    BwScene *inner = plate();
    for (int level = 0; level < 8; level++) {
        const float still[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
        BwScene *outer = bw_scene_new();
        CHECK(bw_scene_set_threads(outer, 1) == BW_ERROR_NONE);
        CHECK(bw_attach_instance(outer, inner, still, 1) == 0);
        CHECK(bw_attach_instance(outer, inner, still, 1) == 1);
        CHECK(bw_scene_commit(outer) == BW_ERROR_NONE);
        bw_scene_free(inner);
        inner = outer;
    }
    pthread_attr_t little;
    pthread_t thread;
    CHECK(pthread_attr_init(&little) == 0 && pthread_attr_setstacksize(&little, 128 * 1024) == 0);
    CHECK(pthread_create(&thread, &little, ask_with_little_stack, inner) == 0);
    pthread_join(thread, NULL);
    pthread_attr_destroy(&little);
    bw_scene_free(inner);
}

/* After a fork there are no threads but one: the library notices, and makes its own anew. */
static void fork_and_ask(BwScene *scene) {
    enum { COUNT = 100000 };
    static BwRay rays[COUNT];
    static BwHit hits[COUNT];
    for (int i = 0; i < COUNT; i++) {
        BwRay ray = {{0, 0, 0}, 0, {0, 0, 1}, INFINITY};
        rays[i] = ray;
    }
    CHECK(bw_scene_set_threads(scene, 2) == BW_ERROR_NONE);
    CHECK(bw_intersect(scene, rays, COUNT, 0, hits, 0) == BW_ERROR_NONE);
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        alarm(20);
        memset(hits, 0, sizeof hits);
        int ok = bw_intersect(scene, rays, COUNT, 0, hits, 0) == BW_ERROR_NONE && hits[COUNT - 1].t == 5;
        _exit(ok ? 0 : 1);
    }
    int status = -1;
    CHECK(child > 0 && waitpid(child, &status, 0) == child && status == 0);
}

int main(void) {
    BwScene *scene = plate();
    null_pointers(scene);
    strides_and_counts(scene);
    scenes();
    not_numbers();
    threads(scene);
    make_small_and_usual();
    floating_point_modes();
    little_stack();
    fork_and_ask(scene);
    files();
    bw_scene_free(scene);
    printf("%d failed of %d checks\n", failed, tried);
    return failed ? 1 : 0;
}
