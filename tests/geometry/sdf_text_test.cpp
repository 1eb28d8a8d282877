#include "geometry/sdf/sdf_text.h"

#include <gtest/gtest.h>

#include "geometry/sdf/sdf_ops.h"

namespace spinel::sdf_text_test {
namespace {

bool same(const SdfNode& a, const SdfNode& b) {
    if (a.op != b.op || a.numbers != b.numbers || a.children.size() != b.children.size()) return false;
    for (std::size_t i = 0; i < a.children.size(); i++)
        if (!same(a.children[i], b.children[i])) return false;
    return true;
}

TEST(SdfText, reads_numbers_before_children_comments_and_space) {
    Result<SdfNode> node = parse_sdf_text(
        "# a die\ndifference( box(2,2, +2),  # body\n\ttranslate(.5, -0, 1e-1, sphere(1)))\n# end", "die.sdf");
    ASSERT_TRUE(node) << node.error().message;
    SdfNode expected{"difference", {}, {{"box", {2, 2, 2}, {}}, {"translate", {0.5f, 0, 0.1f}, {{"sphere", {1}, {}}}}}};
    EXPECT_TRUE(same(*node, expected)) << sdf_text(*node);
}

TEST(SdfText, round_trips_every_operation_bit_by_bit) {
    for (const SdfOperation& operation : sdf_operations()) {
        Result<SdfNode> node = parse_sdf_text(operation.example, "table");
        ASSERT_TRUE(node) << node.error().message;
        EXPECT_EQ(sdf_text(*node), operation.example);
    }
    SdfNode odd{"translate", {0.1f, -1.0f / 3, 1.17549435e-38f}, {{"sphere", {123456.789f}, {}}}};
    Result<SdfNode> again = parse_sdf_text(sdf_text(odd), "");
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_TRUE(same(odd, *again)) << sdf_text(odd);
}

TEST(SdfText, errors_tell_line_column_and_what_was_expected) {
    struct Case {
        const char* text;
        const char* expected;
    };
    for (const Case& c : {
             Case{"", "f:1:1: expected an operation, found the end"},
             Case{"spheer(1)", "f:1:1: unknown operation 'spheer'; available: sphere, "},
             Case{"Sphere(1)", "f:1:1: unknown operation 'Sphere'"},
             Case{"sphere", "f:1:7: expected '(' after sphere, found the end"},
             Case{"sphere(1", "f:1:9: expected ',' or ')', found the end"},
             Case{"sphere(1) x", "f:1:11: expected the end, found 'x'"},
             Case{"union(\n  sphere(1),\n  box(1, 2))", "f:3:3: box takes numbers: x, y, z; 2 given"},
             Case{"union(sphere(1),)", "f:1:17: expected a number or an operation, found ')'"},
             Case{"translate(1, 2, sphere(1), 3)", "f:1:28: the numbers of translate stand before its children"},
             Case{"sphere(-)", "f:1:8: expected a number, found '-'"},
             Case{"sphere(1e99)", "f:1:8: the number is beyond the range of single precision"},
             Case{"sphere(-inf)", "f:1:8: expected a number"},
             Case{"sphere(\x01)", "f:1:8: expected a number or an operation, found byte 0x01"},
             Case{"sphere(0)", "f:1:1: radius of sphere is 0, allowed is 1e-06 to "},
             Case{"twist(1)", "f:1:1: twist takes one child; 0 given"},
         }) {
        Result<SdfNode> node = parse_sdf_text(c.text, "f");
        ASSERT_FALSE(node) << c.text;
        EXPECT_EQ(node.error().message.substr(0, std::string(c.expected).size()), c.expected);
    }
}

TEST(SdfText, refuses_bottomless_nesting) {
    std::string text;
    for (int i = 0; i < 100000; i++) text += "offset(0,";
    Result<SdfNode> node = parse_sdf_text(text, "f");
    ASSERT_FALSE(node);
    EXPECT_NE(node.error().message.find("nested deeper than 200"), std::string::npos) << node.error().message;
}

}  // namespace
}  // namespace spinel::sdf_text_test
