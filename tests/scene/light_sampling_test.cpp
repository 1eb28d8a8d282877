// Light sampling draws directions by the density that it claims, and the density at a hit is the same one: for every
// kind of light that has a size. And the pixel filters.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "geometry/test_scene.h"
#include "image/pixels.h"
#include "kernels/camera.h"
#include "kernels/materials.h"
#include "kernels/sampling_statistics.h"
#include "kernels/surface.h"
#include "kernels/traverse.h"
#include "scene/compiled_scene.h"
#include "scene/material_registry.h"

namespace spinel::light_sampling_test {
namespace {

const vec3 from(0.3f, 0.2f, 0.1f);

Scene scene_with(const Geometry& geometry, vec3 position) {
    Scene scene;
    Material lamp{"lamp", default_material(kernels::MATERIAL_DIFFUSE)};
    lamp.values.emission = vec3(1, 2, 3);
    lamp.values.emission_two_sided = 1;
    scene.materials.push_back(lamp);
    scene.geometries.push_back(geometry);
    Object object;
    object.name = "lamp";
    object.geometry = 0;
    object.transform[3] = position;
    object.materials = {0};
    scene.objects.push_back(object);
    return scene;
}

std::vector<std::pair<std::string, Scene>> scenes() {
    std::vector<std::pair<std::string, Scene>> list;
    list.emplace_back("sphere", scene_with({"g", SphereGeometry{0.4f}}, vec3(1, 0.5f, -1)));
    list.emplace_back("sphere about the receiver", scene_with({"g", SphereGeometry{2.0f}}, vec3(0)));
    list.emplace_back("rectangle", scene_with({"g", RectangleGeometry{{1.5f, 1}}}, vec3(0.5f, 1.5f, 0)));
    list.emplace_back("box", scene_with({"g", BoxGeometry{{1, 0.7f, 0.6f}}}, vec3(-1, 1, 0.8f)));
    MeshGeometry mesh;
    mesh.positions = {vec3(-1, 1, -1), vec3(1, 1.2f, -1), vec3(1, 0.8f, 1), vec3(-1, 1.5f, 1)};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    list.emplace_back("mesh", scene_with({"g", mesh}, vec3(0.2f, 0, 0)));
    const VoxelGeometry voxels = test::voxels_of({2, 1, 2}, {1, 0, 1, 1});
    list.emplace_back("voxels", scene_with({"g", voxels}, vec3(-2.5f, -2, -3)));
    Scene disc;
    disc.lights.push_back({"sun", DirectionalLight{vec3(0.3f, -1, 0.2f), vec3(1), 25}});
    list.emplace_back("disc at infinity", disc);
    for (const Filter filter : {Filter::nearest, Filter::linear}) {
        auto pixels = std::make_shared<PixelBuffer>();
        pixels->width = 8;
        pixels->height = 4;
        pixels->channels = 3;
        std::vector<float> values(8 * 4 * 3);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = float(1 + i / 3 * 7 % 11);
        pixels->data = values;
        Scene environment;
        ImageEnvironment image;
        image.pixels = pixels;
        image.rotation = 33;
        image.filter = filter;
        environment.environment = image;
        list.emplace_back(filter == Filter::nearest ? "environment, nearest" : "environment, linear", environment);
    }
    Scene constant;
    constant.environment = ConstantEnvironment{vec3(2)};
    list.emplace_back("constant environment", constant);
    return list;
}

// Density of sample_light towards d, from what the path tracer would find there.
double density_towards(const kernels::SceneView& view, vec3 d) {
    double sum = 0;
    const kernels::Ray ray(from, 0.0f, d, kernels::INFINITE);
    const kernels::Hit hit = kernels::trace_closest(view, ray, kernels::TRACE_ALL);
    if (kernels::is_hit(hit)) {
        const kernels::Surface s = kernels::surface_at(view, ray, hit);
        const kernels::uint light = kernels::light_of_primitive(view, view.instances.at[s.instance], s.light_key);
        return double(kernels::light_pdf(view, light, from, d, hit.t));
    }
    for (kernels::uint i = 0; i < view.infinite_light_count; ++i) {
        const kernels::Light& light = view.lights.at[i];
        const float p = view.light_table.at[i].probability;
        if (light.kind == kernels::LIGHT_ENVIRONMENT) sum += double(p * kernels::environment_pdf(view, d));
        else if (kernels::directional_seen(light, d))
            sum += double(p) / (2 * M_PI * double(kernels::disc_one_minus_cos(light.radius)));
    }
    return sum;
}

TEST(LightSampling, directions_follow_the_density_that_a_path_finds) {
    const auto list = scenes();
    std::mt19937 random(11);
    std::uniform_real_distribution<float> uniform(0.0f, kernels::ONE_MINUS_EPSILON);
    const auto draw = [&] { return uniform(random); };
    for (const auto& [name, scene] : list) {
        const Result<CompiledScene> compiled = compile(scene);
        ASSERT_TRUE(compiled) << name << ": " << compiled.error().message;
        const kernels::SceneView view = compiled->view();
        ASSERT_GT(view.light_count, 0u) << name;
        test::SphereChiSquare chi(16, 24);
        int differing = 0;
        for (int i = 0; i < 40000; ++i) {
            const float a = draw(), b = draw(), c = draw(), d = draw();
            const kernels::LightSample sample = kernels::sample_light(view, from, a, b, vec2(c, d));
            // A face that is hidden by another of the same object is drawn, and lights nothing: no path finds it.
            bool lit = sample.pdf > 0;
            if (lit && !sample.infinite) {
                const vec3 end = sample.point - 1e-4f * (sample.point - from);
                lit = !kernels::trace_occluded(view, kernels::Ray(from, 0.0f, end - from, 1.0f));
            }
            if (!lit) {
                chi.add_without_direction();
                continue;
            }
            chi.add(sample.direction);
            const double density = density_towards(view, sample.direction);
            // At an edge the ray may meet the neighbouring face, or pass by; nowhere else do the two differ.
            differing += !(std::abs(double(sample.pdf) - density) <= 2e-3 * density);
        }
        EXPECT_LE(differing, 40) << name;  // of 40 000
        const double p = chi.p_value([&](vec3 d) { return density_towards(view, d); });
        EXPECT_GT(p, test::sidak_threshold(int(list.size()))) << name << ", seed 11";
        EXPECT_LT(chi.integral(), 1 + 2e-3) << name;
    }
}

TEST(LightSampling, an_environment_is_chosen_by_what_stands_out_in_it) {
    Scene scene;
    scene.lights.push_back({"sun", DirectionalLight{{0, -1, 0}, vec3(3), 0}});
    const auto probability = [&] {
        const Result<CompiledScene> compiled = compile(scene);
        EXPECT_TRUE(compiled);
        return double(compiled->light_table[compiled->environment.light].probability);
    };
    scene.environment = ConstantEnvironment{vec3(0.2f)};
    EXPECT_EQ(probability(), 0);  // scattering alone finds it, without a shadow ray
    auto pixels = std::make_shared<PixelBuffer>();
    pixels->width = 8;
    pixels->height = 4;
    pixels->channels = 3;
    std::vector<float> values(8 * 4 * 3, 0.2f);
    const auto with_lamp = [&](float lamp) {
        values[3 * 11] = values[3 * 11 + 1] = values[3 * 11 + 2] = lamp;
        pixels->data = values;
        ImageEnvironment image;
        image.pixels = pixels;
        image.filter = Filter::nearest;
        scene.environment = image;
        return probability();
    };
    const double faint = with_lamp(0.4f), bright = with_lamp(400);
    EXPECT_GT(faint, 0.005);
    EXPECT_LT(faint, 0.1);
    EXPECT_GT(bright, 0.5);
    scene.lights.clear();
    scene.environment = ConstantEnvironment{vec3(0.2f)};
    EXPECT_EQ(probability(), 1);
}

TEST(PixelFilter, samples_follow_the_filter) {
    struct Row {
        kernels::uint kind;
        double (*value)(double x);  // not normalised, over [−1, 1] of the radius
    };
    const Row rows[] = {
        {kernels::PIXEL_FILTER_BOX, [](double) { return 1.0; }},
        {kernels::PIXEL_FILTER_TENT, [](double x) { return 1 - std::abs(x); }},
        {kernels::PIXEL_FILTER_GAUSSIAN, [](double x) { return std::exp(-0.5 * 9 * x * x); }},
        {kernels::PIXEL_FILTER_BLACKMAN_HARRIS,
         [](double x) {
             const double a = M_PI * (x + 1);
             return 0.35875 - 0.48829 * std::cos(a) + 0.14128 * std::cos(2 * a) - 0.01168 * std::cos(3 * a);
         }},
    };
    for (const Row& row : rows) {
        const int bins = 64, n = 1 << 18;
        std::vector<double> observed(bins), expected(bins);
        double total = 0;
        for (int b = 0; b < bins; ++b)
            for (int k = 0; k < 64; ++k) expected[std::size_t(b)] += row.value(2 * (b + (k + 0.5) / 64) / bins - 1);
        for (const double e : expected) total += e;
        for (double& e : expected) e *= n / total;
        for (int i = 0; i < n; ++i) {  // stratified: far stricter than chance
            const float x = kernels::sample_pixel_filter(row.kind, 1.5f, (float(i) + 0.5f) / float(n)) / 1.5f;
            observed[std::size_t(std::min(int((double(x) + 1) / 2 * bins), bins - 1))] += 1;
        }
        for (int b = 0; b < bins; ++b)
            EXPECT_NEAR(observed[std::size_t(b)], expected[std::size_t(b)], 6 + 2e-3 * expected[std::size_t(b)])
                << "filter " << row.kind << ", bin " << b;
    }
}

}  // namespace
}  // namespace spinel::light_sampling_test
