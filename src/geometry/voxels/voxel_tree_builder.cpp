// The builders of spinel/voxels.h. Functions and slabs are cut into cubes of 64³ cells, each built by itself, in
// parallel, and then put together; points are sorted into the order of the tree first.

#include <algorithm>
#include <cassert>
#include <string>
#include <utility>

#include "core/parallel.h"
#include "geometry/voxels/voxel_tree_parts.h"

namespace spinel {
namespace {

constexpr int chunk_level = 2;                            // of nodes that are built on their own: 64³ cells
constexpr std::size_t max_chunks = std::size_t(1) << 21;  // what is left to look at after asking for boxes

ivec3 corner_of(ivec3 lower, int child, int level) {
    return lower + (ivec3(child & 3, child >> 2 & 3, child >> 4) << (2 * level));
}

bool is_outside(ivec3 lower, ivec3 size) { return lower.x >= size.x || lower.y >= size.y || lower.z >= size.z; }

// Palette: ivec3 → std::uint16_t. Box: (ivec3 lower, ivec3 upper) → std::optional<std::uint16_t>.
template <class Palette, class Box>
struct FunctionBuilder {
    ivec3 size;
    const Palette& palette;
    const Box& box;

    struct Chunk {
        VoxelTreePart part;
        VoxelBranch root;
    };

    // What the function says of a whole node; nothing: it has to be looked into.
    std::optional<std::uint16_t> known(ivec3 lower, int level) const {
        const ivec3 edge(1 << (2 * level + 2));
        const ivec3 upper = glm::min(lower + edge, size);
        const std::optional<std::uint16_t> answer = box(lower, upper);
        // A node that the set's boundary cuts is not solid.
        return answer && *answer != 0 && upper != lower + edge ? std::nullopt : answer;
    }

    VoxelBranch leaf(VoxelTreePart& part, ivec3 lower) const {
        std::array<std::uint16_t, 64> palettes;
        std::uint64_t mask = 0;
        for (int i = 0; i < 64; ++i) {
            const ivec3 cell = corner_of(lower, i, 0);
            palettes[std::size_t(i)] = is_outside(cell, size) ? std::uint16_t(0) : palette(cell);
            mask |= std::uint64_t(palettes[std::size_t(i)] != 0) << i;
        }
        return part.leaf(mask, palettes);
    }

    VoxelBranch node(VoxelTreePart& part, ivec3 lower, int level) const {
        if (const std::optional<std::uint16_t> answer = known(lower, level))
            return *answer == 0 ? VoxelBranch{} : part.solid(*answer, level);
        if (level == 0) return leaf(part, lower);
        std::array<VoxelBranch, 64> children;
        for (int i = 0; i < 64; ++i) {
            const ivec3 corner = corner_of(lower, i, level);
            if (!is_outside(corner, size)) children[std::size_t(i)] = node(part, corner, level - 1);
        }
        return part.parent(children);
    }

    // Lists the chunks under a node that have to be looked into; false: too many.
    bool list(std::vector<ivec3>& corners, ivec3 lower, int level) const {
        if (known(lower, level)) return true;
        if (level <= chunk_level) {
            corners.push_back(lower);
            return corners.size() <= max_chunks;
        }
        for (int i = 0; i < 64; ++i) {
            const ivec3 corner = corner_of(lower, i, level);
            if (!is_outside(corner, size) && !list(corners, corner, level - 1)) return false;
        }
        return true;
    }

    // Puts the chunks together, which come in the order of list().
    VoxelBranch join(VoxelTreePart& part, std::vector<Chunk>::iterator& next, ivec3 lower, int level) const {
        if (const std::optional<std::uint16_t> answer = known(lower, level))
            return *answer == 0 ? VoxelBranch{} : part.solid(*answer, level);
        if (level <= chunk_level) {
            const VoxelBranch root = part.append(next->part, next->root);
            next->part = {};  // its memory is needed for the rest
            ++next;
            return root;
        }
        std::array<VoxelBranch, 64> children;
        for (int i = 0; i < 64; ++i) {
            const ivec3 corner = corner_of(lower, i, level);
            if (!is_outside(corner, size)) children[std::size_t(i)] = join(part, next, corner, level - 1);
        }
        return part.parent(children);
    }

    Result<VoxelTreePointer> build(const VoxelTreeOptions& options) const {
        const int level = VoxelTree::levels_for(size) - 1;
        std::vector<ivec3> corners;
        if (!list(corners, ivec3(0), level))
            return Error{"a voxel set of this size needs a function that answers for boxes: more than " +
                         std::to_string(max_chunks) + " cubes of 64³ cells would have to be looked into"};
        std::vector<Chunk> chunks(corners.size());
        parallel_for(chunks.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                chunks[i].root = node(chunks[i].part, corners[i], std::min(level, chunk_level));
        });
        VoxelTreePart part;
        auto next = chunks.begin();
        const VoxelBranch root = join(part, next, ivec3(0), level);
        chunks = {};
        return std::move(part).finish(size, root, options);
    }
};

template <class Palette, class Box>
Result<VoxelTreePointer> build_from(ivec3 size, const Palette& palette, const Box& box,
                                    const VoxelTreeOptions& options) {
    return FunctionBuilder<Palette, Box>{size, palette, box}.build(options);
}

std::optional<std::uint16_t> unknown_box(ivec3, ivec3) { return std::nullopt; }

template <class Cell>
Result<VoxelTreePointer> build_from_cells(ivec3 size, std::span<const Cell> cells, const VoxelTreeOptions& options) {
    if (Result<void> valid = validate_voxel_size(size); !valid) return valid.error();
    const std::size_t x = std::size_t(size.x), xy = x * std::size_t(size.y);
    if (cells.size() != xy * std::size_t(size.z))
        return Error{"voxel set of size " + std::to_string(size.x) + "×" + std::to_string(size.y) + "×" +
                     std::to_string(size.z) + " has " + std::to_string(cells.size()) + " cells instead of " +
                     std::to_string(xy * std::size_t(size.z))};
    const auto palette = [&](ivec3 cell) {
        return std::uint16_t(cells[std::size_t(cell.x) + x * std::size_t(cell.y) + xy * std::size_t(cell.z)]);
    };
    return build_from(size, palette, unknown_box, options);
}

// ------------------------------------------------------------------------------------------------------------ points
struct KeyedPoint {
    std::uint64_t key;  // the base-64 digits of the way from the root to the cell
    std::uint16_t palette;
};

// The base-4 digits of a coordinate, each moved to the lowest two bits of a base-64 digit.
std::uint64_t spread(int coordinate) {
    std::uint64_t v = std::uint64_t(coordinate);
    v = (v | v << 32) & 0x000f00000000ffffull;
    v = (v | v << 16) & 0x000f0000ff0000ffull;
    v = (v | v << 8) & 0x000f00f00f00f00full;
    return (v | v << 4) & 0x00c30c30c30c30c3ull;
}

// By the key's lowest `bits` bits; stable.
void radix_sort(std::vector<KeyedPoint>& points, int bits) {
    constexpr int digit_bits = 11;
    std::vector<KeyedPoint> sorted(points.size());
    for (int shift = 0; shift < bits; shift += digit_bits) {
        std::vector<std::size_t> first(std::size_t(1) << digit_bits, 0);
        const auto digit = [&](const KeyedPoint& p) { return std::size_t(p.key >> shift & ((1u << digit_bits) - 1)); };
        for (const KeyedPoint& p : points) ++first[digit(p)];
        std::size_t sum = 0;
        for (std::size_t& f : first) sum += std::exchange(f, sum);
        for (const KeyedPoint& p : points) sorted[first[digit(p)]++] = p;
        points.swap(sorted);
    }
}

// The node of points whose keys differ in the lowest level + 1 digits only.
VoxelBranch node_of_points(VoxelTreePart& part, std::span<const KeyedPoint> points, int level) {
    const auto digit = [level](const KeyedPoint& p) { return std::size_t(p.key >> (6 * level) & 63); };
    if (level == 0) {
        std::array<std::uint16_t, 64> palettes{};
        std::uint64_t mask = 0;
        for (const KeyedPoint& p : points) {
            const std::uint64_t bit = std::uint64_t(1) << digit(p);
            mask = p.palette != 0 ? mask | bit : mask & ~bit;
            palettes[digit(p)] = p.palette;
        }
        return part.leaf(mask, palettes);
    }
    std::array<VoxelBranch, 64> children;
    while (!points.empty()) {
        const std::size_t child = digit(points.front());
        const auto end =
            std::partition_point(points.begin(), points.end(), [&](const KeyedPoint& p) { return digit(p) <= child; });
        const auto count = std::size_t(end - points.begin());
        children[child] = node_of_points(part, points.first(count), level - 1);
        points = points.subspan(count);
    }
    return part.parent(children);
}

}  // namespace

Result<VoxelTreePointer> build_voxel_tree(ivec3 size, std::vector<VoxelPoint> points, const VoxelTreeOptions& options) {
    if (Result<void> valid = validate_voxel_size(size); !valid) return valid.error();
    std::vector<KeyedPoint> keyed;
    keyed.reserve(points.size());
    for (const VoxelPoint& p : points) {
        if (glm::any(glm::lessThan(p.cell, ivec3(0))) || is_outside(p.cell, size))
            return Error{"voxel (" + std::to_string(p.cell.x) + ", " + std::to_string(p.cell.y) + ", " +
                         std::to_string(p.cell.z) + ") lies outside of its set of size " + std::to_string(size.x) +
                         "×" + std::to_string(size.y) + "×" + std::to_string(size.z)};
        keyed.push_back({spread(p.cell.x) | spread(p.cell.y) << 2 | spread(p.cell.z) << 4, p.palette});
    }
    points = {};
    const int levels = VoxelTree::levels_for(size);
    radix_sort(keyed, 6 * levels);
    VoxelTreePart part;
    const VoxelBranch root = node_of_points(part, keyed, levels - 1);
    return std::move(part).finish(size, root, options);
}

Result<VoxelTreePointer> build_voxel_tree(ivec3 size, std::span<const std::uint8_t> cells,
                                          const VoxelTreeOptions& options) {
    return build_from_cells(size, cells, options);
}

Result<VoxelTreePointer> build_voxel_tree(ivec3 size, std::span<const std::uint16_t> cells,
                                          const VoxelTreeOptions& options) {
    return build_from_cells(size, cells, options);
}

Result<VoxelTreePointer> build_voxel_tree(ivec3 size, const VoxelFunction& function, const VoxelTreeOptions& options) {
    if (Result<void> valid = validate_voxel_size(size); !valid) return valid.error();
    assert(function.palette);
    if (function.box) return build_from(size, function.palette, function.box, options);
    return build_from(size, function.palette, unknown_box, options);
}

}  // namespace spinel
