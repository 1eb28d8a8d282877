// Pictures of another renderer. The evaluation scenes of Ignis come with references by Mitsuba (4096 samples
// per pixel); here each is a scene of ours, and our picture must converge to the reference.
//
// What was found out about the references, and is part of the mapping:
//  - box filter of one pixel; fov is of the smaller axis; no camera is mirrored; max_depth counts path edges,
//  so it is our
//    max_bounces + 1; boundaries of media do not count.
//  - They were rendered with spectra: a lamp of constant radiance, seen directly in cbox-d1, has noise of
//  0.3, 0.1 and 1.0 %
//    (R, G, B) and means of 0.9996, 0.9993, 0.9970 times what the scene says. Nothing can agree better than
//    that.
//  - volume: the Mitsuba file's max_depth is 12, Ignis' own 24.
//  - env: in spectral mode Mitsuba 2 interpolates an environment's spectrum and its scale separately and
//  multiplies them, so
//    that a lone bright texel is the square of a tent, its grid lying on texel corners: (width, height − 1)
//    steps. That function is sampled finely into a picture here.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "image/metrics.h"
#include "render/pictures.h"

namespace spinel::ignis_test {
namespace {

using namespace test;

const std::string shared_folder = SPINEL_SOURCE_DIR "/../shared/data/scene/ignis";

struct IgnisScene {
    const char* name;
    const char* reference;
    double relative_mse_16;  // measured at 16 samples per pixel, with a margin of a third
    double color_tolerance;  // of the means: the reference's spectral noise
};

void PrintTo(const IgnisScene& scene, std::ostream* os) { *os << scene.name; }

std::string mesh(const std::string& file, const std::string& rest) {
    return R"({"geometry": {"type": "mesh", "file": ")" + shared_folder + "/" + file + "\"}, " + rest + "}";
}

std::string cornell_box(int max_bounces) {
    const std::string folder = "evaluation/meshes/cbox_";
    return R"("integrator": {"max_bounces": )" + std::to_string(max_bounces) + R"(},
  "camera": {"from": [278, 273, -800], "at": [278, 273, -799], "fov": 39.3077},
  "materials": {
    "box": {"type": "diffuse", "color": [0.45, 0.3, 0.9]},
    "white": {"type": "diffuse", "color": [0.885809, 0.698859, 0.666422]},
    "red": {"type": "diffuse", "color": [0.570068, 0.0430135, 0.0443706]},
    "green": {"type": "diffuse", "color": [0.105421, 0.37798, 0.076425]},
    "lamp": {"type": "diffuse", "color": [0.936461, 0.740433, 0.705267], "emission": [18.387, 10.9873, 2.75357]}
  },
  "objects": [)" +
           mesh(folder + "luminaire.obj", R"("material": "lamp", "transform": [{"translate": [0, -0.5, 0]}])") + ",\n" +
           mesh(folder + "floor.obj", R"("material": "white")") + ",\n" +
           mesh(folder + "ceiling.obj", R"("material": "white")") + ",\n" +
           mesh(folder + "back.obj", R"("material": "white")") + ",\n" +
           mesh(folder + "greenwall.obj", R"("material": "green")") + ",\n" +
           mesh(folder + "redwall.obj", R"("material": "red")") + ",\n" +
           mesh(folder + "smallbox.obj", R"("material": "box")") + ",\n" +
           mesh(folder + "largebox.obj", R"("material": "box")") + "]";
}

// The one bright texel (20, 13) of 100 × 50 as Mitsuba 2 reads it, times 100.
std::string bright_pixel_file() {
    constexpr int width = 1600, height = 784;  // 16 steps for each of theirs
    Image image{width, height, 3, std::vector<float>(std::size_t(width) * height * 3, 0.0f)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double u = (x + 0.5) / width * 100 - 20, v = (y + 0.5) / height * 49 - 13;
            const double tent = std::max(1 - std::abs(u), 0.0) * std::max(1 - std::abs(v), 0.0);
            for (int k = 0; k < 3; ++k) image.at(x, y)[k] = float(100 * tent * tent);
        }
    const std::string file = SPINEL_BINARY_DIR "/ignis_bright_pixel.exr";
    const Result<void> written = write_image(file, {{{"R", "G", "B"}, image}});
    EXPECT_TRUE(written) << written.error().message;
    return file;
}

std::string scene_text(const std::string& name) {
    const std::string bottom = R"("bottom": {"type": "diffuse", "color": [0.885809, 0.698859, 0.666422]})";
    const std::string plane_camera = R"("camera": {"from": [0, 0, -2], "at": [0, 0, 0], "fov": 90})";
    std::string text = R"({"version": 1, "film": {"size": [256, 256], "filter": "box", "filter_radius": 0.5}, )";
    if (name == "cbox_d1") return text + cornell_box(0) + "}";
    if (name == "cbox_d6") return text + cornell_box(5) + "}";
    if (name == "emissive_plane")
        return text + plane_camera + R"(, "integrator": {"max_bounces": 3}, "materials": {)" + bottom +
               R"(, "lamp": {"type": "diffuse", "color": 0, "emission": 1}}, "objects": [)" +
               mesh("meshes/Bottom.ply", R"("material": "bottom")") + ", " +
               mesh("meshes/Top.ply", R"("material": "lamp")") + "]}";
    if (name == "point")
        return text + plane_camera + R"(, "integrator": {"max_bounces": 3}, "materials": {)" + bottom +
               R"(}, "lights": [{"type": "point", "position": [0, 1, 0], "intensity": 1}], "objects": [)" +
               mesh("meshes/Bottom.ply", R"("material": "bottom")") + "]}";
    if (name == "room")
        return text + R"("integrator": {"max_bounces": 3}, "environment": {"type": "constant", "radiance": 1},
            "camera": {"from": [-0.5, 0, 0], "at": [1, 0, 0], "up": [0, 0, -1], "fov": 90},
            "materials": {"white": {"type": "diffuse", "color": 0.8}}, "objects": [)" +
               mesh("meshes/Room.obj", R"("material": "white")") + "]}";
    if (name == "volume")
        return text +
               R"("integrator": {"max_bounces": 11}, "environment": {"type": "constant", "radiance": 1},
            "camera": {"from": [2, 0, 0], "at": [-1, 0, 0], "up": [0, 0, -1], "fov": 60},
            "media": {"volume": {"absorption": [0.65, 1, 0.75]}},
            "materials": {"white": {"type": "diffuse", "color": 0.95}}, "objects": [)" +
               mesh("meshes/Room.obj", R"("material": "white")") + ", " +
               mesh("meshes/SphereTri.ply",
                    R"("material": null, "interior": "volume", "transform": [{"scale": 0.5}])") +
               "]}";
    return text + R"("integrator": {"max_bounces": 5}, "environment": {"type": "image", "file": ")" +
           bright_pixel_file() +
           R"("}, "camera": {"from": [278, 273, -800], "at": [278, 273, -799], "fov": 39.3077}, "materials": {)" +
           bottom + R"(}, "objects": [)" + mesh("evaluation/meshes/cbox_floor.obj", R"("material": "bottom")") + "]}";
}

Result<Image> reference_picture(const IgnisScene& scene) {
    Result<Image> image = read_image(shared_folder + "/evaluation/references/ref-" + scene.reference + "-4096.exr");
    if (!image || image->channels == 3) return image;
    Image rgb{image->width, image->height, 3, {}};
    for (int i = 0; i < image->width * image->height; ++i)
        for (int k = 0; k < 3; ++k) rgb.values.push_back(image->values[std::size_t(i * image->channels + k)]);
    return rgb;
}

Image block_means(const Image& image, int block) {
    Image means{image.width / block, image.height / block, 3, {}};
    for (int y = 0; y < means.height; ++y)
        for (int x = 0; x < means.width; ++x)
            for (int k = 0; k < 3; ++k) {
                double sum = 0;
                for (int j = 0; j < block; ++j)
                    for (int i = 0; i < block; ++i) sum += double(image.at(x * block + i, y * block + j)[k]);
                means.values.push_back(float(sum / (block * block)));
            }
    return means;
}

// What relative_mse(image, reference) would be if our picture had no noise, from two independent ones: the
// reference's noise and any bias, ours or its own. Its own noise falls like 1/block² in means over blocks, a
// bias does not.
double noiseless_relative_mse(const Image& a, const Image& b, const Image& reference, int block) {
    const Image x = block_means(a, block), y = block_means(b, block), r = block_means(reference, block);
    double sum = 0;
    for (std::size_t i = 0; i < r.values.size(); ++i) {
        const double t = double(r.values[i]);
        sum += (double(x.values[i]) - t) * (double(y.values[i]) - t) / (t * t + 1e-2);
    }
    return sum / double(r.values.size());
}

class Ignis : public testing::TestWithParam<IgnisScene> {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(shared_folder))
            GTEST_SKIP() << "the evaluation scenes of Ignis are not at " << shared_folder;
        const Result<Image> image = reference_picture(GetParam());
        ASSERT_TRUE(image) << image.error().message;
        reference = *image;
        const Result<CompiledScene> compiled = compile_text(scene_text(GetParam().name));
        ASSERT_TRUE(compiled) << compiled.error().message;
        scene = *compiled;
    }
    dvec3 ratio(const Image& image) const {
        const std::vector<double> a = channel_means(image), b = channel_means(reference);
        return {a[0] / b[0], a[1] / b[1], a[2] / b[2]};
    }
    Image reference;
    CompiledScene scene;
};
using IgnisSlow = Ignis;

TEST_P(Ignis, looks_like_the_reference_after_a_few_samples) {
    const Image image = render_scene(scene, 16, 1).image();
    const Result<double> distance = relative_mse(image, reference);
    ASSERT_TRUE(distance);
    // How much noisier fewer samples are is every scene's own: stratified, the error² falls faster than 1/n.
    if (fewer_samples == 1) { EXPECT_LT(*distance, GetParam().relative_mse_16); }
    for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(ratio(image)[k], 1, more_noise * GetParam().color_tolerance) << "channel " << k;
}

// Prints the rows of the table in docs/validation.md.
TEST_P(IgnisSlow, converges_to_the_reference_down_to_the_noise_of_that) {
    double previous = 0;
    Image image;
    for (const int spp : {16, 64, 256, 1024}) {
        image = render_scene(scene, spp, 1, 7).image();
        const Result<double> distance = relative_mse(image, reference);
        ASSERT_TRUE(distance);
        const dvec3 r = ratio(image);
        std::printf("| %s | %d | %.2e | %.4f %.4f %.4f |\n", GetParam().name, spp, *distance, r.x, r.y, r.z);
        std::fflush(stdout);
        previous = *distance;
    }
    const Image other = render_scene(scene, 1024, 1, 99).image();
    const double pixels = noiseless_relative_mse(image, other, reference, 1),
                 blocks = noiseless_relative_mse(image, other, reference, 8);
    std::printf("| %s | ∞ | %.2e | blocks of 8 × 8: %.2e |\n", GetParam().name, pixels, blocks);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(ratio(image)[k], 1, GetParam().color_tolerance) << "channel " << k;
    EXPECT_LT(previous, GetParam().relative_mse_16 / 8);
    // The rest is the reference's noise: it averages out, where a bias of ours would stay.
    EXPECT_LT(blocks, std::max(pixels / 16, 3e-5));
}

const IgnisScene scenes[] = {{"cbox_d1", "cbox-d1", 1.2e-4, 5e-3},
                             {"cbox_d6", "cbox-d6", 5.6e-3, 5e-3},
                             {"emissive_plane", "emissive-plane", 1.1e-3, 2e-3},
                             {"point", "point", 4e-6, 2e-3},
                             {"room", "room", 1.2e-2, 2e-3},
                             {"volume", "volume", 3.6e-2, 2e-3},
                             {"env", "env", 3e-5, 2e-2}};
std::string name_of(const testing::TestParamInfo<IgnisScene>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Scenes, Ignis, testing::ValuesIn(scenes), name_of);
INSTANTIATE_TEST_SUITE_P(Scenes, IgnisSlow, testing::ValuesIn(scenes), name_of);

}  // namespace
}  // namespace spinel::ignis_test
