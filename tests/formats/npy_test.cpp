#include "formats/npy.h"

#include <gtest/gtest.h>

#include "test_files.h"

namespace spinel::npy_test {
namespace {

std::string npy(std::string header, const std::string& data, char major = 1) {
    header += '\n';
    std::string bytes("\x93NUMPY", 6);
    bytes += {major, '\0', char(header.size() & 255), char(header.size() >> 8)};
    if (major > 1) bytes += {'\0', '\0'};
    return bytes + header + data;
}
const std::string floats16 = [] {
    std::string bytes;
    for (int i = 0; i < 16; ++i) bytes += raw(float(i));
    return bytes;
}();

using Npy = FileTest;

TEST_F(Npy, rays_are_read_in_the_order_of_the_format) {
    for (const char major : {1, 2, 3}) {
        const auto path =
            write("r.npy", npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 8), }   ", floats16, major));
        const Result<std::vector<TraceRay>> rays = read_rays_npy(path);
        ASSERT_TRUE(rays) << rays.error().message;
        ASSERT_EQ(rays->size(), 2u);
        const TraceRay& second = (*rays)[1];
        EXPECT_EQ(second.origin, glm::vec3(8, 9, 10));
        EXPECT_EQ(second.t_min, 11);
        EXPECT_EQ(second.direction, glm::vec3(12, 13, 14));
        EXPECT_EQ(second.t_max, 15);
    }
    const auto any_order = write("r.npy", npy("{\"shape\":(0,8),'fortran_order':False,'descr':'<f4'}", ""));
    const Result<std::vector<TraceRay>> none = read_rays_npy(any_order);
    ASSERT_TRUE(none) << none.error().message;
    EXPECT_TRUE(none->empty());
}

TEST_F(Npy, what_is_not_a_batch_of_rays_is_refused_with_the_reason) {
    const auto refused = [&](const std::string& header, const std::string& data, const std::string& why) {
        const auto path = write("r.npy", npy(header, data));
        expect_refused(read_rays_npy(path), path, why);
    };
    refused("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 8), }", floats16, "'<f8'");
    refused("{'descr': '>f4', 'fortran_order': False, 'shape': (2, 8), }", floats16, "'>f4'");
    refused("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (2, 8), }", floats16, "[('a'");
    refused("{'descr': '<f4', 'fortran_order': True, 'shape': (2, 8), }", floats16, "C order");
    refused("{'descr': '<f4', 'fortran_order': False, 'shape': (4, 4), }", floats16, "(4, 4)");
    refused("{'descr': '<f4', 'fortran_order': False, 'shape': (16,), }", floats16, "(N, 8)");
    refused("{'descr': '<f4', 'fortran_order': False, 'shape': (3, 8), }", floats16, "need 96 bytes");
    refused("{'descr': '<f4', 'fortran_order': False, 'shape': (1, 8), }", floats16, "need 32 bytes");
    refused("{'descr': '<f4', 'fortran_order': False, 'shape': (18446744073709551615, 8), }", floats16, "rays");
    refused("{'descr': '<f4', 'fortran_order': False, 'shape': (576460752303423489, 8), }", floats16, "rays");
    refused("{'descr': '<f4', 'shape': (2, 8), }", floats16, "header is damaged");
    refused("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 8), ", floats16, "header is damaged");
    refused("", "", "header is damaged");
    const auto text = write("t.npy", "hello");
    expect_refused(read_rays_npy(text), text, "not a .npy file");
    expect_refused(read_rays_npy(folder / "absent.npy"), folder / "absent.npy", "no such file");
}

TEST_F(Npy, a_file_cut_anywhere_is_refused) {
    const std::string whole = npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 8), }", floats16);
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const auto path = write("r.npy", whole.substr(0, size));
        expect_refused(read_rays_npy(path), path);
    }
}

TEST_F(Npy, hits_are_written_as_the_structured_array_that_numpy_reads) {
    std::vector<TraceHit> hits(3);
    hits[1] = {1.5f, 2, 3, 0.25f, 0.5f, 0, 1, 0, -4, 5, 6, 7};
    const auto path = folder / "hits.npy";
    ASSERT_TRUE(write_hits_npy(path, hits));
    const std::string bytes = bytes_of(path);
    const std::size_t length = std::uint8_t(bytes[8]) + 256u * std::uint8_t(bytes[9]);
    EXPECT_EQ((10 + length) % 64, 0u);
    EXPECT_EQ(bytes[9 + length], '\n');
    EXPECT_EQ(bytes.substr(10, length)
                  .find("{'descr': [('t', '<f4'), ('instance', '<u4'), ('primitive', '<u4'), ('u', '<f4'), "
                        "('v', '<f4'), ('nx', "
                        "'<f4'), ('ny', '<f4'), ('nz', '<f4'), ('ix', '<i4'), ('iy', '<i4'), ('iz', '<i4'), "
                        "('material', '<u4')], "
                        "'fortran_order': False, 'shape': (3,), }"),
              0u);
    ASSERT_EQ(bytes.size(), 10 + length + 3 * 48);
    const std::string row = raw(1.5f) + raw(2u) + raw(3u) + raw(0.25f) + raw(0.5f) + raw(0.0f) + raw(1.0f) + raw(0.0f) +
                            raw(-4) + raw(5) + raw(6) + raw(7u);
    EXPECT_EQ(bytes.substr(10 + length + 48, 48), row);
    EXPECT_TRUE(write_hits_npy(folder / "none.npy", {}));
}

}  // namespace
}  // namespace spinel::npy_test
