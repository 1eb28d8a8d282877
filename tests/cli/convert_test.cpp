// `spinel convert` and `spinel generate`.

#include <nlohmann/json.hpp>

#include "cli/run_program.h"

namespace spinel::convert_test {
namespace {

constexpr int BAD_INPUT = 1, USAGE = 2;
using Json = nlohmann::json;

class CliConvert : public ProgramTest {
  protected:
    // Square of edge 2 in the plane z = 0, as two triangles.
    void write_square() { write("square.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n"); }
    Json converted(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "convert");
        arguments.push_back("--json");
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome.code == 0 ? Json::parse(outcome.out) : Json();
    }
};

TEST_F(CliConvert, a_mesh_becomes_voxels_and_these_a_mesh) {
    write_square();
    const Json voxels = converted({at("square.obj"), "-o", at("square.vdb"), "--voxels", "10"});
    EXPECT_EQ(voxels["voxels"], 100);
    EXPECT_EQ(voxels["size"], Json({10, 10, 1}));
    for (const std::string extension : {".obj", ".ply"}) {
        const Json mesh = converted({at("square.vdb"), "-o", at("back" + extension)});
        EXPECT_EQ(mesh["triangles"], 12);
        const Outcome info = run({"info", at("back" + extension), "--json"});
        ASSERT_EQ(info.code, 0) << info.err;
        const Json bounds = Json::parse(info.out)["bounds"];
        EXPECT_NEAR(bounds["lower"][0].get<double>(), -1, 1e-5);
        EXPECT_NEAR(bounds["upper"][1].get<double>(), 1, 1e-5);
        EXPECT_NEAR(bounds["upper"][2].get<double>() - bounds["lower"][2].get<double>(), 0.2, 1e-5);
    }
}

TEST_F(CliConvert, an_implicit_sphere_has_its_volume) {
    write("scene.json", sphere_scene());
    const Json json = converted({at("scene.json"), "-o", at("ball.vdb"), "--voxels", "64"});
    EXPECT_NEAR(json["voxels"].get<double>(), 4.0 / 3 * 3.14159265 * 32 * 32 * 32, 0.01 * 137000);
}

TEST_F(CliConvert, an_infinite_plane_is_left_out_and_that_is_said) {
    write("plane.json", sphere_scene().replace(sphere_scene().rfind("]}"), 2,
                                               R"(, {"geometry": {"type": "plane"}, "material": "matte"}]})"));
    const Outcome outcome = run({"convert", at("plane.json"), "-o", at("ball.vdb"), "--voxels", "32"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("infinite planes left out: 1"), std::string::npos) << outcome.err;
}

TEST_F(CliConvert, what_cannot_be_done_is_refused_with_one_line_and_no_file) {
    write_square();
    write("scene.json", sphere_scene());
    const auto before = files();
    const auto expect = [&](std::vector<std::string> arguments, int code, const std::string& why) {
        SCOPED_TRACE(testing::PrintToString(arguments));
        expect_complaint(run(arguments), code, why);
        EXPECT_EQ(files(), before);
    };
    const std::string square = at("square.obj"), out = at("out.vdb");
    expect({"convert", square, "-o", out}, BAD_INPUT, "--voxels N is needed");
    expect({"convert", square, "-o", out, "--voxels", "0"}, USAGE, "--voxels");
    expect({"convert", square, "-o", out, "--voxels", "99999999"}, USAGE, "--voxels");
    expect({"convert", square, "-o", out, "--voxels", "8", "--solid", "--surface"}, USAGE, "--s");
    expect({"convert", square, "-o", out, "--voxels", "8", "--threshold", "nan"}, USAGE, "--threshold");
    expect({"convert", square, "-o", out, "--voxels", "8", "--colors", "70000"}, USAGE, "--colors");
    expect({"convert", square, "-o", at("out.stl")}, USAGE, "models are written as .vox");
    expect({"convert", square}, USAGE, "--output is required");
    expect({"convert", at("none.obj"), "-o", out, "--voxels", "8"}, BAD_INPUT, "there is no such file");
    expect({"convert", at("scene.json"), "-o", at("out.obj")}, BAD_INPUT, "convert it to a file of voxels first");
    expect({"generate", "moon", "-o", out}, USAGE, "unknown world 'moon'; available: terrain, landscape, city, menger");
    expect({"generate", "menger", "-o", at("out.ply")}, USAGE, "voxels are written as .vox, .vdb");
    for (const std::string size : {"0x4x4", "4x4", "4x4x4x", "-1x2x3", "4x4x2000000", "many"})
        expect({"generate", "menger", "-o", out, "--size", size}, USAGE, "--size");
    expect({"generate", "terrain", "-o", out, "--size", "1000000x4x1000000"}, USAGE, "too large");
    expect({"generate", "menger", "-o", out, "--seed", "3"}, USAGE, "has no seed");
    expect({"generate", "city", "-o", out, "--size", "64x8x64"}, USAGE, "at least 32");
    expect({"generate", "menger"}, USAGE, "--output is required");
}

TEST_F(CliConvert, every_world_is_made_and_the_same_seed_makes_the_same) {
    for (const std::string world : {"terrain", "landscape", "city", "menger"}) {
        SCOPED_TRACE(world);
        for (const std::string name : {"a.vdb", "b.vdb"}) {
            const Outcome outcome = run({"generate", world, "-o", at(name), "--size", "80x64x70", "--json"});
            ASSERT_EQ(outcome.code, 0) << outcome.err;
            const Json json = Json::parse(outcome.out);
            EXPECT_EQ(json["size"], Json({80, 64, 70}));
            EXPECT_GT(json["voxels"], 10000);
        }
        EXPECT_EQ(Json::parse(run({"info", at("a.vdb"), "--json"}).out)["geometries"],
                  Json::parse(run({"info", at("b.vdb"), "--json"}).out)["geometries"]);
        const Outcome rendered =
            run({"render", "--voxels", at("a.vdb"), "-o", at("a.png"), "--size", "32x24", "--spp", "1", "--quiet"});
        EXPECT_EQ(rendered.code, 0) << rendered.err;
    }
}

// Menger's sponge of level n has 20ⁿ cubes.
TEST_F(CliConvert, a_sponge_has_20_to_the_n_voxels) {
    const Outcome outcome = run({"generate", "menger", "-o", at("m.vdb"), "--size", "81x81x81", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(Json::parse(outcome.out)["voxels"], 160000);
}

}  // namespace
}  // namespace spinel::convert_test
