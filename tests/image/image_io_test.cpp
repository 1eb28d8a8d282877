#include "image/image_io.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

namespace spinel::image_io_test {
namespace {

namespace fs = std::filesystem;
const fs::path data_folder = fs::path(SPINEL_SOURCE_DIR) / "../shared/data";

// An empty folder of its own for each test.
class ImageIo : public testing::Test {
  protected:
    void SetUp() override {
        folder = fs::path(testing::TempDir()) /
                 (std::string("spinel_image_io_") + testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder);
        fs::create_directories(folder);
    }
    void TearDown() override { fs::remove_all(folder); }
    std::size_t file_count() const {
        return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }
    fs::path folder;
};

Image ramp(int width, int height, int channels) {
    Image image{width, height, channels, {}};
    for (int i = 0; i < width * height * channels; ++i) image.values.push_back(float(i % 256) / 255.0f);
    return image;
}

std::string bytes_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

TEST_F(ImageIo, png_gives_back_its_bytes) {
    for (const int channels : {1, 3, 4}) {
        const std::vector<std::string> names[] = {{}, {"Y"}, {}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
        const Image image = ramp(9, 5, channels);
        const fs::path path = folder / "a.png";
        const Result<void> written = write_image(path, {{names[channels], image}});
        ASSERT_TRUE(written) << written.error().message;
        const Result<PixelBuffer> pixels = read_pixels(path);
        ASSERT_TRUE(pixels) << pixels.error().message;
        EXPECT_EQ(pixels->width, 9);
        EXPECT_EQ(pixels->height, 5);
        ASSERT_EQ(pixels->channels, channels);
        const auto& bytes = std::get<std::vector<std::uint8_t>>(pixels->data);
        for (std::size_t i = 0; i < image.values.size(); ++i) EXPECT_EQ(bytes[i], i % 256);
        const Result<Image> floats = read_image(path);
        ASSERT_TRUE(floats);
        EXPECT_EQ(floats->values, image.values);
    }
}

TEST_F(ImageIo, transparent_pixels_keep_their_color) {
    const Image image{1, 1, 4, {1.0f, 0.6f, 0.2f, 0.0f}};
    ASSERT_TRUE(write_image(folder / "a.png", {{{"R", "G", "B", "A"}, image}}));
    const Result<Image> back = read_image(folder / "a.png");
    ASSERT_TRUE(back);
    EXPECT_EQ(back->values, image.values);
}

TEST_F(ImageIo, png_clamps_and_survives_values_that_are_no_number) {
    const Image image{4, 1, 1, {NAN, -3.0f, INFINITY, 0.5f}};
    ASSERT_TRUE(write_image(folder / "a.png", {{{"Y"}, image}}));
    const Result<PixelBuffer> back = read_pixels(folder / "a.png");
    ASSERT_TRUE(back);
    EXPECT_EQ(std::get<std::vector<std::uint8_t>>(back->data), (std::vector<std::uint8_t>{0, 0, 255, 128}));
}

TEST_F(ImageIo, exr_keeps_floats_to_the_last_bit_beside_layers) {
    Image color{3, 2, 3, {}}, depth{3, 2, 1, {}}, id{3, 2, 1, {}};
    for (int i = 0; i < 18; ++i) color.values.push_back(std::exp(float(i) - 9.0f));
    for (int i = 0; i < 6; ++i) {
        depth.values.push_back(i == 2 ? INFINITY : 1.0f / float(i + 3));
        id.values.push_back(float(16777216 - i));  // the largest indices that a float holds exactly
    }
    const fs::path path = folder / "a.exr";
    const Result<void> written = write_image(
        path, {{{"depth.Z"}, depth}, {{"R", "G", "B"}, color}, {{"object.id"}, id}}, {{"spinel:seed", "7"}});
    ASSERT_TRUE(written) << written.error().message;
    const Result<Image> back = read_image(path);  // five channels: the picture is chosen by name
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->channels, 3);
    EXPECT_EQ(back->values, color.values);
    for (const auto& [name, plane] : {std::pair{"depth.Z", &depth}, {"object.id", &id}}) {
        ASSERT_TRUE(write_image(folder / "b.exr", {{{name}, *plane}}));
        const Result<Image> single = read_image(folder / "b.exr");
        ASSERT_TRUE(single) << single.error().message;
        EXPECT_EQ(single->values, plane->values) << name;
    }
    EXPECT_NE(bytes_of(path).find("spinel:seed"), std::string::npos);
}

TEST_F(ImageIo, integers_of_16_bits_are_fractions_that_are_encoded) {
    std::ofstream(folder / "a.ppm", std::ios::binary)
        << "P6\n2 1\n65535\n" + std::string("\x00\x00\x12\x34\x80\x00\xff\xff\x00\x01\x99\x99", 12);
    const Result<PixelBuffer> pixels = read_pixels(folder / "a.ppm");
    ASSERT_TRUE(pixels) << pixels.error().message;
    EXPECT_TRUE(pixels->encoded);
    const auto& values = std::get<std::vector<float>>(pixels->data);
    const float expected[] = {0, 0x1234, 0x8000, 0xffff, 1, 0x9999};
    ASSERT_EQ(values.size(), std::size(expected));
    for (std::size_t i = 0; i < values.size(); ++i)
        EXPECT_NEAR(values[i], expected[i] / 65535, 2e-5f) << i;  // a step of 16 bits
    ASSERT_TRUE(write_image(folder / "a.exr", {{{"Y"}, Image{1, 1, 1, {0.5f}}}}));
    EXPECT_FALSE(read_pixels(folder / "a.exr")->encoded);
}

TEST_F(ImageIo, half_planes_are_rounded_to_half) {
    const Image image{2, 1, 1, {1.0f / 3.0f, 65504.0f}};
    ASSERT_TRUE(write_image(folder / "a.exr", {{{"Y"}, image, true}}));
    const Result<Image> back = read_image(folder / "a.exr");
    ASSERT_TRUE(back);
    EXPECT_NE(back->values[0], image.values[0]);
    EXPECT_NEAR(back->values[0], image.values[0], 1.0f / 8192.0f);
    EXPECT_EQ(back->values[1], 65504.0f);
}

TEST_F(ImageIo, a_failed_write_leaves_the_old_file_and_nothing_else) {
    const fs::path path = folder / "a.png";
    ASSERT_TRUE(write_image(path, {{{"R", "G", "B"}, ramp(4, 4, 3)}}));
    const std::string before = bytes_of(path);
    EXPECT_FALSE(write_image(path, {{{"R", "G", "B"}, ramp(4, 4, 3)}, {{"depth.Z"}, ramp(4, 4, 1)}}));
    EXPECT_FALSE(write_image(path, {{{"R", "G"}, ramp(4, 4, 3)}}));
    EXPECT_FALSE(write_image(path, {}));
    EXPECT_EQ(bytes_of(path), before);
    EXPECT_FALSE(write_image(folder / "a.jpeg2", {{{"Y"}, ramp(4, 4, 1)}}));
    EXPECT_FALSE(write_image(folder / "nowhere" / "a.png", {{{"Y"}, ramp(4, 4, 1)}}));
    EXPECT_EQ(file_count(), 1u);
}

TEST_F(ImageIo, a_write_replaces_the_file_and_leaves_nothing_beside_it) {
    const fs::path path = folder / "a.exr";
    ASSERT_TRUE(write_image(path, {{{"Y"}, Image{1, 1, 1, {1.0f}}}}));
    ASSERT_TRUE(write_image(path, {{{"Y"}, Image{1, 1, 1, {2.0f}}}}));
    EXPECT_EQ(read_image(path)->values[0], 2.0f);
    EXPECT_EQ(file_count(), 1u);
}

TEST_F(ImageIo, reads_from_memory_what_it_reads_from_disk) {
    const fs::path path = folder / "a.png";
    ASSERT_TRUE(write_image(path, {{{"R", "G", "B"}, ramp(7, 3, 3)}}));
    const std::string bytes = bytes_of(path);
    const Result<PixelBuffer> pixels = read_pixels_from_memory(bytes.data(), bytes.size(), "texture 0.png");
    ASSERT_TRUE(pixels) << pixels.error().message;
    EXPECT_EQ(pixels->data, read_pixels(path)->data);
    const Result<PixelBuffer> damaged = read_pixels_from_memory(bytes.data(), bytes.size() / 2, "texture 0.png");
    ASSERT_FALSE(damaged);
    EXPECT_NE(damaged.error().message.find("texture 0.png"), std::string::npos);
    EXPECT_FALSE(read_pixels_from_memory("hello", 5, "texture 1.png"));
    EXPECT_FALSE(read_pixels_from_memory(nullptr, 0, "texture 2.png"));
}

TEST_F(ImageIo, an_error_is_one_line_with_the_name_of_the_file) {
    std::ofstream(folder / "text.png") << "this is not a picture";
    for (const fs::path& path : {folder / "absent.png", folder / "text.png", folder}) {
        const Result<PixelBuffer> pixels = read_pixels(path);
        ASSERT_FALSE(pixels);
        EXPECT_NE(pixels.error().message.find(path.string()), std::string::npos) << pixels.error().message;
        EXPECT_EQ(pixels.error().message.find('\n'), std::string::npos) << pixels.error().message;
    }
}

TEST_F(ImageIo, a_size_beyond_the_limit_is_refused_before_memory_is_taken) {
    ASSERT_TRUE(write_image(folder / "a.png", {{{"Y"}, ramp(2, 2, 1)}}));
    std::string bytes = bytes_of(folder / "a.png");
    for (const int corner : {16, 20}) bytes[std::size_t(corner)] = 1;  // width and height grow by 2^24 in the header
    EXPECT_FALSE(read_pixels_from_memory(bytes.data(), bytes.size(), "a.png"));
}

TEST_F(ImageIo, damaged_exr_files_are_refused_with_one_line) {
    if (!fs::exists(data_folder / "env/damaged")) GTEST_SKIP() << "no " << data_folder / "env/damaged";
    for (const auto& entry : fs::directory_iterator(data_folder / "env/damaged")) {
        const Result<PixelBuffer> pixels = read_pixels(entry.path());
        ASSERT_FALSE(pixels) << entry.path();
        EXPECT_NE(pixels.error().message.find(entry.path().filename().string()), std::string::npos);
        EXPECT_EQ(pixels.error().message.find('\n'), std::string::npos) << pixels.error().message;
    }
}

TEST_F(ImageIo, reads_real_environments) {
    if (!fs::exists(data_folder / "env")) GTEST_SKIP() << "no " << data_folder / "env";
    struct Case {
        const char* file;
        int width, height, channels;
    };
    for (const Case& c : {Case{"env/hdr/studio_1k.hdr", 1024, 512, 3},
                          {"env/exr/blender_city.exr", 1024, 512, 3},
                          {"env/exr/openexr_KernerEnvLatLong.exr", 1024, 512, 4},
                          {"env/exr/openexr_WideFloatRange.exr", 500, 500, 1}}) {
        const Result<PixelBuffer> pixels = read_pixels(data_folder / c.file);
        ASSERT_TRUE(pixels) << pixels.error().message;
        EXPECT_EQ(pixels->width, c.width) << c.file;
        EXPECT_EQ(pixels->height, c.height) << c.file;
        EXPECT_EQ(pixels->channels, c.channels) << c.file;
        const auto& values = std::get<std::vector<float>>(pixels->data);
        EXPECT_EQ(values.size(), pixels->value_count());
        EXPECT_GT(*std::max_element(values.begin(), values.end()), 1.0f) << c.file;
    }
}

}  // namespace
}  // namespace spinel::image_io_test
