#include "geometry/sdf/sdf_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "geometry/sdf/sdf_analysis.h"

namespace spinel {
namespace {

using glm::dvec3;
using glm::dvec4;
using kernels::SdfOp;
using kernels::uint;

constexpr double ENDLESS = 1e15;
constexpr std::size_t MAX_OPS = 4'000'000;  // repeats of repeats multiply

dvec3 rotate(dvec4 q, dvec3 p) {
    dvec3 axis(q);
    return p + 2.0 * glm::cross(axis, glm::cross(axis, p) + q.w * p);
}

dvec4 multiply(dvec4 a, dvec4 b) {  // rotates by b, then by a
    return dvec4(a.w * dvec3(b) + b.w * dvec3(a) + glm::cross(dvec3(a), dvec3(b)),
                 a.w * b.w - glm::dot(dvec3(a), dvec3(b)));
}

// A point register, and a similarity still to be applied to it: chains of transforms become one instruction,
// and a translation none at all, since shapes have a place.
struct Place {
    uint point = 0;
    bool owned = false;  // nobody else reads the register any more
    dvec4 rotation = {0, 0, 0, 1};
    double scale = 1;
    dvec3 shift = {0, 0, 0};  // q = scale · rotate(rotation, p) + shift

    bool shifts_only() const { return scale == 1 && dvec3(rotation) == dvec3(0); }
    bool is_identity() const { return shifts_only() && shift == dvec3(0); }
};

// One register file as a bit mask of what is in use.
class Registers {
  public:
    explicit Registers(uint count) : count_(count) {}
    // count() if all are in use.
    uint take() {
        uint i = static_cast<uint>(std::countr_one(used_));
        if (i < count_) used_ |= std::uint64_t(1) << i;
        return std::min(i, count_);
    }
    void release(uint i) { used_ &= ~(std::uint64_t(1) << i); }
    uint count() const { return count_; }

  private:
    std::uint64_t used_ = 0;
    uint count_;
};

class Emitter {
  public:
    Emitter() { points_.take(); }  // register 0: the point that is asked for

    // Emits the instructions of a node; the value register of its result. A place that is owned is used up.
    uint emit(const SdfTree& node, Place place) {
        if (fault_) return 0;
        const std::vector<float>& n = node.numbers;
        switch (node.operation->role) {
            case SdfRole::shape: return emit_shape(node, place);
            case SdfRole::combine: return emit_combine(node, place);
            case SdfRole::translate: place.shift -= dvec3(n[0], n[1], n[2]); return emit(node.children[0], place);
            case SdfRole::rotate: {
                dvec4 q = sdf_quaternion(n);
                dvec4 inverse(-dvec3(q), q.w);
                place.rotation = multiply(inverse, place.rotation);
                place.shift = rotate(inverse, place.shift);
                return emit(node.children[0], place);
            }
            case SdfRole::scale: {
                place.scale /= n[0];
                place.shift /= double(n[0]);
                return change(emit(node.children[0], place), kernels::SDF_OP_MULTIPLY, n[0]);
            }
            case SdfRole::repeat: return emit_repeat(node, place);
            case SdfRole::twist: {
                place = settle(place);
                Place outside = place;
                Place inside = warp(place, node.far, kernels::SDF_OP_TWIST, vec4(n[0], 0, 0, 0), vec4(0));
                uint value = emit(node.children[0], inside);
                return node.far ? emit_far(node, outside, value) : value;
            }
            case SdfRole::elongate: {
                vec4 half(0.5f * n[0], 0.5f * n[1], 0.5f * n[2], 0);
                return emit(node.children[0], warp(settle(place), false, kernels::SDF_OP_ELONGATE, half, vec4(0)));
            }
            case SdfRole::offset: return change(emit(node.children[0], place), kernels::SDF_OP_OFFSET, n[0]);
            case SdfRole::shell: return change(emit(node.children[0], place), kernels::SDF_OP_SHELL, 0.5f * n[0]);
            case SdfRole::displace: {
                place = settle(place);
                uint value = emit(node.children[0], shared(place));
                add(kernels::SDF_OP_DISPLACE, value, value, place.point, vec4(n[0], n[1], 0, 0), vec4(0));
                release(place);
                return value;
            }
        }
        return 0;
    }

    // max(f, distance to the box), so that the solid ends there.
    uint clip(uint value, const SdfBox& box) {
        uint limit = take_value();
        vec3 half(0.5 * (box.upper - box.lower));
        vec3 centre(0.5 * (box.upper + box.lower));
        add(kernels::SDF_OP_BOX, limit, 0, 0, vec4(half, 0), vec4(centre, 0));
        add(kernels::SDF_OP_MAX, value, value, limit, vec4(0), vec4(0));
        values_.release(limit);
        return value;
    }

    const std::optional<std::string>& fault() const { return fault_; }
    std::vector<SdfOp> take_ops() { return std::move(ops_); }

  private:
    void add(uint op, uint target, uint a, uint b, vec4 data0, vec4 data1) {
        if (ops_.size() >= MAX_OPS) {
            fault_ = fmt::format("its repeats expand to more than {} instructions: nest fewer of them", MAX_OPS);
            return;
        }
        ops_.push_back(SdfOp(op, target, a, b, data0, data1));
    }

    uint take_point() {
        uint i = points_.take();
        if (i == points_.count()) {
            fault_ = fmt::format("needs more than {} point registers: nest fewer rotations, scalings and warps",
                                 points_.count());
            return 0;
        }
        return i;
    }

    uint take_value() {
        uint i = values_.take();
        if (i == values_.count()) {
            fault_ = fmt::format("needs more than {} value registers: nest less deeply", values_.count());
            return 0;
        }
        return i;
    }

    void release(const Place& place) {
        if (place.owned) points_.release(place.point);
    }

    static Place shared(Place place) {
        place.owned = false;
        return place;
    }

    // The place as a register of its own, nothing left to apply.
    Place settle(const Place& place) {
        if (place.is_identity()) return place;
        Place settled;
        settled.point = place.owned ? place.point : take_point();
        settled.owned = true;
        add(kernels::SDF_OP_SIMILARITY, settled.point, place.point, 0, vec4(place.rotation),
            vec4(vec3(place.shift), place.scale));
        return settled;
    }

    // A point instruction on a settled place; `keep`: the place is still needed afterwards.
    Place warp(const Place& place, bool keep, uint op, vec4 data0, vec4 data1) {
        Place warped;
        warped.point = place.owned && !keep ? place.point : take_point();
        warped.owned = true;
        add(op, warped.point, place.point, 0, data0, data1);
        return warped;
    }

    uint change(uint value, uint op, float number) {
        add(op, value, value, 0, vec4(number, 0, 0, 0), vec4(0));
        return value;
    }

    uint emit_shape(const SdfTree& node, Place place) {
        if (!place.shifts_only()) place = settle(place);
        release(place);
        SdfShape shape = node.operation->shape(node.numbers);
        uint value = take_value();
        add(shape.op, value, place.point, 0, shape.data, vec4(vec3(-place.shift), 0));
        return value;
    }

    uint emit_combine(const SdfTree& node, Place place) {
        if (!place.shifts_only()) place = settle(place);
        const std::vector<SdfTree>& children = node.children;
        uint op = node.operation->kernel_op;
        std::vector<const SdfTree*> order;
        for (const SdfTree& child : children) order.push_back(&child);
        if (op == kernels::SDF_OP_MIN || op == kernels::SDF_OP_MAX) {
            auto most = std::max_element(order.begin(), order.end(), [](const SdfTree* a, const SdfTree* b) {
                return a->value_registers < b->value_registers;
            });
            std::iter_swap(order.begin(), most);
        }
        uint total = emit(*order[0], shared(place));
        emit_group(node, std::span(order).subspan(1), total, place);
        release(place);
        return total;
    }

    // Folds children into the total. A group that costs more than to look at its bounds is skipped where it
    // lies too far away to count; large groups are halved, along their longest axis where the order of the
    // fold is free.
    void emit_group(const SdfTree& node, std::span<const SdfTree*> group, uint total, const Place& place) {
        constexpr double worth_a_test = 20;  // instructions; measured: a test of less costs what it saves
        constexpr double worth_halving = 60;
        uint op = node.operation->kernel_op;
        vec4 data(node.numbers.empty() ? 0.0f : node.numbers[0], 0, 0, 0);  // k of smooth folds
        SdfSupport bound = group[0]->support;
        double weight = 0;
        for (const SdfTree* child : group) {
            bound.box.lower = glm::min(bound.box.lower, child->support.box.lower);
            bound.box.upper = glm::max(bound.box.upper, child->support.box.upper);
            bound.slope = std::min(bound.slope, child->support.slope);
            weight += child->weight;
        }
        bool bounded = glm::any(glm::lessThan(bound.box.upper - bound.box.lower, dvec3(ENDLESS)));
        bool intersects = op == kernels::SDF_OP_MAX || op == kernels::SDF_OP_SMOOTH_MAX;
        bool skips = bounded && !intersects && weight > worth_a_test;
        std::size_t skip = ops_.size();
        if (skips) {
            bool unites = op == kernels::SDF_OP_MIN || op == kernels::SDF_OP_SMOOTH_MIN;
            auto [centre, half] = centre_and_half(bound.box);
            add(unites ? kernels::SDF_OP_SKIP_UNION : kernels::SDF_OP_SKIP_SUBTRACT, 0, total, place.point,
                vec4(centre - vec3(place.shift), data.x), vec4(half, bound.slope * (1 - 1e-5)));
        }
        if (skips && group.size() > 1 && weight > worth_halving) {
            if (op == kernels::SDF_OP_MIN || op == kernels::SDF_OP_SUBTRACT) sort_along_longest_axis(group);
            std::size_t half = group.size() / 2;
            emit_group(node, group.first(half), total, place);
            emit_group(node, group.subspan(half), total, place);
        } else {
            for (const SdfTree* child : group) {
                uint value = emit(*child, shared(place));
                add(op, total, total, value, data, vec4(0));
                values_.release(value);
            }
        }
        if (skips && !fault_) ops_[skip].target = static_cast<uint>(ops_.size() - skip - 1);
    }

    static void sort_along_longest_axis(std::span<const SdfTree*> group) {
        auto centre = [](const SdfTree* tree) { return centre_and_half(tree->support.box).first; };
        vec3 lower = centre(group[0]);
        vec3 upper = lower;
        for (const SdfTree* child : group) {
            lower = glm::min(lower, centre(child));
            upper = glm::max(upper, centre(child));
        }
        vec3 e = upper - lower;
        int axis = e.x >= e.y && e.x >= e.z ? 0 : (e.y >= e.z ? 1 : 2);
        std::stable_sort(group.begin(), group.end(),
                         [&](const SdfTree* a, const SdfTree* b) { return centre(a)[axis] < centre(b)[axis]; });
    }

    // In floats; edges without end become merely large, of size whose square is still a float.
    static std::pair<vec3, vec3> centre_and_half(const SdfBox& box) {
        vec3 centre(0);
        vec3 half(0);
        for (int axis = 0; axis < 3; axis++) {
            bool finite = box.lower[axis] > -ENDLESS && box.upper[axis] < ENDLESS;
            centre[axis] = finite ? static_cast<float>(0.5 * (box.lower[axis] + box.upper[axis])) : 0.0f;
            half[axis] = static_cast<float>(finite ? 0.5 * (box.upper[axis] - box.lower[axis]) : ENDLESS);
        }
        return {centre, half};
    }

    uint emit_repeat(const SdfTree& node, Place place) {
        const std::vector<float>& n = node.numbers;
        place = settle(place);
        vec4 period(1);
        vec4 extent(0);
        for (int axis = 0; axis < 3; axis++) {
            period[axis] = n[axis] == 0 ? 1.0f : n[axis];
            extent[axis] = sdf_repeat_extent(n, axis);
        }
        uint total = 0;
        bool first = true;
        for (uint corner = 0; corner < 8 && !fault_; corner++) {
            if (corner & node.nearest_axes) continue;
            period.w = static_cast<float>(corner | node.nearest_axes << 3);
            bool last = (corner | node.nearest_axes) == 7;
            Place cell = warp(place, node.far || !last, kernels::SDF_OP_REPEAT, period, extent);
            uint value = emit(node.children[0], cell);
            if (first) {
                total = value;
            } else {
                add(kernels::SDF_OP_MIN, total, total, value, vec4(0), vec4(0));
                values_.release(value);
            }
            first = false;
        }
        return node.far ? emit_far(node, place, total) : total;
    }

    uint emit_far(const SdfTree& node, const Place& place, uint value) {
        auto [centre, half] = centre_and_half(node.support.box);
        add(kernels::SDF_OP_FAR, value, value, place.point, vec4(centre, node.least), vec4(half, node.support.slope));
        release(place);
        return value;
    }

    std::vector<SdfOp> ops_;
    std::optional<std::string> fault_;
    Registers points_{kernels::SDF_POINT_REGISTERS};
    Registers values_{kernels::SDF_VALUE_REGISTERS};
};

std::string text_of(dvec3 v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x, v.y, v.z); }

}  // namespace

Result<SdfData> build_sdf(const SdfGeometry& geometry) {
    Result<SdfTree> resolved = resolve_sdf(geometry.root);
    if (!resolved) return resolved.error();
    SdfTree& tree = *resolved;
    SdfBox solid = tree.support.box;
    bool clipped = false;
    if (geometry.bounds) {
        SdfBox bounds = {dvec3(geometry.bounds->first), dvec3(geometry.bounds->second)};
        if (!glm::all(glm::lessThan(bounds.lower, bounds.upper)) || !is_finite(bounds)) {
            return Error{
                fmt::format("bounds go from {} to {}: they must be finite and the upper corner greater on every axis",
                            text_of(bounds.lower), text_of(bounds.upper))};
        }
        clipped = glm::any(glm::greaterThanEqual(bounds.lower, solid.lower)) ||
                  glm::any(glm::lessThanEqual(bounds.upper, solid.upper));
        SdfBox both = {glm::max(bounds.lower, solid.lower), glm::min(bounds.upper, solid.upper)};
        if (glm::any(glm::greaterThanEqual(both.lower, both.upper))) {
            return Error{fmt::format("bounds from {} to {} hold nothing of the solid, which lies between {} and {}",
                                     text_of(bounds.lower), text_of(bounds.upper), text_of(solid.lower),
                                     text_of(solid.upper))};
        }
        solid = both;
    } else if (!is_finite(solid)) {
        return Error{fmt::format("{}: the solid has no end ({} to {}): give the geometry bounds", geometry.root.op,
                                 text_of(solid.lower), text_of(solid.upper))};
    }

    // Bounds lie strictly outside of the solid: a ray that enters them is outside, whatever the rounding.
    double scale =
        glm::length(solid.upper - solid.lower) + glm::length(glm::max(glm::abs(solid.lower), glm::abs(solid.upper)));
    SdfBox outer = {solid.lower - dvec3(1e-5 * scale), solid.upper + dvec3(1e-5 * scale)};

    double lipschitz = sdf_lipschitz(tree, outer);
    Emitter emitter;
    uint value = emitter.emit(tree, Place());
    if (clipped && !emitter.fault()) {
        value = emitter.clip(value, {dvec3(geometry.bounds->first), dvec3(geometry.bounds->second)});
    }
    if (emitter.fault()) return Error{fmt::format("{}: {}", geometry.root.op, *emitter.fault())};

    SdfData data;
    data.ops = emitter.take_ops();
    data.sdf.lower = vec3(outer.lower);
    data.sdf.upper = vec3(outer.upper);
    data.sdf.op_first = 0;
    data.sdf.op_count = static_cast<uint>(data.ops.size());
    data.sdf.lipschitz = static_cast<float>(lipschitz * (1 + 1e-5));  // evaluated in floats
    data.sdf.result = value;
    data.sdf.longest_crawl = kernels::INFINITE;
    return data;
}

}  // namespace spinel
