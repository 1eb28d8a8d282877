#pragma once
// What the tests of the .vox reader and writer share: the chunks of a file, written one by one, and where the voxels
// of a scene stand.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/result.h"
#include "spinel/scene.h"
#include "test_files.h"

namespace spinel {

using Dictionary = std::map<std::string, std::string>;

// Writes the chunks of a .vox file.
inline std::string number(std::int32_t value) { return raw(value); }
inline std::string text(const std::string& s) { return number(int(s.size())) + s; }
inline std::string dictionary(const Dictionary& d) {
    std::string bytes = number(int(d.size()));
    for (const auto& [key, value] : d) bytes += text(key) + text(value);
    return bytes;
}
inline std::string chunk(const std::string& id, const std::string& content) {
    return id + number(int(content.size())) + number(0) + content;
}
inline std::string file_of(const std::string& chunks, int version = 150) {
    return "VOX " + number(version) + "MAIN" + number(0) + number(int(chunks.size())) + chunks;
}
struct Voxel {
    int x, y, z, index;
};
inline std::string model(ivec3 size, const std::vector<Voxel>& voxels) {
    std::string content = number(int(voxels.size()));
    for (const Voxel& v : voxels) content += {char(v.x), char(v.y), char(v.z), char(v.index)};
    return chunk("SIZE", number(size.x) + number(size.y) + number(size.z)) + chunk("XYZI", content);
}
inline std::string transform(int id, int child, const Dictionary& frame = {}, const Dictionary& attributes = {},
                             int layer = -1) {
    return chunk("nTRN", number(id) + dictionary(attributes) + number(child) + number(-1) + number(layer) + number(1) +
                             dictionary(frame));
}
inline std::string group(int id, const std::vector<int>& children) {
    std::string content = number(id) + dictionary({}) + number(int(children.size()));
    for (const int child : children) content += number(child);
    return chunk("nGRP", content);
}
inline std::string shape(int id, int model_index) {
    return chunk("nSHP", number(id) + dictionary({}) + number(1) + number(model_index) + dictionary({}));
}
inline std::string material(int index, const Dictionary& properties) {
    return chunk("MATL", number(index) + dictionary(properties));
}

using Centers = std::vector<std::array<int, 3>>;

// World positions of the centres of an object's voxels, sorted; doubled, so that they are whole numbers.
inline Centers centers(const Scene& scene, const Object& object) {
    const auto& voxels = std::get<VoxelGeometry>(scene.geometries[std::size_t(object.geometry)].data);
    Centers result;
    voxels.tree->for_each([&](ivec3 cell, std::uint16_t) {
        const vec3 p = object.transform * vec4(vec3(cell) + 0.5f, 1.0f);
        result.push_back({int(std::round(2 * p.x)), int(std::round(2 * p.y)), int(std::round(2 * p.z))});
    });
    std::sort(result.begin(), result.end());
    return result;
}

}  // namespace spinel
