#pragma once
// Cells that become known in no order, before the size of their set is: kept in dense cubes of 16³ cells where anything
// is, two bytes a cell, and built into a tree from these.

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <utility>

#include "core/result.h"
#include "spinel/voxels.h"

namespace spinel {

class SparseCells {
  public:
    static constexpr int cube_edge = 16;

    // So many cubes at most; as a rule half a GiB.
    explicit SparseCells(std::size_t max_cubes = std::size_t(1) << 16) : max_cubes_(max_cubes) {}

    // Of the same cell the last one counts. False: that would be more cubes than allowed. `palette` is not 0.
    bool set(ivec3 cell, std::uint16_t palette);

    bool empty() const { return cubes_.empty(); }
    // The lowest and the highest coordinates there are; not of an empty set.
    std::pair<ivec3, ivec3> bounds() const { return {lower_, upper_}; }

    // function(ivec3 cell, std::uint16_t palette) for each, in no order.
    template <class Function>
    void for_each(const Function& function) const {
        for (const auto& [at, cube] : cubes_)
            for (std::size_t i = 0; i < cube->size(); ++i)
                if ((*cube)[i] != 0) function(corner_of(at) + cell_of(i), (*cube)[i]);
    }

    // What lies in lower ≤ cell < lower + size, which is all of it, as a set of that size.
    Result<VoxelTreePointer> tree(ivec3 lower, ivec3 size) const;

  private:
    using Cube = std::array<std::uint16_t, cube_edge * cube_edge * cube_edge>;  // x fastest, then y, then z
    struct KeyHash {
        std::size_t operator()(const std::array<int, 3>& key) const;
    };
    static ivec3 corner_of(const std::array<int, 3>& at) { return ivec3(at[0], at[1], at[2]) * cube_edge; }
    static ivec3 cell_of(std::size_t i) { return {int(i & 15), int(i >> 4 & 15), int(i >> 8)}; }

    std::size_t max_cubes_;
    std::unordered_map<std::array<int, 3>, std::unique_ptr<Cube>, KeyHash> cubes_;
    std::array<int, 3> last_ = {};  // where the last cell was set; the next is mostly near
    Cube* last_cube_ = nullptr;
    ivec3 lower_ = {}, upper_ = {};
};

}  // namespace spinel
