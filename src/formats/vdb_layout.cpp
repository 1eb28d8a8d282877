#include "formats/vdb_layout.h"

#include <algorithm>
#include <cstdint>
#include <fstream>

#include "formats/file_bytes.h"

namespace spinel {
namespace {

using Complaint = std::optional<std::string>;

constexpr std::int64_t VDB_MAGIC = 0x56444220;
constexpr std::uintmax_t MAX_VDB_FILE = std::uintmax_t(1) << 34;
constexpr std::uint32_t OLDEST = 220, NEWEST = 224;  // versions of the format
constexpr std::uint32_t NO_COMPRESSION_FLAG = 222;   // from which on each grid has its own
constexpr std::uint32_t MAX_GRIDS = 4096;
constexpr std::uint32_t MAX_NAME = 65536;

class Layout {
  public:
    Layout(std::ifstream file, std::uint64_t size) : file_(std::move(file)), size_(size) {}

    Complaint read() {
        if (number<std::int64_t>() != VDB_MAGIC || !file_) return "it is not an OpenVDB file";
        const auto version = number<std::uint32_t>();
        skip(8);  // the library's version
        const bool has_offsets = number<char>() != 0;
        if (version < OLDEST || version > NEWEST)
            return "it is of version " + std::to_string(version) + " of the format; readable are " +
                   std::to_string(OLDEST) + " to " + std::to_string(NEWEST);
        if (version < NO_COMPRESSION_FLAG) skip(1);
        skip(36);  // a unique name
        if (Complaint complaint = skip_metadata()) return complaint;
        const auto count = number<std::uint32_t>();
        if (!file_ || count > MAX_GRIDS)
            return "it states more grids than the " + std::to_string(MAX_GRIDS) + " allowed";
        for (std::uint32_t i = 0; i < count; ++i) {
            if (Complaint complaint = read_grid(has_offsets)) return complaint;
            if (!has_offsets) break;
        }
        return {};
    }
    std::vector<VdbGridEntry>& grids() { return grids_; }

  private:
    static constexpr const char* CUT_OFF = "it is cut off, or damaged";

    std::uint64_t position() { return file_ ? std::uint64_t(file_.tellg()) : size_; }

    template <class T>
    T number() {
        T value{};
        file_.read(reinterpret_cast<char*>(&value), sizeof value);
        return value;
    }
    void skip(std::uint64_t bytes) {
        if (bytes > size_ - std::min(position(), size_)) file_.setstate(std::ios::failbit);
        else file_.seekg(std::streamoff(bytes), std::ios::cur);
    }
    std::string name() {
        const auto length = number<std::uint32_t>();
        if (!file_ || length > MAX_NAME) {
            file_.setstate(std::ios::failbit);
            return {};
        }
        std::string text(length, '\0');
        file_.read(text.data(), std::streamsize(length));
        return text;
    }

    Complaint skip_metadata() {
        const auto count = number<std::uint32_t>();
        for (std::uint32_t i = 0; i < count && file_; ++i) {
            name();
            name();                         // its type
            skip(number<std::uint32_t>());  // the value
        }
        if (!file_) return CUT_OFF;
        return {};
    }

    Complaint read_grid(bool has_offsets) {
        VdbGridEntry grid;
        grid.name = name();
        grid.name = grid.name.substr(0, grid.name.find('\x1e'));  // from here on a number tells equal names apart
        grid.type = name();
        name();  // of the grid whose tree it shares
        skip(8);
        skip(8);
        const auto end = number<std::int64_t>();
        skip(4);  // how it is compressed
        if (Complaint complaint = skip_metadata()) return complaint;
        name();  // the kind of its transform
        if (!file_) return CUT_OFF;
        grids_.push_back(std::move(grid));
        if (!has_offsets) return {};
        if (end < 0 || std::uint64_t(end) < position() || std::uint64_t(end) > size_) return CUT_OFF;
        file_.seekg(end);
        return {};
    }

    std::ifstream file_;
    std::uint64_t size_;
    std::vector<VdbGridEntry> grids_;
};

}  // namespace

Result<std::vector<VdbGridEntry>> read_vdb_layout(const std::filesystem::path& path) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) return cannot_read(path, "there is no such file");
    if (!std::filesystem::is_regular_file(path, error)) return cannot_read(path, "that is not a plain file");
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) return cannot_read(path, error.message());
    if (size > MAX_VDB_FILE)
        return cannot_read(path, "its " + std::to_string(size) + " bytes are more than the " +
                                     std::to_string(MAX_VDB_FILE) + " allowed");
    std::ifstream file(path, std::ios::binary);
    if (!file) return cannot_read(path, "the file cannot be opened");
    Layout layout(std::move(file), size);
    if (const Complaint complaint = layout.read()) return cannot_read(path, *complaint);
    return std::move(layout.grids());
}

}  // namespace spinel
