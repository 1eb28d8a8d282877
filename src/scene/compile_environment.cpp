#include <cmath>

#include "core/parallel.h"
#include "image/pixels.h"
#include "kernels/environment.h"
#include "kernels/sky.h"
#include "kernels/texture.h"
#include "scene/compilation.h"

namespace spinel {
namespace {

using kernels::NONE;
using kernels::uint;

struct Equirect {
    int width = 0;
    int height = 0;
    std::vector<vec3> radiance;  // row 0 at the zenith
};

float clean_radiance(float x) { return std::isfinite(x) ? std::max(x, 0.0f) : 0.0f; }

Equirect from_image(const ImageEnvironment& image) {
    const PixelBuffer& p = *image.pixels;
    Equirect map{p.width, p.height, std::vector<vec3>(std::size_t(p.width) * std::size_t(p.height))};
    for (std::size_t i = 0; i < map.radiance.size(); ++i) {
        vec3 rgb;
        for (int k = 0; k < 3; ++k) {
            const std::size_t at = i * std::size_t(p.channels) + std::size_t(p.channels >= 3 ? k : 0);
            if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&p.data))
                rgb[k] = kernels::srgb_to_linear(float((*bytes)[at]) / 255.0f);
            else rgb[k] = clean_radiance(std::get<std::vector<float>>(p.data)[at]);
        }
        map.radiance[i] = rgb * image.scale;
    }
    return map;
}

Equirect from_sky(const SkyEnvironment& sky, vec3 to_sun) {
    Equirect map{512, 256, std::vector<vec3>(512 * 256)};
    parallel_for(std::size_t(map.height), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y)
            for (int x = 0; x < map.width; ++x) {
                const vec2 uv((float(x) + 0.5f) / float(map.width), (float(y) + 0.5f) / float(map.height));
                map.radiance[y * std::size_t(map.width) + std::size_t(x)] =
                    sky.scale * kernels::sky_radiance(kernels::equirect_direction(uv), to_sun, sky.haze);
            }
    });
    return map;
}

// Density to sample each texel by: its luminance, smoothed by the reach of bilinear look-ups, times its solid angle.
std::vector<double> texel_weights(const Equirect& map, bool smooth) {
    const auto at = [&](int x, int y) {
        return double(
            kernels::luminance(map.radiance[std::size_t(glm::clamp(y, 0, map.height - 1)) * std::size_t(map.width) +
                                            std::size_t((x + map.width) % map.width)]));
    };
    std::vector<double> weights(map.radiance.size());
    for (int y = 0; y < map.height; ++y) {
        const double band = std::cos(M_PI * y / map.height) - std::cos(M_PI * (y + 1) / map.height);
        for (int x = 0; x < map.width; ++x) {
            double w = at(x, y);
            if (smooth) {
                double sum = 0;
                for (int j = -1; j <= 1; ++j)
                    for (int i = -1; i <= 1; ++i) sum += at(x + i, y + j) * (i == 0 ? 6 : 1) * (j == 0 ? 6 : 1);
                w = sum / 64;
            }
            weights[std::size_t(y) * std::size_t(map.width) + std::size_t(x)] = w * band;
        }
    }
    return weights;
}

// Appends count + 1 values of the cumulative distribution, 0 … 1; uniform where all weights vanish. Returns the sum.
double append_cumulative(std::vector<float>& floats, const double* weights, int count) {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += weights[i];
    double running = 0;
    floats.push_back(0);
    for (int i = 0; i < count; ++i) {
        running += weights[i];
        floats.push_back(i + 1 == count ? 1.0f : float(sum > 0 ? running / sum : double(i + 1) / count));
    }
    return sum;
}

Result<void> add_map(Compilation& c, const Equirect& map, float rotation_degrees, bool smooth) {
    CompiledScene& out = c.out;
    const std::size_t width = std::size_t(map.width), height = std::size_t(map.height);
    const Result<kernels::uint> place =
        pool_place(out.floats.size(), 3 * width * height + (width + 1) * height + height + 1, NUMBERS);
    if (!place) return place.error();
    kernels::Environment& e = out.environment;
    e.width = uint(map.width);
    e.height = uint(map.height);
    e.filter_kind = smooth ? kernels::FILTER_TRILINEAR : kernels::FILTER_NEAREST;
    const float a = glm::radians(rotation_degrees);
    e.world_to_local = mat3(vec3(std::cos(a), 0, std::sin(a)), vec3(0, 1, 0), vec3(-std::sin(a), 0, std::cos(a)));
    e.radiance_first = uint(out.floats.size());
    for (const vec3& rgb : map.radiance) out.floats.insert(out.floats.end(), {rgb.x, rgb.y, rgb.z});
    const std::vector<double> weights = texel_weights(map, smooth);
    std::vector<double> rows;
    e.conditional_first = uint(out.floats.size());
    for (int y = 0; y < map.height; ++y)
        rows.push_back(
            append_cumulative(out.floats, weights.data() + std::size_t(y) * std::size_t(map.width), map.width));
    e.marginal_first = uint(out.floats.size());
    const double total = append_cumulative(out.floats, rows.data(), map.height);
    e.light = NONE;
    if (!(total > 0)) return {};
    kernels::Light light = {};
    light.kind = kernels::LIGHT_ENVIRONMENT;
    light.instance = light.material = NONE;
    light.key = kernels::uvec2(NONE);
    light.radiance = vec3(float(total / (2.0 * map.width)));  // mean
    e.light = uint(out.lights.size());
    out.lights.push_back(light);
    return {};
}

Result<void> add_sky(Compilation& c, const SkyEnvironment& sky) {
    const float elevation = glm::radians(sky.sun_elevation), azimuth = glm::radians(sky.sun_azimuth);
    const vec3 to_sun(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                      std::cos(elevation) * std::cos(azimuth));
    if (Result<void> added = add_map(c, from_sky(sky, to_sun), 0, true); !added) return added;
    if (!sky.sun) return {};
    const vec3 irradiance = sky.scale * kernels::sun_irradiance(to_sun, sky.haze);
    if (kernels::is_black(irradiance)) return {};
    kernels::Light light = {};
    light.kind = kernels::LIGHT_DIRECTIONAL;
    light.instance = light.material = NONE;
    light.key = kernels::uvec2(NONE);
    light.direction = -to_sun;
    light.radius = glm::radians(sky.sun_angular_radius);
    light.radiance = light.radius > 0 ? irradiance / (kernels::PI * kernels::sqr(std::sin(light.radius))) : irradiance;
    c.out.lights.push_back(light);
    return {};
}

}  // namespace

Result<void> add_environment(Compilation& c) {
    c.out.environment.light = NONE;
    c.out.environment.world_to_local = mat3(1);
    if (const auto* constant = std::get_if<ConstantEnvironment>(&c.scene.environment))
        return add_map(c, {1, 1, {constant->radiance}}, 0, false);
    if (const auto* image = std::get_if<ImageEnvironment>(&c.scene.environment))
        return add_map(c, from_image(*image), image->rotation, image->filter == Filter::linear);
    if (const auto* sky = std::get_if<SkyEnvironment>(&c.scene.environment)) return add_sky(c, *sky);
    return {};
}

}  // namespace spinel
