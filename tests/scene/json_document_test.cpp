#include "scene/json_document.h"

#include <gtest/gtest.h>

namespace spinel::json_document_test {
namespace {

std::string message(const std::string& text) {
    const auto document = parse_json(text, "a.json");
    return document ? "no error" : document.error().message;
}

std::string position(const JsonDocument& document, const JsonValue& value) {
    return document.error(value.offset, "").message;
}

TEST(JsonDocument, every_value_knows_its_line_and_column) {
    const auto document = parse_json(
        "{ // a comment with \"quotes\", {braces} and [brackets]\n"
        "  \"a\" : [1.5e+3, -2,\n"
        "    true, null , \"x\\\"y\\\\\"],\n"
        "  /* : , \" */ \"é\": {\"b\": {}}\n"
        "}",
        "a.json");
    ASSERT_TRUE(document) << document.error().message;
    const JsonValue& root = document->root;
    EXPECT_EQ(position(*document, root), "a.json:1:1: ");
    const JsonValue::Array& a = *root.find("a")->array();
    ASSERT_EQ(a.size(), 5u);
    EXPECT_EQ(position(*document, *root.find("a")), "a.json:2:9: ");
    EXPECT_EQ(position(*document, a[0]), "a.json:2:10: ");
    EXPECT_EQ(*a[0].number(), 1500);
    EXPECT_EQ(position(*document, a[1]), "a.json:2:18: ");
    EXPECT_EQ(*a[1].number(), -2);
    EXPECT_EQ(position(*document, a[2]), "a.json:3:5: ");
    EXPECT_EQ(*a[2].boolean(), true);
    EXPECT_EQ(position(*document, a[3]), "a.json:3:11: ");
    EXPECT_TRUE(a[3].is_null());
    EXPECT_EQ(position(*document, a[4]), "a.json:3:18: ");
    EXPECT_EQ(*a[4].text(), "x\"y\\");
    const JsonMember& second = (*root.object())[1];
    EXPECT_EQ(second.key, "é");
    EXPECT_EQ(document->error(second.offset, "").message, "a.json:4:15: ");
    // One column a character: the two bytes of é count once.
    EXPECT_EQ(position(*document, second.value), "a.json:4:20: ");
    EXPECT_EQ(position(*document, *second.value.find("b")), "a.json:4:26: ");
}

TEST(JsonDocument, a_byte_order_mark_is_skipped) {
    const auto document = parse_json("\xEF\xBB\xBF{\"a\": 1}", "a.json");
    ASSERT_TRUE(document) << document.error().message;
    EXPECT_EQ(document->root.find("a")->offset, 9u);
}

TEST(JsonDocument, wrong_syntax_is_pointed_at) {
    EXPECT_EQ(message("{\"a\": 1,}"),
              "a.json:1:9: syntax error while parsing object key - unexpected '}'; expected string literal");
    EXPECT_EQ(message("{\"a\":\n [1, 2"),
              "a.json:2:7: syntax error while parsing array - unexpected end of input; expected ']'");
    EXPECT_EQ(message("[1, 2] 3"),
              "a.json:1:8: syntax error while parsing value - unexpected number literal; expected end of input");
    EXPECT_EQ(message("").substr(0, 12), "a.json:1:1: ");
    EXPECT_EQ(message("{\"a\": NaN}").substr(0, 11), "a.json:1:7:");
    EXPECT_NE(message("{\"a\": \"\xff\"}").find("ill-formed UTF-8"), std::string::npos);
}

TEST(JsonDocument, a_number_beyond_a_double_is_an_error) {
    EXPECT_EQ(message("[0, 1e999]"), "a.json:1:5: number 1e999 is out of range");
}

TEST(JsonDocument, a_key_twice_is_an_error_at_the_second) {
    EXPECT_EQ(message("{\"a\": 1, \"b\": 2,\n \"a\": 3}"), "a.json:2:2: key \"a\" stands twice in this object");
    EXPECT_EQ(message("{\"a\": {\"b\": 1}, \"b\": {\"a\": 1}}"), "no error");
}

TEST(JsonDocument, depth_is_limited) {
    EXPECT_EQ(message(std::string(512, '[') + std::string(512, ']')), "no error");
    EXPECT_EQ(message(std::string(100000, '[')), "a.json:1:513: nested more than 512 levels deep");
}

TEST(JsonDocument, size_is_limited) {
    EXPECT_EQ(message(std::string((std::size_t(64) << 20) + 1, ' ')).substr(0, 22), "a.json: 64 MiB of JSON");
}

}  // namespace
}  // namespace spinel::json_document_test
