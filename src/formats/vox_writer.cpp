#include "formats/vox_writer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "core/atomic_file.h"
#include "formats/vox_file.h"
#include "formats/voxel_geometry.h"
#include "image/tone_map.h"
#include "kernels/materials.h"

namespace spinel {
namespace {

using vox::Dictionary;

constexpr int MAX_MODEL_EDGE = 256;
constexpr int MAX_COLORS = 255;
constexpr float MAX_TRANSLATION = 1 << 24;

template <class T>
std::string raw(T value) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    return bytes;
}
std::string number(std::size_t value) { return raw(std::int32_t(value)); }
std::string text(const std::string& s) { return number(s.size()) + s; }
std::string dictionary(const Dictionary& d) {
    std::string bytes = number(d.size());
    for (const auto& [key, value] : d) bytes += text(key) + text(value);
    return bytes;
}
std::string chunk(const std::string& id, const std::string& content) {
    return id + number(content.size()) + number(0) + content;
}
std::string decimal(float value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value);
    return std::string(digits, end.ptr);
}

// What one palette entry says.
struct Entry {
    std::array<std::uint8_t, 4> color = {0, 0, 0, 255};
    Dictionary properties;
};

void set_color(Entry& entry, vec3 linear) {
    for (int c = 0; c < 3; ++c)
        entry.color[std::size_t(c)] =
            std::uint8_t(std::lround(255.0f * std::clamp(srgb_encoded(std::max(linear[c], 0.0f)), 0.0f, 1.0f)));
}

// The inverse of vox_material.cpp's inner_medium().
void set_medium(Entry& entry, const Medium& medium) {
    const vec3 extinction = medium.scattering + medium.absorption;
    const float density = std::max({extinction.x, extinction.y, extinction.z, 1e-6f});
    Dictionary& said = entry.properties;
    said["_d"] = decimal(density);
    said["_g"] = decimal(medium.g);
    if (medium.emission != vec3(0)) {
        said["_media"] = "2", said["_media_type"] = "_emit";
        set_color(entry, medium.emission / density);
    } else if (medium.scattering == vec3(0)) {
        said["_media"] = "0", said["_media_type"] = "_absorb";
        set_color(entry, 1.0f - medium.absorption / density);
    } else {
        said["_media"] = "1", said["_media_type"] = "_scatter";
        set_color(entry, medium.scattering / density);
    }
}

// The inverse of vox_material.cpp's appearance().
Entry entry_of(const kernels::Material& m, const Medium* medium) {
    Entry entry;
    Dictionary& said = entry.properties;
    set_color(entry, m.color);
    if (const float most = std::max({m.emission.x, m.emission.y, m.emission.z}); most > 0.0f) {
        const float flux = std::clamp(std::ceil(std::log2(most) / 2.0f), 0.0f, 4.0f);
        set_color(entry, m.emission / most);
        said["_type"] = "_emit";
        said["_emit"] = decimal(std::min(most / std::pow(4.0f, flux), 1.0f));
        said["_flux"] = decimal(flux);
        return entry;
    }
    said["_rough"] = decimal(m.roughness);
    switch (m.kind) {
        case kernels::MATERIAL_METAL:
            said["_type"] = "_metal";
            said["_metal"] = "1";
            break;
        case kernels::MATERIAL_PRINCIPLED:
            said["_type"] = "_metal";
            said["_metal"] = decimal(m.metallic);
            break;
        case kernels::MATERIAL_PLASTIC:
            said["_type"] = "_metal";
            said["_plastic"] = "1";
            break;
        case kernels::MATERIAL_DIELECTRIC:
            said["_type"] = "_glass";
            said["_trans"] = "0.5";  // by which the colour is that of light after 4 voxels
            set_color(entry, glm::exp(-4.0f * m.absorption));
            if (medium) set_medium(entry, *medium);
            break;
        default: said["_type"] = "_diffuse"; break;
    }
    if (m.kind == kernels::MATERIAL_DIELECTRIC || m.kind == kernels::MATERIAL_PLASTIC) {
        said["_ri"] = decimal(m.ior);
        said["_ior"] = decimal(m.ior - 1.0f);
    }
    return entry;
}

// From the scene's space to the file's: a signed permutation and a whole-numbered place.
struct Pose {
    mat3 rotation = mat3(1);
    vec3 translation = {0, 0, 0};
};

class Writer {
  public:
    Writer(const Scene& scene, const std::filesystem::path& path) : scene_(scene), path_(path) {}

    Result<void> write() {
        if (scene_.objects.empty()) return refuse("there is no object in the scene");
        for (const Object& object : scene_.objects)
            if (Result<void> added = add_object(object); !added) return added;
        if (placements_ == 0) return refuse("there is no voxel in the scene");

        std::string children;
        for (std::size_t i = 0; i < placements_; ++i) children += number(2 + 2 * i);
        const std::string root = chunk("nTRN", number(0) + dictionary({}) + number(1) + raw(std::int32_t(-1)) +
                                                   raw(std::int32_t(-1)) + number(1) + dictionary({}));
        const std::string group = chunk("nGRP", number(1) + dictionary({}) + number(placements_) + children);
        std::string palette(1024, '\0'), materials;
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            std::memcpy(palette.data() + 4 * i, entries_[i].color.data(), 4);
            materials += chunk("MATL", number(i + 1) + dictionary(entries_[i].properties));
        }
        const std::string chunks = models_ + root + group + nodes_ + chunk("RGBA", palette) + materials;
        if (chunks.size() > 0x7fffffffu) return refuse("its voxels are more than a file can hold");
        return write_file_atomically(path_, "VOX " + number(150) + "MAIN" + number(0) + number(chunks.size()) + chunks);
    }

  private:
    Error refuse(const std::string& why) const { return {"cannot write '" + path_.string() + "': " + why}; }

    Result<void> add_object(const Object& object) {
        const Geometry& geometry = scene_.geometries[std::size_t(object.geometry)];
        const auto* voxels = std::get_if<VoxelGeometry>(&geometry.data);
        if (!voxels) return refuse("object '" + object.name + "' is not made of voxels");
        const std::optional<Pose> pose = pose_of(object.transform);
        if (!pose)
            return refuse(
                "object '" + object.name +
                "' does not stand on the lattice of voxels: it must be turned by right angles and moved by whole "
                "voxels, all objects of one scale");
        // Cells by the model that they fall into.
        std::map<std::array<int, 3>, std::vector<VoxelPoint>> models;
        std::map<std::uint16_t, std::uint8_t> colors;
        for (VoxelPoint& point : voxel_points(*voxels)) {
            const auto [color, is_new] = colors.emplace(point.palette, std::uint8_t(0));
            if (is_new) {
                const Result<std::uint8_t> made = color_of(object, point.palette);
                if (!made) return made.error();
                color->second = *made;
            }
            const ivec3 block = point.cell / MAX_MODEL_EDGE;
            models[{block.x, block.y, block.z}].push_back({point.cell - block * MAX_MODEL_EDGE, color->second});
        }
        for (const auto& [block, points] : models)
            add_model(object.name, *pose, MAX_MODEL_EDGE * ivec3(block[0], block[1], block[2]), points);
        return {};
    }

    void add_model(const std::string& name, const Pose& pose, ivec3 corner, const std::vector<VoxelPoint>& points) {
        ivec3 lower(MAX_MODEL_EDGE), upper(0);
        for (const VoxelPoint& p : points) {
            lower = glm::min(lower, p.cell);
            upper = glm::max(upper, p.cell + 1);
        }
        const ivec3 size = upper - lower;
        std::string voxels = number(points.size());
        for (const VoxelPoint& p : points) {
            const ivec3 cell = p.cell - lower;
            voxels += {char(cell.x), char(cell.y), char(cell.z), char(p.palette)};
        }
        models_ +=
            chunk("SIZE", number(std::size_t(size.x)) + number(std::size_t(size.y)) + number(std::size_t(size.z))) +
            chunk("XYZI", voxels);
        // A model turns about its middle, rounded down.
        const vec3 place = pose.translation + pose.rotation * vec3(corner + lower + size / 2);
        Dictionary frame;
        frame["_t"] = std::to_string(std::lround(place.x)) + " " + std::to_string(std::lround(place.y)) + " " +
                      std::to_string(std::lround(place.z));
        if (pose.rotation != mat3(1)) frame["_r"] = std::to_string(rotation_bits(pose.rotation));
        const std::size_t node = 2 + 2 * placements_;
        nodes_ += chunk("nTRN", number(node) + dictionary({{"_name", name}}) + number(node + 1) +
                                    raw(std::int32_t(-1)) + raw(std::int32_t(-1)) + number(1) + dictionary(frame));
        nodes_ += chunk("nSHP", number(node + 1) + dictionary({}) + number(1) + number(placements_) + dictionary({}));
        ++placements_;
    }

    // The file's axes: x right, y away, z up. Ours: x right, y up, z towards the viewer.
    std::optional<Pose> pose_of(const mat4x3& m) {
        const mat3 turn(vec3(1, 0, 0), vec3(0, 0, 1), vec3(0, -1, 0));
        const float scale = glm::length(m[0]);
        if (scale_ == 0.0f) scale_ = scale;
        if (!(std::abs(scale - scale_) <= 1e-4f * scale_)) return std::nullopt;
        Pose pose;
        const mat3 linear = turn * mat3(m[0], m[1], m[2]) / scale_;
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row) {
                pose.rotation[column][row] = std::round(linear[column][row]);
                if (std::abs(linear[column][row] - pose.rotation[column][row]) > 1e-4f) return std::nullopt;
            }
        for (int column = 0; column < 3; ++column)
            if (glm::dot(pose.rotation[column], pose.rotation[column]) != 1.0f) return std::nullopt;
        if (std::abs(glm::determinant(pose.rotation)) != 1.0f) return std::nullopt;
        const vec3 offset = turn * m[3] / scale_;
        // The first object decides where the lattice lies.
        if (!phase_) phase_ = offset - glm::round(offset);
        pose.translation = glm::round(offset - *phase_);
        for (int axis = 0; axis < 3; ++axis)
            if (!(std::abs(offset[axis] - (*phase_)[axis] - pose.translation[axis]) <= 1e-3f) ||
                std::abs(pose.translation[axis]) > MAX_TRANSLATION)
                return std::nullopt;
        return pose;
    }

    static int rotation_bits(const mat3& rotation) {
        int bits = 0;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column) {
                if (rotation[column][row] == 0.0f) continue;
                if (row < 2) bits |= column << (2 * row);
                if (rotation[column][row] < 0.0f) bits |= 1 << (4 + row);
            }
        return bits;
    }

    // The file's palette index of an object's.
    Result<std::uint8_t> color_of(const Object& object, std::uint16_t palette) {
        const std::size_t slot = object.materials.size() == 1 ? 0 : std::size_t(palette - 1);
        const int material = slot < object.materials.size() ? object.materials[slot] : -1;
        int interior = object.interior;
        if (material >= 0 && interior < 0 && scene_.materials[std::size_t(material)].values.interior != kernels::NONE)
            interior = int(scene_.materials[std::size_t(material)].values.interior);
        const auto [made, is_new] = colors_.emplace(std::make_pair(material, interior), std::uint8_t(0));
        if (!is_new) return made->second;
        const Medium* medium = interior >= 0 ? &scene_.media[std::size_t(interior)] : nullptr;
        Entry entry;
        if (material >= 0) {
            entry = entry_of(scene_.materials[std::size_t(material)].values, medium);
        } else if (medium) {
            entry.properties["_type"] = "_media";
            set_medium(entry, *medium);
        } else {
            return refuse("object '" + object.name + "' has voxels without a material or a medium");
        }
        const auto same = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& other) {
            return other.color == entry.color && other.properties == entry.properties;
        });
        if (same == entries_.end() && entries_.size() == MAX_COLORS)
            return refuse("it needs more than the " + std::to_string(MAX_COLORS) + " colours of a palette");
        made->second = std::uint8_t(same - entries_.begin() + 1);
        if (same == entries_.end()) entries_.push_back(std::move(entry));
        return made->second;
    }

    const Scene& scene_;
    const std::filesystem::path& path_;
    float scale_ = 0;  // units a voxel, of the first object
    std::optional<vec3> phase_;
    std::vector<Entry> entries_;                          // palette index 1 …
    std::map<std::pair<int, int>, std::uint8_t> colors_;  // of material and interior
    std::string models_, nodes_;
    std::size_t placements_ = 0;
};

}  // namespace

Result<void> save_vox(const Scene& scene, const std::filesystem::path& path) { return Writer(scene, path).write(); }

}  // namespace spinel
