#include "formats/vox.h"

#include <algorithm>
#include <optional>

#include "formats/file_bytes.h"
#include "formats/vox_file.h"
#include "formats/vox_material.h"
#include "formats/vox_settings.h"
#include "formats/voxel_geometry.h"
#include "scene/material_registry.h"

namespace spinel {
namespace {

constexpr std::size_t MAX_VOX_CELLS = std::size_t(1) << 30;   // of all models together
constexpr std::size_t MAX_PLACEMENTS = std::size_t(1) << 20;  // a small graph may place a model exponentially often
constexpr std::size_t MAX_VOX_DEPTH = 256;

// p ↦ linear·p + offset
struct Placement {
    mat3 linear = mat3(1);
    vec3 offset = {0, 0, 0};
    std::string name;
};

// Part of a model that is one geometry: all that has a surface, or the cells of one cloud material.
struct Part {
    int geometry = -1;
    std::vector<int> materials;
    int interior = -1;
};

class Builder {
  public:
    Builder(const std::filesystem::path& path, const vox::File& file, int frame)
        : path_(path),
          file_(file),
          frame_(std::size_t(frame)),
          parts_(file.models.size()),
          material_of_(256, NOT_MADE) {}

    Result<Scene> build() {
        std::optional<std::string> complaint;
        if (file_.nodes.empty()) {
            // Without a scene graph a model stands on the ground, its pivot above the origin.
            complaint = place(frame_, {mat3(1), vec3(0, 0, file_.models[frame_].size.z / 2), ""});
        } else if (!file_.nodes.count(0)) {
            complaint = "its scene graph has no root (node 0)";
        } else {
            complaint = visit(0, {});
        }
        if (complaint) return cannot_read(path_, *complaint);
        if (scene_.objects.empty()) return cannot_read(path_, "it holds no visible voxel");
        vox::apply_settings(file_, scene_);
        return std::move(scene_);
    }

  private:
    using Complaint = std::optional<std::string>;

    Complaint visit(int index, Placement placement) {
        const auto found = file_.nodes.find(index);
        if (found == file_.nodes.end())
            return "its scene graph refers to node " + std::to_string(index) + ", which is not there";
        const vox::Node& node = found->second;
        if (std::find(way_.begin(), way_.end(), index) != way_.end())
            return "byte " + std::to_string(node.offset) + ": node " + std::to_string(index) + " is its own ancestor";
        if (way_.size() >= MAX_VOX_DEPTH)
            return "its scene graph is deeper than the " + std::to_string(MAX_VOX_DEPTH) + " levels allowed";
        if (++visited_ > MAX_PLACEMENTS)
            return "its scene graph places more than the " + std::to_string(MAX_PLACEMENTS) + " nodes allowed";
        if (node.hidden || file_.hidden_layers.count(node.layer)) return {};

        placement.offset = placement.linear * node.translation + placement.offset;
        placement.linear = placement.linear * node.rotation;
        if (!node.name.empty()) placement.name = node.name;
        way_.push_back(index);
        for (const int child : node.children) {
            Complaint complaint;
            if (node.kind != vox::Node::Kind::shape) complaint = visit(child, placement);
            else if (child < 0 || std::size_t(child) >= file_.models.size())
                complaint = "byte " + std::to_string(node.offset) + ": a shape refers to model " +
                            std::to_string(child) + " of " + std::to_string(file_.models.size());
            else complaint = place(std::size_t(child), placement);
            if (complaint) return complaint;
        }
        way_.pop_back();
        return {};
    }

    Complaint place(std::size_t model, const Placement& placement) {
        if (!parts_[model]) {
            parts_[model].emplace();
            if (Complaint complaint = make_parts(model)) return complaint;
        }
        // The file's axes: x right, y away, z up. Ours: x right, y up, z towards the viewer.
        const mat3 turn(vec3(1, 0, 0), vec3(0, 0, -1), vec3(0, 1, 0));
        const vec3 pivot = file_.models[model].size / 2;  // rounded down, in whole voxels
        const mat3 linear = turn * placement.linear;
        const vec3 offset = turn * (placement.offset - placement.linear * pivot);
        for (const Part& part : *parts_[model]) {
            Object object;
            object.name = placement.name.empty() ? scene_.geometries[std::size_t(part.geometry)].name : placement.name;
            object.geometry = part.geometry;
            object.transform = mat4x3(linear[0], linear[1], linear[2], offset);
            object.materials = part.materials;
            object.interior = part.interior;
            scene_.objects.push_back(std::move(object));
        }
        return {};
    }

    Complaint make_parts(std::size_t model) {
        const ivec3 size = file_.models[model].size;
        const std::string_view voxels = file_.models[model].voxels;
        std::array<bool, 256> used{};
        for (std::size_t i = 3; i < voxels.size(); i += 4) used[std::uint8_t(voxels[i])] = true;
        used[0] = false;
        std::vector<int> solid, clouds;
        for (int index = 1; index < 256; ++index) {
            if (!used[std::size_t(index)]) continue;
            if (make_material(index) == CLOUD) clouds.push_back(index);
            else solid.push_back(index);
        }
        const std::size_t cells = std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
        cells_ += cells * (clouds.size() + (solid.empty() ? 0 : 1));
        if (cells_ > MAX_VOX_CELLS)
            return "its models have more than the " + std::to_string(MAX_VOX_CELLS) + " cells allowed";

        const std::string name = "model " + std::to_string(model);
        if (!solid.empty()) {
            Part part;
            const Result<int> geometry = add_geometry(name, size, voxels, solid);
            if (!geometry) return geometry.error().message;
            part.geometry = *geometry;
            // Slots that no voxel uses repeat a used one: −1 there would announce interfaces that are not.
            part.materials.assign(std::size_t(solid.back()), material_of_[std::size_t(solid[0])]);
            for (const int index : solid) part.materials[std::size_t(index - 1)] = material_of_[std::size_t(index)];
            parts_[model]->push_back(std::move(part));
        }
        for (const int index : clouds) {
            Part part;
            const Result<int> geometry = add_geometry(name + " cloud " + std::to_string(index), size, voxels, {index});
            if (!geometry) return geometry.error().message;
            part.geometry = *geometry;
            part.materials = {-1};
            part.interior = medium_of_[index];
            parts_[model]->push_back(std::move(part));
        }
        return {};
    }

    Result<int> add_geometry(const std::string& name, ivec3 size, std::string_view voxels,
                             const std::vector<int>& kept) {
        std::array<bool, 256> keep{};
        for (const int index : kept) keep[std::size_t(index)] = true;
        std::vector<VoxelPoint> points;
        for (std::size_t i = 0; i < voxels.size(); i += 4) {
            const auto byte = [&](std::size_t j) { return std::uint8_t(voxels[i + j]); };
            if (keep[byte(3)]) points.push_back({{byte(0), byte(1), byte(2)}, byte(3)});
        }
        Result<Geometry> geometry = voxel_geometry(name, size, std::move(points));
        if (!geometry) return geometry.error();
        scene_.geometries.push_back(std::move(*geometry));
        return int(scene_.geometries.size()) - 1;
    }

    // The scene's material of a palette index, or CLOUD. Entries that look the same share one.
    int make_material(int index) {
        int& made = material_of_[std::size_t(index)];
        if (made != NOT_MADE) return made;
        const auto properties = file_.properties.find(index);
        vox::Appearance look = vox::appearance(
            file_.palette[std::size_t(index)],
            properties == file_.properties.end() ? std::map<std::string, std::string>() : properties->second);
        const std::string name = "palette " + std::to_string(index);
        int medium = -1;
        if (look.medium) {
            medium = int(scene_.media.size());
            look.medium->name = name;
            scene_.media.push_back(*look.medium);
        }
        if (look.cloud) {
            medium_of_[index] = medium;
            return made = CLOUD;
        }
        if (medium >= 0) look.material.interior = std::uint32_t(medium);
        const auto same = std::find_if(scene_.materials.begin(), scene_.materials.end(), [&](const Material& other) {
            return same_material(other.values, look.material);
        });
        if (same != scene_.materials.end()) return made = int(same - scene_.materials.begin());
        scene_.materials.push_back({name, look.material});
        return made = int(scene_.materials.size()) - 1;
    }

    static constexpr int NOT_MADE = -1;
    static constexpr int CLOUD = -2;

    const std::filesystem::path& path_;
    const vox::File& file_;
    std::size_t frame_;  // of a file without a scene graph the model
    Scene scene_;
    std::vector<std::optional<std::vector<Part>>> parts_;  // of each model, once it is placed
    std::vector<int> material_of_;                         // of each palette index
    std::map<int, int> medium_of_;                         // of palette indices that are clouds
    std::vector<int> way_;                                 // from the root to the node that is visited
    std::size_t visited_ = 0;
    std::size_t cells_ = 0;
};

}  // namespace

Result<Scene> load_vox(const std::filesystem::path& path, const LoadOptions& options) {
    const int frame = options.frame.value_or(0);
    const Result<vox::File> file = vox::read(path, frame);
    if (!file) return file.error();
    return Builder(path, *file, frame).build();
}

}  // namespace spinel
