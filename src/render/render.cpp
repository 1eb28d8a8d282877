#include "render/render.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include "kernels/integrator_table.h"

namespace spinel {

ivec2 tile_count(const FilmBuffer& film) { return (film.crop.size() + (tile_size - 1)) / tile_size; }

Crop tile_crop(const FilmBuffer& film, int tile) {
    const ivec2 count = tile_count(film);
    const ivec2 lower = film.crop.lower + ivec2(tile % count.x, tile / count.x) * tile_size;
    return {lower, glm::min(lower + tile_size, film.crop.upper)};
}

const std::vector<IntegratorInfo>& integrator_infos() {
    static const std::vector<IntegratorInfo> rows = {
#define SPINEL_INTEGRATOR_INFO(number, name, text, needs, doc) {text, doc, number, needs},
        SPINEL_INTEGRATORS(SPINEL_INTEGRATOR_INFO)
#undef SPINEL_INTEGRATOR_INFO
    };
    return rows;
}

Result<const IntegratorInfo*> find_integrator(const std::string& name) {
    std::string available;
    for (const IntegratorInfo& row : integrator_infos()) {
        if (name == row.name) return &row;
        available += (available.empty() ? "" : ", ") + std::string(row.name);
    }
    return Error{fmt::format("unknown integrator '{}'; available: {}", name, available)};
}

namespace {

constexpr std::uint32_t max_pass = 16;       // samples: how long an interrupt or a time limit may go unseen
constexpr std::uint32_t trusted_after = 16;  // samples before a tile's estimate of its own noise is believed
constexpr std::uint32_t unlimited = 1u << 30;

Result<Crop> checked_crop(Crop crop, ivec2 size) {
    if (crop.size() == ivec2(0)) return Crop{{0, 0}, size};
    if (crop.lower.x < 0 || crop.lower.y < 0 || crop.upper.x > size.x || crop.upper.y > size.y || crop.size().x <= 0 ||
        crop.size().y <= 0)
        return Error{fmt::format("crop {},{} to {},{} is empty or not inside the film of {}x{}", crop.lower.x,
                                 crop.lower.y, crop.upper.x, crop.upper.y, size.x, size.y)};
    return crop;
}

kernels::PreviewSettings preview_settings(const CompiledScene& scene) {
    const IntegratorSettings& i = scene.integrator;
    const float diagonal = glm::length(scene.upper - scene.lower);
    const float ao_radius = i.ao_radius > 0 ? i.ao_radius : diagonal > 0 ? 0.05f * diagonal : 1.0f;
    // A halo needs the mips of what emits.
    return {ao_radius, i.ao_strength, scene.mip_first == kernels::NONE ? 0.0f : i.glow, i.glow_radius};
}

kernels::GaugeSettings gauge_settings(const CompiledScene& scene) {
    const IntegratorSettings& i = scene.integrator;
    const vec3 camera = scene.camera.camera_to_world[3];
    const float far = glm::length(glm::max(glm::abs(scene.upper - camera), glm::abs(scene.lower - camera)));
    return {i.heat_counter, i.heat_most, i.depth_end > 0 ? i.depth_end : std::max(far, 1e-20f)};
}

// Standard error of a tile over its brightness; dark tiles are judged against a fraction of the picture's brightness,
// since nobody sees noise in black.
double tile_error(const FilmBuffer& film, int tile, double picture_mean) {
    const Crop crop = tile_crop(film, tile);
    double variance = 0, mean = 0;
    for (int y = crop.lower.y; y < crop.upper.y; ++y)
        for (int x = crop.lower.x; x < crop.upper.x; ++x) {
            variance += film.at(x, y).error_variance();
            mean += film.at(x, y).mean;
        }
    const double n = double(crop.size().x) * crop.size().y;
    const double reference = std::max(mean / n, 0.1 * picture_mean);
    return reference > 0 ? std::sqrt(variance / n) / reference : 0;
}

}  // namespace

kernels::MarchSettings march_settings(const CompiledScene& scene) {
    const MarchOptions& o = scene.integrator.march;
    const float diagonal = glm::length(scene.upper - scene.lower);
    const auto or_else = [](float given, float otherwise) { return given > 0 ? given : otherwise; };
    kernels::MarchSettings m = {};
    m.step = or_else(o.step, diagonal > 0 ? diagonal / 256 : 1.0f);
    m.shadow_step = or_else(o.shadow_step, 4 * m.step);
    m.shadow_reach = or_else(o.shadow_reach, kernels::INFINITE);
    m.surface_shadow_step = or_else(o.surface_shadow_step, m.shadow_step);
    m.surface_shadow_reach = or_else(o.surface_shadow_reach, kernels::INFINITE);
    m.light_reach = o.light_reach;
    m.naive = o.integration == MarchOptions::Integration::naive;
    m.jitter = o.jitter;
    m.shortcuts = o.shortcuts;
    return m;
}

Result<RenderResult> render(Device& device, const CompiledScene& scene, const RenderOptions& options,
                            const std::atomic<bool>& stop, const std::function<void(const RenderProgress&)>& report) {
    const Result<const IntegratorInfo*> integrator =
        find_integrator(options.integrator.empty() ? scene.integrator.name : options.integrator);
    if (!integrator) return integrator.error();
    const Result<Crop> crop = checked_crop(options.crop, scene.film.size);
    if (!crop) return crop.error();
    if ((*integrator)->needs == SPINEL_NEEDS_MIPS && scene.mip_first == kernels::NONE)
        return Error{fmt::format("the scene was compiled for another integrator than '{}'", (*integrator)->name)};
    if (Result<void> loaded = device.load(scene); !loaded) return loaded.error();

    RenderResult result;
    result.film = FilmBuffer(scene.film.size, *crop);
    FilmBuffer& film = result.film;
    const bool open_ended = options.spp <= 0 && (options.time_limit > 0 || options.noise > 0);
    const std::uint32_t target = options.spp > 0 ? std::uint32_t(options.spp)
                                 : open_ended    ? unlimited
                                                 : std::uint32_t(std::max(scene.integrator.spp, 1));
    const ivec2 tiles = tile_count(film);
    std::vector<std::uint8_t> finished(std::size_t(tiles.x) * std::size_t(tiles.y), 0);
    RenderPass pass;
    pass.settings = {options.seed,
                     options.max_bounces == -2 ? scene.integrator.max_bounces : options.max_bounces,
                     options.clamp < 0 ? scene.integrator.clamp : float(options.clamp),
                     4,
                     preview_settings(scene),
                     march_settings(scene),
                     scene.dvr,
                     std::uint32_t(scene.integrator.transmittance),
                     gauge_settings(scene),
                     scene.integrator.equiangular};
    pass.integrator = (*integrator)->number;
    pass.finished_tiles = &finished;

    const std::clock_t cpu_start = std::clock();
    const auto start = std::chrono::steady_clock::now();
    const auto elapsed = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    std::uint32_t done = 0;
    while (done < target) {
        pass.first_sample = done;
        pass.sample_count = std::min({target - done, max_pass, std::max(done, 1u)});
        if (options.time_limit > 0 && done > 0) {
            const double affordable = (options.time_limit - elapsed()) / (elapsed() / done);
            if (affordable < 0.5) {
                result.reason = StopReason::time;
                break;
            }
            pass.sample_count = std::clamp(std::uint32_t(affordable), 1u, pass.sample_count);
        }
        if (Result<void> rendered = device.render(pass, film, stop); !rendered) return rendered.error();
        if (stop) {
            result.reason = StopReason::interrupted;
            break;
        }
        done += pass.sample_count;
        if (options.noise > 0 && done >= trusted_after) {
            const double mean = film.mean_luminance();
            for (std::size_t i = 0; i < finished.size(); ++i)
                if (!finished[i]) finished[i] = tile_error(film, int(i), mean) <= options.noise;
            if (std::all_of(finished.begin(), finished.end(), [](std::uint8_t f) { return f != 0; })) {
                result.reason = StopReason::noise;
                break;
            }
        }
        if (report) {
            RenderProgress p;
            p.seconds = elapsed();
            p.samples = done;
            p.relative_error = film.relative_error();
            // Error falls as 1/√n, so the samples that a noise target needs can be foretold.
            double fraction = target < unlimited ? double(done) / target : 0;
            if (options.time_limit > 0) fraction = std::max(fraction, p.seconds / options.time_limit);
            if (options.noise > 0 && p.relative_error > 0)
                fraction = std::max(fraction, std::min(1.0, std::pow(options.noise / p.relative_error, 2)));
            p.fraction = std::min(fraction, 1.0);
            if (p.fraction > 0) p.remaining = p.seconds * (1 - p.fraction) / p.fraction;
            report(p);
        }
    }
    result.seconds = elapsed();
    result.cpu_seconds = double(std::clock() - cpu_start) / CLOCKS_PER_SEC;
    return result;
}

}  // namespace spinel
