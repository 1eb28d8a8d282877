// Formulas, and scenes whose values are formulas of time.

#include <gtest/gtest.h>

#include <cmath>

#include "scene/expression.h"
#include "scene/json_test.h"

namespace spinel::animation_test {
namespace {

using namespace test;

double value(std::string_view text, const Variables& variables = {}) {
    const auto result = evaluate_expression(text, variables);
    if (const auto* fault = std::get_if<ExpressionFault>(&result)) {
        ADD_FAILURE() << text << ": " << fault->position << ": " << fault->message;
        return NAN;
    }
    return std::get<double>(result);
}

std::string fault(std::string_view text) {
    const auto result = evaluate_expression(text, {{"t", 1}});
    const auto* f = std::get_if<ExpressionFault>(&result);
    return f ? std::to_string(f->position) + ": " + f->message.substr(0, 40) : "no fault";
}

TEST(Expression, operators_have_the_usual_precedence) {
    EXPECT_EQ(value("1 + 2*3"), 7);
    EXPECT_EQ(value("(1 + 2)*3"), 9);
    EXPECT_EQ(value("8/4/2"), 1);
    EXPECT_EQ(value("5 - 3 - 1"), 1);
    EXPECT_EQ(value("-2^2"), -4);
    EXPECT_EQ(value("2^-1"), 0.5);
    EXPECT_EQ(value("2^3^2"), 512);
    EXPECT_EQ(value("2*-3"), -6);
    EXPECT_EQ(value("1.5e2"), 150);
}

TEST(Expression, functions_and_names) {
    EXPECT_DOUBLE_EQ(value("0.85*cos(0.55*t)", {{"t", 2}}), 0.85 * std::cos(1.1));
    EXPECT_DOUBLE_EQ(value("sin(pi/2)"), 1);
    EXPECT_EQ(value("mod(-1, 3)"), 2);
    EXPECT_EQ(value("clamp(5, 0, 1)"), 1);
    EXPECT_EQ(value("mix(2, 4, 0.5)"), 3);
    EXPECT_EQ(value("step(1, 1)"), 1);
    EXPECT_EQ(value("step(1, 0.9)"), 0);
    EXPECT_EQ(value("smoothstep(0, 2, 1)"), 0.5);
    EXPECT_EQ(value("fract(-0.25)"), 0.75);
}

TEST(Expression, keys_are_linear_between_and_constant_outside) {
    EXPECT_EQ(value("keys(-1, 0, 10, 2, 20, 3, 0)"), 10);
    EXPECT_EQ(value("keys(1, 0, 10, 2, 20, 3, 0)"), 15);
    EXPECT_EQ(value("keys(2, 0, 10, 2, 20, 3, 0)"), 20);
    EXPECT_EQ(value("keys(9, 0, 10, 2, 20, 3, 0)"), 0);
}

TEST(Expression, random_stays_for_a_whole_number_and_differs_between_them) {
    EXPECT_EQ(value("random(3.1, 1)"), value("random(3.9, 1)"));
    EXPECT_NE(value("random(3, 1)"), value("random(4, 1)"));
    EXPECT_NE(value("random(3, 1)"), value("random(3, 2)"));
    double sum = 0;
    for (int i = 0; i < 1000; ++i) sum += value("random(n)", {{"n", i}});
    EXPECT_NEAR(sum / 1000, 0.5, 0.04);
}

TEST(Expression, faults_say_where) {
    EXPECT_EQ(fault("1 +"), "3: expected a number, a name or '(', found ");
    EXPECT_EQ(fault("2 * speed"), "4: unknown name 'speed'; there are pi, t, a");
    EXPECT_EQ(fault("sin(1, 2)"), "0: sin takes other arguments: sin(x)");
    EXPECT_EQ(fault("keys(t, 1)"), "0: keys takes other arguments: keys(t, t0, ");
    EXPECT_EQ(fault("(1"), "2: expected ')', found the end");
    EXPECT_EQ(fault("1 2"), "2: expected an operator or the end, found '");
    EXPECT_EQ(fault("1/0"), "0: the value is not a finite number");
}

Scene at(const std::string& text, int frame, double fps = 0) {
    Result<Scene> scene = read_scene_json(text, "scenes/a.json", fake_loaders(), {frame, fps});
    if (scene) return *std::move(scene);
    ADD_FAILURE() << scene.error().message;
    return {};
}

constexpr const char* moving = R"({"version": 1,
  "camera": {"from": [0, 0, 5]},
  "lights": [{"name": "lamp", "type": "point", "position": [1, 2, 3]}],
  "animation": {"fps": 10, "variables": {"speed": 2, "way": "speed*t"},
    "values": {"/camera/from/0": "way", "/lights/lamp/position": [0, "1 + t", 7], "/lights/0/position/2": "frame"}}})";

TEST(Animation, values_follow_time) {
    const Scene first = at(moving, 0), later = at(moving, 15), other_rate = at(moving, 15, 5);
    EXPECT_EQ(first.cameras[0].from, vec3(0, 0, 5));
    EXPECT_EQ(later.cameras[0].from, vec3(3, 0, 5));
    EXPECT_EQ(std::get<PointLight>(later.lights[0].data).position, vec3(0, 2.5f, 15));
    EXPECT_EQ(other_rate.cameras[0].from, vec3(6, 0, 5));
    EXPECT_EQ(scene_of(moving).cameras[0].from, vec3(0, 0, 5));  // nobody asked: frame 0
}

std::string animated(const std::string& animation) {
    return "{\"version\": 1, \"camera\": {\"fov\": 40},\n\"animation\": " + animation + "}";
}

TEST(Animation, errors_say_where) {
    EXPECT_EQ(message(animated(R"({"values": {"/camera/fov": "40 + x"}})")).substr(0, 57),
              "a.json:2:47: in \"40 + x\": unknown name 'x'; there are pi,");
    EXPECT_EQ(message(animated(R"({"values": {"/camera/from": 1}})")),
              "a.json:2:26: \"/camera/from\" of animation: there is no /camera/from in the scene; write its value at "
              "rest there");
    EXPECT_EQ(message(animated(R"({"values": {"camera": 1}})")),
              "a.json:2:26: \"camera\" of animation: a place begins with /, as /camera/from/0");
    EXPECT_EQ(message(animated(R"({"speed": 1})")).substr(0, 40), "a.json:2:15: unknown key \"speed\" in anim");
    EXPECT_EQ(message(animated(R"({"fps": 0})")).substr(0, 34), "a.json:2:22: \"fps\" of animation is");
    EXPECT_NE(message(animated(R"({"variables": {"sin": 1}})")).find("cannot be the name of a variable"),
              std::string::npos);
    // What comes out is checked like anything else, and the formula is where it stands.
    EXPECT_EQ(message(animated(R"({"values": {"/camera/fov": "200"}})")).substr(0, 41),
              "a.json:2:41: \"fov\" of camera is 200; allo");
}

TEST(Animation, a_frame_of_a_scene_without_one_is_an_error) {
    const Result<Scene> scene = read_scene_json("{\"version\": 1}", "a.json", fake_loaders(), {.frame = 3, .fps = 0});
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().message, "a.json: a frame is asked for, but the scene has no \"animation\"");
}

}  // namespace
}  // namespace spinel::animation_test
