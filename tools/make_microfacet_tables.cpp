// Writes src/kernels/microfacet_tables.h: what single scattering between GGX microfacets loses. Run it after
// a change of the distribution, the masking or the tables' coordinates, from the root of the source tree:
//   g++ -std=c++20 -O3 -Isrc tools/make_microfacet_tables.cpp -o /tmp/tables && /tmp/tables >
//   src/kernels/microfacet_tables.h
// Each entry is a mean over a low-discrepancy set of visible normals; averages over µ integrate the entries
// as they will be interpolated, so that the compensating lobe integrates to exactly what the interpolated
// table says is missing.

#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "kernels/fresnel.h"
#include "kernels/microfacet.h"
#include "kernels/random.h"

// The reading functions need a table; here they read the one in the making.
namespace spinel::kernels {
std::vector<uint> MICROFACET_TABLE(1 << 16);
const uint GGX_MISSING_FIRST = 0, GGX_MISSING_WIDTH = 32, GGX_MISSING_HEIGHT = 32;
const uint GGX_SCHLICK_FIRST = GGX_MISSING_FIRST + GGX_MISSING_WIDTH * GGX_MISSING_HEIGHT;
const uint GGX_SCHLICK_WIDTH = 16, GGX_SCHLICK_HEIGHT = 16;
const uint GGX_MISSING_AVERAGE_FIRST = GGX_SCHLICK_FIRST + GGX_SCHLICK_WIDTH * GGX_SCHLICK_HEIGHT;
const uint GGX_SCHLICK_AVERAGE_FIRST = GGX_MISSING_AVERAGE_FIRST + GGX_MISSING_HEIGHT;
const uint DIELECTRIC_HEIGHT = 16, DIELECTRIC_DEPTH = 11;
const uint THIN_MISSING_FIRST = GGX_SCHLICK_AVERAGE_FIRST + GGX_SCHLICK_HEIGHT, THIN_MISSING_WIDTH = 16;
const uint DENSE_MISSING_FIRST =
    THIN_MISSING_FIRST + THIN_MISSING_WIDTH * DIELECTRIC_HEIGHT * DIELECTRIC_DEPTH;
const uint DENSE_MISSING_WIDTH = 33;
const uint THIN_MISSING_AVERAGE_FIRST =
    DENSE_MISSING_FIRST + DENSE_MISSING_WIDTH * DIELECTRIC_HEIGHT * DIELECTRIC_DEPTH;
const uint DENSE_MISSING_AVERAGE_FIRST = THIN_MISSING_AVERAGE_FIRST + DIELECTRIC_HEIGHT * DIELECTRIC_DEPTH;
const uint TABLE_COUNT = DENSE_MISSING_AVERAGE_FIRST + DIELECTRIC_HEIGHT * DIELECTRIC_DEPTH;
}  // namespace spinel::kernels
#define SPINEL_KERNELS_MICROFACET_TABLES_H
#include "kernels/microfacet_energy.h"

using namespace spinel::kernels;

namespace {

struct Albedo {
    double whole;    // of reflection and, for dielectrics, transmission
    double schlick;  // of reflection weighted by Schlick's (1 − µ)⁵
};

// relative_ior 0: a perfect conductor.
Albedo single_scattering(float alpha, float mu, float relative_ior) {
    const uint count = 16384;
    const glm::vec3 wo(std::sqrt(std::max(0.0f, 1.0f - mu * mu)), 0.0f, mu);
    const float lambda = ggx_lambda(alpha, wo);
    auto seen = [&](glm::vec3 wi) { return (1.0f + lambda) / (1.0f + lambda + ggx_lambda(alpha, wi)); };
    Albedo sum{0, 0};
    for (uint i = 0; i < count; ++i) {
        Sampler sampler = make_sampler(glm::uvec2(0), i, 1);
        const glm::vec3 m = ggx_sample(alpha, wo, sampler_2d(sampler));
        const float om = glm::dot(wo, m);
        if (!(om > 0.0f)) continue;
        const float reflected = relative_ior == 0.0f ? 1.0f : fresnel_dielectric(om, relative_ior);
        const glm::vec3 up = 2.0f * om * m - wo;
        if (up.z > 0.0f) {
            sum.whole += reflected * seen(up);
            sum.schlick += schlick_weight(om) * seen(up);
        }
        if (reflected < 1.0f) {
            const glm::vec3 down =
                (om / relative_ior - refracted_cosine(om, relative_ior)) * m - wo / relative_ior;
            if (down.z < 0.0f) sum.whole += (1.0f - reflected) * seen(down);
        }
    }
    return {sum.whole / count, sum.schlick / count};
}

// Inverses of the coordinates of microfacet_energy.h, by bisection: they are monotonic.
float solve(float target, const std::function<float(float)>& coordinate) {
    float low = 0.0f, high = 1.0f;
    for (int i = 0; i < 60; ++i)
        (coordinate(0.5f * (low + high)) < target ? low : high) = 0.5f * (low + high);
    return std::max(0.5f * (low + high), 1e-4f);
}

void store(uint i, double value) {
    const uint bits = uint(glm::clamp(value, 0.0, 1.0) * 65535.0 + 0.5);
    uint& word = MICROFACET_TABLE[i >> 1];
    word = (i & 1u) ? (word & 0xffffu) | (bits << 16) : (word & 0xffff0000u) | bits;
}

double cosine_average(const std::function<double(float)>& f) {
    const int count = 8192;
    double sum = 0;
    for (int i = 0; i < count; ++i) {
        const double t = (i + 0.5) / count, mu = t * t;  // more where µ is small
        sum += f(float(mu)) * 2 * mu * 2 * t;
    }
    return sum / count;
}

}  // namespace

int main() {
    auto node = [](uint i, uint count) { return float(i) / float(count - 1); };
    for (uint y = 0; y < GGX_MISSING_HEIGHT; ++y) {
        const float roughness = node(y, GGX_MISSING_HEIGHT), alpha = microfacet_table_alpha(roughness);
        for (uint x = 0; x < GGX_MISSING_WIDTH; ++x) {
            const float mu = solve(node(x, GGX_MISSING_WIDTH),
                                   [&](float m) { return std::sqrt(microfacet_warp(m, alpha)); });
            store(GGX_MISSING_FIRST + y * GGX_MISSING_WIDTH + x, 1 - single_scattering(alpha, mu, 0).whole);
        }
        store(GGX_MISSING_AVERAGE_FIRST + y,
              cosine_average([&](float mu) { return ggx_missing(roughness, mu); }));
    }
    for (uint y = 0; y < GGX_SCHLICK_HEIGHT; ++y) {
        const float roughness = node(y, GGX_SCHLICK_HEIGHT), alpha = microfacet_table_alpha(roughness);
        for (uint x = 0; x < GGX_SCHLICK_WIDTH; ++x) {
            const float mu = solve(node(x, GGX_SCHLICK_WIDTH),
                                   [&](float m) { return microfacet_warp(m, std::sqrt(alpha)); });
            const Albedo albedo = single_scattering(alpha, mu, 0);
            store(GGX_SCHLICK_FIRST + y * GGX_SCHLICK_WIDTH + x,
                  0.5 + 1 - std::pow(albedo.schlick / albedo.whole, 0.2) - mu);
        }
        store(GGX_SCHLICK_AVERAGE_FIRST + y, cosine_average([&](float mu) {
                  return ggx_schlick_part(roughness, mu, ggx_missing(roughness, mu));
              }));
    }
    for (uint z = 0; z < DIELECTRIC_DEPTH; ++z) {
        const float e = std::max(0.5f * node(z, DIELECTRIC_DEPTH), 0.002f);
        const float n = (1 + e) / (1 - e);
        for (uint y = 0; y < DIELECTRIC_HEIGHT; ++y) {
            const float roughness = node(y, DIELECTRIC_HEIGHT), alpha = microfacet_table_alpha(roughness);
            const uint row = z * DIELECTRIC_HEIGHT + y;
            for (uint x = 0; x < THIN_MISSING_WIDTH; ++x) {
                const float mu = solve(node(x, THIN_MISSING_WIDTH),
                                       [&](float m) { return std::sqrt(microfacet_warp(m, alpha)); });
                store(THIN_MISSING_FIRST + row * THIN_MISSING_WIDTH + x,
                      1 - single_scattering(alpha, mu, n).whole);
            }
            for (uint x = 0; x < DENSE_MISSING_WIDTH; ++x) {
                const float mu = solve(node(x, DENSE_MISSING_WIDTH),
                                       [&](float m) { return microfacet_critical_coordinate(m, alpha, n); });
                store(DENSE_MISSING_FIRST + row * DENSE_MISSING_WIDTH + x,
                      1 - single_scattering(alpha, mu, 1 / n).whole);
            }
        }
    }
    for (uint z = 0; z < DIELECTRIC_DEPTH; ++z) {
        const float e = std::max(0.5f * node(z, DIELECTRIC_DEPTH), 0.002f);
        const float n = (1 + e) / (1 - e);
        for (uint y = 0; y < DIELECTRIC_HEIGHT; ++y) {
            const float roughness = node(y, DIELECTRIC_HEIGHT);
            const uint row = z * DIELECTRIC_HEIGHT + y;
            store(THIN_MISSING_AVERAGE_FIRST + row,
                  cosine_average([&](float mu) { return dielectric_missing(roughness, mu, n); }));
            store(DENSE_MISSING_AVERAGE_FIRST + row,
                  cosine_average([&](float mu) { return dielectric_missing(roughness, mu, 1 / n); }));
        }
    }

    std::printf(
        "#ifndef SPINEL_KERNELS_MICROFACET_TABLES_H\n#define SPINEL_KERNELS_MICROFACET_TABLES_H\n"
        "// Written by tools/make_microfacet_tables.cpp; microfacet_energy.h says what it holds and reads "
        "it.\n"
        "// clang-format off\n#include \"constants.h\"\nKERNELS_BEGIN\n\n");
    auto constant = [](const char* name, uint value) { std::printf("const uint %s = %uu;\n", name, value); };
#define CONSTANT(name) constant(#name, name)
    CONSTANT(GGX_MISSING_FIRST);
    CONSTANT(GGX_MISSING_WIDTH);
    CONSTANT(GGX_MISSING_HEIGHT);
    CONSTANT(GGX_MISSING_AVERAGE_FIRST);
    CONSTANT(GGX_SCHLICK_FIRST);
    CONSTANT(GGX_SCHLICK_WIDTH);
    CONSTANT(GGX_SCHLICK_HEIGHT);
    CONSTANT(GGX_SCHLICK_AVERAGE_FIRST);
    CONSTANT(DIELECTRIC_HEIGHT);
    CONSTANT(DIELECTRIC_DEPTH);
    CONSTANT(THIN_MISSING_FIRST);
    CONSTANT(THIN_MISSING_WIDTH);
    CONSTANT(THIN_MISSING_AVERAGE_FIRST);
    CONSTANT(DENSE_MISSING_FIRST);
    CONSTANT(DENSE_MISSING_WIDTH);
    CONSTANT(DENSE_MISSING_AVERAGE_FIRST);
#undef CONSTANT
    const uint words = (TABLE_COUNT + 1) / 2;
    constant("MICROFACET_TABLE_COUNT", words);
    std::printf("\n#ifndef SPINEL_TABLE_ELSEWHERE\nconst uint MICROFACET_TABLE[%u] = {", words);
    for (uint i = 0; i < words; ++i) {
        std::printf("%s0x%08xu%s", i % 9 == 0 ? "\n    " : " ", MICROFACET_TABLE[i],
                    i + 1 < words ? "," : "");
    }
    std::printf("};\n#endif\n\nKERNELS_END\n#endif\n");
}
