/* What does this ray hit? The smallest program there is.
 *
 *     cargo xtask c-install --prefix /usr/local
 *     cc first.c -o first $(pkg-config --cflags --libs boxwood)
 */
#include <boxwood.h>
#include <math.h>
#include <stdio.h>

int main(void) {
    const float positions[][3] = {{0, 0, 5}, {4, 0, 5}, {0, 4, 5}, {4, 4, 5}};
    const uint32_t indices[][3] = {{0, 1, 2}, {2, 1, 3}};

    BwScene *scene = bw_scene_new();
    uint32_t quad = bw_attach_triangles(scene, positions[0], 4, 0, indices[0], 2, 0);
    if (quad == BW_INVALID_ID || bw_scene_commit(scene) != BW_ERROR_NONE) {
        fprintf(stderr, "%s\n", bw_last_error_message());
        bw_scene_free(scene);
        return 1;
    }

    /* t counts in units of dir, which need not have length 1. */
    BwRay ray = {{1, 2, 0}, 0, {0, 0, 2}, INFINITY};
    BwHit hit;
    if (bw_intersect1(scene, &ray, &hit)) {
        printf("triangle %u of geometry %u at t = %g, u = %g, v = %g, normal (%g, %g, %g)\n", (unsigned)hit.prim,
               (unsigned)hit.geom, hit.t, hit.u, hit.v, hit.ng[0], hit.ng[1], hit.ng[2]);
    } else {
        printf("nothing\n");
    }

    bw_scene_free(scene);
    return 0;
}
