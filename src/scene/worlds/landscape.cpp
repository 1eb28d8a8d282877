// Coasts and mountains. Heights are fractal noise over warped coordinates (Ebert et al., "Texturing and Modeling"):
// a gentle sum for the land, ridges where it is high. What lies on top depends on height, slope and chance.

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel.h"
#include "kernels/noise.h"
#include "scene/worlds/worlds.h"

namespace spinel {
namespace {

enum Palette : std::uint16_t {
    GRASS = 1,
    MEADOW,
    DRY_GRASS,
    DIRT,
    SAND,
    SILT,
    SNOW,
    ROCK,
    ROCK_PALE,
    ROCK_RED,
    ROCK_DARK,
    WATER,
    TRUNK,
    LEAVES,
    LEAVES_LIGHT,
    LEAVES_AUTUMN,
    NEEDLES,
    NEEDLES_DARK,
};
const WorldMaterial palette[] = {
    {"grass", 0x6f9440},     {"meadow", 0x8aa84c},       {"dry grass", 0xa9a45c},    {"dirt", 0x7b5b3e},
    {"sand", 0xdcc796},      {"silt", 0x9d9470},         {"snow", 0xf3f6f8},         {"rock", 0x8b8178},
    {"pale rock", 0xb3a48d}, {"red rock", 0xa0765a},     {"dark rock", 0x655f5b},    {"water", 0x58b4c4, 0, true},
    {"trunk", 0x5a4230},     {"leaves", 0x4f7a34},       {"light leaves", 0x6d9440}, {"autumn leaves", 0xc08a35},
    {"needles", 0x35603f},   {"dark needles", 0x2a4d38},
};

constexpr int tile = 9;   // one tree at most in each
constexpr int crown = 4;  // cells from the trunk that a tree may reach

struct Tree {
    ivec3 foot = {0, 0, 0};
    int height = 0;  // 0: none
    int radius = 0;
    bool conifer = false;
    std::uint16_t leaves = 0;
};

float smooth_step(float a, float b, float x) {
    const float t = std::clamp((x - a) / (b - a), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

class Landscape {
  public:
    Landscape(ivec3 size, std::uint32_t seed)
        : size_(size),
          seed_(seed),
          sea_(std::max(1, int(0.28f * float(size.y)))),
          // No two seeds look at the same part of the noise.
          offset_(float(seed % 1024) * 37.0f, 0, float(seed / 1024 % 1024) * 53.0f) {
        heights_.resize(std::size_t(size.x) * std::size_t(size.z));
        parallel_for(std::size_t(size.z), 8, [&](std::size_t begin, std::size_t end) {
            for (int z = int(begin); z < int(end); ++z)
                for (int x = 0; x < size.x; ++x) heights_[column(x, z)] = float_height(x, z);
        });
        plant();
        tops_.assign(std::size_t(blocks(size.x)) * std::size_t(blocks(size.z)), std::int32_t(sea_));
        for (int z = 0; z < size.z; ++z)
            for (int x = 0; x < size.x; ++x) raise(x, z, ground(x, z));
        for (const Tree& tree : trees_)
            if (tree.height > 0)
                for (int z = tree.foot.z - crown; z <= tree.foot.z + crown; ++z)
                    for (int x = tree.foot.x - crown; x <= tree.foot.x + crown; ++x)
                        if (x >= 0 && z >= 0 && x < size.x && z < size.z)
                            raise(x, z, tree.foot.y + tree.height + crown);
    }

    std::uint16_t at(ivec3 c) const {
        const int h = ground(c.x, c.z);
        if (c.y <= h) return earth(c, h);
        if (c.y <= sea_) return WATER;
        const int tx = c.x / tile, tz = c.z / tile;
        for (int z = std::max(0, tz - 1); z <= std::min(tz + 1, tiles_z() - 1); ++z)
            for (int x = std::max(0, tx - 1); x <= std::min(tx + 1, tiles_x() - 1); ++x)
                if (const std::uint16_t p =
                        of_tree(trees_[std::size_t(x) + std::size_t(tiles_x()) * std::size_t(z)], c))
                    return p;
        return 0;
    }

    std::optional<std::uint16_t> box(ivec3 lower, ivec3 upper) const {
        for (int z = lower.z / block; z * block < upper.z; ++z)
            for (int x = lower.x / block; x * block < upper.x; ++x)
                if (lower.y <= tops_[std::size_t(x) + std::size_t(blocks(size_.x)) * std::size_t(z)])
                    return std::nullopt;
        return std::uint16_t(0);
    }

  private:
    static constexpr int block = 4;
    static int blocks(int n) { return (n + block - 1) / block; }
    int tiles_x() const { return (size_.x + tile - 1) / tile; }
    int tiles_z() const { return (size_.z + tile - 1) / tile; }
    std::size_t column(int x, int z) const { return std::size_t(x) + std::size_t(size_.x) * std::size_t(z); }
    void raise(int x, int z, int y) {
        std::int32_t& top = tops_[std::size_t(x / block) + std::size_t(blocks(size_.x)) * std::size_t(z / block)];
        top = std::max(top, std::int32_t(y));
    }

    float noise(vec3 p, kernels::uint octaves) const { return kernels::fbm_noise(p, octaves); }

    float float_height(int x, int z) const {
        vec3 p = vec3(float(x), 0, float(z)) / 190.0f + offset_;
        p += 0.28f * vec3(noise(1.7f * p + vec3(0, 5.2f, 0), 3), 0, noise(1.7f * p + vec3(0, 9.7f, 0), 3));
        const float land = noise(p + vec3(0, 1.3f, 0), 7);
        float ridge = 1 - 2.3f * std::abs(noise(1.6f * p + vec3(0, 7.1f, 0), 6));
        ridge = ridge > 0 ? ridge * ridge : 0;
        const float high = smooth_step(-0.02f, 0.34f, land);
        const float above = float(size_.y) - float(sea_) - 8;
        float h = 0.10f + 0.42f * land + 0.85f * high * ridge + 0.10f * high;
        if (h > 0.5f) h = 1 - 0.5f * std::exp(1 - 2 * h);  // summits press together instead of being cut off
        return std::clamp(float(sea_) + above * (h < 0 ? 0.6f * h : h), 1.0f, float(size_.y) - 4);
    }
    int ground(int x, int z) const { return int(heights_[column(x, z)]); }
    // How much the ground rises over one cell.
    float slope(int x, int z) const {
        const auto h = [&](int i, int j) {
            return heights_[column(std::clamp(i, 0, size_.x - 1), std::clamp(j, 0, size_.z - 1))];
        };
        return 0.25f * std::hypot(h(x + 2, z) - h(x - 2, z), h(x, z + 2) - h(x, z - 2));
    }

    std::uint16_t strata(ivec3 c) const {
        // Beds a few cells thick that dip and bend.
        const float bed = float(c.y) + 0.05f * float(c.x) + 7 * noise(vec3(c) / 70.0f + offset_, 3);
        static constexpr std::uint16_t beds[] = {ROCK,      ROCK,      ROCK_PALE, ROCK,     ROCK_RED, ROCK_RED,
                                                 ROCK_PALE, ROCK_DARK, ROCK,      ROCK_RED, ROCK};
        const int i = int(std::floor(bed / 3.5f));
        return beds[std::size_t(((i % 11) + 11) % 11)];
    }

    std::uint16_t earth(ivec3 c, int h) const {
        const int depth = h - c.y;
        if (depth > 4) return strata(c);
        const float steep = slope(c.x, c.z);
        const float speckle = float(world_hash(c.x, c.y, c.z, seed_ + 17) & 0xffff) / 65535.0f;
        if (h <= sea_ + 1) return h < sea_ - 5 ? SILT : SAND;
        if (h == sea_ + 2 && speckle < 0.6f && steep < 0.6f) return SAND;
        const float patch = noise(vec3(float(c.x), 0, float(c.z)) / 34.0f + offset_ + vec3(0, 3.3f, 0), 3);
        const float snow_line = float(size_.y) * 0.66f + 10 * patch;
        if (float(h) > snow_line && steep < 1.5f) return depth < 3 ? std::uint16_t(SNOW) : strata(c);
        if (steep > 0.95f + 0.3f * patch) return strata(c);
        if (depth > 0) return DIRT;
        if (float(h) > snow_line - 22) return speckle < 0.35f ? strata(c) : std::uint16_t(DRY_GRASS);
        const float mixed = patch + 0.25f * (speckle - 0.5f);
        return mixed > 0.16f ? MEADOW : mixed < -0.22f ? DRY_GRASS : GRASS;
    }

    void plant() {
        for (int z = 0; z < tiles_z(); ++z)
            for (int x = 0; x < tiles_x(); ++x) {
                Tree tree;
                const std::uint32_t h = world_hash(x, 1, z, seed_ + 555);
                tree.foot = {std::min(size_.x - 1, x * tile + int(h >> 4) % tile), 0,
                             std::min(size_.z - 1, z * tile + int(h >> 12 & 0xff) % tile)};
                tree.foot.y = ground(tree.foot.x, tree.foot.z) + 1;
                const float wood =
                    noise(vec3(float(tree.foot.x), 0, float(tree.foot.z)) / 80.0f + offset_ + vec3(0, 11.9f, 0), 3);
                const float chance = smooth_step(-0.15f, 0.2f, wood);
                const bool grows = tree.foot.y > sea_ + 4 && float(tree.foot.y) < 0.6f * float(size_.y) &&
                                   slope(tree.foot.x, tree.foot.z) < 0.8f;
                if (grows && float(h >> 20 & 0xff) < 235 * chance + 6) {
                    tree.conifer = float(tree.foot.y) + 30 * wood > 0.46f * float(size_.y);
                    tree.height = (tree.conifer ? 9 : 6) + int(h >> 8 & 3) + int(h >> 28 & 1);
                    tree.radius = tree.conifer ? 3 : 3 + int(h >> 29 & 1);
                    const int kind = int(h >> 16 & 15);
                    tree.leaves = tree.conifer ? (kind < 9 ? NEEDLES : NEEDLES_DARK)
                                  : kind == 0  ? LEAVES_AUTUMN
                                  : kind < 7   ? LEAVES_LIGHT
                                               : LEAVES;
                }
                trees_.push_back(tree);
            }
    }

    std::uint16_t of_tree(const Tree& tree, ivec3 c) const {
        if (tree.height == 0) return 0;
        const ivec3 d = c - tree.foot;
        if (d.y < 0) return 0;
        if (d.x == 0 && d.z == 0 && d.y < tree.height) return TRUNK;
        const std::uint32_t chance = world_hash(c.x, c.y, c.z, seed_ + 999) % 100;
        const int across = d.x * d.x + d.z * d.z;
        if (tree.conifer) {
            if (d.y < 2 || d.y > tree.height + 1) return 0;
            // A cone of tiers.
            const float radius =
                float(tree.radius) * float(tree.height + 2 - d.y) / float(tree.height) + ((d.y & 1) ? 0.1f : 0.8f);
            return float(across) <= radius * radius && chance < 92 ? tree.leaves : 0;
        }
        const int up = d.y - tree.height;
        const int r = tree.radius;
        return across + up * up * 5 / 4 <= r * r + 1 && chance < 88 ? tree.leaves : 0;
    }

    ivec3 size_;
    std::uint32_t seed_;
    int sea_;
    vec3 offset_;
    std::vector<float> heights_;
    std::vector<std::int32_t> tops_;  // of blocks of columns: water and trees with it
    std::vector<Tree> trees_;
};

}  // namespace

Result<Scene> make_landscape(ivec3 size, std::uint32_t seed) {
    if (size.y < 16) return Error{"a landscape needs a height of at least 16"};
    const Landscape landscape(size, seed);
    Result<VoxelTreePointer> tree =
        build_voxel_tree(size, {[&](ivec3 c) { return landscape.at(c); },
                                [&](ivec3 lower, ivec3 upper) { return landscape.box(lower, upper); }});
    if (!tree) return tree.error();
    return world_scene("landscape", *tree, palette);
}

}  // namespace spinel
