#include "devices/cpu/dvr_light.h"

#include <algorithm>
#include <cmath>

#include "kernels/dvr.h"
#include "kernels/traverse.h"

namespace spinel {

namespace {
constexpr int highlight_entries = 1024;
}

DvrLights::DvrLights(const kernels::SceneView& view, const kernels::DvrSettings& settings)
    : settings_(settings), world_to_grid_(view.media.at[settings.medium].world_to_grid) {
    highlights_.resize(highlight_entries + 1);
    for (int i = 0; i <= highlight_entries; ++i)
        highlights_[std::size_t(i)] = settings.specular * std::pow(float(i) / highlight_entries, settings.shininess);
    extinction_.resize(settings.table_size);
    for (std::size_t i = 0; i < extinction_.size(); ++i)
        extinction_[i] = view.floats.at[settings.table_first + 4 * i + 3];
}

DvrLights::Lit DvrLights::at(const DvrVolume& volume, const RayLanes& world, const RayLanes& index, Float8 t,
                             Int8 lanes) const {
    Lit lit = {splat(1.0f), splat(0.0f), {splat(0.0f), splat(0.0f), splat(0.0f)}};
    if (settings_.shaded) {
        const Vec8 g = volume.gradient(index.at(t));
        const glm::mat3& m = world_to_grid_;  // rows times gradient: normals go by the transposed inverse
        const Float8 gx = g.x * m[0].x + g.y * m[0].y + g.z * m[0].z;
        const Float8 gy = g.x * m[1].x + g.y * m[1].y + g.z * m[1].z;
        const Float8 gz = g.x * m[2].x + g.y * m[2].y + g.z * m[2].z;
        const Float8 square = gx * gx + gy * gy + gz * gz;
        const Int8 sloped = square > 1e-30f;
        const Float8 scale = -1.0f / square_root(sloped ? square : splat(1.0f));
        const Vec8 n = {gx * scale, gy * scale, gz * scale};
        const Vec8& d = world.direction;
        Float8 toward, half;
        if (settings_.headlight) {
            toward = half = absolute(n.x * d.x + n.y * d.y + n.z * d.z);
        } else {
            const vec3 l = settings_.to_light;
            toward = absolute(n.x * l.x + n.y * l.y + n.z * l.z);
            const Float8 hx = l.x - d.x, hy = l.y - d.y, hz = l.z - d.z;
            const Float8 length2 = maximum(hx * hx + hy * hy + hz * hz, splat(1e-20f));
            half = absolute(n.x * hx + n.y * hy + n.z * hz) / square_root(length2);
        }
        const Float8 highlight =
            gather_linear(highlights_.data(), minimum(half, splat(1.0f)) * float(highlight_entries), highlight_entries);
        lit.factor = sloped ? settings_.ambient + settings_.diffuse * toward : lit.factor;
        lit.highlight = sloped ? highlight : lit.highlight;
        lit.normal = n;
    }
    if (settings_.shadow > 0) {
        const Float8 shadow = this->shadow(volume, world, index, t, lanes);
        lit.factor *= shadow;
        lit.highlight *= shadow;
    }
    return lit;
}

// dvr_light_way() of the kernel.
Float8 DvrLights::light_way(const RayLanes& world, Float8 t) const {
    Float8 way = splat(settings_.shadow_reach);
    const Vec8 p = world.at(t);
    for (kernels::uint i = 0; i < settings_.plane_count; ++i) {
        const vec4 n = settings_.planes[i];
        const Vec8& d = world.direction;
        const Float8 rate =
            settings_.headlight ? -(n.x * d.x + n.y * d.y + n.z * d.z) : splat(glm::dot(vec3(n), settings_.to_light));
        const Int8 leaves = rate > 0.0f;
        const Float8 end = (n.w - (n.x * p.x + n.y * p.y + n.z * p.z)) / (leaves ? rate : splat(1.0f));
        way = leaves ? minimum(way, end) : way;
    }
    return way;
}

// dvr_shadow() of the kernel; steps that see nothing for sure are not taken.
Float8 DvrLights::shadow(const DvrVolume& volume, const RayLanes& world, const RayLanes& index, Float8 t,
                         Int8 lanes) const {
    const Vec8 p = index.at(t);
    const Float8 way = light_way(world, t);
    Vec8 l = {-index.direction.x, -index.direction.y, -index.direction.z};
    if (!settings_.headlight) {
        const vec3 to_light = world_to_grid_ * settings_.to_light;
        l = {splat(to_light.x), splat(to_light.y), splat(to_light.z)};
    }
    const float step = 2 * settings_.voxel;
    const Float8 per_index =
        1.0f / maximum(maximum(absolute(l.x), maximum(absolute(l.y), absolute(l.z))) * step, splat(1e-20f));
    const vec3 lower = settings_.clip_lower, upper = settings_.clip_upper;
    const int last_entry = int(settings_.table_size) - 1;
    Float8 depth = splat(0.0f);
    for (int i = 1; i < int(kernels::MAX_DVR_STEPS);) {
        const float done = float(i) * step;
        const Vec8 q = {p.x + done * l.x, p.y + done * l.y, p.z + done * l.z};
        lanes &= (way >= done) & (depth <= 8.0f) & (q.x >= lower.x) & (q.x <= upper.x) & (q.y >= lower.y) &
                 (q.y <= upper.y) & (q.z >= lower.z) & (q.z <= upper.z);
        if (!any(lanes)) break;
        const Int8 distance = volume.distance(q);
        if (!any(lanes & (distance == 0))) {
            const Float8 rings = to_float(maximum(distance - 1, splat(0))) * float(DvrVolume::brick);
            i += std::max(1, least(lanes ? to_int(rings * per_index) : splat(1 << 20)));
            continue;
        }
        const Float8 place = volume.place(volume.value(q));
        const Float8 x = minimum(maximum(place, splat(0.0f)), splat(float(last_entry)));
        depth += lanes ? gather_linear(extinction_.data(), x, last_entry) * step : splat(0.0f);
        ++i;
    }
    return 1.0f - settings_.shadow * (1.0f - exp_negative(-depth));
}

}  // namespace spinel
