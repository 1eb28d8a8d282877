#include "devices/cpu/march.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "core/parallel.h"
#include "devices/cpu/noise_lanes.h"
#include "kernels/single_scatter.h"
#include "kernels/traverse.h"

namespace spinel {

namespace {

using kernels::MajorantWalk;
using kernels::MarchSettings;
using kernels::NONE;
using kernels::ScatterState;
using kernels::uint;

constexpr int lattice_edge = 112;     // cells along the longest axis of the grid
constexpr float opaque = 1.0f / 512;  // what is left of the light behind which nothing is asked

// Optical depth towards one light for density 1, at the corners of a lattice over the grid's box.
struct DepthLattice {
    ivec3 cells = {0, 0, 0};
    vec3 per_index = {0, 0, 0};  // lattice cells in a unit of index space
    std::vector<float> depth;    // empty: this light is marched to
    bool solids = true;          // something solid may stand in the way of this light
    bool cut = false;            // some way was longer than marches may be

    std::size_t at(int x, int y, int z) const {
        return std::size_t(x) + std::size_t(cells.x + 1) * (std::size_t(y) + std::size_t(cells.y + 1) * std::size_t(z));
    }
    float look_up(vec3 index) const {
        const vec3 p = glm::clamp(index * per_index, vec3(0), vec3(cells));
        const ivec3 i = glm::min(ivec3(p), cells - 1);
        const vec3 f = p - vec3(i);
        const float* d = depth.data() + at(i.x, i.y, i.z);
        const std::size_t row = std::size_t(cells.x) + 1, layer = row * (std::size_t(cells.y) + 1);
        const auto along = [&](const float* a) { return a[0] + (a[1] - a[0]) * f.x; };
        const float low = along(d) + (along(d + row) - along(d)) * f.y;
        const float high = along(d + layer) + (along(d + layer + row) - along(d + layer)) * f.y;
        return low + (high - low) * f.z;
    }
};

// The medium that shortcuts are for, if there is one.
struct Target {
    uint medium = NONE;
    uint instance = NONE;
    std::vector<DepthLattice> lattices;  // by light
};

struct Tool {
    const kernels::SceneView& view;
    const kernels::Medium& medium;
    const kernels::DensityGrid& grid;
    vec3 to_unit;  // index space to the grid's [0,1]³

    Tool(const kernels::SceneView& v, uint m)
        : view(v), medium(v.media.at[m]), grid(v.grids.at[medium.grid]), to_unit(1.0f / vec3(grid.size)) {}

    // Density at eight points of index space; what is not in `lanes` is not asked.
    Float8 density(const Vec8& p, unsigned lanes) const {
        Float8 d = splat(0.0f);
        bool any = false;
        for (int i = 0; i < 8; ++i) {
            const vec3 point(p.x[i], p.y[i], p.z[i]);
            if (!(lanes >> i & 1) || !kernels::grid_contains(grid, point)) continue;
            d[i] = kernels::scaled_density(medium, kernels::grid_density(view, grid, point));
            any |= d[i] > 0;
        }
        if (!any || medium.noise == kernels::NOISE_NONE) return d;
        if (medium.noise != kernels::NOISE_VALUE || medium.noise_gain != 0.5f || medium.noise_lacunarity != 2.0f) {
            for (int i = 0; i < 8; ++i)
                if (d[i] > 0) d[i] *= kernels::erosion_factor(medium, vec3(p.x[i], p.y[i], p.z[i]) * to_unit);
            return d;
        }
        const float f = medium.noise_frequency;
        const Vec8 q = {p.x * (to_unit.x * f) + medium.noise_drift.x, p.y * (to_unit.y * f) + medium.noise_drift.y,
                        p.z * (to_unit.z * f) + medium.noise_drift.z};
        const Float8 noise = medium.noise_octaves > 1 ? fbm_noise8(q, medium.noise_octaves) : value_noise8(q);
        const Float8 factor = medium.noise_offset + medium.noise_scale * noise;
        return d * maximum(factor, splat(0.0f));
    }
};

// The steps of a march that may find something: those within cells of a majorant above 0. `take(i, count)` is given up
// to eight steps from i on, and says whether to go on. Returns whether the bound of steps ended the march.
template <class Take>
bool each_batch(const kernels::SceneView& view, const kernels::Medium& medium, vec3 origin, vec3 direction, float t_end,
                float step, float start, const Take& take) {
    const float steps = std::ceil(t_end / step);
    const bool cut = steps > float(kernels::MAX_MARCH_STEPS);
    const int last = (cut ? int(kernels::MAX_MARCH_STEPS) : int(steps)) - 1;
    MajorantWalk walk = kernels::majorant_begin(view, medium, origin, direction, t_end);
    float t = 0;
    int next = 0;  // the first step that has not been taken
    const auto run = [&](float begin, float end) {
        int from = std::max(next, int(std::floor(begin / step - start)));
        const int to = std::min(last, int(std::ceil(end / step - start)));
        for (; from <= to; from += 8)
            if (!take(from, std::min(8, to + 1 - from))) return false;
        next = std::max(next, to + 1);
        return true;
    };
    float begin = -1;  // of a run of cells that may hold something
    while (t < t_end) {
        if (walk.majorant > 0 && begin < 0) begin = t;
        if (walk.majorant <= 0 && begin >= 0) {
            if (!run(begin, t)) return false;
            begin = -1;
        }
        const float t_next = walk.t_next;
        if (!(t_next > t) && walk.t_leave < 0) break;
        t = std::max(t, t_next);
        if (t < t_end) kernels::majorant_advance(view, medium, t_end, walk);
    }
    return !(begin >= 0 && !run(begin, t_end)) && cut;
}

Vec8 points(vec3 origin, vec3 direction, Float8 t) {
    return {origin.x + direction.x * t, origin.y + direction.y * t, origin.z + direction.z * t};
}

const Float8 lane_numbers = {0, 1, 2, 3, 4, 5, 6, 7};

// Where steps look, and how wide they are.
void steps_at(int first, float step, float start, float t_end, Float8& t, Float8& width) {
    const Float8 begin = (float(first) + lane_numbers) * step;
    width = maximum(minimum(splat(step), t_end - begin), splat(0.0f));
    t = begin + start * width;
}

// A ray within the box of index space that the grid fills.
bool box_span(const Tool& tool, vec3 o, vec3 d, float& t0, float& t1) {
    for (int a = 0; a < 3; ++a) {
        const float extent = float(tool.grid.size[a]);
        if (d[a] == 0) {
            if (o[a] < 0 || o[a] > extent) return false;
            continue;
        }
        const float x = -o[a] / d[a], y = (extent - o[a]) / d[a];
        t0 = std::max(t0, std::min(x, y));
        t1 = std::min(t1, std::max(x, y));
    }
    return t0 < t1;
}

}  // namespace

struct MarchShortcuts::Data {
    kernels::SceneView view;
    MarchSettings settings;
    Target target;

    void find_target(const CompiledScene& scene);
    void fill_lattice(const kernels::Light& light, DepthLattice& lattice) const;
    bool solids_near(const CompiledScene& scene, const kernels::Light& light) const;

    float depth_from(vec3 origin, vec3 direction, float distance, bool& bound) const;
    vec3 shadow(vec3 origin, vec3 direction, float distance, const kernels::Inside& inside, float start,
                bool& bound) const;
    void march(float t_end, ScatterState& state) const;
    void add_light(const Tool& tool, const kernels::Light& light, const DepthLattice& lattice, vec3 direction,
                   const Vec8& p, const Vec8& world, unsigned lanes, Float8 source[3]) const;
};

// One instance, a box that the grid fills exactly, and nothing else that light passes.
void MarchShortcuts::Data::find_target(const CompiledScene& scene) {
    if (scene.pass_through_count != 1) return;
    for (uint i = 0; i < scene.instances.size(); ++i) {
        const kernels::Instance& instance = scene.instances[i];
        if (!(instance.flags & kernels::INSTANCE_PASS_THROUGH)) continue;
        if (instance.geometry_kind != kernels::GEOMETRY_BOX) return;
        const kernels::Slot& slot = scene.slots[instance.slot_first];
        if (slot.material != NONE || slot.interior == NONE) return;
        const kernels::Interior& interior = scene.interiors[slot.interior];
        if (interior.ior > 0 || interior.medium == NONE) return;
        const kernels::Medium& medium = scene.media[interior.medium];
        if (medium.grid == NONE || !kernels::is_black(medium.emission)) return;
        const vec3 size(scene.grids[medium.grid].size);
        for (int corner = 0; corner < 8; ++corner) {
            const vec3 local(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
            const vec3 index = medium.world_to_grid * vec4(instance.object_to_world * vec4(local, 1), 1);
            if (glm::any(glm::greaterThan(glm::abs(index - 0.5f * (local + 1.0f) * size), 1e-3f * size))) return;
        }
        target.medium = interior.medium;
        target.instance = i;
    }
}

// Whether anything solid may stand between the box and a light.
bool MarchShortcuts::Data::solids_near(const CompiledScene& scene, const kernels::Light& light) const {
    const mat4x3 to_world = view.instances.at[target.instance].object_to_world;
    for (const kernels::Instance& instance : scene.instances) {
        if (instance.flags & kernels::INSTANCE_PASS_THROUGH) continue;
        if (instance.geometry_kind != kernels::GEOMETRY_PLANE) return true;
        // On one side of a plane with the whole box: only what touches it by rounding is below.
        const vec3 y(instance.world_to_object[0].y, instance.world_to_object[1].y, instance.world_to_object[2].y);
        const float offset = instance.world_to_object[3].y;
        float lowest = 1e30f, highest = -1e30f;
        for (int corner = 0; corner < 8; ++corner) {
            const vec3 p = to_world * vec4(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1, 1);
            lowest = std::min(lowest, glm::dot(y, p) + offset);
            highest = std::max(highest, glm::dot(y, p) + offset);
        }
        const float slack = 1e-4f * (highest - lowest);
        const bool infinite = light.kind == kernels::LIGHT_DIRECTIONAL;
        const float side = infinite ? -glm::dot(y, light.direction) : glm::dot(y, light.position) + offset;
        if (!(lowest >= -slack && side > 0) && !(highest <= slack && side < 0)) return true;
    }
    return false;
}

void MarchShortcuts::Data::fill_lattice(const kernels::Light& light, DepthLattice& lattice) const {
    const Tool tool(view, target.medium);
    const vec3 size(tool.grid.size);
    const float longest = std::max({size.x, size.y, size.z});
    lattice.cells = glm::max(ivec3(glm::ceil(size * (float(lattice_edge) / longest))), ivec3(1));
    lattice.per_index = vec3(lattice.cells) / size;
    lattice.depth.assign(lattice.at(0, 0, lattice.cells.z + 1), 0.0f);
    // Corners about cells whose majorant is not 0.
    std::vector<std::uint8_t> wanted(lattice.depth.size(), 0);
    const vec3 cell_edge = vec3(tool.medium.majorant_cell);
    const ivec3 m = tool.medium.majorant_size;
    for (int z = 0; z < m.z; ++z)
        for (int y = 0; y < m.y; ++y)
            for (int x = 0; x < m.x; ++x) {
                const uint at = uint(x) + uint(m.x) * (uint(y) + uint(m.y) * uint(z));
                if (!(view.floats.at[tool.medium.majorant_first + at] > 0)) continue;
                const vec3 corner = vec3(ivec3(x, y, z)) * cell_edge;
                const ivec3 lo = glm::max(ivec3(glm::floor(corner * lattice.per_index)), ivec3(0));
                const ivec3 hi = glm::min(ivec3(glm::ceil((corner + cell_edge) * lattice.per_index)), lattice.cells);
                for (int k = lo.z; k <= hi.z; ++k)
                    for (int j = lo.y; j <= hi.y; ++j)
                        for (int i = lo.x; i <= hi.x; ++i) wanted[lattice.at(i, j, k)] = 1;
            }
    const mat4x3 to_world = [&] {
        const mat4x3& m = tool.medium.world_to_grid;
        const glm::mat3 inverse = glm::inverse(glm::mat3(m));
        return mat4x3(inverse[0], inverse[1], inverse[2], -(inverse * m[3]));
    }();
    std::atomic<bool> cut{false};
    parallel_for(std::size_t(lattice.cells.z) + 1, 1, [&](std::size_t first, std::size_t end) {
        bool bound = false;
        for (std::size_t k = first; k < end; ++k)
            for (int j = 0; j <= lattice.cells.y; ++j)
                for (int i = 0; i <= lattice.cells.x; ++i) {
                    const std::size_t at = lattice.at(i, j, int(k));
                    if (!wanted[at]) continue;
                    const vec3 index = vec3(ivec3(i, j, int(k))) / lattice.per_index;
                    const vec3 p = to_world * vec4(index, 1);
                    const kernels::Arrival a = kernels::light_arrival(settings, light, p);
                    const vec3 d = tool.medium.world_to_grid * vec4(a.direction, 0);
                    float t0 = 0, t1 = std::min(a.distance, settings.shadow_reach);
                    if (!box_span(tool, index, d, t0, t1)) continue;
                    lattice.depth[at] = depth_from(p, a.direction, t1, bound);
                }
        if (bound) cut = true;
    });
    lattice.cut = cut;
}

// Depth of density 1 along a ray that begins in the box, by steps of shadows in the medium.
float MarchShortcuts::Data::depth_from(vec3 origin, vec3 direction, float distance, bool& bound) const {
    const Tool tool(view, target.medium);
    const vec3 o = tool.medium.world_to_grid * vec4(origin, 1), d = tool.medium.world_to_grid * vec4(direction, 0);
    Float8 sum = splat(0.0f);
    bound |= each_batch(view, tool.medium, origin, direction, distance, settings.shadow_step, 0.5f,
                        [&](int first, int count) {
                            Float8 t, width;
                            steps_at(first, settings.shadow_step, 0.5f, distance, t, width);
                            sum += tool.density(points(o, d, t), (1u << count) - 1) * width;
                            return true;
                        });
    float total = 0;
    for (int i = 0; i < 8; ++i) total += sum[i];
    return total;
}

// march_shadow() of a surface.
vec3 MarchShortcuts::Data::shadow(vec3 origin, vec3 direction, float distance, const kernels::Inside& inside,
                                  float start, bool& bound) const {
    const MarchSettings& s = settings;
    const bool known = inside.count == 0 || (inside.count == 1 && target.medium != NONE);
    if (target.medium == NONE || !known)
        return kernels::march_shadow(view, origin, direction, distance, inside, s.surface_shadow_step,
                                     s.surface_shadow_reach, start, bound);
    if (kernels::trace_occluded(view, kernels::Ray(origin, 0, direction, distance))) return vec3(0);
    const Tool tool(view, target.medium);
    const vec3 o = tool.medium.world_to_grid * vec4(origin, 1), d = tool.medium.world_to_grid * vec4(direction, 0);
    float t0 = 0, t1 = std::min(distance, s.surface_shadow_reach);
    if (!box_span(tool, o, d, t0, t1)) return vec3(1);
    const float way = t1 - t0;
    const vec3 entry = o + t0 * d, world = origin + t0 * direction;
    Float8 sum = splat(0.0f);
    bound |=
        each_batch(view, tool.medium, world, direction, way, s.surface_shadow_step, start, [&](int first, int count) {
            Float8 t, width;
            steps_at(first, s.surface_shadow_step, start, way, t, width);
            sum += tool.density(points(entry, d, t), (1u << count) - 1) * width;
            return true;
        });
    float depth = 0;
    for (int i = 0; i < 8; ++i) depth += sum[i];
    return kernels::exp_minus((tool.medium.scattering + tool.medium.absorption) * depth);
}

// scatter_march() through the medium of the shortcuts.
void MarchShortcuts::Data::march(float t_end, ScatterState& state) const {
    const kernels::ActiveMedia media = kernels::active_media(view, state.inside);
    if (media.count != 1 || media.ids[0] != target.medium || !kernels::is_black(media.absorption))
        return kernels::scatter_march(view, settings, t_end, state);
    const Tool tool(view, target.medium);
    const kernels::Medium& medium = tool.medium;
    const vec3 origin = state.ray.origin, direction = state.ray.direction;
    const vec3 o = medium.world_to_grid * vec4(origin, 1), d = medium.world_to_grid * vec4(direction, 0);
    const vec3 extinction = medium.scattering + medium.absorption;
    const vec3 sky = medium.scattering * kernels::scatter_sky(view, vec3(0));
    const auto take = [&](int first, int count) {
        Float8 t, width;
        steps_at(first, settings.step, state.start, t_end, t, width);
        const Vec8 p = points(o, d, t);
        const Float8 density = tool.density(p, (1u << count) - 1);
        unsigned lanes = 0;
        for (int i = 0; i < count; ++i) lanes |= unsigned(density[i] > 0) << i;
        if (lanes == 0) return true;
        const Vec8 world = points(origin, direction, t);
        Float8 source[3] = {splat(sky.x), splat(sky.y), splat(sky.z)};
        for (uint l = 0; l < view.light_count; ++l)
            if (kernels::single_scatter_light(view.lights.at[l].kind)) {
                state.bound_reached |= target.lattices[l].cut;
                add_light(tool, view.lights.at[l], target.lattices[l], direction, p, world, lanes, source);
            }
        // scatter_step() for all at once, but for what the steps before leave of the light.
        Float8 left[3], gain[3];
        for (int k = 0; k < 3; ++k) {
            const Float8 rate = extinction[k] * density;
            left[k] = exp_negative(-rate * width);
            const Int8 thick = rate * width > 1e-4f;
            const Float8 share =
                thick ? (1.0f - left[k]) / (thick ? rate : splat(1.0f)) : width * (1.0f - 0.5f * rate * width);
            gain[k] = source[k] * density * (settings.naive ? width : share);
        }
        for (; lanes; lanes &= lanes - 1) {
            const int i = std::countr_zero(lanes);
            state.radiance += state.transmitted * vec3(gain[0][i], gain[1][i], gain[2][i]);
            state.transmitted *= vec3(left[0][i], left[1][i], left[2][i]);
        }
        if (kernels::max_component(state.transmitted) >= opaque) return true;
        state.transmitted = vec3(0);
        return false;
    };
    state.bound_reached |= each_batch(view, medium, origin, direction, t_end, settings.step, state.start, take);
}

// What arrives of a light at eight points, and is scattered along the ray.
void MarchShortcuts::Data::add_light(const Tool& tool, const kernels::Light& light, const DepthLattice& lattice,
                                     vec3 direction, const Vec8& p, const Vec8& world, unsigned lanes,
                                     Float8 source[3]) const {
    const kernels::Medium& medium = tool.medium;
    Float8 value[3], cosine = splat(0.0f), depth = splat(0.0f);
    if (light.kind == kernels::LIGHT_POINT && !lattice.solids) {
        const Float8 x = light.position.x - world.x, y = light.position.y - world.y, z = light.position.z - world.z;
        const Float8 d2 = maximum(x * x + y * y + z * z, splat(1e-30f));
        const Float8 distance = square_root(d2);
        Float8 factor = 1.0f / d2;
        if (settings.light_reach > 0) {
            const Float8 fade = maximum(1.0f - distance * (1.0f / settings.light_reach), splat(0.0f));
            factor *= fade * fade;
        }
        for (int k = 0; k < 3; ++k) value[k] = light.radiance[k] * factor;
        cosine = (x * direction.x + y * direction.y + z * direction.z) / distance;
        for (unsigned rest = lanes; rest; rest &= rest - 1) {
            const int i = std::countr_zero(rest);
            depth[i] = lattice.look_up(vec3(p.x[i], p.y[i], p.z[i]));
        }
    } else {
        value[0] = value[1] = value[2] = splat(0.0f);
        for (unsigned rest = lanes; rest; rest &= rest - 1) {
            const int i = std::countr_zero(rest);
            const vec3 at(world.x[i], world.y[i], world.z[i]);
            const kernels::Arrival a = kernels::light_arrival(settings, light, at);
            if (kernels::is_black(a.value)) continue;
            if (lattice.solids && kernels::trace_occluded(view, kernels::Ray(at, 0, a.direction, a.distance))) continue;
            for (int k = 0; k < 3; ++k) value[k][i] = a.value[k];
            cosine[i] = glm::dot(direction, a.direction);
            depth[i] = lattice.look_up(vec3(p.x[i], p.y[i], p.z[i]));
        }
    }
    // phase_eval() of the kernel.
    const float g = std::clamp(medium.g, -kernels::PHASE_G_MAX, kernels::PHASE_G_MAX), a = std::abs(g);
    const Float8 off_peak = maximum(g < 0 ? 1.0f + cosine : 1.0f - cosine, splat(0.0f));
    const Float8 d = (1 - a) * (1 - a) + 2 * a * off_peak;
    const Float8 phase = 0.25f * kernels::INV_PI * (1 - a) * (1 + a) / (d * square_root(d));
    for (int k = 0; k < 3; ++k)
        source[k] += medium.scattering[k] * phase * value[k] *
                     exp_negative(-(medium.scattering[k] + medium.absorption[k]) * depth);
}

MarchShortcuts::MarchShortcuts(const CompiledScene& scene, const MarchSettings& settings)
    : data_(std::make_unique<Data>()) {
    data_->view = scene.view();
    data_->settings = settings;
    data_->find_target(scene);
    if (data_->target.medium == NONE) return;
    data_->target.lattices.resize(scene.lights.size());
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        if (!kernels::single_scatter_light(scene.lights[i].kind)) continue;
        data_->target.lattices[i].solids = data_->solids_near(scene, scene.lights[i]);
        data_->fill_lattice(scene.lights[i], data_->target.lattices[i]);
    }
}

MarchShortcuts::~MarchShortcuts() = default;

const MarchSettings& MarchShortcuts::settings() const { return data_->settings; }

// single_scatter() of the kernel, with the marches above.
kernels::PixelSample MarchShortcuts::sample(const kernels::Ray& ray, const kernels::Inside& inside, kernels::Hit hit,
                                            kernels::Sampler numbers) const {
    const Data& d = *data_;
    ScatterState state = kernels::scatter_begin(d.settings, ray, inside, numbers);
    for (uint i = 0; i < kernels::MAX_SCATTER_SEGMENTS; ++i) {
        d.march(hit.t, state);
        if (!kernels::is_hit(hit)) {
            state.radiance += state.transmitted * kernels::environment_radiance(d.view, state.ray.direction);
            return kernels::scatter_sample(state);
        }
        kernels::Surface s;
        if (kernels::scatter_cross(d.view, hit, state, s)) {
            kernels::ScatterSurface seen = kernels::scatter_surface(d.view, s, state.ray.direction);
            const bool dark = kernels::is_black(state.transmitted);
            for (uint k = 0; k < d.view.light_count && !dark; ++k) {
                const kernels::Light& light = d.view.lights.at[k];
                if (!kernels::single_scatter_light(light.kind)) continue;
                const kernels::Arrival a = kernels::light_arrival(d.settings, light, s.position);
                const float start = d.settings.jitter ? kernels::sampler_1d(numbers) : 0.5f;
                const vec3 given = kernels::scatter_surface_light(seen, a);
                if (kernels::is_black(given)) continue;
                seen.light += given * d.shadow(kernels::leave_surface(d.view, s, a.direction), a.direction, a.distance,
                                               state.inside, start, state.bound_reached);
            }
            return kernels::scatter_sample_of(d.view, state, seen);
        }
        hit = kernels::trace_closest(d.view, state.ray, kernels::TRACE_ALL);
    }
    state.bound_reached = true;
    return kernels::scatter_sample(state);
}

}  // namespace spinel
