// The same bits whatever the number of threads, the division into passes, or the part of the picture.

#include <gtest/gtest.h>

#include <cstring>

#include "core/parallel.h"
#include "devices/devices.h"
#include "render/render.h"
#include "scene/compiled_scene.h"
#include "scene/json_reader.h"
#include "spinel/formats.h"

namespace spinel::determinism_test {
namespace {

// Something of everything that could depend on order: media, glass, textures, several lights.
constexpr const char* text = R"json({
  "version": 1,
  "camera": {"from": [0, 1.2, 5], "at": [0, 0.6, 0], "fov": 45, "lens_radius": 0.05},
  "film": {"size": [61, 47]},
  "environment": {"type": "constant", "radiance": 0.3},
  "textures": {"floor": {"type": "checker", "scale": [2, 2]}},
  "media": {"smoke": {"scattering": [3, 2, 1], "absorption": 0.2, "g": 0.4}},
  "geometries": {"blocks": {"type": "voxels", "layers": [["1111", "1221", "1111"], ["1.21", "1.21", "1131"], ["..1.", "2..1", "1..."]]}},
  "materials": {"floor": {"type": "diffuse", "color": "floor"},
                "glass": {"type": "dielectric", "ior": 1.5},
                "lamp": {"type": "diffuse", "color": 0, "emission": 8},
                "gold": {"type": "metal", "preset": "gold", "roughness": 0.3}},
  "objects": [{"geometry": {"type": "plane"}, "material": "floor"},
              {"geometry": {"type": "sphere", "radius": 0.6}, "material": "glass", "transform": [{"translate": [-0.8, 0.6, 0]}]},
              {"geometry": {"type": "sphere", "radius": 0.6}, "material": null, "interior": "smoke", "transform": [{"translate": [0.8, 0.6, 0]}]},
              {"geometry": {"type": "sdf", "expression": "torus(0.5, 0.15)"}, "material": "gold", "transform": [{"translate": [0, 0.2, 1]}]},
              {"geometry": "blocks", "material": ["floor", "glass", "lamp"], "transform": [{"translate": [-2, 0, -1.5]}, {"scale": 0.5}]},
              {"geometry": "blocks", "material": ["floor", "glass", "lamp"], "transform": [{"translate": [0, 0, -2]}, {"scale": 0.5}]},
              {"geometry": {"type": "sphere", "radius": 0.2}, "material": "lamp", "transform": [{"translate": [0, 2.5, 0]}]}],
  "lights": [{"type": "point", "position": [2, 3, 2], "intensity": 5}]
})json";

CompiledScene compiled_scene() {
    const SceneLoaders no_files{
        [](const std::filesystem::path&, const LoadOptions&) -> Result<Scene> { return Error{"no files here"}; },
        [](const std::filesystem::path&) -> Result<PixelBuffer> { return Error{"no files here"}; }};
    const Result<Scene> scene = read_scene_json(text, "determinism.json", no_files);
    EXPECT_TRUE(scene) << scene.error().message;
    Result<CompiledScene> compiled = compile(*scene);
    EXPECT_TRUE(compiled) << compiled.error().message;
    return std::move(*compiled);
}

FilmBuffer rendered(const CompiledScene& scene, const RenderOptions& options, int threads) {
    const ThreadLimit limit(threads);
    const auto device = make_device("cpu");
    const std::atomic<bool> stop{false};
    Result<RenderResult> result = render(**device, scene, options, stop);
    EXPECT_TRUE(result) << result.error().message;
    return std::move(result->film);
}

bool same_bits(const FilmPixel& a, const FilmPixel& b) {
    return a.sum == b.sum && a.mean == b.mean && a.deviation == b.deviation && a.normal == b.normal &&
           a.albedo == b.albedo && a.depth == b.depth && a.hits == b.hits && a.count == b.count && a.object == b.object;
}

TEST(Determinism, same_bits_for_1_2_and_7_threads) {
    const CompiledScene scene = compiled_scene();
    const RenderOptions options{.spp = 8, .seed = 3};
    const FilmBuffer one = rendered(scene, options, 1);
    for (const int threads : {2, 7}) {
        const FilmBuffer many = rendered(scene, options, threads);
        ASSERT_EQ(one.pixels.size(), many.pixels.size());
        for (std::size_t i = 0; i < one.pixels.size(); ++i)
            ASSERT_TRUE(same_bits(one.pixels[i], many.pixels[i])) << "pixel " << i << ", " << threads << " threads";
    }
    EXPECT_GT(one.mean_luminance(), 0.05);
}

TEST(Determinism, four_crops_put_together_are_the_whole) {
    const CompiledScene scene = compiled_scene();
    const FilmBuffer whole = rendered(scene, {.spp = 6}, 2);
    const int x[] = {0, 23, 61}, y[] = {0, 30, 47};
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            RenderOptions options{.spp = 6};
            options.crop = {{x[i], y[j]}, {x[i + 1], y[j + 1]}};
            const FilmBuffer part = rendered(scene, options, 2);
            for (int py = y[j]; py < y[j + 1]; ++py)
                for (int px = x[i]; px < x[i + 1]; ++px)
                    ASSERT_TRUE(same_bits(whole.at(px, py), part.at(px, py))) << px << ", " << py;
        }
}

// Rays go in packets where they have company; a picture of one pixel and one sample has none.
TEST(Determinism, a_pixel_alone_is_as_in_company) {
    const CompiledScene scene = compiled_scene();
    for (const int spp : {1, 3, 16}) {
        const FilmBuffer whole = rendered(scene, {.spp = spp}, 2);
        for (int y = 0; y < 47; y += 3)
            for (int x = 0; x < 61; x += 4) {
                RenderOptions options{.spp = spp};
                options.crop = {{x, y}, {x + 1, y + 1}};
                ASSERT_TRUE(same_bits(whole.at(x, y), rendered(scene, options, 1).at(x, y))) << x << ", " << y;
            }
    }
}

TEST(Determinism, another_seed_gives_another_picture_of_the_same_mean) {
    const CompiledScene scene = compiled_scene();
    const FilmBuffer a = rendered(scene, {.spp = 64, .seed = 1}, 2), b = rendered(scene, {.spp = 64, .seed = 2}, 2);
    std::size_t equal = 0, noisy = 0;  // a plain background is the same for every seed
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        if (a.pixels[i].deviation < 1e-6) continue;
        ++noisy;
        equal += a.pixels[i].sum == b.pixels[i].sum;
    }
    EXPECT_GT(noisy, a.pixels.size() / 4);
    EXPECT_LT(equal, noisy / 20);
    EXPECT_NEAR(a.mean_luminance(), b.mean_luminance(), 0.02 * a.mean_luminance());
}

}  // namespace
}  // namespace spinel::determinism_test
