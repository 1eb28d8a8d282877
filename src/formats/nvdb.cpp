#include "formats/nvdb.h"

#include <blosc.h>
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "formats/byte_reader.h"
#include "formats/file_bytes.h"
#include "formats/inflate.h"
#include "formats/nvdb_tree.h"
#include "formats/samples.h"
#include "formats/volume_scene.h"
#include "scene/validate.h"

namespace spinel {
namespace {

constexpr std::uint64_t CHUNK = std::uint64_t(1) << 30;  // that blosc packs at once
constexpr std::size_t GRID_ENTRY = 176;                  // bytes that describe a grid at the head of a segment
constexpr std::uint64_t MOST_PACKED = 1024;              // bytes that one byte can stand for

enum Codec : std::uint16_t { CODEC_NONE = 0, CODEC_ZIP = 1, CODEC_BLOSC = 2 };

struct Entry {
    std::uint64_t size, file_size;
    std::uint32_t name_size;
};

// A grid's bytes, aligned as NanoVDB wants them.
class GridBytes {
  public:
    explicit GridBytes(std::size_t size) : size_(size), blocks_((size + 31) / 32) {}
    char* data() { return reinterpret_cast<char*>(blocks_.data()); }
    std::size_t size() const { return size_; }

  private:
    struct alignas(32) Block {
        char bytes[32];
    };
    std::size_t size_;
    std::vector<Block> blocks_;
};

Result<GridBytes> unpacked(std::string_view packed, std::uint16_t codec, std::uint64_t size) {
    const Error damaged{"its packed grid is damaged"};
    // The size is believed only once the file has bytes for it.
    if (codec == CODEC_NONE ? packed.size() < size : packed.size() < size / MOST_PACKED || packed.size() < 8)
        return Error{fmt::format("its grid of {} bytes is not in the file's {}", size, packed.size())};
    if (codec == CODEC_NONE) {
        GridBytes bytes(size);
        std::memcpy(bytes.data(), packed.data(), size);
        return bytes;
    }
    ByteReader reader(packed);
    const auto piece = [&] {
        const std::uint64_t low = reader.u32(), high = reader.u32();
        return reader.take(std::size_t(low | high << 32));
    };
    if (codec == CODEC_ZIP) {
        const std::string_view stream = piece();
        if (!reader.ok() || !looks_deflated(stream)) return damaged;
        const Result<std::string> plain = inflated_start(stream, size);
        if (!plain) return plain.error();
        if (plain->size() != size) return damaged;
        GridBytes bytes(size);
        std::memcpy(bytes.data(), plain->data(), size);
        return bytes;
    }
    if (codec != CODEC_BLOSC) return Error{fmt::format("it is packed by the unknown codec {}", codec)};
    GridBytes bytes(size);
    for (std::uint64_t done = 0; done < size;) {
        const std::string_view block = piece();
        const std::uint64_t wanted = std::min(CHUNK, size - done);
        std::size_t plain = 0;
        if (!reader.ok() || block.size() < BLOSC_MIN_HEADER_LENGTH ||
            blosc_cbuffer_validate(block.data(), block.size(), &plain) < 0 || plain != wanted ||
            blosc_decompress_ctx(block.data(), bytes.data() + done, std::size_t(wanted), 1) != int(wanted))
            return damaged;
        done += wanted;
    }
    return bytes;
}

class Reader {
  public:
    Reader(std::string_view bytes, std::string name, const LoadOptions& options)
        : bytes_(bytes), name_(std::move(name)), options_(options) {}

    Result<Scene> read() {
        ByteReader reader(bytes_);
        while (reader.remaining() > 0)
            if (Result<void> segment = read_segment(reader); !segment) return segment.error();
        tell_apart(grids_);
        if (!options_.grid.empty()) {
            std::string names;
            for (const Grid& grid : grids_) names += (names.empty() ? "'" : ", '") + grid.name + "'";
            std::erase_if(grids_, [&](const Grid& grid) { return grid.name != options_.grid; });
            if (grids_.empty() && !names.empty())
                return Error{fmt::format("it has no grid '{}'; it has {}", options_.grid, names)};
        }
        if (grids_.empty()) return Error{left_out_.empty() ? "it holds no grids" : left_out_.front()};
        Scene scene = volume_scene(std::move(grids_));
        scene.notes = std::move(left_out_);
        return scene;
    }

  private:
    Result<void> read_segment(ByteReader& reader) {
        if (reader.take(8) != "NanoVDB0") return Error{"it is not a NanoVDB file"};
        const std::uint32_t version = reader.u32();
        const std::uint16_t count = reader.u16(), codec = reader.u16();
        if (version >> 21 != NANOVDB_MAJOR_VERSION_NUMBER)
            return Error{fmt::format("it is of version {} of the format; readable is {}", version >> 21,
                                     NANOVDB_MAJOR_VERSION_NUMBER)};
        std::vector<Entry> entries;
        for (int i = 0; i < count; ++i) {
            const std::string_view raw = reader.take(GRID_ENTRY);
            if (!reader.ok()) return Error{"it is cut off"};
            Entry entry;
            std::memcpy(&entry.size, raw.data(), 8);
            std::memcpy(&entry.file_size, raw.data() + 8, 8);
            std::memcpy(&entry.name_size, raw.data() + 136, 4);
            reader.take(entry.name_size);
            if (!reader.ok()) return Error{"it is cut off"};
            entries.push_back(entry);
        }
        for (const Entry& entry : entries) {
            const std::string_view packed = reader.take(std::size_t(entry.file_size));
            if (!reader.ok()) return Error{"it is cut off"};
            if (entry.size > MAX_VOLUME_BYTES || entry.size < sizeof(nanovdb::GridData))
                return Error{fmt::format("its grid has {} bytes; {} to {} are allowed", entry.size,
                                         sizeof(nanovdb::GridData), MAX_VOLUME_BYTES)};
            Result<GridBytes> bytes = unpacked(packed, codec, entry.size);
            if (!bytes) return bytes.error();
            if (Result<void> added = add(*bytes); !added) return added.error();
        }
        return {};
    }

    Result<void> add(GridBytes& bytes) {
        const auto& grid = *reinterpret_cast<const nanovdb::GridData*>(bytes.data());
        if (grid.mMagic != NANOVDB_MAGIC_NUMBER) return Error{"its grid is damaged"};
        using nanovdb::GridType;
        switch (grid.mGridType) {
            case GridType::Float: return add_samples<float>(bytes, grid, 1);
            case GridType::Double: return add_samples<double>(bytes, grid, 1);
            case GridType::Fp4: return add_samples<nanovdb::Fp4>(bytes, grid, 1);
            case GridType::Fp8: return add_samples<nanovdb::Fp8>(bytes, grid, 1);
            case GridType::Fp16: return add_samples<nanovdb::Fp16>(bytes, grid, 1);
            case GridType::FpN: return add_samples<nanovdb::FpN>(bytes, grid, 1);
            case GridType::Vec3f: return add_samples<nanovdb::Vec3f>(bytes, grid, 3);
            case GridType::Vec3d: return add_samples<nanovdb::Vec3d>(bytes, grid, 3);
            default: break;
        }
        const auto type = std::uint32_t(grid.mGridType);
        left_out_.push_back(
            fmt::format("its grid '{}' of type {} is left out", name_of(grid),
                        type < std::uint32_t(GridType::End) ? nanovdb::toStr(grid.mGridType) : std::to_string(type)));
        return {};
    }

    std::string name_of(const nanovdb::GridData& grid) const {
        const std::string name(grid.mGridName, strnlen(grid.mGridName, nanovdb::GridData::MaxNameSize));
        return name.empty() ? name_ : name;
    }

    template <class BuildT>
    Result<void> add_samples(GridBytes& bytes, const nanovdb::GridData& grid, int channels) {
        const std::string name = name_of(grid);
        const auto refused = [&](const std::string& why) { return Error{fmt::format("its grid '{}' {}", name, why)}; };
        NanoTree<BuildT> tree;
        if (const auto complaint = tree.read(bytes.data(), bytes.size())) return refused(*complaint);
        if (tree.empty()) {
            left_out_.push_back(fmt::format("its grid '{}' has no active voxel", name));
            return {};
        }
        constexpr int far = 1 << 29;
        if (glm::any(glm::lessThan(tree.lower(), ivec3(-far))) || glm::any(glm::greaterThan(tree.upper(), ivec3(far))))
            return refused("reaches too far from its origin");
        // A sample more all around, as for .vdb; bricks are NanoVDB's leaves.
        const ivec3 origin = (tree.lower() - 1) & ~7;
        const ivec3 size = tree.upper() - origin + 2;
        const bool level_set = grid.mGridClass == nanovdb::GridClass::LevelSet && channels == 1;
        Result<GridPointer> samples = build_grid(size, channels, [&](ivec3 lower, std::span<float> brick) {
            return tree.fill(origin + lower, channels, brick);
        });
        if (!samples) return refused(samples.error().message);
        Grid read;
        read.name = name;
        read.samples = *samples;
        read.background = nano_component(tree.background(), 0);
        read.level_set = level_set;
        const double* m = grid.mMap.mMatD;
        const glm::dvec3 first(glm::dvec3(origin) - 0.5);
        glm::dmat4x3 to_world;
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) to_world[column][row] = m[3 * row + column];
            to_world[3][row] = grid.mMap.mVecD[row];
        }
        to_world[3] += to_world[0] * first.x + to_world[1] * first.y + to_world[2] * first.z;
        read.index_to_local = mat4x3(to_world);
        if (const auto fault = transform_fault(read.index_to_local)) return refused(*fault);
        if (!std::isfinite(read.background)) return refused("has a background that is not finite");
        grids_.push_back(std::move(read));
        return {};
    }

    std::string_view bytes_;
    std::string name_;
    const LoadOptions& options_;
    std::vector<Grid> grids_;
    std::vector<std::string> left_out_;
};

}  // namespace

Result<Scene> load_nvdb(const std::filesystem::path& path, const LoadOptions& options) {
    const Result<std::string> bytes = read_file_bytes(path, MAX_VOLUME_BYTES);
    if (!bytes) return bytes.error();
    Result<Scene> scene = Reader(*bytes, path.stem().string(), options).read();
    return scene ? std::move(scene) : Result<Scene>(cannot_read(path, scene.error().message));
}

}  // namespace spinel
