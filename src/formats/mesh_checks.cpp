#include "formats/mesh_checks.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

#include "formats/file_bytes.h"

namespace spinel {
namespace {

struct PlyProperty {
    unsigned size = 0;        // of a value, bytes
    unsigned count_size = 0;  // of a list's count; 0: no list
};
struct PlyElement {
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
    bool has_list() const {
        return std::any_of(properties.begin(), properties.end(), [](const PlyProperty& p) { return p.count_size > 0; });
    }
    std::uint64_t least_bytes(bool binary) const {
        std::uint64_t bytes = 0;
        for (const PlyProperty& p : properties) bytes += !binary ? 2 : p.count_size > 0 ? p.count_size : p.size;
        return bytes;
    }
};

// 0: no type of the format; `whole` of integers.
unsigned ply_size(std::string_view type, bool& whole) {
    struct Type {
        const char* name;
        unsigned size;
        bool whole;
    };
    static constexpr Type types[] = {
        {"char", 1, true},   {"int8", 1, true},     {"uchar", 1, true},   {"uint8", 1, true},
        {"short", 2, true},  {"int16", 2, true},    {"ushort", 2, true},  {"uint16", 2, true},
        {"int", 4, true},    {"int32", 4, true},    {"uint", 4, true},    {"uint32", 4, true},
        {"float", 4, false}, {"float32", 4, false}, {"double", 8, false}, {"float64", 8, false}};
    for (const Type& t : types) {
        if (type != t.name) continue;
        whole = t.whole;
        return t.size;
    }
    return 0;
}

// The header's elements; an error's text is what is wrong with it.
struct PlyHeader {
    bool binary = false, big_endian = false;
    std::vector<PlyElement> elements;
    std::string fault;
};

PlyHeader read_ply_header(std::string_view bytes, std::size_t& at) {
    static constexpr std::size_t MAX_LINES = 10000;
    PlyHeader header;
    const auto failed = [&](const std::string& why) {
        header.fault = why;
        return header;
    };
    for (std::size_t i = 0; i < MAX_LINES && at < bytes.size(); ++i) {
        const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
        std::istringstream line(std::string(bytes.substr(at, std::min<std::size_t>(end - at, 4096))));
        at = std::min(end + 1, bytes.size());
        std::string word, type, name;
        line >> word;
        if (i == 0 && word != "ply") break;
        if (word == "end_header") return header;
        if (word == "format") {
            line >> type;
            header.binary = type != "ascii";
            header.big_endian = type == "binary_big_endian";
        } else if (word == "element") {
            long long count = -1;
            line >> name >> count;
            if (count < 0) return failed("its PLY header gives element '" + name + "' no count that is a whole number");
            header.elements.push_back({std::uint64_t(count), {}});
        } else if (word == "property") {
            PlyProperty property;
            bool whole = true;
            line >> type;
            if (type == "list") {
                line >> type;
                property.count_size = ply_size(type, whole);
                if (property.count_size == 0 || !whole)
                    return failed("its PLY header counts a list in '" + type + "', which is no whole number");
                line >> type;
            }
            property.size = ply_size(type, whole);
            if (property.size == 0) return failed("its PLY header has a property of the unknown type '" + type + "'");
            if (header.elements.empty()) break;
            header.elements.back().properties.push_back(property);
        } else if (i > 0 && word != "comment" && word != "obj_info" && !word.empty()) {
            break;
        }
    }
    return failed("its PLY header is damaged");
}

std::uint64_t list_count(const char* at, unsigned size, bool big_endian) {
    std::uint64_t count = 0;
    for (unsigned i = 0; i < size; ++i)
        count |= std::uint64_t(std::uint8_t(at[i])) << 8 * (big_endian ? size - 1 - i : i);
    return count;
}

// Whether every list of a binary element fits; `at` moves behind the element.
bool walk_binary(const PlyElement& element, bool big_endian, std::string_view bytes, std::size_t& at) {
    if (!element.has_list()) {
        at += element.count * element.least_bytes(true);
        return at <= bytes.size();
    }
    for (std::uint64_t i = 0; i < element.count; ++i) {
        for (const PlyProperty& p : element.properties) {
            std::uint64_t values = 1;
            if (p.count_size > 0) {
                if (bytes.size() - at < p.count_size) return false;
                values = list_count(bytes.data() + at, p.count_size, big_endian);
                at += p.count_size;
            }
            if (values > (bytes.size() - at) / p.size) return false;
            at += values * p.size;
        }
    }
    return true;
}

// The same of an element in text. What is no number is left to the parser; a count takes digits alone.
bool walk_text(const PlyElement& element, std::string_view bytes, std::size_t& at) {
    const auto skip_word = [&] {
        while (at < bytes.size() && std::strchr(" \t\r\n", bytes[at])) ++at;
        const std::size_t first = at;
        while (at < bytes.size() && !std::strchr(" \t\r\n", bytes[at])) ++at;
        return bytes.substr(first, at - first);
    };
    for (std::uint64_t i = 0; i < element.count; ++i) {
        if (at >= bytes.size()) return true;  // ends early: the parser says so
        for (const PlyProperty& p : element.properties) {
            std::uint64_t values = 1;
            if (p.count_size > 0) {
                values = 0;
                for (const char digit : skip_word()) {
                    if (digit < '0' || digit > '9') return false;
                    values = values * 10 + std::uint64_t(digit - '0');
                    if (values > bytes.size()) return false;
                }
            }
            if (values > bytes.size() - at) return false;
            for (std::uint64_t k = 0; k < values; ++k) skip_word();
        }
    }
    return true;
}

}  // namespace

Result<void> check_ply(const std::filesystem::path& path) {
    const Result<std::string> bytes = read_file_bytes(path, MAX_MESH_FILE);
    if (!bytes) return bytes.error();
    std::size_t at = 0;
    const PlyHeader header = read_ply_header(*bytes, at);
    if (!header.fault.empty()) return cannot_read(path, header.fault);
    std::uint64_t left = bytes->size() - at;
    for (const PlyElement& element : header.elements) {
        const std::uint64_t least = element.least_bytes(header.binary);
        if (least == 0 ? element.count > bytes->size() : element.count > (left + 1) / least)
            return cannot_read(path, "its PLY header announces " + std::to_string(element.count) +
                                         " elements, for which the file is too short");
        left -= std::min(left, element.count * least);
    }
    for (std::size_t i = 0; i < header.elements.size(); ++i) {
        const PlyElement& element = header.elements[i];
        const bool later_lists = std::any_of(header.elements.begin() + std::ptrdiff_t(i), header.elements.end(),
                                             [](const PlyElement& e) { return e.has_list(); });
        if (!later_lists) break;
        const bool sound =
            header.binary ? walk_binary(element, header.big_endian, *bytes, at) : walk_text(element, *bytes, at);
        if (!sound) return cannot_read(path, "a list in it is longer than what is left of the file");
    }
    return {};
}

Result<void> check_off(const std::filesystem::path& path) {
    // Assimp copies lines into 4096 bytes, takes no more than nine corners, and loses its place where a face is none.
    static constexpr std::size_t MAX_LINE = 4000;
    static constexpr std::uint64_t MAX_FACE_CORNERS = 9;
    const Result<std::string> bytes = read_file_bytes(path, MAX_MESH_FILE);
    if (!bytes) return bytes.error();
    std::string_view left = *bytes;
    const auto next_line = [&]() -> std::string_view {
        left.remove_prefix(std::min(left.find_first_not_of("\r\n"), left.size()));
        const std::string_view line = left.substr(0, left.find_first_of("\r\n"));
        left.remove_prefix(line.size());
        return line;
    };
    // The keyword and three counts, on one line or several, comments between them.
    std::vector<std::string> words;
    for (std::size_t needed = 3; words.size() < needed && !left.empty();) {
        const std::string_view whole = next_line();
        std::istringstream line(std::string(whole.substr(0, std::min(whole.find('#'), MAX_LINE))));
        for (std::string word; line >> word;) {
            if (words.empty() && word.find("OFF") != std::string::npos) needed = 4;
            words.push_back(word);
        }
    }
    std::size_t first = 0;
    if (!words.empty() && words[0].find("OFF") != std::string::npos) {
        if (words[0].find_first_not_of("STCN4OF") != std::string::npos)
            return cannot_read(path, "its keyword '" + words[0] + "' is none of OFF, COFF, NOFF, STOFF, 4OFF");
        first = 1;
    }
    const auto whole_number = [&](std::string_view word) {
        std::uint64_t value = 0;
        for (const char digit : word) {
            if (digit < '0' || digit > '9' || value > bytes->size()) return UINT64_MAX;
            value = value * 10 + std::uint64_t(digit - '0');
        }
        return word.empty() ? UINT64_MAX : value;
    };
    if (words.size() != first + 3)
        return cannot_read(path, "its header does not count vertices, faces and edges on lines of their own");
    const std::uint64_t vertices = whole_number(words[first]), faces = whole_number(words[first + 1]);
    if (vertices > bytes->size() || faces > bytes->size())
        return cannot_read(path, "it announces " + words[first] + " vertices and " + words[first + 1] +
                                     " faces, for which the file is too short");
    for (std::uint64_t i = 0; i < vertices + faces; ++i) {
        const std::string_view line = next_line();
        const std::string what = i < vertices ? "vertex " + std::to_string(i) : "face " + std::to_string(i - vertices);
        if (line.empty()) return cannot_read(path, "it ends before " + what);
        if (line.size() > MAX_LINE) return cannot_read(path, "the line of " + what + " is too long");
        if (i < vertices) continue;
        std::istringstream numbers{std::string(line)};
        std::string word;
        numbers >> word;
        const std::uint64_t corners = whole_number(word);
        if (corners < 1 || corners > MAX_FACE_CORNERS)
            return cannot_read(path, what + " does not have 1 to " + std::to_string(MAX_FACE_CORNERS) + " corners");
        for (std::uint64_t k = 0; k < corners; ++k) {
            word.clear();
            numbers >> word;
            if (whole_number(word) >= vertices)
                return cannot_read(path, what + " refers to vertex '" + word + "' of " + std::to_string(vertices));
        }
    }
    return {};
}

bool is_nested_deeper(std::string_view json, int depth) {
    int now = 0;
    bool text = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (text) {
            if (c == '\\') ++i;
            else if (c == '"') text = false;
        } else if (c == '"') {
            text = true;
        } else if (c == '[' || c == '{') {
            if (++now > depth) return true;
        } else if (c == ']' || c == '}') {
            --now;
        }
    }
    return false;
}

}  // namespace spinel
