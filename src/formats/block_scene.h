#pragma once
// Gathers the blocks of a world or structure and makes a scene of them: cubes become one voxel geometry, blocks of
// other shapes one mesh of boxes. Lengths are blocks (metres), x east, y up, z south.

#include <string>
#include <unordered_map>
#include <vector>

#include "core/result.h"
#include "formats/blocks.h"
#include "geometry/voxels/sparse_cells.h"
#include "spinel/scene.h"

namespace spinel {

class BlockScene {
  public:
    // The number of a block state (blocks.h); the same text gives the same number.
    std::uint32_t state(const std::string& text);
    // Of a numeric id and its data; what was never a block counts as unknown.
    std::uint32_t legacy_state(int id, int data);

    bool is_nothing(std::uint32_t state) const { return nothing_[state]; }

    // A block of `state` at `cell`; what is nothing is left out. False: there are more blocks than allowed.
    bool place(ivec3 cell, std::uint32_t state);

    // What has been placed. The names of unknown blocks are in the scene's notes.
    Result<Scene> build(const std::string& name) &&;

  private:
    struct Odd {  // not a cube
        ivec3 cell;
        std::uint32_t state;
    };
    std::uint16_t slot_of(const kernels::Material& material, const std::string& name);
    void add_boxes(MeshGeometry& mesh, ivec3 lower, ivec3 upper);

    std::unordered_map<std::string, std::uint32_t> numbers_;
    std::vector<Block> blocks_;
    std::vector<bool> nothing_;
    std::vector<std::uint16_t> slots_;  // of each block, its material + 1
    std::uint16_t water_slot_ = 0;
    std::vector<std::uint32_t> legacy_;  // by id · 16 + data
    std::vector<Material> materials_;
    SparseCells cubes_;  // their material + 1
    std::vector<Odd> odd_;
    std::vector<bool> seen_;  // states that have been placed
};

}  // namespace spinel
