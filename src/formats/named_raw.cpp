#include "formats/named_raw.h"

#include <fmt/format.h>

#include <charconv>
#include <map>
#include <optional>

#include "formats/file_bytes.h"
#include "formats/inflate.h"
#include "formats/samples.h"

namespace spinel {
namespace {

struct NamedRaw {
    std::string name;
    ivec3 size = {0, 0, 0};
    std::optional<SampleType> type;
};

std::optional<SampleType> type_of(std::string_view word) {
    static const std::map<std::string_view, SampleType> types = {
        {"u8", SampleType::u8},   {"uint8", SampleType::u8},    {"i8", SampleType::i8},   {"int8", SampleType::i8},
        {"u16", SampleType::u16}, {"uint16", SampleType::u16},  {"i16", SampleType::i16}, {"int16", SampleType::i16},
        {"u32", SampleType::u32}, {"uint32", SampleType::u32},  {"i32", SampleType::i32}, {"int32", SampleType::i32},
        {"f32", SampleType::f32}, {"float32", SampleType::f32}, {"f64", SampleType::f64}, {"float64", SampleType::f64}};
    const auto found = types.find(word);
    return found == types.end() ? std::nullopt : std::optional(found->second);
}

std::optional<ivec3> size_of(std::string_view word) {
    ivec3 size(0);
    const char *at = word.data(), *end = at + word.size();
    for (int i = 0; i < 3; ++i) {
        if (i > 0 && (at == end || *at++ != 'x')) return std::nullopt;
        const auto [next, error] = std::from_chars(at, end, size[i]);
        if (error != std::errc() || size[i] < 1 || size[i] > (1 << 20)) return std::nullopt;
        at = next;
    }
    return at == end ? std::optional(size) : std::nullopt;
}

// "lidc_256x256x133_u8.raw.gz": the words between underlines.
NamedRaw named(std::string text) {
    for (const std::string_view tail : {".gz", ".GZ", ".raw", ".RAW"})
        if (text.ends_with(tail)) text.resize(text.size() - tail.size());
    NamedRaw found;
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find('_', at), text.size());
        const std::string word = text.substr(at, end - at);
        if (const auto size = size_of(word)) found.size = *size;
        else if (const auto type = type_of(word)) found.type = type;
        else found.name += (found.name.empty() ? "" : "_") + word;
        at = end + 1;
    }
    return found;
}

Result<Scene> read_named_raw(const std::string& file, const std::string& file_name) {
    const NamedRaw what = named(file_name);
    if (what.size.x == 0 || !what.type)
        return Error{
            "its name does not tell size and type, as in name_256x256x128_uint8.raw; a .nhdr file beside it can"};
    const auto wanted = bytes_of_samples(what.size, *what.type);
    if (!wanted) return Error{fmt::format("its size is of more samples than the {} allowed", MAX_VOLUME_SAMPLES)};
    const bool packed = looks_deflated(file) && file.size() != *wanted;
    const Result<std::string> unpacked =
        packed ? inflated_start(file, *wanted + 1) : Result<std::string>(std::string());
    if (!unpacked) return unpacked.error();
    const std::string& bytes = packed ? *unpacked : file;
    if (bytes.size() != *wanted)
        return Error{fmt::format("its size needs {} bytes of samples, there are {}", *wanted,
                                 bytes.size() > *wanted ? "more" : std::to_string(bytes.size()))};
    return scan_scene(what.name, what.size, decode_samples(bytes, *what.type, false), mat4x3(1), "");
}

}  // namespace

Result<Scene> load_named_raw(const std::filesystem::path& path, const LoadOptions&) {
    const Result<std::string> bytes = read_file_bytes(path, MAX_VOLUME_BYTES);
    if (!bytes) return bytes.error();
    Result<Scene> scene = read_named_raw(*bytes, path.filename().string());
    return scene ? std::move(scene) : Result<Scene>(cannot_read(path, scene.error().message));
}

}  // namespace spinel
