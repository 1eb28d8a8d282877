#include "render/grid_stream.h"

#include <algorithm>
#include <mutex>
#include <numeric>

#include "core/parallel.h"
#include "kernels/grid_stream.h"
#include "kernels/traverse.h"

namespace spinel {
namespace {

using kernels::Hit;
using kernels::MeshRay;
using kernels::Ray;
using kernels::SceneView;
using kernels::StreamRay;
using kernels::uint;

constexpr std::size_t batch_size = 8192;    // rays that go together …
constexpr std::size_t waiting_room = 2048;  // … and how many of them test triangles in one pass

std::uint64_t spread(std::uint32_t x) {  // the lowest ten bits, two places between each
    std::uint64_t v = x & 0x3ffu;
    v = (v | v << 16) & 0x30000ffu;
    v = (v | v << 8) & 0x300f00fu;
    v = (v | v << 4) & 0x30c30c3u;
    return (v | v << 2) & 0x9249249u;
}

// Rays that begin close together and go the same way stand together: by octant of direction, then along a Morton curve.
std::vector<std::uint32_t> coherent_order(std::span<const Ray> rays) {
    glm::vec3 lower(kernels::INFINITE), upper(-kernels::INFINITE);
    for (const Ray& ray : rays) lower = glm::min(lower, ray.origin), upper = glm::max(upper, ray.origin);
    const glm::vec3 scale = 1023.0f / glm::max(upper - lower, glm::vec3(1e-30f));
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const glm::vec3& d = rays[i].direction;
        const glm::uvec3 p((rays[i].origin - lower) * scale);
        const std::uint64_t octant = std::uint64_t(d.x < 0) | std::uint64_t(d.y < 0) << 1 | std::uint64_t(d.z < 0) << 2;
        keys[i] = {octant << 30 | spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2, std::uint32_t(i)};
    }
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order(rays.size());
    for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].second;
    return order;
}

// One batch through one mesh, in its own space.
class Batch {
  public:
    Batch(const SceneView& scene, uint mesh, bool any) : scene_(scene), mesh_(mesh), any_(any) {}

    void add(std::uint32_t name, const Ray& local) {
        names_.push_back(name);
        rays_.push_back(kernels::mesh_ray(scene_, mesh_, local, any_, scene_.meshes.at[mesh_].triangle_test));
        states_.push_back(kernels::stream_begin(scene_, mesh_, rays_.back(), count_));
    }

    void run(std::vector<StreamPass>& passes) {
        std::vector<std::uint32_t> live(rays_.size()), waiting;
        std::iota(live.begin(), live.end(), 0u);
        for (std::size_t pass = 0; !live.empty(); ++pass) {
            for (const std::uint32_t i : live)
                if (states_[i].state == kernels::STREAM_ACTIVE)
                    kernels::stream_advance(scene_, mesh_, rays_[i], states_[i], count_);
            waiting.clear();
            for (const std::uint32_t i : live) {
                StreamRay& s = states_[i];
                if (s.state != kernels::STREAM_ACTIVE && s.state != kernels::STREAM_OVERFLOW) continue;
                const bool room = waiting.size() < waiting_room;
                s.state = room ? int(s.list) : kernels::STREAM_OVERFLOW;
                if (room) waiting.push_back(i);
            }
            if (passes.size() <= pass) passes.resize(pass + 1);
            tally(passes[pass]);
            // Rays in one cell test its triangles one after the other, while they are in the cache.
            std::stable_sort(waiting.begin(), waiting.end(),
                             [&](std::uint32_t a, std::uint32_t b) { return states_[a].list < states_[b].list; });
            for (const std::uint32_t i : waiting) kernels::stream_test(scene_, rays_[i], states_[i], count_);
            for (const std::uint32_t i : waiting) passes[pass].active += states_[i].state == kernels::STREAM_ACTIVE;
            // Those that overflowed come first the next time.
            std::stable_partition(live.begin(), live.end(),
                                  [&](std::uint32_t i) { return states_[i].state == kernels::STREAM_OVERFLOW; });
            std::erase_if(live, [&](std::uint32_t i) {
                return states_[i].state == kernels::STREAM_DEAD || states_[i].state == kernels::STREAM_INACTIVE;
            });
        }
    }

    template <class Report>
    void report(const Report& report) const {
        for (std::size_t i = 0; i < names_.size(); ++i) report(names_[i], states_[i].nearest);
    }

  private:
    // As they stand between the two halves of a pass.
    void tally(StreamPass& pass) const {
        for (const StreamRay& s : states_) {
            pass.waiting += s.state >= 0;
            pass.inactive += s.state == kernels::STREAM_INACTIVE;
            pass.overflow += s.state == kernels::STREAM_OVERFLOW;
            pass.dead += s.state == kernels::STREAM_DEAD;
        }
    }

    const SceneView& scene_;
    uint mesh_;
    bool any_;
    std::vector<std::uint32_t> names_;
    std::vector<MeshRay> rays_;
    std::vector<StreamRay> states_;
    kernels::WalkCount count_ = kernels::no_count();
};

void trace_batch(const SceneView& scene, std::span<const Ray> rays, std::span<const std::uint32_t> names, uint mask,
                 bool any, Hit* hits, std::vector<StreamPass>& passes) {
    for (const std::uint32_t n : names) hits[n] = kernels::no_hit(rays[n].t_max);
    for (uint instance = 0; instance < scene.instance_count; ++instance) {
        const kernels::Instance& placed = scene.instances.at[instance];
        if (!kernels::instance_admitted(placed.flags, mask)) continue;
        if (placed.geometry_kind != kernels::GEOMETRY_MESH) {
            for (const std::uint32_t n : names) kernels::instance_closest(scene, instance, rays[n], hits[n]);
            continue;
        }
        Batch batch(scene, placed.geometry, any);
        for (const std::uint32_t n : names) {
            if (any && kernels::is_hit(hits[n])) continue;
            Ray local = kernels::ray_to_local(placed, rays[n]);
            local.t_max = hits[n].t;  // of surfaces at one t the first instance's counts, and these come in order
            batch.add(n, local);
        }
        batch.run(passes);
        batch.report([&](std::uint32_t n, const kernels::MeshNearest& nearest) {
            if (nearest.triangle == kernels::NONE) return;
            kernels::mesh_report(scene, placed.geometry, nearest, hits[n]);
            hits[n].instance = instance;
        });
    }
}

}  // namespace

void stream_trace(const SceneView& scene, std::span<const Ray> rays, uint mask, bool any, Hit* hits,
                  std::vector<StreamPass>& passes) {
    const std::vector<std::uint32_t> order = coherent_order(rays);
    std::mutex mutex;
    parallel_for((rays.size() + batch_size - 1) / batch_size, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            const std::size_t first = b * batch_size, last = std::min(rays.size(), first + batch_size);
            std::vector<StreamPass> own;
            trace_batch(scene, rays, std::span(order).subspan(first, last - first), mask, any, hits, own);
            const std::lock_guard lock(mutex);
            if (passes.size() < own.size()) passes.resize(own.size());
            for (std::size_t i = 0; i < own.size(); ++i) {
                passes[i].active += own[i].active;
                passes[i].waiting += own[i].waiting;
                passes[i].inactive += own[i].inactive;
                passes[i].overflow += own[i].overflow;
                passes[i].dead += own[i].dead;
            }
        }
    });
}

}  // namespace spinel
