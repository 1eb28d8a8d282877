// Mesh files that must not be believed: each is refused with one line, at once and without the memory that it asks for.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "formats/mesh_assimp.h"
#include "gltf_file.h"
#include "spinel/formats.h"

namespace spinel::mesh_refusal_test {
namespace {

class MeshRefusal : public GltfTest {
  protected:
    void refuse(const std::string& name, const std::string& bytes, const std::string& why) {
        SCOPED_TRACE(name);
        const auto path = write(name, bytes);
        expect_refused(path.extension() == ".gltf" ? load_gltf(path) : load_mesh(path), path, why);
    }
    static std::string ply(const std::string& vertices, const std::string& faces, const std::string& list = "uchar int",
                           const std::string& format = "binary_little_endian") {
        return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
               "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces + "\nproperty list " +
               list + " vertex_indices\nend_header\n";
    }
    static std::string triangle() {
        std::string data;
        for (const float f : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) data += raw(f);
        return data;
    }
    static std::string face() { return raw(0) + raw(1) + raw(2); }
};

TEST_F(MeshRefusal, counts_of_a_ply_are_held_against_its_size) {
    refuse("vertices.ply", ply("4000000000", "1") + triangle() + "\3" + face(), "4000000000 elements");
    refuse("faces.ply", ply("3", "4000000000") + triangle() + "\3" + face(), "4000000000 elements");
    refuse("below.ply", ply("-3", "1") + triangle() + "\3" + face(), "no count that is a whole number");
    refuse("list.ply", ply("3", "1", "uint int") + triangle() + raw(0xfffffff0u) + face(), "longer than what is left");
    refuse("broken.ply", ply("3", "1", "float int") + triangle() + raw(3.0f) + face(), "no whole number");
    refuse("text.ply", ply("3", "1", "uint int", "ascii") + "0 0 0\n1 0 0\n0 1 0\n4294967290 0 1 2\n",
           "longer than what is left");
    refuse("type.ply", ply("3", "1", "uchar quad") + triangle() + "\3" + face(), "unknown type 'quad'");
    // The same, sound: in either order of bytes, and in text with the line ends of another system.
    EXPECT_TRUE(load_mesh(write("good.ply", ply("3", "1", "uint int") + triangle() + raw(3u) + face())));
    EXPECT_TRUE(load_mesh(write("text.ply",
                                "ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nproperty float x\r\nproperty float "
                                "y\r\nproperty float z\r\nelement face 1\r\nproperty list uchar int "
                                "vertex_indices\r\nend_header\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 2\r\n")));
}

TEST_F(MeshRefusal, counts_of_an_off_are_held_against_its_size) {
    refuse("a.off", "OFF\n4000000000 1 0\n0 0 0\n", "4000000000 vertices");
    refuse("b.off", "OFF 3 4000000000 0\n0 0 0\n", "4000000000 faces");
    refuse("c.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n\x13 0\n0 1  0 10 1 ", "face 0 does not have 1 to 9 corners");
    refuse("d.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "face 0 refers to vertex '3' of 3");
    refuse("e.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n", "it ends before face 0");
    refuse("f.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1" + std::string(5000, ' ') + "2\n", "too long");
    EXPECT_TRUE(load_mesh(write("g.off", "OFF\n# a triangle\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")));
}

TEST_F(MeshRefusal, nodes_that_are_no_trees_are_named) {
    refuse("loop.gltf", bytes_of(gltf(R"([{"mesh": 0, "children": [0]}])", "[{}]")), "or below itself");
    // Each node twice the one below: 2²⁴ of them in the end.
    std::string doubled = "[";
    for (int i = 1; i <= 24; ++i) doubled += R"({"children": [)" + std::to_string(i) + "," + std::to_string(i) + "]},";
    refuse("doubled.gltf", bytes_of(gltf(doubled + R"({"mesh": 0}])", "[{}]")), "node 1 has two parents");
    std::string deep = "[";
    for (int i = 1; i <= 5000; ++i) deep += R"({"children": [)" + std::to_string(i) + "]},";
    refuse("deep.gltf", bytes_of(gltf(deep + R"({"mesh": 0}])", "[{}]")), "more than the 1000 nodes allowed");
    refuse("brackets.gltf", R"({"extras": )" + std::string(100000, '[') + std::string(100000, ']') + "}",
           "nested deeper than the 256 levels allowed");
}

// Rows of the data's manifest whose note says so.
TEST_F(MeshRefusal, negative_files_of_the_data_are_refused_with_one_line) {
    const auto manifest = data_folder / "MANIFEST.tsv";
    if (!std::filesystem::exists(manifest)) GTEST_SKIP() << "no " << manifest;
    std::istringstream lines(bytes_of(manifest));
    int refused = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line.rfind("mesh/", 0) != 0) continue;
        std::string note = line.substr(line.rfind('\t') + 1);
        std::transform(note.begin(), note.end(), note.begin(), [](unsigned char c) { return std::tolower(c); });
        if (note.find("negative") == std::string::npos) continue;
        const auto path = data_folder / line.substr(0, line.find('\t'));
        SCOPED_TRACE(path);
        const Result<Scene> read = load_model(path);
        expect_refused(read, path);
        if (path.filename() == "heart_draco.glb") expect_refused(read, path, "KHR_draco_mesh_compression");
        ++refused;
    }
    EXPECT_GE(refused, 1);
}

}  // namespace
}  // namespace spinel::mesh_refusal_test
