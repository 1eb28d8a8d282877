#include "accel/compact_bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/parallel.h"
#include "kernels/mesh_compact.h"

namespace spinel {
namespace {

using kernels::uint;

constexpr uint words_per_unit = sizeof(kernels::WideUnit) / sizeof(uint);
constexpr uint block_triangles = kernels::COMPACT_BLOCK_TRIANGLES, block_vertices = kernels::COMPACT_BLOCK_VERTICES;

uint rounded_up(uint words, uint to) { return (words + to - 1) / to * to; }

// 0 and −0 are two vertices.
bool same_bits(const glm::vec3& a, const glm::vec3& b) {
    using Bits = std::array<std::uint32_t, 3>;
    return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}

struct Block {
    uint triangle_count = 0, vertex_count = 0;
    std::array<uint, block_triangles> indices;  // of triangles
    std::array<uint, block_triangles> corners;  // three places of three bits
    std::array<glm::vec3, block_vertices> vertices;

    // False: it has no room for it.
    bool add(const kernels::Triangle& triangle, uint index) {
        if (triangle_count == block_triangles) return false;
        uint count = vertex_count, places = 0;
        for (uint corner = 0; corner < 3; ++corner) {
            const glm::vec3& vertex = (&triangle.a)[corner];
            uint place = 0;
            while (place < count && !same_bits(vertices[place], vertex)) ++place;
            if (place == block_vertices) return false;
            if (place == count) vertices[count++] = vertex;
            places |= place << (3 * corner);
        }
        vertex_count = count;
        indices[triangle_count] = index;
        corners[triangle_count++] = places;
        return true;
    }
    uint words() const { return kernels::compact_block_words(triangle_count, vertex_count); }
};

class Writer {
  public:
    Writer(const Bvh& binary, std::span<const kernels::Triangle> triangles, const WideBvhOptions& options)
        : binary_(binary), triangles_(triangles) {
        plan_ = plan_wide_bvh(binary.nodes, options, {block_triangles, [this](uint first, uint count) {
                                                          uint blocks = 0;
                                                          pack(first, count, [&](const Block&) { ++blocks; });
                                                          return blocks;
                                                      }});
    }

    WideBvh run() {
        place();
        parallel_for(plan_.nodes.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) write_node(plan_.nodes[i], places_[i]);
        });
        return std::move(out_);
    }

  private:
    // Where a node of the plan and its leaves are to stand, in words from the root …
    struct Place {
        uint node;
        std::array<uint, wide_width> leaves;  // … after it; before they are placed, how many words they take …
        std::array<std::uint8_t, wide_width> blocks;  // … in how many blocks
    };

    // The blocks of some of the binary tree's primitives, each of which is filled before the next is begun.
    template <class Visit>
    void pack(uint first, uint count, const Visit& visit) const {
        Block block;
        for (uint i = first; i < first + count; ++i) {
            const uint index = binary_.order[i];
            if (block.add(triangles_[index], index)) continue;
            visit(block);
            block.triangle_count = block.vertex_count = 0;
            block.add(triangles_[index], index);
        }
        visit(block);
    }

    void place() {
        const auto& nodes = plan_.nodes;
        places_.resize(nodes.size());
        parallel_for(nodes.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                for (uint k = 0; k < nodes[i].count; ++k) {
                    uint words = 0;
                    std::uint8_t blocks = 0;
                    if (nodes[i].counts[k] > 0)
                        pack(nodes[i].firsts[k], nodes[i].counts[k], [&](const Block& block) {
                            words += block.words();
                            ++blocks;
                        });
                    places_[i].leaves[k] = words;
                    places_[i].blocks[k] = blocks;
                }
        });
        auto& statistics = out_.statistics;
        std::size_t next = 0;
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            next =
                (next + words_per_unit - 1) / words_per_unit * words_per_unit;  // a node touches two lines of a cache
            places_[i].node = uint(next / kernels::COMPACT_STEP);
            next += kernels::COMPACT_NODE_WORDS;
            for (uint k = 0; k < nodes[i].count; ++k) {
                const uint words = places_[i].leaves[k];
                places_[i].leaves[k] = uint(next / kernels::COMPACT_STEP);
                next += rounded_up(words, kernels::COMPACT_STEP);
                statistics.block_count += places_[i].blocks[k];
            }
        }
        statistics.sah_cost = plan_.sah_cost;
        statistics.depth = plan_.depth;
        statistics.node_count = uint(nodes.size());
        statistics.triangle_count = plan_.triangle_count;
        // Walks read whole vectors, the last of which may begin with the last word.
        out_.units.resize(next / words_per_unit + 2);
        std::memset(out_.units.data(), 0, out_.units.size() * sizeof out_.units[0]);
    }

    float* words_at(uint step) { return out_.units.data()->lanes + std::size_t(step) * kernels::COMPACT_STEP; }
    static void put(float& word, uint bits) { word = std::bit_cast<float>(bits); }

    void write_node(const WidePlanNode& node, const Place& place) {
        float* const words = words_at(place.node);
        std::array<std::uint8_t, 4> packed{0, 0, 0, std::uint8_t((1u << node.count) - 1)};
        for (std::uint32_t axis = 0; axis < 3; ++axis) packed[axis] = write_planes(node, int(axis), words);
        put(words[3], std::bit_cast<uint>(packed));
        for (uint i = 0; i < node.count; ++i) {
            if (node.counts[i] == 0) {
                put(words[16 + i], places_[node.nodes[i]].node);
                continue;
            }
            put(words[16 + i], uint(place.blocks[i]) << 28 | place.leaves[i]);
            float* to = words_at(place.leaves[i]);
            pack(node.firsts[i], node.counts[i], [&](const Block& block) {
                write_block(block, to);
                to += block.words();
            });
        }
    }

    // Returns the exponent of the steps.
    std::uint8_t write_planes(const WidePlanNode& node, int axis, float* words) const {
        const auto box = [&](uint i) -> const kernels::BvhNode& { return binary_.nodes[node.children[i]]; };
        float lower = box(0).lower[axis], upper = box(0).upper[axis];
        for (uint i = 1; i < node.count; ++i) {
            lower = std::min(lower, box(i).lower[axis]);
            upper = std::max(upper, box(i).upper[axis]);
        }
        const auto step_of = [](int exponent) { return std::bit_cast<float>(uint(exponent) << 23); };
        const auto plane = [&](int steps, float step) { return float(steps) * step + lower; };
        // The least power of two by which 255 steps reach the end.
        int exponent = std::clamp(std::ilogb((double(upper) - double(lower)) / 255) + 127, 1, 254);
        while (exponent < 254 && !(plane(255, step_of(exponent)) >= upper)) ++exponent;
        const float step = step_of(exponent);
        std::array<std::uint8_t, 2 * wide_width> planes{};
        for (uint i = 0; i < node.count; ++i) {
            const float from = box(i).lower[axis], to = box(i).upper[axis];
            const auto steps_to = [&](float x) {
                return int(std::clamp((double(x) - double(lower)) / double(step), 0.0, 255.0));
            };
            int first = steps_to(from), last = steps_to(to);
            while (first > 0 && !(plane(first, step) <= from)) --first;
            while (last < 255 && !(plane(last, step) >= to)) ++last;
            planes[i] = std::uint8_t(first);
            planes[wide_width + i] = std::uint8_t(last);
        }
        words[axis] = lower;
        std::memcpy(words + 4 + 4 * axis, planes.data(), planes.size());
        return std::uint8_t(exponent);
    }

    static void write_block(const Block& block, float* words) {
        const uint triangles = block.triangle_count, vertices = block.vertex_count;
        put(words[0], triangles | vertices << 8);
        for (uint i = 0; i < triangles; i += 2)
            put(words[1 + i / 2], block.corners[i] | (i + 1 < triangles ? block.corners[i + 1] << 16 : 0u));
        float* const rows = words + kernels::compact_rows(triangles);
        for (uint i = 0; i < vertices; ++i)
            for (uint axis = 0; axis < 3; ++axis) rows[axis * vertices + i] = block.vertices[i][int(axis)];
        for (uint i = 0; i < triangles; ++i)
            put(words[kernels::compact_indices(triangles, vertices) + i], block.indices[i]);
    }

    const Bvh& binary_;
    std::span<const kernels::Triangle> triangles_;
    WidePlan plan_;
    std::vector<Place> places_;
    WideBvh out_;
};

}  // namespace

WideBvh compact_bvh(const Bvh& binary, std::span<const kernels::Triangle> triangles, const WideBvhOptions& options) {
    if (binary.nodes.empty()) return {};
    return Writer(binary, triangles, options).run();
}

}  // namespace spinel
