#include "formats/inflate.h"

#include <zlib.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "formats/byte_reader.h"

namespace spinel {
namespace {

constexpr std::string_view GZIP_MAGIC = "\x1f\x8b";

Error too_long(std::size_t max_bytes) {
    return {"it unpacks to more than the " + std::to_string(max_bytes) + " bytes allowed"};
}

// One block of LZ4: tokens of a run of literals and a match behind it. Appends to `out`, at most `size` bytes.
// Format: github.com/lz4/lz4, doc/lz4_Block_format.md.
bool unpack_lz4_block(std::string_view block, std::size_t size, std::string& out) {
    const std::size_t start = out.size();
    ByteReader reader(block);
    const auto length_of = [&](std::size_t length) {
        if (length < 15) return length;
        std::uint8_t more = 255;
        while (more == 255 && reader.ok()) length += more = reader.u8();
        return length;
    };
    while (reader.ok() && reader.remaining() > 0) {
        const std::uint8_t token = reader.u8();
        const std::string_view literals = reader.take(length_of(token >> 4));
        if (!reader.ok() || out.size() - start + literals.size() > size) return false;
        out += literals;
        if (reader.remaining() == 0) break;  // the last sequence has no match
        const std::size_t distance = reader.u16();
        const std::size_t length = length_of(token & 15) + 4;
        if (!reader.ok() || distance == 0 || distance > out.size() - start || out.size() - start + length > size)
            return false;
        for (std::size_t i = 0; i < length; ++i) out += out[out.size() - distance];  // may overlap itself
    }
    return reader.ok() && out.size() - start == size;
}

// Up to `max_bytes`; more of them are an error, or cut off.
Result<std::string> inflate_up_to(std::string_view packed, std::size_t max_bytes, bool cut) {
    z_stream stream{};
    if (inflateInit2(&stream, 15 + 32) != Z_OK) return Error{"zlib cannot start"};  // 32: gzip or zlib, by its head
    struct End {
        z_stream& stream;
        ~End() { inflateEnd(&stream); }
    } end{stream};
    std::string out;
    std::string block(std::size_t(1) << 16, '\0');
    std::size_t used = 0;
    while (true) {
        const std::size_t piece = std::min<std::size_t>(packed.size() - used, std::numeric_limits<uInt>::max());
        stream.next_in =
            reinterpret_cast<Bytef*>(const_cast<char*>(packed.data() + used));  // zlib does not write there
        stream.avail_in = uInt(piece);
        stream.next_out = reinterpret_cast<Bytef*>(block.data());
        stream.avail_out = uInt(block.size());
        const int status = inflate(&stream, Z_NO_FLUSH);
        used += piece - stream.avail_in;
        const std::size_t made = block.size() - stream.avail_out;
        if (out.size() + made > max_bytes && !cut) return too_long(max_bytes);
        out.append(block.data(), std::min(made, max_bytes - out.size()));
        if (cut && out.size() == max_bytes) return out;
        if (status == Z_STREAM_END) {
            if (!packed.substr(used).starts_with(GZIP_MAGIC)) return out;
            if (inflateReset(&stream) != Z_OK) return Error{"zlib cannot start"};
        } else if (status != Z_OK) {
            return Error{status == Z_BUF_ERROR ? "its compressed data ends early" : "its compressed data is damaged"};
        }
    }
}

}  // namespace

bool looks_deflated(std::string_view bytes) {
    if (bytes.size() < 2) return false;
    if (bytes.starts_with(GZIP_MAGIC)) return true;
    const unsigned head = unsigned(std::uint8_t(bytes[0])) << 8 | std::uint8_t(bytes[1]);
    return (head & 0x0f00) == 0x0800 && (head >> 12) <= 7 && head % 31 == 0;  // RFC 1950
}

Result<std::string> inflated(std::string_view packed, std::size_t max_bytes) {
    return inflate_up_to(packed, max_bytes, false);
}

Result<std::string> inflated_start(std::string_view packed, std::size_t bytes) {
    return inflate_up_to(packed, bytes, true);
}

Result<std::string> lz4_unpacked(std::string_view packed, std::size_t max_bytes) {
    ByteReader reader(packed);
    std::string out;
    while (reader.remaining() > 0) {
        if (reader.take(8) != "LZ4Block") return Error{"its LZ4 data does not begin with 'LZ4Block'"};
        const std::uint8_t method = reader.u8() & 0xf0;
        const std::uint32_t packed_size = reader.u32(), size = reader.u32();
        reader.u32();                         // checksum
        if (reader.ok() && size == 0) break;  // the end mark
        const std::string_view block = reader.take(packed_size);
        if (!reader.ok()) return Error{"its LZ4 data ends early"};
        if (size > max_bytes - out.size()) return too_long(max_bytes);
        if (method == 0x10 && block.size() == size) out += block;
        else if (method != 0x20 || !unpack_lz4_block(block, size, out)) return Error{"its LZ4 data is damaged"};
    }
    return out;
}

}  // namespace spinel
