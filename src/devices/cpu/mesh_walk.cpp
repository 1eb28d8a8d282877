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

// How nodes and leaves are stored: as WideUnit tells …
struct Gathered {
    static const float* at(const WideMesh& mesh, std::uint32_t place) { return mesh.units[place].lanes; }
    static std::uint32_t reference(const float* node, int child) { return bits(node[48 + child]); }
    static bool box(const float* node, int child, glm::vec3& lower, glm::vec3& upper) {
        for (int a = 0; a < 3; ++a) {
            lower[a] = node[16 * a + child];
            upper[a] = node[16 * a + 8 + child];
        }
        return lower.x <= upper.x;
    }
    static int triangle_count(const float*) { return 4; }
    static kernels::Triangle triangle(const float* block, int lane) { return triangle_of(block, lane); }
    static std::uint32_t index(const float* block, int lane) { return bits(block[36 + lane]); }
    static const float* next(const float* block) { return block + 8 * kernels::WIDE_BLOCK_UNITS; }
};

// … and as kernels/mesh_compact.h does.
struct Compact {
    static const float* at(const WideMesh& mesh, std::uint32_t place) {
        return mesh.units->lanes + std::size_t(place) * kernels::COMPACT_STEP;
    }
    static std::uint32_t reference(const float* node, int child) { return bits(node[16 + child]); }
    static bool box(const float* node, int child, glm::vec3& lower, glm::vec3& upper) {
        const std::uint32_t packed = bits(node[3]);
        const auto* const bytes = reinterpret_cast<const unsigned char*>(node + 4);
        for (int a = 0; a < 3; ++a) {
            const float step = std::bit_cast<float>(kernels::byte_of(packed, std::uint32_t(a)) << 23);
            lower[a] = kernels::multiply_add(float(bytes[16 * a + child]), step, node[a]);
            upper[a] = kernels::multiply_add(float(bytes[16 * a + 8 + child]), step, node[a]);
        }
        return kernels::byte_of(packed, 3) >> child & 1;
    }
    static std::uint32_t triangles(const float* block) { return kernels::byte_of(bits(block[0]), 0); }
    static std::uint32_t vertices(const float* block) { return kernels::byte_of(bits(block[0]), 1); }
    static int triangle_count(const float* block) { return int(triangles(block)); }
    static kernels::Triangle triangle(const float* block, int lane) {
        const std::uint32_t corners = bits(block[1 + lane / 2]) >> (lane % 2 * 16), count = vertices(block);
        const auto vertex = [&](int corner) {
            const float* const x = block + kernels::compact_rows(triangles(block)) + (corners >> (3 * corner) & 7u);
            return glm::vec3(x[0], x[count], x[2 * count]);
        };
        return {vertex(0), vertex(1), vertex(2)};
    }
    static const float* indices(const float* block) {
        return block + kernels::compact_indices(triangles(block), vertices(block));
    }
    static std::uint32_t index(const float* block, int lane) { return bits(indices(block)[lane]); }
    static const float* next(const float* block) { return indices(block) + triangles(block); }
};

// Calls visit(block, lane) for the triangles of all leaves that the ray meets, nearer
// ones sooner, while it is told to go on; `t_max` is read anew each time.
template <class Layout, class Visit>
void walk(const WideMesh& mesh, const Ray& ray, const float& t_max, const Visit& visit) {
    const glm::vec3 inverse = kernels::wide_inverse(ray.direction);
    const float padding = kernels::slab_padding(mesh.lower, mesh.upper, ray.origin);
    Entry stack[kernels::WIDE_STACK_SIZE];
    int size = 0;
    stack[size++] = {0, ray.t_min};
    while (size > 0) {
        const Entry entry = stack[--size];
        if (!(entry.enter <= t_max)) continue;
        const float* at = Layout::at(mesh, entry.reference & kernels::WIDE_UNIT_MASK);
        if (std::uint32_t blocks = entry.reference >> 28; blocks > 0) {
            for (; blocks > 0; --blocks, at = Layout::next(at))
                for (int lane = 0; lane < Layout::triangle_count(at); ++lane)
                    if (!visit(at, lane)) return;
            continue;
        }
        const int first = size;
        for (int i = 0; i < 8; ++i) {
            glm::vec3 lower, upper;
            if (!Layout::box(at, i, lower, upper)) continue;
            float enter = ray.t_min, leave = t_max;
            for (int a = 0; a < 3; ++a) {
                const float t0 = (lower[a] - padding - ray.origin[a]) * inverse[a];
                const float t1 = (upper[a] + padding - ray.origin[a]) * inverse[a];
                enter = std::max(enter, std::min(t0, t1));
                leave = std::min(leave, std::max(t0, t1));
            }
            if (!(enter <= leave)) continue;
            int place = size++;
            for (; place > first && stack[place - 1].enter < enter; --place) stack[place] = stack[place - 1];
            stack[place] = {Layout::reference(at, i), enter};
        }
    }
}

template <class Layout>
WideHit closest_portable(const WideMesh& mesh, const Ray& ray) {
    const kernels::TriangleRay sheared = kernels::triangle_ray(ray);
    kernels::TriangleHit best(ray.t_max, 0, 0);
    const float* nearest_block = nullptr;
    int nearest_lane = 0;
    walk<Layout>(mesh, ray, best.t, [&](const float* block, int lane) {
        const bool before = nearest_block && Layout::index(block, lane) < Layout::index(nearest_block, nearest_lane);
        const float limit = before ? kernels::next_above(best.t) : best.t;
        if (kernels::triangle_watertight(sheared, Layout::triangle(block, lane), ray.t_min, limit, best)) {
            nearest_block = block;
            nearest_lane = lane;
        }
        return true;
    });
    if (!nearest_block) return {ray.t_max, 0, 0, NONE};
    return {best.t, best.u, best.v, Layout::index(nearest_block, nearest_lane), nearest_block, nearest_lane};
}

template <class Layout>
bool any_portable(const WideMesh& mesh, const Ray& ray) {
    const kernels::TriangleRay sheared = kernels::triangle_ray(ray);
    kernels::TriangleHit unread(0, 0, 0);
    bool found = false;
    walk<Layout>(mesh, ray, ray.t_max, [&](const float* block, int lane) {
        found = kernels::triangle_watertight(sheared, Layout::triangle(block, lane), ray.t_min, ray.t_max, unread);
        return !found;
    });
    return found;
}

// cross(b − a, c − a), each component with the one of its products rounded that g++ rounds in kernels::mesh_report().
// Left to itself it would choose otherwise for one layout or the other, and normals would differ in last bits.
glm::vec3 normal_of(const kernels::Triangle& triangle) {
    const glm::vec3 e = triangle.b - triangle.a, f = triangle.c - triangle.a;
    return {kernels::multiply_add(-f.y, e.z, e.y * f.z), kernels::multiply_add(-f.z, e.x, e.z * f.x),
            kernels::multiply_add(e.x, f.y, -(f.x * e.y))};
}

}  // namespace

glm::vec3 wide_normal(const WideHit& hit) { return normal_of(Gathered::triangle(hit.block, hit.lane)); }
glm::vec3 compact_normal(const WideHit& hit) { return normal_of(Compact::triangle(hit.block, hit.lane)); }

WideHit wide_closest_portable(const WideMesh& mesh, const Ray& ray) { return closest_portable<Gathered>(mesh, ray); }
bool wide_any_portable(const WideMesh& mesh, const Ray& ray) { return any_portable<Gathered>(mesh, ray); }
WideHit compact_closest_portable(const WideMesh& mesh, const Ray& ray) { return closest_portable<Compact>(mesh, ray); }
bool compact_any_portable(const WideMesh& mesh, const Ray& ray) { return any_portable<Compact>(mesh, ray); }

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
WideHit compact_closest_avx2(const WideMesh& mesh, const Ray& ray);
bool compact_any_avx2(const WideMesh& mesh, const Ray& ray);
void wide_closest8_avx2(const WideMesh& mesh, const Ray* rays, unsigned lanes, WideHit* hits);  // mesh_packet_avx2.cpp
unsigned wide_any8_avx2(const WideMesh& mesh, const Ray* rays, unsigned lanes);

WideHit wide_closest(const WideMesh& mesh, const Ray& ray) {
    return has_avx2() ? wide_closest_avx2(mesh, ray) : wide_closest_portable(mesh, ray);
}
bool wide_any(const WideMesh& mesh, const Ray& ray) {
    return has_avx2() ? wide_any_avx2(mesh, ray) : wide_any_portable(mesh, ray);
}
WideHit compact_closest(const WideMesh& mesh, const Ray& ray) {
    return has_avx2() ? compact_closest_avx2(mesh, ray) : compact_closest_portable(mesh, ray);
}
bool compact_any(const WideMesh& mesh, const Ray& ray) {
    return has_avx2() ? compact_any_avx2(mesh, ray) : compact_any_portable(mesh, ray);
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
WideHit compact_closest(const WideMesh& mesh, const Ray& ray) { return compact_closest_portable(mesh, ray); }
bool compact_any(const WideMesh& mesh, const Ray& ray) { return compact_any_portable(mesh, ray); }

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
    const bool compact = scene.meshes.at[mesh].walk == MESH_WALK_COMPACT;
    if (any) {
        const bool found = compact ? compact_any(wide, ray) : wide_any(wide, ray);
        return {{TriangleHit(ray.t_max, 0, 0), found ? first : NONE}, vec3(0)};
    }
    const WideHit hit = compact ? compact_closest(wide, ray) : wide_closest(wide, ray);
    if (hit.triangle == NONE) return {{TriangleHit(hit.t, hit.u, hit.v), NONE}, vec3(0)};
    return {{TriangleHit(hit.t, hit.u, hit.v), first + hit.triangle}, compact ? compact_normal(hit) : wide_normal(hit)};
}
