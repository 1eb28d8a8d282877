// `spinel bench`: structures side by side on the same rays, which all see the same.

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "cli/run_program.h"
#include "geometry/mesh/mesh_structures.h"

namespace spinel::bench_test {
namespace {

class CliBench : public ProgramTest {};

const std::string blocks = R"({"version": 1,
 "environment": {"type": "constant", "radiance": 1},
 "materials": {"stone": {"type": "diffuse", "color": 0.5}},
 "objects": [{"geometry": {"type": "voxels", "layers": [["1111", "1..1", "1111"], ["1..1", "....", "1.1."], ["..1.", "....", "1..."]]},
              "material": "stone", "transform": [{"rotate": {"axis": [1, 2, 3], "degrees": 20}}]}]})";

TEST_F(CliBench, every_structure_sees_the_same_and_is_timed) {
    write("blocks.json", blocks);
    const Outcome outcome = run({"bench", at("blocks.json"), "--size", "64", "--repeats", "1", "--json", "--from",
                                 "9,6,8", "--at", "2,1,1", "--fov", "40"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    std::set<std::string> rays, structures, first;
    const nlohmann::json result = nlohmann::json::parse(outcome.out);
    for (const auto& row : result.at("rows")) {
        rays.insert(row.at("subject").get<std::string>() + " " + row.at("rays").get<std::string>());
        const std::string structure = row.at("structure");
        structures.insert(structure);
        EXPECT_GT(row.at("mrays_per_s").get<double>(), 0) << row;
        EXPECT_GT(row.at("bytes").get<double>(), 0) << row;
        // NanoVDB's steps accumulate rounding: it may see another voxel, which is not ours to mend.
        const nlohmann::json& differing = row.at("differing");  // null: of the one that the others are compared with
        if (differing.is_null()) {
            first.insert(structure);
        } else if (structure != "nanovdb-leaf-mask") {
            EXPECT_EQ(differing.get<double>(), 0) << row;
        }
    }
    EXPECT_EQ(first, (std::set<std::string>{"wide-bvh8", "64-tree"}));
    EXPECT_EQ(rays, (std::set<std::string>{"scene primary", "scene diffuse", "scene shadow", "voxels primary",
                                           "voxels diffuse"}));
    for (const char* name : {"wide-bvh8", "wide-bvh8, 8 rays", "64-tree", "64-tree, packets", "64-tree, stream",
                             "64-tree, one ray", "64-tree, kernel", "dense 3D-DDA"})
        EXPECT_TRUE(structures.contains(name)) << name;
}

TEST_F(CliBench, structures_of_meshes_are_measured_counted_and_drawn) {
    const std::string knot = std::string(SPINEL_SOURCE_DIR) + "/examples/knot.ply";
    const Outcome outcome = run({"bench", knot, "--size", "32", "--repeats", "1", "--json", "--scaling", "--structures",
                                 "bvh2,bvh2-stackless,kd-tree,grid,grid-hierarchical", "--html", at("report.html")});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json result = nlohmann::json::parse(outcome.out);
    std::set<std::string> seen;
    for (const auto& row : result.at("rows")) {
        if (row.at("subject") != "meshes") continue;
        seen.insert(row.at("structure").get<std::string>() + " " + row.at("rays").get<std::string>());
        EXPECT_GT(row.at("mrays_per_s").get<double>(), 0) << row;
        EXPECT_GT(row.at("build_ms").get<double>(), 0) << row;
        EXPECT_GT(row.at("build_ms_two_threads").get<double>(), 0) << row;
        const auto structure = find_mesh_structure(row.at("structure").get<std::string>());
        ASSERT_TRUE(structure) << row;
        EXPECT_EQ(row.contains("refit_ms"), (*structure)->refit != nullptr) << row;
        EXPECT_GT(row.at("sah_cost").get<double>(), 1) << row;
        EXPECT_GT(row.at("nodes_per_ray").get<double>(), 0) << row;
        EXPECT_GT(row.at("tests_per_ray").get<double>(), 0) << row;
        if (row.at("structure") == "bvh2") {
            EXPECT_TRUE(row.at("differing").is_null()) << row;
        } else {
            EXPECT_EQ(row.at("differing").get<double>(), 0) << row;
        }
    }
    for (const char* structure : {"bvh2", "bvh2-stackless", "kd-tree", "grid", "grid-hierarchical"})
        for (const char* rays : {"primary", "diffuse", "shadow"})
            EXPECT_TRUE(seen.contains(std::string(structure) + " " + rays)) << structure << ' ' << rays;
    EXPECT_EQ(seen.size(), 15u);
    std::set<std::size_t> sizes;
    for (const auto& row : result.at("scaling")) sizes.insert(row.at("triangles").get<std::size_t>());
    EXPECT_GE(sizes.size(), 3u);
    EXPECT_EQ(*sizes.rbegin(), 17920u);
    // Whole in itself: nothing is fetched from elsewhere.
    const std::string page = bytes_of(at("report.html"));
    EXPECT_NE(page.find("<svg"), std::string::npos);
    EXPECT_NE(page.find("data:image/png;base64,iVBORw0KGgo"), std::string::npos);
    EXPECT_EQ(page.find("http"), std::string::npos);
    EXPECT_EQ(page.find("nan"), std::string::npos);
}

TEST_F(CliBench, a_structure_alone_is_compared_with_nothing) {
    const std::string knot = std::string(SPINEL_SOURCE_DIR) + "/examples/knot.ply";
    const Outcome outcome = run({"bench", knot, "--size", "16", "--repeats", "1", "--structures", "kd-tree"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    std::istringstream lines(outcome.out);
    int rows = 0;
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with("meshes")) {
            ++rows;
            EXPECT_TRUE(line.ends_with(" -")) << line;
        }
    EXPECT_EQ(rows, 3) << outcome.out;
}

// No lattice parts the corners of a face that stands there many times.
TEST_F(CliBench, scaling_ends_where_a_mesh_gets_no_coarser) {
    std::string face = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (int i = 0; i < 2500; ++i) face += "f 1 2 3\n";
    write("face.obj", face);
    const Outcome outcome = run({"bench", at("face.obj"), "--size", "8", "--repeats", "1", "--json", "--scaling",
                                 "--structures", "bvh2-median"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json result = nlohmann::json::parse(outcome.out);
    std::set<std::size_t> sizes;
    for (const auto& row : result.at("scaling")) sizes.insert(row.at("triangles").get<std::size_t>());
    EXPECT_EQ(sizes, std::set<std::size_t>{2500});
}

TEST_F(CliBench, wrong_use_is_told) {
    expect_complaint(run({"bench", "x.ply", "--structures", "bvh2,octree"}), 2, "unknown accelerator 'octree'");
    write("blocks.json", blocks);
    expect_complaint(run({"bench"}), 2, "FILE is required");
    expect_complaint(run({"bench", at("blocks.json"), "--from", "1,2,3"}), 2, "--from needs --at");
    write("empty.json", R"({"version": 1})");
    expect_complaint(run({"bench", at("empty.json")}), 1, "there is nothing in it to render");
    expect_complaint(run({"bench", "--voxels", at("missing.vdb")}), 1, "missing.vdb");
}

}  // namespace
}  // namespace spinel::bench_test
