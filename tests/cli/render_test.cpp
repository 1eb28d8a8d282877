// What `spinel render` promises of its pictures: parts equal the whole, threads change nothing, limits stop
// it, the settings stand in the file.

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/run_program.h"
#include "image/image_io.h"

#include <OpenImageIO/imageio.h>

namespace spinel::render_test {
namespace {

using Json = nlohmann::json;

// Everything that stands in an EXR: names of channels and values, and text attributes.
struct Exr {
    int width = 0, height = 0;
    std::vector<std::string> channels;
    std::vector<float> values;  // channels interleaved
    std::map<std::string, std::string> attributes;

    float at(int x, int y, const std::string& channel) const {
        const auto found = std::find(channels.begin(), channels.end(), channel);
        if (found == channels.end()) {
            ADD_FAILURE() << "no channel " << channel;
            return NAN;
        }
        const std::size_t pixel = std::size_t(y) * std::size_t(width) + std::size_t(x);
        return values[pixel * channels.size() + std::size_t(found - channels.begin())];
    }
};

Exr read_exr(const std::string& path) {
    Exr exr;
    const auto file = OIIO::ImageInput::open(path);
    if (!file) {
        ADD_FAILURE() << "cannot read " << path << ": " << OIIO::geterror();
        return exr;
    }
    const OIIO::ImageSpec& spec = file->spec();
    exr.width = spec.width;
    exr.height = spec.height;
    exr.channels = spec.channelnames;
    for (const auto& attribute : spec.extra_attribs) exr.attributes[attribute.name().string()] = attribute.get_string();
    exr.values.resize(std::size_t(spec.width) * std::size_t(spec.height) * std::size_t(spec.nchannels));
    EXPECT_TRUE(file->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, exr.values.data())) << path;
    return exr;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

class CliRender : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        scene = write("scene.json", sphere_scene()).string();
    }
    // Renders the scene to an EXR of this name; arguments are further options.
    Exr render(const std::string& name, const std::vector<std::string>& arguments = {}) const {
        std::vector<std::string> all = {"render", scene, "-o", at(name), "--quiet"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        const Outcome outcome = run(all);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return read_exr(at(name));
    }
    std::string scene;
};

TEST_F(CliRender, parts_put_together_are_the_whole_bit_by_bit) {
    const Exr whole = render("whole.exr", {"--aov", "depth,normal"});
    ASSERT_EQ(whole.width, 24);
    ASSERT_EQ(whole.height, 16);
    const int x_cuts[] = {0, 7, 24}, y_cuts[] = {0, 11, 16};
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const int left = x_cuts[i], top = y_cuts[j], right = x_cuts[i + 1], bottom = y_cuts[j + 1];
            const std::string crop = std::to_string(left) + "," + std::to_string(top) + "," + std::to_string(right) +
                                     "," + std::to_string(bottom);
            const Exr part = render("part.exr", {"--aov", "depth,normal", "--crop", crop});
            ASSERT_EQ(part.width, right - left);
            ASSERT_EQ(part.height, bottom - top);
            ASSERT_EQ(part.channels, whole.channels);
            EXPECT_EQ(part.attributes.at("spinel.crop"), crop);
            const std::size_t n = whole.channels.size();
            for (int y = top; y < bottom; ++y)
                EXPECT_EQ(std::memcmp(&whole.values[(std::size_t(y) * 24 + std::size_t(left)) * n],
                                      &part.values[std::size_t(y - top) * std::size_t(part.width) * n],
                                      std::size_t(part.width) * n * sizeof(float)),
                          0)
                    << "row " << y << " of crop " << crop;
        }
}

TEST_F(CliRender, any_number_of_threads_gives_the_same_bits_and_another_seed_others) {
    const Exr one = render("one.exr", {"--threads", "1"});
    for (const char* threads : {"2", "7"})
        EXPECT_TRUE(same_bits(render("many.exr", {"--threads", threads}).values, one.values)) << threads << " threads";
    EXPECT_FALSE(same_bits(render("seed.exr", {"--seed", "1"}).values, one.values));
}

TEST_F(CliRender, the_effective_settings_stand_in_the_file) {
    const Exr plain = render("plain.exr");
    EXPECT_EQ(plain.attributes.at("spinel.spp"), "4");
    EXPECT_EQ(plain.attributes.at("spinel.seed"), "0");
    EXPECT_EQ(plain.attributes.at("spinel.integrator"), "path");
    EXPECT_EQ(plain.attributes.at("spinel.max_bounces"), "-1");
    EXPECT_EQ(plain.attributes.at("spinel.device"), "cpu");
    EXPECT_EQ(plain.attributes.at("spinel.input"), "scene.json");
    EXPECT_EQ(plain.attributes.at("spinel.stopped_by"), "samples");
    EXPECT_TRUE(plain.attributes.at("Software").starts_with("Spinel "));
    const Exr other = render("other.exr", {"--spp", "3", "--seed", "7", "--max-bounces", "2", "--size", "40x30"});
    EXPECT_EQ(other.attributes.at("spinel.spp"), "3");
    EXPECT_EQ(other.attributes.at("spinel.seed"), "7");
    EXPECT_EQ(other.attributes.at("spinel.max_bounces"), "2");
    EXPECT_EQ(other.attributes.at("spinel.film"), "40x30");
    EXPECT_EQ(other.width, 40);
    EXPECT_EQ(other.height, 30);
}

// The camera stands 5 before the middle of a sphere of radius 1.
TEST_F(CliRender, further_outputs_are_what_they_are_named_for) {
    // Samples within their own pixel, so that a pixel that only background reaches has no hits.
    std::string text = sphere_scene();
    text.replace(text.find("[24, 16]"), 8, "[25, 17], \"filter\": \"box\", \"filter_radius\": 0.5");
    write("scene.json", text);
    const Exr exr = render("aov.exr", {"--spp", "16", "--aov", "depth,normal,albedo,object,samples,variance"});
    const int x = 12, y = 8;
    EXPECT_NEAR(exr.at(x, y, "depth.Z"), 4.0f, 0.02f);
    EXPECT_NEAR(exr.at(x, y, "normal.Z"), 1.0f, 0.02f);
    EXPECT_NEAR(exr.at(x, y, "normal.X"), 0.0f, 0.05f);
    EXPECT_NEAR(exr.at(x, y, "normal.Y"), 0.0f, 0.05f);
    EXPECT_GT(exr.at(x, y - 3, "normal.Y"), 0.2f) << "up in the picture is +y";
    EXPECT_GT(exr.at(x + 3, y, "normal.X"), 0.2f) << "right in the picture is +x";
    EXPECT_NEAR(exr.at(x, y, "albedo.R"), 0.5f, 1e-3f);
    std::size_t hits = 0;
    for (int j = 0; j < exr.height; ++j)
        for (int i = 0; i < exr.width; ++i) {
            const bool hit = std::isfinite(exr.at(i, j, "depth.Z")) && exr.at(i, j, "depth.Z") > 0;
            hits += hit;
            const float nx = exr.at(i, j, "normal.X"), ny = exr.at(i, j, "normal.Y"), nz = exr.at(i, j, "normal.Z");
            const float length = std::sqrt(nx * nx + ny * ny + nz * nz);
            if (hit) {
                EXPECT_LE(length, 1.0f + 1e-5f) << "a mean of unit vectors, at " << i << " " << j;
                EXPECT_GT(length, 0.7f) << i << " " << j;
                EXPECT_GE(exr.at(i, j, "depth.Z"), 4.0f - 1e-4f);
                EXPECT_LE(exr.at(i, j, "depth.Z"), std::sqrt(24.0f) + 1e-3f) << "beyond the sphere's edge";
            } else {
                EXPECT_EQ(length, 0.0f) << i << " " << j;
            }
        }
    EXPECT_GT(hits, 50u);
    EXPECT_LT(hits, 300u);
    const auto has = [&](const std::string& prefix) {
        return std::any_of(exr.channels.begin(), exr.channels.end(),
                           [&](const std::string& c) { return c.starts_with(prefix); });
    };
    for (const char* name : {"object", "samples", "variance"}) EXPECT_TRUE(has(name)) << name;
}

TEST_F(CliRender, the_normal_of_one_sample_is_a_unit_vector) {
    const Exr exr = render("one.exr", {"--spp", "1", "--aov", "normal,depth"});
    int hits = 0;
    for (int y = 0; y < exr.height; ++y)
        for (int x = 0; x < exr.width; ++x) {
            const float nx = exr.at(x, y, "normal.X"), ny = exr.at(x, y, "normal.Y"), nz = exr.at(x, y, "normal.Z");
            if (nx == 0 && ny == 0 && nz == 0) continue;
            EXPECT_NEAR(std::sqrt(nx * nx + ny * ny + nz * nz), 1.0f, 1e-5f) << x << " " << y;
            EXPECT_GT(nz, 0.0f) << "what is seen faces the camera";
            ++hits;
        }
    EXPECT_GT(hits, 50);
}

TEST_F(CliRender, a_png_has_its_further_outputs_beside_it) {
    EXPECT_EQ(run({"render", scene, "-o", at("a.png"), "--aov", "depth", "--quiet"}).code, 0);
    EXPECT_EQ(files(), (std::vector<std::string>{"a.aov.exr", "a.png", "scene.json"}));
    EXPECT_EQ(read_exr(at("a.aov.exr")).channels, std::vector<std::string>{"depth.Z"});
    const Result<PixelBuffer> png = read_pixels(at("a.png"));
    ASSERT_TRUE(png) << png.error().message;
    EXPECT_EQ(png->width, 24);
    EXPECT_EQ(png->height, 16);
    EXPECT_TRUE(std::holds_alternative<std::vector<std::uint8_t>>(png->data));
}

TEST_F(CliRender, a_time_limit_is_kept) {
    const auto start = std::chrono::steady_clock::now();
    const Outcome outcome = run({"render", scene, "-o", at("a.exr"), "--time", "1s", "--json"});
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const Json json = Json::parse(outcome.out);
    EXPECT_EQ(json["stopped_by"], "time");
    EXPECT_GT(json["spp"].get<double>(), 4) << "a limit alone means as many samples as it allows";
    EXPECT_NEAR(json["seconds"].get<double>(), 1.0, 0.35);
    EXPECT_LT(wall, 5.0);
    EXPECT_EQ(read_exr(at("a.exr")).attributes.at("spinel.stopped_by"), "time");
}

TEST_F(CliRender, a_noise_limit_is_reached) {
    const Outcome outcome = run({"render", scene, "-o", at("a.exr"), "--noise", "0.02", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const Json json = Json::parse(outcome.out);
    EXPECT_EQ(json["stopped_by"], "noise");
    EXPECT_LE(json["relative_error"].get<double>(), 0.02);
    EXPECT_GE(json["spp"].get<double>(), 16);
    const Outcome finer = run({"render", scene, "-o", at("b.exr"), "--noise", "0.005", "--json"});
    ASSERT_EQ(finer.code, 0) << finer.err;
    EXPECT_LE(Json::parse(finer.out)["relative_error"].get<double>(), 0.005);
    EXPECT_GT(Json::parse(finer.out)["spp"].get<double>(), 2 * json["spp"].get<double>());
}

TEST_F(CliRender, check_compares_with_what_the_scene_expects) {
    const std::string furnace = R"({"version": 1, "film": {"size": [8, 8]}, "integrator": {"spp": 1},
 "environment": {"type": "constant", "radiance": [0.25, 0.5, 1]}, "expected": {"mean": [0.25, 0.5, )";
    write("right.json", furnace + "1], \"tolerance\": 0.001}}");
    write("wrong.json", furnace + "1.1], \"tolerance\": 0.05}}");
    write("bad.json", "{");
    const Outcome right = run({"render", at("right.json"), "-o", at("a.exr"), "--check", "--quiet"});
    EXPECT_EQ(right.code, 0) << right.err;
    expect_complaint(run({"render", at("wrong.json"), "-o", at("b.exr"), "--check", "--quiet"}), 3,
                     "expected (0.25, 0.5, 1.1)");
    EXPECT_TRUE(std::filesystem::exists(at("b.exr"))) << "the picture tells what went wrong";
    expect_complaint(run({"render", at("bad.json"), "-o", at("c.exr"), "--check", "--quiet"}), 1, "bad.json");
}

TEST_F(CliRender, quiet_says_nothing_and_json_gives_one_object) {
    const Outcome quiet = run({"render", scene, "-o", at("a.png"), "--quiet"});
    EXPECT_EQ(quiet.code, 0);
    EXPECT_EQ(quiet.out + quiet.err, "");
    const Outcome plain = run({"render", scene, "-o", at("a.png")});
    EXPECT_EQ(plain.out, "") << "messages go to stderr";
    EXPECT_NE(plain.err.find("24x16, 4 spp"), std::string::npos) << plain.err;
    const Outcome json = run({"render", scene, "-o", at("a.png"), "--json"});
    EXPECT_EQ(json.err, "");
    const Json object = Json::parse(json.out);
    EXPECT_EQ(object["width"], 24);
    EXPECT_EQ(object["height"], 16);
    EXPECT_EQ(object["spp"], 4);
    EXPECT_EQ(object["output"], at("a.png"));
    EXPECT_EQ(object["mean"].size(), 3u);
}

TEST_F(CliRender, a_bad_file_of_a_batch_does_not_take_the_others_with_it) {
    write("bad.json", "{\"version\": 1, \"colour\": 2}");
    write("cube.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    const Outcome outcome = run({"render", scene, at("bad.json"), at("none.vox"), at("cube.obj"), "-o", at("out/"),
                                 "--spp", "1", "--size", "16x9", "--quiet"});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 2) << outcome.err;
    EXPECT_TRUE(std::filesystem::exists(at("out/scene.png")));
    EXPECT_TRUE(std::filesystem::exists(at("out/cube.png")));
    EXPECT_FALSE(std::filesystem::exists(at("out/bad.png")));
    const Outcome named = run({"render", scene, at("cube.obj"), "-o", at("made/{name}-small.exr"), "--spp", "1",
                               "--size", "16x9", "--quiet"});
    EXPECT_EQ(named.code, 0) << named.err;
    EXPECT_EQ(read_exr(at("made/scene-small.exr")).width, 16);
    EXPECT_EQ(read_exr(at("made/cube-small.exr")).width, 16);
}

TEST_F(CliRender, a_file_whose_name_is_not_text_is_still_rendered) {
    const std::string odd = write("odd\xff.json", sphere_scene()).string();
    const Outcome outcome = run({"render", odd, "-o", at("a.png"), "--json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(Json::accept(outcome.out)) << outcome.out;
}

TEST_F(CliRender, volumes_that_dvr_does_not_show_are_told_of) {
    write("v.svol", "spinel volume 1\nsize 2 2 2\ntype u8\nspacing 1 1 1\n\n" + std::string(8, 'x'));
    const auto scene_of = [&](const std::string& objects) {
        return R"({"version": 1, "film": {"size": [4, 4]}, "integrator": {"type": "dvr", "spp": 1},
          "media": {"m": {"scattering": 1, "density": "v"}}, "geometries": {"v": {"type": "volume", "file": "v.svol"}},
          "objects": [)" +
               objects + "]}";
    };
    const std::string one = R"({"geometry": "v", "interior": "m"})";
    write("one.json", scene_of(one));
    write("two.json", scene_of(one + "," + one));
    EXPECT_EQ(run({"render", at("one.json"), "-o", at("a.png")}).err.find("warning"), std::string::npos);
    const Outcome two = run({"render", at("two.json"), "-o", at("a.png")});
    EXPECT_EQ(two.code, 0) << two.err;
    EXPECT_NE(two.err.find("dvr shows the first of 2 volumes"), std::string::npos) << two.err;
    EXPECT_EQ(run({"render", at("two.json"), "--integrator", "path", "-o", at("a.png")}).err.find("warning"),
              std::string::npos);
}

}  // namespace
}  // namespace spinel::render_test
