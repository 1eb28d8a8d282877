#include "formats/colored_voxels.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <unordered_map>

#include "formats/byte_reader.h"
#include "formats/file_bytes.h"
#include "formats/voxel_geometry.h"
#include "image/tone_map.h"
#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel {
namespace {

constexpr std::uintmax_t MAX_VOXELS_FILE = std::uintmax_t(1) << 30;
constexpr int MAX_VOXELS_EDGE = 4096;
constexpr std::size_t MAX_PALETTE = 65535;
constexpr std::uint64_t MAX_VOXELS_CELLS = std::uint64_t(1) << 31;  // of packed files, whose length tells little

using Complaint = std::optional<std::string>;

bool edges_fit(ivec3 size) {
    for (int axis = 0; axis < 3; ++axis)
        if (size[axis] < 1 || size[axis] > MAX_VOXELS_EDGE) return false;
    return std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(size.z) <= MAX_VOXELS_CELLS;
}

// Collects sets of coloured voxels into a scene.
class ColoredScene {
  public:
    // The palette index of a colour; 0: there are too many.
    std::uint16_t color(std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
        const std::uint32_t rgb = std::uint32_t(red) << 16 | std::uint32_t(green) << 8 | blue;
        const auto [found, is_new] = indices_.emplace(rgb, std::uint16_t(scene_.materials.size() + 1));
        if (!is_new) return found->second;
        if (scene_.materials.size() >= MAX_PALETTE) return 0;
        kernels::Material material = default_material(kernels::MATERIAL_DIFFUSE);
        const std::uint8_t bytes[] = {red, green, blue};
        for (int c = 0; c < 3; ++c) material.color[c] = srgb_decoded(float(bytes[c]) / 255.0f);
        scene_.materials.push_back({"color " + std::to_string(rgb), material});
        return found->second;
    }
    std::size_t count = 0;  // voxels in all

    Complaint add(std::string name, ivec3 size, std::vector<VoxelPoint> points, ivec3 place) {
        if (points.empty()) return {};
        Result<Geometry> geometry = voxel_geometry(name, size, std::move(points));
        if (!geometry) return geometry.error().message;
        Object object;
        object.name = std::move(name);
        object.geometry = int(scene_.geometries.size());
        object.transform[3] = vec3(place);
        scene_.geometries.push_back(std::move(*geometry));
        scene_.objects.push_back(std::move(object));
        return {};
    }

    Result<Scene> finish(const std::filesystem::path& path, const Complaint& complaint) {
        if (complaint) return cannot_read(path, *complaint);
        if (scene_.objects.empty()) return cannot_read(path, "it holds no visible voxel");
        std::vector<int> slots(scene_.materials.size());
        for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = int(i);
        for (Object& object : scene_.objects) object.materials = slots;
        return std::move(scene_);
    }

  private:
    Scene scene_;
    std::unordered_map<std::uint32_t, std::uint16_t> indices_;
};

// Layout: getqubicle.com, "Qubicle Binary".
class Qubicle {
  public:
    Qubicle(std::string_view bytes, ColoredScene& scene) : reader_(bytes), scene_(scene) {}

    Complaint read() {
        const std::uint32_t version = reader_.u32();
        bgra_ = reader_.u32() == 1;
        right_handed_ = reader_.u32() == 1;
        packed_ = reader_.u32() == 1;
        reader_.u32();  // what alpha says besides seen or not
        const std::uint32_t matrix_count = reader_.u32();
        if (!reader_.ok() || version != 0x101) return "it is not a Qubicle file of version 1.1";
        for (std::uint32_t i = 0; i < matrix_count; ++i)
            if (Complaint complaint = read_matrix()) return "matrix " + std::to_string(i) + ": " + *complaint;
        return {};
    }

  private:
    Complaint read_matrix() {
        const std::string name(reader_.take(reader_.u8()));
        ivec3 size, place;
        for (int axis = 0; axis < 3; ++axis) size[axis] = reader_.i32();
        for (int axis = 0; axis < 3; ++axis) place[axis] = reader_.i32();
        if (!reader_.ok()) return "the file ends in its head";
        if (!edges_fit(size)) return "its size is none, or larger than allowed";
        for (int axis = 0; axis < 3; ++axis)
            if (std::abs(std::int64_t(place[axis])) > (1 << 24)) return "it stands too far away";
        const std::size_t cells = std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
        if (!packed_ && reader_.remaining() / 4 < cells) return "its size needs more bytes than the file has";
        std::vector<VoxelPoint> points;
        const auto layer = std::uint32_t(size.x) * std::uint32_t(size.y);
        for (int z = 0; z < size.z; ++z) {
            // Files of a left-handed space point away with z.
            const int ours = right_handed_ ? z : size.z - 1 - z;
            std::uint32_t at = 0;
            while (packed_ || at < layer) {
                constexpr std::uint32_t CODE = 2, NEXT_LAYER = 6;
                std::uint32_t color = reader_.u32(), repeat = 1;
                if (packed_ && color == NEXT_LAYER) break;
                if (packed_ && color == CODE) {
                    repeat = reader_.u32();
                    color = reader_.u32();
                }
                if (!reader_.ok()) return "the file ends in its voxels";
                if (repeat > layer - at) return "a run of voxels is longer than its layer";
                if (Complaint complaint = add_run(points, size, ours, at, repeat, color)) return complaint;
                at += repeat;
            }
        }
        if (!right_handed_) place.z = -place.z - size.z;
        return scene_.add(name.empty() ? "matrix" : name, size, std::move(points), place);
    }

    Complaint add_run(std::vector<VoxelPoint>& points, ivec3 size, int z, std::uint32_t at, std::uint32_t count,
                      std::uint32_t color) {
        if (color >> 24 == 0) return {};  // not seen
        const auto low = std::uint8_t(color), middle = std::uint8_t(color >> 8), high = std::uint8_t(color >> 16);
        const std::uint16_t index = bgra_ ? scene_.color(high, middle, low) : scene_.color(low, middle, high);
        if (!index) return "it has more colours than a palette";
        scene_.count += count;
        if (scene_.count > MAX_VOXELS) return "it has more voxels than allowed";
        for (std::uint32_t i = at; i < at + count; ++i)
            points.push_back({{int(i % std::uint32_t(size.x)), int(i / std::uint32_t(size.x)), z}, index});
        return {};
    }

    ByteReader reader_;
    ColoredScene& scene_;
    bool bgra_ = false, right_handed_ = false, packed_ = false;
};

// Layout: Ken Silverman's slab6.txt. x east, y south, z down.
Complaint read_kv6(std::string_view bytes, ColoredScene& scene, const std::string& name) {
    ByteReader reader(bytes);
    if (reader.take(4) != "Kvxl") return "it is not a KV6 file (it does not begin with 'Kvxl')";
    ivec3 size;
    for (int axis = 0; axis < 3; ++axis) size[axis] = reader.i32();
    reader.take(12);  // pivot
    const std::uint32_t count = reader.u32();
    if (!reader.ok()) return "the file ends in its head";
    if (!edges_fit(size)) return "its size is none, or larger than allowed";
    if (count > reader.remaining() / 8) return "it announces more voxels than the file has";
    ByteReader voxels(reader.take(std::size_t(count) * 8));
    reader.take(std::size_t(size.x) * 4);  // voxels of each slice
    if (reader.remaining() / 2 < std::size_t(size.x) * std::size_t(size.y)) return "it ends before its columns";
    std::vector<VoxelPoint> points;
    points.reserve(count);
    for (int x = 0; x < size.x; ++x)
        for (int y = 0; y < size.y; ++y) {
            const std::uint16_t in_column = reader.u16();
            for (std::uint16_t i = 0; i < in_column; ++i) {
                const std::uint8_t blue = voxels.u8(), green = voxels.u8(), red = voxels.u8();
                voxels.u8();
                const std::uint16_t z = voxels.u16();
                voxels.u16();  // visible sides, normal
                if (!voxels.ok()) return "its columns hold more voxels than it announces";
                if (z >= size.z) return "a voxel lies outside of the size";
                const std::uint16_t index = scene.color(red, green, blue);
                if (!index) return "it has more colours than a palette";
                points.push_back({{x, size.z - 1 - int(z), y}, index});
            }
        }
    return scene.add(name, {size.x, size.z, size.y}, std::move(points), ivec3(0));
}

// Layout: patrickmin.com/binvox/binvox.html. y fastest, then z, then x; y up.
Complaint read_binvox(std::string_view bytes, ColoredScene& scene, const std::string& name) {
    if (!bytes.starts_with("#binvox")) return "it is not a binvox file (it does not begin with '#binvox')";
    ivec3 size(0);
    std::size_t at = 0;
    while (true) {
        const std::size_t end = bytes.find('\n', at);
        if (end == bytes.npos) return "its header has no end";
        const std::string_view line = bytes.substr(at, end - at);
        at = end + 1;
        if (line.starts_with("data")) break;
        if (!line.starts_with("dim ")) continue;
        const char* digits = line.data() + 4;
        for (const int axis : {0, 2, 1}) {  // as they lie in the file
            while (digits < line.data() + line.size() && *digits == ' ') ++digits;
            const auto [next, error] = std::from_chars(digits, line.data() + line.size(), size[axis]);
            if (error != std::errc()) return "its dim is not three whole numbers";
            digits = next;
        }
    }
    if (!edges_fit(size)) return "its size is none, or larger than allowed";
    const std::uint64_t cells = std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(size.z);
    const std::uint16_t index = scene.color(200, 200, 200);
    ByteReader reader(bytes.substr(at));
    std::vector<VoxelPoint> points;
    std::uint64_t cell = 0;
    while (cell < cells) {
        const std::uint8_t value = reader.u8(), count = reader.u8();
        if (!reader.ok()) return "its voxels end early";
        if (count > cells - cell) return "it has more voxels than its size";
        if (value != 0) {
            if (points.size() + count > MAX_VOXELS) return "it has more voxels than allowed";
            for (std::uint64_t i = cell; i < cell + count; ++i) {
                const std::uint64_t y = std::uint64_t(size.y), z = std::uint64_t(size.z);
                points.push_back({{int(i / y / z), int(i % y), int(i / y % z)}, index});
            }
        }
        cell += count;
    }
    return scene.add(name, size, std::move(points), ivec3(0));
}

template <class Read>
Result<Scene> load_colored(const std::filesystem::path& path, const Read& read) {
    const Result<std::string> bytes = read_file_bytes(path, MAX_VOXELS_FILE);
    if (!bytes) return bytes.error();
    ColoredScene scene;
    const Complaint complaint = read(*bytes, scene);
    return scene.finish(path, complaint);
}

}  // namespace

Result<Scene> load_qubicle(const std::filesystem::path& path, const LoadOptions&) {
    return load_colored(path, [](std::string_view bytes, ColoredScene& scene) { return Qubicle(bytes, scene).read(); });
}

Result<Scene> load_kv6(const std::filesystem::path& path, const LoadOptions&) {
    const std::string name = path.stem().string();
    return load_colored(path,
                        [&](std::string_view bytes, ColoredScene& scene) { return read_kv6(bytes, scene, name); });
}

Result<Scene> load_binvox(const std::filesystem::path& path, const LoadOptions&) {
    const std::string name = path.stem().string();
    return load_colored(path,
                        [&](std::string_view bytes, ColoredScene& scene) { return read_binvox(bytes, scene, name); });
}

}  // namespace spinel
