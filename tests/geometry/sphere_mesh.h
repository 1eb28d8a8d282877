#pragma once
// The unit sphere in triangles with smooth normals: a cube of steps × steps squares a face, pulled onto the
// sphere.

#include <cmath>
#include <glm/glm.hpp>

#include "spinel/scene.h"

namespace spinel::test {

// 12·steps² triangles; the volume is that of the sphere, so that what it refracts and holds is the same in
// the mean.
inline MeshGeometry sphere_mesh(int steps) {
    MeshGeometry mesh;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        const float side = face % 2 ? 1.0f : -1.0f;
        const std::uint32_t first = std::uint32_t(mesh.positions.size());
        for (int j = 0; j <= steps; ++j)
            for (int i = 0; i <= steps; ++i) {
                // Equal angles: triangles of nearly equal size.
                const auto tangent = [&](int k) { return std::tan((float(k) / float(steps) - 0.5f) * 1.5707963f); };
                vec3 p;
                p[axis] = side;
                p[(axis + 1) % 3] = tangent(i);
                p[(axis + 2) % 3] = tangent(j);
                mesh.normals.push_back(glm::normalize(p));
            }
        const std::uint32_t row = std::uint32_t(steps) + 1;
        for (std::uint32_t j = 0; j + 1 < row; ++j)
            for (std::uint32_t i = 0; i + 1 < row; ++i) {
                const std::uint32_t a = first + j * row + i, b = a + 1, c = a + row, d = c + 1;
                for (const uvec3 t : {uvec3(a, b, d), uvec3(a, d, c)})
                    mesh.triangles.push_back(side > 0 ? t : uvec3(t.x, t.z, t.y));
            }
        mesh.positions = mesh.normals;
    }
    double volume = 0;
    for (const uvec3 t : mesh.triangles)
        volume += double(glm::dot(mesh.positions[t.x], glm::cross(mesh.positions[t.y], mesh.positions[t.z]))) / 6;
    const float scale = float(std::cbrt(4.0 / 3.0 * 3.14159265358979 / volume));
    for (vec3& p : mesh.positions) p *= scale;
    return mesh;
}

}  // namespace spinel::test
