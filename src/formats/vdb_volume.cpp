#include "formats/vdb_volume.h"

#include <fmt/format.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "formats/file_bytes.h"
#include "formats/volume_scene.h"
#include "scene/validate.h"

namespace spinel {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

float component(float v, int) { return v; }
float component(double v, int) { return float(v); }
template <class T>
float component(const openvdb::math::Vec3<T>& v, int i) {
    return float(v[i]);
}

// The bricks of a grid from `origin` on, which is a multiple of 8, so that bricks are OpenVDB's leaves.
template <class GridType>
BrickFiller bricks_of(const GridType& grid, Coord origin, int channels) {
    return [&grid, origin, channels](ivec3 lower, std::span<float> samples) {
        const Coord first = origin.offsetBy(lower.x, lower.y, lower.z);
        constexpr auto volume = GridSamples::brick_volume;
        if (const auto* leaf = grid.tree().probeConstLeaf(first)) {
            for (int c = 0; c < channels; ++c)
                for (openvdb::Index i = 0; i < volume; ++i) {
                    // A leaf runs z fastest.
                    const std::size_t x = i & 7, y = i >> 3 & 7, z = i >> 6;
                    samples[std::size_t(c) * volume + i] =
                        component(leaf->getValue(openvdb::Index(x << 6 | y << 3 | z)), c);
                }
            return 0;
        }
        const auto value = grid.tree().getValue(first);  // a tile, or the background
        for (int c = 0; c < channels; ++c) samples[std::size_t(c) * volume] = component(value, c);
        constexpr int tile_edges[] = {4096, 4096, 128, 8};  // at the depths −1 (background), 0, 1, 2
        const int edge = tile_edges[grid.tree().getValueDepth(first) + 1];
        return (edge - (first.x() & (edge - 1))) / GridSamples::brick_edge;
    };
}

class VolumeReader {
  public:
    VolumeReader(const std::filesystem::path& path, const LoadOptions& options) : path_(path), options_(options) {}

    Result<Scene> read() {
        openvdb::initialize();
        std::ifstream file(path_, std::ios::binary);
        file.exceptions(std::ios::failbit | std::ios::badbit);
        const openvdb::GridPtrVecPtr grids = openvdb::io::Stream(file, false).getGrids();
        for (const openvdb::GridBase::Ptr& grid : *grids)
            if (Result<void> added = add(grid); !added) return added.error();
        tell_apart(grids_);
        if (!options_.grid.empty()) {
            std::string names;
            for (const Grid& grid : grids_) names += (names.empty() ? "'" : ", '") + grid.name + "'";
            std::erase_if(grids_, [&](const Grid& grid) { return grid.name != options_.grid; });
            if (grids_.empty() && !names.empty())
                return cannot_read(path_, fmt::format("it has no grid '{}'; it has {}", options_.grid, names));
        }
        if (grids_.empty())
            return cannot_read(path_, left_out_.empty() ? "none of its grids has an active voxel" : left_out_.front());
        Scene scene = volume_scene(std::move(grids_), {});
        scene.notes = std::move(left_out_);
        return scene;
    }

  private:
    Error refused(const openvdb::GridBase& grid, const std::string& why) const {
        return cannot_read(path_, fmt::format("its grid '{}' {}", grid.getName(), why));
    }

    Result<void> add(const openvdb::GridBase::Ptr& base) {
        using namespace openvdb;
        if (const auto grid = gridPtrCast<FloatGrid>(base)) return add_scalar(*grid);
        if (const auto grid = gridPtrCast<DoubleGrid>(base)) return add_scalar(*grid);
        if (const auto grid = gridPtrCast<Vec3SGrid>(base)) return add_samples(*grid, 3);
        if (const auto grid = gridPtrCast<Vec3DGrid>(base)) return add_samples(*grid, 3);
        left_out_.push_back(fmt::format("its grid '{}' {}", base->getName(),
                                        base->type().find("ptdata") != std::string::npos
                                            ? "holds points, which are not read"
                                            : "of type " + base->type() + " is left out"));
        return {};
    }

    template <class GridType>
    Result<void> add_scalar(const GridType& grid) {
        return add_samples(grid, 1, grid.getGridClass() == openvdb::GRID_LEVEL_SET);
    }

    template <class GridType>
    Result<void> add_samples(const GridType& grid, int channels, bool level_set = false) {
        if (!grid.transform().isLinear()) return refused(grid, "has a transform that is not affine");
        const CoordBBox box = grid.evalActiveVoxelBoundingBox();
        if (box.empty()) {
            left_out_.push_back(fmt::format("its grid '{}' has no active voxel", grid.getName()));
            return {};
        }
        // A sample more all around: beyond what is active, values fall to the background.
        const Coord origin = box.min().offsetBy(-1) & ~7;
        ivec3 size(0);
        for (int i = 0; i < 3; ++i)
            size[i] = int(std::min<std::int64_t>(std::int64_t(box.max()[i]) - origin[i] + 2, 1 << 30));
        Result<GridPointer> samples = build_grid(size, channels, bricks_of(grid, origin, channels));
        if (!samples) return refused(grid, samples.error().message);
        Grid read;
        read.name = grid.getName().empty() ? path_.stem().string() : grid.getName();
        read.samples = *samples;
        read.background = component(grid.background(), 0);
        read.level_set = level_set;
        const openvdb::Vec3d corner = origin.asVec3d() - 0.5, at = grid.indexToWorld(corner);
        for (int axis = 0; axis < 3; ++axis) {
            openvdb::Vec3d step = corner;
            step[axis] += 1;
            const openvdb::Vec3d column = grid.indexToWorld(step) - at;
            read.index_to_local[axis] = vec3(column[0], column[1], column[2]);
        }
        read.index_to_local[3] = vec3(at[0], at[1], at[2]);
        if (const auto fault = transform_fault(read.index_to_local)) return refused(grid, *fault);
        if (!std::isfinite(read.background)) read.background = 0;
        grids_.push_back(std::move(read));
        return {};
    }

    const std::filesystem::path& path_;
    const LoadOptions& options_;
    std::vector<Grid> grids_;
    std::vector<std::string> left_out_;
};

}  // namespace

Result<Scene> read_vdb_volumes(const std::filesystem::path& path, const LoadOptions& options) {
    return VolumeReader(path, options).read();
}

}  // namespace spinel
