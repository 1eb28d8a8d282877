#include "accel/kd_builder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>

#include "core/parallel.h"
#include "kernels/mesh_kd.h"

namespace spinel {
namespace {

constexpr std::size_t parallel_threshold = 8192;  // primitives below which a subtree is not worth a task

// Where a primitive's box ends, lies, or begins along an axis, in this order at one plane.
enum Kind : std::uint8_t { END, PLANAR, START };

struct Event {
    float position;
    std::uint32_t primitive;
    std::uint8_t axis;
    std::uint8_t kind;
    bool operator<(const Event& other) const {
        if (position != other.position) return position < other.position;
        if (axis != other.axis) return axis < other.axis;
        if (kind != other.kind) return kind < other.kind;
        return primitive < other.primitive;
    }
};

double half_area(const Box& b) {
    const glm::dvec3 e = glm::dvec3(b.upper) - glm::dvec3(b.lower);
    return e.x * e.y + e.y * e.z + e.z * e.x;
}

struct Split {
    double cost = std::numeric_limits<double>::infinity();
    float position = 0;
    std::uint8_t axis = 3;  // 3: none
    bool planar_left = true;
};

// The primitives that a task deals with have numbers of its own, so that what it keeps for each of them is no larger
// than its part of the tree.
struct Task {
    std::vector<std::uint32_t> names;  // of the boxes, by number
    std::vector<std::uint8_t> side;    // of the split at hand
};

// Part of a tree: its root first, indices its own.
struct Subtree {
    std::vector<kernels::KdNode> nodes;
    std::vector<std::uint32_t> references;
    double cost = 0;  // half areas by what is done in them
    std::uint32_t depth = 0;
    std::size_t leaf_count = 0;
};

class Builder {
  public:
    Builder(const ClipToBox& clip, const KdOptions& options, std::size_t count)
        : clip_(clip),
          options_(options),
          max_depth_(std::min(int(8 + 1.3 * std::log2(double(count))), int(kernels::KD_MAX_DEPTH))) {}

    static void append_events(std::uint32_t primitive, const Box& box, std::vector<Event>& events) {
        for (std::uint8_t axis = 0; axis < 3; ++axis) {
            const float lower = box.lower[axis], upper = box.upper[axis];
            if (lower == upper) {
                events.push_back({lower, primitive, axis, PLANAR});
            } else {
                events.push_back({lower, primitive, axis, START});
                events.push_back({upper, primitive, axis, END});
            }
        }
    }

    // Events are sorted; each of `primitives` has some. At most `most` references come of them, which is no less than
    // there are primitives.
    void build(Subtree& tree, std::size_t node, std::vector<std::uint32_t>&& primitives, std::vector<Event>&& events,
               const Box& region, int depth, std::size_t most, Task& task) const {
        const std::size_t count = primitives.size();
        tree.depth = std::max(tree.depth, std::uint32_t(depth));
        Split split;
        if (depth < max_depth_ && count > 0) split = best_split(events, region, count);
        const double area = half_area(region);
        const auto leaf = [&] {
            tree.nodes[node] = {kernels::bits_float(std::uint32_t(count)),
                                std::uint32_t(tree.references.size()) << 3 | 1u};
            for (const std::uint32_t p : primitives) tree.references.push_back(task.names[p]);
            tree.cost += area * double(count);
            ++tree.leaf_count;
        };
        if (split.axis > 2 || !(split.cost < double(count))) return leaf();
        Box left_region = region, right_region = region;
        left_region.upper[split.axis] = split.position;
        right_region.lower[split.axis] = split.position;
        std::vector<std::uint32_t> left, right;
        std::vector<Event> left_events, right_events;
        distribute(split, primitives, events, left_region, right_region, task, left, right, left_events, right_events);
        const std::size_t below = left.size() + right.size();
        if (below > most) return leaf();
        tree.cost += area * double(options_.traversal_cost);
        // What may still be added is shared out by numbers, whatever order subtrees are built in.
        const std::size_t most_left =
            left.size() + std::size_t(double(most - below) * double(left.size()) / double(below));
        const std::size_t most_right = most - most_left;
        primitives = {};
        events = {};

        const std::size_t children = tree.nodes.size();
        tree.nodes.resize(children + 2);
        tree.nodes[node] = {split.position, std::uint32_t(children) << 3 | std::uint32_t(split.axis) << 1};
        if (count < parallel_threshold) {
            build(tree, children, std::move(left), std::move(left_events), left_region, depth + 1, most_left, task);
            build(tree, children + 1, std::move(right), std::move(right_events), right_region, depth + 1, most_right,
                  task);
            return;
        }
        std::array<Subtree, 2> halves;
        parallel_for(2, 1, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                halves[i].nodes.resize(1);
                std::vector<std::uint32_t>& own = i == 0 ? left : right;
                std::vector<Event>& own_events = i == 0 ? left_events : right_events;
                Task part = renumbered(task, own, own_events);
                build(halves[i], 0, std::move(own), std::move(own_events), i == 0 ? left_region : right_region,
                      depth + 1, i == 0 ? most_left : most_right, part);
            }
        });
        for (std::size_t i = 0; i < 2; ++i) graft(tree, children + i, halves[i]);
    }

  private:
    static Task renumbered(const Task& task, std::vector<std::uint32_t>& primitives, std::vector<Event>& events) {
        Task part{std::vector<std::uint32_t>(primitives.size()), std::vector<std::uint8_t>(primitives.size())};
        std::vector<std::uint32_t> numbers(task.names.size());
        for (std::uint32_t i = 0; i < primitives.size(); ++i) {
            numbers[primitives[i]] = i;
            part.names[i] = task.names[primitives[i]];
            primitives[i] = i;
        }
        for (Event& e : events) e.primitive = numbers[e.primitive];
        return part;
    }

    static void graft(Subtree& tree, std::size_t root, const Subtree& part) {
        // All but its root stand behind what is there.
        const auto node_shift = std::uint32_t(tree.nodes.size()) - 1u;
        const auto reference_shift = std::uint32_t(tree.references.size());
        const auto shifted = [&](kernels::KdNode n) {
            n.link += (n.link & 1u ? reference_shift : node_shift) << 3;
            return n;
        };
        tree.nodes[root] = shifted(part.nodes[0]);
        for (std::size_t i = 1; i < part.nodes.size(); ++i) tree.nodes.push_back(shifted(part.nodes[i]));
        tree.references.insert(tree.references.end(), part.references.begin(), part.references.end());
        tree.cost += part.cost;
        tree.depth = std::max(tree.depth, part.depth);
        tree.leaf_count += part.leaf_count;
    }

    double cost_of(double left_share, double right_share, std::size_t left, std::size_t right) const {
        const double cost = double(options_.traversal_cost) + left_share * double(left) + right_share * double(right);
        return left == 0 || right == 0 ? cost * (1 - double(options_.empty_bonus)) : cost;
    }

    Split best_split(const std::vector<Event>& events, const Box& region, std::size_t count) const {
        Split best;
        const double area = half_area(region);
        if (!(area > 0)) return best;
        const glm::dvec3 extent = glm::dvec3(region.upper) - glm::dvec3(region.lower);
        std::array<std::size_t, 3> left = {0, 0, 0}, right = {count, count, count};
        for (std::size_t i = 0; i < events.size();) {
            const float position = events[i].position;
            const std::uint8_t axis = events[i].axis;
            std::array<std::size_t, 3> found = {0, 0, 0};  // by kind
            for (; i < events.size() && events[i].position == position && events[i].axis == axis; ++i)
                ++found[events[i].kind];
            right[axis] -= found[END] + found[PLANAR];
            if (position > region.lower[axis] && position < region.upper[axis]) {
                const double u = extent[(axis + 1) % 3], v = extent[(axis + 2) % 3];
                const double below = double(position) - double(region.lower[axis]);
                const double above = double(region.upper[axis]) - double(position);
                const double left_share = (u * v + below * (u + v)) / area;
                const double right_share = (u * v + above * (u + v)) / area;
                const double with_left = cost_of(left_share, right_share, left[axis] + found[PLANAR], right[axis]);
                const double with_right = cost_of(left_share, right_share, left[axis], right[axis] + found[PLANAR]);
                if (std::min(with_left, with_right) < best.cost)
                    best = {std::min(with_left, with_right), position, axis, with_left <= with_right};
            }
            left[axis] += found[START] + found[PLANAR];
        }
        return best;
    }

    void distribute(const Split& split, const std::vector<std::uint32_t>& primitives, const std::vector<Event>& events,
                    const Box& left_region, const Box& right_region, Task& task, std::vector<std::uint32_t>& left,
                    std::vector<std::uint32_t>& right, std::vector<Event>& left_events,
                    std::vector<Event>& right_events) const {
        constexpr std::uint8_t LEFT = 1, RIGHT = 2, BOTH = 3;
        std::vector<std::uint8_t>& side = task.side;
        for (const std::uint32_t p : primitives) side[p] = BOTH;
        for (const Event& e : events) {
            if (e.axis != split.axis) continue;
            if (e.kind == END && e.position <= split.position) side[e.primitive] = LEFT;
            if (e.kind == START && e.position >= split.position) side[e.primitive] = RIGHT;
            if (e.kind == PLANAR)
                side[e.primitive] =
                    e.position < split.position || (e.position == split.position && split.planar_left) ? LEFT : RIGHT;
        }
        for (const Event& e : events) {
            if (side[e.primitive] == LEFT) left_events.push_back(e);
            if (side[e.primitive] == RIGHT) right_events.push_back(e);
        }
        // What straddles the plane gets new events on either side, from what of it lies there.
        std::vector<Event> left_new, right_new;
        for (const std::uint32_t p : primitives) {
            if (side[p] != BOTH) {
                (side[p] == LEFT ? left : right).push_back(p);
                continue;
            }
            const Box in_left = clip_(task.names[p], left_region), in_right = clip_(task.names[p], right_region);
            const bool is_left = glm::all(glm::lessThanEqual(in_left.lower, in_left.upper));
            const bool is_right = glm::all(glm::lessThanEqual(in_right.lower, in_right.upper));
            if (is_left || !is_right) {
                left.push_back(p);
                append_events(p, is_left ? in_left : left_region, left_new);
            }
            if (is_right) {
                right.push_back(p);
                append_events(p, in_right, right_new);
            }
        }
        const auto merge_in = [](std::vector<Event>& to, std::vector<Event>& more) {
            std::sort(more.begin(), more.end());
            const auto middle = std::ptrdiff_t(to.size());
            to.insert(to.end(), more.begin(), more.end());
            std::inplace_merge(to.begin(), to.begin() + middle, to.end());
        };
        merge_in(left_events, left_new);
        merge_in(right_events, right_new);
    }

    const ClipToBox& clip_;
    const KdOptions options_;
    const int max_depth_;
};

}  // namespace

KdTree build_kd_tree(std::span<const Box> boxes, const ClipToBox& clip, const KdOptions& options) {
    KdTree tree;
    if (boxes.empty()) return tree;
    std::vector<std::uint32_t> primitives(boxes.size());
    std::vector<Event> events;
    events.reserve(6 * boxes.size());
    tree.bounds = boxes[0];
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        primitives[i] = std::uint32_t(i);
        tree.bounds.lower = glm::min(tree.bounds.lower, boxes[i].lower);
        tree.bounds.upper = glm::max(tree.bounds.upper, boxes[i].upper);
        Builder::append_events(std::uint32_t(i), boxes[i], events);
    }
    std::sort(events.begin(), events.end());
    Subtree whole;
    whole.nodes.resize(1);
    Task task{primitives, std::vector<std::uint8_t>(boxes.size())};
    const std::size_t most = options.references * boxes.size() + (std::size_t(1) << 16);
    Builder(clip, options, boxes.size())
        .build(whole, 0, std::move(primitives), std::move(events), tree.bounds, 0, most, task);
    tree.nodes = std::move(whole.nodes);
    tree.references = std::move(whole.references);
    tree.depth = whole.depth;
    tree.leaf_count = whole.leaf_count;
    const double area = half_area(tree.bounds);
    tree.sah_cost = area > 0 ? whole.cost / area : double(boxes.size());
    return tree;
}

}  // namespace spinel
