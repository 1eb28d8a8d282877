#include "formats/schematic.h"

#include <optional>

#include "formats/block_scene.h"
#include "formats/block_states.h"
#include "formats/byte_reader.h"
#include "formats/file_bytes.h"
#include "formats/nbt.h"

namespace spinel {
namespace {

constexpr std::uintmax_t MAX_SCHEMATIC_FILE = std::uintmax_t(1) << 30;
constexpr int MAX_SCHEMATIC_EDGE = 1 << 16;
constexpr std::uint64_t MAX_SCHEMATIC_CELLS = std::uint64_t(1) << 32;

using Complaint = std::optional<std::string>;
const std::string TOO_MANY = "there are more blocks than allowed";

// Reads a file of NBT, lets `fill` place its blocks, and makes the scene.
template <class Fill>
Result<Scene> load_blocks(const std::filesystem::path& path, const Fill& fill) {
    Result<std::string> bytes = read_file_bytes(path, MAX_SCHEMATIC_FILE);
    if (!bytes) return bytes.error();
    const Result<nbt::Document> document = nbt::parse_packed(std::move(*bytes));
    if (!document) return cannot_read(path, document.error().message);
    BlockScene blocks;
    if (const Complaint complaint = fill(document->root, blocks)) return cannot_read(path, *complaint);
    Result<Scene> scene = std::move(blocks).build(path.stem().string());
    if (!scene) return cannot_read(path, scene.error().message);
    return scene;
}

Complaint check_size(ivec3 size) {
    const std::uint64_t cells = std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(size.z);
    for (int axis = 0; axis < 3; ++axis)
        if (size[axis] < 1 || size[axis] > MAX_SCHEMATIC_EDGE)
            return "an edge is " + std::to_string(size[axis]) + " blocks long; it must be 1 … " +
                   std::to_string(MAX_SCHEMATIC_EDGE);
    if (cells > MAX_SCHEMATIC_CELLS)
        return "its box is larger than the " + std::to_string(MAX_SCHEMATIC_CELLS) + " blocks allowed";
    return {};
}

std::size_t cells_of(ivec3 size) { return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z); }

// Cell i of a box, x fastest, then z, then y.
ivec3 cell_in_box(std::size_t i, ivec3 size) {
    const std::size_t x = std::size_t(size.x), z = std::size_t(size.z);
    return {int(i % x), int(i / x / z), int(i / x % z)};
}

// Width, Height and Length, which are unsigned though NBT is not.
ivec3 read_size(const nbt::Tag& tag) {
    const auto edge = [&](const char* key) { return int(std::uint16_t(tag.integer_of(key, 0))); };
    return {edge("Width"), edge("Height"), edge("Length")};
}

Complaint fill_sponge(const nbt::Tag& root, BlockScene& blocks) {
    // Version 3 stands in a compound of its own, its blocks in another.
    const nbt::Tag* inner = root.find("Schematic", nbt::Type::compound);
    const nbt::Tag& schematic = inner ? *inner : root;
    const std::int64_t version = schematic.integer_of("Version", 0);
    if (version < 1 || version > 3)
        return version == 0 ? "it is not a Sponge schematic (it has no Version)"
                            : "its version is " + std::to_string(version) + ", readable are 1, 2 and 3";
    const nbt::Tag* container = version == 3 ? schematic.find("Blocks", nbt::Type::compound) : &schematic;
    if (!container) return "it has no Blocks";
    const nbt::Tag* palette = container->find("Palette", nbt::Type::compound);
    const nbt::Tag* data = container->find(version == 3 ? "Data" : "BlockData", nbt::Type::int8_array);
    if (!palette || !data) return "it has no palette or no block data";
    const ivec3 size = read_size(schematic);
    if (Complaint complaint = check_size(size)) return complaint;
    const std::size_t cells = cells_of(size);
    if (data->bytes.size() < cells)
        return "its size needs at least " + std::to_string(cells) + " bytes of blocks, it has " +
               std::to_string(data->bytes.size());

    std::vector<std::optional<std::uint32_t>> states(
        std::min<std::size_t>(palette->children.size() * 2 + 256, 1u << 22));
    for (const nbt::Tag& entry : palette->children) {
        if (entry.integer < 0 || std::size_t(entry.integer) >= states.size())
            return "palette entry '" + std::string(entry.name) + "' has number " + std::to_string(entry.integer);
        states[std::size_t(entry.integer)] = blocks.state(std::string(entry.name));
    }
    ByteReader reader(data->bytes);
    for (std::size_t i = 0; i < cells; ++i) {
        std::uint32_t index = 0;  // seven bits a byte, the lowest first
        int shift = 0;
        std::uint8_t byte = 0x80;
        for (; (byte & 0x80) && shift < 28; shift += 7) {
            byte = reader.u8();
            index |= std::uint32_t(byte & 0x7f) << shift;
        }
        if (!reader.ok()) return "its block data ends early";
        if (index >= states.size() || !states[index])
            return "a block refers to palette entry " + std::to_string(index) + ", which is not there";
        if (!blocks.place(cell_in_box(i, size), *states[index])) return TOO_MANY;
    }
    return {};
}

Complaint fill_mcedit(const nbt::Tag& root, BlockScene& blocks) {
    const nbt::Tag* ids = root.find("Blocks", nbt::Type::int8_array);
    const nbt::Tag* data = root.find("Data", nbt::Type::int8_array);
    const nbt::Tag* add =
        root.find("AddBlocks", nbt::Type::int8_array);  // bits 8 … 11 of the ids, the high nibble first
    if (!ids) return "it is not a schematic of MCEdit (it has no Blocks)";
    const ivec3 size = read_size(root);
    if (Complaint complaint = check_size(size)) return complaint;
    const std::size_t cells = cells_of(size);
    if (ids->bytes.size() != cells || (data && data->bytes.size() != cells) || (add && add->bytes.size() < cells / 2))
        return "its size needs " + std::to_string(cells) + " blocks, it has " + std::to_string(ids->bytes.size());

    // What Schematica writes besides: the names of the numbers. Only those of mods are worth asking.
    std::unordered_map<int, std::uint32_t> foreign;
    if (const nbt::Tag* mapping = root.find("SchematicaMapping", nbt::Type::compound))
        for (const nbt::Tag& entry : mapping->children)
            if (!entry.name.starts_with("minecraft:"))
                foreign[int(entry.integer)] = blocks.state(std::string(entry.name));

    for (std::size_t i = 0; i < cells; ++i) {
        int id = std::uint8_t(ids->bytes[i]);
        if (add && i / 2 < add->bytes.size()) {
            const auto pair = std::uint8_t(add->bytes[i / 2]);
            id |= (i & 1 ? pair >> 4 : pair & 15) << 8;
        }
        if (id == 0) continue;
        const auto named = foreign.find(id);
        const std::uint32_t state =
            named != foreign.end() ? named->second : blocks.legacy_state(id, data ? data->bytes[i] & 15 : 0);
        if (!blocks.place(cell_in_box(i, size), state)) return TOO_MANY;
    }
    return {};
}

std::optional<ivec3> read_vector(const nbt::Tag& tag, std::string_view key) {
    const nbt::Tag* vector = tag.find(key, nbt::Type::compound);
    if (!vector) return std::nullopt;
    ivec3 result(0);
    constexpr std::string_view axes[] = {"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t value = vector->integer_of(axes[axis], 0);
        if (value < -(1 << 24) || value > (1 << 24)) return std::nullopt;
        result[axis] = int(value);
    }
    return result;
}

Complaint fill_litematic(const nbt::Tag& root, BlockScene& blocks) {
    const nbt::Tag* regions = root.find("Regions", nbt::Type::compound);
    if (!regions) return "it is not a litematic (it has no Regions)";
    std::optional<ivec3> lowest, highest;
    for (const nbt::Tag& region : regions->children) {
        const std::string where = "region '" + std::string(region.name) + "': ";
        const std::optional<ivec3> position = read_vector(region, "Position"), extent = read_vector(region, "Size");
        const nbt::Tag* palette = region.find("BlockStatePalette", nbt::Type::list);
        const nbt::Tag* data = region.find("BlockStates", nbt::Type::int64_array);
        if (!position || !extent || !palette || !data)
            return where + "it lacks a position, a size, a palette or blocks";
        // A size may be negative: the region then extends the other way from its position.
        const ivec3 size = glm::abs(*extent);
        const ivec3 origin = *position + glm::min(*extent + 1, ivec3(0));
        if (Complaint complaint = check_size(size)) return where + *complaint;
        lowest = lowest ? glm::min(*lowest, origin) : origin;
        highest = highest ? glm::max(*highest, origin + size) : origin + size;
        if (Complaint complaint = check_size(*highest - *lowest)) return "all regions together: " + *complaint;
        const Result<std::vector<std::uint32_t>> states = read_palette(*palette, blocks);
        if (!states) return where + states.error().message;
        const int bits = bits_for(states->size(), 2);
        const std::size_t cells = cells_of(size);
        if (data->count() < PackedIndices::words_for(cells, bits, true))
            return where + "its size needs " + std::to_string(PackedIndices::words_for(cells, bits, true)) +
                   " words of blocks, it has " + std::to_string(data->count());
        const PackedIndices indices(*data, bits, true);
        for (std::size_t i = 0; i < cells; ++i) {
            const std::size_t index = indices[i];
            if (index >= states->size())
                return where + "a block refers to palette entry " + std::to_string(index) + " of " +
                       std::to_string(states->size());
            if (!blocks.place(origin + cell_in_box(i, size), (*states)[index])) return TOO_MANY;
        }
    }
    return {};
}

Complaint fill_structure(const nbt::Tag& root, BlockScene& blocks) {
    const nbt::Tag* edges = root.find("size", nbt::Type::list);
    const nbt::Tag* palette = root.find("palette", nbt::Type::list);
    // Some structures have several looks; the first counts.
    if (const nbt::Tag* palettes = root.find("palettes", nbt::Type::list); palettes && !palettes->children.empty())
        palette = &palettes->children.front();
    const nbt::Tag* list = root.find("blocks", nbt::Type::list);
    if (!edges || edges->children.size() != 3 || !palette || !list)
        return "it is not a structure (that has size, palette and blocks)";
    ivec3 size(0);
    for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t edge = edges->children[std::size_t(axis)].integer;
        size[axis] = edge >= 0 && edge <= MAX_SCHEMATIC_EDGE ? int(edge) : MAX_SCHEMATIC_EDGE + 1;
    }
    if (Complaint complaint = check_size(size)) return complaint;
    const Result<std::vector<std::uint32_t>> states = read_palette(*palette, blocks);
    if (!states) return states.error().message;
    for (const nbt::Tag& block : list->children) {
        const nbt::Tag* position = block.find("pos", nbt::Type::list);
        const std::int64_t index = block.integer_of("state", -1);
        if (!position || position->children.size() != 3) return "a block has no position";
        if (index < 0 || std::size_t(index) >= states->size())
            return "a block refers to palette entry " + std::to_string(index) + " of " + std::to_string(states->size());
        ivec3 cell(0);
        for (int axis = 0; axis < 3; ++axis) {
            const std::int64_t at = position->children[std::size_t(axis)].integer;
            if (at < 0 || at >= size[axis]) return "a block lies outside of the structure's size";
            cell[axis] = int(at);
        }
        if (!blocks.place(cell, (*states)[std::size_t(index)])) return TOO_MANY;
    }
    return {};
}

}  // namespace

Result<Scene> load_sponge_schematic(const std::filesystem::path& path, const LoadOptions&) {
    return load_blocks(path, fill_sponge);
}
Result<Scene> load_mcedit_schematic(const std::filesystem::path& path, const LoadOptions&) {
    return load_blocks(path, fill_mcedit);
}
Result<Scene> load_litematic(const std::filesystem::path& path, const LoadOptions&) {
    return load_blocks(path, fill_litematic);
}
Result<Scene> load_structure(const std::filesystem::path& path, const LoadOptions&) {
    return load_blocks(path, fill_structure);
}

}  // namespace spinel
