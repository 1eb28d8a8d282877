// What every material must keep, whatever it is: looped over the registry, so a new material is tested by
// being there.

#include "kernels/bsdf.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <string>

#include "kernels/random.h"
#include "sampling_statistics.h"
#include "scene/material_registry.h"

namespace spinel::bsdf_test {
namespace {

using namespace kernels;
using glm::dvec3;
using glm::uvec2;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using kernels::Material;  // not the scene's

struct Case {
    std::string name;
    Bsdf bsdf;
    float relative_ior;
    float metallic;
    bool layered = false;  // principled with a coat or as a thin wall
};

// The layers of principled; a thin wall has the same index on both sides.
void add_layered_cases(std::vector<Case>& cases, float roughness, vec3 color) {
    struct Layers {
        float coat, coat_roughness, transmission;
    };
    for (const Layers& l : {Layers{1, 0, 0}, Layers{0.6f, 0.4f, 0}, Layers{0, 0, 1}, Layers{0.5f, 0.2f, 0.5f}}) {
        for (float metallic : {0.0f, 0.4f, 1.0f}) {
            Material m = default_material(MATERIAL_PRINCIPLED);
            m.coat = l.coat;
            m.coat_roughness = l.coat_roughness;
            m.transmission = l.transmission;
            cases.push_back({"principled, roughness " + std::to_string(roughness) + ", metallic " +
                                 std::to_string(metallic) + ", coat " + std::to_string(l.coat) + " of roughness " +
                                 std::to_string(l.coat_roughness) + ", transmission " + std::to_string(l.transmission),
                             make_bsdf(m, color, roughness, metallic, 1), 1, metallic, true});
        }
    }
}

// Every registered kind, over roughness, metalness where it counts, and the sides of an interface.
std::vector<Case> all_cases(const std::vector<float>& roughnesses, vec3 color) {
    std::vector<Case> cases;
    for (const MaterialInfo& info : material_infos()) {
        auto has = [&](std::string_view name) {
            return std::any_of(info.parameters.begin(), info.parameters.end(),
                               [&](const MaterialParameter& p) { return p.name == name; });
        };
        const std::vector<float> metallics =
            has("metallic") ? std::vector<float>{0.0f, 0.4f, 1.0f} : std::vector<float>{0.0f};
        const std::vector<float> iors =
            has("ior") ? std::vector<float>{1.5f, 1 / 1.5f, 1 / 2.2f} : std::vector<float>{1.0f};
        for (float roughness : roughnesses) {
            for (float metallic : metallics) {
                for (float ior : iors) {
                    Material m = default_material(info.kind);
                    m.ior = std::max(ior, 1 / ior);
                    cases.push_back({std::string(info.name) + ", roughness " + std::to_string(roughness) +
                                         ", metallic " + std::to_string(metallic) + ", ior " + std::to_string(ior),
                                     make_bsdf(m, color, roughness, metallic, ior), ior, metallic});
                }
            }
        }
    }
    for (float roughness : roughnesses) add_layered_cases(cases, roughness, color);
    return cases;
}

vec3 at_angle(float cosine, float phi = 0.7f) {
    const float sine = std::sqrt(1 - cosine * cosine);
    return vec3(sine * std::cos(phi), sine * std::sin(phi), cosine);
}

vec3 rgb(vec4 v) { return vec3(v.x, v.y, v.z); }

BsdfSample draw(const Bsdf& b, vec3 wo, uint i, uint seed = 0) {
    Sampler s = make_sampler(uvec2(3, 1), i, seed);
    const float u_lobe = sampler_1d(s);
    return bsdf_sample(b, wo, u_lobe, sampler_2d(s));
}

// Flux that leaves for each unit that arrives along wo; transmission freed from the scaling of radiance.
dvec3 albedo(const Case& c, vec3 wo, uint count) {
    // Additive recurrence by powers of the root of x⁴ = x + 1 (Roberts 2018): three dimensions that are even
    // together.
    constexpr double g = 1.2207440846057596;
    dvec3 sum(0);
    for (uint i = 0; i < count; ++i) {
        const dvec3 u = glm::fract(dvec3(1 / g, 1 / (g * g), 1 / (g * g * g)) * double(i) + 0.5);
        const BsdfSample s = bsdf_sample(c.bsdf, wo, std::min(float(u.x), ONE_MINUS_EPSILON),
                                         glm::min(vec2(float(u.y), float(u.z)), vec2(ONE_MINUS_EPSILON)));
        const bool crosses = (s.flags & LOBE_TRANSMISSION) != 0u;
        sum += dvec3(s.weight) * double(crosses ? c.relative_ior * c.relative_ior : 1.0f);
    }
    return sum / double(count);
}

void expect_samples_follow_density(const std::vector<float>& roughnesses, const std::vector<float>& cosines, int count,
                                   int bins, int max_depth) {
    std::vector<std::pair<Case, float>> tests;
    for (const Case& c : all_cases(roughnesses, vec3(0.8f, 0.5f, 0.2f))) {
        if (bsdf_is_delta(c.bsdf)) continue;
        for (float cosine : cosines) tests.push_back({c, cosine});
    }
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0.0f, ONE_MINUS_EPSILON);
    for (const auto& [c, cosine] : tests) {
        const vec3 wo = at_angle(cosine);
        test::SphereChiSquare chi(bins, bins);
        for (int i = 0; i < count; ++i) {
            const float u_lobe = uniform(random), u = uniform(random);
            const BsdfSample s = bsdf_sample(c.bsdf, wo, u_lobe, vec2(u, uniform(random)));
            if ((s.flags & (LOBE_FAILED | LOBE_DELTA)) != 0u) chi.add_without_direction();
            else chi.add(s.direction);
        }
        const double p = chi.p_value([&](vec3 wi) { return double(bsdf_pdf(c.bsdf, wo, wi)); }, max_depth);
        EXPECT_GT(p, test::sidak_threshold(int(tests.size()))) << c.name << ", cosine " << cosine << ", seed 7";
        EXPECT_LT(chi.integral(), 1.001) << c.name << ", cosine " << cosine << ", seed 7";
    }
}

TEST(Bsdf, samples_follow_their_density) {
    expect_samples_follow_density({0.0f, 0.3f, 0.8f}, {0.15f, 0.8f}, 20000, 16, 8);
}

TEST(BsdfSlow, samples_follow_their_density_finely) {
    expect_samples_follow_density({0.0f, 0.15f, 0.3f, 0.5f, 0.75f, 1.0f}, {0.03f, 0.15f, 0.5f, 0.8f, 1.0f}, 400000, 32,
                                  13);
}

TEST(Bsdf, weight_is_value_over_density) {
    for (const Case& c : all_cases({0.0f, 0.05f, 0.3f, 1.0f}, vec3(0.8f, 0.5f, 0.2f))) {
        for (float cosine : {0.01f, 0.3f, 0.9f, 1.0f}) {
            const vec3 wo = at_angle(cosine);
            for (uint i = 0; i < 200; ++i) {
                SCOPED_TRACE(testing::Message() << c.name << ", cosine " << cosine << ", sample " << i << " of seed 0");
                const BsdfSample s = draw(c.bsdf, wo, i);
                ASSERT_TRUE(std::isfinite(s.weight.x + s.weight.y + s.weight.z) && std::isfinite(s.pdf));
                ASSERT_GE(min_component(s.weight), 0.0f);
                if ((s.flags & LOBE_FAILED) != 0u) {
                    ASSERT_TRUE(is_black(s.weight));
                    continue;
                }
                ASSERT_NEAR(glm::length(s.direction), 1.0f, 1e-4f);
                ASSERT_EQ((s.flags & LOBE_TRANSMISSION) != 0u, s.direction.z < 0.0f);
                ASSERT_GT(s.pdf, 0.0f);
                if ((s.flags & LOBE_DELTA) != 0u) {
                    ASSERT_LE(s.pdf, 1.0f);
                    continue;
                }
                const vec4 value_pdf = bsdf_eval_pdf(c.bsdf, wo, s.direction);
                ASSERT_NEAR(value_pdf.w / s.pdf, 1.0f, 1e-4f);
                const vec3 value = s.weight * s.pdf;
                ASSERT_LE(glm::length(value - rgb(value_pdf)), 1e-4f * glm::length(value) + 1e-12f);
                ASSERT_EQ(bsdf_eval(c.bsdf, wo, s.direction), rgb(value_pdf));
                ASSERT_EQ(bsdf_pdf(c.bsdf, wo, s.direction), value_pdf.w);
            }
        }
    }
}

// f(o, i) = f(i, o); across an interface f/n² is symmetric. Radiance f carries 1/η², so f(o, i) η² = f(i, o).
TEST(Bsdf, is_reciprocal) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
    for (const MaterialInfo& info : material_infos()) {
        int compared = 0;
        for (int i = 0; i < 4000; ++i) {
            Material m = default_material(info.kind);
            m.ior = 1.2f + uniform(random);
            const vec3 color(uniform(random), uniform(random), uniform(random));
            const float roughness = 0.15f + 0.85f * uniform(random), metallic = uniform(random);
            const float eta = (i & 1) != 0 ? m.ior : 1 / m.ior;
            const float u = uniform(random);
            const vec3 wo = square_to_hemisphere(vec2(u, 0.99f * uniform(random)));
            const float v = uniform(random);
            const vec3 wi = square_to_sphere(vec2(v, uniform(random)));
            if (std::abs(wi.z) < 0.01f) continue;
            const Bsdf forth = make_bsdf(m, color, roughness, metallic, eta);
            const dvec3 a = dvec3(bsdf_eval(forth, wo, wi)) / double(std::abs(wi.z));
            dvec3 b;
            if (wi.z > 0) {
                b = dvec3(bsdf_eval(forth, wi, wo)) / double(wo.z);
            } else {
                const Bsdf back = make_bsdf(m, color, roughness, metallic, 1 / eta);
                b = dvec3(bsdf_eval(back, -wi, -wo)) / double(wo.z) / double(eta * eta);
            }
            ASSERT_LE(glm::length(a - b), 2e-3 * glm::length(a + b) + 1e-6)
                << info.name << ", draw " << i << " of seed 3: color " << color.x << " " << color.y << " " << color.z
                << ", roughness " << roughness << ", metallic " << metallic << ", eta " << eta << ", wo " << wo.x << " "
                << wo.y << " " << wo.z << ", wi " << wi.x << " " << wi.y << " " << wi.z;
            if (glm::length(a) > 1e-6) ++compared;
        }
        EXPECT_GT(compared, 500) << info.name << ", seed 3";
    }
}

TEST(Bsdf, never_returns_more_than_it_gets) {
    for (float level : {0.3f, 1.0f}) {
        for (const Case& c : all_cases({0.0f, 0.1f, 0.25f, 0.6f, 1.0f}, vec3(level))) {
            for (float cosine : {0.05f, 0.3f, 0.7f, 1.0f}) {
                // Light between the microfacets of a wall comes in rare bright samples.
                // Thin walls have rare bright samples, so layers take more of them.
                EXPECT_LE(max_component(vec3(albedo(c, at_angle(cosine), c.layered ? 65536 : 8192))), 1.01f)
                    << c.name << ", cosine " << cosine << ", color " << level;
            }
        }
    }
}

// A white furnace: whatever the roughness, nothing is lost.
void expect_white(std::string_view kind, const std::vector<float>& roughnesses, float tolerance, uint count) {
    int tested = 0;
    for (const Case& c : all_cases(roughnesses, vec3(1.0f))) {
        if (c.bsdf.kind != find_material_info(kind)->kind || c.layered) continue;
        for (float cosine : {0.05f, 0.1f, 0.3f, 0.5f, 0.7f, 0.9f, 1.0f}) {
            EXPECT_NEAR(albedo(c, at_angle(cosine), count).x, 1.0, tolerance) << c.name << ", cosine " << cosine;
            ++tested;
        }
    }
    EXPECT_GT(tested, 0);
}
const std::vector<float> furnace_roughnesses = {0.0f, 0.1f, 0.2f, 0.3f, 0.45f, 0.6f, 0.7f, 0.85f, 0.95f, 1.0f};

TEST(BsdfFurnace, white_diffuse_loses_nothing) { expect_white("diffuse", furnace_roughnesses, 0.002f, 32768); }
TEST(BsdfFurnace, white_metal_loses_nothing) { expect_white("metal", furnace_roughnesses, 0.005f, 65536); }
TEST(BsdfFurnace, glass_loses_nothing) { expect_white("dielectric", {0.0f, 0.1f, 0.3f, 0.45f, 0.6f}, 0.005f, 65536); }
TEST(BsdfFurnace, rough_glass_loses_nothing) { expect_white("dielectric", {0.7f, 0.85f, 1.0f}, 0.01f, 16384); }
TEST(BsdfFurnace, white_plastic_loses_nothing) { expect_white("plastic", furnace_roughnesses, 0.008f, 16384); }
TEST(BsdfFurnace, white_principled_loses_nothing) { expect_white("principled", furnace_roughnesses, 0.008f, 16384); }

// What a coat sends back down to rough metal under it is lost in part, a little of it to what is not metal; all else
// comes out.
TEST(BsdfFurnace, white_layers_lose_little) {
    int tested = 0;
    for (const Case& c : all_cases({0.0f, 0.1f, 0.3f, 0.6f, 1.0f}, vec3(1.0f))) {
        if (!c.layered) continue;
        const bool coated_metal = c.bsdf.coat > 0 && c.metallic > 0;
        for (float cosine : {0.1f, 0.3f, 0.6f, 1.0f}) {
            const double white = albedo(c, at_angle(cosine), 32768).x;
            EXPECT_LT(white, 1.008) << c.name << ", cosine " << cosine;
            EXPECT_GT(white, coated_metal ? 0.92 : 0.97) << c.name << ", cosine " << cosine;
            ++tested;
        }
    }
    EXPECT_EQ(tested, 240);
}

TEST(Bsdf, layers_are_reciprocal) {
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
    int reflected = 0, transmitted = 0;
    for (int i = 0; i < 4000; ++i) {
        Material m = default_material(MATERIAL_PRINCIPLED);
        m.ior = 1.2f + uniform(random);
        m.coat = uniform(random);
        m.coat_roughness = 0.15f + 0.85f * uniform(random);
        m.transmission = uniform(random);
        const float roughness = 0.15f + 0.85f * uniform(random), metallic = uniform(random);
        const vec3 color(uniform(random), uniform(random), uniform(random));
        const Bsdf b = make_bsdf(m, color, roughness, metallic, 1);
        const vec3 wo = at_angle(0.02f + 0.98f * uniform(random), 6 * uniform(random));
        const vec3 up = at_angle(0.02f + 0.98f * uniform(random), 6 * uniform(random));
        const bool through = (i & 1) != 0;
        const vec3 wi = through ? -up : up;
        const vec3 forth = bsdf_eval(b, wo, wi) / up.z;
        const vec3 back = (through ? bsdf_eval(b, up, -wo) : bsdf_eval(b, up, wo)) / wo.z;
        ASSERT_LE(glm::length(forth - back), 2e-3f * glm::length(forth + back) + 1e-6f) << "draw " << i << " of seed 4";
        if (glm::length(forth) > 1e-6f) ++(through ? transmitted : reflected);
    }
    EXPECT_GT(reflected, 1500);
    EXPECT_GT(transmitted, 1500);
}

TEST(Bsdf, a_clear_thin_wall_lets_light_pass_unbent) {
    Material m = default_material(MATERIAL_PRINCIPLED);
    m.transmission = 1;
    const vec3 color(0.9f, 0.5f, 0.1f);
    const Bsdf b = make_bsdf(m, color, 0, 0, 1);
    EXPECT_TRUE(bsdf_is_delta(b));
    for (float cosine : {0.2f, 0.7f, 1.0f}) {
        const vec3 wo = at_angle(cosine);
        const BsdfSample s = bsdf_sample(b, wo, ONE_MINUS_EPSILON, vec2(0.3f));
        EXPECT_EQ(s.direction, -wo);
        EXPECT_EQ(s.flags, LOBE_DELTA | LOBE_TRANSMISSION);
        const float through = (1 - 0.04f) * (1 - schlick_weight(cosine));
        EXPECT_LT(glm::length(s.weight * s.pdf - color * through), 1e-5f) << cosine;
    }
}

TEST(BsdfSlow, furnace_over_all_roughnesses_and_indices) {
    double worst = 0;
    for (int r = 0; r <= 40; ++r) {
        for (float ior : {1.1f, 1.25f, 1.33f, 1.45f, 1.52f, 1.6f, 1.8f, 2.1f, 2.42f}) {
            for (float eta : {ior, 1 / ior}) {
                Material m = default_material(MATERIAL_DIELECTRIC);
                const Case c{"", make_bsdf(m, vec3(1.0f), float(r) / 40, 0, eta), eta, 0};
                for (float cosine : {0.05f, 0.2f, 0.4f, 0.6f, 0.8f, 1.0f}) {
                    const double lost = std::abs(albedo(c, at_angle(cosine), 65536).x - 1);
                    // The tables are coarsest next to n = 1, where the critical angle moves fastest.
                    EXPECT_LT(lost, ior < 1.2f ? 0.03 : 0.015)
                        << "roughness " << r / 40.0 << ", eta " << eta << ", cosine " << cosine;
                    worst = std::max(worst, lost);
                }
            }
        }
    }
    RecordProperty("worst_loss", std::to_string(worst));
}

TEST(Bsdf, smooth_diffuse_is_exactly_lambert) {
    const Bsdf b = make_bsdf(default_material(MATERIAL_DIFFUSE), vec3(0.6f, 0.4f, 0.2f), 0, 0, 1);
    for (float cosine : {0.1f, 0.5f, 1.0f}) {
        const vec3 wi = at_angle(cosine);
        EXPECT_EQ(bsdf_eval(b, at_angle(0.3f), wi), vec3(0.6f, 0.4f, 0.2f) * (cosine * INV_PI)) << "cosine " << cosine;
        EXPECT_EQ(bsdf_eval(b, at_angle(0.3f), -wi), vec3(0.0f)) << "cosine " << cosine;
    }
}

// The full Moon has no limb darkening: towards the light a rough surface is brighter than Lambert's at
// grazing angles.
TEST(Bsdf, rough_diffuse_scatters_back) {
    const Material m = default_material(MATERIAL_DIFFUSE);
    const Bsdf rough = make_bsdf(m, vec3(0.5f), 1, 0, 1), smooth = make_bsdf(m, vec3(0.5f), 0, 0, 1);
    const vec3 wo = at_angle(0.3f, 0.0f);
    EXPECT_GT(bsdf_eval(rough, wo, wo).x, 1.2f * bsdf_eval(smooth, wo, wo).x);
    EXPECT_LT(bsdf_eval(rough, wo, at_angle(0.3f, PI)).x, bsdf_eval(smooth, wo, at_angle(0.3f, PI)).x);
}

// The microfacet lobes alone, by brute differentiation of their sampling maps.
TEST(Bsdf, density_of_reflection_and_refraction_is_the_inverse_jacobian) {
    int compared = 0;
    for (float roughness : {0.3f, 0.6f}) {
        for (float eta : {1.5f, 1 / 1.5f}) {
            for (float cosine : {0.3f, 0.85f}) {
                const Bsdf b = make_bsdf(default_material(MATERIAL_DIELECTRIC), vec3(1), roughness, 0, eta);
                const vec3 wo = at_angle(cosine);
                const float missing = dielectric_missing(roughness, cosine, eta);
                for (bool reflect : {true, false}) {
                    // The lobe numbers that choose the microfacet lobe, and within it either outcome.
                    const float u_lobe = reflect ? missing + 1e-5f : ONE_MINUS_EPSILON;
                    auto map = [&](double u, double v) {
                        return dvec3(bsdf_sample(b, wo, u_lobe, vec2(float(u), float(v))).direction);
                    };
                    for (double u : {0.12, 0.4, 0.77}) {
                        for (double v : {0.2, 0.5, 0.7}) {
                            const BsdfSample s = bsdf_sample(b, wo, u_lobe, vec2(float(u), float(v)));
                            if ((s.flags & LOBE_FAILED) != 0u || (s.direction.z > 0) != reflect) continue;
                            const vec3 wi = s.direction;
                            const vec3 m = glm::normalize(reflect ? wo + wi : wo + eta * wi);
                            const double fresnel = fresnel_dielectric(std::abs(glm::dot(wo, m)), eta);
                            if (fresnel > 0.8) continue;  // next to total reflection differences lose their digits
                            const double lambert = missing * (reflect ? 1 - b.energy.z : b.energy.z) * lambert_pdf(wi);
                            const double lobe = (1 - missing) * (reflect ? fresnel : 1 - fresnel) *
                                                test::density_of_direction_map(map, u, v, 5e-4);
                            EXPECT_NEAR((lobe + lambert) / s.pdf, 1.0, 0.02)
                                << "roughness " << roughness << " eta " << eta << " cosine " << cosine << " at " << u
                                << ", " << v;
                            ++compared;
                        }
                    }
                }
            }
        }
    }
    EXPECT_GT(compared, 50);
}

TEST(Bsdf, smooth_glass_obeys_snell_and_fresnel) {
    for (float eta : {1.5f, 1 / 1.5f}) {
        const Bsdf b = make_bsdf(default_material(MATERIAL_DIELECTRIC), vec3(1), 0, 0, eta);
        EXPECT_TRUE(bsdf_is_delta(b));
        for (float cosine : {0.1f, 0.5f, 0.9f, 1.0f}) {
            SCOPED_TRACE(testing::Message() << "eta " << eta << ", cosine " << cosine);
            const vec3 wo = at_angle(cosine);
            const BsdfSample up = bsdf_sample(b, wo, 0.0f, vec2(0.5f));
            EXPECT_LT(glm::length(up.direction - vec3(-wo.x, -wo.y, wo.z)), 1e-6f);
            const float fresnel = up.pdf;
            const BsdfSample down = bsdf_sample(b, wo, ONE_MINUS_EPSILON, vec2(0.5f));
            if (std::sqrt(1 - cosine * cosine) >= eta) {
                EXPECT_EQ(fresnel, 1.0f);  // total internal reflection
                EXPECT_GT(down.direction.z, 0.0f);
                continue;
            }
            EXPECT_NEAR(eta * std::hypot(down.direction.x, down.direction.y), std::hypot(wo.x, wo.y), 1e-6f);
            EXPECT_LT(glm::dot(glm::vec2(down.direction), glm::vec2(wo)),
                      1e-6f);  // to the other side of the normal
            EXPECT_NEAR(down.weight.x, 1 / (eta * eta), 1e-5f);
            // The same from the other side: Stokes.
            EXPECT_NEAR(fresnel_dielectric(-down.direction.z, 1 / eta), fresnel, 1e-4f);
        }
        EXPECT_NEAR(fresnel_dielectric(1, eta), 0.04f, 1e-6f);
    }
}

TEST(Bsdf, equal_indices_let_light_pass_at_any_roughness) {
    for (float roughness : {0.0f, 0.5f, 1.0f}) {
        const Bsdf b = make_bsdf(default_material(MATERIAL_DIELECTRIC), vec3(1), roughness, 0, 1);
        const BsdfSample s = bsdf_sample(b, at_angle(0.4f), 0.3f, vec2(0.2f, 0.8f));
        EXPECT_EQ(s.direction, -at_angle(0.4f)) << "roughness " << roughness;
        EXPECT_EQ(s.weight, vec3(1)) << "roughness " << roughness;
    }
}

TEST(Fresnel, averages_match_quadrature) {
    for (float n : {1.0002f, 1.01f, 1.33f, 1.5f, 2.42f}) {
        double sum = 0;
        for (int i = 0; i < 20000; ++i) {
            const double mu = (i + 0.5) / 20000;
            sum += 2 * mu * fresnel_dielectric(float(mu), n) / 20000;
        }
        EXPECT_NEAR(fresnel_dielectric_average(n), sum, 6e-3) << n;
    }
    const vec3 f0(0.9f, 0.5f, 0.1f), dip = fresnel_f82_dip(f0, vec3(0.7f, 0.9f, 1.0f));
    vec3 sum(0);
    for (int i = 0; i < 20000; ++i) {
        const float mu = (float(i) + 0.5f) / 20000;
        sum += 2 * mu * fresnel_f82(mu, f0, dip) / 20000.0f;
    }
    EXPECT_LT(glm::length(sum - fresnel_f82_average(f0, dip)), 2e-3f);
    // What the model is named for.
    const vec3 schlick = f0 + (vec3(1) - f0) * schlick_weight(1 / 7.0f);
    EXPECT_LT(glm::length(fresnel_f82(1 / 7.0f, f0, dip) / schlick - vec3(0.7f, 0.9f, 1.0f)), 1e-4f);
}

TEST(Fresnel, a_conductor_without_absorption_is_a_dielectric) {
    for (float mu : {0.05f, 0.3f, 0.7f, 1.0f}) {
        EXPECT_NEAR(fresnel_conductor(mu, vec3(1.5f), vec3(0)).x, fresnel_dielectric(mu, 1.5f), 1e-4f);
    }
}

TEST(Bsdf, grazing_and_degenerate_directions_stay_finite) {
    for (const Case& c : all_cases({0.0f, 0.032f, 0.05f, 0.5f, 1.0f}, vec3(1.0f))) {
        for (float cosine : {1e-7f, 1e-4f, 1.0f}) {
            SCOPED_TRACE(testing::Message() << c.name << ", cosine " << cosine);
            const vec3 wo = at_angle(cosine);
            for (vec3 wi : {at_angle(1e-7f, 3.0f), wo, -wo, vec3(-wo.x, -wo.y, wo.z), vec3(0, 0, 1), vec3(0, 0, -1),
                            vec3(1, 0, 0), vec3(0.6f, 0, -0.8f)}) {
                SCOPED_TRACE(testing::Message() << "wi " << wi.x << " " << wi.y << " " << wi.z);
                const vec4 v = bsdf_eval_pdf(c.bsdf, wo, wi);
                ASSERT_TRUE(std::isfinite(v.x + v.y + v.z + v.w));
                ASSERT_GE(v.w, 0.0f);
                ASSERT_GE(min_component(rgb(v)), 0.0f);
            }
            for (float u : {0.0f, 0.5f, ONE_MINUS_EPSILON}) {
                for (float l : {0.0f, 0.5f, ONE_MINUS_EPSILON}) {
                    SCOPED_TRACE(testing::Message() << "u_lobe " << l << ", u " << u);
                    const BsdfSample s = bsdf_sample(c.bsdf, wo, l, vec2(u, 1 - u > 0.9f ? ONE_MINUS_EPSILON : u));
                    ASSERT_TRUE(std::isfinite(s.weight.x + s.weight.y + s.weight.z + s.pdf));
                    ASSERT_GE(min_component(s.weight), 0.0f);
                }
            }
            const vec3 estimate = bsdf_albedo(c.bsdf, wo);
            ASSERT_TRUE(min_component(estimate) >= 0.0f && max_component(estimate) <= 1.0f + 1e-4f);
        }
    }
}

TEST(Bsdf, delta_materials_evaluate_to_nothing) {
    int seen = 0;
    for (const Case& c : all_cases({0.0f, 0.5f}, vec3(1.0f))) {
        if (!bsdf_is_delta(c.bsdf)) continue;
        ++seen;
        for (uint i = 0; i < 100; ++i) {
            const vec3 wo = at_angle(0.4f);
            const BsdfSample s = draw(c.bsdf, wo, i);
            EXPECT_NE(s.flags & (LOBE_DELTA | LOBE_FAILED), 0u) << c.name << ", sample " << i << " of seed 0";
            EXPECT_EQ(bsdf_eval_pdf(c.bsdf, wo, s.direction), vec4(0.0f)) << c.name << ", sample " << i << " of seed 0";
        }
    }
    EXPECT_GE(seen, 3);
}

TEST(MaterialRegistry, names_kinds_and_parameters_are_sound) {
    std::set<std::string_view> names;
    std::set<uint> kinds;
    for (const MaterialInfo& info : material_infos()) {
        EXPECT_TRUE(names.insert(info.name).second) << info.name;
        EXPECT_TRUE(kinds.insert(info.kind).second) << info.name;
        EXPECT_EQ(find_material_info(info.name), &info);
        EXPECT_EQ(find_material_info(info.kind), &info);
        EXPECT_FALSE(info.doc.empty());
        EXPECT_EQ(default_material(info.kind).kind, info.kind);
        std::set<std::string_view> parameters;
        for (auto list : {info.parameters, common_material_parameters()}) {
            for (const MaterialParameter& p : list) {
                EXPECT_TRUE(parameters.insert(p.name).second) << info.name << "." << p.name;
                EXPECT_FALSE(p.doc.empty()) << p.name;
                EXPECT_EQ(p.member.index(), p.initial.index()) << p.name;
                std::visit(
                    [&](auto value) {
                        if constexpr (std::is_same_v<decltype(value), vec3>) {
                            EXPECT_GE(min_component(value), p.minimum) << p.name;
                            EXPECT_LE(max_component(value), p.maximum) << p.name;
                        } else {
                            EXPECT_GE(float(value), p.minimum) << p.name;
                            EXPECT_LE(float(value), p.maximum) << p.name;
                        }
                    },
                    p.initial);
            }
        }
    }
    EXPECT_EQ(find_material_info("gals"), nullptr);
    EXPECT_GE(names.size(), 5u);
}

TEST(MaterialRegistry, metals_have_their_colours) {
    const MaterialInfo* metal = find_material_info("metal");
    ASSERT_NE(metal, nullptr);
    auto reflectance = [&](std::string_view name) {
        for (const MaterialPreset& preset : metal->presets) {
            if (preset.name == name) return fresnel_conductor(1, preset.eta, preset.k);
        }
        ADD_FAILURE() << "no preset " << name;
        return vec3(0);
    };
    const vec3 gold = reflectance("gold"), copper = reflectance("copper"), silver = reflectance("silver");
    EXPECT_GT(gold.x, 0.9f);
    EXPECT_LT(gold.z, 0.5f);
    EXPECT_GT(copper.x, 0.9f);
    EXPECT_LT(copper.y, gold.y);
    EXPECT_GT(min_component(silver), 0.9f);
    EXPECT_GT(min_component(reflectance("aluminium")), 0.85f);
}

}  // namespace
}  // namespace spinel::bsdf_test
