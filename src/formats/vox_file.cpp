#include "formats/vox_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "formats/byte_reader.h"
#include "formats/file_bytes.h"

namespace spinel::vox {
namespace {

constexpr std::uintmax_t MAX_VOX_FILE = std::uintmax_t(1) << 32;
constexpr int MAX_VOX_EDGE = 2048;
constexpr int MAX_FRAMES = 1 << 20;
// What a writer that does not go back to fill it in leaves as the size of MAIN: all chunks to the file's end.
constexpr std::uint32_t SIZE_UNKNOWN = 0x7fffff;

// The text of an error without the name of the file; empty: none.
using Complaint = std::optional<std::string>;

std::string at_byte(std::size_t offset) { return "byte " + std::to_string(offset) + ": "; }

Dictionary read_dictionary(ByteReader& reader) {
    Dictionary dictionary;
    const std::uint32_t count = reader.u32();
    for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
        const std::string key(reader.take(reader.u32()));
        dictionary[key] = std::string(reader.take(reader.u32()));
    }
    return dictionary;
}

// Three integers separated by spaces, within what floats hold exactly.
std::optional<vec3> parse_translation(const std::string& text) {
    vec3 result(0.0f);
    const char* at = text.data();
    const char* end = at + text.size();
    for (int axis = 0; axis < 3; ++axis) {
        while (at < end && *at == ' ') ++at;
        int value = 0;
        const auto [next, error] = std::from_chars(at, end, value);
        if (error != std::errc() || std::abs(long(value)) > (1L << 24)) return std::nullopt;
        result[axis] = float(value);
        at = next;
    }
    return at == end ? std::optional(result) : std::nullopt;
}

// Bits 0–1 and 2–3 give the column of the entry that is not zero in the first and second row, bits 4–6 the
// rows' signs.
std::optional<mat3> parse_rotation(const std::string& text) {
    int bits = 0;
    const auto [next, error] = std::from_chars(text.data(), text.data() + text.size(), bits);
    if (error != std::errc() || next != text.data() + text.size() || bits < 0 || bits > 127) return std::nullopt;
    const int columns[3] = {bits & 3, (bits >> 2) & 3, 3 - (bits & 3) - ((bits >> 2) & 3)};
    if (columns[0] == columns[1] || columns[0] == 3 || columns[1] == 3) return std::nullopt;
    mat3 rotation(0.0f);
    for (int row = 0; row < 3; ++row) rotation[columns[row]][row] = (bits >> (4 + row)) & 1 ? -1.0f : 1.0f;
    return rotation;
}

class Parser {
  public:
    Parser(File& file, int frame) : file_(file), frame_(frame) { file_.palette = default_palette(); }

    Complaint parse() {
        ByteReader reader(file_.bytes);
        if (reader.take(4) != "VOX ") return "it is not a MagicaVoxel file (it does not begin with 'VOX ')";
        const std::int32_t version = reader.i32();
        if (!reader.ok()) return at_byte(reader.offset()) + "the file ends in its header";
        if (version != 150 && version != 200)
            return "its version is " + std::to_string(version) + ", readable are 150 and 200";
        if (reader.take(4) != "MAIN") return at_byte(8) + "there is no MAIN chunk";
        const std::uint32_t content = reader.u32();
        std::uint32_t children = reader.u32();
        reader.take(content);
        if (reader.ok() && children == SIZE_UNKNOWN) children = std::uint32_t(reader.remaining());
        if (!reader.ok() || children > reader.remaining())
            return at_byte(12) + "MAIN announces " + std::to_string(children) + " bytes of chunks, the file has " +
                   std::to_string(reader.remaining());
        const std::size_t origin = reader.offset();
        ByteReader chunks(reader.take(children), origin);
        while (chunks.remaining() > 0) {
            if (Complaint complaint = read_chunk(chunks)) return complaint;
        }
        if (size_) return "its last SIZE chunk has no XYZI chunk";
        if (file_.models.empty()) return "it holds no model";
        if (file_.nodes.empty()) file_.frame_count = int(file_.models.size());
        if (frame_ < 0 || frame_ >= file_.frame_count)
            return "there is no frame " + std::to_string(frame_) + "; its frames are 0 … " +
                   std::to_string(file_.frame_count - 1);
        return {};
    }

  private:
    Complaint read_chunk(ByteReader& chunks) {
        const std::size_t start = chunks.offset();
        const std::string id(chunks.take(4));
        const std::uint32_t content_size = chunks.u32(), children_size = chunks.u32();
        if (!chunks.ok()) return at_byte(start) + "the file ends in the head of a chunk";
        const std::size_t content_start = chunks.offset(), left = chunks.remaining();
        ByteReader content(chunks.take(content_size), content_start);
        chunks.take(children_size);  // only MAIN has children
        if (!chunks.ok())
            return at_byte(start) + "chunk " + quoted(id) + " announces " +
                   std::to_string(std::uint64_t(content_size) + children_size) + " bytes, " + std::to_string(left) +
                   " are left";
        Complaint complaint;
        if (id == "SIZE") complaint = read_size(content);
        if (id == "XYZI") complaint = read_voxels(content);
        if (id == "RGBA") read_palette(content);
        if (id == "MATL") read_material(content);
        if (id == "MATT") read_legacy_material(content);
        if (id == "LAYR") read_layer(content);
        if (id == "rOBJ") read_setting(content);
        if (id == "rCAM") read_camera(content);
        if (id == "nTRN" || id == "nGRP" || id == "nSHP") complaint = read_node(id, content, start);
        if (complaint) return at_byte(start) + *complaint;
        if (!content.ok()) return at_byte(start) + "chunk " + quoted(id) + " is too short for what it says it holds";
        return {};
    }

    // Printable, whatever the bytes.
    static std::string quoted(std::string id) {
        for (char& c : id)
            if (c < 32 || c > 126) c = '?';
        return "'" + id + "'";
    }

    Complaint read_size(ByteReader& content) {
        if (size_) return "two SIZE chunks follow each other without XYZI";
        const int x = content.i32(), y = content.i32(), z = content.i32();
        if (!content.ok()) return {};
        for (const int edge : {x, y, z}) {
            if (edge < 0 || edge > MAX_VOX_EDGE)
                return "a model's edge is " + std::to_string(edge) + " voxels, at most " +
                       std::to_string(MAX_VOX_EDGE) + " are allowed";
        }
        size_ = ivec3(x, y, z);
        return {};
    }

    Complaint read_voxels(ByteReader& content) {
        if (!size_) return "an XYZI chunk stands without a SIZE chunk before it";
        const ivec3 size = *size_;
        size_.reset();
        const std::uint32_t count = content.u32();
        if (count > content.remaining() / 4) {
            return "a model announces " + std::to_string(count) + " voxels, its chunk has room for " +
                   std::to_string(content.remaining() / 4);
        }
        const std::string_view voxels = content.take(std::size_t(count) * 4);
        for (std::size_t i = 0; i < voxels.size(); i += 4) {
            // Braces: clang reads parentheses here as the declaration of a function.
            const ivec3 cell = {std::uint8_t(voxels[i]), std::uint8_t(voxels[i + 1]), std::uint8_t(voxels[i + 2])};
            if (cell.x >= size.x || cell.y >= size.y || cell.z >= size.z)
                return "voxel (" + text(cell) + ") lies outside its model of (" + text(size) + ")";
        }
        file_.models.push_back({size, voxels});
        return {};
    }

    static std::string text(ivec3 v) {
        return std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z);
    }

    // Entry i of the file colours palette index i + 1; the last entry is not used.
    void read_palette(ByteReader& content) {
        const std::string_view bytes = content.take(1024);
        if (!content.ok()) return;
        for (std::size_t i = 1; i < 256; ++i)
            for (std::size_t c = 0; c < 4; ++c) file_.palette[i][c] = std::uint8_t(bytes[(i - 1) * 4 + c]);
    }

    void read_material(ByteReader& content) {
        const int index = content.i32();
        file_.properties[index] = read_dictionary(content);
    }

    // Of version 0.98 and before: a type, a weight, and one float for each property bit. Told in the later
    // words.
    void read_legacy_material(ByteReader& content) {
        static const char* const types[] = {"_diffuse", "_metal", "_glass", "_emit"};
        static const char* const names[] = {"_plastic", "_rough", "_spec", "_ior", "_att", "_flux", "_glow"};
        const int index = content.i32(), type = content.i32();
        const float weight = content.f32();
        const std::uint32_t bits = content.u32();
        Dictionary& properties = file_.properties[index];
        if (type >= 0 && type < 4) properties["_type"] = types[type];
        properties["_weight"] = std::to_string(weight);
        for (int bit = 0; bit < 7; ++bit)
            if ((bits >> bit) & 1u) properties[names[bit]] = std::to_string(content.f32());
    }

    void read_layer(ByteReader& content) {
        const int layer = content.i32();
        if (word(read_dictionary(content), "_hidden") == "1") file_.hidden_layers.insert(layer);
    }

    void read_setting(ByteReader& content) {
        Dictionary setting = read_dictionary(content);
        const std::string type = word(setting, "_type");
        file_.settings[type] = std::move(setting);
    }

    void read_camera(ByteReader& content) {
        content.i32();  // its number
        file_.cameras.push_back(read_dictionary(content));
    }

    // Keeps count of the frames, and says whether the key of `attributes`, the `i`-th of its node, holds at the frame
    // that is read. Keys stand in order; the first holds before its time as well.
    bool key_holds(const Dictionary& attributes, std::uint32_t i) {
        const float at = std::clamp(number(attributes, "_f", 0.0f), 0.0f, float(MAX_FRAMES));
        file_.frame_count = std::max(file_.frame_count, int(at) + 1);
        return i == 0 || int(at) <= frame_;
    }

    Complaint read_node(const std::string& id, ByteReader& content, std::size_t start) {
        Node node;
        node.offset = start;
        const int index = content.i32();
        const Dictionary attributes = read_dictionary(content);
        node.name = word(attributes, "_name");
        node.hidden = word(attributes, "_hidden") == "1";
        if (id == "nTRN") {
            node.kind = Node::Kind::transform;
            node.children.push_back(content.i32());
            content.i32();  // reserved
            node.layer = content.i32();
            const std::uint32_t key_count = content.u32();
            for (std::uint32_t i = 0; i < key_count && content.ok(); ++i) {
                const Dictionary key = read_dictionary(content);
                if (!key_holds(key, i)) continue;
                node.translation = vec3(0);
                node.rotation = mat3(1);
                if (key.count("_t")) {
                    const auto translation = parse_translation(key.at("_t"));
                    if (!translation) return "the translation '" + key.at("_t") + "' is not three integers";
                    node.translation = *translation;
                }
                if (key.count("_r")) {
                    const auto rotation = parse_rotation(key.at("_r"));
                    if (!rotation) return "the rotation '" + key.at("_r") + "' is not one";
                    node.rotation = *rotation;
                }
            }
        } else {
            node.kind = id == "nGRP" ? Node::Kind::group : Node::Kind::shape;
            const std::uint32_t count = content.u32();
            if (count > content.remaining() / 4) return "a node announces " + std::to_string(count) + " children";
            for (std::uint32_t i = 0; i < count && content.ok(); ++i) {
                const int child = content.i32();
                if (node.kind == Node::Kind::group) node.children.push_back(child);
                else if (key_holds(read_dictionary(content), i)) node.children = {child};
            }
        }
        if (!file_.nodes.emplace(index, std::move(node)).second) return "there are two nodes " + std::to_string(index);
        return {};
    }

    File& file_;
    int frame_;
    std::optional<ivec3> size_;  // of the SIZE chunk that waits for its XYZI
};

}  // namespace

std::string word(const Dictionary& dictionary, const std::string& key) {
    const auto found = dictionary.find(key);
    return found == dictionary.end() ? std::string() : found->second;
}

float number(const Dictionary& dictionary, const std::string& key, float otherwise) {
    const std::string text = word(dictionary, key);
    float value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && !text.empty() && std::isfinite(value) ? value : otherwise;
}

std::optional<vec3> triple(const Dictionary& dictionary, const std::string& key) {
    const std::string text = word(dictionary, key);
    vec3 result(0.0f);
    const char* at = text.data();
    const char* end = at + text.size();
    for (int axis = 0; axis < 3; ++axis) {
        while (at < end && *at == ' ') ++at;
        const auto [next, error] = std::from_chars(at, end, result[axis]);
        if (error != std::errc() || !std::isfinite(result[axis])) return std::nullopt;
        at = next;
    }
    return result;
}

std::array<std::array<std::uint8_t, 4>, 256> default_palette() {
    std::array<std::array<std::uint8_t, 4>, 256> palette{};
    std::size_t i = 1;
    for (int red = 5; red >= 0; --red)
        for (int green = 5; green >= 0; --green)
            for (int blue = 5; blue >= 0; --blue)
                if (red + green + blue > 0)
                    palette[i++] = {std::uint8_t(red * 0x33), std::uint8_t(green * 0x33), std::uint8_t(blue * 0x33),
                                    255};
    for (const int channels : {1, 2, 4, 7}) {  // bits: red, green, blue; then all three
        for (const std::uint8_t level : {0xee, 0xdd, 0xbb, 0xaa, 0x88, 0x77, 0x55, 0x44, 0x22, 0x11}) {
            for (int c = 0; c < 3; ++c) palette[i][std::size_t(c)] = (channels >> c) & 1 ? level : std::uint8_t(0);
            palette[i++][3] = 255;
        }
    }
    return palette;
}

Result<File> read(const std::filesystem::path& path, int frame) {
    Result<std::string> bytes = read_file_bytes(path, MAX_VOX_FILE);
    if (!bytes) return bytes.error();
    File file;  // a file with a model is longer than any small-string buffer, so that the views survive its
                // moves
    file.bytes = std::move(*bytes);
    if (Complaint complaint = Parser(file, frame).parse()) return cannot_read(path, *complaint);
    return file;
}

}  // namespace spinel::vox
