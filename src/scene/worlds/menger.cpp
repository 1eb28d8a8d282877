#include <algorithm>
#include <string>
#include <vector>

#include "image/palette.h"
#include "scene/worlds/worlds.h"

namespace spinel {
namespace {

// Of three base-3 digits at one level, two that are 1 are a tunnel through the cube of that level.
bool is_tunnel(ivec3 digit) { return (digit.x == 1) + (digit.y == 1) + (digit.z == 1) >= 2; }

}  // namespace

// Menger, "Allgemeine Räume und Cartesische Räume", 1926. Coloured by shells about the middle.
Result<Scene> make_menger(ivec3 size, std::uint32_t) {
    int edge = 1;
    while (edge < std::max({size.x, size.y, size.z})) edge *= 3;
    constexpr int shades = 24;
    const auto palette = [&](ivec3 cell) {
        ivec3 rest = cell;
        for (int e = 1; e < edge; e *= 3, rest /= 3)
            if (is_tunnel(rest % 3)) return std::uint16_t(0);
        const ivec3 from = glm::abs(2 * cell + 1 - edge);
        const int distance = from.x + from.y + from.z;  // at most 3·edge
        return std::uint16_t(1 + std::min(shades - 1, int(std::int64_t(distance) * shades / (3 * edge))));
    };
    const auto box = [&](ivec3 lower, ivec3 upper) -> std::optional<std::uint16_t> {
        for (int e = edge / 3; e >= 1; e /= 3) {
            if (lower / e != (upper - 1) / e) return std::nullopt;
            if (is_tunnel(lower / e % 3)) return std::uint16_t(0);
        }
        return std::nullopt;
    };
    Result<VoxelTreePointer> tree = build_voxel_tree(size, {palette, box});
    if (!tree) return tree.error();
    std::vector<WorldMaterial> materials;
    const vec3 inner = oklab_of_linear(linear_of_srgb8(0x2a6ff2)), outer = oklab_of_linear(linear_of_srgb8(0x8a6b12));
    for (int i = 0; i < shades; ++i) {
        const std::uint32_t c = srgb8(linear_of_oklab(glm::mix(inner, outer, float(i) / (shades - 1))));
        materials.push_back({"sponge", (c & 0xff) << 16 | (c & 0xff00) | c >> 16});
    }
    return world_scene("menger", *tree, materials);
}

}  // namespace spinel
