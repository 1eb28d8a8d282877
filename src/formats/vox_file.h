#pragma once
// What a MagicaVoxel file (.vox, versions 150 and 200) says, chunk by chunk, in the file's own coordinates (z
// up). Layout: github.com/ephtracy/voxel-model, MagicaVoxel-file-format-vox.txt and …-vox-extension.txt.

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "spinel/scene.h"

namespace spinel::vox {

struct Model {
    ivec3 size = {0, 0, 0};
    std::string_view voxels;  // four bytes each: x, y, z, palette index; inside size, checked
};

struct Node {
    enum class Kind { transform, group, shape };
    Kind kind = Kind::group;
    std::string name;
    bool hidden = false;
    std::size_t offset = 0;     // of its chunk in the file, for messages
    std::vector<int> children;  // nodes; of a shape: the model of the frame that was asked for
    int layer = -1;             // of a transform
    mat3 rotation = mat3(1);    // a signed permutation, of a transform, in that frame
    vec3 translation = {0, 0, 0};
};

using Dictionary = std::map<std::string, std::string>;

// Palette index `i` has color[i] and properties[i]; index 0 is empty space. IMAP is not kept: it only says in which
// order the program shows the palette, voxels and materials keep their indices.
struct File {
    std::string bytes;  // that the views look into
    std::vector<Model> models;
    std::map<int, Node> nodes;  // empty: a file without a scene graph
    std::set<int> hidden_layers;
    std::array<std::array<std::uint8_t, 4>, 256> palette;
    std::map<int, Dictionary> properties;        // "_type" → "_metal", "_rough" → "0.1" …
    std::map<std::string, Dictionary> settings;  // rOBJ by "_type": "_inf" (the sun), "_uni" (the sky), "_ground" …
    std::vector<Dictionary> cameras;             // rCAM
    int frame_count = 1;                         // of the animation
};

// The palette of files that hold none: the web colours in steps of 0x33 without black, then ramps of red,
// green, blue and grey.
std::array<std::array<std::uint8_t, 4>, 256> default_palette();

// As the file is in `frame` of its animation. A key holds until the next one; without a scene graph frames are models.
Result<File> read(const std::filesystem::path& path, int frame = 0);

std::string word(const Dictionary& dictionary, const std::string& key);  // empty: absent
// What is no number, or not finite, counts as absent: files of many writers hold such.
float number(const Dictionary& dictionary, const std::string& key, float otherwise);
// Numbers separated by spaces; absent unless there are three.
std::optional<vec3> triple(const Dictionary& dictionary, const std::string& key);

}  // namespace spinel::vox
