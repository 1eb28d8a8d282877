#include "geometry/voxels/greedy_mesh.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <tuple>
#include <unordered_map>

namespace spinel {
namespace {

constexpr std::size_t max_faces = std::size_t(1) << 28;

struct Face {
    std::int32_t side;   // 2·axis + 1 towards the upper end
    std::int32_t layer;  // of the cell, along the axis
    std::int32_t v, u;   // across
    std::int32_t palette;
    auto order() const { return std::tie(side, layer, v, u); }
};

class Vertices {
  public:
    explicit Vertices(std::vector<vec3>& positions) : positions_(positions) {}
    std::uint32_t at(ivec3 p) {
        const std::uint64_t key = std::uint64_t(p.x) | std::uint64_t(p.y) << 21 | std::uint64_t(p.z) << 42;
        const auto [found, is_new] = index_.emplace(key, std::uint32_t(positions_.size()));
        if (is_new) positions_.push_back(vec3(p));
        return found->second;
    }

  private:
    std::vector<vec3>& positions_;
    std::unordered_map<std::uint64_t, std::uint32_t> index_;
};

void add_rectangle(MeshGeometry& mesh, Vertices& vertices, const Face& face, int width, int height) {
    const int axis = face.side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const bool upper = face.side % 2 != 0;
    ivec3 corner;
    corner[axis] = face.layer + (upper ? 1 : 0);
    corner[u] = face.u;
    corner[v] = face.v;
    ivec3 along(0), up(0);
    along[u] = width;
    up[v] = height;
    const std::uint32_t a = vertices.at(corner), b = vertices.at(corner + along), c = vertices.at(corner + along + up),
                        d = vertices.at(corner + up);
    for (const uvec3 t : {uvec3(a, b, c), uvec3(a, c, d)}) {
        mesh.triangles.push_back(upper ? t : uvec3(t.x, t.z, t.y));
        mesh.slots.push_back(std::uint32_t(face.palette - 1));
    }
}

// The faces of one layer and side, sorted by v, then u.
void merge_layer(MeshGeometry& mesh, Vertices& vertices, std::span<const Face> faces, std::vector<std::uint8_t>& used) {
    used.assign(faces.size(), 0);
    std::vector<std::size_t> rows;  // where each row begins
    for (std::size_t i = 0; i < faces.size(); ++i)
        if (i == 0 || faces[i].v != faces[i - 1].v) rows.push_back(i);
    rows.push_back(faces.size());
    for (std::size_t row = 0; row + 1 < rows.size(); ++row)
        for (std::size_t i = rows[row]; i < rows[row + 1]; ++i) {
            if (used[i]) continue;
            int width = 1;
            const auto fits = [&](std::size_t first, std::size_t end, int count) {
                if (first + std::size_t(count) > end) return false;
                for (int k = 0; k < count; ++k) {
                    const Face& face = faces[first + std::size_t(k)];
                    if (used[first + std::size_t(k)] || face.u != faces[i].u + k || face.palette != faces[i].palette)
                        return false;
                }
                return true;
            };
            while (i + std::size_t(width) < rows[row + 1] && !used[i + std::size_t(width)] &&
                   faces[i + std::size_t(width)].u == faces[i].u + width &&
                   faces[i + std::size_t(width)].palette == faces[i].palette)
                ++width;
            std::fill_n(used.begin() + std::ptrdiff_t(i), width, std::uint8_t(1));
            int height = 1;
            for (std::size_t next = row + 1; next + 1 < rows.size() && faces[rows[next]].v == faces[i].v + height;
                 ++next, ++height) {
                const auto begin = faces.begin() + std::ptrdiff_t(rows[next]),
                           end = faces.begin() + std::ptrdiff_t(rows[next + 1]);
                const auto at =
                    std::size_t(std::lower_bound(begin, end, faces[i].u, [](const Face& f, int u) { return f.u < u; }) -
                                faces.begin());
                if (!fits(at, rows[next + 1], width)) break;
                std::fill_n(used.begin() + std::ptrdiff_t(at), width, std::uint8_t(1));
            }
            add_rectangle(mesh, vertices, faces[i], width, height);
        }
}

}  // namespace

Result<MeshGeometry> greedy_mesh(const VoxelTree& tree, const HidesFace& hides) {
    std::vector<Face> faces;
    const auto add_faces = [&](ivec3 cell, std::uint16_t palette, ivec3 lower, int edge) {
        for (int side = 0; side < 6; ++side) {
            const int axis = side / 2;
            ivec3 across = cell;
            across[axis] += side % 2 ? 1 : -1;
            if (across[axis] >= lower[axis] && across[axis] < lower[axis] + edge) continue;  // within the cube
            if (!hides(palette, tree.at(across)))
                faces.push_back({side, cell[axis], cell[(axis + 2) % 3], cell[(axis + 1) % 3], palette});
        }
    };
    tree.for_each_cube([&](ivec3 lower, int edge, std::uint16_t palette) {
        if (faces.size() > max_faces) return;
        const int last = edge - 1;
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y) {
                const bool rim = z == 0 || z == last || y == 0 || y == last;
                for (int x = 0; x < edge; x += rim ? 1 : std::max(last, 1))
                    add_faces(lower + ivec3(x, y, z), palette, lower, edge);
            }
    });
    if (faces.size() > max_faces)
        return Error{"voxels have more than the " + std::to_string(max_faces) + " visible faces that a mesh may have"};
    if (faces.empty()) return Error{"voxels have no visible face"};
    std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.order() < b.order(); });
    MeshGeometry mesh;
    Vertices vertices(mesh.positions);
    std::vector<std::uint8_t> used;
    for (std::size_t first = 0, end; first < faces.size(); first = end) {
        for (end = first;
             end < faces.size() && faces[end].side == faces[first].side && faces[end].layer == faces[first].layer;)
            ++end;
        merge_layer(mesh, vertices, {faces.data() + first, end - first}, used);
    }
    return mesh;
}

}  // namespace spinel
