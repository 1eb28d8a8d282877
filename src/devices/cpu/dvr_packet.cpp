#include "devices/cpu/dvr_packet.h"

#include <algorithm>
#include <cmath>

#include "devices/cpu/dvr_rays.h"
#include "kernels/dvr.h"
#include "kernels/traverse.h"

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace spinel {

namespace {

constexpr double most_samples = 1 << 29;  // of a copy of the volume in 16 bits, 1 GiB; larger ones go by the kernel
constexpr float farthest_step = 1e9f;     // that an int counts

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

// Mean of colour·σ and σ between entries, as transfer_between() of the kernel: along each ray one piece ends where the
// next one begins, so that half of the rows are known already.
class Pieces {
  public:
    Pieces(const float* table, int size) : table_(table), size_(size) {}

    void begin_at(Float8 x) { x_ = x, known_ = false; }
    Float8 begin() const { return x_; }
    // As far as x, which is where the next piece begins.
    void mean_to(Float8 x, Float8 mean[4]) {
        Float8 next[4];
        const float* integral = table_ + 4 * size_;
        if (!known_) rows_at(integral, x_, size_, rows_);
        rows_at(integral, x, size_, next);
        const Float8 difference = x - x_;
        const Int8 close = absolute(difference) < kernels::TRANSFER_LEAST_DIFFERENCE;
        const Float8 inverse = 1.0f / (close ? splat(1.0f) : difference);
        for (int i = 0; i < 4; ++i) mean[i] = (next[i] - rows_[i]) * inverse;
        for (int i = 0; i < 4; ++i) rows_[i] = next[i];
        known_ = true;
        if (any(close)) {
            rows_at(table_, 0.5f * (x_ + x), size_, next);
            for (int i = 0; i < 4; ++i) mean[i] = close ? next[i] : mean[i];
        }
        x_ = x;
    }

  private:
    Float8 x_ = splat(0.0f);
    Float8 rows_[4];
    const float* table_;
    int size_;
    bool known_ = false;
};

}  // namespace

std::unique_ptr<DvrPackets> DvrPackets::make(const CompiledScene& scene, const kernels::DvrSettings& settings) {
    if (settings.medium == kernels::NONE) return {};
    const kernels::DensityGrid& grid = scene.grids[scene.media[settings.medium].grid];
    const double samples = double(grid.size.x + 4) * (grid.size.y + 4) * (grid.size.z + 4);
    if (grid.filter_kind != kernels::FILTER_TRILINEAR || samples >= most_samples) return {};
    std::unique_ptr<DvrPackets> packets(new DvrPackets(scene, settings));
    if (packets->volume_.is_coarse()) return {};
    return packets;
}

DvrPackets::DvrPackets(const CompiledScene& scene, const kernels::DvrSettings& settings)
    : view_(scene.view()), settings_(settings), volume_(view_, settings), lights_(view_, settings) {
    for (const kernels::Instance& instance : scene.instances)
        surfaces_ |= !(instance.flags & kernels::INSTANCE_PASS_THROUGH);
}

// Light of the pieces of the rays that end at t.
void DvrPackets::step(const Rays& rays, Float8 t, const Float8 mean[4], Int8 lanes, Seen& seen) const {
    const Float8 zero = splat(0.0f);
    const Float8 opacity = 1.0f - exp_negative(minimum(mean[3] * -settings_.step, zero));
    lanes &= opacity > kernels::DVR_FAINT;
    if (!any(lanes)) return;
    const DvrLights::Lit lit = lights_.at(volume_, rays.world, rays.index, t - 0.5f * settings_.step, lanes);
    const Float8 after = lanes ? seen.left * (1.0f - opacity) : seen.left;
    const Int8 halved = lanes & (seen.left > 0.5f) & (after <= 0.5f);
    seen.normal.x = halved ? lit.normal.x : seen.normal.x;
    seen.normal.y = halved ? lit.normal.y : seen.normal.y;
    seen.normal.z = halved ? lit.normal.z : seen.normal.z;
    seen.depth = halved ? t : seen.depth;
    const Float8 weight = lanes ? seen.left * opacity : zero;
    const Float8 factor = lit.factor / (lanes ? mean[3] : splat(1.0f));
    seen.red += weight * (mean[0] * factor + lit.highlight);
    seen.green += weight * (mean[1] * factor + lit.highlight);
    seen.blue += weight * (mean[2] * factor + lit.highlight);
    seen.left = after < kernels::DVR_OPAQUE ? zero : after;
}

void DvrPackets::composite(const Rays& rays, Seen& seen) const {
    const float step = settings_.step;
    const Float8 last_entry = splat(float(settings_.table_size - 1)), zero = splat(0.0f);
    const auto place = [&](Float8 t) {
        return minimum(maximum(volume_.place(volume_.value(rays.at(t))), zero), last_entry);
    };
    Pieces pieces(view_.floats.at + settings_.table_first, int(settings_.table_size));
    bool known = false;  // whether the step before has been looked at
    int k = rays.begin;
    for (int bound = 0; k <= rays.end; ++bound) {
        const Int8 alive = (rays.first <= k) & (rays.last >= k) & (seen.left > 0.0f);
        const Int8 waiting = (rays.first > k) & (rays.first <= rays.last);
        if (!any(alive | waiting)) break;
        if (bound == int(kernels::MAX_DVR_STEPS)) {
            seen.bound_reached = alive | waiting;
            break;
        }
        const Float8 t = (float(k) + rays.start) * step;
        const Int8 distance = volume_.distance(rays.at(t));
        if (!any(alive & (distance == 0))) {
            // Rings of empty bricks about the one of each ray: all may leap as far as the nearest ends.
            const Float8 rings = to_float(maximum(distance - 1, splat(0))) * float(DvrVolume::brick);
            k += dvr_leap(alive, to_int(rings * rays.per_index), rays.first, waiting, k);
            known = false;
            continue;
        }
        if (!known) pieces.begin_at(place((float(k - 1) + rays.start) * step));
        known = true;
        const Float8 x0 = pieces.begin(), x1 = place(t);
        const Int8 lanes = alive & (rays.first < k);
        if (any(lanes & ((x0 > volume_.first_visible()) | (x1 > volume_.first_visible())))) {
            Float8 mean[4];
            pieces.mean_to(x1, mean);
            this->step(rays, t, mean, lanes, seen);
        } else {
            pieces.begin_at(x1);
        }
        ++k;
    }
}

// dvr_span() of the kernel. `ends` is how far the rays go; not at all: 0.
DvrPackets::Rays DvrPackets::begin(const RayLanes& rays, Float8 start, Float8 ends) const {
    const mat4x3& m = view_.media.at[settings_.medium].world_to_grid;
    const Vec8 &o = rays.origin, &d = rays.direction;
    Rays r;
    r.world = rays;
    r.start = start;
    const auto turned = [&](const Vec8& v, int axis) { return v.x * m[0][axis] + v.y * m[1][axis] + v.z * m[2][axis]; };
    r.index.origin = {turned(o, 0) + m[3].x, turned(o, 1) + m[3].y, turned(o, 2) + m[3].z};
    r.index.direction = {turned(d, 0), turned(d, 1), turned(d, 2)};
    r.span_begin = splat(0.0f);
    r.span_end = ends;
    const auto between = [&](Float8 from, Float8 rate, float lower, float upper) {
        const Int8 still = rate == 0.0f;
        const Float8 inverse = 1.0f / (still ? splat(1.0f) : rate);
        const Float8 t0 = (lower - from) * inverse, t1 = (upper - from) * inverse;
        r.span_begin = still ? r.span_begin : maximum(r.span_begin, minimum(t0, t1));
        const Int8 outside = (from < lower) | (from > upper);
        r.span_end = still ? (outside ? splat(-1.0f) : r.span_end) : minimum(r.span_end, maximum(t0, t1));
    };
    const vec3 lower = settings_.clip_lower, upper = settings_.clip_upper;
    between(r.index.origin.x, r.index.direction.x, lower.x, upper.x);
    between(r.index.origin.y, r.index.direction.y, lower.y, upper.y);
    between(r.index.origin.z, r.index.direction.z, lower.z, upper.z);
    for (kernels::uint i = 0; i < settings_.plane_count; ++i) {
        const vec4 n = settings_.planes[i];
        const Float8 height = o.x * n.x + o.y * n.y + o.z * n.z - n.w;  // > 0: cut away
        const Float8 rate = d.x * n.x + d.y * n.y + d.z * n.z;
        const Float8 at = -height / (rate == 0.0f ? splat(1.0f) : rate);
        r.span_end = rate == 0.0f  ? (height > 0.0f ? splat(-1.0f) : r.span_end)
                     : rate > 0.0f ? minimum(r.span_end, at)
                                   : r.span_end;
        r.span_begin = rate < 0.0f ? maximum(r.span_begin, at) : r.span_begin;
    }
    const Int8 empty = ~(r.span_begin < r.span_end);
    const float per_step = 1.0f / settings_.step;
    const auto bounded = [](Float8 x) { return minimum(maximum(x, splat(-1.0f)), splat(farthest_step)); };
    r.first = empty ? splat(1) : to_int(-floor8(bounded(r.span_begin * per_step - start) * -1.0f));
    r.last = empty ? splat(-1) : to_int(floor8(bounded(r.span_end * per_step - start)));
    r.begin = least(empty ? splat(1 << 30) : r.first);
    r.end = -least(-r.last);
    const Float8 fastest =
        maximum(absolute(r.index.direction.x), maximum(absolute(r.index.direction.y), absolute(r.index.direction.z)));
    r.per_index = 1.0f / maximum(fastest * settings_.step, splat(1e-20f));
    return r;
}

void DvrPackets::render(const RayLanes& rays, Float8 start, const kernels::Hit* hits, int count,
                        kernels::PixelSample* samples) const {
    kernels::PreviewView views[width];
    Float8 ends = splat(0.0f);
    for (int i = 0; i < count; ++i) {
        views[i].found = false;
        views[i].bound_reached = false;
        if (surfaces_)
            views[i] = kernels::preview_view(
                view_,
                kernels::Ray(vec3(rays.origin.x[i], rays.origin.y[i], rays.origin.z[i]), 0,
                             vec3(rays.direction.x[i], rays.direction.y[i], rays.direction.z[i]), kernels::INFINITE),
                hits[i]);
        ends[i] = views[i].found ? views[i].distance : kernels::INFINITE;
    }
    const Rays r = begin(rays, start, ends);
    Seen seen;
    if (any(r.span_begin < r.span_end)) {
        if (settings_.mode == kernels::DVR_COMPOSITE) composite(r, seen);
        else if (settings_.mode == kernels::DVR_ISOSURFACE) isosurface(r, seen);
        else projection(r, seen);
    }
    for (int i = 0; i < count; ++i) {
        const kernels::DvrSeen one(vec3(seen.red[i], seen.green[i], seen.blue[i]), seen.left[i], seen.depth[i],
                                   vec3(seen.normal.x[i], seen.normal.y[i], seen.normal.z[i]),
                                   seen.bound_reached[i] != 0);
        samples[i] = kernels::dvr_sample(view_, settings_, views[i], one);
    }
}

}  // namespace spinel
