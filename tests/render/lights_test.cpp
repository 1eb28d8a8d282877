// Every kind of light against closed forms on a matte plane, and the same emitter made of different things.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>

#include "kernels/environment.h"
#include "kernels/frame.h"
#include "kernels/warp.h"
#include "render/pictures.h"

namespace spinel::lights_test {
namespace {

using namespace test;

// Looks at one point of the plane y = 0, of reflectance (0.8, 0.5, 0.2), straight down an oblique line.
std::string probe(const std::string& contents, vec3 at = {0, 0, 0}, int max_bounces = 1) {
    return fmt::format(R"({{"version": 1, "film": {{"size": [4, 4], "filter": "box", "filter_radius": 0.5}},
        "integrator": {{"max_bounces": {}}},
        "camera": {{"type": "orthographic", "from": [{}, 0.3, {}], "at": [{}, 0, {}], "height": 1e-4}},
        "textures": {{"halves": {{"type": "checker", "color_a": [1, 1, 1], "color_b": [0, 0, 0], "scale": [2, 1]}},
                      "squares": {{"type": "checker", "color_a": [1, 0.5, 0.2], "color_b": [0.1, 0.2, 1], "scale": [4, 3]}}}},
        "materials": {{"floor": {{"type": "diffuse", "color": [0.8, 0.5, 0.2]}},
                       "black": {{"type": "diffuse", "color": 0}},
                       "lamp": {{"type": "diffuse", "color": 0, "emission": [2, 3, 5]}},
                       "lamp2": {{"type": "diffuse", "color": 0, "emission": [2, 3, 5], "emission_two_sided": true}},
                       "striped": {{"type": "diffuse", "color": 0, "emission": {{"texture": "halves", "factor": [2, 3, 5]}}}},
                       "squares": {{"type": "diffuse", "color": 0, "emission": {{"texture": "squares", "factor": 4}}}}}},
        "geometries": {{"floor": {{"type": "rectangle", "size": [40, 40]}}}},
        {}}})",
                       max_bounces, at.x, at.z + 0.4, at.x, at.z, contents);
}
std::string objects(const std::string& more) {
    return R"("objects": [{"geometry": "floor", "material": "floor"})" + (more.empty() ? "" : ", " + more) + "]";
}

const dvec3 reflectance(0.8, 0.5, 0.2);
const dvec3 lamp(2, 3, 5);
dvec3 lambert(dvec3 irradiance) { return reflectance * irradiance / M_PI; }

// Irradiance over radiance on a horizontal element below the corner of a parallel rectangle a × b at height
// h.
double corner_factor(double a, double b, double h) {
    const double x = a / h, y = b / h;
    return 0.5 * (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                  y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y)));
}
// … seen from below (px, pz) for the rectangle [x0, x1] × [z0, z1].
double rectangle_factor(double x0, double x1, double z0, double z1, double h, double px = 0, double pz = 0) {
    const auto f = [&](double x, double z) {
        return (x < 0 ? -1 : 1) * (z < 0 ? -1 : 1) * corner_factor(std::abs(x), std::abs(z), h);
    };
    return f(x1 - px, z1 - pz) - f(x0 - px, z1 - pz) - f(x1 - px, z0 - pz) + f(x0 - px, z0 - pz);
}

TEST(Lights, point_light_falls_off_with_the_square_of_distance_and_the_cosine) {
    const TestPicture p = render_text(
        probe(R"("lights": [{"type": "point", "position": [0.7, 2, -0.4], "intensity": [3, 5, 7]}], )" + objects("")),
        4);
    const double d2 = 0.49 + 4 + 0.16;
    expect_mean(p.mean(), lambert(dvec3(3, 5, 7) * 2.0 / (d2 * std::sqrt(d2))), 4, 1e-3);
}

TEST(Lights, spot_light_is_full_within_soft_between_and_dark_beyond_its_angles) {
    for (const double degrees : {5.0, 12.0, 24.9, 31.0, 39.0, 41.0}) {
        const double angle = degrees * M_PI / 180;
        const TestPicture p = render_text(
            probe(
                R"("lights": [{"type": "spot", "position": [0, 2, 0], "direction": [0, -1, 0], "intensity": 5,
                      "inner_angle": 25, "outer_angle": 40}], )" +
                    objects(""),
                {float(2 * std::tan(angle)), 0, 0}),
            4);
        const double inner = std::cos(25 * M_PI / 180), outer = std::cos(40 * M_PI / 180);
        const double t = std::clamp((std::cos(angle) - outer) / (inner - outer), 0.0, 1.0);
        const double d = 2 / std::cos(angle);
        // Near the edges the soft step changes over the picture's width: a hair of tolerance.
        const dvec3 expected = lambert(dvec3(5 * t * t * (3 - 2 * t) * std::cos(angle) / (d * d)));
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(p.mean().mean[k], expected[k], 2e-4 * expected[k] + 1e-7) << degrees;
    }
}

TEST(Lights, directional_light_gives_its_irradiance_times_the_cosine_whatever_its_angular_radius) {
    for (const float radius : {0.0f, 0.265f, 5.0f, 25.0f}) {
        const TestPicture p = render_text(
            probe(fmt::format(
                      R"("lights": [{{"type": "directional", "direction": [1, -2, 0.5], "irradiance": [3, 2, 1],
                                  "angular_radius": {}}}], )",
                      radius) +
                  objects("")),
            radius == 0 ? 4 : 1024);
        expect_mean(p.mean(), lambert(dvec3(3, 2, 1) * 2.0 / std::sqrt(1 + 4 + 0.25)), 4, 2e-3);
    }
}

TEST(Lights, a_sun_with_a_disc_equals_the_parallel_sun_in_the_mean_over_soft_shadows) {
    const auto sun = [](double radius) {
        return render_text(fmt::format(
                               R"({{"version": 1, "film": {{"size": [48, 48], "filter": "box", "filter_radius": 0.5}},
        "integrator": {{"max_bounces": 1}},
        "camera": {{"type": "orthographic", "from": [0, 5, 0], "at": [0, 0, 0], "up": [0, 0, -1], "height": 4}},
        "lights": [{{"type": "directional", "direction": [0.3, -2, 0.2], "irradiance": 3, "angular_radius": {}}}],
        "materials": {{"floor": {{"type": "diffuse", "color": 0.5}}, "black": {{"type": "diffuse", "color": 0}}}},
        "objects": [{{"geometry": {{"type": "plane"}}, "material": "floor"}},
                    {{"geometry": {{"type": "box", "size": [1, 0.1, 1]}}, "material": "black",
                     "transform": [{{"translate": [0, 0.5, 0]}}]}}]}})",
                               radius),
                           64);
    };
    const TestPicture soft = sun(3), hard = sun(0);
    // The disc averages the shadow's place over 3°, to first order nothing; what is left is of second order.
    EXPECT_NEAR(soft.mean().mean.x / hard.mean().mean.x, 1, 0.004);
    EXPECT_GT(compare(soft, hard, 1).worst, 10) << "a penumbra is there";
}

TEST(Lights, sphere_light_equals_its_form_factor_near_and_far) {
    for (const double height : {0.6, 1.0, 4.0, 30.0}) {
        const TestPicture p = render_text(
            probe(objects(fmt::format(R"({{"geometry": {{"type": "sphere", "radius": 0.5}}, "material": "lamp",
                                           "transform": [{{"translate": [0.3, {}, 0]}}]}})",
                                      height))),
            512);
        const double d2 = 0.09 + height * height;
        expect_mean(p.mean(), lambert(lamp * M_PI * 0.25 / d2 * height / std::sqrt(d2)), 4, 4e-3);
    }
}

// The rectangle [−1, 1] × [−0.5, 0.5] at height 1.5, its light downwards, made of whatever emits.
struct Emitter {
    const char* name;
    std::string object;
};
std::vector<Emitter> flat_emitters(const std::string& material) {
    const std::string m = "\"material\": \"" + material + "\"";
    return {
        {"rectangle",
         R"({"geometry": {"type": "rectangle", "size": [2, 1]}, )" + m +
             R"(, "transform": [{"rotate": {"axis": [1, 0, 0], "degrees": 180}}, {"translate": [0, 1.5, 0]}]})"},
        {"rectangle under a stretched transform",
         R"({"geometry": {"type": "rectangle", "size": [1, 1]}, )" + m +
             R"(, "transform": [{"scale": [-2, -3, 1]}, {"translate": [0, 1.5, 0]}]})"},
        {"mesh",
         R"({"geometry": {"type": "mesh", "positions": [[-1, 1.5, -0.5], [1, 1.5, -0.5], [1, 1.5, 0.5], [-1, 1.5, 0.5]],
                     "triangles": [[0, 1, 2], [0, 2, 3]]}, )" +
             m + "}"},
        {"mesh of a mirrored instance",
         R"({"geometry": {"type": "mesh", "positions": [[-1, 1.5, -0.5], [1, 1.5, -0.5], [1, 1.5, 0.5], [-1, 1.5, 0.5]],
             "triangles": [[0, 1, 2], [0, 2, 3]]}, )" +
             m + R"(, "transform": [{"scale": [-1, 1, 1]}]})"},
        {"voxels", R"({"geometry": {"type": "voxels", "layers": [["11"]]}, )" + m +
                       R"(, "transform": [{"translate": [-1, 1.5, -0.5]}]})"},
        {"box",
         R"({"geometry": {"type": "box", "size": [2, 1, 1]}, )" + m + R"(, "transform": [{"translate": [0, 2, 0]}]})"},
        {"sdf box, found by following paths alone",
         R"x({"geometry": {"type": "sdf", "expression": "box(2, 1, 1)"}, )x" + m +
             R"(, "transform": [{"translate": [0, 2, 0]}]})"},
    };
}

TEST(Lights, a_flat_emitter_equals_its_form_factor_whatever_it_is_made_of) {
    for (const Emitter& e : flat_emitters("lamp")) {
        SCOPED_TRACE(e.name);
        for (const vec3 at : {vec3(0), vec3(1.3f, 0, 0.4f)}) {
            const TestPicture p = render_text(probe(objects(e.object), at), 2048);
            const bool sides = std::string(e.name).find("box") != std::string::npos || e.name == std::string("voxels");
            double factor = rectangle_factor(-1, 1, -0.5, 0.5, 1.5, at.x, at.z);
            if (sides && at.x > 1) continue;  // a solid shows its side there
            expect_mean(p.mean(), lambert(lamp * factor), 4, 0.01);
        }
    }
}

TEST(Lights, solids_that_emit_look_the_same_from_the_side_whatever_they_are_made_of) {
    std::vector<Estimate> means;
    for (const Emitter& e : flat_emitters("lamp")) {
        const std::string name = e.name;
        if (name != "voxels" && name != "box" && name.find("sdf") == std::string::npos) continue;
        means.push_back(render_text(probe(objects(e.object), {1.8f, 0, 0.3f}), 2048).mean());
    }
    ASSERT_EQ(means.size(), 3u);
    for (const Estimate& m : means) {
        EXPECT_NEAR(m.mean.x / means[0].mean.x, 1, 4 * (m.error.x + means[0].error.x) / m.mean.x);
        EXPECT_LT(m.error.x, more_noise * 0.01 * m.mean.x);
    }
}

TEST(Lights, one_sided_emitters_are_dark_behind_and_two_sided_ones_are_not) {
    const auto rectangle = [](const char* material, double degrees) {
        return fmt::format(R"({{"geometry": {{"type": "rectangle", "size": [2, 1]}}, "material": "{}",
            "transform": [{{"rotate": {{"axis": [1, 0, 0], "degrees": {}}}}}, {{"translate": [0, 1.5, 0]}}]}})",
                           material, degrees);
    };
    const dvec3 expected = lambert(lamp * rectangle_factor(-1, 1, -0.5, 0.5, 1.5));
    EXPECT_EQ(render_text(probe(objects(rectangle("lamp", 0))), 16).mean().mean, dvec3(0));
    expect_mean(render_text(probe(objects(rectangle("lamp", 180))), 1024).mean(), expected);
    expect_mean(render_text(probe(objects(rectangle("lamp2", 0))), 1024).mean(), expected);
    expect_mean(render_text(probe(objects(rectangle("lamp2", 180))), 1024).mean(), expected);
    // From within a sphere only the two-sided one is seen: uniform radiance, irradiance π L.
    const auto around = [](const char* material) {
        return std::string(R"({"geometry": {"type": "sphere", "radius": 3}, "material": ")") + material + "\"}";
    };
    EXPECT_EQ(render_text(probe(objects(around("lamp"))), 16).mean().mean, dvec3(0));
    expect_mean(render_text(probe(objects(around("lamp2"))), 1024).mean(), lambert(lamp * M_PI));
}

TEST(Lights, textured_emission_lights_as_it_looks) {
    // The half u < ½ of the rectangle shines. Turned by 180° about x, u still runs along +x.
    const std::string object = R"({"geometry": {"type": "rectangle", "size": [2, 1]}, "material": "striped",
        "transform": [{"rotate": {"axis": [1, 0, 0], "degrees": 180}}, {"translate": [0, 1.5, 0]}]})";
    const dvec3 expected = lambert(lamp * rectangle_factor(-1, 0, -0.5, 0.5, 1.5, 0.6, 0));
    expect_mean(render_text(probe(objects(object), {0.6f, 0, 0}), 4096).mean(), expected);
}

// The same textured emitter, once as a light that is sampled, once found by following paths alone: with a
// cutout of opacity that never cuts the emitter is still a light, so the twin is made by hand.
Estimate without_light_sampling(const std::string& text, int spp) {
    Result<CompiledScene> scene = compile_text(text);
    EXPECT_TRUE(scene) << scene.error().message;
    if (!scene) return {};
    for (kernels::Instance& instance : scene->instances) {
        instance.light_first = kernels::NONE;
        instance.light_count = 0;
    }
    scene->lights.clear();
    scene->light_table.clear();
    scene->environment.light = kernels::NONE;
    scene->infinite_light_count = 0;
    return render_scene(*scene, spp).mean();
}

TEST(Lights, light_sampling_changes_nothing_but_the_noise) {
    const std::string mesh =
        R"({"geometry": {"type": "mesh", "positions": [[-1, 0, -1], [1, 0, -1], [1, 0.2, 1], [-1, 0, 1]],
            "uvs": [[0, 0], [1, 0], [1, 1], [0, 1]], "triangles": [[0, 1, 2], [0, 2, 3]]}, "material": "squares",
            "transform": [{"translate": [0.3, 1.2, 0]}]})";
    const std::vector<Emitter> emitters = {
        {"textured mesh", mesh},
        {"textured sphere", R"({"geometry": {"type": "sphere", "radius": 0.6}, "material": "squares",
            "transform": [{"rotate": {"axis": [1, 1, 0], "degrees": 70}}, {"translate": [0.3, 1.2, 0]}]})"},
        {"textured box", R"({"geometry": {"type": "box", "size": [1, 0.7, 1.4]}, "material": "squares",
            "transform": [{"rotate": {"axis": [1, 1, 0], "degrees": 30}}, {"translate": [0.3, 1.4, 0]}]})"},
        {"textured voxels",
         R"({"geometry": {"type": "voxels", "layers": [["11", "1."], [".1", ".."]]}, "material": "squares",
            "transform": [{"rotate": {"axis": [0, 1, 1], "degrees": 30}}, {"translate": [0.3, 1.4, 0]}]})"},
        {"textured rectangle", R"({"geometry": {"type": "rectangle", "size": [2, 1]}, "material": "squares",
            "transform": [{"rotate": {"axis": [1, 0, 0], "degrees": 150}}, {"translate": [0, 1.5, 0]}]})"},
        {"sphere",
         R"({"geometry": {"type": "sphere", "radius": 0.6}, "material": "lamp", "transform": [{"translate": [0.3, 1, 0]}]})"},
        {"sphere seen from within", R"({"geometry": {"type": "sphere", "radius": 3}, "material": "lamp2"})"},
        {"ellipsoid", R"({"geometry": {"type": "sphere", "radius": 0.6}, "material": "lamp",
            "transform": [{"scale": [1, 0.5, 2]}, {"translate": [0.3, 1, 0]}]})"},
    };
    for (const Emitter& e : emitters) {
        SCOPED_TRACE(e.name);
        const std::string text = probe(objects(e.object));
        const Estimate a = render_text(text, 4096).mean(), b = without_light_sampling(text, 8192);
        for (int k = 0; k < 3; ++k) {
            const double error = std::sqrt(a.error[k] * a.error[k] + b.error[k] * b.error[k]);
            EXPECT_NEAR(a.mean[k], b.mean[k], 4 * error) << "channel " << k;
            EXPECT_LT(error, more_noise * 0.015 * b.mean[k]);
        }
    }
}

TEST(Lights, cutouts_let_light_through_in_proportion) {
    for (const char* emitter : {R"("lights": [{"type": "point", "position": [0, 3, 0], "intensity": 9}], )",
                                R"("environment": {"type": "constant", "radiance": 1}, )"}) {
        const auto with = [&](const std::string& screen) {
            std::string text = probe(emitter + objects(screen));
            text.replace(text.find("\"black\":"), 8,
                         R"("veil": {"type": "diffuse", "color": 0, "opacity": 0.3}, "black":)");
            return render_text(text, 2048).mean();
        };
        const std::string dome = R"({"geometry": {"type": "sphere", "radius": 2}, "material": "veil"})";
        const Estimate open = with(""), veiled = with(dome);
        EXPECT_NEAR(veiled.mean.x / open.mean.x, 0.7, 4 * veiled.error.x / open.mean.x + 1e-4);
        EXPECT_LT(veiled.error.x, more_noise * 0.01 * open.mean.x);
    }
}

// -------------------------------------------------------------------------------------------------------
// environments
Scene plain_scene(const std::string& text) {
    Result<Scene> scene = read_scene_json(text, "test.json", {load_model, read_pixels});
    EXPECT_TRUE(scene) << scene.error().message;
    return scene ? *scene : Scene{};
}

Estimate under(const std::string& text, const ImageEnvironment& environment, int spp) {
    Scene scene = plain_scene(text);
    scene.environment = environment;
    const Result<CompiledScene> compiled = compile(scene);
    EXPECT_TRUE(compiled) << compiled.error().message;
    return compiled ? render_scene(*compiled, spp).mean() : Estimate{};
}

ImageEnvironment picture_environment(int width, int height, std::vector<float> values, Filter filter) {
    ImageEnvironment e;
    e.pixels = std::make_shared<PixelBuffer>(PixelBuffer{width, height, 3, std::move(values)});
    e.filter = filter;
    return e;
}

TEST(Lights, a_constant_picture_equals_the_constant_environment) {
    const std::string scene = probe(objects(R"({"geometry": {"type": "sphere", "radius": 0.5}, "material": "floor",
        "transform": [{"translate": [0.2, 0.6, 0]}]})"),
                                    vec3(0), 4);
    const std::string constant =
        scene.substr(0, scene.rfind('}')) + R"(, "environment": {"type": "constant", "radiance": [1, 2, 3]}})";
    const Estimate a = render_text(constant, 2048).mean();
    for (const Filter filter : {Filter::nearest, Filter::linear}) {
        std::vector<float> values;
        for (int i = 0; i < 16 * 8; ++i) values.insert(values.end(), {1, 2, 3});
        const Estimate b = under(scene, picture_environment(16, 8, values, filter), 2048);
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(a.mean[k] / b.mean[k], 1, 4 * (a.error[k] + b.error[k]) / b.mean[k]);
            EXPECT_LT(b.error[k], more_noise * 0.01 * b.mean[k]);
        }
    }
}

TEST(Lights, one_bright_texel_is_a_small_sun) {
    constexpr int width = 100, height = 50, x = 20, y = 13;
    std::vector<float> values(width * height * 3, 0.0f);
    for (int k = 0; k < 3; ++k) values[(y * width + x) * 3 + k] = 100;
    // ∫ cos θ sin θ over the texel.
    const double t0 = M_PI * y / height, t1 = M_PI * (y + 1) / height;
    const double factor = 2 * M_PI / width * 0.5 * (std::sin(t1) * std::sin(t1) - std::sin(t0) * std::sin(t0));
    const Estimate e = under(probe(objects("")), picture_environment(width, height, values, Filter::nearest), 256);
    expect_mean(e, lambert(dvec3(100 * factor)), 4, 2e-3);
    // Where it stands: a wall in the way of its middle leaves nothing. Towards u = 0.205, v = 0.27.
    const vec3 d = kernels::equirect_direction({(x + 0.5f) / width, (y + 0.5f) / height});
    const std::string wall = fmt::format(R"({{"geometry": {{"type": "sphere", "radius": 0.2}}, "material": "black",
        "transform": [{{"translate": [{}, {}, {}]}}]}})",
                                         2 * d.x, 2 * d.y, 2 * d.z);
    EXPECT_EQ(under(probe(objects(wall)), picture_environment(width, height, values, Filter::nearest), 64).mean,
              dvec3(0));
}

TEST(Lights, a_picture_of_contrasts_lights_like_its_integral_for_either_filter) {
    const std::vector<float> values = {9, 0, 0, 0, 0, 1, 0.1f, 3, 0, 0, 0, 0, 1, 1, 5, 0, 0, 0, 0, 7, 2, 0, 0, 0,
                                       0, 1, 0, 2, 0, 0, 0,    0, 9, 0, 0, 4, 0, 0, 0, 1, 0, 0, 3, 0, 1, 0, 2, 8};
    for (const Filter filter : {Filter::nearest, Filter::linear})
        for (const float rotation : {0.0f, 73.0f}) {
            ImageEnvironment e = picture_environment(4, 4, values, filter);
            e.rotation = rotation;
            const std::string text = probe(objects(""));
            Scene scene = plain_scene(text);
            scene.environment = e;
            const Result<CompiledScene> compiled = compile(scene);
            ASSERT_TRUE(compiled);
            dvec3 irradiance(0);
            const int n = 720;
            for (int j = 0; j < n; ++j)
                for (int i = 0; i < 4 * n; ++i) {  // midpoints of equal projected areas
                    const double r = std::sqrt((j + 0.5) / n), phi = 2 * M_PI * (i + 0.5) / (4 * n);
                    const vec3 d(float(r * std::cos(phi)), float(std::sqrt(1 - r * r)), float(r * std::sin(phi)));
                    irradiance += dvec3(kernels::environment_radiance(compiled->view(), d));
                }
            irradiance *= M_PI / (4.0 * n * n);
            expect_mean(render_scene(*compiled, 4096).mean(), lambert(irradiance), 4, 0.012);
            expect_mean(without_light_sampling(text, 1), dvec3(0), 1,
                        1);  // the twin really has no environment
        }
}

}  // namespace
}  // namespace spinel::lights_test
