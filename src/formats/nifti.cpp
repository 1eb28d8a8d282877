#include "formats/nifti.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "formats/file_bytes.h"
#include "formats/inflate.h"
#include "formats/samples.h"

namespace spinel {
namespace {

using glm::dmat3;
using glm::dvec3;

constexpr std::size_t HEADER_1 = 348, HEADER_2 = 540;

// Numbers at fixed places of a header that is long enough.
class NiftiFields {
  public:
    NiftiFields(std::string_view bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}
    template <class T>
    T at(std::size_t offset) const {
        unsigned char raw[sizeof(T)];
        std::memcpy(raw, bytes_.data() + offset, sizeof(T));
        if (swapped_) std::reverse(raw, raw + sizeof(T));
        T value;
        std::memcpy(&value, raw, sizeof(T));
        return value;
    }

  private:
    std::string_view bytes_;
    bool swapped_;
};

struct NiftiHeader {
    std::int64_t dim[8] = {};
    int datatype = 0;
    double pixdim[8] = {};
    double offset = 0;  // of the samples
    double slope = 0, intercept = 0;
    int qform = 0, sform = 0;
    double quatern[3] = {}, qoffset[3] = {};
    double srow[3][4] = {};
    int units = 0;
    bool swapped = false;
};

// The members of the two versions, which differ in their places and widths.
NiftiHeader header_1(const NiftiFields& f) {
    NiftiHeader h;
    for (int i = 0; i < 8; ++i) {
        h.dim[i] = f.at<std::int16_t>(40 + 2 * std::size_t(i));
        h.pixdim[i] = f.at<float>(76 + 4 * std::size_t(i));
    }
    h.datatype = f.at<std::int16_t>(70);
    h.offset = f.at<float>(108);
    h.slope = f.at<float>(112);
    h.intercept = f.at<float>(116);
    h.units = f.at<std::uint8_t>(123);
    h.qform = f.at<std::int16_t>(252);
    h.sform = f.at<std::int16_t>(254);
    for (std::size_t i = 0; i < 3; ++i) {
        h.quatern[i] = f.at<float>(256 + 4 * i);
        h.qoffset[i] = f.at<float>(268 + 4 * i);
        for (std::size_t k = 0; k < 4; ++k) h.srow[i][k] = f.at<float>(280 + 16 * i + 4 * k);
    }
    return h;
}

NiftiHeader header_2(const NiftiFields& f) {
    NiftiHeader h;
    for (int i = 0; i < 8; ++i) {
        h.dim[i] = f.at<std::int64_t>(16 + 8 * std::size_t(i));
        h.pixdim[i] = f.at<double>(104 + 8 * std::size_t(i));
    }
    h.datatype = f.at<std::int16_t>(12);
    h.offset = double(f.at<std::int64_t>(168));
    h.slope = f.at<double>(176);
    h.intercept = f.at<double>(184);
    h.qform = f.at<std::int32_t>(344);
    h.sform = f.at<std::int32_t>(348);
    for (std::size_t i = 0; i < 3; ++i) {
        h.quatern[i] = f.at<double>(352 + 8 * i);
        h.qoffset[i] = f.at<double>(376 + 8 * i);
        for (std::size_t k = 0; k < 4; ++k) h.srow[i][k] = f.at<double>(400 + 32 * i + 8 * k);
    }
    h.units = f.at<std::int32_t>(500);
    return h;
}

Result<NiftiHeader> read_nifti_header(std::string_view bytes) {
    if (bytes.size() < 4) return Error{"it is not a NIfTI file"};
    for (const bool swapped : {false, true}) {
        const NiftiFields fields(bytes, swapped);
        const auto size = fields.at<std::int32_t>(0);
        if (size != std::int32_t(HEADER_1) && size != std::int32_t(HEADER_2)) continue;
        if (bytes.size() < std::size_t(size)) return Error{"its header is cut off"};
        const bool second = size == std::int32_t(HEADER_2);
        const std::string_view magic = bytes.substr(second ? 4 : 344, 4);
        if (magic.starts_with(second ? "ni2" : "ni1"))
            return Error{"its samples are in another file (.hdr and .img), which is not read"};
        if (!magic.starts_with(second ? "n+2" : "n+1")) return Error{"it is not a NIfTI file (Analyze is not read)"};
        NiftiHeader h = second ? header_2(fields) : header_1(fields);
        h.swapped = swapped;
        return h;
    }
    return Error{"it is not a NIfTI file"};
}

Result<SampleType> sample_type(int datatype) {
    switch (datatype) {
        case 2: return SampleType::u8;
        case 4: return SampleType::i16;
        case 8: return SampleType::i32;
        case 16: return SampleType::f32;
        case 64: return SampleType::f64;
        case 256: return SampleType::i8;
        case 512: return SampleType::u16;
        case 768: return SampleType::u32;
        case 1024: return SampleType::i64;
        case 1280: return SampleType::u64;
        case 1: return Error{"its samples are bits, which are not read"};
        case 32:
        case 1792:
        case 2048: return Error{"its samples are complex numbers, which are not read"};
        case 128:
        case 2304: return Error{"its samples are colours, which are not read"};
        case 1536: return Error{"its samples are floats of 128 bits, which are not read"};
        default: return Error{fmt::format("its samples are of the unknown type {}", datatype)};
    }
}

// From sample indices (at the samples themselves) to the patient's right, front and up.
Result<glm::dmat4x3> orientation(const NiftiHeader& h) {
    if (h.sform > 0) {
        glm::dmat4x3 m;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 4; ++column) m[column][row] = h.srow[row][column];
        return m;
    }
    const dvec3 spacing(h.pixdim[1], h.pixdim[2], h.pixdim[3]);
    for (int i = 0; i < 3; ++i)
        if (!(std::abs(spacing[i]) > 0)) return Error{"its spacing is zero or not a number"};
    if (h.qform <= 0)
        return glm::dmat4x3(dvec3(spacing.x, 0, 0), dvec3(0, spacing.y, 0), dvec3(0, 0, spacing.z), dvec3(0));
    double b = h.quatern[0], c = h.quatern[1], d = h.quatern[2];
    double a = 1 - (b * b + c * c + d * d);
    if (a < 1e-7) {  // half a turn
        const double length = std::sqrt(b * b + c * c + d * d);
        b /= length, c /= length, d /= length, a = 0;
    } else {
        a = std::sqrt(a);
    }
    const double handed = h.pixdim[0] < 0 ? -1 : 1;
    const dvec3 x(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c));
    const dvec3 y(2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b));
    const dvec3 z(2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - b * b - c * c);
    return glm::dmat4x3(x * spacing.x, y * spacing.y, z * (handed * spacing.z),
                        dvec3(h.qoffset[0], h.qoffset[1], h.qoffset[2]));
}

std::string unit_of(int units) {
    switch (units & 7) {
        case 1: return "m";
        case 2: return "mm";
        case 3: return "µm";
        default: return "";
    }
}

Result<Scene> read_nifti(const std::string& file, const std::string& name, const LoadOptions& options) {
    const bool packed = looks_deflated(file);
    const Result<std::string> start =
        packed ? inflated_start(file, HEADER_2) : Result<std::string>(file.substr(0, HEADER_2));
    if (!start) return start.error();
    const Result<NiftiHeader> header = read_nifti_header(*start);
    if (!header) return header.error();
    const NiftiHeader& h = *header;
    const Result<SampleType> type = sample_type(h.datatype);
    if (!type) return type.error();
    if (h.dim[0] < 1 || h.dim[0] > 7) return Error{fmt::format("it has {} dimensions; 1 to 7 are allowed", h.dim[0])};
    ivec3 size(1);
    std::uint64_t volumes = 1;
    for (int i = 1; i <= h.dim[0]; ++i) {
        if (h.dim[i] < 1 || h.dim[i] > (1 << 20))
            return Error{fmt::format("its dimension {} is {}; 1 to {} are allowed", i, h.dim[i], 1 << 20)};
        if (i <= 3) {
            size[i - 1] = int(h.dim[i]);
            continue;
        }
        volumes *= std::uint64_t(h.dim[i]);
        if (volumes > MAX_VOLUME_SAMPLES) return Error{"it has too many volumes"};
    }
    const auto volume_bytes = bytes_of_samples(size, *type);
    if (!volume_bytes)
        return Error{fmt::format("its {}×{}×{} samples are more than the {} allowed", size.x, size.y, size.z,
                                 MAX_VOLUME_SAMPLES)};
    const auto frame = std::uint64_t(options.frame.value_or(0));
    if (frame >= volumes) return Error{fmt::format("it has {} volumes, there is no frame {}", volumes, frame)};
    if (!(h.offset >= 0) || h.offset > 1e15) return Error{"its samples begin beyond its end"};
    // The size is believed only once the file has as many bytes.
    const auto first = std::uint64_t(h.offset);
    const std::uint64_t end = first + *volume_bytes * (frame + 1);
    if (end > MAX_VOLUME_BYTES)
        return Error{fmt::format("its samples end at byte {}, beyond the {} allowed", end, MAX_VOLUME_BYTES)};
    const Result<std::string> unpacked = packed ? inflated_start(file, end) : Result<std::string>(std::string());
    if (!unpacked) return unpacked.error();
    const std::string_view bytes = packed ? std::string_view(*unpacked) : std::string_view(file);
    if (bytes.size() < end)
        return Error{
            fmt::format("its size needs {} bytes up to the end of this volume, there are {}", end, bytes.size())};
    const Result<glm::dmat4x3> placed = orientation(h);
    if (!placed) return placed.error();
    glm::dmat4x3 m = *placed;
    m[3] -= 0.5 * (m[0] + m[1] + m[2]);  // sample i sits at i + ½
    const bool scaled = h.slope != 0 && std::isfinite(h.slope) && std::isfinite(h.intercept);
    DecodedSamples samples = decode_samples(bytes.substr(end - *volume_bytes, *volume_bytes), *type,
                                            h.swapped != (std::endian::native == std::endian::big),
                                            scaled ? h.slope : 1.0, scaled ? h.intercept : 0.0);
    Result<Scene> scene = scan_scene(name, size, std::move(samples), patient_to_world(mat4x3(m)), "");
    if (scene && volumes > 1 && !options.frame)
        scene->notes.push_back(fmt::format("of its {} volumes the first is read (--frame)", volumes));
    if (scene && !unit_of(h.units).empty() && unit_of(h.units) != "mm")
        scene->notes.push_back("its lengths are in " + unit_of(h.units));
    return scene;
}

}  // namespace

Result<Scene> load_nifti(const std::filesystem::path& path, const LoadOptions& options) {
    const Result<std::string> bytes = read_file_bytes(path, MAX_VOLUME_BYTES);
    if (!bytes) return bytes.error();
    std::string name = path.stem().string();
    if (name.ends_with(".nii")) name.resize(name.size() - 4);
    Result<Scene> scene = read_nifti(*bytes, name, options);
    return scene ? std::move(scene) : Result<Scene>(cannot_read(path, scene.error().message));
}

}  // namespace spinel
