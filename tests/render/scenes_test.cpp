// Scene files that carry their expected mean: the white furnace, and spheres with closed forms. A new promise
// is a new file in tests/scenes/.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "devices/devices.h"
#include "render/pictures.h"
#include "render/render.h"
#include "scene/compiled_scene.h"
#include "spinel/formats.h"

namespace spinel::scenes_test {
namespace {

std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(SPINEL_SOURCE_DIR "/tests/scenes"))
        if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

class Scenes : public testing::TestWithParam<std::string> {};

TEST_P(Scenes, have_the_mean_that_their_file_expects) {
    const Result<Scene> scene = load_scene(std::string(SPINEL_SOURCE_DIR "/tests/scenes/") + GetParam() + ".json");
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(scene->expected) << "the scene file has no \"expected\"";
    const Result<CompiledScene> compiled = compile(*scene);
    ASSERT_TRUE(compiled) << compiled.error().message;
    const auto device = make_device("cpu");
    ASSERT_TRUE(device);
    const std::atomic<bool> stop{false};
    RenderOptions options;
    options.spp = std::max(compiled->integrator.spp / test::fewer_samples, 1);
    const Result<RenderResult> result = render(**device, *compiled, options, stop);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(result->film.bound_reached, 0u);
    glm::dvec3 mean(0);
    for (const FilmPixel& p : result->film.pixels) mean += p.sum / double(p.count);
    mean /= double(result->film.pixels.size());
    for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(mean[k], scene->expected->mean[k],
                    test::more_noise * double(scene->expected->tolerance) * scene->expected->mean[k])
            << "channel " << k << "; repeat: spinel render tests/scenes/" << GetParam() << ".json --check -o out.exr";
}

INSTANTIATE_TEST_SUITE_P(Files, Scenes, testing::ValuesIn(scene_names()), [](const auto& info) { return info.param; });

}  // namespace
}  // namespace spinel::scenes_test
