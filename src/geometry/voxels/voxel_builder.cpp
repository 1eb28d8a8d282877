#include "geometry/voxels/voxel_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/random.h"

namespace spinel {
namespace {

// Waves as kernels/voxel_waves.h reads them. Each is shorter than the one before by a constant ratio and as high in
// proportion; directions are spread evenly by the golden ratio, the first straight on.
void append_waves(const VoxelWaves& waves, kernels::VoxelGrid& grid, std::vector<float>& floats) {
    constexpr double ratio = 0.77, golden = 0.6180339887498949, two_pi = 6.283185307179586;
    double amplitudes = 0, length = 1;
    for (int i = 0; i < waves.count; ++i, length *= ratio) amplitudes += length;
    const double scale = 0.5 * double(waves.height) / amplitudes;
    std::vector<float> table;
    double steepest = 0;
    length = double(waves.length);
    for (int i = 0; i < waves.count; ++i, length *= ratio) {
        const double k = two_pi / length, amplitude = scale * length / double(waves.length);
        const double aside = 2 * std::fmod(0.5 + golden * i, 1.0) - 1;
        const double angle = (double(waves.direction) + aside * double(waves.spread)) * two_pi / 360;
        const double random =
            kernels::hash_uint(kernels::uint(waves.seed) * 64u + kernels::uint(i)) * (1.0 / 4294967296.0);
        const double phase = two_pi * random - std::sqrt(double(waves.gravity) * k) * double(waves.time);
        for (const double x : {k * std::cos(angle), k * std::sin(angle), std::fmod(phase, two_pi), amplitude})
            table.push_back(float(x));
        steepest += k * amplitude;
    }
    // A hair below the top of the cell and above its floor, whatever the rounding.
    const double mean = 1 - 0.5 * double(waves.height) - 1e-4;
    grid.wave_first = std::uint32_t(floats.size());
    grid.wave_count = std::uint32_t(waves.count);
    for (const double x : {mean, mean + 0.5 * double(waves.height) + 1e-5, steepest * 1.0001})
        floats.push_back(float(x));
    floats.insert(floats.end(), table.begin(), table.end());
}

}  // namespace

float rounding_of(const VoxelGeometry& voxels, std::size_t palette) {
    if (voxels.rounding.empty()) return 0;
    if (voxels.rounding.size() == 1) return voxels.rounding[0];
    return palette <= voxels.rounding.size() ? voxels.rounding[palette - 1] : 0;
}

void append_shapes(const VoxelGeometry& voxels, kernels::VoxelGrid& grid, std::vector<float>& floats) {
    std::vector<float> shapes(voxels.tree->palette_maximum(), 0.0f);
    for (std::size_t i = 0; i < shapes.size(); ++i) shapes[i] = rounding_of(voxels, i + 1);
    if (voxels.waves)
        for (const int palette : voxels.waves->palette)
            if (std::size_t(palette) <= shapes.size()) shapes[std::size_t(palette - 1)] = -1;
    if (std::all_of(shapes.begin(), shapes.end(), [](float shape) { return shape == 0; })) return;
    grid.walk = kernels::VOXEL_WALK_SHAPES;
    grid.shape_first = std::uint32_t(floats.size());
    floats.insert(floats.end(), shapes.begin(), shapes.end());
    if (voxels.waves) append_waves(*voxels.waves, grid, floats);
}

void append_outlines(const VoxelOutlines& outlines, kernels::VoxelGrid& grid, std::vector<float>& floats) {
    grid.line_first = std::uint32_t(floats.size());
    for (const float x : {float(outlines.where), 0.5f * outlines.width, outlines.strength, outlines.color.x,
                          outlines.color.y, outlines.color.z})
        floats.push_back(x);
}

Result<kernels::VoxelGrid> append_sdf_voxels(const SdfVoxelGeometry& voxels, const kernels::Sdf& bounds,
                                             std::uint32_t sdf, std::vector<float>& floats) {
    const glm::dvec3 lower = glm::ceil(glm::dvec3(bounds.lower) / double(voxels.cell) - 0.5);
    const glm::dvec3 count = glm::floor(glm::dvec3(bounds.upper) / double(voxels.cell) - 0.5) - lower + 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(count[axis] >= 1)) return Error{"holds no cell: the bounds of the expression are thinner than one"};
        if (!(count[axis] <= VoxelTree::max_edge))
            return Error{
                fmt::format("is {:.0f} cells along an edge; at most {}: bound the expression or make `cell` larger",
                            count[axis], VoxelTree::max_edge)};
    }
    kernels::VoxelGrid grid = {};
    grid.size = ivec3(count);
    grid.walk = kernels::VOXEL_WALK_SDF;
    grid.reference_first = grid.shape_first = grid.wave_first = grid.line_first = kernels::NONE;
    grid.sdf = sdf;
    grid.sdf_origin = vec3(lower * double(voxels.cell));
    grid.sdf_cell = voxels.cell;
    grid.strata_first = std::uint32_t(floats.size());
    grid.strata_count = std::uint32_t(voxels.strata.size());
    floats.insert(floats.end(), voxels.strata.begin(), voxels.strata.end());
    return grid;
}

kernels::VoxelGrid append_voxels(const VoxelTree& tree, std::vector<kernels::VoxelNode>& nodes,
                                 std::vector<std::uint32_t>& words) {
    const VoxelTree::Arrays& arrays = tree.arrays();
    kernels::VoxelGrid grid = {};
    grid.size = tree.size();
    grid.level_count = std::uint32_t(tree.level_count());
    grid.root = arrays.root;
    grid.node_first = std::uint32_t(nodes.size());
    nodes.insert(nodes.end(), arrays.nodes.begin(), arrays.nodes.end());
    grid.palette_first = std::uint32_t(words.size());
    words.insert(words.end(), arrays.palettes.begin(), arrays.palettes.end());
    grid.reference_first = arrays.references.empty() ? kernels::NONE : std::uint32_t(words.size());
    words.insert(words.end(), arrays.references.begin(), arrays.references.end());
    grid.walk = kernels::VOXEL_WALK_TREE;
    grid.shape_first = grid.wave_first = grid.line_first = grid.sdf = kernels::NONE;
    return grid;
}

}  // namespace spinel
