#include "formats/raw_volume.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include "core/atomic_file.h"
#include "formats/byte_reader.h"
#include "formats/file_bytes.h"
#include "formats/left_out.h"
#include "formats/volume_scene.h"

namespace spinel {
namespace {

constexpr int MAX_RAW_EDGE = 8192;
constexpr std::uint64_t MAX_VALUES = std::uint64_t(1) << 31;
constexpr std::size_t MAX_RAW_HEADER = 4096;

struct RawHeader {
    ivec3 size = {0, 0, 0};
    std::string type;
    vec3 spacing = {1, 1, 1};
    vec3 origin = {0, 0, 0};
    Filter filter = Filter::linear;
};

mat4x3 axis_aligned(vec3 spacing, vec3 origin) {
    return {vec3(spacing.x, 0, 0), vec3(0, spacing.y, 0), vec3(0, 0, spacing.z), origin};
}

// All of `text` as `count` numbers.
template <class T>
std::optional<std::vector<T>> numbers(std::string_view text, std::size_t count) {
    std::vector<T> result;
    const char* at = text.data();
    const char* end = at + text.size();
    while (true) {
        while (at < end && (*at == ' ' || *at == '\t')) ++at;
        if (at == end) break;
        T value{};
        const auto [next, error] = std::from_chars(at, end, value);
        if (error != std::errc() || (next < end && *next != ' ' && *next != '\t')) return std::nullopt;
        result.push_back(value);
        at = next;
    }
    return result.size() == count ? std::optional(result) : std::nullopt;
}

bool usable(vec3 v, bool positive) {
    for (int axis = 0; axis < 3; ++axis) {
        if (!std::isfinite(v[axis]) || std::abs(v[axis]) > 1e12f) return false;
        if (positive && !(v[axis] >= 1e-12f)) return false;
    }
    return true;
}

// One line of the header; the complaint, if there is one.
std::optional<std::string> read_line(const std::string& key, std::string_view rest, RawHeader& header) {
    const std::string shown = "'" + std::string(rest) + "'";
    if (key == "size") {
        const auto size = numbers<int>(rest, 3);
        if (!size) return "size needs three whole numbers, found " + shown;
        for (const int edge : *size)
            if (edge < 1 || edge > MAX_RAW_EDGE)
                return "an edge must be 1 … " + std::to_string(MAX_RAW_EDGE) + ", found " + shown;
        header.size = {(*size)[0], (*size)[1], (*size)[2]};
    } else if (key == "type") {
        if (rest != "u8" && rest != "u16" && rest != "f32") return "type must be u8, u16 or f32, found " + shown;
        header.type = rest;
    } else if (key == "spacing" || key == "origin") {
        const auto values = numbers<float>(rest, 3);
        const bool positive = key == "spacing";
        if (!values || !usable({(*values)[0], (*values)[1], (*values)[2]}, positive))
            return key + " needs three " + (positive ? "positive " : "") + "numbers, found " + shown;
        (positive ? header.spacing : header.origin) = {(*values)[0], (*values)[1], (*values)[2]};
    } else if (key == "filter") {
        if (rest != "linear" && rest != "nearest") return "filter must be linear or nearest, found " + shown;
        header.filter = rest == "linear" ? Filter::linear : Filter::nearest;
    } else {
        return "unknown key '" + key + "'; known: size, type, spacing, origin, filter";
    }
    return std::nullopt;
}

// Reads up to the empty line, where the stream then stands.
Result<RawHeader> read_raw_header(const std::filesystem::path& path, std::istream& file) {
    RawHeader header;
    std::string block(MAX_RAW_HEADER, '\0');
    file.read(block.data(), std::streamsize(MAX_RAW_HEADER));
    block.resize(std::size_t(file.gcount()));
    std::set<std::string> seen;
    std::size_t at = 0;
    for (int number = 1;; ++number) {
        const std::size_t end = block.find('\n', at);
        if (end == std::string::npos)
            return cannot_read(path, number == 1 ? "it does not begin with 'spinel volume 1'"
                                                 : "line " + std::to_string(number) + ": the header has no end");
        std::string line = block.substr(at, end - at);
        if (!line.empty() && line.back() == '\r') line.pop_back();
        at = end + 1;
        if (number == 1) {
            if (line != "spinel volume 1") return cannot_read(path, "it does not begin with 'spinel volume 1'");
            continue;
        }
        if (line.empty()) break;
        const std::string key = line.substr(0, line.find(' '));
        const std::string rest = key.size() < line.size() ? line.substr(key.size() + 1) : std::string();
        auto complaint = read_line(key, rest, header);
        if (!complaint && !seen.insert(key).second) complaint = "'" + key + "' is given twice";
        if (complaint) return cannot_read(path, "line " + std::to_string(number) + ": " + *complaint);
    }
    for (const char* key : {"size", "type"})
        if (!seen.count(key)) return cannot_read(path, std::string("its header gives no ") + key);
    file.clear();
    file.seekg(std::streamoff(at));
    return header;
}

template <class T>
std::vector<float> normalised(const std::string& bytes, std::size_t count) {
    std::vector<float> values(count);
    for (std::size_t i = 0; i < count; ++i) {
        T value;
        std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
        values[i] = std::is_integral_v<T> ? float(value) / float(std::numeric_limits<T>::max()) : float(value);
    }
    return values;
}

std::string stem(const std::filesystem::path& path) { return path.stem().string(); }

}  // namespace

Result<Scene> load_bits(const std::filesystem::path& path, const LoadOptions&) {
    constexpr int edge = 32;
    const Result<std::string> bytes = read_file_bytes(path, std::uintmax_t(1) << 32);
    if (!bytes) return bytes.error();
    if (bytes->size() != edge * edge * 4)
        return cannot_read(path, "a bit volume has 4096 bytes, this file has " + std::to_string(bytes->size()));
    std::vector<float> values(edge * edge * edge);
    Grid grid;
    grid.name = stem(path);
    grid.index_to_local = axis_aligned(vec3(1.0f / edge), vec3(0.0f));
    ByteReader reader(*bytes);
    for (int z = 0; z < edge; ++z) {
        for (int x = 0; x < edge; ++x) {
            const std::uint32_t column = reader.u32();
            for (int y = 0; y < edge; ++y)
                values[std::size_t(x) + edge * (std::size_t(y) + edge * std::size_t(z))] =
                    (column >> y) & 1u ? 1.0f : 0.0f;
        }
    }
    Result<GridPointer> samples = build_grid({edge, edge, edge}, values);
    if (!samples) return cannot_read(path, "it " + samples.error().message);
    grid.samples = *samples;
    return volume_scene({std::move(grid)});
}

Result<Scene> load_svol(const std::filesystem::path& path, const LoadOptions&) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return cannot_read(path, "there is no such file");
    std::ifstream file(path, std::ios::binary);
    if (!file) return cannot_read(path, "the file cannot be opened");
    const Result<RawHeader> header = read_raw_header(path, file);
    if (!header) return header.error();

    // The size is believed only once the file has as many bytes.
    const std::uint64_t count =
        std::uint64_t(header->size.x) * std::uint64_t(header->size.y) * std::uint64_t(header->size.z);
    if (count > MAX_VALUES)
        return cannot_read(path, "its " + std::to_string(count) + " samples are more than the " +
                                     std::to_string(MAX_VALUES) + " allowed");
    const std::uint64_t wanted = count * (header->type == "u8" ? 1 : header->type == "u16" ? 2 : 4);
    const std::uint64_t there = std::filesystem::file_size(path, error) - std::uint64_t(file.tellg());
    if (error || there != wanted)
        return cannot_read(path, "its size needs " + std::to_string(wanted) + " bytes of samples, the file has " +
                                     std::to_string(there));
    std::string bytes(std::size_t(wanted), '\0');
    if (!file.read(bytes.data(), std::streamsize(wanted))) return cannot_read(path, "the file ended early");

    const std::vector<float> values = header->type == "u8"    ? normalised<std::uint8_t>(bytes, std::size_t(count))
                                      : header->type == "u16" ? normalised<std::uint16_t>(bytes, std::size_t(count))
                                                              : normalised<float>(bytes, std::size_t(count));
    Grid grid;
    grid.name = stem(path);
    grid.filter = header->filter;
    grid.index_to_local = axis_aligned(header->spacing, header->origin);
    Result<GridPointer> samples = build_grid(header->size, values);
    if (!samples) return cannot_read(path, "it " + samples.error().message);
    grid.samples = *samples;
    return volume_scene({std::move(grid)});
}

Result<Notes> save_svol(const Scene& scene, const std::filesystem::path& path) {
    const auto cannot_write = [&](const std::string& why) {
        return Error{"cannot write '" + path.string() + "': " + why};
    };
    if (scene.grids.size() != 1)
        return cannot_write("the scene has " + std::to_string(scene.grids.size()) + " grids, the file holds one");
    const Grid& grid = scene.grids[0];
    const vec3 spacing(grid.index_to_local[0].x, grid.index_to_local[1].y, grid.index_to_local[2].z);
    const vec3 origin = grid.index_to_local[3];
    if (grid.samples->channels() != 1) return cannot_write("the grid holds vectors, the file holds numbers");
    if (grid.filter == Filter::cubic)
        return cannot_write("the grid's look-up is cubic, the file knows linear and nearest");
    if (grid.index_to_local != axis_aligned(spacing, origin) || !usable(spacing, true) || !usable(origin, false))
        return cannot_write("the grid is not aligned with its axes");
    std::ostringstream header;
    header.precision(9);  // enough for every float
    const ivec3 size = grid.samples->size();
    header << "spinel volume 1\nsize " << size.x << ' ' << size.y << ' ' << size.z << "\ntype f32\nspacing "
           << spacing.x << ' ' << spacing.y << ' ' << spacing.z << "\norigin " << origin.x << ' ' << origin.y << ' '
           << origin.z << "\nfilter " << (grid.filter == Filter::linear ? "linear" : "nearest") << "\n\n";
    std::string bytes = header.str();
    const std::vector<float> values = grid.samples->dense();
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    if (Result<void> written = write_file_atomically(path, bytes); !written) return written.error();
    LeftOut left_out;
    left_out.add_light_and_cameras(scene);
    return left_out.notes();
}

}  // namespace spinel
