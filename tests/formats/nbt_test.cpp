#include "formats/nbt.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include "formats/inflate.h"
#include "nbt_writer.h"
#include "test_files.h"

namespace spinel::nbt_test {
namespace {

std::string deflated(const std::string& plain, int window_bits) {
    z_stream stream{};
    deflateInit2(&stream, 9, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&stream, plain.size()) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(plain.data()));
    stream.avail_in = uInt(plain.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = uInt(out.size());
    deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}
std::string zlib_of(const std::string& plain) { return deflated(plain, 15); }
std::string gzip_of(const std::string& plain) { return deflated(plain, 15 + 16); }

// Every kind of tag once.
std::string rich_document() {
    using namespace nbt;
    return document({{"byte", int8(-3)},
                     {"short", int16(-300)},
                     {"int", int32(70000)},
                     {"long", {Type::int64, big_endian(std::int64_t(-5000000000))}},
                     {"float", {Type::float32, big_endian(std::uint32_t(0x3fc00000))}},
                     {"double", {Type::float64, big_endian(std::uint64_t(0xc004000000000000))}},
                     {"bytes", bytes("abc\xff")},
                     {"ints", {Type::int32_array, big_endian(std::int32_t(2)) + big_endian(7) + big_endian(-8)}},
                     {"longs", longs({1, ~0ull})},
                     {"list", list(Type::string, {text("x"), text("yz")})},
                     {"compound", compound({{"inner", int8(1)}})},
                     {"empty", list(Type::end, {})}});
}

TEST(Nbt, reads_every_kind_of_tag) {
    const Result<nbt::Document> document = nbt::parse(rich_document());
    ASSERT_TRUE(document) << document.error().message;
    const nbt::Tag& root = document->root;
    EXPECT_EQ(root.children.size(), 12u);
    EXPECT_EQ(root.integer_of("byte", 0), -3);
    EXPECT_EQ(root.integer_of("short", 0), -300);
    EXPECT_EQ(root.integer_of("int", 0), 70000);
    EXPECT_EQ(root.integer_of("long", 0), -5000000000);
    EXPECT_EQ(root.find("float")->real, 1.5);
    EXPECT_EQ(root.find("double")->real, -2.5);
    EXPECT_EQ(root.find("bytes")->count(), 4u);
    EXPECT_EQ(root.find("bytes")->element(3), -1);
    EXPECT_EQ(root.find("ints")->element(1), -8);
    EXPECT_EQ(root.find("longs")->element(1), -1);
    EXPECT_EQ(root.find("list")->children[1].bytes, "yz");
    EXPECT_EQ(root.find("compound")->integer_of("inner", 0), 1);
    EXPECT_EQ(root.find("empty")->count(), 0u);
    EXPECT_EQ(root.find("absent"), nullptr);
    EXPECT_EQ(root.find("list", nbt::Type::compound), nullptr);
    EXPECT_EQ(root.integer_of("list", 42), 42);
}

TEST(Nbt, is_the_same_packed_by_gzip_zlib_or_not_at_all) {
    for (const std::string& file : {rich_document(), gzip_of(rich_document()), zlib_of(rich_document())}) {
        const Result<nbt::Document> document = nbt::parse_packed(file);
        ASSERT_TRUE(document) << document.error().message;
        EXPECT_EQ(document->root.integer_of("int", 0), 70000);
    }
}

TEST(Nbt, is_refused_when_it_is_cut_anywhere) {
    const std::string whole = rich_document();
    for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(nbt::parse(whole.substr(0, size))) << size;
    const std::string packed = gzip_of(whole);
    for (std::size_t size = 0; size < packed.size(); ++size)
        EXPECT_FALSE(nbt::parse_packed(packed.substr(0, size))) << size;
}

TEST(Nbt, counts_that_lie_are_not_believed) {
    using namespace nbt;
    const auto lying = [](Type type, const std::string& payload) { return document({{"a", {type, payload}}}); };
    const std::string many = big_endian(std::int32_t(0x7fffffff));
    for (const Type type : {Type::int8_array, Type::int32_array, Type::int64_array})
        EXPECT_FALSE(parse(lying(type, many + "abc")));
    EXPECT_FALSE(parse(lying(Type::list, char(Type::compound) + many)));
    EXPECT_FALSE(parse(lying(Type::list, char(Type::end) + many)));
    EXPECT_FALSE(parse(lying(Type::list, "\x20" + big_endian(std::int32_t(1)))));
    EXPECT_FALSE(parse(lying(Type(13), "")));
    EXPECT_FALSE(parse(lying(Type::string, "\xff\xff")));
}

TEST(Nbt, nests_only_so_deep) {
    std::string deep(1, char(nbt::Type::compound));
    deep += nbt::counted("");
    for (int i = 0; i < 100000; ++i) deep += char(nbt::Type::compound) + nbt::counted("");
    const Result<nbt::Document> document = nbt::parse(deep);
    ASSERT_FALSE(document);
    EXPECT_NE(document.error().message.find("deeper"), std::string::npos) << document.error().message;
    std::string lists(1, char(nbt::Type::compound));
    lists += nbt::counted("") + char(nbt::Type::list) + nbt::counted("");
    for (int i = 0; i < 100000; ++i) lists += char(nbt::Type::list) + nbt::big_endian(std::int32_t(1));
    EXPECT_FALSE(nbt::parse(lists));
}

TEST(Inflate, stops_at_its_bound) {
    const std::string bomb = gzip_of(std::string(std::size_t(1) << 24, 'a'));
    EXPECT_LT(bomb.size(), 100000u);
    EXPECT_TRUE(inflated(bomb, std::size_t(1) << 24));
    const Result<std::string> cut = inflated(bomb, (std::size_t(1) << 24) - 1);
    ASSERT_FALSE(cut);
    EXPECT_NE(cut.error().message.find("more than"), std::string::npos);
}

TEST(Inflate, joins_the_members_of_a_gzip_file) {
    const Result<std::string> both = inflated(gzip_of("one ") + gzip_of("two"), 100);
    ASSERT_TRUE(both);
    EXPECT_EQ(*both, "one two");
}

// "abcabcabcabc" and a literal end: four literals and a match that overlaps itself.
const std::string lz4_block = std::string(
    "\x36"
    "abc"
    "\x03\x00"
    "\x20"
    "xy",
    9);
std::string lz4_frame(char method, const std::string& block, std::size_t size) {
    return "LZ4Block" + std::string(1, method) + raw(std::uint32_t(block.size())) + raw(std::uint32_t(size)) + raw(0u) +
           block;
}
const std::string lz4_end = lz4_frame(0x10, "", 0);

TEST(Inflate, unpacks_lz4) {
    // 3 literals, then 10 more from 3 back, then 2 literals.
    const Result<std::string> text = lz4_unpacked(lz4_frame(0x25, lz4_block, 15) + lz4_end, 100);
    ASSERT_TRUE(text) << text.error().message;
    EXPECT_EQ(*text, "abcabcabcabcaxy");
    EXPECT_EQ(*lz4_unpacked(lz4_frame(0x15, "plain", 5) + lz4_end, 100), "plain");
    EXPECT_FALSE(lz4_unpacked(lz4_frame(0x25, lz4_block, 14), 100));
    EXPECT_FALSE(lz4_unpacked(lz4_frame(0x25, lz4_block, 15), 14));
    EXPECT_FALSE(lz4_unpacked(lz4_frame(0x25,
                                        std::string("\x30"
                                                    "abc"
                                                    "\x09\x00",
                                                    6),
                                        7),
                              100));  // from before the start
    EXPECT_FALSE(lz4_unpacked("nonsense", 100));
}

}  // namespace
}  // namespace spinel::nbt_test
