// `dvr` of files: windows in the data's own units, and orientation.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <algorithm>

#include "formats/test_files.h"
#include "image/metrics.h"
#include "render/pictures.h"
#include "scene/integrator_setting.h"

namespace spinel::dvr_data_test {
namespace {

using namespace test;

using DvrData = FileTest;

// A file as `spinel render --integrator dvr` shows it, `settings` as of --set.
Image shown(const std::filesystem::path& file, ivec2 size, const std::vector<std::string>& settings) {
    LoadOptions options;
    options.plain = true;
    Result<Scene> scene = load_scene(file, size, options);
    EXPECT_TRUE(scene) << scene.error().message;
    if (!scene) return {};
    scene->integrator.name = "dvr";
    scene->film.filter = PixelFilter::box;
    scene->film.filter_radius = 0.5f;
    for (const std::string& setting : settings) {
        const Result<void> set = set_integrator(scene->integrator, setting);
        EXPECT_TRUE(set) << set.error().message;
    }
    const Result<CompiledScene> compiled = compile(*scene);
    EXPECT_TRUE(compiled) << compiled.error().message;
    return compiled ? render_scene(*compiled, 4, 1).image() : Image{};
}

// NIfTI-1 of 24³ samples; the sform turns nothing.
template <class T>
std::string nifti(std::int16_t datatype, float slope, float intercept, T (*value)(int, int, int)) {
    std::string bytes(352, '\0');
    const auto put = [&](std::size_t at, auto number) { bytes.replace(at, sizeof number, raw(number)); };
    put(0, std::int32_t(348));
    const std::int16_t dims[] = {3, 24, 24, 24, 1, 1, 1, 1};
    for (std::size_t i = 0; i < 8; ++i) put(40 + 2 * i, dims[i]);
    put(70, datatype);
    for (std::size_t i = 0; i < 4; ++i) put(76 + 4 * i, 1.0f);
    put(108, 352.0f);
    put(112, slope);
    put(116, intercept);
    put(254, std::int16_t(1));
    for (std::size_t i = 0; i < 3; ++i) put(280 + 20 * i, 1.0f);
    bytes.replace(344, 4, std::string("n+1\0", 4));
    for (int k = 0; k < 24; ++k)
        for (int j = 0; j < 24; ++j)
            for (int i = 0; i < 24; ++i) bytes += raw(value(i, j, k));
    return bytes;
}

// A ball of bone in a larger one of fat in air, as a scanner stores it: half a Hounsfield unit a step from −1024 on.
std::int16_t stored(int i, int j, int k) {
    const float r = glm::length(vec3(float(i), float(j), float(k)) - vec3(9, 13, 11.5f));
    const float hounsfield = std::clamp(1500 - 250 * r, -80.0f, 1000.0f) - (r > 9 ? 920.0f : 0.0f);
    return std::int16_t(std::lround((hounsfield + 1024) * 2));
}
float hounsfield(int i, int j, int k) { return 0.5f * float(stored(i, j, k)) - 1024; }

TEST_F(DvrData, stored_numbers_are_windowed_in_the_units_that_their_scaling_means) {
    const auto scaled = write("scaled.nii", nifti<std::int16_t>(4, 0.5f, -1024, stored));
    const auto plain = write("plain.nii", nifti<float>(16, 0, 0, hounsfield));
    const auto unscaled = write("unscaled.nii", nifti<std::int16_t>(4, 0, 0, stored));
    const std::vector<std::vector<std::string>> cases = {{"dvr.preset=ct-bone"},
                                                         {"dvr.preset=ct-skin", "dvr.light=scene", "dvr.shadow=0.5"},
                                                         {"dvr.level=-80", "dvr.width=300", "dvr.color_map=viridis"},
                                                         {"dvr.mode=maximum", "dvr.level=400", "dvr.width=1600"},
                                                         {"dvr.mode=isosurface", "dvr.iso=300"}};
    for (const std::vector<std::string>& settings : cases) {
        const Image image = shown(scaled, {40, 40}, settings), expected = shown(plain, {40, 40}, settings);
        const Result<double> difference = rmse(image, expected);
        ASSERT_TRUE(difference);
        EXPECT_LT(*difference, 1e-4) << settings[0];
        EXPECT_GT(channel_means(image)[0], 0.005) << settings[0];
        const Result<double> other = rmse(shown(unscaled, {40, 40}, settings), expected);
        ASSERT_TRUE(other);
        EXPECT_GT(*other, 0.01) << settings[0];
    }
}

// One head in four storage orders: the files differ in how samples follow each other, not in where they are.
TEST_F(DvrData, one_head_in_four_storage_orders_is_one_picture) {
    const auto space = data_folder / "volume/nifti/space";
    if (!std::filesystem::exists(space)) GTEST_SKIP() << space << " is not there";
    for (const char* mode : {"composite", "maximum", "average", "isosurface"}) {
        const std::vector<std::string> settings = {"dvr.preset=mri", fmt::format("dvr.mode={}", mode), "dvr.iso=25"};
        const Image reference = shown(space / "RAS.nii.gz", {96, 96}, settings);
        EXPECT_GT(channel_means(reference)[0], 0.02);
        for (const char* name : {"ILA.nii.gz", "LPI.nii.gz", "PSR.nii.gz"}) {
            const Result<double> difference = rmse(shown(space / name, {96, 96}, settings), reference);
            ASSERT_TRUE(difference) << difference.error().message;
            EXPECT_LT(*difference, 0.005) << name << " " << mode;
        }
    }
}

}  // namespace
}  // namespace spinel::dvr_data_test
