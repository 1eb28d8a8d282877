#include "json_test.h"

namespace spinel::json_geometry_test {
namespace {

using test::scene_of;

std::string scene_text(const std::string& geometry) {
    return "{\"version\": 1, \"geometries\": {\n\"g\": " + geometry + "}}";
}

template <class T>
T read(const std::string& geometry) {
    const Scene scene = scene_of(scene_text(geometry));
    if (scene.geometries.empty() || !std::holds_alternative<T>(scene.geometries[0].data)) return {};
    return std::get<T>(scene.geometries[0].data);
}

std::string message(const std::string& geometry) { return test::message(scene_text(geometry)); }

TEST(JsonGeometry, analytic_shapes) {
    EXPECT_EQ(read<SphereGeometry>("{\"type\": \"sphere\", \"radius\": 3}").radius, 3);
    EXPECT_EQ(read<BoxGeometry>("{\"type\": \"box\", \"size\": [1, 2, 3]}").size, vec3(1, 2, 3));
    EXPECT_EQ(read<RectangleGeometry>("{\"type\": \"rectangle\", \"size\": [2, 3]}").size, vec2(2, 3));
    EXPECT_TRUE(
        std::holds_alternative<PlaneGeometry>(scene_of(scene_text("{\"type\": \"plane\"}")).geometries.at(0).data));
    EXPECT_EQ(message("{\"type\": \"sphere\", \"radius\": 0}"),
              "a.json:2:35: \"radius\" of geometry \"g\" is 0; allowed: > 0");
    EXPECT_EQ(message("{\"type\": \"spheer\"}"),
              "a.json:2:15: unknown geometry type \"spheer\" in geometry \"g\"; available: mesh, voxels, "
              "volume, sdf, sphere, "
              "box, plane, rectangle, sdf_voxels");
    EXPECT_EQ(message("{\"type\": \"plane\", \"radius\": 0}"),
              "a.json:2:24: unknown key \"radius\" in geometry \"g\" of type \"plane\"; allowed: type");
}

TEST(JsonGeometry, a_mesh_written_in_place) {
    const auto mesh = read<MeshGeometry>(R"({"type": "mesh", "positions": [[0,0,0], [1,0,0], [0,1,0], [0,0,1.5]],
        "triangles": [[0,1,2], [0,2,3]], "normals": [[0,0,1],[0,0,1],[0,0,1],[1,0,0]],
        "uvs": [[0,0],[1,0],[0,1],[1,1]], "slots": [0, 1]})");
    ASSERT_EQ(mesh.positions.size(), 4u);
    EXPECT_EQ(mesh.positions[3], vec3(0, 0, 1.5f));
    ASSERT_EQ(mesh.triangles.size(), 2u);
    EXPECT_EQ(mesh.triangles[1], uvec3(0, 2, 3));
    EXPECT_EQ(mesh.normals.at(3), vec3(1, 0, 0));
    EXPECT_EQ(mesh.uvs.at(2), vec2(0, 1));
    EXPECT_EQ(mesh.slots, (std::vector<std::uint32_t>{0, 1}));
}

TEST(JsonGeometry, a_mesh_that_is_wrong) {
    EXPECT_EQ(message("{\"type\": \"mesh\"}"), "a.json:2:6: geometry \"g\" needs \"positions\" (or \"file\")");
    const std::string start = "{\"type\": \"mesh\", \"positions\": [[0,0,0],[1,0,0],[0,1,0]],\n";
    EXPECT_EQ(message(start + "\"triangles\": [[0, 1, 3]]}"),
              "a.json:3:22: \"triangles\" of geometry \"g\" is 3; allowed: 0 … 2");
    EXPECT_EQ(message(start + "\"triangles\": [[0, 1]]}"),
              "a.json:3:15: \"triangles\" of geometry \"g\" must be arrays of 3 vertex indices, not an array of 2");
    EXPECT_EQ(message(start + "\"triangles\": []}"), "a.json:2:6: geometry \"g\" has no triangles");
    EXPECT_EQ(message(start + "\"triangles\": [[0, 1, 2]], \"uvs\": [[0, 0]]}"),
              "a.json:2:6: geometry \"g\" has 1 uvs; there must be none or 3");
    EXPECT_EQ(message("{\"type\": \"mesh\", \"triangles\": [[0, 1, 2]], \"positions\": [[0, 0]]}"),
              "a.json:2:63: \"positions\" of geometry \"g\" must be an array of 3 numbers, not an array of 2");
}

TEST(JsonGeometry, voxels_as_cells) {
    const auto voxels = read<VoxelGeometry>("{\"type\": \"voxels\", \"size\": [2, 1, 2], \"cells\": [0, 1, 65535, 3]}");
    EXPECT_EQ(voxels.tree->size(), ivec3(2, 1, 2));
    EXPECT_EQ(voxels.tree->voxel_count(), 3u);
    EXPECT_EQ(voxels.tree->at({1, 0, 0}), 1);
    EXPECT_EQ(voxels.tree->at({0, 0, 1}), 65535);
    EXPECT_EQ(voxels.tree->at({1, 0, 1}), 3);
    EXPECT_EQ(message("{\"type\": \"voxels\", \"size\": [2, 1, 2], \"cells\": [0, 1, 65536, 3]}"),
              "a.json:2:60: \"cells\" of geometry \"g\" is 65536; allowed: 0 … 65535");
    EXPECT_EQ(message("{\"type\": \"voxels\", \"size\": [2, 1, 2], \"cells\": [0, 1, 2]}"),
              "a.json:2:6: geometry \"g\": voxel set of size 2×1×2 has 3 cells instead of 4");
    EXPECT_EQ(message("{\"type\": \"voxels\"}"),
              "a.json:2:6: geometry \"g\" needs \"size\" with \"cells\" (or \"layers\" or \"file\")");
}

TEST(JsonGeometry, voxels_as_layers_from_the_bottom_up) {
    // Two layers of two rows along z, three cells along x.
    const auto voxels = read<VoxelGeometry>(R"({"type": "voxels", "layers": [["12.", "3 9"], ["az.", "..1"]]})");
    ASSERT_EQ(voxels.tree->size(), ivec3(3, 2, 2));
    const auto cell = [&](int i, int j, int k) { return int(voxels.tree->at({i, j, k})); };
    EXPECT_EQ(cell(0, 0, 0), 1);
    EXPECT_EQ(cell(1, 0, 0), 2);
    EXPECT_EQ(cell(2, 0, 0), 0);
    EXPECT_EQ(cell(0, 0, 1), 3);
    EXPECT_EQ(cell(1, 0, 1), 0);
    EXPECT_EQ(cell(2, 0, 1), 9);
    EXPECT_EQ(cell(0, 1, 0), 10);
    EXPECT_EQ(cell(1, 1, 0), 35);
    EXPECT_EQ(cell(2, 1, 1), 1);
    EXPECT_EQ(message(R"({"type": "voxels", "layers": [["12", "3"]]})"),
              "a.json:2:43: \"layers\" of geometry \"g\": a row of 1 characters, but the first row has 2");
    EXPECT_EQ(message(R"({"type": "voxels", "layers": [["12"], ["12", "12"]]})"),
              "a.json:2:44: \"layers\" of geometry \"g\": a layer of 2 rows, but the first has 1");
    EXPECT_EQ(message(R"({"type": "voxels", "layers": [["1#"]]})"),
              "a.json:2:37: \"layers\" of geometry \"g\": '#' is no voxel; allowed: '.' and ' ' (empty), 1…9, a…z");
    EXPECT_EQ(message(R"({"type": "voxels", "layers": []})"),
              "a.json:2:35: \"layers\" of geometry \"g\" holds no voxels");
    EXPECT_EQ(message(R"({"type": "voxels", "size": [1, 1, 1], "layers": [["1"]]})"),
              "a.json:2:25: \"size\" of geometry \"g\" excludes \"layers\"");
}

TEST(JsonGeometry, volumes) {
    EXPECT_EQ(message(R"({"type": "volume", "size": [1, 1, 2], "values": [1]})"),
              "a.json:2:6: geometry \"g\" has 1 values; its size needs 2");
    EXPECT_EQ(
        message(R"({"type": "volume", "size": [1, 1, 1], "values": [1], "filter": "sharp"})"),
        "a.json:2:69: \"filter\" of geometry \"g\" must be one of nearest, linear, cubic, not the text \"sharp\"");
}

TEST(JsonGeometry, sdf_text_and_tree_agree) {
    const auto text = read<SdfGeometry>(
        R"j({"type": "sdf", "expression": "difference(box(2, 3, 4), translate(1, 0, 0, sphere(1.25)))"})j");
    const auto tree = read<SdfGeometry>(R"({"type": "sdf", "expression": {"op": "difference", "args": [
        {"op": "box", "x": 2, "y": 3, "z": 4},
        {"op": "translate", "x": 1, "y": 0, "z": 0, "args": [{"op": "sphere", "radius": 1.25}]}]},
        "bounds": [[-1, -2, -3], [1, 2, 3]]})");
    for (const SdfGeometry& sdf : {text, tree}) {
        EXPECT_EQ(sdf.root.op, "difference");
        ASSERT_EQ(sdf.root.children.size(), 2u);
        EXPECT_EQ(sdf.root.children[0].op, "box");
        EXPECT_EQ(sdf.root.children[0].numbers, (std::vector<float>{2, 3, 4}));
        EXPECT_EQ(sdf.root.children[1].numbers, (std::vector<float>{1, 0, 0}));
        ASSERT_EQ(sdf.root.children[1].children.size(), 1u);
        EXPECT_EQ(sdf.root.children[1].children[0].numbers, std::vector<float>{1.25f});
    }
    EXPECT_FALSE(text.bounds);
    ASSERT_TRUE(tree.bounds);
    EXPECT_EQ(tree.bounds->first, vec3(-1, -2, -3));
    EXPECT_EQ(tree.bounds->second, vec3(1, 2, 3));
}

TEST(JsonGeometry, volumes_as_surfaces) {
    const std::string samples = R"("type": "volume", "size": [1, 1, 2], "values": [1, 2])";
    EXPECT_FALSE(read<VolumeGeometry>("{" + samples + "}").surface);
    const auto plain = read<VolumeGeometry>("{" + samples + R"(, "as": "surface"})");
    EXPECT_TRUE(plain.surface);
    EXPECT_EQ(plain.level, 0);
    EXPECT_FALSE(plain.solid_above);
    const auto above = read<VolumeGeometry>("{" + samples + R"(, "as": "surface", "level": 1.5, "solid": "above"})");
    EXPECT_EQ(above.level, 1.5f);
    EXPECT_TRUE(above.solid_above);
    EXPECT_EQ(message("{" + samples + R"(, "level": 1})"),
              "a.json:2:6: \"level\" of geometry \"g\" needs \"as\": \"surface\"");
    EXPECT_NE(message("{" + samples + R"(, "as": "mesh"})").find("fog, surface"), std::string::npos);
}

TEST(JsonGeometry, sdf_that_is_wrong) {
    const auto sdf = [](const std::string& expression) {
        return message("{\"type\": \"sdf\",\n\"expression\": " + expression + "}");
    };
    EXPECT_EQ(sdf("{\"op\": \"spheer\"}").substr(0, 60),
              "a.json:3:22: unknown operation 'spheer'; available: sphere, ");
    EXPECT_EQ(sdf("{\"op\": \"sphere\"}"), "a.json:3:15: \"sphere\" in geometry \"g\" needs \"radius\"");
    EXPECT_EQ(sdf("{\"op\": \"sphere\", \"radius\": 1, \"x\": 1}"),
              "a.json:3:45: unknown key \"x\" of \"sphere\" in geometry \"g\"; allowed: op, radius");
    EXPECT_EQ(sdf("{\"op\": \"sphere\", \"radius\": -1}").substr(0, 54),
              "a.json:3:42: \"radius\" of \"sphere\" in geometry \"g\" is -");
    EXPECT_EQ(sdf("{\"op\": \"union\", \"args\": []}").substr(0, 32), "a.json:3:15: union takes 2 or mo");
    EXPECT_EQ(sdf("{\"args\": []}"), "a.json:3:15: an SDF node of geometry \"g\" needs \"op\"");
    EXPECT_EQ(sdf("3"),
              "a.json:3:15: \"expression\" of geometry \"g\" must be a text or an object with \"op\", not a "
              "number");
    EXPECT_EQ(sdf("\"spheer(1)\"").substr(0, 46), "a.json:3:15: \"expression\" of geometry \"g\":1:1:");
    EXPECT_EQ(sdf("\"sphere(1)\", \"bounds\": [[0, 0, 0], [1, 0, 1]]"),
              "a.json:2:6: geometry \"g\" has bounds whose lower corner is not below the upper one");
}

}  // namespace
}  // namespace spinel::json_geometry_test
