#include "geometry/sdf/sdf_builder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/sdf/sdf_ops.h"
#include "geometry/sdf/sdf_reference.h"
#include "geometry/sdf_test_scene.h"

namespace spinel::sdf_builder_test {
namespace {

using glm::dvec3;

// Every row of the table, so that a new operation is tested by having an example.
class SdfOperationTest : public testing::TestWithParam<std::size_t> {
  protected:
    const SdfOperation& operation() const { return sdf_operations()[GetParam()]; }
    std::string example() const { return std::string(operation().example); }
};
INSTANTIATE_TEST_SUITE_P(Table, SdfOperationTest, testing::Range(std::size_t(0), sdf_operations().size()),
                         [](const auto& info) { return std::string(sdf_operations()[info.param].name); });

TEST_P(SdfOperationTest, has_documentation_and_an_example_that_uses_it) {
    EXPECT_FALSE(operation().doc.empty());
    EXPECT_NE(example().find(std::string(operation().name) + "("), std::string::npos);
    for (const SdfParameter& parameter : operation().parameters) EXPECT_FALSE(parameter.doc.empty());
}

TEST_P(SdfOperationTest, sign_agrees_with_the_reference) {
    SdfTestScene scene(example());
    SdfRandom random(11);
    int inside = 0;
    for (int i = 0; i < 20000; i++) {
        vec3 margin = 0.1f * (scene.upper() - scene.lower());
        vec3 p = random.in_box(scene.lower() - margin, scene.upper() + margin);
        double expected = sdf_reference(scene.root, dvec3(p));
        float f = scene.distance(p);
        inside += f < 0;
        if (std::abs(expected) < 1e-5) continue;
        ASSERT_EQ(f < 0, expected < 0) << example() << " at " << p.x << " " << p.y << " " << p.z;
        if (operation().role != SdfRole::repeat) { ASSERT_NEAR(f, expected, 1e-5) << example(); }
    }
    EXPECT_GT(inside, 200);
    EXPECT_LT(inside, 19900);
}

TEST_P(SdfOperationTest, gradient_equals_finite_differences) {
    SdfTestScene scene(example());
    SdfRandom random(12);
    const float h = 2e-3f;
    int compared = 0, creases = 0;
    for (int i = 0; i < 5000; i++) {
        vec3 p = random.in_box(scene.lower(), scene.upper());
        vec4 g = scene.gradient(p);
        ASSERT_NEAR(g.w, scene.distance(p), 2e-6f);
        vec3 difference;
        float second = 0;  // curvature: large where a crease lies within h
        for (int axis = 0; axis < 3; axis++) {
            vec3 e(0);
            e[axis] = h;
            float plus = scene.distance(p + e), minus = scene.distance(p - e);
            difference[axis] = (plus - minus) / (2 * h);
            second = std::max(second, std::abs(plus + minus - 2 * g.w) / (h * h));
        }
        if (second > 10) {
            creases++;
            continue;
        }
        compared++;
        ASSERT_LT(glm::length(difference - vec3(g)), 0.03f)
            << example() << " at " << p.x << " " << p.y << " " << p.z << " curvature " << second;
    }
    EXPECT_GT(compared, 10 * creases);
}

TEST_P(SdfOperationTest, lipschitz_constant_holds_within_the_bounds) {
    SdfTestScene scene(example());
    SdfRandom random(13);
    float steepest = 0;
    for (int i = 0; i < 20000; i++) {
        vec3 p = random.in_box(scene.lower(), scene.upper());
        vec3 q = i % 2 ? random.in_box(scene.lower(), scene.upper())
                       : glm::clamp(p + random.direction() * 0.01f, scene.lower(), scene.upper());
        float slope = std::abs(scene.distance(p) - scene.distance(q));
        ASSERT_LE(slope, scene.data.sdf.lipschitz * glm::length(p - q) + 2e-6f) << example();
        steepest = std::max(steepest, glm::length(vec3(scene.gradient(p))));
    }
    EXPECT_LE(steepest, scene.data.sdf.lipschitz * 1.0001f);
    EXPECT_GT(steepest, 0.3f * scene.data.sdf.lipschitz) << "needlessly large";
}

TEST_P(SdfOperationTest, bounds_contain_the_solid) {
    SdfTestScene scene(example());
    SdfRandom random(14);
    vec3 grow = 0.5f * (scene.upper() - scene.lower());
    for (int i = 0; i < 50000; i++) {
        vec3 p = random.in_box(scene.lower() - grow, scene.upper() + grow);
        bool within = glm::all(glm::greaterThan(p, scene.lower())) && glm::all(glm::lessThan(p, scene.upper()));
        if (!within) { ASSERT_GT(sdf_reference(scene.root, dvec3(p)), 0) << example(); }
    }
}

// ---------------------------------------------------------------------------------------------------------------
// fuzz
class TreeMaker {
  public:
    explicit TreeMaker(unsigned seed) : random_(seed) {}

    SdfNode make(int depth) {
        while (true) {
            const SdfOperation& operation =
                sdf_operations()[random_.below(static_cast<unsigned>(sdf_operations().size()))];
            if ((operation.role == SdfRole::shape) != (depth == 0) && random_.below(4) != 0) continue;
            if (depth == 0 && operation.role != SdfRole::shape) continue;
            SdfNode node;
            node.op = operation.name;
            node.numbers = numbers(operation);
            std::size_t count =
                operation.child_maximum == SDF_ANY_COUNT ? 2 + random_.below(3) : operation.child_maximum;
            for (std::size_t i = 0; i < count; i++)
                node.children.push_back(make(depth - 1 - int(random_.below(2)) * (depth > 1)));
            return node;
        }
    }

  private:
    std::vector<float> numbers(const SdfOperation& operation) {
        std::vector<float> n;
        for (const SdfParameter& parameter : operation.parameters) {
            float low = parameter.minimum < 0 ? -1.0f : 0.2f;
            n.push_back(random_.uniform(low, 1.2f));
        }
        if (operation.name == "rounded_box") n[3] = 0.05f;
        if (operation.name == "displace") n = {random_.uniform(-0.1f, 0.1f), random_.uniform(1, 6)};
        if (operation.name == "rotate") n[3] *= 180;
        if (operation.name == "repeat") {
            for (int axis = 0; axis < 3; axis++) {
                n[axis] *= random_.below(3) == 0 ? 0.0f : 3.0f;
                n[3 + axis] = n[axis] == 0 ? 0.0f : static_cast<float>(random_.below(4));
            }
            if (n[0] == 0 && n[1] == 0 && n[2] == 0) n[0] = 2;
        }
        return n;
    }
    SdfRandom random_;
};

TEST(SdfBuilder, random_expressions_agree_with_the_reference) {
    int built = 0;
    for (unsigned seed = 0; seed < 1500; seed++) {
        SdfNode root = TreeMaker(seed).make(1 + int(seed % 4));
        Result<SdfData> data = build_sdf({root, std::pair(vec3(-2.5f), vec3(2.5f))});
        if (!data) {  // only a repeat's child that is too large, or bounds that miss the solid
            std::string message = data.error().message;
            ASSERT_TRUE(message.find("must stay within one period") != std::string::npos ||
                        message.find("hold nothing of the solid") != std::string::npos)
                << message;
            continue;
        }
        built++;
        SdfTestScene scene(root, *std::move(data));
        SdfRandom random(seed);
        for (int i = 0; i < 60; i++) {
            vec3 p = random.in_box(vec3(-2.5f), vec3(2.5f));
            double expected = sdf_reference(root, dvec3(p));
            float scale = scene.data.sdf.lipschitz;
            bool within = glm::all(glm::greaterThan(p, scene.lower())) && glm::all(glm::lessThan(p, scene.upper()));
            if (!within) {
                ASSERT_GT(expected, -1e-5 * scale) << "seed " << seed << ": " << sdf_text(root);
                continue;
            }
            float f = scene.distance(p);
            if (std::abs(expected) > 2e-5 * scale) {
                ASSERT_EQ(f < 0, expected < 0) << "seed " << seed << ": " << sdf_text(root);
            }
            vec3 q = random.in_box(scene.lower(), scene.upper());
            ASSERT_LE(std::abs(f - scene.distance(q)), scale * glm::length(p - q) + 1e-5f * scale)
                << "seed " << seed << ": " << sdf_text(root);
        }
    }
    EXPECT_GT(built, 1000);
}

TEST(SdfBuilder, bounds_of_random_expressions_contain_the_solid) {
    int finite = 0;
    for (unsigned seed = 0; seed < 1500; seed++) {
        SdfNode root = TreeMaker(seed + 5000).make(1 + int(seed % 4));
        Result<SdfData> data = build_sdf({root, std::nullopt});
        if (!data) continue;
        finite++;
        SdfTestScene scene(root, *std::move(data));
        SdfRandom random(seed);
        for (int i = 0; i < 60; i++) {
            vec3 grow = 0.3f * (scene.upper() - scene.lower());
            vec3 p = random.in_box(scene.lower() - grow, scene.upper() + grow);
            bool within = glm::all(glm::greaterThan(p, scene.lower())) && glm::all(glm::lessThan(p, scene.upper()));
            if (!within) { ASSERT_GT(sdf_reference(root, dvec3(p)), 0) << "seed " << seed << ": " << sdf_text(root); }
        }
    }
    EXPECT_GT(finite, 500);
}

// ------------------------------------------------------------------------------------------------- repeats
// and effects
TEST(SdfBuilder, children_may_reach_into_neighbouring_cells) {
    SdfTestScene scene("repeat(1, 0, 1.2, 4, 0, 3, translate(0.4, 0, -0.3, sphere(0.45)))");
    SdfRandom random(21);
    for (int i = 0; i < 20000; i++) {
        vec3 p = random.in_box(scene.lower(), scene.upper());
        double expected = sdf_reference(scene.root, dvec3(p));
        if (std::abs(expected) > 1e-5) { ASSERT_EQ(scene.distance(p) < 0, expected < 0); }
        ASSERT_LE(scene.distance(p), expected + 1e-5);  // never above the distance to the nearest copy
    }
}

TEST(SdfBuilder, effects_around_a_repeat_see_true_values) {
    // The surface of the offset lies where the spheres' f is 0.3.
    SdfTestScene scene("offset(0.3, repeat(2, 2, 2, 3, 3, 3, sphere(0.5)))");
    EXPECT_NEAR(scene.distance({0.8f, 0, 0}), 0, 1e-6f);
    EXPECT_GT(scene.distance({1, 0, 0}), 0);
    EXPECT_GT(scene.distance({1, 1, 1}), 0);
    Result<SdfNode> root = parse_sdf_text("offset(1.6, repeat(2, 2, 2, sphere(0.5)))", "");
    Result<SdfData> data = build_sdf({*root, std::pair(vec3(-4), vec3(4))});
    ASSERT_FALSE(data);
    EXPECT_NE(data.error().message.find("offset.repeat: period_x"), std::string::npos) << data.error().message;
}

TEST(SdfBuilder, a_twist_in_a_large_scene_keeps_its_own_steepness) {
    SdfTestScene small("twist(2, box(1, 2, 0.5))");
    SdfTestScene large("union(twist(2, box(1, 2, 0.5)), translate(0, -51, 0, box(200, 100, 200)))");
    EXPECT_LT(large.data.sdf.lipschitz, 2.5f * small.data.sdf.lipschitz);
}

// ---------------------------------------------------------------------------------------------------------------
// tapes
TEST(SdfBuilder, thousands_of_shapes_fit_into_the_registers) {
    SdfNode root{"union", {}, {}};
    SdfRandom random(31);
    for (int i = 0; i < 5000; i++) {
        vec3 p = random.in_box(vec3(-10), vec3(10));
        SdfNode pair{
            "difference", {}, {{"sphere", {0.3f}, {}}, {"rotate", {0, 1, 0, 20}, {{"box", {0.2f, 0.2f, 1}, {}}}}}};
        root.children.push_back({"translate", {p.x, p.y, p.z}, {pair}});
    }
    Result<SdfData> data = build_sdf({root, std::nullopt});
    ASSERT_TRUE(data) << data.error().message;
    for (const kernels::SdfOp& op : data->ops) {
        if (op.op < kernels::SDF_OP_SKIP_UNION) { ASSERT_LT(op.target, 4u); }
    }
}

TEST(SdfBuilder, skipping_far_groups_changes_no_value) {
    SdfRandom random(32);
    auto pebbles = [&](SdfNode node, int count) {
        for (int i = 0; i < count; i++) {
            vec3 p = random.in_box(vec3(-4), vec3(4));
            float r = random.uniform(0.2f, 0.8f);
            SdfNode pebble{"sphere", {r}, {}};
            if (i % 3 == 0) pebble = {"rotate", {1, 2, 3, p.x * 90}, {{"box", {r, 2 * r, r}, {}}}};
            node.children.push_back({"translate", {p.x, p.y, p.z}, {pebble}});
        }
        return node;
    };
    for (const SdfNode& root :
         {pebbles({"union", {}, {}}, 300), pebbles({"smooth_union", {0.3f}, {}}, 300),
          pebbles({"difference", {}, {{"box", {8, 8, 8}, {}}}}, 300),
          pebbles({"smooth_difference", {0.2f}, {{"box", {8, 8, 8}, {}}}}, 300),
          SdfNode{"shell", {0.05f}, {{"translate", {1, 2, 3}, {pebbles({"union", {}, {}}, 100)}}}}}) {
        Result<SdfData> data = build_sdf({root, std::nullopt});
        ASSERT_TRUE(data) << data.error().message;
        SdfTestScene scene(root, *std::move(data));
        for (int i = 0; i < 2000; i++) {
            vec3 p = random.in_box(scene.lower(), scene.upper());
            ASSERT_NEAR(scene.distance(p), sdf_reference(root, dvec3(p)), 2e-5) << root.op;
            ASSERT_NEAR(scene.gradient(p).w, scene.distance(p), 2e-6f) << root.op;
        }
    }
}

TEST(SdfBuilder, chains_of_transforms_become_one_instruction) {
    SdfTestScene scene(
        "translate(1, 2, 3, rotate(0, 1, 0, 30, translate(4, 5, 6, rotate(1, 0, 0, 40, box(1, 2, 3)))))");
    EXPECT_EQ(scene.data.ops.size(), 2u);
    EXPECT_EQ(SdfTestScene("translate(1, 2, 3, translate(4, 5, 6, sphere(1)))").data.ops.size(), 1u);
}

SdfNode nest(const char* op, std::vector<float> numbers, int count) {
    SdfNode node{"sphere", {1}, {}};
    for (int i = 0; i < count; i++) node = SdfNode{op, numbers, {node}};
    return node;
}

TEST(SdfBuilder, deep_nesting_is_refused_by_name_of_the_limit) {
    Result<SdfData> deep = build_sdf({nest("offset", {0.001f}, 300), std::nullopt});
    ASSERT_FALSE(deep);
    EXPECT_NE(deep.error().message.find("nested deeper than 200"), std::string::npos) << deep.error().message;
    EXPECT_TRUE(build_sdf({nest("elongate", {0.1f, 0, 0}, 30), std::nullopt}));
    EXPECT_TRUE(build_sdf({nest("rotate", {0, 1, 0, 10}, 60), std::nullopt}));
    SdfNode wide{"sphere", {1}, {}};
    for (int i = 0; i < 20; i++) wide = {"displace", {0.001f, 1}, {{"rotate", {0, 1, 0, 10}, {wide}}}};
    Result<SdfData> points = build_sdf({wide, std::nullopt});
    ASSERT_FALSE(points);
    EXPECT_NE(points.error().message.find("point registers"), std::string::npos) << points.error().message;
}

TEST(SdfBuilder, errors_name_the_place_and_what_is_allowed) {
    struct Case {
        SdfNode root;
        const char* expected;
    };
    SdfNode sphere{"sphere", {1}, {}};
    for (const Case& c : {
             Case{{"spheer", {1}, {}}, "spheer: unknown operation 'spheer'; available: sphere, box, "},
             Case{{"union", {}, {sphere, {"translate", {1, 2}, {sphere}}}},
                  "union[1].translate: translate takes numbers: x, y, z; 2 given"},
             Case{{"translate", {1, 2, 3}, {{"box", {1, 1, -1}, {}}}},
                  "translate.box: z of box is -1, allowed is 1e-06 to "},
             Case{{"union", {}, {sphere}}, "union: union takes 2 or more children; 1 given"},
             Case{{"sphere", {1}, {sphere}}, "sphere: sphere takes no children; 1 given"},
             Case{{"sphere", {NAN}, {}}, "radius of sphere is nan"},
             Case{{"rotate", {0, 0, 0, 1}, {sphere}}, "the direction is zero"},
             Case{{"rounded_box", {1, 1, 1, 0.6f}, {}}, "allowed is at most half the shortest edge, 0.5"},
             Case{{"plane", {0, 1, 0, 0}, {}}, "plane: the solid has no end"},
             Case{{"repeat", {1, 0, 0}, {{"sphere", {0.4f}, {}}}}, "repeat: the solid has no end"},
             Case{{"repeat", {1, 0, 0, 2}, {{"sphere", {1.1f}, {}}}},
                  "repeat: period_x is 1, but the child reaches to 1.1"},
         }) {
        Result<SdfData> data = build_sdf({c.root, std::nullopt});
        ASSERT_FALSE(data) << c.expected;
        EXPECT_NE(data.error().message.find(c.expected), std::string::npos) << data.error().message;
    }
    EXPECT_FALSE(build_sdf({sphere, std::pair(vec3(1), vec3(0))}));
    Result<SdfData> outside = build_sdf({sphere, std::pair(vec3(5), vec3(6))});
    ASSERT_FALSE(outside);
    EXPECT_NE(outside.error().message.find("hold nothing of the solid"), std::string::npos);
}

}  // namespace
}  // namespace spinel::sdf_builder_test
