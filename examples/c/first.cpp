// As first.c, in C++: the scene frees itself, errors are exceptions.
//
//     c++ -std=c++17 first.cpp -o first $(pkg-config --cflags --libs boxwood)
#include <boxwood.h>

#include <array>
#include <iostream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

struct FreeScene {
    void operator()(BwScene *scene) const { bw_scene_free(scene); }
};
using Scene = std::unique_ptr<BwScene, FreeScene>;

static void check(bool ok) {
    if (!ok) throw std::runtime_error(bw_last_error_message());
}

int main() try {
    const std::vector<std::array<float, 3>> positions = {{0, 0, 5}, {4, 0, 5}, {0, 4, 5}, {4, 4, 5}};
    const std::vector<std::array<std::uint32_t, 3>> indices = {{0, 1, 2}, {2, 1, 3}};

    Scene scene(bw_scene_new());
    auto quad = bw_attach_triangles(scene.get(), positions[0].data(), positions.size(), 0, indices[0].data(),
                                    indices.size(), 0);
    check(quad != BW_INVALID_ID);
    check(bw_scene_commit(scene.get()) == BW_ERROR_NONE);

    const float far = std::numeric_limits<float>::infinity();
    const std::vector<BwRay> rays = {{{1, 2, 0}, 0, {0, 0, 2}, far}, {{9, 2, 0}, 0, {0, 0, 2}, far}};
    std::vector<BwHit> hits(rays.size());
    check(bw_intersect(scene.get(), rays.data(), rays.size(), 0, hits.data(), 0) == BW_ERROR_NONE);
    for (const BwHit &hit : hits) {
        if (hit.geom == BW_INVALID_ID) {
            std::cout << "nothing\n";
        } else {
            std::cout << "triangle " << hit.prim << " at t = " << hit.t << "\n";
        }
    }

    // A mistake, to see what becomes of it.
    const std::array<std::uint32_t, 3> wrong = {0, 1, 4};
    check(bw_attach_triangles(scene.get(), positions[0].data(), 4, 0, wrong.data(), 1, 0) != BW_INVALID_ID);
} catch (const std::exception &error) {
    std::cout << "error: " << error.what() << "\n";
}
