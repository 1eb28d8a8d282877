#include "devices/cpu/dvr_packet.h"

#include <algorithm>
#include <cmath>

#include "kernels/dvr.h"
#include "kernels/traverse.h"

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace spinel {

namespace {

using kernels::DvrSpan;
using kernels::uint;

constexpr int highlight_entries = 1024;
constexpr double most_samples = 1 << 29;  // of a copy of the volume in 16 bits, 1 GiB; larger ones go by the kernel

bool any(Int8 lanes) {
#ifdef __AVX2__
    return _mm256_movemask_ps(__m256(lanes)) != 0;
#else
    for (int i = 0; i < 8; ++i)
        if (lanes[i]) return true;
    return false;
#endif
}

// Rows of four numbers at entry x of a table, linear between entries.
void rows_at(const float* table, Float8 x, int size, Float8 out[4]) {
    const Int8 i = minimum(to_int(x), splat(size - 2));
    const Float8 f = x - to_float(i);
#ifdef __AVX2__
    __m128 row[8];
    for (int lane = 0; lane < 8; ++lane) {
        const float* at = table + 4 * i[lane];
        const __m128 a = _mm_loadu_ps(at), b = _mm_loadu_ps(at + 4);
        row[lane] = _mm_add_ps(a, _mm_mul_ps(_mm_sub_ps(b, a), _mm_set1_ps(f[lane])));
    }
    _MM_TRANSPOSE4_PS(row[0], row[1], row[2], row[3]);
    _MM_TRANSPOSE4_PS(row[4], row[5], row[6], row[7]);
    for (int k = 0; k < 4; ++k) out[k] = Float8(_mm256_set_m128(row[4 + k], row[k]));
#else
    for (int k = 0; k < 4; ++k)
        for (int lane = 0; lane < 8; ++lane) {
            const float* at = table + 4 * i[lane] + k;
            out[k][lane] = at[0] + (at[4] - at[0]) * f[lane];
        }
#endif
}

}  // namespace

struct DvrPackets::Rays {
    Vec8 origin, direction;  // index space
    Vec8 world;              // direction in world space
    Float8 start;
    Int8 first, last;  // steps
    Float8 reach;      // index units that a step goes at most along an axis
    int begin, end;    // least and greatest of all
};

struct DvrPackets::Seen {
    Float8 red = splat(0.0f), green = splat(0.0f), blue = splat(0.0f);
    Float8 left = splat(1.0f);
    Float8 depth = splat(0.0f);
    Vec8 normal = {splat(0.0f), splat(0.0f), splat(0.0f)};
};

std::unique_ptr<DvrPackets> DvrPackets::make(const CompiledScene& scene, const kernels::DvrSettings& settings) {
    if (settings.medium == kernels::NONE || settings.mode != kernels::DVR_COMPOSITE || settings.shadow > 0) return {};
    const kernels::DensityGrid& grid = scene.grids[scene.media[settings.medium].grid];
    const double samples = double(grid.size.x + 4) * (grid.size.y + 4) * (grid.size.z + 4);
    if (grid.filter_kind != kernels::FILTER_TRILINEAR || samples >= most_samples) return {};
    std::unique_ptr<DvrPackets> packets(new DvrPackets(scene, settings));
    if (packets->volume_.is_coarse()) return {};
    return packets;
}

DvrPackets::DvrPackets(const CompiledScene& scene, const kernels::DvrSettings& settings)
    : view_(scene.view()),
      settings_(settings),
      volume_(view_, settings),
      world_to_grid_(scene.media[settings.medium].world_to_grid) {
    for (const kernels::Instance& instance : scene.instances)
        surfaces_ |= !(instance.flags & kernels::INSTANCE_PASS_THROUGH);
    highlights_.resize(highlight_entries + 1);
    for (int i = 0; i <= highlight_entries; ++i)
        highlights_[std::size_t(i)] = settings.specular * std::pow(float(i) / highlight_entries, settings.shininess);
}

void DvrPackets::mean_between(Float8 x0, Float8 x1, Float8 mean[4]) const {
    const float* table = view_.floats.at + settings_.table_first;
    const int size = int(settings_.table_size);
    Float8 a[4], b[4];
    rows_at(table + 4 * size, x0, size, a);
    rows_at(table + 4 * size, x1, size, b);
    const Float8 difference = x1 - x0;
    const Float8 magnitude = difference < 0.0f ? -difference : difference;
    const Int8 close = magnitude < kernels::TRANSFER_LEAST_DIFFERENCE;
    const Float8 inverse = 1.0f / (close ? splat(1.0f) : difference);
    for (int k = 0; k < 4; ++k) mean[k] = (b[k] - a[k]) * inverse;
    if (!any(close)) return;
    rows_at(table, 0.5f * (x0 + x1), size, a);
    for (int k = 0; k < 4; ++k) mean[k] = close ? a[k] : mean[k];
}

// Light of the piece of the rays between two samples.
void DvrPackets::step(const Rays& rays, Float8 t, const Vec8& middle, Float8 x0, Float8 x1, Int8 lanes,
                      Seen& seen) const {
    const Float8 last = splat(float(settings_.table_size - 1)), zero = splat(0.0f);
    x0 = minimum(maximum(x0, zero), last);
    x1 = minimum(maximum(x1, zero), last);
    if (!any(lanes & ((x0 > volume_.first_visible()) | (x1 > volume_.first_visible())))) return;
    Float8 mean[4];
    mean_between(x0, x1, mean);
    const Float8 opacity = 1.0f - exp_negative(minimum(mean[3] * -settings_.step, zero));
    lanes &= opacity > kernels::DVR_FAINT;
    if (!any(lanes)) return;
    const Float8 inverse = 1.0f / (lanes ? mean[3] : splat(1.0f));
    Float8 diffuse = splat(1.0f), highlight = zero;
    if (settings_.shaded) {
        const Vec8 g = volume_.gradient(middle);
        const glm::mat3& m = world_to_grid_;  // rows times gradient: normals go by the transposed inverse
        const Float8 gx = g.x * m[0].x + g.y * m[0].y + g.z * m[0].z;
        const Float8 gy = g.x * m[1].x + g.y * m[1].y + g.z * m[1].z;
        const Float8 gz = g.x * m[2].x + g.y * m[2].y + g.z * m[2].z;
        const Float8 square = gx * gx + gy * gy + gz * gz;
        const Int8 sloped = square > 1e-30f;
        const Float8 scale = 1.0f / square_root(sloped ? square : splat(1.0f));
        const Vec8 n = {gx * scale, gy * scale, gz * scale};
        const Vec8& d = rays.world;
        const auto absolute = [](Float8 x) { return x < 0.0f ? -x : x; };
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
        const Float8 at = minimum(half, splat(1.0f)) * float(highlight_entries);
        const Int8 i = minimum(to_int(at), splat(highlight_entries - 1));
        Float8 a, b;
#ifdef __AVX2__
        a = Float8(_mm256_i32gather_ps(highlights_.data(), __m256i(i), 4));
        b = Float8(_mm256_i32gather_ps(highlights_.data() + 1, __m256i(i), 4));
#else
        for (int lane = 0; lane < 8; ++lane) {
            a[lane] = highlights_[std::size_t(i[lane])];
            b[lane] = highlights_[std::size_t(i[lane]) + 1];
        }
#endif
        diffuse = sloped ? settings_.ambient + settings_.diffuse * toward : diffuse;
        highlight = sloped ? mix8(a, b, at - to_float(i)) : highlight;
        const Int8 halved = lanes & (seen.left > 0.5f) & (seen.left * (1.0f - opacity) <= 0.5f);
        seen.normal.x = halved ? -n.x : seen.normal.x;
        seen.normal.y = halved ? -n.y : seen.normal.y;
        seen.normal.z = halved ? -n.z : seen.normal.z;
    }
    const Float8 after = lanes ? seen.left * (1.0f - opacity) : seen.left;
    seen.depth = (lanes & (seen.left > 0.5f) & (after <= 0.5f)) ? t : seen.depth;
    const Float8 weight = lanes ? seen.left * opacity : zero;
    const Float8 lit = diffuse * inverse;
    seen.red += weight * (mean[0] * lit + highlight);
    seen.green += weight * (mean[1] * lit + highlight);
    seen.blue += weight * (mean[2] * lit + highlight);
    seen.left = after < kernels::DVR_OPAQUE ? zero : after;
}

void DvrPackets::composite(const Rays& rays, Seen& seen) const {
    const auto at = [&](Float8 t) {
        return Vec8{rays.origin.x + t * rays.direction.x, rays.origin.y + t * rays.direction.y,
                    rays.origin.z + t * rays.direction.z};
    };
    const float step = settings_.step;
    bool known = false;  // whether x0 belongs to the step before
    Float8 x0 = splat(0.0f);
    int k = rays.begin;
    // A step may see less than it goes: a sample's neighbours in reach of a step are in the brick's range already.
    for (int bound = 0; k <= rays.end && bound < int(kernels::MAX_DVR_STEPS); ++bound) {
        const Int8 alive = (rays.first <= k) & (rays.last >= k) & (seen.left > 0.0f);
        const Float8 t = (float(k) + rays.start) * step;
        const Vec8 p = at(t);
        if (!any(alive)) {
            // Rays that begin later, or none.
            int next = rays.end + 1;
            for (int i = 0; i < 8; ++i)
                if (rays.first[i] > k && rays.first[i] <= rays.last[i] && seen.left[i] > 0)
                    next = std::min(next, rays.first[i]);
            known = false;
            k = next;
            continue;
        }
        const Int8 distance = volume_.distance(p);
        if (!any(alive & (distance == 0))) {
            // Rings of empty bricks about the one at p: their rays may leap as far as the nearest ends.
            const Float8 rings = to_float(maximum(distance - 1, splat(0))) * float(DvrVolume::brick);
            const Int8 steps = maximum(to_int(rings / rays.reach), splat(1));
            int leap = 1 << 20;
            for (int i = 0; i < 8; ++i)
                if (alive[i]) leap = std::min(leap, steps[i]);
                else if (rays.first[i] > k && seen.left[i] > 0) leap = std::min(leap, rays.first[i] - k);
            known = false;
            k += leap;
            continue;
        }
        if (!known) x0 = volume_.place(at(t - step));
        const Float8 x1 = volume_.place(p);
        this->step(rays, t, at(t - 0.5f * step), x0, x1, alive & (rays.first < k), seen);
        x0 = x1;
        known = true;
        ++k;
    }
}

void DvrPackets::render(const kernels::Ray* rays, const kernels::Hit* hits, kernels::Sampler* numbers, int count,
                        kernels::PixelSample* samples) const {
    kernels::PreviewView views[width];
    Rays r;
    r.begin = 1 << 30;
    r.end = -1;
    for (int i = 0; i < width; ++i) {
        const kernels::Ray& ray = rays[std::min(i, count - 1)];
        if (i < count) {
            if (surfaces_) {
                views[i] = kernels::preview_view(view_, ray, hits[i]);
            } else {
                views[i].found = false;
                views[i].ray = ray;
                views[i].bound_reached = false;
            }
        }
        const DvrSpan span = kernels::dvr_span(view_, settings_, ray,
                                               i < count && views[i].found ? views[i].distance : kernels::INFINITE);
        r.start[i] = i < count && settings_.jitter ? kernels::sampler_1d(numbers[i]) : 0.0f;
        const bool empty = i >= count || !(span.begin < span.end);
        r.origin.x[i] = span.origin.x, r.origin.y[i] = span.origin.y, r.origin.z[i] = span.origin.z;
        r.direction.x[i] = span.direction.x, r.direction.y[i] = span.direction.y, r.direction.z[i] = span.direction.z;
        r.world.x[i] = ray.direction.x, r.world.y[i] = ray.direction.y, r.world.z[i] = ray.direction.z;
        r.first[i] = empty ? 1 : int(std::ceil(span.begin / settings_.step - r.start[i]));
        r.last[i] = empty ? 0 : int(std::floor(span.end / settings_.step - r.start[i]));
        r.reach[i] = std::max(kernels::max_component(glm::abs(span.direction)) * settings_.step, 1e-20f);
        if (r.first[i] > r.last[i]) continue;
        r.begin = std::min(r.begin, r.first[i]);
        r.end = std::max(r.end, r.last[i]);
    }
    Seen seen;
    if (r.begin <= r.end) composite(r, seen);
    for (int i = 0; i < count; ++i) {
        const kernels::DvrSeen one(vec3(seen.red[i], seen.green[i], seen.blue[i]), seen.left[i], seen.depth[i],
                                   vec3(seen.normal.x[i], seen.normal.y[i], seen.normal.z[i]), false);
        samples[i] = kernels::dvr_sample(view_, settings_, views[i], one);
    }
}

}  // namespace spinel
