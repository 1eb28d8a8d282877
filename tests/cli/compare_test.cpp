// `spinel compare`: how far two pictures are apart, and whether that is too far.

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/run_program.h"
#include "image/image_io.h"
#include "image/tone_map.h"

namespace spinel::compare_test {
namespace {

using Json = nlohmann::json;

class CliCompare : public ProgramTest {
  protected:
    // A plain picture of 8 x 4.
    void plain(const std::string& name, float value, int channels = 3) {
        const std::vector<std::string> names = {"R", "G", "B", "A"};
        const Image image{8, 4, channels, std::vector<float>(std::size_t(32 * channels), value)};
        const auto written = write_image(folder / name, {{{names.begin(), names.begin() + channels}, image}});
        ASSERT_TRUE(written) << written.error().message;
    }
    double value(const std::string& a, const std::string& b, const std::string& metric) const {
        const Outcome outcome = run({"compare", at(a), at(b), "--metric", metric, "--json"});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        return Json::parse(outcome.out)["value"];
    }
};

TEST_F(CliCompare, every_metric_is_0_for_equal_pictures_and_more_for_others) {
    plain("a.png", 0.5f);
    plain("b.png", 0.6f);
    plain("a.exr", 0.5f);
    plain("b.exr", 0.6f);
    for (const char* metric : {"rmse", "relmse", "flip", "mean"}) {
        EXPECT_EQ(value("a.png", "a.png", metric), 0.0) << metric;
        EXPECT_GT(value("a.png", "b.png", metric), 0.0) << metric;
        EXPECT_EQ(value("a.exr", "a.exr", metric), 0.0) << metric;
        EXPECT_GT(value("a.exr", "b.exr", metric), 0.0) << metric;
    }
    EXPECT_NEAR(value("a.exr", "b.exr", "rmse"), 0.1, 1e-6);
    EXPECT_NEAR(value("a.exr", "b.exr", "mean"), 1.0 / 6, 1e-6);
}

// 8 bits are decoded: a PNG equals the EXR of the light that it shows.
TEST_F(CliCompare, bytes_and_floats_meet_as_light) {
    plain("a.png", 0.6f);
    plain("a.exr", srgb_decoded(0.6f));
    for (const char* metric : {"rmse", "mean", "flip"}) EXPECT_LT(value("a.png", "a.exr", metric), 1e-4) << metric;
    plain("alpha.png", 0.6f, 4);
    EXPECT_EQ(value("a.png", "alpha.png", "rmse"), 0.0) << "alpha does not count";
}

// So are 16 bits, whichever format holds them; a picture of floats is light as it is.
TEST_F(CliCompare, words_are_decoded_as_bytes_are) {
    std::string ppm = "P6\n8 4\n65535\n";
    for (int i = 0; i < 8 * 4 * 3; ++i) ppm += {char(0x99), char(0x99)};  // 0.6, the high byte first
    write("a.ppm", ppm);
    plain("a.exr", srgb_decoded(0.6f));
    plain("b.exr", 0.6f);
    EXPECT_LT(value("a.ppm", "a.exr", "rmse"), 4e-5);  // two steps of 16 bits
    EXPECT_GT(value("a.ppm", "b.exr", "rmse"), 0.2);
    plain("a.png", 0.6f);
    EXPECT_LT(value("a.ppm", "a.png", "rmse"), 4e-5) << "0.6 is a whole number of steps of both";
}

TEST_F(CliCompare, above_the_threshold_the_comparison_has_failed) {
    plain("a.exr", 0.5f);
    plain("b.exr", 0.6f);
    const Outcome within = run({"compare", at("a.exr"), at("b.exr"), "--threshold", "0.11"});
    EXPECT_EQ(within.code, 0);
    EXPECT_EQ(within.out, "rmse 0.1\n");
    EXPECT_EQ(within.err, "");
    const Outcome beyond = run({"compare", at("a.exr"), at("b.exr"), "--threshold", "0.09"});
    EXPECT_EQ(beyond.code, 3);
    EXPECT_EQ(beyond.out, "rmse 0.1\n");
    EXPECT_NE(beyond.err.find("rmse is 0.1, not within 0.09"), std::string::npos) << beyond.err;
    const Json json = Json::parse(run({"compare", at("a.exr"), at("b.exr"), "--threshold", "0.09", "--json"}).out);
    EXPECT_EQ(json["within"], false);
    plain("nan.exr", NAN);
    EXPECT_EQ(run({"compare", at("nan.exr"), at("a.exr"), "--threshold", "1"}).code, 3) << "NaN is within nothing";
}

TEST_F(CliCompare, what_cannot_be_compared_is_refused) {
    plain("a.png", 0.5f);
    plain("grey.png", 0.5f, 1);
    write("text.png", "not a picture");
    expect_complaint(run({"compare", at("a.png"), at("grey.png")}), 1, "different shape");
    expect_complaint(run({"compare", at("a.png"), at("none.png")}), 1, "none.png");
    expect_complaint(run({"compare", at("a.png"), at("text.png")}), 1, "text.png");
    expect_complaint(run({"compare", at("a.png"), at("a.png"), "--metric", "taste"}), 2, "flip");
    expect_complaint(run({"compare", at("a.png"), at("a.png"), "--threshold", "-1"}), 2, "--threshold");
    expect_complaint(run({"compare", at("a.png"), at("a.png"), "--threshold", "nan"}), 2, "--threshold");
    expect_complaint(run({"compare", at("a.png")}), 2, "REFERENCE");
}

}  // namespace
}  // namespace spinel::compare_test
