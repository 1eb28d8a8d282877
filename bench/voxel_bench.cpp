// Rays against voxels, one thread: the sparse tree beside the plain 3D-DDA over a dense grid and beside NanoVDB, whose
// hierarchical DDA goes from node to node and, in a leaf, from voxel to voxel by the leaf's mask. Prints Mrays/s, their
// ratios to NanoVDB, bytes of topology for each voxel, build times, and how many rays each sees differently from ours.
//
// Usage: spinel_voxel_bench [MODEL.vox] [MESH.ply]    measures these besides the terrain; meshes become shells of 1024³

#include <nanovdb/util/HDDA.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <nanovdb/util/Ray.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "devices/cpu/voxel_walk.h"
#include "geometry/voxels/dense_walk.h"
#include "geometry/voxels/terrain.h"
#include "geometry/voxels/voxel_builder.h"
#include "geometry/voxels/voxelise.h"
#include "kernels/frame.h"
#include "kernels/voxels.h"
#include "spinel/formats.h"

namespace spinel {
namespace {

using kernels::Hit;
using kernels::Ray;

constexpr int edge = 1024;  // pixels of the primary picture

double cpu_seconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

// A number in [0, 1) for a ray and a dimension.
float uniform(std::uint32_t i, std::uint32_t dimension) {
    std::uint32_t h = i * 0x9e3779b9u ^ dimension * 0x85ebca6bu;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return float((h ^ h >> 16) >> 8) * 0x1p-24f;
}

struct View {
    vec3 from, at, up;
};

// Pixel by pixel in tiles of 8×8, and in those in blocks of 4×2, as a renderer asks for them.
std::vector<Ray> primary_rays(const View& view) {
    const vec3 forward = glm::normalize(view.at - view.from);
    const vec3 right = glm::normalize(glm::cross(forward, view.up)), up = glm::cross(right, forward);
    const float scale = std::tan(glm::radians(30.0f));
    std::vector<Ray> rays;
    for (int ty = 0; ty < edge; ty += 8)
        for (int tx = 0; tx < edge; tx += 8)
            for (int block = 0; block < 8; ++block)
                for (int i = 0; i < 8; ++i) {
                    const int x = tx + (block & 1) * 4 + (i & 3), y = ty + (block >> 1) * 2 + (i >> 2);
                    const vec2 p = scale * (2.0f * vec2(x + 0.5f, y + 0.5f) / float(edge) - 1.0f);
                    rays.push_back({view.from, 0, glm::normalize(forward + p.x * right - p.y * up), kernels::INFINITE});
                }
    return rays;
}

// One cosine-distributed bounce from every hit, 0.001 voxels off the face.
std::vector<Ray> diffuse_rays(const std::vector<Ray>& rays, const std::vector<Hit>& hits) {
    std::vector<Ray> bounced;
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
        if (!kernels::is_hit(hits[i])) continue;
        const float r = std::sqrt(uniform(i, 1)), phi = 2 * kernels::PI * uniform(i, 2);
        const vec3 local(r * std::cos(phi), r * std::sin(phi), std::sqrt(std::max(0.0f, 1 - r * r)));
        const kernels::Frame frame = kernels::make_frame(hits[i].normal);
        bounced.push_back({kernels::ray_at(rays[i], hits[i].t) + 0.001f * hits[i].normal, 0,
                           glm::normalize(kernels::to_world(frame, local)), kernels::INFINITE});
    }
    return bounced;
}

// ---------------------------------------------------------------------------------------------------------- the walks
struct World {
    std::vector<kernels::VoxelNode> nodes;
    std::vector<std::uint32_t> words;
    std::vector<kernels::VoxelGrid> grids;
    std::vector<kernels::Slot> slots;
    kernels::SceneView scene = {};

    explicit World(const VoxelTree& tree) : slots(tree.palette_maximum(), kernels::Slot{0, kernels::NONE}) {
        grids.push_back(append_voxels(tree, nodes, words));
        scene.voxel_nodes.at = nodes.data();
        scene.words.at = words.data();
        scene.voxel_grids.at = grids.data();
        scene.slots.at = slots.data();
    }
};

using NanoGrid = nanovdb::NanoGrid<nanovdb::ValueMask>;
using NanoRay = nanovdb::Ray<float>;

nanovdb::GridHandle<> nano_grid(const VoxelTree& tree) {
    openvdb::MaskGrid grid;
    tree.for_each_cube([&](ivec3 lower, int size, std::uint16_t) {
        const ivec3 upper = lower + (size - 1);
        grid.fill({openvdb::Coord(lower.x, lower.y, lower.z), openvdb::Coord(upper.x, upper.y, upper.z)}, true);
    });
    grid.tree().prune();
    return nanovdb::openToNanoVDB(grid);
}

// The first active voxel: from node to node by the hierarchical DDA, in a leaf from voxel to voxel by its mask.
template <class Accessor>
bool nano_first(const Ray& ray, const nanovdb::CoordBBox& box, const Accessor& accessor, ivec3& cell, float& t) {
    using nanovdb::Coord;
    const nanovdb::Vec3f o(ray.origin.x, ray.origin.y, ray.origin.z),
        d(ray.direction.x, ray.direction.y, ray.direction.z);
    NanoRay r(o, d);
    if (!r.clip(box)) return false;
    Coord ijk = nanovdb::RoundDown<Coord>(r.start());
    nanovdb::HDDA<NanoRay, Coord> hdda(r, int(accessor.getDim(ijk, r)));
    for (;;) {
        ijk = hdda.voxel();
        if (const auto* leaf = accessor.probeLeaf(ijk)) {
            hdda.update(r, 1);
            ijk = hdda.voxel();
            const Coord origin = leaf->origin();
            while ((ijk & ~7) == origin) {
                if (leaf->isActive(ijk)) {
                    cell = {ijk[0], ijk[1], ijk[2]};
                    t = hdda.time();
                    return true;
                }
                if (!hdda.step()) return false;
                ijk = hdda.voxel();
            }
            hdda.update(r, int(accessor.getDim(ijk, r)));
            continue;
        }
        if (accessor.isActive(ijk)) {  // a tile
            const nanovdb::Vec3f p = r(hdda.time());
            const Coord low = hdda.voxel();
            for (int i = 0; i < 3; ++i) cell[i] = std::clamp(int(std::floor(p[i])), low[i], low[i] + hdda.dim() - 1);
            t = hdda.time();
            return true;
        }
        if (!hdda.step()) return false;
        hdda.update(r, int(accessor.getDim(hdda.voxel(), r)));
    }
}

struct Walk {
    std::string name;
    std::function<void(const std::vector<Ray>&, std::vector<Hit>&)> trace;
    std::size_t stride = 1;  // slow ones trace every so many groups of eight
    double topology = 0;     // bytes
    double build = 0;        // s
};

double rays_per_second(const Walk& walk, const std::vector<Ray>& rays, std::vector<Hit>& hits) {
    std::vector<Ray> some;
    for (std::size_t i = 0; i + 8 <= rays.size(); i += 8 * walk.stride)
        some.insert(some.end(), rays.begin() + std::ptrdiff_t(i), rays.begin() + std::ptrdiff_t(i) + 8);
    hits.assign(some.size(), kernels::no_hit(kernels::INFINITE));
    std::vector<double> seconds;
    for (int i = 0; i < 3; ++i) {
        const double start = cpu_seconds();
        walk.trace(some, hits);
        seconds.push_back(cpu_seconds() - start);
    }
    std::sort(seconds.begin(), seconds.end());
    return double(some.size()) / seconds[1];
}

double differing(const std::vector<Hit>& ours, const std::vector<Hit>& theirs, std::size_t stride) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < theirs.size(); ++i) {
        const Hit& a = ours[i / 8 * 8 * stride + i % 8];
        count += kernels::is_hit(a) != kernels::is_hit(theirs[i]) || (kernels::is_hit(a) && a.cell != theirs[i].cell);
    }
    return double(count) / double(std::max<std::size_t>(1, theirs.size()));
}

template <class Build>
double seconds_of(const Build& build) {
    const auto start = std::chrono::steady_clock::now();
    build();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void run(const std::string& title, const VoxelTreePointer& tree, double build, const View& view) {
    const double count = double(tree->voxel_count());
    const World world(*tree);
    DenseVoxels dense;
    const double dense_build = seconds_of([&] { dense = dense_voxels(*tree); });
    nanovdb::GridHandle<> nano;
    const double nano_build = seconds_of([&] { nano = nano_grid(*tree); });
    const NanoGrid& grid = *nano.grid<nanovdb::ValueMask>();
    const nanovdb::CoordBBox box = grid.tree().bbox();

    const auto scalar = [](const auto& closest) {
        return [closest](const std::vector<Ray>& rays, std::vector<Hit>& hits) {
            for (std::size_t i = 0; i < rays.size(); ++i) {
                Hit hit = kernels::no_hit(rays[i].t_max);
                closest(rays[i], hit);
                if (hit.t < rays[i].t_max) hit.instance = 0;
                hits[i] = hit;
            }
        };
    };
    const VoxelTreeMemory memory = tree->memory();
    std::vector<Walk> walks = {
        {"64-tree, kernel", scalar([&](const Ray& r, Hit& hit) { kernels::voxels_closest(world.scene, 0, 0, r, hit); }),
         1, double(memory.node_bytes + memory.reference_bytes), build},
        {"64-tree, 1 ray", scalar([&](const Ray& r, Hit& hit) { cpu_voxels_closest(world.scene, 0, 0, r, hit); }), 1,
         double(memory.node_bytes + memory.reference_bytes), build},
        {"dense 3D-DDA", scalar([&](const Ray& r, Hit& hit) { dense_closest(world.scene, dense, 0, r, hit); }), 8,
         double(dense.cells.size()), dense_build},
        {"NanoVDB, leaf mask",
         [&](const std::vector<Ray>& rays, std::vector<Hit>& hits) {
             const auto accessor = grid.getAccessor();
             for (std::size_t i = 0; i < rays.size(); ++i) {
                 Hit hit = kernels::no_hit(rays[i].t_max);
                 if (nano_first(rays[i], box, accessor, hit.cell, hit.t)) hit.instance = 0;
                 hits[i] = hit;
             }
         },
         1, double(nano.size()), nano_build}};

    const std::vector<Ray> primary = primary_rays(view);
    std::vector<Hit> primary_hits(primary.size()), diffuse_hits, theirs;
    walks[0].trace(primary, primary_hits);
    const std::vector<Ray> diffuse = diffuse_rays(primary, primary_hits);
    diffuse_hits.resize(diffuse.size());
    walks[0].trace(diffuse, diffuse_hits);

    std::printf("\n%s: %d×%d×%d, %.4g voxels; %zu primary rays, %zu diffuse\n", title.c_str(), tree->size().x,
                tree->size().y, tree->size().z, count, primary.size(), diffuse.size());
    struct Row {
        double primary, diffuse, primary_off, diffuse_off;
    };
    std::vector<Row> rows;
    for (const Walk& walk : walks) {
        Row row;
        row.primary = 1e-6 * rays_per_second(walk, primary, theirs);
        row.primary_off = differing(primary_hits, theirs, walk.stride);
        row.diffuse = 1e-6 * rays_per_second(walk, diffuse, theirs);
        row.diffuse_off = differing(diffuse_hits, theirs, walk.stride);
        rows.push_back(row);
    }
    const Row& base = rows.back();
    std::printf("%-20s %9s %9s %7s %7s %10s %9s %9s\n", "", "primary", "diffuse", "ratio", "ratio", "B/voxel",
                "build s", "differ");
    for (std::size_t i = 0; i < walks.size(); ++i)
        std::printf("%-20s %9.3f %9.3f %7.2f %7.2f %10.4f %9.3f %8.4f%%\n", walks[i].name.c_str(), rows[i].primary,
                    rows[i].diffuse, rows[i].primary / base.primary, rows[i].diffuse / base.diffuse,
                    walks[i].topology / count, walks[i].build,
                    100 * std::max(rows[i].primary_off, rows[i].diffuse_off));
    VoxelTreePointer once;
    const double share = seconds_of([&] { once = with_shared_subtrees(*tree); });
    const VoxelTreeMemory m = once->memory();
    std::printf("palette indices %.4f B/voxel; shared in %.2f s: topology %.4f, palette indices %.4f B/voxel\n",
                double(memory.palette_bytes) / count, share, double(m.node_bytes + m.reference_bytes) / count,
                double(m.palette_bytes) / count);
}

// The voxels of a model, whatever their material, as seen from above a corner.
void run_model(const std::filesystem::path& path) {
    const Result<Scene> scene = load_scene(path);
    if (!scene) return std::printf("%s\n", scene.error().message.c_str()), void();
    for (const Geometry& geometry : scene->geometries) {
        const auto* voxels = std::get_if<VoxelGeometry>(&geometry.data);
        if (!voxels) continue;
        std::vector<VoxelPoint> points;
        voxels->tree->for_each([&](ivec3 cell, std::uint16_t) { points.push_back({cell, 1}); });
        const ivec3 size = voxels->tree->size();
        VoxelTreePointer tree;
        const double build = seconds_of([&] { tree = *build_voxel_tree(size, points); });
        const vec3 center = 0.5f * vec3(size);
        run(path.filename().string(), tree, build,
            {center + 0.75f * glm::length(vec3(size)) * glm::normalize(vec3(0.6f, -1, 0.5f)), center, {0, 0, 1}});
        return;
    }
}

void run_mesh(const std::filesystem::path& path) {
    const Result<Scene> scene = load_scene(path);
    if (!scene) return std::printf("%s\n", scene.error().message.c_str()), void();
    for (const Geometry& geometry : scene->geometries) {
        const auto* mesh = std::get_if<MeshGeometry>(&geometry.data);
        if (!mesh || mesh->triangles.size() < 100) continue;
        VoxelTreePointer tree;
        const double build = seconds_of([&] { tree = voxelise_surface(*mesh, 1024)->tree; });
        const vec3 center = 0.5f * vec3(tree->size());
        run(path.filename().string() + " as a shell", tree, build,
            {center + 0.8f * glm::length(vec3(tree->size())) * glm::normalize(vec3(0.3f, 0.3f, 1)), center, {0, 1, 0}});
        return;
    }
}

void run_terrain() {
    VoxelTreePointer tree;
    const double build = seconds_of([&] { tree = *build_terrain({1024, 256, 1024}, false); });
    run("terrain", tree, build, {{120.3f, 205.7f, 90.2f}, {600, 60, 640}, {0, 1, 0}});
}

}  // namespace
}  // namespace spinel

int main(int argc, char** argv) {
    openvdb::initialize();
    spinel::run_terrain();
    for (int i = 1; i < argc; ++i) {
        const std::filesystem::path path = argv[i];
        if (path.extension() == ".vox") spinel::run_model(path);
        else spinel::run_mesh(path);
    }
}
