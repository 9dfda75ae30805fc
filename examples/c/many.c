/* A million rays at hills of 131,072 triangles: one by one from four threads of ours that share a scene, then all in one call on
 * the library's own threads. The answers are the same bits.
 *
 *     cc many.c -o many $(pkg-config --cflags --libs boxwood) -lpthread
 */
#include <boxwood.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SIDE = 256, ACROSS = 1000, RAYS = ACROSS * ACROSS, THREADS = 4 };

/* What one thread is to do. */
typedef struct Share {
    const BwScene *scene;
    const BwRay *rays;
    BwHit *hits;
    size_t count;
} Share;

static void *ask(void *argument) {
    const Share *share = argument;
    for (size_t i = 0; i < share->count; i++) {
        bw_intersect1(share->scene, &share->rays[i], &share->hits[i]);
    }
    return NULL;
}

static double seconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Whole numbers, so that every compiler makes the same hills. */
static float height(uint32_t x, uint32_t y) {
    uint32_t h = (x / 8 * 73856093u) ^ (y / 8 * 19349663u) ^ (x * y);
    return (float)((h >> 3) % 16);
}

static BwScene *hills(void) {
    float *positions = malloc(sizeof(float) * 3 * (SIDE + 1) * (SIDE + 1));
    uint32_t *indices = malloc(sizeof(uint32_t) * 6 * SIDE * SIDE);
    BwScene *scene = bw_scene_new();
    if (positions != NULL && indices != NULL && scene != NULL) {
        float *p = positions;
        uint32_t *i = indices;
        for (uint32_t y = 0; y <= SIDE; y++) {
            for (uint32_t x = 0; x <= SIDE; x++) {
                *p++ = (float)x, *p++ = (float)y, *p++ = height(x, y);
            }
        }
        for (uint32_t y = 0; y < SIDE; y++) {
            for (uint32_t x = 0; x < SIDE; x++) {
                uint32_t a = y * (SIDE + 1) + x, b = a + 1, c = a + SIDE + 1, d = c + 1;
                *i++ = a, *i++ = b, *i++ = c;
                *i++ = c, *i++ = b, *i++ = d;
            }
        }
        bw_attach_triangles(scene, positions, (SIDE + 1) * (SIDE + 1), 0, indices, 2 * SIDE * SIDE, 0);
    }
    /* What is attached is copied. */
    free(positions);
    free(indices);
    if (bw_scene_commit(scene) != BW_ERROR_NONE) {
        fprintf(stderr, "%s\n", bw_last_error_message());
        exit(1);
    }
    return scene;
}

int main(void) {
    BwScene *scene = hills();
    BwRay *rays = malloc(sizeof(BwRay) * RAYS);
    BwHit *one_by_one = malloc(sizeof(BwHit) * RAYS);
    BwHit *together = malloc(sizeof(BwHit) * RAYS);
    if (rays == NULL || one_by_one == NULL || together == NULL) {
        return 1;
    }
    /* A camera above a corner, that looks across. */
    for (int i = 0; i < RAYS; i++) {
        BwRay ray = {{-20, -30, 60}, 0, {(float)(i % ACROSS), (float)(ACROSS - i / ACROSS), -150}, INFINITY};
        rays[i] = ray;
    }

    double start = seconds();
    pthread_t threads[THREADS];
    Share shares[THREADS];
    for (int k = 0; k < THREADS; k++) {
        Share share = {scene, rays + k * (RAYS / THREADS), one_by_one + k * (RAYS / THREADS), RAYS / THREADS};
        shares[k] = share;
        if (pthread_create(&threads[k], NULL, ask, &shares[k]) != 0) {
            return 1;
        }
    }
    for (int k = 0; k < THREADS; k++) {
        pthread_join(threads[k], NULL);
    }
    double middle = seconds();
    if (bw_last_error() != BW_ERROR_NONE || bw_intersect(scene, rays, RAYS, 0, together, 0) != BW_ERROR_NONE) {
        fprintf(stderr, "%s\n", bw_last_error_message());
        return 1;
    }
    double end = seconds();

    int hits = 0;
    for (int i = 0; i < RAYS; i++) {
        hits += one_by_one[i].geom != BW_INVALID_ID;
    }
    int same = memcmp(one_by_one, together, sizeof(BwHit) * RAYS) == 0;
    printf("%d of %d rays hit, %s answers together\n", hits, RAYS, same ? "the same" : "OTHER");
    printf("%.1f million rays per second one by one on %d threads, %.1f in one call\n", RAYS * 1e-6 / (middle - start),
           THREADS, RAYS * 1e-6 / (end - middle));

    free(rays);
    free(one_by_one);
    free(together);
    bw_scene_free(scene);
    return same ? 0 : 1;
}
