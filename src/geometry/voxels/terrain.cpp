#include "geometry/voxels/terrain.h"

#include <algorithm>
#include <vector>

#include "core/parallel.h"
#include "geometry/voxels/voxel_tree_parts.h"

namespace spinel {
namespace {

using u32 = std::uint32_t;

u32 hash(int x, int y, int z, int seed) {
    u32 h = u32(x) * 0x8da6b343u ^ u32(y) * 0xd8163841u ^ u32(z) * 0xcb1ab31fu ^ u32(seed) * 0x9e3779b9u;
    h ^= h >> 16;
    h *= 0x7feb352du;
    h ^= h >> 15;
    h *= 0x846ca68bu;
    return h ^ h >> 16;
}

// 3u² − 2u³ of a fraction of 65536.
std::int64_t smooth(std::int64_t u) { return ((u * u >> 16) * (3 * 65536 - 2 * u)) >> 16; }
std::int64_t weight(int x, int cell) { return smooth(std::int64_t(x % cell) * 65536 / cell); }
std::int64_t lerp(std::int64_t a, std::int64_t b, std::int64_t w) { return a + ((b - a) * w >> 16); }

std::int64_t noise2(int x, int z, int cell, int seed) {
    const auto at = [&](int i, int j) { return std::int64_t(hash(x / cell + i, 0, z / cell + j, seed) >> 16); };
    const std::int64_t wx = weight(x, cell), wz = weight(z, cell);
    return lerp(lerp(at(0, 0), at(1, 0), wx), lerp(at(0, 1), at(1, 1), wx), wz);
}

// Value noise in space, its lattice worked out once.
class Noise3 {
  public:
    Noise3(int width, int depth, int cell, int seed)
        : cell_(cell), nx_(width / cell + 2), ny_(terrain_height_limit / cell + 2) {
        for (int i = 0; i < cell; ++i) weights_.push_back(weight(i, cell));
        for (int z = 0; z < depth / cell + 2; ++z)
            for (int y = 0; y < ny_; ++y)
                for (int x = 0; x < nx_; ++x) lattice_.push_back(std::uint16_t(hash(x, y, z, seed) >> 16));
    }
    std::int64_t at(ivec3 p) const {
        const ivec3 c = p / cell_;
        const std::uint16_t* v = lattice_.data() + c.x + std::ptrdiff_t(nx_) * (c.y + std::ptrdiff_t(ny_) * c.z);
        const std::ptrdiff_t dy = nx_, dz = std::ptrdiff_t(nx_) * ny_;
        const ivec3 f = p - c * cell_;
        const std::int64_t wx = weights_[std::size_t(f.x)], wy = weights_[std::size_t(f.y)],
                           wz = weights_[std::size_t(f.z)];
        return lerp(lerp(lerp(v[0], v[1], wx), lerp(v[dy], v[dy + 1], wx), wy),
                    lerp(lerp(v[dz], v[dz + 1], wx), lerp(v[dy + dz], v[dy + dz + 1], wx), wy), wz);
    }

  private:
    int cell_, nx_, ny_;
    std::vector<std::int64_t> weights_;
    std::vector<std::uint16_t> lattice_;
};

constexpr int tile = 16, block = 4;

struct Tree {
    int trunk = 0;  // cells; 0: no tree
    int radius = 0;
    ivec3 foot = {0, 0, 0};
};

int blocks(int n, int edge) { return (n + edge - 1) / edge; }

}  // namespace

struct Terrain::Tables {
    int width, depth;
    Noise3 wide, narrow;
    std::vector<std::int16_t> heights;  // of columns
    std::vector<std::int16_t> tops;     // of blocks of columns, with trees
    std::vector<Tree> trees;            // of tiles

    Tables(int w, int d) : width(w), depth(d), wide(w, d, 48, 77), narrow(w, d, 32, 78) {}
    const Tree& tree(int x, int z) const {
        return trees[std::size_t(x / tile) + std::size_t(blocks(width, tile)) * std::size_t(z / tile)];
    }
    // Trees stand on columns that may lie outside of what is kept.
    static int height_of(int x, int z) {
        constexpr int amplitudes[7] = {96, 48, 26, 12, 6, 3, 2};
        int h = 16;
        for (int k = 0; k < 7; ++k) h += int(amplitudes[k] * noise2(x, z, 256 >> k, 1000 + k) >> 16);
        return h;
    }
};

Terrain::Terrain(int width, int depth) {
    auto t = std::make_unique<Tables>(width, depth);
    t->heights.resize(std::size_t(width) * std::size_t(depth));
    parallel_for(std::size_t(depth), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t z = begin; z < end; ++z)
            for (int x = 0; x < width; ++x)
                t->heights[std::size_t(x) + std::size_t(width) * z] = std::int16_t(Tables::height_of(x, int(z)));
    });
    for (int tz = 0; tz < blocks(depth, tile); ++tz)
        for (int tx = 0; tx < blocks(width, tile); ++tx) {
            const u32 h = hash(tx, 1, tz, 555);
            Tree tree;
            tree.radius = 3 + int(h >> 16 & 1);
            tree.foot = {tile * tx + 4 + int(h >> 4 & 7), 0, tile * tz + 4 + int(h >> 8 & 7)};
            tree.foot.y = Tables::height_of(tree.foot.x, tree.foot.z) + 1;
            const int trunk = 6 + int(h >> 12 & 7);
            if ((h & 7) < 3 && tree.foot.y + trunk + tree.radius + 1 < terrain_height_limit) tree.trunk = trunk;
            t->trees.push_back(tree);
        }
    for (int bz = 0; bz < blocks(depth, block); ++bz)
        for (int bx = 0; bx < blocks(width, block); ++bx) {
            const Tree& tree = t->tree(bx * block, bz * block);
            int top = tree.trunk > 0 ? tree.foot.y + tree.trunk + tree.radius : 0;
            for (int z = bz * block; z < std::min(depth, bz * block + block); ++z)
                for (int x = bx * block; x < std::min(width, bx * block + block); ++x)
                    top = std::max(top, int(t->heights[std::size_t(x) + std::size_t(width) * std::size_t(z)]));
            t->tops.push_back(std::int16_t(top));
        }
    tables_ = std::move(t);
}

Terrain::~Terrain() = default;

int Terrain::height(int x, int z) const {
    return tables_->heights[std::size_t(x) + std::size_t(tables_->width) * std::size_t(z)];
}

std::uint16_t Terrain::at(ivec3 c) const {
    const int ground = height(c.x, c.z);
    if (c.y <= ground) {
        if (c.y > 2 && std::abs(tables_->wide.at(c) - 32768) < 3600 && std::abs(tables_->narrow.at(c) - 32768) < 6000)
            return 0;
        return c.y == ground ? TERRAIN_GRASS : c.y > ground - 4 ? TERRAIN_DIRT : TERRAIN_STONE;
    }
    const Tree& tree = tables_->tree(c.x, c.z);
    if (tree.trunk == 0) return 0;
    if (c.x == tree.foot.x && c.z == tree.foot.z && c.y < tree.foot.y + tree.trunk) return TERRAIN_WOOD;
    const ivec3 d = c - tree.foot - ivec3(0, tree.trunk, 0);
    const bool crown = d.x * d.x + d.y * d.y + d.z * d.z <= tree.radius * tree.radius + 1;
    return crown && hash(c.x, c.y, c.z, 999) % 100 < 55 ? TERRAIN_LEAVES : 0;
}

std::optional<std::uint16_t> Terrain::box(ivec3 lower, ivec3 upper) const {
    if (lower.y >= terrain_height_limit) return std::uint16_t(0);
    const int across = blocks(tables_->width, block);
    for (int bz = lower.z / block; bz * block < upper.z; ++bz)
        for (int bx = lower.x / block; bx * block < upper.x; ++bx)
            if (lower.y <= tables_->tops[std::size_t(bx) + std::size_t(across) * std::size_t(bz)]) return std::nullopt;
    return std::uint16_t(0);
}

Result<VoxelTreePointer> build_terrain(ivec3 size, bool strata, const VoxelTreeOptions& options) {
    if (Result<void> valid = validate_voxel_size(size); !valid) return valid.error();
    constexpr std::int64_t max_columns = std::int64_t(1) << 30;
    if (std::int64_t(size.x) * size.z > max_columns)
        return Error{"terrain of " + std::to_string(size.x) + "×" + std::to_string(size.z) +
                     " columns is too large: at most " + std::to_string(max_columns)};
    const Terrain terrain(size.x, size.z);
    const auto box = [&](ivec3 lower, ivec3 upper) { return terrain.box(lower, upper); };
    if (strata) return build_voxel_tree(size, {[&](ivec3 cell) { return terrain.at(cell); }, box}, options);
    return build_voxel_tree(size, {[&](ivec3 c) { return std::uint16_t(terrain.at(c) != 0); }, box}, options);
}

}  // namespace spinel
