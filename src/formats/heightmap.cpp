#include "formats/heightmap.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "formats/file_bytes.h"
#include "formats/inflate.h"
#include "formats/voxel_geometry.h"
#include "image/image_io.h"
#include "image/tone_map.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel {
namespace {

constexpr std::uintmax_t MAX_HEIGHTMAP_FILE = std::uintmax_t(1) << 28;
constexpr int MAX_HEIGHTMAP_EDGE = 1 << 14;
constexpr float MAX_HEIGHT = 65536;  // voxels
constexpr float METRES_PER_DEGREE = 111320;
constexpr int VOID = -32768;

struct Heights {
    int width = 0, depth = 0;
    std::vector<float> values;  // rows from the north; whatever unit
    float at(int x, int z) const {
        x = std::clamp(x, 0, width - 1);
        z = std::clamp(z, 0, depth - 1);
        return values[std::size_t(z) * std::size_t(width) + std::size_t(x)];
    }
};

struct Ground {
    const char* name;
    std::uint32_t rgb;
    float top;  // fraction of the relief
};
constexpr Ground GROUNDS[] = {{"sand", 0xcdbf95, 0.02f},
                              {"grass", 0x6d8a45, 0.3f},
                              {"forest", 0x48673a, 0.62f},
                              {"rock", 0x8a857c, 0.85f},
                              {"snow", 0xf2f5f7, 2.0f}};
constexpr int ROCK = 3;
constexpr float STEEP = 1.0f;  // rise over run from which on nothing but rock holds

// `scale` of the heights gives voxels; `slope` is how steep the land is for a step of one voxel to the next column.
Result<Scene> terrain(const std::string& name, const Heights& heights, float scale, float slope, mat4x3 transform) {
    const auto [low, high] = std::minmax_element(heights.values.begin(), heights.values.end());
    const float lowest = *low, relief = std::max(*high - *low, 1e-6f);
    const auto top_of = [&](int x, int z) { return 1 + int(std::lround((heights.at(x, z) - lowest) * scale)); };
    const ivec3 size(heights.width, 1 + int(std::lround(relief * scale)), heights.depth);
    std::vector<VoxelPoint> points;
    for (int z = 0; z < heights.depth; ++z)
        for (int x = 0; x < heights.width; ++x) {
            const int top = top_of(x, z);
            const int sides[4] = {top_of(x - 1, z), top_of(x + 1, z), top_of(x, z - 1), top_of(x, z + 1)};
            const int lowest_side = *std::min_element(sides, sides + 4);
            const bool border = x == 0 || z == 0 || x == heights.width - 1 || z == heights.depth - 1;
            const int steps = std::max(*std::max_element(sides, sides + 4) - top, top - lowest_side);
            const float fraction = (heights.at(x, z) - lowest) / relief;
            int ground = 0;
            while (fraction > GROUNDS[ground].top) ++ground;
            if (float(steps) * slope > STEEP && steps > 1) ground = ROCK;
            for (int y = border ? 0 : std::min(lowest_side, top - 1); y < top; ++y)
                points.push_back({{x, y, z}, std::uint16_t((y == top - 1 ? ground : ROCK) + 1)});
            if (points.size() > MAX_VOXELS) return Error{"its terrain has more voxels than allowed"};
        }
    Scene scene;
    Object object;
    object.name = name;
    object.geometry = 0;
    object.transform = transform;
    for (const Ground& ground : GROUNDS) {
        kernels::Material material = default_material(kernels::MATERIAL_DIFFUSE);
        for (int c = 0; c < 3; ++c) material.color[c] = srgb_decoded(float(ground.rgb >> (16 - 8 * c) & 255) / 255.0f);
        object.materials.push_back(int(scene.materials.size()));
        scene.materials.push_back({ground.name, material});
    }
    Result<Geometry> geometry = voxel_geometry(name, size, std::move(points));
    if (!geometry) return geometry.error();
    scene.geometries.push_back(std::move(*geometry));
    scene.objects.push_back(std::move(object));
    return scene;
}

// The southern edge of a tile in degrees, from a name such as N44W072.hgt.
std::optional<float> latitude_of(const std::string& name) {
    int degrees = 0;
    char hemisphere = 0;
    if (std::sscanf(name.c_str(), "%c%2d", &hemisphere, &degrees) != 2) return std::nullopt;
    if (hemisphere == 'N' || hemisphere == 'n') return float(degrees);
    if (hemisphere == 'S' || hemisphere == 's') return float(-degrees);
    return std::nullopt;
}

}  // namespace

Result<Scene> load_hgt(const std::filesystem::path& path, const LoadOptions& options) {
    Result<std::string> bytes = read_file_bytes(path, MAX_HEIGHTMAP_FILE);
    if (!bytes) return bytes.error();
    if (path.extension() == ".gz") {
        bytes = inflated(*bytes, MAX_HEIGHTMAP_FILE);
        if (!bytes) return cannot_read(path, bytes.error().message);
    }
    const std::size_t count = bytes->size() / 2;
    const auto edge = std::size_t(std::lround(std::sqrt(double(count))));
    if (edge < 2 || edge * edge * 2 != bytes->size())
        return cannot_read(path, "its " + std::to_string(bytes->size()) + " bytes are not a square of 16-bit heights");
    Heights heights{int(edge), int(edge), {}};
    heights.values.resize(edge * edge);
    float lowest = 1e6f;
    std::size_t voids = 0;
    for (std::size_t i = 0; i < heights.values.size(); ++i) {
        const int value =
            std::int16_t(std::uint16_t(std::uint8_t((*bytes)[2 * i]) << 8 | std::uint8_t((*bytes)[2 * i + 1])));
        heights.values[i] = float(value);
        if (value == VOID) ++voids;
        else lowest = std::min(lowest, float(value));
    }
    if (voids == heights.values.size()) return cannot_read(path, "all of its heights are void");
    for (float& value : heights.values)
        if (value == float(VOID)) value = lowest;
    const float relief = std::max(*std::max_element(heights.values.begin(), heights.values.end()) - lowest, 1.0f);

    const std::string name = path.filename().string();
    const std::optional<float> latitude = latitude_of(name);
    const float south = METRES_PER_DEGREE / float(edge - 1);
    const float east = south * std::cos(glm::radians(std::clamp(latitude.value_or(0.0f) + 0.5f, -89.0f, 89.0f)));
    // Metres a voxel. The lowest column is a voxel high, so that the highest rises by one less.
    const float up = options.heightmap ? relief / std::max(*options.heightmap - 1.0f, 1e-3f) : south / 8;
    // Asked for so many voxels the terrain is drawn steeper than it is: of cubes.
    const float height = options.heightmap ? south : up;
    const mat4x3 transform(vec3(east, 0, 0), vec3(0, height, 0), vec3(0, 0, south),
                           vec3(0, options.heightmap ? 0.0f : lowest, 0));
    Result<Scene> scene = terrain(name.substr(0, name.find('.')), heights, 1.0f / up, up / south, transform);
    if (!scene) return cannot_read(path, scene.error().message);
    if (voids > 0)
        scene->notes.push_back(std::to_string(voids) + " of its heights are void and lie as low as the lowest");
    if (!latitude)
        scene->notes.emplace_back("its name gives no latitude (as N44W072 does): it is as wide as on the equator");
    return scene;
}

Result<Scene> load_heightmap(const std::filesystem::path& path, const LoadOptions& options) {
    if (!options.heightmap)
        return cannot_read(path,
                           "it is a picture; as a heightmap it needs a height in voxels (--heightmap, or \"height\" of "
                           "voxels in a scene file)");
    const Result<Image> image = read_image(path);
    if (!image) return image.error();
    if (image->width > MAX_HEIGHTMAP_EDGE || image->height > MAX_HEIGHTMAP_EDGE)
        return cannot_read(path, "a heightmap may have " + std::to_string(MAX_HEIGHTMAP_EDGE) +
                                     " pixels along an edge, it has " +
                                     std::to_string(std::max(image->width, image->height)));
    Heights heights{image->width, image->height, {}};
    const int colors = image->channels >= 3 ? 3 : 1;
    for (int z = 0; z < image->height; ++z)
        for (int x = 0; x < image->width; ++x) {
            float sum = 0;
            for (int c = 0; c < colors; ++c) sum += image->at(x, z)[c];
            const float value = sum / float(colors);
            if (!std::isfinite(value) || std::abs(value) * *options.heightmap > MAX_HEIGHT)
                return cannot_read(path, "pixel (" + std::to_string(x) + ", " + std::to_string(z) +
                                             ") is not finite, or higher than the " + std::to_string(int(MAX_HEIGHT)) +
                                             " voxels allowed");
            heights.values.push_back(value);
        }
    Result<Scene> scene = terrain(path.stem().string(), heights, *options.heightmap - 1.0f, 1.0f, mat4x3(1));
    if (!scene) return cannot_read(path, scene.error().message);
    return scene;
}

}  // namespace spinel
