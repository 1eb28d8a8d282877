// What the program tells: help, version, `list` and `info`.

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "cli/run_program.h"

namespace spinel::inform_test {
namespace {

using Json = nlohmann::json;

class CliInform : public ProgramTest {};

TEST_F(CliInform, every_subcommand_has_an_example_in_its_help) {
    const Outcome all = run({"--help"});
    EXPECT_EQ(all.code, 0);
    EXPECT_EQ(all.err, "");
    for (const std::string name : {"render", "info", "list", "trace", "compare", "convert", "generate"}) {
        SCOPED_TRACE(name);
        EXPECT_NE(all.out.find("\n  " + name + " "), std::string::npos) << all.out;
        const Outcome help = run({name, "--help"});
        EXPECT_EQ(help.code, 0);
        EXPECT_EQ(help.err, "");
        EXPECT_NE(help.out.find("Examples:\n  spinel " + name + " "), std::string::npos) << help.out;
        EXPECT_EQ(run({name, "-h"}).out, help.out);
    }
}

TEST_F(CliInform, the_version_is_a_number) {
    const Outcome outcome = run({"--version"});
    EXPECT_EQ(outcome.code, 0);
    ASSERT_FALSE(outcome.out.empty());
    EXPECT_NE(outcome.out.find_first_of("0123456789"), std::string::npos) << outcome.out;
    EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 1);
}

TEST_F(CliInform, list_names_what_is_registered) {
    const std::vector<std::pair<std::string, std::string>> members = {{"accelerators", "brute-force"},
                                                                      {"aovs", "depth"},
                                                                      {"devices", "cpu"},
                                                                      {"formats", "vox"},
                                                                      {"integrators", "path"},
                                                                      {"materials", "metal"},
                                                                      {"sdf", "torus"},
                                                                      {"triangle-tests", "watertight"},
                                                                      {"worlds", "terrain"}};
    const Outcome everything = run({"list"});
    EXPECT_EQ(everything.code, 0);
    const Json all = Json::parse(run({"list", "--json"}).out);
    EXPECT_EQ(all.size(), members.size());
    for (const auto& [kind, member] : members) {
        SCOPED_TRACE(kind);
        EXPECT_NE(everything.out.find(kind + ":\n"), std::string::npos);
        const Outcome one = run({"list", kind});
        EXPECT_EQ(one.code, 0);
        EXPECT_EQ(one.err, "");
        EXPECT_TRUE(one.out.starts_with(member + " ") || one.out.find("\n" + member + " ") != std::string::npos)
            << one.out;
        const Json json = Json::parse(run({"list", kind, "--json"}).out);
        ASSERT_TRUE(json.contains(kind));
        EXPECT_EQ(json[kind], all[kind]);
        EXPECT_EQ(json[kind].size(), std::size_t(std::count(one.out.begin(), one.out.end(), '\n')));
        bool found = false;
        for (const Json& row : json[kind]) {
            found |= row["name"] == member;
            EXPECT_FALSE(row["doc"].get<std::string>().empty()) << row;
        }
        EXPECT_TRUE(found) << member;
    }
}

TEST_F(CliInform, info_tells_what_is_in_a_scene) {
    write("scene.json", sphere_scene());
    const Outcome text = run({"info", at("scene.json")});
    EXPECT_EQ(text.code, 0);
    EXPECT_EQ(text.err, "");
    for (const char* word : {"scene.json", "bounds", "objects     1", "sphere", "matte", "diffuse"})
        EXPECT_NE(text.out.find(word), std::string::npos) << word << " in\n" << text.out;
    const Outcome outcome = run({"info", at("scene.json"), "--json"});
    EXPECT_EQ(outcome.code, 0);
    const Json json = Json::parse(outcome.out);
    EXPECT_EQ(json["file"], at("scene.json"));
    EXPECT_EQ(json["objects"], 1);
    EXPECT_EQ(json["geometries"][0]["type"], "sphere");
    EXPECT_EQ(json["materials"][0]["name"], "matte");
    EXPECT_EQ(json["bounds"]["lower"], Json({-1, -1, -1}));
    EXPECT_EQ(json["bounds"]["upper"], Json({1, 1, 1}));
}

TEST_F(CliInform, info_tells_what_is_in_a_model_and_adds_nothing) {
    write("quad.obj", "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nf 1 2 3 4\n");
    const Json json = Json::parse(run({"info", at("quad.obj"), "--json"}).out);
    EXPECT_EQ(json["objects"], 1) << "no ground under it";
    EXPECT_EQ(json["geometries"][0]["triangles"], 2);
    EXPECT_EQ(json["cameras"].size(), 0u);
    EXPECT_EQ(json["lights"], 0);
    EXPECT_EQ(json["bounds"]["upper"], Json({2, 3, 0}));
}

TEST_F(CliInform, list_puts_the_descriptions_under_each_other) {
    for (const std::string kind : {"sdf", "accelerators", "materials"}) {
        const Json json = Json::parse(run({"list", kind, "--json"}).out);
        std::istringstream lines(run({"list", kind}).out);
        std::set<std::size_t> columns;
        std::string line;
        for (const Json& row : json[kind]) {
            ASSERT_TRUE(std::getline(lines, line));
            const std::string name = row["name"], doc = row["doc"];
            EXPECT_EQ(line.substr(0, name.size() + 2), name + "  ");
            columns.insert(line.size() - doc.size());
            EXPECT_TRUE(line.ends_with(doc)) << line;
        }
        EXPECT_EQ(columns.size(), 1u) << kind;
    }
}

TEST_F(CliInform, info_prints_numbers_as_they_were_written_and_says_what_has_no_name) {
    write("scene.json", R"({"version": 1, "camera": {}, "materials": {"m": {"type": "diffuse"}},
        "objects": [{"geometry": {"type": "sphere", "radius": 0.3}, "material": "m"}]})");
    const Outcome text = run({"info", at("scene.json")});
    EXPECT_EQ(text.code, 0) << text.err;
    EXPECT_NE(text.out.find("radius 0.3\n"), std::string::npos) << text.out;
    EXPECT_NE(text.out.find("cameras     1\n    (unnamed)\n"), std::string::npos) << text.out;
    const std::string json = run({"info", at("scene.json"), "--json"}).out;
    EXPECT_NE(json.find("\"radius\": 0.3\n"), std::string::npos) << json;
    EXPECT_EQ(Json::parse(json)["bounds"]["upper"], Json({0.3, 0.3, 0.3}));
}

TEST_F(CliInform, info_goes_on_after_a_bad_file) {
    write("scene.json", sphere_scene());
    const Outcome outcome = run({"info", at("none.vox"), at("scene.json")});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_TRUE(outcome.err.starts_with("spinel: ")) << outcome.err;
    EXPECT_NE(outcome.out.find("sphere"), std::string::npos);
}

TEST_F(CliInform, info_counts_the_voxels_of_an_artist) {
    const std::filesystem::path file = data_folder / "vox/ephtracy/chr_knight.vox";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not at hand";
    const Outcome outcome = run({"info", file.string(), "--json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const Json json = Json::parse(outcome.out);
    EXPECT_EQ(json["geometries"][0]["type"], "voxels");
    EXPECT_GT(json["geometries"][0]["voxels"].get<int>(), 100);
}

}  // namespace
}  // namespace spinel::inform_test
