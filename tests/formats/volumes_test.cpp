// Every reader of volumes on small files that the tests write, and on real ones where they are at hand.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "formats/volume_scene.h"
#include "image/image_io.h"
#include "kernels/portable.h"
#include "scene/validate.h"
#include "spinel/formats.h"
#include "test_files.h"

namespace spinel::volumes_test {
namespace {

using Volumes = FileTest;

template <class T>
std::string big(T value) {
    std::string bytes = raw(value);
    std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

std::string gzipped(const std::string& bytes) {
    z_stream stream{};
    deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&stream, uLong(bytes.size())), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = uInt(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = uInt(out.size());
    deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

// The world position of the middle of sample (i, j, k).
vec3 place(const Grid& grid, ivec3 i) { return grid.index_to_local * vec4(vec3(i) + 0.5f, 1); }

void expect_near(vec3 a, vec3 b, float tolerance = 1e-4f) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance);
}

// A NIfTI-1 file of 2×3×4 numbers of 16 bits, i + 10 j + 100 k; sform, qform and scaling as told.
struct Nifti {
    bool big_endian = false;
    int sform = 0, qform = 0;
    float slope = 0, intercept = 0;
    std::array<float, 12> srow = {};
    std::array<float, 3> quatern = {}, offset = {};
    float handed = 1;
    int volumes = 1, datatype = 4;

    std::string bytes() const {
        std::string b(352, '\0');
        const auto put = [&](std::size_t at, auto value) {
            const std::string raw_bytes = big_endian ? big(value) : raw(value);
            b.replace(at, raw_bytes.size(), raw_bytes);
        };
        put(0, std::int32_t(348));
        const std::int16_t dims[] = {std::int16_t(volumes > 1 ? 4 : 3), 2, 3, 4, std::int16_t(volumes), 1, 1, 1};
        for (std::size_t i = 0; i < 8; ++i) put(40 + 2 * i, dims[i]);
        put(70, std::int16_t(datatype));
        const float spacing[] = {handed, 2, 3, 5};
        for (std::size_t i = 0; i < 4; ++i) put(76 + 4 * i, spacing[i]);
        put(108, 352.0f);
        put(112, slope);
        put(116, intercept);
        put(252, std::int16_t(qform));
        put(254, std::int16_t(sform));
        for (std::size_t i = 0; i < 3; ++i) {
            put(256 + 4 * i, quatern[i]);
            put(268 + 4 * i, offset[i]);
        }
        for (std::size_t i = 0; i < 12; ++i) put(280 + 4 * i, srow[i]);
        b.replace(344, 4, std::string("n+1\0", 4));
        for (int v = 0; v < volumes; ++v)
            for (int k = 0; k < 4; ++k)
                for (int j = 0; j < 3; ++j)
                    for (int i = 0; i < 2; ++i) {
                        const auto value = std::int16_t(i + 10 * j + 100 * k - 1000 * v);
                        b += big_endian ? big(value) : raw(value);
                    }
        return b;
    }
};

Grid only_grid(const Result<Scene>& scene) {
    EXPECT_TRUE(scene) << scene.error().message;
    if (!scene) return {};
    const Result<void> valid = validate(*scene);
    EXPECT_TRUE(valid) << valid.error().message;
    EXPECT_EQ(scene->grids.size(), 1u);
    return scene->grids[0];
}

TEST_F(Volumes, nifti_of_either_byte_order_packed_or_not) {
    for (const bool order : {false, true})
        for (const bool packed : {false, true}) {
            const Nifti file{.big_endian = order};
            const std::string name = packed ? "a.nii.gz" : "a.nii";
            const Grid grid = only_grid(load_model(write(name, packed ? gzipped(file.bytes()) : file.bytes())));
            EXPECT_EQ(grid.name, "a");
            EXPECT_EQ(grid.samples->size(), ivec3(2, 3, 4));
            for (int k = 0; k < 4; ++k)
                for (int j = 0; j < 3; ++j)
                    for (int i = 0; i < 2; ++i) EXPECT_EQ(grid.samples->at({i, j, k}), float(i + 10 * j + 100 * k));
            // Without a form samples stand at multiples of the spacing; y to the front is −z, z up is +y.
            expect_near(place(grid, {1, 2, 3}), {2, 15, -6});
        }
}

TEST_F(Volumes, nifti_is_oriented_by_its_sform_or_else_its_qform) {
    Nifti file{
        .sform = 1, .qform = 1, .srow = {0, 0, -5, 7, 2, 0, 0, 8, 0, 3, 0, 9}, .quatern = {0, 0, std::sqrt(0.5f)}};
    file.offset = {10, 20, 30};
    expect_near(place(only_grid(load_model(write("a.nii", file.bytes()))), {1, 2, 3}), vec3(7 - 15, 9 + 6, -(8 + 2)));
    file.sform = 0;  // a quarter of a turn about z: x goes to y, y to −x
    expect_near(place(only_grid(load_model(write("a.nii", file.bytes()))), {1, 2, 3}),
                vec3(10 - 6, 30 + 15, -(20 + 2)));
    file.handed = -1;
    expect_near(place(only_grid(load_model(write("a.nii", file.bytes()))), {1, 2, 3}),
                vec3(10 - 6, 30 - 15, -(20 + 2)));
}

TEST_F(Volumes, nifti_keeps_the_units_that_its_scaling_means) {
    const Grid grid = only_grid(load_model(write("a.nii", Nifti{.slope = 2, .intercept = -1024}.bytes())));
    EXPECT_EQ(grid.samples->at({1, 2, 3}), 2 * 321 - 1024.0f);
    EXPECT_EQ(grid.samples->minimum(), -1024.0f);
    EXPECT_EQ(grid.background, -1024.0f);
}

TEST_F(Volumes, nifti_holds_a_row_of_volumes) {
    const auto path = write("a.nii", Nifti{.volumes = 3}.bytes());
    EXPECT_EQ(only_grid(load_model(path)).samples->at({1, 2, 3}), 321.0f);
    LoadOptions options;
    options.frame = 2;
    EXPECT_EQ(only_grid(load_model(path, options)).samples->at({1, 2, 3}), 321.0f - 2000);
    options.frame = 3;
    expect_refused(load_model(path, options), path, "3 volumes");
}

TEST_F(Volumes, nifti_that_is_wrong_is_refused_before_anything_is_allocated) {
    const auto refused = [&](const std::string& bytes, const std::string& why) {
        const auto path = write("a.nii", bytes);
        expect_refused(load_model(path), path, why);
    };
    refused("", "not a NIfTI");
    refused(std::string(400, 'x'), "not a NIfTI");
    std::string bytes = Nifti{}.bytes();
    refused(bytes.substr(0, 200), "cut off");
    refused(bytes.substr(0, bytes.size() - 1), "400 bytes up to the end of this volume, there are 399");
    for (std::size_t i = 0; i < 3; ++i) bytes.replace(42 + 2 * i, 2, raw(std::int16_t(1000)));
    refused(bytes, "needs 2000000352 bytes");
    for (std::size_t i = 0; i < 3; ++i) bytes.replace(42 + 2 * i, 2, raw(std::int16_t(32000)));
    refused(bytes, "more than");
    const auto packed = write("a.nii.gz", gzipped(bytes));
    expect_refused(load_model(packed), packed, "more than");
    refused(Nifti{.datatype = 32}.bytes(), "complex");
    refused(Nifti{.datatype = 128}.bytes(), "colours");
    refused(Nifti{.sform = 1}.bytes(), "transform");
}

TEST_F(Volumes, nrrd_raw_packed_detached_and_oblique) {
    const std::string head =
        "NRRD0004\n# comment\ntype: short\ndimension: 3\nsizes: 2 1 3\nkey:=value\nspace: left-posterior-superior\n"
        "space directions: (0,2,0) (1,0,0) (0,0,3)\nspace origin: (5,6,7)\nsample units: \"HU\"\n";
    std::string samples;
    for (int i = 0; i < 6; ++i) samples += big(std::int16_t(100 * i - 250));
    const auto check = [&](const std::filesystem::path& path) {
        const Grid grid = only_grid(load_model(path));
        ASSERT_TRUE(grid.samples);
        EXPECT_EQ(grid.samples->dense(), (std::vector<float>{-250, -150, -50, 50, 150, 250}));
        EXPECT_EQ(grid.unit, "HU");
        // Left and back are −x and, turned, +z.
        expect_near(place(grid, {1, 0, 2}), {-5, 7 + 6, 6 + 2});
    };
    check(write("a.nrrd", head + "endian: big\nencoding: raw\n\n" + samples));
    check(write("b.nrrd", head + "endian: big\nencoding: gzip\n\n" + gzipped(samples)));
    write("c.bin", "skip\nxx" + samples);
    check(write("c.nhdr", head + "endian: big\nencoding: raw\nline skip: 1\nbyte skip: 2\ndata file: c.bin\n"));
    check(write("d.nhdr", head + "endian: big\nencoding: raw\nbyte skip: -1\ndata file: ./c.bin\n"));
    const auto path = folder / "e.nrrd";
    const auto refused = [&](const std::string& text, const std::string& why) {
        write("e.nrrd", text);
        expect_refused(load_model(path), path, why);
    };
    refused("NRRE0004\n\n", "not a NRRD");
    refused(head + "endian: big\nencoding: raw\n\n" + samples.substr(1), "needs 12 bytes of samples, there are 11");
    refused(head + "endian: big\nencoding: hex\n\n", "allowed: raw, gzip");
    refused(head + "encoding: raw\n\n" + samples, "endian");
    refused(head + "endian: big\nencoding: gzip\n\n" + samples, "not packed by gzip");
    refused("NRRD0004\ntype: float\ndimension: 3\nsizes: 1000 1000 1000\nendian: little\nencoding: raw\n\nxx",
            "needs 4000000000 bytes");
    refused("NRRD0004\ntype: block\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\n", "its type");
    refused(
        "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 1 1 1\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n"
        "encoding: raw\n\nabc",
        "holds 3 values for each place");
    write("f.nhdr", head + "endian: big\nencoding: raw\ndata file: absent.bin\n");
    expect_refused(load_model(folder / "f.nhdr"), folder / "f.nhdr", "absent.bin");
}

TEST_F(Volumes, metaimage) {
    const std::string head =
        "ObjectType = Image\nNDims = 3\nBinaryDataByteOrderMSB = False\nTransformMatrix = 1 0 0 0 -1 0 0 0 1\n"
        "Offset = 1 2 3\nElementSpacing = 2 3 4\nDimSize = 2 1 1\nElementType = MET_SHORT\n";
    const std::string samples = raw(std::int16_t(-7)) + raw(std::int16_t(9));
    const Grid grid =
        only_grid(load_model(write("a.mha", head + "CompressedData = False\nElementDataFile = LOCAL\n" + samples)));
    EXPECT_EQ(grid.samples->dense(), (std::vector<float>{-7, 9}));
    expect_near(place(grid, {1, 0, 0}), {-3, 3, 2});
    expect_near(place(grid, {0, 1, 0}) - place(grid, {0, 0, 0}), {0, 0, -3});
    const auto path = write("b.mha", head + "ElementDataFile = LOCAL\nx");
    expect_refused(load_model(path), path, "there are 1");
    expect_refused(load_model(write("c.mha", "hello\n")), folder / "c.mha", "not a MetaImage");
}

TEST_F(Volumes, mitsuba_volumes_fill_their_box) {
    const auto head = [](std::int32_t encoding, std::int32_t channels) {
        std::string b = "VOL\x03" + raw(encoding);
        for (const std::int32_t n : {2, 1, 1, channels}) b += raw(n);
        for (const float x : {0.0f, 1.0f, 2.0f, 4.0f, 2.0f, 5.0f}) b += raw(x);
        return b;
    };
    const Grid grid = only_grid(load_model(write("a.vol", head(1, 1) + raw(0.5f) + raw(7.0f))));
    EXPECT_EQ(grid.samples->dense(), (std::vector<float>{0.5f, 7}));
    expect_near(place(grid, {1, 0, 0}), {3, 1.5f, 3.5f});
    const Grid colors = only_grid(load_model(write("b.vol", head(3, 3) + std::string("\xff\0\x33\0\xff\0", 6))));
    EXPECT_EQ(colors.samples->channels(), 3);
    EXPECT_EQ(colors.samples->at({1, 0, 0}, 1), 1.0f);
    EXPECT_NEAR(colors.samples->at({0, 0, 0}, 2), 0.2f, 1e-6f);
    const Grid halves =
        only_grid(load_model(write("c.vol", head(2, 1) + raw(std::uint16_t(0x3800)) + raw(std::uint16_t(0xc000)))));
    EXPECT_EQ(halves.samples->dense(), (std::vector<float>{0.5f, -2}));
    const auto path = write("d.vol", head(1, 1) + raw(1.0f));
    expect_refused(load_model(path), path, "needs 8 bytes");
    expect_refused(load_model(write("e.vol", head(4, 1))), folder / "e.vol", "encoding is 4");
}

TEST_F(Volumes, raw_files_tell_their_size_by_their_name) {
    const Grid grid =
        only_grid(load_model(write("ct_2x1x2_int16.raw", raw(std::int16_t(-1)) + raw(std::int16_t(2)) +
                                                             raw(std::int16_t(3)) + raw(std::int16_t(4)))));
    EXPECT_EQ(grid.name, "ct");
    EXPECT_EQ(grid.samples->dense(), (std::vector<float>{-1, 2, 3, 4}));
    EXPECT_EQ(only_grid(load_model(write("a_3x1x1_u8.raw.gz", gzipped("abc")))).samples->at({2, 0, 0}), float('c'));
    expect_refused(load_model(write("a_3x1x1_u8.raw", "ab")), folder / "a_3x1x1_u8.raw", "needs 3 bytes");
    expect_refused(load_model(write("scan.raw", "ab")), folder / "scan.raw", "256x256x128");
}

TEST_F(Volumes, a_folder_or_a_row_of_pictures_is_a_stack) {
    for (const int slice : {9, 10, 11}) {
        Image image{2, 3, 1, {}};
        for (int i = 0; i < 6; ++i) image.values.push_back(float(10 * (slice - 9) + i) / 255);
        ASSERT_TRUE(write_image(folder / fmt::format("s{}.png", slice), {{{"Y"}, image}}));
    }
    for (const auto& path : {folder, folder / "s%d.png"}) {
        const Grid grid = only_grid(load_model(path));
        ASSERT_TRUE(grid.samples);
        EXPECT_EQ(grid.samples->size(), ivec3(2, 3, 3));
        EXPECT_NEAR(grid.samples->at({1, 2, 0}) * 255, 1, 1e-3f) << "the top row is the highest";
        EXPECT_NEAR(grid.samples->at({1, 0, 2}) * 255, 25, 1e-3f) << "s9 stands before s10";
    }
    ASSERT_TRUE(write_image(folder / "s12.png", {{{"Y"}, Image{1, 1, 1, {0}}}}));
    expect_refused(load_model(folder), folder / "s12.png", "1×1 pixels");
    expect_refused(load_model(folder / "t%03d.png"), folder / "t%03d.png", "no picture");
}

TEST_F(Volumes, real_scans_load_or_are_refused_as_they_should) {
    const auto volumes = data_folder / "volume";
    if (!std::filesystem::exists(volumes)) GTEST_SKIP() << volumes << " is not there";
    const std::map<std::string, std::string> wrong = {{"complex_unsupported.nii.gz", "complex"},
                                                      {"pointgrid.vdb", "points"},
                                                      {"tooth.raw", "name does not tell"},
                                                      {"cranium_256x256x108_i16.raw.gz", ""}};
    int loaded = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(volumes)) {
        if (!entry.is_regular_file()) continue;
        const auto& path = entry.path();
        const Result<Scene> scene = load_model(path);
        const auto known = wrong.find(path.filename().string());
        if (known != wrong.end() && !known->second.empty()) {
            expect_refused(scene, path, known->second);
            continue;
        }
        ASSERT_TRUE(scene) << scene.error().message;
        const Result<void> valid = validate(*scene);
        EXPECT_TRUE(valid) << path << valid.error().message;
        ++loaded;
    }
    EXPECT_GE(loaded, 30);
}

// The four files hold one head in different storage orders: at any place in space they hold the same value.
TEST_F(Volumes, one_head_in_four_storage_orders_is_the_same_head) {
    const auto space = data_folder / "volume/nifti/space";
    if (!std::filesystem::exists(space)) GTEST_SKIP() << space << " is not there";
    const Grid reference = only_grid(load_model(space / "RAS.nii.gz"));
    for (const char* name : {"ILA.nii.gz", "LPI.nii.gz", "PSR.nii.gz"}) {
        const Grid grid = only_grid(load_model(space / name));
        const glm::mat4 to_index = glm::inverse(glm::mat4(grid.index_to_local));
        const ivec3 size = reference.samples->size();
        int compared = 0;
        for (int z = 0; z < size.z; z += 3)
            for (int y = 0; y < size.y; y += 3)
                for (int x = 0; x < size.x; x += 3) {
                    const vec3 p = vec3(to_index * vec4(place(reference, {x, y, z}), 1));
                    const ivec3 i(glm::floor(p));
                    ASSERT_NEAR(glm::length(p - vec3(i) - 0.5f), 0, 0.02f) << name;
                    ASSERT_FLOAT_EQ(grid.samples->at(i), reference.samples->at({x, y, z})) << name;
                    ++compared;
                }
        EXPECT_GT(compared, 10000);
    }
}

}  // namespace
}  // namespace spinel::volumes_test
