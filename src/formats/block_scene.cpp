#include "formats/block_scene.h"

#include <algorithm>
#include <limits>
#include <set>

#include "kernels/materials.h"
#include "scene/material_registry.h"

namespace spinel {
namespace {

constexpr std::uint32_t NOT_MADE = 0xffffffffu;
constexpr std::size_t MAX_ODD = std::size_t(1) << 22;  // blocks of boxes; each box is twelve triangles
constexpr std::size_t MAX_STATES = std::size_t(1) << 20;
constexpr std::uint64_t MAX_JOINT_CELLS = std::uint64_t(1) << 30;  // bits that joints are looked up in
// Boxes end a little inside of what they touch, so that no two surfaces lie in one plane.
constexpr float INSET = 1.0f / 512;

void add_box(MeshGeometry& mesh, glm::vec3 lower, glm::vec3 upper, std::uint32_t slot) {
    const auto first = std::uint32_t(mesh.positions.size());
    for (std::uint32_t i = 0; i < 8; ++i)
        mesh.positions.push_back({i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z});
    // Two triangles a side, counter-clockwise from outside.
    constexpr std::uint32_t corners[12][3] = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                                              {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    for (const auto& c : corners) {
        mesh.triangles.push_back({first + c[0], first + c[1], first + c[2]});
        mesh.slots.push_back(slot);
    }
}

// Of the dielectrics the one that yields to all others.
bool is_water(const Material& material) {
    return material.values.kind == kernels::MATERIAL_DIELECTRIC && material.values.priority == 0;
}

}  // namespace

std::uint32_t BlockScene::state(const std::string& text) {
    const auto [found, is_new] = numbers_.emplace(text, std::uint32_t(blocks_.size()));
    if (!is_new) return found->second;
    blocks_.push_back(block_of(text));
    const Block& block = blocks_.back();
    nothing_.push_back(!block.cube && block.boxes.empty() && block.joint == Block::Joint::none && !block.in_water);
    slots_.push_back(0);
    seen_.push_back(false);
    return found->second;
}

std::uint32_t BlockScene::legacy_state(int id, int data) {
    if (id < 0 || id > 4095 || data < 0 || data > 15) return state("minecraft:air");
    if (legacy_.empty()) legacy_.assign(4096 * 16, NOT_MADE);
    std::uint32_t& made = legacy_[std::size_t(id) * 16 + std::size_t(data)];
    if (made != NOT_MADE) return made;
    const std::string name = legacy_block(id, data);
    return made = state(name.empty() ? "id:" + std::to_string(id) : name);
}

std::uint16_t BlockScene::slot_of(const kernels::Material& material, const std::string& name) {
    const auto same = std::find_if(materials_.begin(), materials_.end(),
                                   [&](const Material& other) { return same_material(other.values, material); });
    if (same == materials_.end()) {
        materials_.push_back({name, material});
        return std::uint16_t(materials_.size());
    }
    return std::uint16_t(same - materials_.begin() + 1);
}

bool BlockScene::place(ivec3 cell, std::uint32_t number) {
    if (nothing_[number]) return true;
    if (odd_.size() >= MAX_ODD || blocks_.size() > MAX_STATES) return false;
    const Block& block = blocks_[number];
    seen_[number] = true;
    if (block.in_water) {
        if (!water_slot_) water_slot_ = slot_of(block_of("water").material, "water");
        if (!cubes_.set(cell, water_slot_)) return false;
    }
    const bool has_boxes = !block.boxes.empty() || block.joint != Block::Joint::none;
    if (!block.cube && !has_boxes) return true;
    if (!slots_[number]) {
        if (materials_.size() >= std::numeric_limits<std::uint16_t>::max() - 1) return false;
        slots_[number] = slot_of(block.material, block.name);
    }
    if (block.cube && !block.in_water && !cubes_.set(cell, slots_[number])) return false;
    if (has_boxes) odd_.push_back({cell, number});
    return true;
}

void BlockScene::add_boxes(MeshGeometry& mesh, ivec3 lower, ivec3 upper) {
    // Fences, walls and panes join with cubes and with their like. A bit a cell, only where some have to be told.
    const ivec3 size = upper - lower + 1;
    const bool joints = std::any_of(odd_.begin(), odd_.end(),
                                    [&](const Odd& odd) { return blocks_[odd.state].joint != Block::Joint::none; });
    std::vector<bool> holds;
    const auto index = [&](ivec3 c) {
        return std::size_t(c.x - lower.x) +
               std::size_t(size.x) * (std::size_t(c.y - lower.y) + std::size_t(size.y) * std::size_t(c.z - lower.z));
    };
    const auto inside = [&](ivec3 c) {
        return glm::all(glm::greaterThanEqual(c, lower)) && glm::all(glm::lessThanEqual(c, upper));
    };
    const std::uint64_t cells = std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(size.z);
    if (joints && cells <= MAX_JOINT_CELLS) {
        holds.resize(std::size_t(cells));
        cubes_.for_each([&](ivec3 cell, std::uint16_t slot) {
            if (!is_water(materials_[slot - 1u])) holds[index(cell)] = true;
        });
        for (const Odd& odd : odd_)
            if (blocks_[odd.state].joint != Block::Joint::none) holds[index(odd.cell)] = true;
    }
    const auto joins = [&](ivec3 c) { return !holds.empty() && inside(c) && holds[index(c)]; };
    for (const Odd& odd : odd_) {
        const Block& block = blocks_[odd.state];
        const std::uint32_t slot = slots_[odd.state] - 1u;
        const auto add = [&](const std::vector<BlockBox>& boxes) {
            for (const BlockBox& box : boxes)
                add_box(mesh, glm::vec3(odd.cell - lower) + box.lower + INSET,
                        glm::vec3(odd.cell - lower) + box.upper - INSET, slot);
        };
        if (block.joint == Block::Joint::none) {
            add(block.boxes);
            continue;
        }
        unsigned sides = 0;
        if (joins(odd.cell + ivec3(0, 0, -1))) sides |= JOINS_NORTH;
        if (joins(odd.cell + ivec3(0, 0, 1))) sides |= JOINS_SOUTH;
        if (joins(odd.cell + ivec3(-1, 0, 0))) sides |= JOINS_WEST;
        if (joins(odd.cell + ivec3(1, 0, 0))) sides |= JOINS_EAST;
        add(joined_boxes(block.joint, sides));
    }
}

Result<Scene> BlockScene::build(const std::string& name) && {
    if (cubes_.empty() && odd_.empty()) return Error{"it holds no visible block"};
    ivec3 lower(std::numeric_limits<int>::max()), upper(std::numeric_limits<int>::min());
    const auto include = [&](ivec3 cell) {
        lower = glm::min(lower, cell);
        upper = glm::max(upper, cell);
    };
    if (!cubes_.empty()) {
        include(cubes_.bounds().first);
        include(cubes_.bounds().second);
    }
    for (const Odd& odd : odd_) include(odd.cell);

    Scene scene;
    std::vector<int> slots(materials_.size());
    for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = int(i);
    const auto add_object = [&](Geometry geometry) {
        Object object;
        object.name = geometry.name;
        object.geometry = int(scene.geometries.size());
        object.transform[3] = glm::vec3(lower);
        object.materials = slots;
        scene.geometries.push_back(std::move(geometry));
        scene.objects.push_back(std::move(object));
    };
    MeshGeometry mesh;
    add_boxes(mesh, lower, upper);
    if (!cubes_.empty()) {
        Result<VoxelTreePointer> tree = cubes_.tree(lower, upper - lower + 1);
        if (!tree) return tree.error();
        cubes_ = SparseCells();  // its memory is needed for the rest
        add_object({name, VoxelGeometry{std::move(*tree)}});
    }
    if (!mesh.triangles.empty()) add_object({name + " shapes", std::move(mesh)});
    scene.materials = std::move(materials_);

    std::set<std::string> unknown;
    for (std::size_t i = 0; i < blocks_.size(); ++i)
        if (seen_[i] && !blocks_[i].known) unknown.insert(blocks_[i].name);
    if (!unknown.empty()) {
        std::string list;
        std::size_t count = 0;
        for (const std::string& one : unknown) {
            if (++count > 8) break;
            list += (list.empty() ? "" : ", ") + one;
        }
        if (unknown.size() > 8) list += " …";
        scene.notes.push_back(std::to_string(unknown.size()) +
                              " kinds of block are not known and look as their names sound: " + list);
    }
    return scene;
}

}  // namespace spinel
