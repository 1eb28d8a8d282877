// The published schema and reference page are those of the tables, and the scenes of the repository obey the
// schema. SPINEL_UPDATE_DOCS=1 rewrites the files.

#include "scene/json_schema.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "json_test.h"

namespace spinel::json_schema_test {
namespace {

const std::filesystem::path source = SPINEL_SOURCE_DIR;
const std::string begin_marker = "<!-- The tables below are generated: SPINEL_UPDATE_DOCS=1 tests_scene -->\n";
const std::string end_marker = "<!-- The end of the generated tables -->\n";

bool update() { return std::getenv("SPINEL_UPDATE_DOCS") != nullptr; }

std::string read(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

void write(const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

TEST(JsonSchema, committed_schema_is_that_of_the_tables) {
    const std::filesystem::path path = source / "docs/scene.schema.json";
    if (update()) write(path, scene_schema());
    EXPECT_EQ(read(path), scene_schema()) << "run with SPINEL_UPDATE_DOCS=1 and commit docs/scene.schema.json";
}

TEST(JsonSchema, committed_reference_page_is_that_of_the_tables) {
    const std::filesystem::path path = source / "docs/scene.md";
    std::string page = read(path);
    const std::size_t begin = page.find(begin_marker);
    const std::size_t end = page.find(end_marker);
    ASSERT_NE(begin, std::string::npos) << "the marker of the generated part is missing";
    ASSERT_NE(end, std::string::npos) << "the marker of the generated part's end is missing";
    const std::string before = page.substr(0, begin + begin_marker.size()), after = page.substr(end);
    const std::string wanted = before + "\n" + scene_reference() + after;
    if (update()) write(path, page = wanted);
    EXPECT_EQ(page, wanted) << "run with SPINEL_UPDATE_DOCS=1 and commit docs/scene.md";
}

TEST(JsonSchema, every_reference_leads_to_a_definition) {
    const auto schema = nlohmann::json::parse(scene_schema());
    const std::string text = schema.dump(), prefix = "\"#/definitions/";
    std::size_t count = 0;
    for (std::size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix, at + 1), ++count) {
        const std::size_t start = at + prefix.size();
        const std::string name = text.substr(start, text.find('"', start) - start);
        EXPECT_TRUE(schema["definitions"].contains(name)) << name;
    }
    EXPECT_GT(count, 20u);
}

// Runs `python3 -c code arguments…`; its exit code.
int python(const std::string& code, const std::string& arguments) {
    const int status = std::system(("python3 -c '" + code + "' " + arguments).c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Scene files of the repository.
std::vector<std::filesystem::path> scene_files() {
    std::vector<std::filesystem::path> files;
    for (const char* folder : {"examples", "tests/scenes", "bench/scenes"}) {
        if (!std::filesystem::is_directory(source / folder)) continue;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(source / folder))
            if (entry.path().extension() == ".json") files.push_back(entry.path());
    }
    return files;
}

std::string file_list(const std::vector<std::filesystem::path>& files) {
    std::string list;
    for (const auto& file : files) list += " '" + file.string() + "'";
    return list;
}

// Its exit code is the number of files that disobey the schema; comments (// to the end of a line) are taken
// out first.
const char* const validator = R"(
import json, re, sys, jsonschema
schema = json.load(open(sys.argv[1]))
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
wrong = 0
for path in sys.argv[2:]:
    text = re.sub(r"(\"(?:[^\"\\\\]|\\\\.)*\")|//[^\n]*", lambda m: m.group(1) or "", open(path).read())
    errors = list(validator.iter_errors(json.loads(text)))
    for error in errors:
        print(path, list(error.absolute_path), error.message[:300])
    wrong += bool(errors)
sys.exit(wrong)
)";

bool jsonschema_installed() { return python("import jsonschema", "2>/dev/null") == 0; }

int disobedient(const std::vector<std::filesystem::path>& files, const std::string& more = "") {
    return python(validator, (source / "docs/scene.schema.json").string() + file_list(files) + more);
}

// The ```json blocks of the reference page.
std::vector<std::string> examples() {
    const std::string page = read(source / "docs/scene.md"), opening = "```json\n";
    std::vector<std::string> texts;
    for (std::size_t at = page.find(opening); at != std::string::npos; at = page.find(opening, at + 1)) {
        const std::size_t start = at + opening.size();
        texts.push_back(page.substr(start, page.find("```", start) - start));
    }
    return texts;
}

std::vector<std::filesystem::path> temporary_files(const std::vector<std::string>& texts) {
    const std::string folder = testing::TempDir();
    std::vector<std::filesystem::path> files;
    for (const std::string& text : texts) {
        files.push_back(folder + "spinel_schema_test_" + std::to_string(files.size()) + ".json");
        write(files.back(), text);
    }
    return files;
}

TEST(JsonSchema, scenes_of_the_repository_obey_it) {
    if (!jsonschema_installed()) GTEST_SKIP() << "python3-jsonschema is not installed";
    EXPECT_EQ(disobedient(scene_files()), 0);
}

TEST(JsonSchema, examples_of_the_reference_page_are_right) {
    const std::vector<std::string> texts = examples();
    ASSERT_GE(texts.size(), 2u);
    for (const std::string& text : texts) test::scene_of(text);
    if (!jsonschema_installed()) GTEST_SKIP() << "python3-jsonschema is not installed";
    EXPECT_EQ(disobedient(temporary_files(texts)), 0);
}

TEST(JsonSchema, what_the_reader_refuses_by_its_tables_disobeys_the_schema) {
    if (!jsonschema_installed()) GTEST_SKIP() << "python3-jsonschema is not installed";
    const std::vector<std::string> right = {
        R"({"version": 1, "camera": {"from": [0, 1, 2]}, "film": {"size": [1, 2]}})",
        R"({"version": 1, "textures": {"t": {"type": "checker"}}, "materials": {"m": {"type": "diffuse", "color": "t"}}})",
        R"({"version": 1, "textures": {"t": {"type": "checker"}},
            "materials": {"m": {"type": "diffuse", "color": {"texture": "t", "factor": [0, 1, 0]}}}})",
    };
    const std::vector<std::string> wrong = {
        R"({})",
        R"({"version": 2})",
        R"({"version": 1, "colour": 1})",
        R"({"version": 1, "camera": {"fov": 180}})",
        R"({"version": 1, "film": {"size": [1, 0]}})",
        R"({"version": 1, "camera": {}, "cameras": {}})",
        R"({"version": 1, "materials": {"m": {"type": "gals"}}})",
        R"({"version": 1, "materials": {"m": {"type": "metal", "roughnes": 1}}})",
        R"({"version": 1, "materials": {"m": {"type": "metal", "preset": "wood"}}})",
        R"({"version": 1, "media": {"m": {"g": 1}}})",
        R"({"version": 1, "objects": [{}]})",
        R"({"version": 1, "objects": [{"geometry": {"type": "sphere"}, "material": null, "transform": [{"spin": 1}]}]})",
        R"({"version": 1, "geometries": {"g": {"type": "sdf", "expression": {"op": "sphere"}}}})",
        R"({"version": 1, "geometries": {"g": {"type": "voxels", "layers": [["#"]]}}})",
    };
    for (const std::string& text : right) test::scene_of(text);
    for (const std::string& text : wrong) EXPECT_FALSE(test::read(text)) << text;
    EXPECT_EQ(disobedient(temporary_files(right)), 0);
    EXPECT_EQ(disobedient(temporary_files(wrong), " >/dev/null"), int(wrong.size()));
}

}  // namespace
}  // namespace spinel::json_schema_test
