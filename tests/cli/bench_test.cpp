// `spinel bench`: structures side by side on the same rays, which all see the same.

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "cli/run_program.h"

namespace spinel {
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
    std::set<std::string> rays, structures;
    const nlohmann::json result = nlohmann::json::parse(outcome.out);
    for (const auto& row : result.at("rows")) {
        rays.insert(row.at("subject").get<std::string>() + " " + row.at("rays").get<std::string>());
        const std::string structure = row.at("structure");
        structures.insert(structure);
        EXPECT_GT(row.at("mrays_per_s").get<double>(), 0) << row;
        EXPECT_GT(row.at("bytes").get<double>(), 0) << row;
        // NanoVDB's steps accumulate rounding: it may see another voxel, which is not ours to mend.
        if (structure != "nanovdb-leaf-mask") { EXPECT_EQ(row.at("differing").get<double>(), 0) << row; }
    }
    EXPECT_EQ(rays, (std::set<std::string>{"scene primary", "scene diffuse", "scene shadow", "voxels primary",
                                           "voxels diffuse"}));
    for (const char* name : {"wide-bvh8", "wide-bvh8, 8 rays", "64-tree", "64-tree, packets", "64-tree, stream",
                             "64-tree, one ray", "64-tree, kernel", "dense 3D-DDA"})
        EXPECT_TRUE(structures.contains(name)) << name;
}

TEST_F(CliBench, wrong_use_is_told) {
    write("blocks.json", blocks);
    expect_complaint(run({"bench"}), 2, "FILE is required");
    expect_complaint(run({"bench", at("blocks.json"), "--from", "1,2,3"}), 2, "--from needs --at");
    write("empty.json", R"({"version": 1})");
    expect_complaint(run({"bench", at("empty.json")}), 1, "there is nothing in it to render");
    expect_complaint(run({"bench", "--voxels", at("missing.vdb")}), 1, "missing.vdb");
}

}  // namespace
}  // namespace spinel
