#include "formats/npy.h"

#include <charconv>
#include <cstddef>
#include <cstring>
#include <map>
#include <optional>

#include "core/atomic_file.h"
#include "formats/byte_reader.h"
#include "formats/file_bytes.h"

namespace spinel {
namespace {

constexpr std::string_view NPY_MAGIC("\x93NUMPY", 6);
constexpr std::uintmax_t MAX_NPY_FILE = std::uintmax_t(1) << 36;

// The header is a Python dictionary with string keys. Splits it into its values' texts, brackets and quotes
// kept.
std::optional<std::map<std::string, std::string>> python_dictionary(std::string_view text) {
    std::map<std::string, std::string> result;
    std::size_t at = 0;
    const auto skip_spaces = [&] {
        while (at < text.size() && (text[at] == ' ' || text[at] == '\n')) ++at;
    };
    const auto take = [&](char c) {
        skip_spaces();
        if (at >= text.size() || text[at] != c) return false;
        ++at;
        return true;
    };
    if (!take('{')) return std::nullopt;
    while (!take('}')) {
        skip_spaces();
        if (at >= text.size() || (text[at] != '\'' && text[at] != '"')) return std::nullopt;
        const std::size_t key_end = text.find(text[at], at + 1);
        if (key_end == std::string_view::npos) return std::nullopt;
        const std::string key(text.substr(at + 1, key_end - at - 1));
        at = key_end + 1;
        if (!take(':')) return std::nullopt;
        skip_spaces();
        const std::size_t begin = at;
        int depth = 0;
        for (; at < text.size(); ++at) {
            if (text[at] == '(' || text[at] == '[') ++depth;
            if (text[at] == ')' || text[at] == ']') --depth;
            if (depth < 0) return std::nullopt;
            if (depth == 0 && (text[at] == ',' || text[at] == '}')) break;
        }
        if (at >= text.size()) return std::nullopt;
        std::size_t end = at;
        while (end > begin && text[end - 1] == ' ') --end;
        if (!result.emplace(key, text.substr(begin, end - begin)).second) return std::nullopt;
        if (text[at] == ',') ++at;
    }
    skip_spaces();
    return at == text.size() ? std::optional(result) : std::nullopt;
}

// "(100, 8)" or "(100,)"
std::optional<std::vector<std::uint64_t>> shape(std::string_view text) {
    if (text.size() < 2 || text.front() != '(' || text.back() != ')') return std::nullopt;
    text = text.substr(1, text.size() - 2);
    std::vector<std::uint64_t> result;
    const char* at = text.data();
    const char* end = at + text.size();
    while (at < end) {
        std::uint64_t edge = 0;
        const auto [next, error] = std::from_chars(at, end, edge);
        if (error != std::errc()) return std::nullopt;
        result.push_back(edge);
        at = next;
        if (at < end && *at != ',') return std::nullopt;
        if (at < end) ++at;
        while (at < end && *at == ' ') ++at;
    }
    return result;
}

}  // namespace

Result<std::vector<TraceRay>> read_rays_npy(const std::filesystem::path& path) {
    const Result<std::string> bytes = read_file_bytes(path, MAX_NPY_FILE);
    if (!bytes) return bytes.error();
    ByteReader reader(*bytes);
    if (reader.take(NPY_MAGIC.size()) != NPY_MAGIC) return cannot_read(path, "it is not a .npy file");
    const std::string_view version = reader.take(2);
    if (!reader.ok()) return cannot_read(path, "the file ends in its header");
    const int major = std::uint8_t(version[0]);
    if (major < 1 || major > 3)
        return cannot_read(path, "its format version is " + std::to_string(major) + ", readable are 1 … 3");
    std::size_t length = 0;
    if (major == 1) {
        const std::string_view two = reader.take(2);
        if (reader.ok()) length = std::size_t(std::uint8_t(two[0])) + 256 * std::size_t(std::uint8_t(two[1]));
    } else {
        length = reader.u32();
    }
    const std::string_view header = reader.take(length);
    if (!reader.ok()) return cannot_read(path, "the file ends in its header");
    const auto fields = python_dictionary(header);
    if (!fields || !fields->count("descr") || !fields->count("fortran_order") || !fields->count("shape"))
        return cannot_read(path, "its header is damaged");
    const std::string type = fields->at("descr");
    if (type != "'<f4'" && type != "\"<f4\"")
        return cannot_read(path, "rays must be little-endian float32 ('<f4'), found " + type.substr(0, 60));
    if (fields->at("fortran_order") != "False") return cannot_read(path, "rays must be in C order");
    const auto edges = shape(fields->at("shape"));
    if (!edges || edges->size() != 2 || (*edges)[1] != 8)
        return cannot_read(path, "rays must have the shape (N, 8), found " + fields->at("shape").substr(0, 60));
    const std::uint64_t count = (*edges)[0];
    if (count > MAX_NPY_FILE || count * sizeof(TraceRay) != reader.remaining())
        return cannot_read(path, "its " + std::to_string(count) + " rays need " +
                                     std::to_string(count > MAX_NPY_FILE ? 0 : count * sizeof(TraceRay)) +
                                     " bytes, the file has " + std::to_string(reader.remaining()));
    std::vector<TraceRay> rays{std::size_t(count)};
    const std::string_view data = reader.take(reader.remaining());
    if (count > 0) std::memcpy(rays.data(), data.data(), data.size());
    return rays;
}

Result<void> write_hits_npy(const std::filesystem::path& path, std::span<const TraceHit> hits) {
    static_assert(offsetof(TraceHit, t) == 0 && offsetof(TraceHit, instance) == 4 && offsetof(TraceHit, u) == 12 &&
                      offsetof(TraceHit, nx) == 20 && offsetof(TraceHit, ix) == 32 &&
                      offsetof(TraceHit, material) == 44 && sizeof(TraceHit) == 48,
                  "the fields below are the struct as it lies in memory");
    std::string header =
        "{'descr': [('t', '<f4'), ('instance', '<u4'), ('primitive', '<u4'), ('u', '<f4'), ('v', '<f4'), "
        "('nx', '<f4'), ('ny', '<f4'), ('nz', '<f4'), ('ix', '<i4'), ('iy', '<i4'), ('iz', '<i4'), "
        "('material', '<u4')], 'fortran_order': False, 'shape': (" +
        std::to_string(hits.size()) + ",), }";
    // Padded, so that the data begins at a multiple of 64.
    const std::size_t before = NPY_MAGIC.size() + 4;
    header.append(63 - (before + header.size()) % 64, ' ');
    header += '\n';
    std::string bytes(NPY_MAGIC);
    bytes += {'\x01', '\x00', char(header.size() & 255), char(header.size() >> 8)};
    bytes += header;
    bytes.append(reinterpret_cast<const char*>(hits.data()), hits.size_bytes());
    return write_file_atomically(path, bytes);
}

}  // namespace spinel
