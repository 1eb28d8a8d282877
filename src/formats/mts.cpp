#include "formats/mts.h"

#include <optional>

#include "formats/block_scene.h"
#include "formats/byte_reader.h"
#include "formats/file_bytes.h"
#include "formats/inflate.h"

namespace spinel {
namespace {

constexpr std::uintmax_t MAX_MTS_FILE = std::uintmax_t(1) << 28;
constexpr std::uint64_t MAX_NODES = std::uint64_t(1) << 28;

using Complaint = std::optional<std::string>;

// Layout: luanti's doc/schematic_file_format.md. Big-endian; nodes x fastest, then y, then z, which points north.
Complaint fill(std::string_view bytes, BlockScene& blocks) {
    ByteReader reader(bytes);
    if (reader.take(4) != "MTSM") return "it is not a schematic of Luanti (it does not begin with 'MTSM')";
    const int version = reader.u16_be();
    if (reader.ok() && (version < 1 || version > 4))
        return "its version is " + std::to_string(version) + ", readable are 1 to 4";
    ivec3 size;
    for (int axis = 0; axis < 3; ++axis) size[axis] = reader.u16_be();
    if (version >= 3) reader.take(std::size_t(size.y));  // probabilities of whole layers
    const int name_count = reader.u16_be();
    std::vector<std::uint32_t> states;
    for (int i = 0; i < name_count && reader.ok(); ++i)
        states.push_back(blocks.state(std::string(reader.take(reader.u16_be()))));
    if (!reader.ok()) return "the file ends in its header";
    const std::uint64_t nodes = std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(size.z);
    if (nodes == 0 || nodes > MAX_NODES) return "its " + std::to_string(nodes) + " nodes are none or more than allowed";

    // Names, then probabilities, then rotations.
    const Result<std::string> content = inflated(reader.take(reader.remaining()), std::size_t(nodes) * 4);
    if (!content) return content.error().message;
    if (content->size() < nodes * 4)
        return "its size needs " + std::to_string(nodes * 4) + " bytes of nodes, it has " +
               std::to_string(content->size());
    for (std::size_t i = 0; i < nodes; ++i) {
        const std::size_t name =
            std::size_t(std::uint8_t((*content)[2 * i])) << 8 | std::uint8_t((*content)[2 * i + 1]);
        if (name >= states.size())
            return "a node refers to name " + std::to_string(name) + " of " + std::to_string(states.size());
        const bool never = version >= 2 && ((*content)[2 * nodes + i] & (version >= 4 ? 0x7f : 0xff)) == 0;
        if (never) continue;
        const std::size_t x = std::size_t(size.x), y = std::size_t(size.y);
        // z turns round: ours points south.
        const ivec3 cell(int(i % x), int(i / x % y), size.z - 1 - int(i / x / y));
        if (!blocks.place(cell, states[name])) return "there are more nodes than allowed";
    }
    return {};
}

}  // namespace

Result<Scene> load_mts(const std::filesystem::path& path, const LoadOptions&) {
    const Result<std::string> bytes = read_file_bytes(path, MAX_MTS_FILE);
    if (!bytes) return bytes.error();
    BlockScene blocks;
    if (const Complaint complaint = fill(*bytes, blocks)) return cannot_read(path, *complaint);
    Result<Scene> scene = std::move(blocks).build(path.stem().string());
    if (!scene) return cannot_read(path, scene.error().message);
    return scene;
}

}  // namespace spinel
