// What the program says when it cannot do what it was asked for: one line, the right exit code, and no
// picture.

#include <string>
#include <vector>

#include "cli/run_program.h"

namespace spinel::errors_test {
namespace {

constexpr int BAD_INPUT = 1, USAGE = 2;

class CliErrors : public ProgramTest {
  protected:
    // Renders a file of the given bytes; it must be refused and leave nothing.
    void expect_refused_file(const std::string& name, const std::string& bytes, const std::string& why) {
        SCOPED_TRACE(name + ": " + why);
        write(name, bytes);
        expect_refused({at(name)}, BAD_INPUT, why);
        std::filesystem::remove(folder / name);
    }
    void expect_refused(std::vector<std::string> arguments, int code, const std::string& why) {
        arguments.insert(arguments.begin(), "render");
        arguments.insert(arguments.end(), {"-o", at("picture.png")});
        const auto before = files();
        expect_complaint(run(arguments), code, why);
        EXPECT_EQ(files(), before);
    }
};

// A copy with the first `from` replaced.
std::string with(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST_F(CliErrors, a_harmed_scene_is_refused_and_says_where) {
    const std::string good = sphere_scene();
    const std::vector<std::pair<std::string, std::string>> harmed = {
        {with(good, "\"film\"", "\"flim\""), "scene.json:3:2: unknown key \"flim\""},
        {with(good, "\"color\"", "\"colour\""), "unknown key \"colour\""},
        {with(good, "\"diffuse\"", "\"velvet\""), "scene.json:6:34: unknown material type"},
        {with(good, "[24, 16]", "[0, 16]"), "scene.json:3:"},
        {with(good, "[24, 16]", "[24, -1]"), "scene.json:3:"},
        {with(good, "\"material\": \"matte\"", "\"material\": \"mat\""), "\"mat\""},
        {with(good, "\"material\"", "\"transform\": [{\"scale\": 0}], \"material\""), "scene.json:7:"},
        {with(good, "\"material\"", "\"transform\": [1,0,0,0, 0,1,0,0, 1,1,0,0], \"material\""), "scene.json:7:"},
        {with(good, "\"radius\": 1", "\"radius\": -1"), "scene.json:7:"},
        {with(good, "\"spp\": 4", "\"spp\": 0"), "scene.json:4:"},
        {with(good, "{\"type\": \"sphere\", \"radius\": 1}", "{\"type\": \"mesh\", \"file\": \"no.ply\"}"), "no.ply"},
        {with(good, "\"version\": 1", "\"version\": 2"), "scene.json:1:"},
        {with(good, "\"spp\": 4", "\"spp\": 4e"), "scene.json:4:"},
        {good.substr(0, good.size() / 2), "scene.json:"},
        {"[]", "scene.json:1:1"},
        {"", "scene.json:1:1"},
    };
    for (const auto& [text, why] : harmed) expect_refused_file("scene.json", text, why);
}

TEST_F(CliErrors, an_unknown_integrator_is_refused_wherever_it_is_named) {
    expect_refused_file("scene.json", with(sphere_scene(), "\"spp\": 4", "\"type\": \"bdpt\""), "'bdpt'");
    write("scene.json", sphere_scene());
    expect_refused({at("scene.json"), "--integrator", "bdpt"}, USAGE, "unknown integrator 'bdpt'; available: ");
}

TEST_F(CliErrors, what_a_scene_does_not_have_is_refused) {
    write("scene.json", sphere_scene());
    expect_refused({at("scene.json"), "--camera", "back"}, BAD_INPUT,
                   "no camera 'back': the scene's cameras have no names");
    write("named.json", with(sphere_scene(), R"("camera": {"from": [0, 0, 5], "at": [0, 0, 0], "fov": 30})",
                             R"("cameras": {"front": {"from": [0, 0, 5]}})"));
    expect_refused({at("named.json"), "--camera", "back"}, BAD_INPUT, "no camera 'back'; available: 'front'");
    expect_refused({at("scene.json"), "--crop", "20,0,25,4"}, BAD_INPUT, "24x16");
    expect_refused({at("scene.json"), "--check"}, BAD_INPUT, "\"expected\"");
}

// Every file of the data folder that its list calls negative.
TEST_F(CliErrors, real_files_that_are_damaged_or_foreign_are_refused) {
    std::ifstream list(data_folder / "MANIFEST.tsv");
    if (!list) GTEST_SKIP() << "no " << data_folder / "MANIFEST.tsv";
    std::size_t count = 0;
    for (std::string row; std::getline(list, row);) {
        if (row.find("NEGATIVE") == std::string::npos) continue;
        const std::string file = row.substr(0, row.find('\t')), path = (data_folder / file).string();
        SCOPED_TRACE(path);
        ++count;
        std::vector<std::string> arguments = {"info", path};
        if (file.ends_with(".exr")) arguments.insert(arguments.end(), {"--heightmap", "8"});  // as a picture
        expect_complaint(run(arguments), BAD_INPUT, std::filesystem::path(file).filename().string());
    }
    EXPECT_GE(count, 6u);
}

TEST_F(CliErrors, harmed_models_are_refused) {
    expect_refused_file("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "nan.obj");
    expect_refused_file(
        "nan.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n",
        "nan.ply");
    // An endless loop of Assimp's, if it were asked.
    expect_refused_file("cut.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n",
                        "its PLY header is damaged");
    expect_refused_file("odd.ply", "ply\nformat ascii 1.0\nelement vertex 3\nv 0 0 0\nend_header\n",
                        "its PLY header is damaged");
    const std::string vox =
        std::string("VOX ") + raw<int>(150) + "MAIN" + raw<int>(0) + raw<int>(1000) + "SIZE" + raw<int>(12);
    for (const std::size_t length : {std::size_t(0), std::size_t(3), std::size_t(6), std::size_t(14), vox.size()})
        expect_refused_file("cut.vox", vox.substr(0, length), "cut.vox");
    for (const std::string name :
         {"empty.obj", "empty.ply", "empty.stl", "empty.off", "empty.glb", "empty.gltf", "empty.svol", "empty.bits"})
        expect_refused_file(name, "", name);
    expect_refused_file("points.obj", "v 0 0 0\nv 1 0 0\n", "points.obj");
    expect_refused_file("picture.jpg", "not a model", "unknown extension '.jpg'");
    expect_refused_file("no_extension", "not a model", "unknown extension ''");
}

TEST_F(CliErrors, missing_files_and_folders_as_input_are_refused) {
    for (const std::string name : {"none.json", "none.vox", "none.ply", "none.obj", "none.glb", "none.svol"})
        expect_refused({at(name)}, BAD_INPUT, "there is no such file");
    for (const std::string name : {"folder.json", "folder.vox", "folder.ply", "folder.gltf", "folder"}) {
        std::filesystem::create_directory(folder / name);
        expect_refused({at(name)}, BAD_INPUT, name);
    }
}

TEST_F(CliErrors, an_output_that_cannot_be_written_is_refused_before_rendering) {
    write("scene.json", sphere_scene());
    write("plain", "");
    std::filesystem::create_directory(folder / "taken.png");
    const auto before = files();
    const auto expect = [&](const std::string& output, const std::string& why) {
        // So many samples that the test would run out of patience if it were noticed afterwards.
        expect_complaint(run({"render", at("scene.json"), "-o", output, "--spp", "1000000000"}), BAD_INPUT, why);
        EXPECT_EQ(files(), before);
    };
    expect(at("plain/picture.png"), "plain");
    expect("/proc/none/picture.png", "/proc/none");
    if (::geteuid() != 0) {  // the superuser may write anywhere
        std::filesystem::permissions(folder, std::filesystem::perms::owner_write,
                                     std::filesystem::perm_options::remove);
        expect(at("picture.png"), "Permission denied");
        std::filesystem::permissions(folder, std::filesystem::perms::owner_write, std::filesystem::perm_options::add);
    }
}

// Whatever the option: a value that is not one of the allowed ones is wrong usage, and the allowed ones are named.
TEST_F(CliErrors, a_value_that_is_none_of_the_allowed_ones_is_wrong_usage) {
    write("scene.json", sphere_scene());
    const std::string scene = at("scene.json");
    expect_refused({scene, "--device", "abacus"}, USAGE, "unknown device 'abacus'; available: cpu");
    expect_refused({scene, "--integrator", "bdpt"}, USAGE, "unknown integrator 'bdpt'; available: path");
    expect_refused({scene, "--tone-map", "sepia"}, USAGE, "unknown tone map 'sepia'; available: linear, aces, agx");
    expect_refused({scene, "--aov", "smell"}, USAGE, "smell");
    expect_complaint(run({"trace", scene, "--rays", at("r.npy"), "-o", at("h.npy"), "--accel", "abacus"}), USAGE,
                     "unknown accelerator 'abacus'; available: wide-bvh8, wide-bvh8-compact, bvh2");
    expect_refused({scene, "--accel", "abacus"}, USAGE, "unknown accelerator 'abacus'; available: wide-bvh8, ");
    expect_refused({scene, "--accel-preset", "faster"}, USAGE, "unknown preset 'faster'; available: fast, balanced");
    expect_refused({scene, "--accel", "bvh2", "--accel-preset", "fast"}, USAGE, "'bvh2' has no presets");
    expect_complaint(run({"trace", scene, "--rays", at("r.npy"), "-o", at("h.npy"), "--accel-preset", "faster"}), USAGE,
                     "unknown preset 'faster'; available: fast, balanced, high");
    expect_complaint(run({"list", "colours"}), USAGE, "materials");
    for (const std::string output : {"picture.bmp", "picture", "{name}.jpg"})
        expect_complaint(run({"render", scene, "-o", at(output)}), USAGE, "pictures are written as .png or .exr");
    EXPECT_EQ(files(), std::vector<std::string>{"scene.json"});
}

TEST_F(CliErrors, wrong_usage_exits_with_2) {
    write("scene.json", sphere_scene());
    const std::string scene = at("scene.json");
    for (const std::vector<std::string>& arguments :
         std::vector<std::vector<std::string>>{{scene, "--frobnicate"},
                                               {scene, "--size", "0x5"},
                                               {scene, "--size", "12"},
                                               {scene, "--size", "12x9x"},
                                               {scene, "--size", "-1x9"},
                                               {scene, "--size", "70000x9"},
                                               {scene, "--time", "0"},
                                               {scene, "--time", "-3s"},
                                               {scene, "--time", "5 parsecs"},
                                               {scene, "--time", "nan"},
                                               {scene, "--time", "inf"},
                                               {scene, "--spp", "0"},
                                               {scene, "--spp", "many"},
                                               {scene, "--noise", "0"},
                                               {scene, "--noise", "nan"},
                                               {scene, "--crop", "1,2,3"},
                                               {scene, "--crop", "5,5,5,9"},
                                               {scene, "--crop", "5,5,4,9"},
                                               {scene, "--crop", "-1,0,4,4"},
                                               {scene, "--threads", "-1"},
                                               {scene, "--seed", "-1"},
                                               {scene, "--exposure", "nan"},
                                               {scene, "--exposure", "bright"},
                                               {scene, scene},
                                               {}}) {
        SCOPED_TRACE(testing::PrintToString(arguments));
        expect_refused(arguments, USAGE, "");
    }
    expect_complaint(run({"render", scene}), USAGE, "--output is required");
    expect_complaint(run({}), USAGE, "available: render, info, list, trace, bench, compare, convert, generate");
    expect_complaint(run({"paint"}), USAGE, "unknown subcommand 'paint'");
    expect_complaint(run({"--frobnicate"}), USAGE, "");
    expect_complaint(run({"info"}), USAGE, "FILE");
    expect_complaint(run({"trace", scene}), USAGE, "required");
}

TEST_F(CliErrors, two_inputs_never_share_an_output) {
    std::filesystem::create_directories(folder / "a");
    std::filesystem::create_directories(folder / "b");
    write("a/same.json", sphere_scene());
    write("b/same.json", sphere_scene());
    expect_complaint(run({"render", at("a/same.json"), at("b/same.json"), "-o", at("out/")}), USAGE, "same.png");
    expect_complaint(run({"render", at("a/same.json"), at("b/same.json"), "-o", at("{name}.exr")}), USAGE, "same.exr");
    EXPECT_EQ(files(), (std::vector<std::string>{"a", "b"}));
}

}  // namespace
}  // namespace spinel::errors_test
