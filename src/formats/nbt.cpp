#include "formats/nbt.h"

#include <algorithm>
#include <bit>
#include <optional>

#include "formats/byte_reader.h"
#include "formats/inflate.h"

namespace spinel::nbt {
namespace {

constexpr std::size_t MAX_BYTES = std::size_t(1) << 30;
constexpr std::size_t MAX_TAGS = std::size_t(1) << 22;  // a tag of one byte becomes one of a hundred
constexpr int MAX_NBT_DEPTH = 512;                      // the game's own bound

std::size_t element_size(Type array) { return array == Type::int8_array ? 1 : array == Type::int32_array ? 4 : 8; }

class Parser {
  public:
    explicit Parser(std::string_view bytes) : reader_(bytes) {}

    Result<Tag> parse() {
        const std::uint8_t type = reader_.u8();
        if (!reader_.ok() || type != std::uint8_t(Type::compound))
            return Error{"it is not NBT (it does not begin with a compound tag)"};
        Tag root;
        root.type = Type::compound;
        root.name = read_string();
        if (const auto complaint = read_payload(root, 0))
            return Error{"byte " + std::to_string(reader_.offset()) + ": " + *complaint};
        return root;
    }

  private:
    using Complaint = std::optional<std::string>;

    std::string_view read_string() { return reader_.take(reader_.u16_be()); }

    // A count that the file announces, if it has that many bytes left at `least` bytes each.
    std::optional<std::size_t> read_count(std::size_t least) {
        const auto count = std::int32_t(reader_.u32_be());
        if (count <= 0) return 0;
        if (std::size_t(count) > reader_.remaining() / least) return std::nullopt;
        return std::size_t(count);
    }

    Complaint read_payload(Tag& tag, int depth) {
        if (++tags_ > MAX_TAGS) return "it holds more than the " + std::to_string(MAX_TAGS) + " tags allowed";
        switch (tag.type) {
            case Type::int8: tag.integer = std::int8_t(reader_.u8()); break;
            case Type::int16: tag.integer = std::int16_t(reader_.u16_be()); break;
            case Type::int32: tag.integer = std::int32_t(reader_.u32_be()); break;
            case Type::int64: tag.integer = std::int64_t(reader_.u64_be()); break;
            case Type::float32: tag.real = double(std::bit_cast<float>(reader_.u32_be())); break;
            case Type::float64: tag.real = std::bit_cast<double>(reader_.u64_be()); break;
            case Type::string: tag.bytes = read_string(); break;
            case Type::int8_array:
            case Type::int32_array:
            case Type::int64_array: {
                const auto count = read_count(element_size(tag.type));
                if (!count) return "an array is longer than the file";
                tag.bytes = reader_.take(*count * element_size(tag.type));
                break;
            }
            case Type::list: return read_list(tag, depth + 1);
            case Type::compound: return read_compound(tag, depth + 1);
            case Type::end: break;  // read_type() lets none through
        }
        if (!reader_.ok()) return "it ends within a tag";
        return {};
    }

    Complaint read_list(Tag& tag, int depth) {
        if (depth > MAX_NBT_DEPTH)
            return "its tags nest deeper than the " + std::to_string(MAX_NBT_DEPTH) + " levels allowed";
        const std::uint8_t type = reader_.u8();
        if (type > std::uint8_t(Type::int64_array)) return "a list holds tags of unknown type " + std::to_string(type);
        const auto count = read_count(1);
        if (!reader_.ok()) return "it ends within a tag";
        if (!count || *count > MAX_TAGS - tags_) return "a list is longer than the file, or than allowed";
        if (*count > 0 && type == std::uint8_t(Type::end)) return "a list holds tags without a type";
        tag.children.reserve(std::min<std::size_t>(*count, 64));  // lists of lists may announce far more than there is
        for (std::size_t i = 0; i < *count; ++i) {
            tag.children.emplace_back().type = Type(type);
            if (Complaint complaint = read_payload(tag.children.back(), depth)) return complaint;
        }
        return {};
    }

    Complaint read_compound(Tag& tag, int depth) {
        if (depth > MAX_NBT_DEPTH)
            return "its tags nest deeper than the " + std::to_string(MAX_NBT_DEPTH) + " levels allowed";
        while (true) {
            const std::uint8_t type = reader_.u8();
            if (!reader_.ok()) return "it ends within a compound";
            if (type == std::uint8_t(Type::end)) return {};
            if (type > std::uint8_t(Type::int64_array)) return "a tag has unknown type " + std::to_string(type);
            Tag& child = tag.children.emplace_back();
            child.type = Type(type);
            child.name = read_string();
            if (Complaint complaint = read_payload(child, depth)) return complaint;
        }
    }

    ByteReader reader_;
    std::size_t tags_ = 0;
};

}  // namespace

const Tag* Tag::find(std::string_view key) const {
    if (type != Type::compound) return nullptr;
    for (const Tag& child : children)
        if (child.name == key) return &child;
    return nullptr;
}

const Tag* Tag::find(std::string_view key, Type wanted) const {
    const Tag* found = find(key);
    return found && found->type == wanted ? found : nullptr;
}

std::int64_t Tag::integer_of(std::string_view key, std::int64_t otherwise) const {
    const Tag* found = find(key);
    return found && found->type >= Type::int8 && found->type <= Type::int64 ? found->integer : otherwise;
}

std::string_view Tag::string_of(std::string_view key) const {
    const Tag* found = find(key, Type::string);
    return found ? found->bytes : std::string_view();
}

std::size_t Tag::count() const {
    const bool array = type == Type::int8_array || type == Type::int32_array || type == Type::int64_array;
    return array ? bytes.size() / element_size(type) : children.size();
}

std::int64_t Tag::element(std::size_t i) const {
    const std::size_t size = element_size(type);
    ByteReader reader(bytes.substr(i * size, size));
    if (size == 1) return std::int8_t(reader.u8());
    if (size == 4) return std::int32_t(reader.u32_be());
    return std::int64_t(reader.u64_be());
}

Result<Document> parse(std::string bytes) {
    auto kept = std::make_shared<const std::string>(std::move(bytes));
    Result<Tag> root = Parser(*kept).parse();
    if (!root) return root.error();
    return Document{std::move(kept), std::move(*root)};
}

Result<Document> parse_packed(std::string bytes) {
    if (!looks_deflated(bytes)) return parse(std::move(bytes));
    Result<std::string> plain = inflated(bytes, MAX_BYTES);
    if (!plain) return plain.error();
    return parse(std::move(*plain));
}

}  // namespace spinel::nbt
