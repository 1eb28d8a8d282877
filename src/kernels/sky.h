#ifndef SPINEL_KERNELS_SKY_H
#define SPINEL_KERNELS_SKY_H
// Clear sky. Nishita et al., "Display of the Earth Taking into Account Atmospheric Scattering", SIGGRAPH
// 1993: sunlight scattered once by air (Rayleigh) and haze (Mie) on its way to the eye, attenuated along both
// legs by them and by ozone, integrated numerically over a spherical shell. What is scattered more than once
// is left out, so the true sky is a little brighter, most of all near the horizon.
//
// Coefficients at sea level are those of Hillaire, "A Scalable and Production Ready Sky and Atmosphere
// Rendering Technique", EGSR 2020 (table 1; red, green, blue stand for 680, 550 and 440 nm, after Bruneton
// 2017). Lengths in kilometres. The eye is at sea level, +y is up.
//
// Units: the sun above the atmosphere has white irradiance SKY_SUN_IRRADIANCE, chosen so that a white
// horizontal surface under a sun at 40° and the sky around it has radiance 1.
#include "phase.h"
KERNELS_BEGIN

const float SKY_GROUND_RADIUS = 6360.0f;
const float SKY_TOP_RADIUS = 6460.0f;
const float SKY_AIR_SCALE_HEIGHT = 8.0f;  // density falls by e
const float SKY_HAZE_SCALE_HEIGHT = 1.2f;
const float SKY_OZONE_CENTER = 25.0f;         // a tent about this height …
const float SKY_OZONE_HALF_WIDTH = 15.0f;     // … that ends here
const float SKY_HAZE_SCATTERING = 3.996e-3f;  // per km, times the haze
const float SKY_HAZE_ABSORPTION = 4.40e-3f;
const float SKY_HAZE_G = 0.8f;
const float SKY_SUN_IRRADIANCE = 5.0f;
const float SKY_SUN_RADIUS = 0.004625f;  // angular, radians: how long a sunset takes
const float SKY_GROUND_ALBEDO = 0.2f;

FN vec3 sky_air_scattering() { return vec3(5.802e-3f, 13.558e-3f, 33.1e-3f); }    // per km
FN vec3 sky_ozone_absorption() { return vec3(0.650e-3f, 1.881e-3f, 0.085e-3f); }  // per km

// Relative densities of air, haze and ozone.
FN vec3 sky_densities(float height) {
    float h = max(height, 0.0f);
    return vec3(exp(-h / SKY_AIR_SCALE_HEIGHT), exp(-h / SKY_HAZE_SCALE_HEIGHT),
                max(0.0f, 1.0f - abs(h - SKY_OZONE_CENTER) / SKY_OZONE_HALF_WIDTH));
}

// Transmittance over a column: densities integrated along it, in km.
FN vec3 sky_transmittance(vec3 column, float haze) {
    vec3 depth = sky_air_scattering() * column.x + vec3((SKY_HAZE_SCATTERING + SKY_HAZE_ABSORPTION) * haze * column.y) +
                 sky_ozone_absorption() * column.z;
    return exp(-depth);
}

// From radius r, under cosine µ to the vertical: distance to the top of the atmosphere.
FN float sky_distance_to_top(float r, float mu) {
    return -r * mu + safe_sqrt(r * r * (mu * mu - 1.0f) + SKY_TOP_RADIUS * SKY_TOP_RADIUS);
}
FN bool sky_hits_ground(float r, float mu) {
    return mu < 0.0f && r * r * (mu * mu - 1.0f) + SKY_GROUND_RADIUS * SKY_GROUND_RADIUS > 0.0f;
}
FN float sky_radius_along(float r, float mu, float t) { return safe_sqrt(r * r + 2.0f * r * mu * t + t * t); }

// Densities integrated from radius r to the top, by midpoints that lie denser near the start.
FN vec3 sky_column(float r, float mu, uint steps) {
    float distance_to_top = sky_distance_to_top(r, mu);
    vec3 column = vec3(0.0f);
    for (uint i = 0u; i < steps; ++i) {
        float s = (float(i) + 0.5f) / float(steps);
        float t = s * s * distance_to_top;
        float dt = 2.0f * s / float(steps) * distance_to_top;
        column += sky_densities(sky_radius_along(r, mu, t) - SKY_GROUND_RADIUS) * dt;
    }
    return column;
}

// Haze scatters forward: Cornette, Shanks, "Physically reasonable analytic expression for the
// single-scattering phase function", Applied Optics 31(16), 1992.
FN float sky_haze_phase(float cosine) {
    float g = SKY_HAZE_G;
    float g2 = g * g;
    float d = max(1.0f + g2 - 2.0f * g * cosine, 1e-4f);
    return 3.0f / (8.0f * PI) * (1.0f - g2) * (1.0f + cosine * cosine) / ((2.0f + g2) * d * sqrt(d));
}
FN float sky_air_phase(float cosine) { return 3.0f / (16.0f * PI) * (1.0f + cosine * cosine); }

// Light scattered once towards the eye from a direction above the horizon.
FN vec3 sky_single_scattering(vec3 direction, vec3 to_sun, float haze, uint view_steps, uint sun_steps) {
    float r = SKY_GROUND_RADIUS + 0.001f;
    float mu = max(direction.y, 0.0f);
    float distance_to_top = sky_distance_to_top(r, mu);
    float cosine = dot(direction, to_sun);
    vec3 column = vec3(0.0f);
    vec3 air = vec3(0.0f);
    vec3 haze_light = vec3(0.0f);
    for (uint i = 0u; i < view_steps; ++i) {
        float s = (float(i) + 0.5f) / float(view_steps);
        float t = s * s * distance_to_top;
        float dt = 2.0f * s / float(view_steps) * distance_to_top;
        float radius = sky_radius_along(r, mu, t);
        vec3 densities = sky_densities(radius - SKY_GROUND_RADIUS);
        vec3 here = column + 0.5f * dt * densities;
        column += dt * densities;
        float sun_mu = clamp((r * to_sun.y + t * cosine) / radius, -1.0f, 1.0f);
        if (sky_hits_ground(radius, sun_mu)) continue;
        vec3 light = sky_transmittance(here + sky_column(radius, sun_mu, sun_steps), haze) * dt;
        air += light * densities.x;
        haze_light += light * densities.y;
    }
    return SKY_SUN_IRRADIANCE * (air * sky_air_scattering() * sky_air_phase(cosine) +
                                 haze_light * (SKY_HAZE_SCATTERING * haze * sky_haze_phase(cosine)));
}

const uint SKY_VIEW_STEPS = 32u;
const uint SKY_SUN_STEPS = 10u;

// Irradiance at the ground on a surface that faces the sun. It sets over the width of its disc.
FN vec3 sun_irradiance(vec3 to_sun, float haze) {
    float visible = smoothstep(-SKY_SUN_RADIUS, SKY_SUN_RADIUS, to_sun.y);
    if (visible == 0.0f) return vec3(0.0f);
    vec3 column = sky_column(SKY_GROUND_RADIUS + 0.001f, max(to_sun.y, 0.0f), 64u);
    return visible * SKY_SUN_IRRADIANCE * sky_transmittance(column, haze);
}

// Radiance from a direction, the sun's disc left out. Below the horizon the sky's lowest light passes
// smoothly into that of a grey ground under this sun and sky.
FN vec3 sky_radiance(vec3 direction, vec3 to_sun, float haze) {
    if (direction.y >= 0.0f) return sky_single_scattering(direction, to_sun, haze, SKY_VIEW_STEPS, SKY_SUN_STEPS);
    vec3 horizontal = vec3(direction.x, 0.0f, direction.z);
    float length_squared = dot(horizontal, horizontal);
    // The sky's irradiance on the ground by four directions at 45°, the cosine-weighted middle of a
    // hemisphere.
    const float h = 0.70710678f;
    vec3 sky = sky_single_scattering(vec3(h, h, 0.0f), to_sun, haze, 8u, 6u) +
               sky_single_scattering(vec3(-h, h, 0.0f), to_sun, haze, 8u, 6u) +
               sky_single_scattering(vec3(0.0f, h, h), to_sun, haze, 8u, 6u) +
               sky_single_scattering(vec3(0.0f, h, -h), to_sun, haze, 8u, 6u);
    vec3 irradiance = sky * (0.25f * PI) + sun_irradiance(to_sun, haze) * max(to_sun.y, 0.0f);
    vec3 ground = irradiance * (SKY_GROUND_ALBEDO * INV_PI);
    float below = smoothstep(0.0f, 0.15f, -direction.y);
    if (below == 1.0f || length_squared == 0.0f) return ground;
    vec3 horizon =
        sky_single_scattering(horizontal * inversesqrt(length_squared), to_sun, haze, SKY_VIEW_STEPS, SKY_SUN_STEPS);
    return mix(horizon, ground, below);
}

KERNELS_END
#endif
