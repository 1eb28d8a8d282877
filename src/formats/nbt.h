#pragma once
// Named binary tags (NBT), the tree of values that Minecraft's files are made of. Big-endian; a list or compound holds
// further tags. Layout: minecraft.wiki/w/NBT_format.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace spinel::nbt {

enum class Type : std::uint8_t {
    end,
    int8,
    int16,
    int32,
    int64,
    float32,
    float64,
    int8_array,
    string,
    list,
    compound,
    int32_array,
    int64_array
};

struct Tag {
    Type type = Type::end;
    std::string_view name;      // within a compound
    std::int64_t integer = 0;   // of the four integer types
    double real = 0;            // of the two floating-point types
    std::string_view bytes;     // of a string; of an array its elements, big-endian
    std::vector<Tag> children;  // of a list or a compound

    // The child of that name; null: there is none, or not of that type.
    const Tag* find(std::string_view key) const;
    const Tag* find(std::string_view key, Type wanted) const;
    // Of an integer child of any width, or `otherwise`.
    std::int64_t integer_of(std::string_view key, std::int64_t otherwise) const;
    std::string_view string_of(std::string_view key) const;

    // Elements of an array, or children.
    std::size_t count() const;
    // Element i < count() of an array, sign-extended.
    std::int64_t element(std::size_t i) const;
};

struct Document {
    std::shared_ptr<const std::string> bytes;  // that the tags look into
    Tag root;                                  // a compound
};

// Of bytes as they are, not compressed.
Result<Document> parse(std::string bytes);

// The same of a gzip or zlib stream, or of plain bytes.
Result<Document> parse_packed(std::string bytes);

}  // namespace spinel::nbt
