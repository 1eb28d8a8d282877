#include "accel/wide_bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "accel/float4.h"
#include "core/parallel.h"

namespace spinel {
namespace {

constexpr std::uint32_t block_size = 4;

std::uint32_t blocks_for(std::uint32_t count) { return (count + block_size - 1) / block_size; }

class Writer {
  public:
    Writer(const Bvh& binary, std::span<const kernels::Triangle> triangles, const WidePlan& plan)
        : binary_(binary), triangles_(triangles), plan_(plan) {}

    WideBvh run() {
        place();
        parallel_for(plan_.nodes.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (i + 4 < end) prefetch_order(plan_.nodes[i + 4]);
                if (i + 2 < end) prefetch(plan_.nodes[i + 2]);
                write_node(i);
            }
        });
        return std::move(out_);
    }

  private:
    // Each node is followed by its leaves' blocks.
    void place() {
        auto& statistics = out_.statistics;
        units_.reserve(plan_.nodes.size());
        std::size_t next = 0;
        for (const WidePlanNode& node : plan_.nodes) {
            units_.push_back(std::uint32_t(next));
            next += kernels::WIDE_NODE_UNITS;
            for (std::uint32_t i = 0; i < node.count; ++i) {
                const std::uint32_t blocks = blocks_for(node.counts[i]);
                next += blocks * kernels::WIDE_BLOCK_UNITS;
                statistics.block_count += blocks;
            }
        }
        statistics.sah_cost = plan_.sah_cost;
        statistics.depth = plan_.depth;
        statistics.node_count = std::uint32_t(plan_.nodes.size());
        statistics.triangle_count = plan_.triangle_count;
        out_.units.resize(next);
    }

    void write_node(std::size_t index) {
        constexpr float inf = std::numeric_limits<float>::infinity();
        static constexpr kernels::BvhNode nothing = {glm::vec3(inf), 0, glm::vec3(-inf), 0};
        const WidePlanNode& node = plan_.nodes[index];
        kernels::WideUnit* const units = &out_.units[units_[index]];
        std::uint32_t block = units_[index] + kernels::WIDE_NODE_UNITS;
        std::array<const kernels::BvhNode*, wide_width> boxes;
        for (std::uint32_t i = 0; i < wide_width; ++i) {
            boxes[i] = i < node.count ? &binary_.nodes[node.children[i]] : &nothing;
            std::uint32_t reference = 0;
            if (i < node.count && node.counts[i] > 0) reference = blocks_for(node.counts[i]) << 28 | block;
            else if (i < node.count) reference = units_[node.nodes[i]];
            units[6].lanes[i] = std::bit_cast<float>(reference);
            if (i >= node.count) continue;
            for (std::uint32_t first = 0; first < node.counts[i];
                 first += block_size, block += kernels::WIDE_BLOCK_UNITS)
                write_block(out_.units[block].lanes, node.firsts[i] + first,
                            std::min(block_size, node.counts[i] - first));
        }
        for (std::size_t half = 0; half < wide_width; half += 4) {
            const auto write = [&](int unit, const float* a, const float* b, const float* c, const float* d) {
                const auto columns = transposed(a, b, c, d);
                for (int axis = 0; axis < 3; ++axis)
                    columns[std::size_t(axis)].store(units[unit + 2 * axis].lanes + half);
            };
            const auto* const box = &boxes[half];
            write(0, &box[0]->lower.x, &box[1]->lower.x, &box[2]->lower.x, &box[3]->lower.x);
            write(1, &box[0]->upper.x, &box[1]->upper.x, &box[2]->upper.x, &box[3]->upper.x);
        }
    }

    // The columns of four rows of four.
    static std::array<Float4, 4> transposed(const float* a, const float* b, const float* c, const float* d) {
        std::array<Float4, 4> rows = {Float4::load_anywhere(a), Float4::load_anywhere(b), Float4::load_anywhere(c),
                                      Float4::load_anywhere(d)};
        transpose(rows[0], rows[1], rows[2], rows[3]);
        return rows;
    }

    void write_block(float* rows, std::uint32_t first, std::uint32_t count) {
        std::array<std::uint32_t, block_size> indices;
        std::array<const float*, block_size> t;
        for (std::uint32_t lane = 0; lane < block_size; ++lane) {
            indices[lane] = binary_.order[first + std::min(lane, count - 1)];
            t[lane] = &triangles_[indices[lane]].a.x;
        }
        for (std::size_t row = 0; row < 8; row += 4) {
            const auto columns = transposed(t[0] + row, t[1] + row, t[2] + row, t[3] + row);
            for (std::size_t i = 0; i < 4; ++i) columns[i].store(rows + (row + i) * block_size);
        }
        for (std::uint32_t lane = 0; lane < block_size; ++lane) {
            rows[8 * block_size + lane] = t[lane][8];
            rows[9 * block_size + lane] = std::bit_cast<float>(indices[lane]);
        }
    }

    // Asks memory for what write_node() reads: nodes and triangles are wanted in another order than they stand in.
    void prefetch_order(const WidePlanNode& node) const {
        for (std::uint32_t i = 0; i < node.count; ++i)
            if (node.counts[i] > 0) __builtin_prefetch(&binary_.order[node.firsts[i]]);
    }
    void prefetch(const WidePlanNode& node) const {
        for (std::uint32_t i = 0; i < node.count; ++i) {
            __builtin_prefetch(&binary_.nodes[node.children[i]]);
            for (std::uint32_t k = 0; k < node.counts[i]; ++k) {
                const char* t = reinterpret_cast<const char*>(&triangles_[binary_.order[node.firsts[i] + k]]);
                __builtin_prefetch(t);
                __builtin_prefetch(t + sizeof(kernels::Triangle) - 1);
            }
        }
    }

    const Bvh& binary_;
    std::span<const kernels::Triangle> triangles_;
    const WidePlan& plan_;
    std::vector<std::uint32_t> units_;  // where the plan's nodes begin
    WideBvh out_;
};

}  // namespace

WideBvh collapse_bvh(const Bvh& binary, std::span<const kernels::Triangle> triangles, const WideBvhOptions& options) {
    if (binary.nodes.empty()) return {};
    const WideLeaves leaves{block_size, [](std::uint32_t, std::uint32_t count) { return blocks_for(count); }};
    return Writer(binary, triangles, plan_wide_bvh(binary, options, leaves)).run();
}

}  // namespace spinel
