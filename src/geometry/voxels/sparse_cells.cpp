#include "geometry/voxels/sparse_cells.h"

#include <algorithm>
#include <cassert>
#include <span>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "geometry/voxels/voxel_tree_parts.h"

namespace spinel {
namespace {

constexpr int chunk_level = 2;  // of nodes that are built on their own, in parallel
constexpr int chunk_edge = 64;

// A chunk of the tree, and a cube of cells that reaches into it.
struct Overlap {
    std::uint64_t order;  // the base-64 digits of the way from the root to the chunk
    ivec3 chunk;          // its lower corner in the tree
    ivec3 cube;           // the cube's
    const std::uint16_t* cells;
};

struct Chunk {
    std::uint64_t order;
    std::span<const Overlap> overlaps;
    VoxelTreePart part;
    VoxelBranch root;
};

std::uint64_t order_of(ivec3 chunk, int level_count) {
    std::uint64_t order = 0;
    for (int level = level_count - 1; level > chunk_level; --level) {
        const ivec3 digit = (chunk >> (2 * level)) & 3;
        order = order << 6 | std::uint64_t(digit.x | digit.y << 2 | digit.z << 4);
    }
    return order;
}

// All cells of a chunk, x fastest, then y, then z.
class DenseChunk {
  public:
    DenseChunk() : cells_(std::size_t(chunk_edge) * chunk_edge * chunk_edge) {}

    void fill(std::span<const Overlap> overlaps) {
        std::fill(cells_.begin(), cells_.end(), std::uint16_t(0));
        touched_ = 0;
        constexpr int edge = SparseCells::cube_edge;
        for (const Overlap& o : overlaps) {
            const ivec3 place = o.cube - o.chunk;
            const ivec3 first = glm::max(place, ivec3(0)), last = glm::min(place + edge, ivec3(chunk_edge));
            touch(first / 16, (last - 1) / 16);
            for (int z = first.z; z < last.z; ++z)
                for (int y = first.y; y < last.y; ++y) {
                    const std::uint16_t* row = o.cells + ((z - place.z) * edge + y - place.y) * edge;
                    std::copy(row + (first.x - place.x), row + (last.x - place.x),
                              cells_.begin() + index({first.x, y, z}));
                }
        }
    }

    VoxelBranch node(VoxelTreePart& part, ivec3 lower, int level) const {
        if (level == 0) return leaf(part, lower);
        std::array<VoxelBranch, 64> children;
        for (int i = 0; i < 64; ++i)
            if (level < chunk_level || touched_ >> i & 1)
                children[std::size_t(i)] = node(part, lower + (digits(i) << (2 * level)), level - 1);
        return part.parent(children);
    }

  private:
    void touch(ivec3 first, ivec3 last) {
        for (int z = first.z; z <= last.z; ++z)
            for (int y = first.y; y <= last.y; ++y)
                for (int x = first.x; x <= last.x; ++x) touched_ |= std::uint64_t(1) << (x + 4 * y + 16 * z);
    }
    static std::ptrdiff_t index(ivec3 cell) { return (cell.z * chunk_edge + cell.y) * chunk_edge + cell.x; }
    static ivec3 digits(int child) { return {child & 3, child >> 2 & 3, child >> 4}; }

    VoxelBranch leaf(VoxelTreePart& part, ivec3 lower) const {
        std::array<std::uint16_t, 64> palettes;
        std::uint64_t mask = 0;
        for (int i = 0; i < 64; ++i) {
            const std::uint16_t palette = cells_[std::size_t(index(lower + digits(i)))];
            palettes[std::size_t(i)] = palette;
            mask |= std::uint64_t(palette != 0) << i;
        }
        return part.leaf(mask, palettes);
    }

    std::vector<std::uint16_t> cells_;
    std::uint64_t touched_ = 0;  // the 16³ cells below a chunk that may hold anything
};

// The node over chunks whose orders differ in the lowest level − chunk_level digits only.
VoxelBranch join(VoxelTreePart& part, std::span<Chunk> chunks, int level) {
    if (level <= chunk_level) {
        const VoxelBranch root = part.append(chunks.front().part, chunks.front().root);
        chunks.front().part = {};  // its memory is needed for the rest
        return root;
    }
    std::array<VoxelBranch, 64> children;
    const auto digit = [&](const Chunk& c) { return c.order >> (6 * (level - chunk_level - 1)) & 63; };
    while (!chunks.empty()) {
        const std::uint64_t child = digit(chunks.front());
        const auto end =
            std::partition_point(chunks.begin(), chunks.end(), [&](const Chunk& c) { return digit(c) <= child; });
        const auto count = std::size_t(end - chunks.begin());
        children[std::size_t(child)] = join(part, chunks.first(count), level - 1);
        chunks = chunks.subspan(count);
    }
    return part.parent(children);
}

}  // namespace

std::size_t SparseCells::KeyHash::operator()(const std::array<int, 3>& key) const {
    std::uint64_t h = 0;
    for (const int k : key) h = (h ^ std::uint32_t(k)) * 0x9e3779b97f4a7c15ull;  // 2⁶⁴ / golden ratio
    return std::size_t(h ^ h >> 32);
}

bool SparseCells::set(ivec3 cell, std::uint16_t palette) {
    assert(palette != 0);
    const ivec3 corner = cell >> 4;  // rounds down, below 0 as well
    const std::array<int, 3> at = {corner.x, corner.y, corner.z};
    if (!last_cube_ || at != last_) {
        auto found = cubes_.find(at);
        if (found == cubes_.end()) {
            if (cubes_.size() >= max_cubes_) return false;
            if (cubes_.empty()) lower_ = upper_ = cell;
            found = cubes_.emplace(at, std::make_unique<Cube>(Cube{})).first;
        }
        last_ = at;
        last_cube_ = found->second.get();
    }
    const glm::uvec3 within(cell & 15);
    (*last_cube_)[within.x | within.y << 4 | within.z << 8] = palette;
    lower_ = glm::min(lower_, cell);
    upper_ = glm::max(upper_, cell);
    return true;
}

Result<VoxelTreePointer> SparseCells::tree(ivec3 lower, ivec3 size) const {
    if (Result<void> valid = validate_voxel_size(size); !valid) return valid.error();
    const int level_count = VoxelTree::levels_for(size);
    std::vector<Overlap> overlaps;
    for (const auto& [at, cube] : cubes_) {
        const ivec3 place = corner_of(at) - lower;
        const ivec3 first = glm::max(place, ivec3(0)) / chunk_edge;
        const ivec3 last = glm::min(place + cube_edge, size) - 1;
        for (int z = first.z; z <= last.z / chunk_edge; ++z)
            for (int y = first.y; y <= last.y / chunk_edge; ++y)
                for (int x = first.x; x <= last.x / chunk_edge; ++x) {
                    const ivec3 chunk = ivec3(x, y, z) * chunk_edge;
                    overlaps.push_back({order_of(chunk, level_count), chunk, place, cube->data()});
                }
    }
    std::sort(overlaps.begin(), overlaps.end(), [](const Overlap& a, const Overlap& b) { return a.order < b.order; });
    std::vector<Chunk> chunks;
    for (std::size_t begin = 0, end; begin < overlaps.size(); begin = end) {
        for (end = begin; end < overlaps.size() && overlaps[end].order == overlaps[begin].order;) ++end;
        chunks.push_back({overlaps[begin].order, std::span(overlaps).subspan(begin, end - begin), {}, {}});
    }
    parallel_for(chunks.size(), 4, [&](std::size_t begin, std::size_t end) {
        DenseChunk dense;
        for (std::size_t i = begin; i < end; ++i) {
            dense.fill(chunks[i].overlaps);
            chunks[i].root = dense.node(chunks[i].part, ivec3(0), std::min(level_count - 1, chunk_level));
        }
    });
    VoxelTreePart part;
    const VoxelBranch root = chunks.empty() ? VoxelBranch{} : join(part, chunks, level_count - 1);
    chunks = {};
    return std::move(part).finish(size, root, {});
}

}  // namespace spinel
