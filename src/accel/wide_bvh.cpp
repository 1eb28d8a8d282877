#include "accel/wide_bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "accel/float4.h"
#include "core/parallel.h"

namespace spinel {
namespace {

constexpr std::uint32_t block_size = wide_block;

std::uint32_t blocks_for(std::uint32_t count) { return (count + block_size - 1) / block_size; }

// The columns of four rows of four.
std::array<Float4, 4> transposed(const float* a, const float* b, const float* c, const float* d) {
    std::array<Float4, 4> rows = {Float4::load_anywhere(a), Float4::load_anywhere(b), Float4::load_anywhere(c),
                                  Float4::load_anywhere(d)};
    transpose(rows[0], rows[1], rows[2], rows[3]);
    return rows;
}

// Asks memory for what write_wide_node() reads of them.
void prefetch_children(std::span<const kernels::BvhNode> binary, const WidePlanNode& node) {
    for (std::uint32_t i = 0; i < node.count; ++i) __builtin_prefetch(&binary[node.children[i]]);
}

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
        const WidePlanNode& node = plan_.nodes[index];
        kernels::WideUnit* const units = &out_.units[units_[index]];
        std::uint32_t block = units_[index] + kernels::WIDE_NODE_UNITS;
        std::array<WideChild, wide_width> children;
        for (std::uint32_t i = 0; i < node.count; ++i) {
            const std::uint32_t blocks = blocks_for(node.counts[i]);
            children[i] = {&binary_.nodes[node.children[i]], blocks > 0 ? blocks << 28 | block : units_[node.nodes[i]]};
            const auto leaf = std::span(binary_.order).subspan(node.firsts[i], node.counts[i]);
            for (std::size_t first = 0; first < leaf.size(); first += block_size, block += kernels::WIDE_BLOCK_UNITS)
                write_wide_block(triangles_,
                                 leaf.subspan(first, std::min<std::size_t>(block_size, leaf.size() - first)),
                                 out_.units[block].lanes);
        }
        write_wide_node(std::span(children).first(node.count), units);
    }

    // Asks memory for what write_node() reads: nodes and triangles are wanted in another order than they stand in.
    void prefetch_order(const WidePlanNode& node) const {
        for (std::uint32_t i = 0; i < node.count; ++i)
            if (node.counts[i] > 0) __builtin_prefetch(&binary_.order[node.firsts[i]]);
    }
    void prefetch(const WidePlanNode& node) const {
        prefetch_children(binary_.nodes, node);
        for (std::uint32_t i = 0; i < node.count; ++i) {
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

void write_wide_block(std::span<const kernels::Triangle> triangles, std::span<const std::uint32_t> indices,
                      float* rows) {
    std::array<std::uint32_t, block_size> index;
    std::array<const float*, block_size> t;
    for (std::size_t lane = 0; lane < block_size; ++lane) {
        index[lane] = indices[std::min(lane, indices.size() - 1)];
        t[lane] = &triangles[index[lane]].a.x;
    }
    for (std::size_t row = 0; row < 8; row += 4) {
        const auto columns = transposed(t[0] + row, t[1] + row, t[2] + row, t[3] + row);
        for (std::size_t i = 0; i < 4; ++i) columns[i].store(rows + (row + i) * block_size);
    }
    for (std::size_t lane = 0; lane < block_size; ++lane) {
        rows[8 * block_size + lane] = t[lane][8];
        rows[9 * block_size + lane] = std::bit_cast<float>(index[lane]);
    }
}

void write_wide_node(std::span<const WideChild> children, kernels::WideUnit* units) {
    constexpr float inf = std::numeric_limits<float>::infinity();
    static constexpr kernels::BvhNode nothing = {glm::vec3(inf), 0, glm::vec3(-inf), 0};  // for those not there
    std::array<const kernels::BvhNode*, wide_width> boxes;
    for (std::size_t i = 0; i < wide_width; ++i) {
        const bool there = i < children.size();
        boxes[i] = there ? children[i].box : &nothing;
        units[6].lanes[i] = std::bit_cast<float>(there ? children[i].reference : 0u);
    }
    for (std::size_t half = 0; half < wide_width; half += 4) {
        const auto* const b = &boxes[half];
        const auto lower = transposed(&b[0]->lower.x, &b[1]->lower.x, &b[2]->lower.x, &b[3]->lower.x);
        const auto upper = transposed(&b[0]->upper.x, &b[1]->upper.x, &b[2]->upper.x, &b[3]->upper.x);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            lower[axis].store(units[2 * axis].lanes + half);
            upper[axis].store(units[2 * axis + 1].lanes + half);
        }
    }
}

WideParts::WideParts(std::size_t blocks, std::size_t ready) : first_ready_(unit_of_block(blocks)) {
    // Memory that is asked for and not touched costs nothing.
    units_.reserve(unit_of_ready(ready + (ready > 0 ? blocks / 8 : blocks / 4)));
    units_.resize(unit_of_ready(ready));
}

WideBvh collapse_parts(std::span<const kernels::BvhNode> binary, WideParts parts, std::span<const WideReady> ready,
                       const WideBvhOptions& options) {
    const WideLeaves leaves{1, [](std::uint32_t, std::uint32_t count) { return count; }, ready};
    const WidePlan plan = plan_wide_bvh(binary, options, leaves);
    // Where nodes stand: those of the plan in place of those that are not there, then behind all others.
    std::vector<std::uint32_t> ready_units(ready.size()), plan_units{0}, holes;
    for (std::size_t r = 0; r < ready.size(); ++r) {
        ready_units[r] = parts.unit_of_ready(r);
        if (ready[r].primitives == 0) holes.push_back(std::uint32_t(r));
    }
    const std::size_t node_count = plan.nodes.size() + ready.size() - holes.size();
    std::size_t end = ready.size(), hole = 0;
    while (plan_units.size() < plan.nodes.size())
        plan_units.push_back(parts.unit_of_ready(hole < holes.size() ? holes[hole++] : end++));
    while (hole < holes.size()) {  // the last nodes take the places that are left
        --end;
        if (holes.back() == end) holes.pop_back();
        else {
            std::copy_n(parts.ready(end), kernels::WIDE_NODE_UNITS, parts.ready(holes[hole]));
            ready_units[end] = parts.unit_of_ready(holes[hole++]);
        }
    }
    parts.units_.resize(parts.unit_of_ready(end));
    WideBvh out;
    out.units = std::move(parts.units_);
    parallel_for(plan.nodes.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            if (n + 4 < end) prefetch_children(binary, plan.nodes[n + 4]);
            const WidePlanNode& node = plan.nodes[n];
            std::array<WideChild, wide_width> children;
            for (std::uint32_t i = 0; i < node.count; ++i) {
                const std::uint32_t first = node.firsts[i], count = node.counts[i];
                children[i].box = &binary[node.children[i]];
                children[i].reference = count == 0            ? plan_units[node.nodes[i]]
                                        : count == wide_ready ? ready_units[first]
                                                              : WideParts::block_reference(first, count);
            }
            write_wide_node(std::span(children).first(node.count), &out.units[plan_units[n]]);
        }
    });
    out.statistics = {plan.sah_cost, plan.depth, std::uint32_t(node_count), plan.triangle_count, plan.triangle_count};
    return out;
}

WideBvh collapse_bvh(const Bvh& binary, std::span<const kernels::Triangle> triangles, const WideBvhOptions& options) {
    if (binary.nodes.empty()) return {};
    const WideLeaves leaves{block_size, [](std::uint32_t, std::uint32_t count) { return blocks_for(count); }};
    return Writer(binary, triangles, plan_wide_bvh(binary.nodes, options, leaves)).run();
}

}  // namespace spinel
