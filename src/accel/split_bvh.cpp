#include "accel/split_bvh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "accel/float4.h"
#include "core/huge_pages.h"
#include "core/parallel.h"

namespace spinel {
namespace {

using kernels::BvhNode;

constexpr int max_bins = 32;
constexpr std::size_t parallel_threshold = 4096;  // references below which a subtree is not worth a task
constexpr float infinity = std::numeric_limits<float>::infinity();

// A primitive, or a part of one.
struct alignas(16) Reference {
    glm::vec3 lower;
    std::uint32_t primitive;
    glm::vec3 upper;
    std::uint32_t unused;

    Bounds bounds() const { return {Float4::load(&lower.x), Float4::load(&upper.x)}; }
    Float4 center() const {  // halved first: the sum may be beyond what floats hold
        return Float4::load(&lower.x) * Float4(0.5f) + Float4::load(&upper.x) * Float4(0.5f);
    }
};
static_assert(sizeof(Reference) == 32);

// References of a subtree with their bounds.
struct Record {
    std::span<Reference> references;
    Bounds bounds;
    Bounds centers;
    std::size_t growth = 0;  // how many more references the subtree may come to
    int depth = 0;
};

struct Split {
    int axis = -1;
    int bin = 0;  // bins below go left
    float cost = infinity;
    float overlap = 0;  // area of what the children share
    bool spatial = false;
    Bounds left = {}, right = {};  // of the children
};

int ceil_log2(std::size_t n) { return n <= 1 ? 0 : std::bit_width(n - 1); }

glm::vec3 three(Float4 a) {
    const auto l = lanes_of(a);
    return {l[0], l[1], l[2]};
}

// What maps positions to bins, 0 … count − 1, the same way whenever asked.
struct Binning {
    int count;
    Float4 offset, scale;  // scale 0: positions do not spread along that axis

    Binning(const Bounds& range, int bins) : count(bins), offset(0.0f), scale(0.0f) {
        const auto extent = lanes_of(range.upper - range.lower), from = lanes_of(range.lower);
        alignas(16) float scales[4] = {}, offsets[4] = {};
        for (std::size_t a = 0; a < 3; ++a) {
            // A hair less than `bins`, so that the last position is in the last bin.
            const float s = 0.9999f * float(bins) / extent[a];
            if (!(std::isfinite(s) && s > 0)) continue;  // also where the extent is infinite
            scales[a] = s;
            offsets[a] = from[a];
        }
        scale = Float4::load(scales);
        offset = Float4::load(offsets);
    }
    void bins_of(Float4 position, int bins[4]) const { store_truncated((position - offset) * scale, bins); }
};

class Builder {
  public:
    Builder(const SplitBvhOptions& options, const ClipPrimitive& clip, std::size_t max_references)
        : options_(options),
          clip_(clip),
          block_bits_(std::countr_zero(options.block)),
          nodes_(2 * max_references),
          order_(max_references) {}

    Bvh run(Record& root) {
        root_area_ = root.bounds.half_area();
        next_node_ = 1;
        build(0, root);
        return compact();
    }

  private:
    // Fills node `at` and all below it.
    void build(std::size_t at, Record& record) {
        BvhNode& node = nodes_[at];
        node.lower = three(record.bounds.lower);
        node.upper = three(record.bounds.upper);
        const std::size_t count = record.references.size();
        if (count <= options_.min_leaf) return make_leaf(node, record);
        // As many levels as halving needs are kept in reserve, which bounds the
        // depth whatever the input.
        const bool balance = record.depth + ceil_log2(count) >= options_.max_depth;
        Split split;
        if (!balance) split = best_split(record);
        const float leaf_cost = blocks(count);
        if (count <= options_.max_leaf && !(split.cost < leaf_cost)) return make_leaf(node, record);
        Record left, right;
        left.depth = right.depth = record.depth + 1;
        std::vector<Reference> left_parts, right_parts;
        if (split.axis < 0 || (split.spatial && !partition_space(record, split, left, right, left_parts, right_parts)))
            halve(record, left, right);
        else if (!split.spatial) partition(record, split, left, right);
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
        for (std::size_t i = 0; i < record.references.size(); ++i) order_[first + i] = record.references[i].primitive;
        std::sort(&order_[first], &order_[first] + record.references.size());
    }

    static void share_growth(const Record& record, Record& left, Record& right) {
        const std::size_t spent = left.references.size() + right.references.size() - record.references.size();
        const std::size_t rest = record.growth - std::min(spent, record.growth);
        left.growth = std::size_t(double(rest) * double(left.references.size()) /
                                  double(left.references.size() + right.references.size()));
        right.growth = rest - left.growth;
    }

    Split best_split(const Record& record) const {
        Split best = best_object_split(record);
        const float area = record.bounds.half_area();
        const bool overlapping = best.overlap > options_.spatial_overlap * area &&
                                 best.overlap > options_.spatial_overlap_of_all * root_area_;
        if (record.growth > 0 && record.references.size() >= options_.spatial_from && (best.axis < 0 || overlapping)) {
            const Split spatial = best_spatial_split(record);
            if (spatial.cost < 0.99f * best.cost) best = spatial;
        }
        return best;
    }

    // Of the planes between bins, the one with the least expected cost; `counts`
    // of primitives that go left by the bin they begin in, and right by the one
    // they end in.
    template <class Counts>
    void sweep(const Bounds* bins, int bin_count, const Counts& begins, const Counts& ends, int axis,
               float inverse_area, bool spatial, Split& best) const {
        std::array<float, max_bins> right_cost;
        std::array<Bounds, max_bins> right_bounds;
        Bounds right;
        std::uint32_t right_count = 0;
        for (int i = bin_count - 1; i > 0; --i) {
            right.extend(bins[i]);
            right_count += ends[std::size_t(i)];
            right_bounds[std::size_t(i)] = right;
            right_cost[std::size_t(i)] = right_count > 0 ? right.half_area() * blocks(right_count) : infinity;
        }
        Bounds left;
        std::uint32_t left_count = 0;
        for (int i = 1; i < bin_count; ++i) {
            left.extend(bins[i - 1]);
            left_count += begins[std::size_t(i) - 1];
            if (left_count == 0) continue;
            const float cost = options_.traversal_cost +
                               (left.half_area() * blocks(left_count) + right_cost[std::size_t(i)]) * inverse_area;
            if (cost < best.cost) {  // NaN never wins
                const Bounds& r = right_bounds[std::size_t(i)];
                best = {axis, i, cost, 0, spatial, left, r};
                if (!spatial && options_.spatial_growth > 0) {
                    const Float4 shared = max(min(left.upper, r.upper) - max(left.lower, r.lower), Float4(0.0f));
                    best.overlap = half_area(shared);
                }
            }
        }
    }

    int bins_for(std::size_t count) const { return int(std::min(std::size_t(options_.bin_count), 4 + count / 16)); }

    Split best_object_split(const Record& record) const {
        const Binning binning(record.centers, bins_for(record.references.size()));
        std::array<std::array<Bounds, max_bins>, 3> bins;
        std::array<std::array<std::uint32_t, max_bins>, 3> counts;
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < binning.count; ++i) {
                bins[std::size_t(axis)][std::size_t(i)] = Bounds{};
                counts[std::size_t(axis)][std::size_t(i)] = 0;
            }
        for (const Reference& reference : record.references) {
            alignas(16) int at[4];
            binning.bins_of(reference.center(), at);
            const Bounds b = reference.bounds();
            for (std::size_t axis = 0; axis < 3; ++axis) {
                bins[axis][std::size_t(at[axis])].extend(b);
                ++counts[axis][std::size_t(at[axis])];
            }
        }
        const float area = record.bounds.half_area();
        const float inverse_area = area > 0 ? 1.0f / area : 0.0f;
        const auto scale = lanes_of(binning.scale);
        Split best;
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (scale[axis] > 0)
                sweep(bins[axis].data(), binning.count, counts[axis], counts[axis], int(axis), inverse_area, false,
                      best);
        return best;
    }

    static constexpr int spatial_bins = 16;

    static float bin_plane(const Record& record, int axis, int bin) {
        const float lower = three(record.bounds.lower)[axis], upper = three(record.bounds.upper)[axis];
        return lower + (upper - lower) * (float(bin) / float(spatial_bins));
    }

    Split best_spatial_split(const Record& record) const {
        const Binning binning(record.bounds, spatial_bins);
        std::array<std::array<Bounds, max_bins>, 3> bins;
        std::array<std::array<std::uint32_t, max_bins>, 3> begins{}, ends{};
        std::array<std::array<float, spatial_bins>, 3> planes;
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < spatial_bins; ++i)
                planes[std::size_t(axis)][std::size_t(i)] = bin_plane(record, axis, i);
        for (const Reference& reference : record.references) {
            alignas(16) int first[4], last[4];
            const Bounds whole = reference.bounds();
            binning.bins_of(whole.lower, first);
            binning.bins_of(whole.upper, last);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                ++begins[axis][std::size_t(first[axis])];
                ++ends[axis][std::size_t(last[axis])];
                if (first[axis] == last[axis]) {
                    bins[axis][std::size_t(first[axis])].extend(whole);
                    continue;
                }
                Box rest = {reference.lower, reference.upper};
                for (int i = first[axis]; i < last[axis]; ++i) {
                    Box below, above;
                    clip_(reference.primitive, rest, int(axis), planes[axis][std::size_t(i) + 1], below, above);
                    if (is_usable(below)) bins[axis][std::size_t(i)].extend(bounds_of(below));
                    rest = above;
                }
                if (is_usable(rest)) bins[axis][std::size_t(last[axis])].extend(bounds_of(rest));
            }
        }
        const float area = record.bounds.half_area();
        const float inverse_area = area > 0 ? 1.0f / area : 0.0f;
        const auto scale = lanes_of(binning.scale);
        Split best;
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (scale[axis] > 0)
                sweep(bins[axis].data(), spatial_bins, begins[axis], ends[axis], int(axis), inverse_area, true, best);
        return best;
    }

    static bool is_usable(const Box& b) {
        return b.lower.x <= b.upper.x && b.lower.y <= b.upper.y && b.lower.z <= b.upper.z;
    }
    static Bounds bounds_of(const Box& b) { return {Float4(b.lower), Float4(b.upper)}; }

    static void extend(Record& record, const Reference& reference) {
        record.bounds.extend(reference.bounds());
        record.centers.extend(reference.center());
    }

    // Without a branch on where a reference goes, which nobody can guess: every
    // one is put where the left ones end, and what stood there in its place.
    void partition(Record& record, const Split& split, Record& left, Record& right) const {
        const Binning binning(record.centers, bins_for(record.references.size()));
        const auto axis = std::size_t(split.axis);
        const float offset = lanes_of(binning.offset)[axis], scale = lanes_of(binning.scale)[axis];
        // What is added to a centre before the bounds of the left ones and of the
        // right ones are asked: infinity keeps out.
        static constexpr float keep_out[3] = {infinity, 0, infinity};
        Bounds left_centers, right_centers;
        Reference* middle = record.references.data();
        for (Reference& place : record.references) {
            const Reference reference = place;
            const Float4 center = reference.center();
            const float along = reference.lower[split.axis] * 0.5f + reference.upper[split.axis] * 0.5f;
            const bool goes_left = int((along - offset) * scale) < split.bin;  // as bins_of()
            place = *middle;
            *middle = reference;
            middle += goes_left;
            const Float4 not_left(keep_out[goes_left]), not_right(keep_out[1 + goes_left]);
            left_centers.lower = min(left_centers.lower, center + not_left);
            left_centers.upper = max(left_centers.upper, center - not_left);
            right_centers.lower = min(right_centers.lower, center + not_right);
            right_centers.upper = max(right_centers.upper, center - not_right);
        }
        const auto count = std::size_t(middle - record.references.data());
        left.references = record.references.first(count);
        right.references = record.references.subspan(count);
        left.bounds = split.left;
        right.bounds = split.right;
        left.centers = left_centers;
        right.centers = right_centers;
    }

    // References on both sides are cut in two, unless it is cheaper to leave them
    // whole on one side ("unsplitting"). False: it came to nothing.
    bool partition_space(const Record& record, const Split& split, Record& left, Record& right,
                         std::vector<Reference>& left_parts, std::vector<Reference>& right_parts) const {
        const float plane = bin_plane(record, split.axis, split.bin);
        std::vector<Reference> across;
        Bounds left_bounds, right_bounds;
        for (const Reference& reference : record.references) {
            if (reference.upper[split.axis] <= plane) {
                left_parts.push_back(reference);
                left_bounds.extend(reference.bounds());
            } else if (reference.lower[split.axis] >= plane) {
                right_parts.push_back(reference);
                right_bounds.extend(reference.bounds());
            } else {
                across.push_back(reference);
            }
        }
        struct Cut {
            Box below, above;
        };
        std::vector<Cut> cuts(across.size());
        Bounds left_all = left_bounds, right_all = right_bounds;
        for (std::size_t i = 0; i < across.size(); ++i) {
            Cut& cut = cuts[i];
            clip_(across[i].primitive, {across[i].lower, across[i].upper}, split.axis, plane, cut.below, cut.above);
            if (is_usable(cut.below)) left_all.extend(bounds_of(cut.below));
            if (is_usable(cut.above)) right_all.extend(bounds_of(cut.above));
        }
        std::size_t left_count = left_parts.size() + across.size(), right_count = right_parts.size() + across.size();
        std::size_t growth = record.growth;
        const auto put = [](std::vector<Reference>& to, const Box& box, std::uint32_t primitive) {
            to.push_back({box.lower, primitive, box.upper, 0});
        };
        for (std::size_t i = 0; i < across.size(); ++i) {
            const Reference& reference = across[i];
            const Cut& cut = cuts[i];
            const bool in_left = is_usable(cut.below), in_right = is_usable(cut.above);
            Bounds with_left = left_all, with_right = right_all;
            with_left.extend(reference.bounds());
            with_right.extend(reference.bounds());
            const float nl = float(left_count), nr = float(right_count);
            const float cut_cost = left_all.half_area() * nl + right_all.half_area() * nr;
            const float left_cost = with_left.half_area() * nl + right_all.half_area() * (nr - 1);
            const float right_cost = left_all.half_area() * (nl - 1) + with_right.half_area() * nr;
            const bool may_cut = growth > 0 && in_left && in_right;
            if (may_cut && cut_cost <= left_cost && cut_cost <= right_cost) {
                put(left_parts, cut.below, reference.primitive);
                put(right_parts, cut.above, reference.primitive);
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
        for (const Reference& reference : left_parts) extend(left, reference);
        for (const Reference& reference : right_parts) extend(right, reference);
        return true;
    }

    // Halves by number, ordered by centre along the widest axis; ties by
    // primitive, so that the order is total.
    static void halve(Record& record, Record& left, Record& right) {
        const glm::vec3 extent = three(record.centers.upper - record.centers.lower);
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const std::size_t middle = record.references.size() / 2;
        std::nth_element(record.references.begin(), record.references.begin() + std::ptrdiff_t(middle),
                         record.references.end(), [axis](const Reference& a, const Reference& b) {
                             const float ca = a.lower[axis] + a.upper[axis], cb = b.lower[axis] + b.upper[axis];
                             return ca != cb ? ca < cb : a.primitive < b.primitive;
                         });
        left.references = record.references.first(middle);
        right.references = record.references.subspan(middle);
        for (const Reference& reference : left.references) extend(left, reference);
        for (const Reference& reference : right.references) extend(right, reference);
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
    assert(options.bin_count >= 4 && options.bin_count <= max_bins);
    HugeVector<Reference> references;
    references.reserve(boxes.size());
    Record root;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const glm::vec3 lower = boxes[i].lower, upper = boxes[i].upper;
        bool usable = true;
        for (int axis = 0; axis < 3; ++axis)
            usable = usable && std::isfinite(lower[axis]) && std::isfinite(upper[axis]) && lower[axis] <= upper[axis];
        if (!usable) continue;
        references.push_back({lower, std::uint32_t(i), upper, 0});
        root.bounds.extend(references.back().bounds());
        root.centers.extend(references.back().center());
    }
    if (references.empty()) return {};
    root.references = references;
    if (clip) root.growth = std::size_t(double(options.spatial_growth) * double(references.size()));
    return Builder(options, clip, references.size() + root.growth).run(root);
}

}  // namespace spinel
