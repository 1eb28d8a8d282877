// The walk through wide hierarchies without instructions that a machine may lack, and the choice between it and AVX2.
#include "devices/cpu/mesh_walk.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "devices/cpu/avx2.h"
#include "kernels/mesh.h"

namespace spinel {

using kernels::NONE;
using kernels::Ray;

namespace {

WideMesh wide_mesh_of(const kernels::SceneView& scene, kernels::uint mesh) {
    const kernels::Mesh& m = scene.meshes.at[mesh];
    return {scene.wide_units.at + m.node_first, m.lower, m.upper};
}

struct Entry {
    std::uint32_t reference;
    float enter;
};

std::uint32_t bits(float x) { return std::bit_cast<std::uint32_t>(x); }

kernels::Triangle triangle_of(const float* block, int lane) {
    const auto vertex = [&](int v) {
        return glm::vec3(block[12 * v + lane], block[12 * v + 4 + lane], block[12 * v + 8 + lane]);
    };
    return {vertex(0), vertex(1), vertex(2)};
}

// Calls visit(block, lane) for the triangles of all leaves that the ray meets, nearer
// ones sooner, while it is told to go on; `t_max` is read anew each time.
template <class Visit>
void walk(const WideMesh& mesh, const Ray& ray, const float& t_max, const Visit& visit) {
    const glm::vec3 inverse = kernels::wide_inverse(ray.direction);
    const float padding = kernels::slab_padding(mesh.lower, mesh.upper, ray.origin);
    Entry stack[kernels::WIDE_STACK_SIZE];
    int size = 0;
    stack[size++] = {0, ray.t_min};
    while (size > 0) {
        const Entry entry = stack[--size];
        if (!(entry.enter <= t_max)) continue;
        const kernels::WideUnit* const unit = mesh.units + (entry.reference & kernels::WIDE_UNIT_MASK);
        if (const std::uint32_t blocks = entry.reference >> 28; blocks > 0) {
            for (std::uint32_t b = 0; b < blocks; ++b) {
                const float* const block = unit[b * kernels::WIDE_BLOCK_UNITS].lanes;
                for (int lane = 0; lane < 4; ++lane)
                    if (!visit(block, lane)) return;
            }
            continue;
        }
        const int first = size;
        for (int i = 0; i < 8; ++i) {
            float enter = ray.t_min, leave = t_max;
            for (int a = 0; a < 3; ++a) {
                const float t0 = (unit[2 * a].lanes[i] - padding - ray.origin[a]) * inverse[a];
                const float t1 = (unit[2 * a + 1].lanes[i] + padding - ray.origin[a]) * inverse[a];
                enter = std::max(enter, std::min(t0, t1));
                leave = std::min(leave, std::max(t0, t1));
            }
            if (!(enter <= leave) || !(unit[0].lanes[i] <= unit[1].lanes[i])) continue;
            int at = size++;
            for (; at > first && stack[at - 1].enter < enter; --at) stack[at] = stack[at - 1];
            stack[at] = {bits(unit[6].lanes[i]), enter};
        }
    }
}

}  // namespace

glm::vec3 wide_normal(const WideHit& hit) {
    const kernels::Triangle triangle = triangle_of(hit.block, hit.lane);
    return glm::cross(triangle.b - triangle.a, triangle.c - triangle.a);
}

WideHit wide_closest_portable(const WideMesh& mesh, const Ray& ray) {
    const kernels::TriangleRay sheared = kernels::triangle_ray(ray);
    kernels::TriangleHit best(ray.t_max, 0, 0);
    const float* nearest_block = nullptr;
    int nearest_lane = 0;
    walk(mesh, ray, best.t, [&](const float* block, int lane) {
        const bool before = nearest_block && bits(block[36 + lane]) < bits(nearest_block[36 + nearest_lane]);
        const float limit = before ? kernels::next_above(best.t) : best.t;
        if (kernels::triangle_watertight(sheared, triangle_of(block, lane), ray.t_min, limit, best)) {
            nearest_block = block;
            nearest_lane = lane;
        }
        return true;
    });
    if (!nearest_block) return {ray.t_max, 0, 0, NONE};
    return {best.t, best.u, best.v, bits(nearest_block[36 + nearest_lane]), nearest_block, nearest_lane};
}

bool wide_any_portable(const WideMesh& mesh, const Ray& ray) {
    const kernels::TriangleRay sheared = kernels::triangle_ray(ray);
    kernels::TriangleHit unread(0, 0, 0);
    bool found = false;
    walk(mesh, ray, ray.t_max, [&](const float* block, int lane) {
        found = kernels::triangle_watertight(sheared, triangle_of(block, lane), ray.t_min, ray.t_max, unread);
        return !found;
    });
    return found;
}

namespace {

void closest_one_by_one(const WideMesh& mesh, const Ray* rays, unsigned lanes, WideHit* hits) {
    for (; lanes; lanes &= lanes - 1) {
        const int i = std::countr_zero(lanes);
        hits[i] = wide_closest_portable(mesh, rays[i]);
    }
}

unsigned any_one_by_one(const WideMesh& mesh, const Ray* rays, unsigned lanes) {
    unsigned found = 0;
    for (; lanes; lanes &= lanes - 1) {
        const int i = std::countr_zero(lanes);
        found |= unsigned(wide_any_portable(mesh, rays[i])) << i;
    }
    return found;
}

}  // namespace

#ifdef SPINEL_AVX2

WideHit wide_closest_avx2(const WideMesh& mesh, const Ray& ray);  // mesh_walk_avx2.cpp
bool wide_any_avx2(const WideMesh& mesh, const Ray& ray);
void wide_closest8_avx2(const WideMesh& mesh, const Ray* rays, unsigned lanes, WideHit* hits);  // mesh_packet_avx2.cpp
unsigned wide_any8_avx2(const WideMesh& mesh, const Ray* rays, unsigned lanes);

WideHit wide_closest(const WideMesh& mesh, const Ray& ray) {
    return has_avx2() ? wide_closest_avx2(mesh, ray) : wide_closest_portable(mesh, ray);
}
bool wide_any(const WideMesh& mesh, const Ray& ray) {
    return has_avx2() ? wide_any_avx2(mesh, ray) : wide_any_portable(mesh, ray);
}

void wide_closest8(const WideMesh& mesh, const Ray* rays, unsigned lanes, WideHit* hits) {
    if (has_avx2()) return wide_closest8_avx2(mesh, rays, lanes, hits);
    closest_one_by_one(mesh, rays, lanes, hits);
}
unsigned wide_any8(const WideMesh& mesh, const Ray* rays, unsigned lanes) {
    return has_avx2() ? wide_any8_avx2(mesh, rays, lanes) : any_one_by_one(mesh, rays, lanes);
}

namespace {
bool has_packets() { return has_avx2(); }
}  // namespace

#else

WideHit wide_closest(const WideMesh& mesh, const Ray& ray) { return wide_closest_portable(mesh, ray); }
bool wide_any(const WideMesh& mesh, const Ray& ray) { return wide_any_portable(mesh, ray); }

void wide_closest8(const WideMesh& mesh, const Ray* rays, unsigned lanes, WideHit* hits) {
    closest_one_by_one(mesh, rays, lanes, hits);
}
unsigned wide_any8(const WideMesh& mesh, const Ray* rays, unsigned lanes) { return any_one_by_one(mesh, rays, lanes); }

namespace {
bool has_packets() { return false; }
}  // namespace

#endif

bool walks_in_packets(const kernels::Mesh& mesh) {
    return has_packets() && mesh.walk == kernels::MESH_WALK_WIDE &&
           mesh.triangle_test == kernels::TRIANGLE_WATERTIGHT && mesh.triangle_count > 0;
}

unsigned cpu_mesh_closest8(const kernels::SceneView& scene, kernels::uint mesh, kernels::uint instance, const Ray* rays,
                           unsigned lanes, kernels::Hit* hits) {
    WideHit nearest[packet_size];
    wide_closest8(wide_mesh_of(scene, mesh), rays, lanes, nearest);
    const kernels::uint first = scene.meshes.at[mesh].triangle_first;
    unsigned found = 0;
    for (unsigned rest = lanes; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        const WideHit& hit = nearest[i];
        if (hit.triangle == NONE) continue;
        kernels::mesh_report_normal(scene, mesh, {{hit.t, hit.u, hit.v}, first + hit.triangle}, wide_normal(hit),
                                    hits[i]);
        hits[i].instance = instance;
        found |= 1u << i;
    }
    return found;
}

unsigned cpu_mesh_any8(const kernels::SceneView& scene, kernels::uint mesh, const Ray* rays, unsigned lanes) {
    return wide_any8(wide_mesh_of(scene, mesh), rays, lanes);
}

}  // namespace spinel

// The device's walk, as kernels/mesh_wide.h declares it.
spinel::kernels::WideNearest spinel::kernels::device_mesh_wide(const SceneView& scene, uint mesh, Ray ray, bool any) {
    const WideMesh wide = wide_mesh_of(scene, mesh);
    const uint first = scene.meshes.at[mesh].triangle_first;
    if (any) return {{TriangleHit(ray.t_max, 0, 0), wide_any(wide, ray) ? first : NONE}, vec3(0)};
    const WideHit hit = wide_closest(wide, ray);
    if (hit.triangle == NONE) return {{TriangleHit(hit.t, hit.u, hit.v), NONE}, vec3(0)};
    return {{TriangleHit(hit.t, hit.u, hit.v), first + hit.triangle}, wide_normal(hit)};
}
