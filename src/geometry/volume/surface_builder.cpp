#include "geometry/volume/surface_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/parallel.h"
#include "core/pool.h"
#include "kernels/sdf.h"
#include "kernels/sdf_grid.h"
#include "kernels/sdf_ops.h"

namespace spinel {
namespace {

using kernels::SdfOp;
using kernels::uint;

enum class Side : std::uint8_t { outside, inside, both };

constexpr std::size_t most_cells = std::size_t(1) << 27;  // nine bytes for each while they are sorted out

// The coarse cells of a grid's box, x fastest.
class Cells {
  public:
    explicit Cells(ivec3 size) : size_(size) {}
    std::size_t count() const { return std::size_t(size_.x) * std::size_t(size_.y) * std::size_t(size_.z); }
    std::size_t index(ivec3 c) const {
        return std::size_t(c.x) + std::size_t(size_.x) * (std::size_t(c.y) + std::size_t(size_.y) * std::size_t(c.z));
    }
    // In order of their indices, or against it.
    template <class Visit>
    void each(bool backwards, const Visit& visit) const {
        for (int z = 0; z < size_.z; ++z)
            for (int y = 0; y < size_.y; ++y)
                for (int x = 0; x < size_.x; ++x) {
                    const ivec3 c(x, y, z);
                    visit(backwards ? size_ - 1 - c : c);
                }
    }
    bool has(ivec3 c) const {
        return glm::all(glm::greaterThanEqual(c, ivec3(0))) && glm::all(glm::lessThan(c, size_));
    }

  private:
    ivec3 size_;
};

std::vector<Side> sides_of(const VolumeGeometry& volume, const kernels::DensityGrid& grid,
                           const std::vector<float>& floats, std::size_t count) {
    std::vector<Side> sides(count);
    for (std::size_t i = 0; i < count; ++i) {
        float least = floats[grid.minorant_first + i] - volume.level,
              most = floats[grid.majorant_first + i] - volume.level;
        if (volume.solid_above) std::tie(least, most) = std::pair(-most, -least);
        sides[i] = least >= 0 ? Side::outside : most < 0 ? Side::inside : Side::both;
    }
    return sides;
}

// How many cells away the nearest one is that the surface may cross, a diagonal step counting as one: two sweeps, each
// by the half of a cell's 26 neighbours that it has passed (Rosenfeld and Pfaltz, "Sequential Operations in Digital
// Picture Processing", JACM 13(4), 1966).
std::vector<uint> steps_to_surface(const Cells& cells, const std::vector<Side>& sides) {
    constexpr uint far = 1u << 20;
    std::vector<uint> steps(sides.size());
    for (std::size_t i = 0; i < sides.size(); ++i) steps[i] = sides[i] == Side::both ? 0 : far;
    for (const bool backwards : {false, true})
        cells.each(backwards, [&](ivec3 c) {
            uint& least = steps[cells.index(c)];
            for (int n = 0; n < 13; ++n) {
                const ivec3 before(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
                const ivec3 there = backwards ? c - before : c + before;
                if (cells.has(there)) least = std::min(least, steps[cells.index(there)] + 1);
            }
        });
    return steps;
}

// The square of the Lipschitz bound over the look-ups in a coarse cell, by the samples that they read.
double steepness(const kernels::SceneView& view, const kernels::DensityGrid& grid, ivec3 cell) {
    const int reach = grid.filter_kind == kernels::FILTER_TRICUBIC ? 2 : 1;
    const ivec3 last = grid.size - 1;
    const ivec3 lower = glm::max(cell * grid.majorant_cell - reach, ivec3(0));
    const ivec3 upper = glm::min((cell + 1) * grid.majorant_cell - 1 + reach, last);
    vec3 most(0);
    for (int z = lower.z; z <= upper.z; ++z)
        for (int y = lower.y; y <= upper.y; ++y)
            for (int x = lower.x; x <= upper.x; ++x) {
                const ivec3 i(x, y, z);
                const float value = kernels::grid_sample(view, grid, i, 0);
                for (int axis = 0; axis < 3; ++axis) {
                    ivec3 next = i;
                    if (++next[axis] > upper[axis]) continue;
                    most[axis] = std::max(most[axis], std::abs(kernels::grid_sample(view, grid, next, 0) - value));
                }
            }
    return glm::dot(glm::dvec3(most), glm::dvec3(most));
}

}  // namespace

Result<SdfData> build_surface(const VolumeGeometry& volume, const kernels::DensityGrid& record, uint grid,
                              std::vector<std::uint32_t>& words, const std::vector<float>& floats) {
    const Cells cells(record.majorant_size);
    if (cells.count() > most_cells)
        return Error{fmt::format("has {} coarse cells; a surface may have up to {}", cells.count(), most_cells)};
    const std::vector<Side> sides = sides_of(volume, record, floats, cells.count());
    const std::vector<uint> steps = steps_to_surface(cells, sides);
    const Result<uint> first =
        pool_place(words.size(), cells.count() + 1, "words of voxels, volumes, textures and tables");
    if (!first) return first.error();

    // Bounds by cells that hold any of the solid; what reaches the outermost samples ends there.
    const float edge = float(record.majorant_cell);
    const vec3 box_lower(0.5f), box_upper = vec3(record.size) - 0.5f;
    vec3 lower = box_upper, upper = box_lower;
    bool clipped = false;
    words.reserve(words.size() + cells.count() + 1);
    words.push_back(grid);
    cells.each(false, [&](ivec3 c) {
        const std::size_t i = cells.index(c);
        const uint clearance = steps[i] < 2 ? 0 : (steps[i] - 1) * uint(record.majorant_cell);
        words.push_back(clearance | (clearance > 0 && sides[i] == Side::inside ? kernels::SDF_GRID_INSIDE : 0));
        if (sides[i] == Side::outside) return;
        lower = glm::min(lower, vec3(c) * edge);
        upper = glm::max(upper, vec3(c + 1) * edge);
        clipped = clipped || glm::any(glm::equal(c, ivec3(0))) || glm::any(glm::equal(c, record.majorant_size - 1));
    });
    lower = glm::max(lower, box_lower);
    upper = glm::min(upper, box_upper);
    if (!glm::all(glm::lessThan(lower, upper)))
        return Error{fmt::format("has no sample {} its level, {}, and so no surface",
                                 volume.solid_above ? "above" : "below", volume.level)};

    kernels::SceneView view = {};
    view.words.at = words.data();
    std::vector<double> slab_steepness(std::size_t(record.majorant_size.z), 0);
    parallel_for(slab_steepness.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t z = begin; z < end; ++z)
            for (int y = 0; y < record.majorant_size.y; ++y)
                for (int x = 0; x < record.majorant_size.x; ++x)
                    if (const ivec3 c(x, y, int(z)); steps[cells.index(c)] < 2)
                        slab_steepness[z] = std::max(slab_steepness[z], steepness(view, record, c));
    });
    const double slope = std::sqrt(*std::max_element(slab_steepness.begin(), slab_steepness.end()));
    const auto unit = float((volume.solid_above ? -1 : 1) / (slope > 0 ? slope : 1.0));
    if (!std::isnormal(unit)) return Error{"differs too little or too much between samples to have a surface"};

    SdfData data;
    data.ops.push_back(SdfOp(kernels::SDF_OP_GRID, 0, 0, *first, vec4(volume.level, unit, 0, 0), vec4(0)));
    if (clipped) {
        data.ops.push_back(SdfOp(kernels::SDF_OP_BOX, 1, 0, 0, vec4(0.5f * (box_upper - box_lower), 0),
                                 vec4(0.5f * (box_lower + box_upper), 0)));
        data.ops.push_back(SdfOp(kernels::SDF_OP_MAX, 0, 0, 1, vec4(0), vec4(0)));
    }
    // Bounds lie strictly outside of the solid, as those of expressions.
    const float margin = 1e-5f * (glm::length(upper - lower) + glm::length(upper));
    data.sdf.lower = lower - margin;
    data.sdf.upper = upper + margin;
    data.sdf.op_first = 0;
    data.sdf.op_count = uint(data.ops.size());
    data.sdf.lipschitz = 1 + 1e-5f;  // evaluated in floats
    data.sdf.result = 0;
    // What is thinner may be stepped over at a grazing angle: half a sample, or more where a ray that crawls all the
    // way through would come to the bound on steps.
    data.sdf.longest_crawl = std::max(0.5f, glm::length(upper - lower) / (0.75f * float(kernels::SDF_MAX_STEPS)));
    return data;
}

}  // namespace spinel
