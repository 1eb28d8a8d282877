#include "formats/anvil.h"

#include <optional>
#include <set>

#include "formats/block_scene.h"
#include "formats/block_states.h"
#include "formats/byte_reader.h"
#include "formats/file_bytes.h"
#include "formats/inflate.h"
#include "formats/nbt.h"

namespace spinel {
namespace {

constexpr std::uintmax_t MAX_ANVIL_FILE = std::uintmax_t(1) << 30;
constexpr std::size_t MAX_CHUNK = std::size_t(1) << 26;  // unpacked
constexpr std::size_t SECTOR = 4096;
constexpr std::size_t SECTION_BLOCKS = 16 * 16 * 16;
constexpr std::size_t SECTION_NIBBLES = SECTION_BLOCKS / 2;
constexpr int MAX_SECTION = 128;  // 2048 blocks above or below

ivec3 cell_of(std::size_t i) { return {int(i & 15), int(i >> 8), int(i >> 4 & 15)}; }

int nibble(std::string_view bytes, std::size_t i) {
    const auto byte = std::uint8_t(bytes[i / 2]);
    return i & 1 ? byte >> 4 : byte & 15;
}

class Region {
  public:
    explicit Region(std::string_view bytes) : bytes_(bytes) {}

    std::optional<std::string> read() {
        if (bytes_.size() < 2 * SECTOR)
            return "its " + std::to_string(bytes_.size()) + " bytes are less than the 8192 of a region's header";
        for (int chunk = 0; chunk < 1024; ++chunk) {
            auto complaint = read_chunk(chunk);
            if (complaint)
                return "chunk (" + std::to_string(chunk % 32) + ", " + std::to_string(chunk / 32) + "): " + *complaint;
        }
        return {};
    }
    BlockScene& scene() { return scene_; }
    int external_count() const { return external_count_; }
    int chunk_count() const { return chunk_count_; }

  private:
    using Complaint = std::optional<std::string>;

    Complaint read_chunk(int chunk) {
        const std::uint32_t location = ByteReader(bytes_.substr(std::size_t(chunk) * 4, 4)).u32_be();
        const std::size_t start = std::size_t(location >> 8) * SECTOR;
        if (location == 0) return {};
        if (start < 2 * SECTOR || start + 5 > bytes_.size()) return "it lies outside of the file";
        // A small file could otherwise be unpacked a thousand times.
        if (!taken_.insert(start).second) return "it lies where another one does";
        ByteReader reader(bytes_.substr(start));
        const std::uint32_t length = reader.u32_be();
        const std::uint8_t packing = reader.u8();
        if (packing & 0x80) {  // too large for a region: a file of its own
            ++external_count_;
            return {};
        }
        if (length < 1 || length - 1 > reader.remaining())
            return "it announces " + std::to_string(length) + " bytes, " + std::to_string(reader.remaining() + 1) +
                   " are left";
        const std::string_view packed = reader.take(length - 1);
        Result<std::string> plain = packing == 1 || packing == 2 ? inflated(packed, MAX_CHUNK)
                                    : packing == 3               ? Result<std::string>(std::string(packed))
                                    : packing == 4
                                        ? lz4_unpacked(packed, MAX_CHUNK)
                                        : Error{"its packing " + std::to_string(packing) +
                                                " is unknown; readable are 1 (gzip), 2 (zlib), 3 (none) and 4 (LZ4)"};
        if (!plain) return plain.error().message;
        const Result<nbt::Document> document = nbt::parse(std::move(*plain));
        if (!document) return document.error().message;
        ++chunk_count_;

        const nbt::Tag* level = document->root.find("Level", nbt::Type::compound);
        const nbt::Tag& root = level ? *level : document->root;
        const nbt::Tag* sections = root.find("sections", nbt::Type::list);
        if (!sections) sections = root.find("Sections", nbt::Type::list);
        if (!sections) return {};  // not generated yet
        const ivec3 origin = 16 * ivec3(chunk % 32, 0, chunk / 32);
        for (const nbt::Tag& section : sections->children) {
            const std::int64_t y = section.integer_of("Y", 0);
            if (y < -MAX_SECTION || y >= MAX_SECTION) continue;
            if (Complaint complaint = read_section(section, origin + ivec3(0, 16 * int(y), 0)))
                return "section " + std::to_string(int(y)) + ": " + *complaint;
        }
        return {};
    }

    Complaint read_section(const nbt::Tag& section, ivec3 origin) {
        if (const nbt::Tag* blocks = section.find("Blocks", nbt::Type::int8_array))
            return read_numeric(section, blocks->bytes, origin);
        // Since 1.18 both stand in a compound of their own.
        const nbt::Tag* states = section.find("block_states", nbt::Type::compound);
        const nbt::Tag* palette =
            states ? states->find("palette", nbt::Type::list) : section.find("Palette", nbt::Type::list);
        const nbt::Tag* data =
            states ? states->find("data", nbt::Type::int64_array) : section.find("BlockStates", nbt::Type::int64_array);
        if (!palette || palette->children.empty()) return {};  // light alone
        return read_states(*palette, data, origin);
    }

    Complaint read_numeric(const nbt::Tag& section, std::string_view blocks, ivec3 origin) {
        const nbt::Tag* data = section.find("Data", nbt::Type::int8_array);
        const nbt::Tag* add = section.find("Add", nbt::Type::int8_array);  // bits 8 … 11 of the ids
        if (blocks.size() != SECTION_BLOCKS || (data && data->bytes.size() != SECTION_NIBBLES) ||
            (add && add->bytes.size() != SECTION_NIBBLES))
            return "its arrays of blocks do not have 4096 entries";
        for (std::size_t i = 0; i < SECTION_BLOCKS; ++i) {
            const int id = std::uint8_t(blocks[i]) | (add ? nibble(add->bytes, i) << 8 : 0);
            if (id == 0) continue;
            if (!scene_.place(origin + cell_of(i), scene_.legacy_state(id, data ? nibble(data->bytes, i) : 0)))
                return "there are more blocks than allowed";
        }
        return {};
    }

    Complaint read_states(const nbt::Tag& palette, const nbt::Tag* data, ivec3 origin) {
        const Result<std::vector<std::uint32_t>> states = read_palette(palette, scene_);
        if (!states) return states.error().message;
        const auto place = [&](std::size_t i, std::size_t index) -> Complaint {
            if (index >= states->size())
                return "a block refers to palette entry " + std::to_string(index) + " of " +
                       std::to_string(states->size());
            if (!scene_.place(origin + cell_of(i), (*states)[index])) return "there are more blocks than allowed";
            return {};
        };
        if (!data) {  // all of the first
            if (states->size() > 1) return "it has a palette, but no blocks";
            if (scene_.is_nothing(states->front())) return {};
            for (std::size_t i = 0; i < SECTION_BLOCKS; ++i)
                if (Complaint complaint = place(i, 0)) return complaint;
            return {};
        }
        // Since 1.16 no index spans two words; the length of the array tells which it is.
        const int bits = bits_for(states->size(), 4);
        const bool spanning = data->count() == PackedIndices::words_for(SECTION_BLOCKS, bits, true);
        if (!spanning && data->count() != PackedIndices::words_for(SECTION_BLOCKS, bits, false))
            return "its " + std::to_string(data->count()) + " words do not hold 4096 indices of " +
                   std::to_string(bits) + " bits";
        const PackedIndices indices(*data, bits, spanning);
        for (std::size_t i = 0; i < SECTION_BLOCKS; ++i)
            if (Complaint complaint = place(i, indices[i])) return complaint;
        return {};
    }

    std::string_view bytes_;
    BlockScene scene_;
    std::set<std::size_t> taken_;  // where chunks begin
    int external_count_ = 0;
    int chunk_count_ = 0;
};

}  // namespace

Result<Scene> load_anvil(const std::filesystem::path& path, const LoadOptions&) {
    const Result<std::string> bytes = read_file_bytes(path, MAX_ANVIL_FILE);
    if (!bytes) return bytes.error();
    Region region(*bytes);
    if (const auto complaint = region.read()) return cannot_read(path, *complaint);
    if (region.chunk_count() == 0) return cannot_read(path, "it holds no chunk");
    Result<Scene> scene = std::move(region.scene()).build(path.stem().string());
    if (!scene) return cannot_read(path, scene.error().message);
    if (region.external_count() > 0)
        scene->notes.push_back(std::to_string(region.external_count()) +
                               " chunks stand in files of their own (.mcc) and are left out");
    return scene;
}

}  // namespace spinel
