#include "formats/vox_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "core/atomic_file.h"
#include "formats/left_out.h"
#include "formats/vox_palette.h"
#include "kernels/materials.h"

namespace spinel {
namespace {

using vox::Dictionary;

constexpr int MAX_MODEL_EDGE = 256;
constexpr int MAX_COLORS = 255;
constexpr float MAX_TRANSLATION = 1 << 24;

template <class T>
std::string raw_bytes(T value) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    return bytes;
}
std::string int_bytes(std::size_t value) { return raw_bytes(std::int32_t(value)); }
std::string text_bytes(const std::string& s) { return int_bytes(s.size()) + s; }
std::string dictionary_bytes(const Dictionary& d) {
    std::string bytes = int_bytes(d.size());
    for (const auto& [key, value] : d) bytes += text_bytes(key) + text_bytes(value);
    return bytes;
}
std::string chunk(const std::string& id, const std::string& content) {
    return id + int_bytes(content.size()) + int_bytes(0) + content;
}
// From the scene's space to the file's: a signed permutation and a whole-numbered place.
struct Pose {
    mat3 rotation = mat3(1);
    vec3 translation = {0, 0, 0};
};

class Writer {
  public:
    Writer(const Scene& scene, const std::filesystem::path& path) : scene_(scene), path_(path) {}

    Result<Notes> write() {
        if (scene_.objects.empty()) return refuse("there is no object in the scene");
        std::vector<Pose> poses;
        for (const Object& object : scene_.objects) {
            const Result<Pose> pose = look_at(object);
            if (!pose) return pose.error();
            poses.push_back(*pose);
        }
        if (looks_.empty()) return refuse("there is no voxel in the scene");
        Result<vox::FewEntries> few = vox::few_entries(entries_, voxels_, MAX_COLORS);
        if (!few) return refuse(few.error().message);
        palette_ = std::move(*few);
        for (std::size_t i = 0; i < poses.size(); ++i) add_object(scene_.objects[i], poses[i]);

        std::string children;
        for (std::size_t i = 0; i < placements_; ++i) children += int_bytes(2 + 2 * i);
        const std::string root =
            chunk("nTRN", int_bytes(0) + dictionary_bytes({}) + int_bytes(1) + raw_bytes(std::int32_t(-1)) +
                              raw_bytes(std::int32_t(-1)) + int_bytes(1) + dictionary_bytes({}));
        const std::string group =
            chunk("nGRP", int_bytes(1) + dictionary_bytes({}) + int_bytes(placements_) + children);
        std::string palette(1024, '\0'), materials;
        for (std::size_t i = 0; i < palette_.entries.size(); ++i) {
            std::memcpy(palette.data() + 4 * i, palette_.entries[i].color.data(), 4);
            materials += chunk("MATL", int_bytes(i + 1) + dictionary_bytes(palette_.entries[i].properties));
        }
        const std::string chunks = models_ + root + group + nodes_ + chunk("RGBA", palette) + materials;
        if (chunks.size() > 0x7fffffffu) return refuse("its voxels are more than a file can hold");
        if (Result<void> written = write_file_atomically(
                path_, "VOX " + int_bytes(150) + "MAIN" + int_bytes(0) + int_bytes(chunks.size()) + chunks);
            !written)
            return written.error();
        return notes();
    }

  private:
    Error refuse(const std::string& why) const { return {"cannot write '" + path_.string() + "': " + why}; }

    // Where an object stands; notes what its voxels look like.
    Result<Pose> look_at(const Object& object) {
        const Geometry& geometry = scene_.geometries[std::size_t(object.geometry)];
        const auto* voxels = std::get_if<VoxelGeometry>(&geometry.data);
        if (!voxels) return refuse("object '" + object.name + "' is not made of voxels");
        const std::optional<Pose> pose = pose_of(object.transform);
        if (!pose)
            return refuse(
                "object '" + object.name +
                "' does not stand on the lattice of voxels: it must be turned by right angles and moved by whole "
                "voxels, all objects of one scale");
        std::vector<std::uint64_t> counts(voxels->tree->palette_maximum() + std::size_t(1));
        voxels->tree->for_each_cube([&](ivec3, int edge, std::uint16_t palette) {
            counts[palette] += std::uint64_t(edge) * std::uint64_t(edge) * std::uint64_t(edge);
        });
        for (std::size_t palette = 1; palette < counts.size(); ++palette)
            if (counts[palette] > 0)
                if (Result<void> added = add_look(object, std::uint16_t(palette), counts[palette]); !added)
                    return added.error();
        return *pose;
    }

    void add_object(const Object& object, const Pose& pose) {
        const auto& voxels = std::get<VoxelGeometry>(scene_.geometries[std::size_t(object.geometry)].data);
        // Cells by the model that they fall into.
        std::map<std::array<int, 3>, std::vector<VoxelPoint>> models;
        std::vector<std::uint16_t> color(voxels.tree->palette_maximum() + std::size_t(1));
        voxels.tree->for_each([&](ivec3 cell, std::uint16_t palette) {
            if (color[palette] == 0)
                color[palette] = std::uint16_t(1 + palette_.index[looks_.at(look_of(object, palette))]);
            const ivec3 block = cell / MAX_MODEL_EDGE;
            models[{block.x, block.y, block.z}].push_back({cell - block * MAX_MODEL_EDGE, color[palette]});
        });
        for (const auto& [block, points] : models)
            add_model(object.name, pose, MAX_MODEL_EDGE * ivec3(block[0], block[1], block[2]), points);
    }

    void add_model(const std::string& name, const Pose& pose, ivec3 corner, const std::vector<VoxelPoint>& points) {
        ivec3 lower(MAX_MODEL_EDGE), upper(0);
        for (const VoxelPoint& p : points) {
            lower = glm::min(lower, p.cell);
            upper = glm::max(upper, p.cell + 1);
        }
        const ivec3 size = upper - lower;
        std::string voxels = int_bytes(points.size());
        for (const VoxelPoint& p : points) {
            const ivec3 cell = p.cell - lower;
            voxels += {char(cell.x), char(cell.y), char(cell.z), char(p.palette)};
        }
        models_ += chunk("SIZE", int_bytes(std::size_t(size.x)) + int_bytes(std::size_t(size.y)) +
                                     int_bytes(std::size_t(size.z))) +
                   chunk("XYZI", voxels);
        // A model turns about its middle, rounded down.
        const vec3 place = pose.translation + pose.rotation * vec3(corner + lower + size / 2);
        Dictionary frame;
        frame["_t"] = std::to_string(std::lround(place.x)) + " " + std::to_string(std::lround(place.y)) + " " +
                      std::to_string(std::lround(place.z));
        if (pose.rotation != mat3(1)) frame["_r"] = std::to_string(rotation_bits(pose.rotation));
        const std::size_t node = 2 + 2 * placements_;
        nodes_ += chunk("nTRN", int_bytes(node) + dictionary_bytes({{"_name", name}}) + int_bytes(node + 1) +
                                    raw_bytes(std::int32_t(-1)) + raw_bytes(std::int32_t(-1)) + int_bytes(1) +
                                    dictionary_bytes(frame));
        nodes_ += chunk("nSHP", int_bytes(node + 1) + dictionary_bytes({}) + int_bytes(1) + int_bytes(placements_) +
                                    dictionary_bytes({}));
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

    // A material and what is inside, each −1: none.
    using Look = std::pair<int, int>;

    Look look_of(const Object& object, std::uint16_t palette) const {
        const std::size_t slot = object.materials.size() == 1 ? 0 : std::size_t(palette - 1);
        const int material = slot < object.materials.size() ? object.materials[slot] : -1;
        int interior = object.interior;
        if (material >= 0 && interior < 0 && scene_.materials[std::size_t(material)].values.interior != kernels::NONE)
            interior = int(scene_.materials[std::size_t(material)].values.interior);
        return {material, interior};
    }

    Result<void> add_look(const Object& object, std::uint16_t palette, std::uint64_t voxels) {
        const Look look = look_of(object, palette);
        const auto [known, is_new] = looks_.emplace(look, 0);
        if (!is_new) return voxels_[known->second] += voxels, Result<void>();
        const Medium* medium = look.second >= 0 ? &scene_.media[std::size_t(look.second)] : nullptr;
        vox::Entry entry;
        if (look.first >= 0) {
            const kernels::Material& material = scene_.materials[std::size_t(look.first)].values;
            entry = vox::entry_of(material, medium, scale_);
            const bool is_glass = material.kind == kernels::MATERIAL_DIELECTRIC;
            for (const std::string& what : vox::losses(material, is_glass ? medium : nullptr, scale_)) ++lost_[what];
            if (medium && !is_glass) ++lost_["interior"];
        } else if (medium) {
            entry = vox::entry_of(*medium, scale_);
        } else {
            return refuse("object '" + object.name + "' has voxels without a material or a medium");
        }
        if (medium && (medium->grid >= 0 || medium->erosion.kind != Erosion::Kind::none)) ++lost_["varying density"];
        const auto same = std::find(entries_.begin(), entries_.end(), entry);
        known->second = std::size_t(same - entries_.begin());
        if (same == entries_.end()) {
            entries_.push_back(std::move(entry));
            voxels_.push_back(0);
        }
        voxels_[known->second] += voxels;
        return {};
    }

    Notes notes() const {
        LeftOut left_out;
        for (const auto& [what, count] : lost_)
            left_out.add(what + " of " + std::to_string(count) + (count == 1 ? " material" : " materials"));
        if (palette_.entries.size() < entries_.size())
            left_out.add(std::to_string(entries_.size()) + " colours as " + std::to_string(palette_.entries.size()));
        if (std::abs(scale_ - 1.0f) > 1e-4f) left_out.add("the size of voxels");
        left_out.add_light_and_cameras(scene_);
        return left_out.notes();
    }

    const Scene& scene_;
    const std::filesystem::path& path_;
    float scale_ = 0;  // units a voxel, of the first object
    std::optional<vec3> phase_;
    std::map<Look, std::size_t> looks_;  // their entries
    std::vector<vox::Entry> entries_;    // all that are asked for …
    std::vector<std::uint64_t> voxels_;  // … by so many voxels …
    vox::FewEntries palette_;            // … and what is written of them, from palette index 1 on
    std::map<std::string, int> lost_;    // what cannot be said, of so many materials
    std::string models_, nodes_;
    std::size_t placements_ = 0;
};

}  // namespace

Result<Notes> save_vox(const Scene& scene, const std::filesystem::path& path) { return Writer(scene, path).write(); }

}  // namespace spinel
