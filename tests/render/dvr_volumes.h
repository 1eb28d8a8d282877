#pragma once
// Volumes that tests of `dvr` make and look at.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "render/pictures.h"

namespace spinel::test {

// A volume of floats in a file of its own.
class Dvr : public ::testing::Test {
  protected:
    Dvr()
        : file_(std::filesystem::temp_directory_path() /
                fmt::format("spinel_dvr_{}_{}.svol", getpid(),
                            ::testing::UnitTest::GetInstance()->current_test_info()->name())) {}
    ~Dvr() override { std::filesystem::remove(file_); }

    template <class Value>
    void write(int edge, const Value& value) {
        write(ivec3(edge), value);
    }
    // The longest edge is 1 long.
    template <class Value>
    void write(ivec3 size, const Value& value) {
        std::ofstream out(file_, std::ios::binary);
        out << fmt::format("spinel volume 1\nsize {0} {1} {2}\ntype f32\nspacing {3} {3} {3}\n\n", size.x, size.y,
                           size.z, 1.0 / std::max({size.x, size.y, size.z}));
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    const float v = value(x, y, z);
                    out.write(reinterpret_cast<const char*>(&v), sizeof v);
                }
    }

    // The unit cube seen from `from`, or along −z without perspective.
    std::string scene(const std::string& dvr, const std::string& camera, int pixels,
                      const std::string& more = "") const {
        return fmt::format(R"json({{"version": 1, "camera": {{{}}}, "film": {{"size": [{}, {}], "filter": "box",
          "filter_radius": 0.5}}, "integrator": {{"type": "dvr", "dvr": {{{}}}}},
          "media": {{"m": {{"scattering": 1, "density": "v"}}}},
          "materials": {{"grey": {{"type": "diffuse"}}}}, "geometries": {{"v": {{"type": "volume", "file": "{}"}}}},
          "objects": [{}{{"geometry": "v", "interior": "m"}}]}})json",
                           camera, pixels, pixels, dvr, file_.string(), more);
    }

    std::filesystem::path file_;
};

inline constexpr const char* straight =
    R"("type": "orthographic", "from": [0.5, 0.5, 3], "at": [0.5, 0.5, 0], "height": 0.01)";
inline constexpr const char* oblique = R"("from": [1.9, 1.5, 2.4], "at": [0.5, 0.5, 0.5], "fov": 30)";

inline float ball(int x, int y, int z) {
    const float r = glm::length(vec3(float(x), float(y), float(z)) - 15.5f);
    return std::max(0.0f, 100 - 6 * r) + 3 * std::sin(0.9f * float(x)) * std::sin(0.7f * float(y)) + 3;
}

inline constexpr const char* layers = R"("points": [{"value": 20, "color": [1, 0.2, 0.1], "opacity": 0},
    {"value": 40, "color": [1, 0.5, 0.1], "opacity": 0.15}, {"value": 60, "color": [0.2, 0.6, 1], "opacity": 0.01},
    {"value": 90, "color": [1, 1, 1], "opacity": 0.6}])";

}  // namespace spinel::test
