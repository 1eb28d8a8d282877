#include "accel/split_bvh.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cassert>
#include <limits>
#include <vector>

#include "accel/split_planes.h"
#include "core/huge_pages.h"
#include "core/parallel.h"

namespace spinel {
namespace {

using kernels::BvhNode;

using split::Binning;
using split::Plane;
using split::Record;
using split::Reference;

constexpr std::size_t parallel_threshold = 4096;  // references below which a subtree is not worth a task
constexpr float infinity = std::numeric_limits<float>::infinity();

int ceil_log2(std::size_t n) { return n <= 1 ? 0 : std::bit_width(n - 1); }

class Builder {
  public:
    Builder(const SplitBvhOptions& options, const ClipPrimitive& clip, std::size_t max_references)
        : options_(options),
          clip_(clip),
          block_bits_(std::countr_zero(options.block)),
          nodes_(2 * max_references),
          order_(max_references) {}

    Bvh run(Record& root) {
        root_area_ = half_area(root.bounds);
        next_node_ = 1;
        build(0, root);
        return compact();
    }

  private:
    // Fills node `at` and all below it.
    void build(std::size_t at, Record& record) {
        BvhNode& node = nodes_[at];
        node.lower = lower_of(record.bounds);
        node.upper = upper_of(record.bounds);
        const std::size_t count = record.references.size();
        if (count <= options_.min_leaf) return make_leaf(node, record);
        // As many levels as halving needs are kept in reserve, which bounds the
        // depth whatever the input. Two that may not share a leaf are halved too.
        const bool balance =
            record.depth + ceil_log2(count) >= options_.max_depth || (count == 2 && options_.max_leaf == 1);
        Plane plane;
        if (!balance) plane = best_plane(record);
        const float leaf_cost = blocks(count);
        if (count <= options_.max_leaf && !(plane.cost < leaf_cost)) return make_leaf(node, record);
        Record left, right;
        left.depth = right.depth = record.depth + 1;
        std::vector<Reference> left_parts, right_parts;
        if (plane.axis < 0 || (plane.spatial && !partition_space(record, plane, left, right, left_parts, right_parts)))
            halve(record, left, right);
        else if (!plane.spatial) partition(record, plane, left, right);
        share_growth(record, left, right);

        const std::size_t children = next_node_.fetch_add(2, std::memory_order_relaxed);
        node.first = std::uint32_t(children);
        node.count = 0;
        if (count < parallel_threshold) {
            build(children, left);
            build(children + 1, right);
        } else {
            parallel_for(2, 1, [&](std::size_t first, std::size_t last) {
                if (first == 0) build(children, left);
                if (last == 2) build(children + 1, right);
            });
        }
    }

    float blocks(std::size_t count) const { return float((count + options_.block - 1) >> block_bits_); }

    void make_leaf(BvhNode& node, const Record& record) {
        const std::size_t first = next_order_.fetch_add(record.references.size(), std::memory_order_relaxed);
        node.first = std::uint32_t(first);
        node.count = std::uint32_t(record.references.size());
        for (std::size_t i = 0; i < record.references.size(); ++i) order_[first + i] = record.references[i].primitive();
        if (record.references.size() > 1) std::sort(&order_[first], &order_[first] + record.references.size());
    }

    static void share_growth(const Record& record, Record& left, Record& right) {
        const std::size_t spent = left.references.size() + right.references.size() - record.references.size();
        const std::size_t rest = record.growth - std::min(spent, record.growth);
        if (rest == 0) return;
        left.growth = std::size_t(double(rest) * double(left.references.size()) /
                                  double(left.references.size() + right.references.size()));
        right.growth = rest - left.growth;
    }

    Plane best_plane(const Record& record) const {
        const Plane best = split::best_object_plane(record, options_);
        if (record.growth == 0 || record.references.size() < options_.spatial_from) return best;
        if (best.axis >= 0) {
            const Float4 low = min(best.left.negated_lower(), best.right.negated_lower());
            const Float4 high = min(best.left.upper(), best.right.upper());
            const float overlap = half_area(max(high + low, Float4(0.0f)));
            if (!(overlap > options_.spatial_overlap * half_area(record.bounds) &&
                  overlap > options_.spatial_overlap_of_all * root_area_))
                return best;
        }
        const Plane spatial = split::best_spatial_plane(record, options_, clip_);
        return spatial.cost < 0.99f * best.cost ? spatial : best;
    }

    // Without a branch on where a reference goes, which nobody can guess: every one is put where the left ones end, and
    // what stood there in its place.
    void partition(Record& record, const Plane& plane, Record& left, Record& right) const {
        const Binning binning = split::center_binning(record, options_);
        const Float4 bin(float(plane.bin));
        // By how much a centre is lowered before the bounds of the left ones and of the right ones are asked: infinity
        // keeps out.
        static constexpr float keep_out[3] = {infinity, 0, infinity};
        Reference* middle = record.references.data();
        for (Reference& place : record.references) {
            const Reference reference = place;
            const SignedBounds center = reference.bounds().center();
            const int goes_left = less_mask(binning.place(center.negated_lower()), bin) >> plane.axis & 1;
            place = *middle;
            *middle = reference;
            middle += goes_left;
            left.centers.extend(center.lowered(keep_out[goes_left]));
            right.centers.extend(center.lowered(keep_out[goes_left + 1]));
        }
        const auto count = std::size_t(middle - record.references.data());
        left.references = record.references.first(count);
        right.references = record.references.subspan(count);
        left.bounds = plane.left;
        right.bounds = plane.right;
    }

    // References on both sides are cut in two, unless it is cheaper to leave them
    // whole on one side ("unsplitting"). False: it came to nothing.
    bool partition_space(const Record& record, const Plane& plane, Record& left, Record& right,
                         std::vector<Reference>& left_parts, std::vector<Reference>& right_parts) const {
        const float position = split::spatial_position(record, plane.axis, plane.bin);
        std::vector<Reference> across;
        SignedBounds left_all, right_all;
        for (const Reference& reference : record.references) {
            if (reference.upper(plane.axis) <= position) {
                left_parts.push_back(reference);
                left_all.extend(reference.bounds());
            } else if (reference.lower(plane.axis) >= position) {
                right_parts.push_back(reference);
                right_all.extend(reference.bounds());
            } else {
                across.push_back(reference);
            }
        }
        struct Cut {
            Box below, above;
        };
        std::vector<Cut> cuts(across.size());
        for (std::size_t i = 0; i < across.size(); ++i) {
            Cut& cut = cuts[i];
            const SignedBounds whole = across[i].bounds();
            clip_(across[i].primitive(), {lower_of(whole), upper_of(whole)}, plane.axis, position, cut.below,
                  cut.above);
            if (split::holds_something(cut.below)) left_all.extend(signed_bounds(cut.below));
            if (split::holds_something(cut.above)) right_all.extend(signed_bounds(cut.above));
        }
        std::size_t left_count = left_parts.size() + across.size(), right_count = right_parts.size() + across.size();
        std::size_t growth = record.growth;
        const auto put = [](std::vector<Reference>& to, const Box& box, std::uint32_t primitive) {
            to.emplace_back(signed_bounds(box), primitive);
        };
        for (std::size_t i = 0; i < across.size(); ++i) {
            const Reference& reference = across[i];
            const Cut& cut = cuts[i];
            const bool in_left = split::holds_something(cut.below), in_right = split::holds_something(cut.above);
            SignedBounds with_left = left_all, with_right = right_all;
            with_left.extend(reference.bounds());
            with_right.extend(reference.bounds());
            const float nl = float(left_count), nr = float(right_count);
            const float cut_cost = half_area(left_all) * nl + half_area(right_all) * nr;
            const float left_cost = half_area(with_left) * nl + half_area(right_all) * (nr - 1);
            const float right_cost = half_area(left_all) * (nl - 1) + half_area(with_right) * nr;
            const bool may_cut = growth > 0 && in_left && in_right;
            if (may_cut && cut_cost <= left_cost && cut_cost <= right_cost) {
                put(left_parts, cut.below, reference.primitive());
                put(right_parts, cut.above, reference.primitive());
                --growth;
            } else if (in_left && (!in_right || left_cost <= right_cost)) {
                left_parts.push_back(reference);
                left_all = with_left;
                --right_count;
            } else {
                right_parts.push_back(reference);
                right_all = with_right;
                --left_count;
            }
        }
        if (left_parts.empty() || right_parts.empty() || left_parts.size() >= record.references.size() ||
            right_parts.size() >= record.references.size()) {
            left_parts.clear();
            right_parts.clear();
            return false;
        }
        left.references = left_parts;
        right.references = right_parts;
        for (const Reference& reference : left_parts) left.extend(reference);
        for (const Reference& reference : right_parts) right.extend(reference);
        return true;
    }

    // Halves by number, ordered by centre along the widest axis; ties by
    // primitive, so that the order is total.
    static void halve(Record& record, Record& left, Record& right) {
        const glm::vec3 extent = upper_of(record.centers) - lower_of(record.centers);
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const std::size_t middle = record.references.size() / 2;
        std::nth_element(record.references.begin(), record.references.begin() + std::ptrdiff_t(middle),
                         record.references.end(), [axis](const Reference& a, const Reference& b) {
                             const float ca = a.center2(axis), cb = b.center2(axis);
                             return ca != cb ? ca < cb : a.primitive() < b.primitive();
                         });
        left.references = record.references.first(middle);
        right.references = record.references.subspan(middle);
        for (const Reference& reference : left.references) left.extend(reference);
        for (const Reference& reference : right.references) right.extend(reference);
    }

    // Nodes in depth-first order, so that how tasks came by does not show.
    Bvh compact() const {
        Bvh bvh;
        bvh.nodes.reserve(next_node_);
        bvh.order.reserve(next_order_);
        struct Pending {
            std::uint32_t node, depth;  // in bvh.nodes
        };
        std::vector<Pending> stack;
        bvh.nodes.push_back(nodes_[0]);
        stack.push_back({0, 0});
        const auto half_area = [](const BvhNode& n) {
            const glm::dvec3 e = glm::dvec3(n.upper) - glm::dvec3(n.lower);
            return e.x * e.y + e.y * e.z + e.z * e.x;
        };
        double cost = 0;
        while (!stack.empty()) {
            const Pending pending = stack.back();
            stack.pop_back();
            BvhNode& node = bvh.nodes[pending.node];
            bvh.statistics.depth = std::max(bvh.statistics.depth, pending.depth);
            if (node.count > 0) {
                ++bvh.statistics.leaf_count;
                cost += half_area(node) * double(blocks(node.count));
                const std::uint32_t* from = &order_[node.first];
                node.first = std::uint32_t(bvh.order.size());
                bvh.order.insert(bvh.order.end(), from, from + node.count);
                continue;
            }
            cost += half_area(node) * double(options_.traversal_cost);
            const std::uint32_t from = node.first, to = std::uint32_t(bvh.nodes.size());
            node.first = to;
            bvh.nodes.push_back(nodes_[from]);
            bvh.nodes.push_back(nodes_[from + 1]);
            stack.push_back({to + 1, pending.depth + 1});
            stack.push_back({to, pending.depth + 1});
        }
        const double root_area = half_area(bvh.nodes[0]);
        bvh.statistics.sah_cost = root_area > 0 ? cost / root_area : 0;
        return bvh;
    }

    const SplitBvhOptions& options_;
    const ClipPrimitive& clip_;
    int block_bits_;
    float root_area_ = 0;
    HugeVector<BvhNode> nodes_;  // as many as there can be
    HugeVector<std::uint32_t> order_;
    std::atomic<std::size_t> next_node_{0}, next_order_{0};
};

}  // namespace

Bvh build_split_bvh(std::span<const Box> boxes, const SplitBvhOptions& options, const ClipPrimitive& clip) {
    assert(boxes.size() <= kernels::BVH_MAX_PRIMITIVES);
    assert(options.min_leaf >= 1 && options.min_leaf <= options.max_leaf && options.max_leaf <= kernels::BVH_MAX_LEAF);
    assert(std::has_single_bit(options.block));
    assert(options.bin_count >= 4 && options.bin_count <= split::max_bins);
    HugeVector<Reference> references;
    references.reserve(boxes.size());
    Record root;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const SignedBounds bounds = signed_bounds(boxes[i]);
        if (!is_usable(bounds)) continue;
        references.emplace_back(bounds, std::uint32_t(i));
        root.extend(references.back());
    }
    if (references.empty()) return {};
    root.references = references;
    if (clip) root.growth = std::size_t(double(options.spatial_growth) * double(references.size()));
    return Builder(options, clip, references.size() + root.growth).run(root);
}

}  // namespace spinel
