#pragma once
// Pictures with their noise: a scene given as text is rendered in batches of different seeds, whose scatter
// says how sure every pixel and every block of pixels is. So tests can ask for equality "within noise" and
// mean it.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <string>
#include <vector>

#include "devices/devices.h"
#include "image/image_io.h"
#include "image/pixels.h"
#include "render/render.h"
#include "scene/compiled_scene.h"
#include "scene/json_reader.h"
#include "spinel/formats.h"

namespace spinel::test {

using glm::dvec3;

// Sanitizers make pictures ten to twenty times slower. There they get a sixteenth of the samples, and where a test sets
// a limit to the noise or to what noise may do, that is four times as high. What is judged in standard errors is judged
// so still, a little more mildly: the scatter of so few samples is not quite normal.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int fewer_samples = 16;
constexpr double milder = 1.5;
#else
constexpr int fewer_samples = 1;
constexpr double milder = 1;
#endif
const double more_noise = std::sqrt(fewer_samples);

// A mean with its standard error, per channel.
struct Estimate {
    dvec3 mean = dvec3(0);
    dvec3 error = dvec3(0);
};

struct TestPicture {
    ivec2 size = {0, 0};
    std::vector<std::vector<dvec3>> batches;  // of pixels, row by row from the top

    // Mean over the pixels [lower, upper), its error from the scatter of the batches.
    Estimate mean(ivec2 lower, ivec2 upper) const {
        Estimate e;
        dvec3 sum_of_squares(0);
        for (const auto& batch : batches) {
            dvec3 m(0);
            for (int y = lower.y; y < upper.y; ++y)
                for (int x = lower.x; x < upper.x; ++x) m += batch[std::size_t(y * size.x + x)];
            m /= double((upper.x - lower.x) * (upper.y - lower.y));
            e.mean += m;
            sum_of_squares += m * m;
        }
        const double n = double(batches.size());
        e.mean /= n;
        e.error = glm::sqrt(glm::max(sum_of_squares / n - e.mean * e.mean, dvec3(0)) / std::max(n - 1, 1.0));
        return e;
    }
    Estimate mean() const { return mean({0, 0}, size); }
    dvec3 at(int x, int y) const { return mean({x, y}, {x + 1, y + 1}).mean; }

    Image image() const {
        Image image{size.x, size.y, 3, {}};
        for (std::size_t i = 0; i < batches[0].size(); ++i) {
            dvec3 m(0);
            for (const auto& batch : batches) m += batch[i];
            for (int k = 0; k < 3; ++k) image.values.push_back(float(m[k] / double(batches.size())));
        }
        return image;
    }
};

inline Result<CompiledScene> compile_text(const std::string& text) {
    const Result<Scene> scene = read_scene_json(text, "test.json", {load_model, read_pixels});
    if (!scene) return scene.error();
    return compile(*scene);
}

inline TestPicture render_scene(const CompiledScene& scene, int spp, int batches = 8, std::uint32_t first_seed = 1) {
    TestPicture picture;
    picture.size = scene.film.size;
    const Result<std::unique_ptr<Device>> device = make_device("cpu");
    EXPECT_TRUE(device);
    const std::atomic<bool> stop{false};
    for (int b = 0; b < batches; ++b) {
        RenderOptions options;
        options.spp = std::max(spp / fewer_samples, 1);
        options.seed = first_seed + std::uint32_t(b);
        const Result<RenderResult> result = render(**device, scene, options, stop);
        EXPECT_TRUE(result) << result.error().message;
        if (!result) return picture;
        EXPECT_EQ(result->film.bound_reached, 0u);
        std::vector<dvec3>& pixels = picture.batches.emplace_back();
        for (const FilmPixel& p : result->film.pixels) pixels.push_back(p.sum / double(p.count));
    }
    return picture;
}

inline TestPicture render_text(const std::string& text, int spp, int batches = 8, std::uint32_t first_seed = 1) {
    const Result<CompiledScene> scene = compile_text(text);
    if (!scene) {
        ADD_FAILURE() << scene.error().message << "\n" << text;
        TestPicture black;
        black.size = {1, 1};
        black.batches.assign(2, {dvec3(-1)});
        return black;
    }
    return render_scene(*scene, spp, batches, first_seed);
}

// Every channel of the mean is `expected`: within `sigmas` standard errors, which must themselves be small
// enough that the test says something.
inline void expect_mean(const Estimate& e, dvec3 expected, double sigmas = 4, double largest_error = 0.01) {
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(e.mean[k], expected[k], milder * sigmas * e.error[k] + 2e-5 * std::abs(expected[k]) + 1e-9)
            << "channel " << k << ", standard error " << e.error[k] << ", ratio " << e.mean[k] / expected[k];
        EXPECT_LE(e.error[k], more_noise * largest_error * std::abs(expected[k]) + 1e-9)
            << "too noisy to tell, channel " << k;
    }
}

struct Difference {
    dvec3 ratio = dvec3(1);  // of the means
    double chi_squared = 0;  // mean over blocks and channels of difference² / variance: about 1 for equal pictures
    double worst = 0;        // largest |difference| / standard error of a block
    ivec2 worst_block = {0, 0};
};

// Block by block. Blocks without noise on either side are compared to rounding.
inline Difference compare(const TestPicture& a, const TestPicture& b, int block) {
    Difference d;
    EXPECT_EQ(a.size, b.size);
    if (a.size != b.size) return d;
    d.ratio = a.mean().mean / b.mean().mean;
    int count = 0;
    for (int y = 0; y + block <= a.size.y; y += block)
        for (int x = 0; x + block <= a.size.x; x += block) {
            const Estimate ea = a.mean({x, y}, {x + block, y + block}), eb = b.mean({x, y}, {x + block, y + block});
            for (int k = 0; k < 3; ++k) {
                const double difference = ea.mean[k] - eb.mean[k];
                const double floor = 1e-5 * (std::abs(ea.mean[k]) + std::abs(eb.mean[k])) + 1e-9;
                const double error = std::sqrt(ea.error[k] * ea.error[k] + eb.error[k] * eb.error[k] + floor * floor);
                const double z = std::abs(difference) / error;
                d.chi_squared += z * z;
                ++count;
                if (z > d.worst) {
                    d.worst = z;
                    d.worst_block = {x, y};
                }
            }
        }
    d.chi_squared /= count;
    return d;
}

// Two ways to the same picture. With 8 batches each the expected chi_squared is 14/12 for equal pictures.
inline void expect_same(const TestPicture& a, const TestPicture& b, int block = 8, double mean_tolerance = 0.01,
                        double chi_squared = 1.6, double worst = 6.5) {
    const Difference d = compare(a, b, block);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(d.ratio[k], 1, more_noise * mean_tolerance) << "channel " << k;
    EXPECT_LT(d.chi_squared, chi_squared);
    EXPECT_LT(d.worst, worst) << "in the block at " << d.worst_block.x << ", " << d.worst_block.y;
}

}  // namespace spinel::test
