#include "geometry/volume/surface_reference.h"

#include <cmath>

namespace spinel {
namespace {

// Of a sample that is so far away along an axis: a tent, or the cubic B-spline (de Boor, "A Practical Guide to
// Splines", 1978).
double weight(Filter filter, double distance) {
    const double d = std::abs(distance);
    if (filter != Filter::cubic) return d < 1 ? 1 - d : 0;
    if (d >= 2) return 0;
    return d < 1 ? (4 - 6 * d * d + 3 * d * d * d) / 6 : (2 - d) * (2 - d) * (2 - d) / 6;
}

}  // namespace

double surface_reference(const VolumeGeometry& volume, const Grid& grid, glm::dvec3 p) {
    const ivec3 last = grid.samples->size() - 1;
    const glm::dvec3 q = glm::clamp(p - 0.5, glm::dvec3(0), glm::dvec3(last));
    const ivec3 base(glm::floor(q));
    double sum = 0;
    for (int z = -1; z <= 2; ++z)
        for (int y = -1; y <= 2; ++y)
            for (int x = -1; x <= 2; ++x) {
                const ivec3 i = base + ivec3(x, y, z);
                const double w =
                    weight(grid.filter, q.x - i.x) * weight(grid.filter, q.y - i.y) * weight(grid.filter, q.z - i.z);
                if (w != 0) sum += w * double(grid.samples->at(glm::clamp(i, ivec3(0), last)));
            }
    return (volume.solid_above ? -1 : 1) * (sum - double(volume.level));
}

}  // namespace spinel
