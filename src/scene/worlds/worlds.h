#pragma once
// Worlds of voxels made by programs. One row of the table for each; to add one, write its function in a file of its own
// and add its row in worlds.cpp.

#include <cstdint>
#include <span>
#include <string_view>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel {

struct World {
    std::string_view name;
    std::string_view doc;
    ivec3 size;   // where none is asked for
    bool seeded;  // there is one for each seed; otherwise it is always the same
    Result<Scene> (*make)(ivec3 size, std::uint32_t seed);
};

std::span<const World> worlds();
const World* find_world(std::string_view name);  // null: there is none

// The same size and seed give the same voxels. Checks the size; (0, 0, 0) is the row's own.
Result<Scene> make_world(const World& world, ivec3 size, std::uint32_t seed);

// For the makers: the world's palette in the order of its indices, from 1, and the scene of one set of voxels.
struct WorldMaterial {
    const char* name;
    std::uint32_t color;  // 0xrrggbb, sRGB
    float emission = 0;   // radiance, in the colour
    bool water = false;
};
Scene world_scene(const char* name, VoxelTreePointer tree, std::span<const WorldMaterial> palette);

Result<Scene> make_terrain_world(ivec3 size, std::uint32_t seed);
Result<Scene> make_landscape(ivec3 size, std::uint32_t seed);
Result<Scene> make_city(ivec3 size, std::uint32_t seed);
Result<Scene> make_menger(ivec3 size, std::uint32_t seed);

// What is here or there by chance.
inline std::uint32_t world_hash(int x, int y, int z, std::uint32_t seed) {
    std::uint32_t h = std::uint32_t(x) * 0x8da6b343u ^ std::uint32_t(y) * 0xd8163841u ^ std::uint32_t(z) * 0xcb1ab31fu ^
                      seed * 0x9e3779b9u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return h ^ h >> 16;
}

}  // namespace spinel
