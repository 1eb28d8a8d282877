// No ray gets out of a closed mesh: millions of rays from inside of scanned ones, for every structure.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <mutex>

#include "core/parallel.h"
#include "geometry/mesh/mesh_structures.h"
#include "geometry/scanned_meshes.h"
#include "geometry/test_scene.h"
#include "kernels/traverse.h"

namespace spinel::closed_mesh_test {
namespace {

using namespace test;

// How often the surface winds about a point, from the solid angles of its triangles: van Oosterom and Strackee 1983.
double winding_number(const MeshGeometry& mesh, const glm::dvec3& p) {
    double sum = 0;
    for (const uvec3& t : mesh.triangles) {
        const glm::dvec3 a = glm::dvec3(mesh.positions[t.x]) - p, b = glm::dvec3(mesh.positions[t.y]) - p,
                         c = glm::dvec3(mesh.positions[t.z]) - p;
        const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
        sum += 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                              la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
    }
    return sum / (4 * M_PI);
}

std::vector<vec3> points_inside(const MeshGeometry& mesh, std::size_t count) {
    vec3 lower = mesh.positions[0], upper = lower;
    for (const vec3& p : mesh.positions) lower = glm::min(lower, p), upper = glm::max(upper, p);
    Random random(1);
    std::vector<vec3> points;
    for (int i = 0; i < 4000 && points.size() < count; ++i) {
        const vec3 p = glm::mix(lower, upper, 0.5f + 0.5f * random.in_cube());
        if (std::abs(winding_number(mesh, glm::dvec3(p))) > 0.5) points.push_back(p);
    }
    return points;
}

struct Model {
    const char* name;
    const char* file;
    std::optional<MeshGeometry> (*read)(const std::filesystem::path&);
};
const Model models[] = {{"bunny", "stanford/bun_zipper.ply.gz", read_gzipped_ply},
                        {"dragon", "stanford/dragon_vrip.ply.gz", read_gzipped_ply},
                        {"teapot", "common/teapot.obj", read_mesh}};

struct ClosedModel {
    MeshGeometry mesh;
    std::vector<vec3> inside;
};

// Closed and searched once for all tests; null without the file.
const ClosedModel* closed_model(const Model& model) {
    static std::map<std::string, ClosedModel> known;
    if (const auto at = known.find(model.name); at != known.end()) return &at->second;
    const auto open = model.read(mesh_folder / model.file);
    if (!open) return nullptr;
    ClosedModel& made = known[model.name];
    made.mesh = closed(*open);
    made.inside = points_inside(made.mesh, 24);
    return &made;
}

// A third of the rays go anywhere, a third to vertices, a third to points of edges.
void expect_nothing_escapes(const AcceleratorSettings& accelerator, std::size_t ray_count) {
    for (const Model& model : models) {
        SCOPED_TRACE(model.name);
        const ClosedModel* known = closed_model(model);
        if (!known) GTEST_SKIP() << "needs shared/data/mesh/" << model.file << " beside the source tree";
        const MeshGeometry& mesh = known->mesh;
        const std::vector<vec3>& origins = known->inside;
        ASSERT_GE(origins.size(), 8u);
        TestScene parts;
        parts.place(kernels::GEOMETRY_MESH, parts.add(mesh, accelerator));
        const kernels::SceneView& scene = parts.view();
        constexpr std::size_t chunk = 10000;
        std::atomic<std::size_t> escaped = 0;
        std::mutex mutex;
        std::string example;
        parallel_for(ray_count / chunk, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c) {
                Random random(std::uint32_t(c) + 100);
                for (std::size_t i = 0; i < chunk; ++i) {
                    const vec3 origin = origins[random.below(std::uint32_t(origins.size()))];
                    const uvec3 t = mesh.triangles[random.below(std::uint32_t(mesh.triangles.size()))];
                    vec3 direction = random.awkward_direction();
                    if (i % 3 == 1) direction = mesh.positions[t.x] - origin;
                    if (i % 3 == 2)
                        direction = glm::mix(mesh.positions[t.x], mesh.positions[t.y], random.uniform(0, 1)) - origin;
                    const kernels::Ray r = ray(origin, direction);
                    const bool met = i % 2 ? kernels::trace_any(scene, r, kernels::TRACE_ALL)
                                           : kernels::is_hit(kernels::trace_closest(scene, r, kernels::TRACE_ALL));
                    if (met) continue;
                    ++escaped;
                    const std::lock_guard lock(mutex);
                    example = describe(r);
                }
            }
        });
        EXPECT_EQ(escaped, 0u) << "of " << ray_count << ", one is " << example;
    }
}

TEST(SlowClosedMeshes, keep_ten_million_rays_in) { expect_nothing_escapes({}, 10'000'000); }

TEST(SlowClosedMeshes, keep_ten_million_rays_in_the_compact_layout) {
    expect_nothing_escapes({"wide-bvh8-compact", "watertight"}, 10'000'000);
}

class SlowClosedMeshStructures : public testing::TestWithParam<std::size_t> {};

TEST_P(SlowClosedMeshStructures, keep_rays_in) {
    const char* structure = mesh_structures()[GetParam()].name;
    expect_nothing_escapes({structure, "watertight"}, 300'000);
    expect_nothing_escapes({structure, "watertight-indexed"}, 60'000);
}

INSTANTIATE_TEST_SUITE_P(All, SlowClosedMeshStructures, testing::Range(std::size_t(0), mesh_structures().size()),
                         [](const testing::TestParamInfo<std::size_t>& info) {
                             std::string name = mesh_structures()[info.param].name;
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

}  // namespace
}  // namespace spinel::closed_mesh_test
