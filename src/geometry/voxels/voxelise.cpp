#include "geometry/voxels/voxelise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "core/parallel.h"
#include "geometry/mesh/mesh_builder.h"
#include "geometry/voxels/triangle_cells.h"

namespace spinel {
namespace {

using glm::dvec3;

// The triangles that may have to do with each slab of `layers` along an axis; `margin` in cells.
std::vector<std::vector<std::uint32_t>> bin_triangles(std::span<const dvec3> positions,
                                                      std::span<const uvec3> triangles, int axis, int extent,
                                                      int layers, double margin) {
    std::vector<std::vector<std::uint32_t>> bins(std::size_t((extent + layers - 1) / layers));
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const double a = positions[triangles[i].x][axis], b = positions[triangles[i].y][axis],
                     c = positions[triangles[i].z][axis];
        const double first = std::floor((std::min({a, b, c}) - margin) / layers);
        const double last = std::floor((std::max({a, b, c}) + margin) / layers);
        if (!(last >= 0) || !(first < double(bins.size()))) continue;
        const auto end = std::size_t(std::min(last, double(bins.size()) - 1)) + 1;
        for (auto bin = std::size_t(std::max(first, 0.0)); bin < end; ++bin) bins[bin].push_back(std::uint32_t(i));
    }
    return bins;
}

// Twice the signed area of (a, b, c), exact.
std::int64_t cross(glm::i64vec2 a, glm::i64vec2 b, glm::i64vec2 c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Of the two triangles at an edge, which run along it in opposite directions, exactly one owns the points on it.
bool owns(glm::i64vec2 from, glm::i64vec2 to) { return to.y > from.y || (to.y == from.y && to.x < from.x); }

}  // namespace

mat4x3 VoxelFrame::transform() const {
    const float edge = float(cell);
    return mat4x3(vec3(edge, 0, 0), vec3(0, edge, 0), vec3(0, 0, edge), vec3(origin));
}

Result<VoxelFrame> fit_voxel_frame(dvec3 lower, dvec3 upper, int resolution) {
    if (resolution < 1 || resolution > VoxelTree::max_edge)
        return Error{"cannot voxelise with " + std::to_string(resolution) +
                     " cells along the longest edge; allowed: 1 … " + std::to_string(VoxelTree::max_edge)};
    const dvec3 extent = upper - lower;
    const double longest = std::max({extent.x, extent.y, extent.z});
    if (!(longest > 0 && std::isfinite(longest))) return Error{"cannot voxelise what has no extent"};
    VoxelFrame frame;
    frame.origin = lower;
    frame.cell = longest / resolution;
    frame.size = glm::clamp(ivec3(glm::ceil(extent / frame.cell - 1e-6)), ivec3(1), ivec3(resolution));
    return frame;
}

void visit_surface_cells(ivec3 size, std::span<const dvec3> positions, std::span<const uvec3> triangles,
                         const VisitSurfaceCell& visit) {
    struct Touch {
        std::uint64_t cell;  // in the slab, linear
        std::uint32_t triangle;
    };
    const auto bins = bin_triangles(positions, triangles, 2, size.z, voxel_slab_layers, 1e-3);
    const auto across = std::uint64_t(size.x), layer = across * std::uint64_t(size.y);
    const auto work = [&](std::size_t slab) {
        const int z = int(slab) * voxel_slab_layers;
        const ivec3 begin(0, 0, z), end(size.x, size.y, std::min(size.z, z + voxel_slab_layers));
        std::vector<Touch> touches;
        for (const std::uint32_t i : bins[slab])
            TriangleCells(positions[triangles[i].x], positions[triangles[i].y], positions[triangles[i].z])
                .for_each(begin, end, [&](ivec3 c) {
                    touches.push_back(
                        {std::uint64_t(c.x) + across * std::uint64_t(c.y) + layer * std::uint64_t(c.z - z), i});
                });
        std::sort(touches.begin(), touches.end(), [](const Touch& a, const Touch& b) {
            return std::pair(a.cell, a.triangle) < std::pair(b.cell, b.triangle);
        });
        std::vector<std::uint32_t> here;
        for (std::size_t i = 0; i < touches.size();) {
            const std::uint64_t cell = touches[i].cell;
            here.clear();
            for (; i < touches.size() && touches[i].cell == cell; ++i) here.push_back(touches[i].triangle);
            visit(slab, {int(cell % across), int(cell % layer / across), z + int(cell / layer)}, here);
        }
    };
    parallel_for(bins.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t slab = begin; slab < end; ++slab) work(slab);
    });
}

// --------------------------------------------------------------------------------------------------------- MeshInside
std::size_t MeshInside::Lines::line(ivec3 size, ivec3 cell) const {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    return std::size_t(cell[u]) + std::size_t(size[u]) * std::size_t(cell[v]);
}

bool MeshInside::inside(const Lines& lines, std::size_t line, int cell) {
    for (std::size_t i = lines.first[line]; i < lines.first[line + 1]; ++i)
        if (cell < lines.spans[i].end) return cell >= lines.spans[i].begin;
    return false;
}

MeshInside::Lines MeshInside::cast(int axis, std::span<const dvec3> positions, std::span<const uvec3> triangles,
                                   bool& closed) const {
    constexpr int layers = 16;
    constexpr std::int64_t one = 4096, half = one / 2;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto bins = bin_triangles(positions, triangles, v, size_[v], layers, 1e-3);
    struct Crossing {
        std::uint32_t line;  // in the slab
        int sign;
        double at;
    };
    struct Slab {
        std::vector<std::uint32_t> counts;  // of spans, of each line
        std::vector<Span> spans;
        std::vector<std::uint8_t> mute;
        bool closed = true;
    };
    std::vector<Slab> slabs(bins.size());

    const auto find_crossings = [&](std::size_t slab) {
        std::vector<Crossing> crossings;
        const int v_begin = int(slab) * layers, v_end = std::min(size_[v], v_begin + layers);
        for (const std::uint32_t i : bins[slab]) {
            dvec3 p[3];
            glm::i64vec2 q[3];
            for (int k = 0; k < 3; ++k) {
                p[k] = positions[triangles[i][k]];
                q[k] = {std::llround(p[k][u] * double(one)), std::llround(p[k][v] * double(one))};
            }
            std::int64_t area = cross(q[0], q[1], q[2]);
            if (area == 0) continue;
            // Along the line from below, the winding number rises where the surface is entered from outside.
            const int sign = area > 0 ? -1 : 1;
            if (area < 0) {
                std::swap(p[1], p[2]);
                std::swap(q[1], q[2]);
                area = -area;
            }
            const auto first_centre = [&](std::int64_t low) { return (low - half + one - 1) >> 12; };
            const auto last_centre = [&](std::int64_t high) { return (high - half) >> 12; };
            const auto u_first = std::max<std::int64_t>(0, first_centre(std::min({q[0].x, q[1].x, q[2].x})));
            const auto u_last = std::min<std::int64_t>(size_[u] - 1, last_centre(std::max({q[0].x, q[1].x, q[2].x})));
            const auto v_first = std::max<std::int64_t>(v_begin, first_centre(std::min({q[0].y, q[1].y, q[2].y})));
            const auto v_last = std::min<std::int64_t>(v_end - 1, last_centre(std::max({q[0].y, q[1].y, q[2].y})));
            const bool owned[3] = {owns(q[1], q[2]), owns(q[2], q[0]), owns(q[0], q[1])};
            for (std::int64_t j = v_first; j <= v_last; ++j)
                for (std::int64_t k = u_first; k <= u_last; ++k) {
                    const glm::i64vec2 centre(k * one + half, j * one + half);
                    const std::int64_t e[3] = {cross(q[1], q[2], centre), cross(q[2], q[0], centre),
                                               cross(q[0], q[1], centre)};
                    bool in = true;
                    for (int n = 0; n < 3; ++n) in = in && (e[n] > 0 || (e[n] == 0 && owned[n]));
                    if (!in) continue;
                    const double at =
                        (double(e[0]) * p[0][axis] + double(e[1]) * p[1][axis] + double(e[2]) * p[2][axis]) /
                        double(area);
                    crossings.push_back({std::uint32_t(k + std::int64_t(size_[u]) * (j - v_begin)), sign, at});
                }
        }
        std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
            return std::pair(a.line, a.at) < std::pair(b.line, b.at);
        });
        return crossings;
    };

    const auto work = [&](std::size_t slab) {
        const std::vector<Crossing> crossings = find_crossings(slab);
        Slab& out = slabs[slab];
        const int rows = std::min(size_[v], (int(slab) + 1) * layers) - int(slab) * layers;
        const std::size_t line_count = std::size_t(rows) * std::size_t(size_[u]);
        out.counts.assign(line_count, 0);
        out.mute.assign(line_count, 0);
        for (std::size_t first = 0, end; first < crossings.size(); first = end) {
            const std::uint32_t line = crossings[first].line;
            int sum = 0;
            for (end = first; end < crossings.size() && crossings[end].line == line; ++end) sum += crossings[end].sign;
            const bool alternate = sum != 0;
            if (alternate) out.closed = false;
            if (alternate && (end - first) % 2 != 0) {
                out.mute[line] = 1;
                continue;
            }
            int winding = 0;
            std::int32_t begin = 0;
            for (std::size_t i = first; i < end; ++i) {
                const int before = winding;
                winding = alternate ? 1 - winding : winding + crossings[i].sign;
                if ((before != 0) == (winding != 0)) continue;
                // The first cell whose centre lies beyond the crossing.
                const double beyond = std::floor(crossings[i].at - 0.5) + 1;
                const auto cell = std::int32_t(std::clamp(beyond, 0.0, double(size_[axis])));
                if (winding != 0) {
                    begin = cell;
                } else if (cell > begin) {
                    out.spans.push_back({begin, cell});
                    ++out.counts[line];
                }
            }
        }
    };
    parallel_for(slabs.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t slab = begin; slab < end; ++slab) work(slab);
    });

    Lines lines;
    lines.axis = axis;
    lines.first.push_back(0);
    lines.first.reserve(std::size_t(size_[u]) * std::size_t(size_[v]) + 1);
    for (Slab& slab : slabs) {
        closed = closed && slab.closed;
        for (const std::uint32_t count : slab.counts) lines.first.push_back(lines.first.back() + count);
        lines.spans.insert(lines.spans.end(), slab.spans.begin(), slab.spans.end());
        lines.mute.insert(lines.mute.end(), slab.mute.begin(), slab.mute.end());
        slab = {};
    }
    return lines;
}

MeshInside::MeshInside(ivec3 size, std::span<const dvec3> positions, std::span<const uvec3> triangles) : size_(size) {
    bool closed = true;
    lines_.push_back(cast(0, positions, triangles, closed));
    if (closed) return;
    for (const int axis : {1, 2}) lines_.push_back(cast(axis, positions, triangles, closed));
}

bool MeshInside::at(ivec3 cell) const {
    int in = 0, out = 0;
    for (const Lines& lines : lines_) {
        const std::size_t line = lines.line(size_, cell);
        if (lines.mute[line]) continue;
        ++(inside(lines, line, cell[lines.axis]) ? in : out);
    }
    return in > out;
}

std::optional<bool> MeshInside::box(ivec3 lower, ivec3 upper) const {
    std::optional<bool> all;
    for (const Lines& lines : lines_) {
        const int axis = lines.axis, u = (axis + 1) % 3, v = (axis + 2) % 3;
        ivec3 cell = lower;
        for (cell[v] = lower[v]; cell[v] < upper[v]; ++cell[v])
            for (cell[u] = lower[u]; cell[u] < upper[u]; ++cell[u]) {
                const std::size_t line = lines.line(size_, cell);
                if (lines.mute[line]) return std::nullopt;
                bool in = false;
                for (std::size_t i = lines.first[line]; i < lines.first[line + 1]; ++i) {
                    const Span span = lines.spans[i];
                    if (span.end <= lower[axis]) continue;
                    if (span.begin >= upper[axis]) break;
                    if (span.begin > lower[axis] || span.end < upper[axis]) return std::nullopt;
                    in = true;
                    break;
                }
                if (all && *all != in) return std::nullopt;
                all = in;
            }
    }
    return all;
}

// -------------------------------------------------------------------------------------------------------------- shell
Result<VoxelisedMesh> voxelise_surface(const MeshGeometry& mesh, int resolution, const VoxelTreeOptions& options) {
    if (Result<void> valid = validate_mesh(mesh); !valid) return valid.error();
    dvec3 lower(std::numeric_limits<double>::infinity()), upper = -lower;
    for (const uvec3& triangle : mesh.triangles)
        for (int i = 0; i < 3; ++i) {
            lower = glm::min(lower, dvec3(mesh.positions[triangle[i]]));
            upper = glm::max(upper, dvec3(mesh.positions[triangle[i]]));
        }
    const Result<VoxelFrame> frame = fit_voxel_frame(lower, upper, resolution);
    if (!frame) return frame.error();
    std::vector<dvec3> positions;
    positions.reserve(mesh.positions.size());
    for (const vec3& p : mesh.positions) positions.push_back(frame->to_cells(dvec3(p)));
    std::vector<std::vector<VoxelPoint>> found(voxel_slab_count(frame->size));
    visit_surface_cells(frame->size, positions, mesh.triangles,
                        [&](std::size_t slab, ivec3 cell, std::span<const std::uint32_t> triangles) {
                            const std::uint32_t slot = mesh.slots.empty() ? 0 : mesh.slots[triangles.back()];
                            found[slab].push_back({cell, std::uint16_t(slot + 1)});
                        });
    std::vector<VoxelPoint> points;
    for (std::vector<VoxelPoint>& part : found) {
        points.insert(points.end(), part.begin(), part.end());
        part = {};
    }
    Result<VoxelTreePointer> tree = build_voxel_tree(frame->size, std::move(points), options);
    if (!tree) return tree.error();
    return VoxelisedMesh{*tree, frame->transform()};
}

}  // namespace spinel
