#include "formats/nrrd.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "formats/file_bytes.h"
#include "formats/inflate.h"
#include "formats/samples.h"
#include "formats/text_numbers.h"

namespace spinel {
namespace {

using glm::dvec3;

constexpr std::size_t MAX_SCAN_HEADER = 1 << 16;

// What either format says of its samples.
struct Scan {
    ivec3 size = {1, 1, 1};
    SampleType type = SampleType::u8;
    bool big_endian = false;
    bool packed = false;      // gzip or zlib
    bool anatomical = false;  // axes and origin are to the patient's left, back and head …
    bool right = false;       // … but here to the right …
    bool front = false;       // … or the front
    dvec3 axes[3] = {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)};
    dvec3 origin = dvec3(0);  // of the first sample's middle
    std::string unit;
    std::string file;  // of the samples; empty: behind the header
    std::int64_t line_skip = 0;
    std::int64_t byte_skip = 0;  // −1: the samples are the end of the file
};

mat4x3 placement(const Scan& scan) {
    glm::dmat4x3 m(scan.axes[0], scan.axes[1], scan.axes[2], scan.origin);
    m[3] -= 0.5 * (m[0] + m[1] + m[2]);  // sample i sits at i + ½
    if (!scan.anatomical) return mat4x3(m);
    for (int i = 0; i < 4; ++i) m[i] *= dvec3(scan.right ? 1 : -1, scan.front ? 1 : -1, 1);
    return patient_to_world(mat4x3(m));
}

// The samples of a scan from the bytes that they begin in.
Result<Scene> read_samples(const Scan& scan, std::string_view bytes, const std::string& name) {
    const auto wanted = bytes_of_samples(scan.size, scan.type);
    if (!wanted)
        return Error{fmt::format("its {}×{}×{} samples are more than the {} allowed", scan.size.x, scan.size.y,
                                 scan.size.z, MAX_VOLUME_SAMPLES)};
    for (std::int64_t i = 0; i < scan.line_skip; ++i) {
        const auto end = bytes.find('\n');
        if (end == bytes.npos) return Error{"it has fewer lines than its samples are behind of"};
        bytes.remove_prefix(end + 1);
    }
    const std::uint64_t skip = std::uint64_t(std::max<std::int64_t>(scan.byte_skip, 0));
    Result<std::string> unpacked = std::string();
    if (scan.packed) {
        if (!looks_deflated(bytes)) return Error{"its samples are not packed by gzip, as it says"};
        if (skip > MAX_VOLUME_BYTES) return Error{"its samples begin too far behind"};
        unpacked = inflated_start(bytes, skip + *wanted);
        if (!unpacked) return unpacked.error();
        bytes = *unpacked;
    }
    if (scan.byte_skip < 0) bytes.remove_prefix(bytes.size() - std::min<std::size_t>(bytes.size(), *wanted));
    else bytes.remove_prefix(std::min<std::uint64_t>(skip, bytes.size()));
    // The size is believed only once there are as many bytes.
    if (bytes.size() < *wanted)
        return Error{fmt::format("its size needs {} bytes of samples, there are {}", *wanted, bytes.size())};
    return scan_scene(name, scan.size, decode_samples(bytes.substr(0, *wanted), scan.type, scan.big_endian),
                      placement(scan), scan.unit);
}

Result<Scene> read_scan(const Scan& scan, const std::filesystem::path& path, std::string_view behind) {
    const std::string name = path.stem().string();
    if (scan.file.empty()) return read_samples(scan, behind, name);
    const Result<std::string> bytes = read_file_bytes(path.parent_path() / scan.file, MAX_VOLUME_BYTES);
    if (!bytes) return Error{"of its samples: " + bytes.error().message};
    return read_samples(scan, *bytes, name);
}

// "(1,0,0) (0,1,0) none": a vector for each axis of space.
std::optional<std::vector<std::optional<dvec3>>> vectors(std::string_view text) {
    std::vector<std::optional<dvec3>> result;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        if (result.size() == 16) return std::nullopt;
        if (text.starts_with("none")) {
            result.emplace_back();
            text.remove_prefix(4);
            continue;
        }
        const auto end = text.find(')');
        if (text[0] != '(' || end == text.npos) return std::nullopt;
        std::string inner(text.substr(1, end - 1));
        std::replace(inner.begin(), inner.end(), ',', ' ');
        const auto numbers = text_numbers<double>(inner);
        if (!numbers || numbers->empty() || numbers->size() > 3) return std::nullopt;
        dvec3 v(0);
        for (std::size_t i = 0; i < numbers->size(); ++i) v[int(i)] = (*numbers)[i];
        result.push_back(v);
        text.remove_prefix(end + 1);
    }
    return result;
}

std::optional<SampleType> nrrd_type(std::string_view name) {
    static const std::map<std::string_view, SampleType> types = {{"signed char", SampleType::i8},
                                                                 {"int8", SampleType::i8},
                                                                 {"int8_t", SampleType::i8},
                                                                 {"uchar", SampleType::u8},
                                                                 {"unsigned char", SampleType::u8},
                                                                 {"uint8", SampleType::u8},
                                                                 {"uint8_t", SampleType::u8},
                                                                 {"short", SampleType::i16},
                                                                 {"short int", SampleType::i16},
                                                                 {"signed short", SampleType::i16},
                                                                 {"signed short int", SampleType::i16},
                                                                 {"int16", SampleType::i16},
                                                                 {"int16_t", SampleType::i16},
                                                                 {"ushort", SampleType::u16},
                                                                 {"unsigned short", SampleType::u16},
                                                                 {"unsigned short int", SampleType::u16},
                                                                 {"uint16", SampleType::u16},
                                                                 {"uint16_t", SampleType::u16},
                                                                 {"int", SampleType::i32},
                                                                 {"signed int", SampleType::i32},
                                                                 {"int32", SampleType::i32},
                                                                 {"int32_t", SampleType::i32},
                                                                 {"uint", SampleType::u32},
                                                                 {"unsigned int", SampleType::u32},
                                                                 {"uint32", SampleType::u32},
                                                                 {"uint32_t", SampleType::u32},
                                                                 {"longlong", SampleType::i64},
                                                                 {"long long", SampleType::i64},
                                                                 {"int64", SampleType::i64},
                                                                 {"int64_t", SampleType::i64},
                                                                 {"ulonglong", SampleType::u64},
                                                                 {"unsigned long long", SampleType::u64},
                                                                 {"uint64", SampleType::u64},
                                                                 {"uint64_t", SampleType::u64},
                                                                 {"float", SampleType::f32},
                                                                 {"double", SampleType::f64}};
    const auto found = types.find(name);
    return found == types.end() ? std::nullopt : std::optional(found->second);
}

using ScanFields = std::map<std::string, std::string, std::less<>>;

Result<Scan> nrrd_scan(const ScanFields& fields, bool detached) {
    const auto field = [&](std::string_view name) -> std::string_view {
        const auto found = fields.find(name);
        return found == fields.end() ? std::string_view() : std::string_view(found->second);
    };
    const auto wrong = [&](std::string_view name, const char* allowed) {
        return Error{fmt::format("its {} is '{}'; allowed: {}", name, field(name), allowed)};
    };
    Scan scan;
    const auto type = nrrd_type(field("type"));
    if (!type) return wrong("type", "scalars of 8 to 64 bits");
    scan.type = *type;
    const auto sizes = text_numbers<int>(field("sizes"));
    if (!sizes || sizes->empty()) return wrong("sizes", "whole numbers, one for each dimension");
    const auto dimension = text_numbers<std::size_t>(field("dimension"));
    if (!dimension || dimension->size() != 1 || (*dimension)[0] != sizes->size())
        return wrong("dimension", "the number of its sizes");

    auto directions = vectors(field("space directions"));
    if (!directions || (!directions->empty() && directions->size() != sizes->size()))
        return wrong("space directions", "a vector or none for each dimension");
    Result<std::vector<double>> spacings = std::vector<double>();
    if (!field("spacings").empty()) {
        // NaN stands for axes that are not of space.
        std::string text(field("spacings"));
        auto numbers = text_numbers<double>(text);
        if (!numbers || numbers->size() != sizes->size()) return wrong("spacings", "a number for each dimension");
        *spacings = *numbers;
    }
    // Axes that are not of space may only have one sample; they are left out.
    int axis = 0;
    for (std::size_t i = 0; i < sizes->size(); ++i) {
        const bool of_space = directions->empty() || (*directions)[i];
        if ((*sizes)[i] < 1) return wrong("sizes", "whole numbers from 1 on");
        if ((!of_space || axis == 3) && (*sizes)[i] == 1) continue;
        if (!of_space || axis == 3)
            return Error{
                fmt::format("its dimension {} holds {} values for each place; one is allowed", i + 1, (*sizes)[i])};
        scan.size[axis] = (*sizes)[i];
        if (!directions->empty()) {
            scan.axes[axis] = *(*directions)[i];
        } else if (!spacings->empty() && std::isfinite((*spacings)[i]) && (*spacings)[i] != 0) {
            scan.axes[axis] *= (*spacings)[i];
        }
        ++axis;
    }
    if (axis == 2 && !directions->empty()) {  // a slice in space
        const dvec3 normal = glm::cross(scan.axes[0], scan.axes[1]);
        if (const double length = glm::length(normal); length > 0) scan.axes[2] = normal / length * std::sqrt(length);
    }
    const std::string_view space = field("space");
    const bool left =
        space == "left-posterior-superior" || space == "LPS" || space.starts_with("left-posterior-superior-");
    const bool right =
        space == "right-anterior-superior" || space == "RAS" || space.starts_with("right-anterior-superior-");
    const bool left_front =
        space == "left-anterior-superior" || space == "LAS" || space.starts_with("left-anterior-superior-");
    scan.anatomical = left || right || left_front;
    scan.right = right;
    scan.front = right || left_front;
    if (!field("space origin").empty()) {
        const auto origin = vectors(field("space origin"));
        if (!origin || origin->size() != 1 || !(*origin)[0]) return wrong("space origin", "one vector");
        scan.origin = *(*origin)[0];
    }
    const std::string_view encoding = field("encoding");
    scan.packed = encoding == "gzip" || encoding == "gz";
    if (!scan.packed && encoding != "raw") return wrong("encoding", "raw, gzip");
    if (sample_bytes(scan.type) > 1) {
        if (field("endian") != "little" && field("endian") != "big") return wrong("endian", "little, big");
        scan.big_endian = field("endian") == "big";
    }
    for (auto [name, skip] : {std::pair{"line skip", &scan.line_skip}, std::pair{"byte skip", &scan.byte_skip}}) {
        if (field(name).empty()) continue;
        const auto number = text_numbers<std::int64_t>(field(name));
        if (!number || number->size() != 1 || (*number)[0] < -1 || (*number)[0] > (std::int64_t(1) << 40))
            return wrong(name, "one whole number");
        *skip = (*number)[0];
    }
    if (scan.line_skip < 0 || (scan.byte_skip < 0 && scan.packed))
        return Error{"its line skip or byte skip is negative"};
    scan.unit = field("sample units");
    if (scan.unit.size() > 1 && scan.unit.front() == '"' && scan.unit.back() == '"')
        scan.unit = scan.unit.substr(1, scan.unit.size() - 2);
    scan.file = field("data file");
    if (scan.file.empty()) scan.file = field("datafile");
    if (scan.file.starts_with("LIST") || scan.file.find('%') != std::string::npos)
        return Error{"its samples are in several files, which is not read"};
    if (detached && scan.file.empty()) return Error{"its header names no data file"};
    return scan;
}

Result<Scene> read_nrrd(const std::filesystem::path& path, std::string_view bytes) {
    if (!bytes.starts_with("NRRD000")) return Error{"it is not a NRRD file"};
    ScanFields fields;
    std::size_t at = 0;
    for (int number = 1;; ++number) {
        const std::size_t end = bytes.substr(0, MAX_SCAN_HEADER).find('\n', at);
        const std::string_view line = trimmed(bytes.substr(at, end == bytes.npos ? bytes.npos : end - at));
        at = end == bytes.npos ? bytes.size() : end + 1;
        if (line.empty() || (end == bytes.npos && at > MAX_SCAN_HEADER)) break;
        if (number > 1 && line[0] != '#' && line.find(":=") == line.npos) {
            const auto colon = line.find(':');
            if (colon == line.npos) return Error{fmt::format("line {} of its header has no ':'", number)};
            std::string key(line.substr(0, colon));
            std::transform(key.begin(), key.end(), key.begin(), [](unsigned char c) { return char(std::tolower(c)); });
            if (key == "centers") key = "centerings";
            fields[key] = trimmed(line.substr(colon + 1));
        }
        if (end == bytes.npos) break;
    }
    const bool detached = path.extension() == ".nhdr" || path.extension() == ".NHDR";
    const Result<Scan> scan = nrrd_scan(fields, detached);
    if (!scan) return scan.error();
    return read_scan(*scan, path, bytes.substr(at));
}

std::optional<SampleType> metaimage_type(std::string_view name) {
    static const std::map<std::string_view, SampleType> types = {
        {"MET_CHAR", SampleType::i8},       {"MET_UCHAR", SampleType::u8},       {"MET_SHORT", SampleType::i16},
        {"MET_USHORT", SampleType::u16},    {"MET_INT", SampleType::i32},        {"MET_UINT", SampleType::u32},
        {"MET_LONG_LONG", SampleType::i64}, {"MET_ULONG_LONG", SampleType::u64}, {"MET_FLOAT", SampleType::f32},
        {"MET_DOUBLE", SampleType::f64}};
    const auto found = types.find(name);
    return found == types.end() ? std::nullopt : std::optional(found->second);
}

Result<Scene> read_metaimage(const std::filesystem::path& path, std::string_view bytes) {
    ScanFields fields;
    std::size_t at = 0;
    while (!fields.contains("ElementDataFile")) {
        const std::size_t end = bytes.substr(0, MAX_SCAN_HEADER).find('\n', at);
        if (end == bytes.npos) return Error{"its header names no ElementDataFile"};
        const std::string_view line = bytes.substr(at, end - at);
        at = end + 1;
        const auto equals = line.find('=');
        if (equals == line.npos) return Error{"it is not a MetaImage file"};
        fields[std::string(trimmed(line.substr(0, equals)))] = trimmed(line.substr(equals + 1));
    }
    const auto wrong = [&](const char* name) {
        return Error{fmt::format("its {} is '{}', which is not read", name, fields[name])};
    };
    Scan scan;
    const auto type = metaimage_type(fields["ElementType"]);
    if (!type) return wrong("ElementType");
    scan.type = *type;
    if (const std::string& channels = fields["ElementNumberOfChannels"]; !channels.empty() && channels != "1")
        return wrong("ElementNumberOfChannels");
    const auto size = text_numbers<int>(fields["DimSize"]);
    if (!size || size->size() < 2 || size->size() > 3) return wrong("DimSize");
    const std::size_t n = size->size();
    for (std::size_t i = 0; i < n; ++i) scan.size[int(i)] = (*size)[i];
    scan.packed = fields["CompressedData"] == "True";
    scan.big_endian = fields["BinaryDataByteOrderMSB"] == "True" || fields["ElementByteOrderMSB"] == "True";
    scan.anatomical = true;
    const auto numbers_of = [&](std::initializer_list<const char*> names, std::size_t count,
                                std::vector<double> fallback) -> std::optional<std::vector<double>> {
        for (const char* name : names) {
            if (fields[name].empty()) continue;
            auto numbers = text_numbers<double>(fields[name]);
            if (!numbers || numbers->size() != count) return std::nullopt;
            return numbers;
        }
        return fallback;
    };
    std::vector<double> identity(n * n, 0);
    for (std::size_t i = 0; i < n; ++i) identity[i * (n + 1)] = 1;
    const auto spacing = numbers_of({"ElementSpacing"}, n, std::vector<double>(n, 1));
    const auto matrix = numbers_of({"TransformMatrix", "Rotation", "Orientation"}, n * n, identity);
    const auto origin = numbers_of({"Offset", "Origin", "Position"}, n, std::vector<double>(n, 0));
    if (!spacing) return wrong("ElementSpacing");
    if (!matrix) return wrong("TransformMatrix");
    if (!origin) return wrong("Offset");
    for (std::size_t i = 0; i < n; ++i) {
        scan.axes[i] = dvec3(0);
        for (std::size_t k = 0; k < n; ++k) scan.axes[i][int(k)] = (*spacing)[i] * (*matrix)[i * n + k];
        scan.origin[int(i)] = (*origin)[i];
    }
    if (const std::string& skip = fields["HeaderSize"]; !skip.empty()) {
        const auto number = text_numbers<std::int64_t>(skip);
        if (!number || number->size() != 1 || (*number)[0] < -1) return wrong("HeaderSize");
        scan.byte_skip = (*number)[0];
    }
    const std::string& file = fields["ElementDataFile"];
    if (file.empty() || file.starts_with("LIST") || file.find('%') != std::string::npos)
        return wrong("ElementDataFile");
    if (file != "LOCAL") scan.file = file;
    return read_scan(scan, path, bytes.substr(at));
}

template <class Read>
Result<Scene> load_scan(const std::filesystem::path& path, Read read) {
    const Result<std::string> bytes = read_file_bytes(path, MAX_VOLUME_BYTES);
    if (!bytes) return bytes.error();
    Result<Scene> scene = read(path, std::string_view(*bytes));
    return scene ? std::move(scene) : Result<Scene>(cannot_read(path, scene.error().message));
}

}  // namespace

Result<Scene> load_nrrd(const std::filesystem::path& path, const LoadOptions&) { return load_scan(path, read_nrrd); }
Result<Scene> load_metaimage(const std::filesystem::path& path, const LoadOptions&) {
    return load_scan(path, read_metaimage);
}

}  // namespace spinel
