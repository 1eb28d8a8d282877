#include "scene/worlds/worlds.h"

#include <numeric>
#include <string>

#include "geometry/voxels/terrain.h"
#include "geometry/voxels/voxel_tree_parts.h"
#include "image/palette.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel {

std::span<const World> worlds() {
    static const World table[] = {
        {"terrain",
         "hills with caves and trees, of integers alone: the same everywhere, for measurements",
         {1024, 256, 1024},
         false,
         make_terrain_world},
        {"landscape", "coasts and mountains with strata, snow, woods and water", {512, 160, 512}, true, make_landscape},
        {"city", "streets, parks and towers, some of whose windows are lit", {384, 192, 384}, true, make_city},
        {"menger",
         "Menger's sponge, cut to the size; whole if the edges are a power of 3",
         {243, 243, 243},
         false,
         make_menger},
    };
    return table;
}

const World* find_world(std::string_view name) {
    for (const World& world : worlds())
        if (world.name == name) return &world;
    return nullptr;
}

Result<Scene> make_world(const World& world, ivec3 size, std::uint32_t seed) {
    if (size == ivec3(0)) size = world.size;
    if (Result<void> valid = validate_voxel_size(size); !valid) return valid.error();
    constexpr std::int64_t most_columns = std::int64_t(1) << 28;  // makers keep some bytes for each
    if (std::int64_t(size.x) * size.z > most_columns)
        return Error{"a world of " + std::to_string(size.x) + "×" + std::to_string(size.z) +
                     " columns is too large: at most " + std::to_string(most_columns)};
    if (!world.seeded && seed != 0)
        return Error{"the world '" + std::string(world.name) + "' is one alone and has no seed"};
    return world.make(size, seed);
}

Scene world_scene(const char* name, VoxelTreePointer tree, std::span<const WorldMaterial> palette) {
    Scene scene;
    for (const WorldMaterial& row : palette) {
        Material m{row.name, default_material(row.water ? kernels::MATERIAL_DIELECTRIC : kernels::MATERIAL_DIFFUSE)};
        const vec3 color = linear_of_srgb8(row.color >> 16 | (row.color & 0xff00) | (row.color & 0xff) << 16);
        if (row.water) {
            // Its colour is what is left of white light after some 16 voxels.
            m.values.ior = 1.33f;
            m.values.absorption = -glm::log(glm::max(color, 1e-3f)) / 16.0f;
        } else {
            m.values.color = color;
        }
        m.values.emission = row.emission * color;
        scene.materials.push_back(std::move(m));
    }
    scene.geometries.push_back({name, VoxelGeometry{std::move(tree)}});
    Object object;
    object.name = name;
    object.geometry = 0;
    object.materials.resize(palette.size());
    std::iota(object.materials.begin(), object.materials.end(), 0);
    scene.objects.push_back(std::move(object));
    return scene;
}

Result<Scene> make_terrain_world(ivec3 size, std::uint32_t) {
    static const WorldMaterial palette[] = {
        // in the order of TerrainPalette
        {"grass", 0x7d9b4a}, {"dirt", 0x8a6544}, {"stone", 0x8d8a86}, {"wood", 0x5e432c}, {"leaves", 0x4c7a38},
    };
    Result<VoxelTreePointer> tree = build_terrain(size);
    if (!tree) return tree.error();
    return world_scene("terrain", *tree, palette);
}

}  // namespace spinel
