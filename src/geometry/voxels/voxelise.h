#pragma once
// From meshes to voxels: the cells that a surface touches, and those that it encloses.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "spinel/scene.h"
#include "spinel/voxels.h"

namespace spinel {

// A lattice of cubic cells in some space.
struct VoxelFrame {
    ivec3 size = {1, 1, 1};
    glm::dvec3 origin = {0, 0, 0};  // the lower corner of cell (0, 0, 0)
    double cell = 1;                // its edge

    glm::dvec3 to_cells(glm::dvec3 p) const { return (p - origin) / cell; }
    glm::dvec3 centre(ivec3 c) const { return origin + (glm::dvec3(c) + 0.5) * cell; }
    mat4x3 transform() const;  // from the cells' space
};

// `resolution` cells along the longest edge of the box, and as many as needed along the others.
Result<VoxelFrame> fit_voxel_frame(glm::dvec3 lower, glm::dvec3 upper, int resolution);

// Slabs of so many layers along z are worked on independently.
constexpr int voxel_slab_layers = 8;
inline std::size_t voxel_slab_count(ivec3 size) {
    return std::size_t((size.z + voxel_slab_layers - 1) / voxel_slab_layers);
}

// visit(slab, cell, triangles) for every cell that triangles touch (triangle_cells.h), with all of them in rising
// order. Slabs are visited in parallel, the cells of one by one thread, in one order. Positions are in the cells'
// space.
using VisitSurfaceCell = std::function<void(std::size_t slab, ivec3 cell, std::span<const std::uint32_t> triangles)>;
void visit_surface_cells(ivec3 size, std::span<const glm::dvec3> positions, std::span<const uvec3> triangles,
                         const VisitSurfaceCell& visit);

// Which cells' centres a mesh encloses, by winding numbers along lines through the centres. Vertices are snapped to
// 1/4096 of a cell across the lines, so that whether a line passes an edge on the left or on the right is decided
// exactly, and the same for both triangles at the edge: a closed mesh has no line that leaks.
//
// A line along which the winding number does not return to zero has passed a hole, or triangles turned the wrong way.
// If it has an even number of crossings, they are taken to alternate between in and out; otherwise it says nothing. A
// mesh without such lines along x is closed and decided by these alone; for any other the lines along x, y and z vote.
class MeshInside {
  public:
    static constexpr int max_edge = 1 << 16;  // of `size`: keeps the snapped coordinates' products within 64 bits

    MeshInside(ivec3 size, std::span<const glm::dvec3> positions, std::span<const uvec3> triangles);

    bool closed() const { return lines_.size() == 1; }
    bool at(ivec3 cell) const;
    // For all of lower ≤ cell < upper, if that is easily told.
    std::optional<bool> box(ivec3 lower, ivec3 upper) const;

  private:
    struct Span {
        std::int32_t begin, end;
    };
    struct Lines {
        int axis;
        std::vector<std::size_t> first;  // into `spans`, of each line; and the end
        std::vector<Span> spans;         // cells inside, in rising order
        std::vector<std::uint8_t> mute;  // lines that say nothing
        std::size_t line(ivec3 size, ivec3 cell) const;
    };
    Lines cast(int axis, std::span<const glm::dvec3> positions, std::span<const uvec3> triangles, bool& closed) const;
    static bool inside(const Lines& lines, std::size_t line, int cell);

    ivec3 size_;
    std::vector<Lines> lines_;  // along x, or along x, y and z
};

struct VoxelisedMesh {
    VoxelTreePointer tree;         // palette index: the triangle's material slot + 1
    mat4x3 transform = mat4x3(1);  // from the cells' space to the mesh's
};

// Every cell that a triangle touches. Where triangles of several slots meet, the last one counts.
Result<VoxelisedMesh> voxelise_surface(const MeshGeometry& mesh, int resolution, const VoxelTreeOptions& options = {});

}  // namespace spinel
