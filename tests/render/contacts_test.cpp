// Things that touch: surfaces of several objects in exactly the same place are one boundary.

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>

#include "kernels/locate.h"
#include "render/pictures.h"

namespace spinel::contacts_test {
namespace {

using namespace test;

std::string stage(const std::string& things, const std::string& definitions = "") {
    return fmt::format(R"({{"version": 1, "film": {{"size": [32, 32], "filter": "box", "filter_radius": 0.5}},
        "camera": {{"from": [1.3, 1.1, 3.6], "at": [0, 0, 0], "fov": 42}},
        "environment": {{"type": "constant", "radiance": [0.3, 0.4, 0.5]}},
        "lights": [{{"type": "directional", "direction": [-1, -2, -0.5], "irradiance": 3, "angular_radius": 12}}],
        "media": {{"milk": {{"scattering": [2, 1.2, 0.6], "absorption": [0.1, 0.3, 0.2], "g": 0.4}}}},
        "textures": {{"tiles": {{"type": "checker", "color_a": [0.8, 0.7, 0.6], "color_b": [0.1, 0.1, 0.2], "scale": [1.5, 1.5]}}}},
        "materials": {{"floor": {{"type": "diffuse", "color": "tiles"}}, "red": {{"type": "diffuse", "color": [0.7, 0.2, 0.1]}},
                       "glass": {{"type": "dielectric", "ior": 1.5, "absorption": [0.2, 0.6, 1]}},
                       "twin": {{"type": "dielectric", "ior": 1.5, "absorption": [0.2, 0.6, 1], "roughness": 0.3}},
                       "water": {{"type": "dielectric", "ior": 1.33, "absorption": [0.8, 0.3, 0.1], "priority": -1}}}},
        "objects": [{{"geometry": {{"type": "plane"}}, "material": "floor", "transform": [{{"translate": [0, FLOOR, 0]}}]}}{}{}]{}}})",
                       things.empty() ? "" : ", ", things, definitions);
}
TestPicture picture(std::string text, const std::string& floor = "-1") {
    text.replace(text.find("FLOOR"), 5, floor);
    return render_text(text, 48);
}
std::string box(vec3 size, vec3 center, const std::string& what) {
    return fmt::format(
        R"({{"geometry": {{"type": "box", "size": [{}, {}, {}]}}, {}, "transform": [{{"translate": [{}, {}, {}]}}]}})",
        size.x, size.y, size.z, what, center.x, center.y, center.z);
}
const std::string glass = R"("material": "glass")", milk = R"("material": null, "interior": "milk")";

void expect_same_picture(const TestPicture& a, const TestPicture& b) {
    const Estimate ea = a.mean(), eb = b.mean();
    for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(ea.mean[k], eb.mean[k], 0.005 * eb.mean[k]) << "channel " << k << ", error " << ea.error[k];
    const Difference d = compare(a, b, 8);
    EXPECT_LT(d.chi_squared, 1.8);
    EXPECT_LT(d.worst, 7) << "in the block at " << d.worst_block.x << ", " << d.worst_block.y;
}

TEST(Contacts, two_blocks_of_glass_that_share_a_face_are_one_block) {
    const TestPicture one = picture(stage(box(vec3(1.6f), {0, 0, 0}, glass)));
    expect_same_picture(picture(stage(box({1.6f, 0.8f, 1.6f}, {0, 0.4f, 0}, glass) + ", " +
                                      box({1.6f, 0.8f, 1.6f}, {0, -0.4f, 0}, glass))),
                        one);
    // Three, side by side, the middle one of voxels.
    expect_same_picture(
        picture(stage(box({0.4f, 1.6f, 1.6f}, {-0.6f, 0, 0}, glass) + ", " +
                      box({0.4f, 1.6f, 1.6f}, {0.6f, 0, 0}, glass) +
                      R"(, {"geometry": {"type": "voxels", "layers": [["11"], ["11"]]}, "material": "glass",
                            "transform": [{"scale": [0.4, 0.8, 1.6]}, {"translate": [-0.4, -0.8, -0.8]}]})")),
        one);
}

TEST(Contacts, two_boxes_of_fog_that_share_a_face_are_one_box) {
    expect_same_picture(picture(stage(box({1.6f, 0.8f, 1.6f}, {0, 0.4f, 0}, milk) + ", " +
                                      box({1.6f, 0.8f, 1.6f}, {0, -0.4f, 0}, milk))),
                        picture(stage(box(vec3(1.6f), {0, 0, 0}, milk))));
}

TEST(Contacts, water_against_glass_is_the_same_of_boxes_and_of_voxels) {
    const TestPicture voxels = picture(stage(
        R"({"geometry": {"type": "voxels", "layers": [["12", "12"], ["12", "12"]]}, "material": ["water", "glass"],
            "transform": [{"translate": [-1, -1, -1]}, {"scale": 0.8}]})"));
    expect_same_picture(picture(stage(box({0.8f, 1.6f, 1.6f}, {-0.4f, 0, 0}, R"("material": "water")") + ", " +
                                      box({0.8f, 1.6f, 1.6f}, {0.4f, 0, 0}, glass))),
                        voxels);
    // Overlapping, with four faces of the one in the same place as faces of the other.
    expect_same_picture(picture(stage(box({1.2f, 1.6f, 1.6f}, {-0.2f, 0, 0}, R"("material": "water")") + ", " +
                                      box({0.8f, 1.6f, 1.6f}, {0.4f, 0, 0}, glass))),
                        voxels);
}

TEST(Contacts, glass_stands_on_the_floor) {
    for (const std::string& what : {glass, milk}) {
        SCOPED_TRACE(what);
        // The same with the bottom sunk below the floor, where nothing can see it.
        const TestPicture sunk = picture(stage(box({1.6f, 1.7f, 1.6f}, {0, -0.05f, 0}, what)), "-0.8");
        expect_same_picture(picture(stage(box(vec3(1.6f), {0, 0, 0}, what)), "-0.8"), sunk);
    }
}

TEST(Contacts, a_wall_in_the_same_place_as_glass_or_fog_is_what_is_seen) {
    const std::string red = R"("material": "red")";
    const TestPicture bare = picture(stage(box(vec3(1.6f), {0, 0, 0}, red)));
    for (const std::string& what : {glass, milk}) {
        SCOPED_TRACE(what);
        const std::string cover = box(vec3(1.6f), {0, 0, 0}, what), wall = box(vec3(1.6f), {0, 0, 0}, red);
        expect_same_picture(picture(stage(cover + ", " + wall)), bare);
        expect_same_picture(picture(stage(wall + ", " + cover)), bare);
    }
}

TEST(Contacts, the_order_of_objects_does_not_matter) {
    // Smooth and rough glass in one place, fog that fills both.
    const std::string a = box(vec3(1.6f), {0, 0, 0}, glass), b = box(vec3(1.6f), {0, 0, 0}, R"("material": "twin")"),
                      c = box(vec3(1.6f), {0, 0, 0}, milk);
    const TestPicture first = picture(stage(a + ", " + b + ", " + c));
    expect_same_picture(picture(stage(a + ", " + c + ", " + b)), first);
    expect_same_picture(picture(stage(c + ", " + a + ", " + b)), first);
}

TEST(Contacts, the_camera_is_inside_of_all_that_share_a_place) {
    const Result<CompiledScene> scene = compile_text(fmt::format(
        R"({{"version": 1, "camera": {{"from": [0.1, 0.2, 0.3], "at": [0, 0, -5]}},
            "media": {{"a": {{"absorption": 1}}, "b": {{"absorption": 2}}, "c": {{"absorption": 3}}}},
            "objects": [{}, {}, {}]}})",
        box(vec3(2), {0, 0, 0}, R"("interior": "a", "material": null)"),
        box(vec3(2), {0, 0, 0}, R"("interior": "b", "material": null)"),
        box(vec3(3), {0, 0, 0}, R"("interior": "c", "material": null)")));
    ASSERT_TRUE(scene) << scene.error().message;
    const kernels::Inside inside = kernels::interiors_at(scene->view(), {0.1f, 0.2f, 0.3f});
    ASSERT_EQ(inside.count, 3u);
    EXPECT_EQ(inside.dropped, 0u);
    EXPECT_EQ(inside.entries[0], 2u) << "what reaches farthest was entered first";
}

// A lamp in a block of glass with a half-clear label on its face, over a white floor.
std::string labelled(const std::string& lamp, float label) {
    return fmt::format(R"({{"version": 1, "film": {{"size": [8, 8]}},
        "camera": {{"type": "orthographic", "from": [0, 3, 0], "at": [0, 0, 0], "up": [0, 0, 1], "height": 0.5}},
        "materials": {{"floor": {{"type": "diffuse", "color": 0.8}}, "glass": {{"type": "dielectric", "ior": 1.5}},
                       "label": {{"type": "diffuse", "color": 0, "opacity": 0.5}},
                       "lamp": {{"type": "diffuse", "color": 0, "emission": 50}}}},
        "objects": [{{"geometry": {{"type": "rectangle", "size": [40, 40]}}, "material": "floor"}},
            {{"geometry": {{"type": "box", "size": [8, 2, 8]}}, "material": "glass", "transform": [{{"translate": [0, 6, 0]}}]}},
            {{"geometry": {{"type": "rectangle", "size": [8, 8]}}, "material": "label", "transform": [{{"translate": [0, {}, 0]}}]}},
            {{"geometry": {}, "material": "lamp", "transform": [{{"translate": [0, 6, 0]}}]}}]}})",
                       label, lamp);
}

TEST(Contacts, glass_refracts_behind_a_label_with_holes) {
    const ivec2 all(8, 8);
    const auto apart = render_text(labelled(R"({"type": "sphere", "radius": 0.95})", 4.99f), 4096).mean({0, 0}, all);
    EXPECT_GT(apart.mean.x, 0.2);
    // With light sampling and without, which an implicit surface does not have.
    for (const char* lamp : {R"({"type": "sphere", "radius": 0.95})",
                             R"({"type": "sdf", "expression": {"op": "sphere", "radius": 0.95}})"}) {
        const auto touching = render_text(labelled(lamp, 5), 4096).mean({0, 0}, all);
        EXPECT_NEAR(touching.mean.x, apart.mean.x, 4 * (touching.error.x + apart.error.x)) << lamp;
    }
}

TEST(Contacts, two_planes_in_one_place_are_one_in_any_order) {
    const auto ground = [](const char* first, const char* second) {
        return render_text(fmt::format(R"({{"version": 1, "film": {{"size": [16, 16]}},
            "camera": {{"from": [0, 3, 6], "at": [0, 0, 0], "fov": 20}},
            "environment": {{"type": "constant", "radiance": 1}},
            "materials": {{"water": {{"type": "dielectric", "ior": 1.33, "absorption": 10}},
                           "grey": {{"type": "diffuse", "color": 0.5}}}},
            "objects": [{{"geometry": {{"type": "plane"}}, "material": "{}"}},
                        {{"geometry": {{"type": "plane"}}, "material": "{}"}}]}})",
                                       first, second),
                           64)
            .mean({0, 0}, {16, 16});
    };
    expect_mean(ground("water", "grey"), dvec3(0.5));
    expect_mean(ground("grey", "water"), dvec3(0.5));
}

// --------------------------------------------------------------------------------------- what the compiler flags
TEST(Contacts, far_away_say_nothing_of_what_is_near) {
    const Result<CompiledScene> scene = compile_text(fmt::format(
        R"({{"version": 1, "materials": {{"glass": {{"type": "dielectric", "ior": 1.5}}, "white": {{"type": "diffuse"}}}},
        "objects": [{{"geometry": {{"type": "plane"}}, "material": "white"}}, {}, {}]}})",
        box(vec3(1), {4, 0.5f, 0}, glass), box(vec3(20000), {200000, 10000, 0}, glass)));
    ASSERT_TRUE(scene) << scene.error().message;
    const kernels::SceneView view = scene->view();
    EXPECT_GT(kernels::contact_error(view, scene->instances[0], {4, 0, 0}), 0);
    EXPECT_LT(kernels::contact_error(view, scene->instances[0], {4, 0, 0}), 1e-4f);
    EXPECT_EQ(kernels::contact_error(view, scene->instances[0], {0, 0, 0}), 0);
    EXPECT_GT(kernels::contact_error(view, scene->instances[0], {200000, 0, 0}), 0.1f);
}

bool touches(const CompiledScene& scene, std::size_t i) { return scene.instances[i].contact_count > 0; }

const kernels::Contact& contact_of(const CompiledScene& scene, std::size_t i) {
    return scene.contacts.at(scene.instances[i].contact_first);
}

TEST(Contacts, are_not_looked_for_where_nothing_touches) {
    const Result<CompiledScene> scene = compile_text(fmt::format(
        R"({{"version": 1, "materials": {{"glass": {{"type": "dielectric", "ior": 1.5}}, "white": {{"type": "diffuse"}}}},
        "media": {{"fog": {{"absorption": 1}}}},
        "objects": [{{"geometry": {{"type": "plane"}}, "material": "white", "transform": [{{"translate": [0, -3, 0]}}]}},
            {{"geometry": {{"type": "mesh", "positions": [[-2,-2,-2],[2,-2,-2],[-2,2,-2],[2,2,2],[-2,2,2],[2,-2,2]],
                            "triangles": [[0,1,2],[3,4,5]]}}, "material": "white"}},
            {{"geometry": {{"type": "sphere", "radius": 0.5}}, "material": "glass"}},
            {}, {}, {}]}})",
        box(vec3(8), {0, 1.5f, 0}, R"("material": null, "interior": "fog")"),
        box(vec3(1), {2.4f, 0, 0}, R"("material": "white")"), box(vec3(1), {3.4f, 0, 0}, R"("material": "white")")));
    ASSERT_TRUE(scene) << scene.error().message;
    for (std::size_t i = 0; i < scene->instances.size(); ++i) EXPECT_FALSE(touches(*scene, i)) << "object " << i;
}

TEST(Contacts, are_flagged_where_they_are_and_no_further) {
    const Result<CompiledScene> scene = compile_text(fmt::format(
        R"({{"version": 1, "materials": {{"glass": {{"type": "dielectric", "ior": 1.5}}, "white": {{"type": "diffuse"}}}},
        "objects": [{{"geometry": {{"type": "plane"}}, "material": "white"}},
            {{"geometry": {{"type": "sphere", "radius": 0.5}}, "material": "glass", "transform": [{{"translate": [0, 0.5, 0]}}]}}, {}, {}]}})",
        box(vec3(1), {4, 0.5f, 0}, glass), box(vec3(1), {5, 0.5f, 0}, R"("material": "white")")));
    ASSERT_TRUE(scene) << scene.error().message;
    for (std::size_t i = 0; i < 4; ++i) EXPECT_TRUE(touches(*scene, i)) << "object " << i;
    EXPECT_LT(contact_of(*scene, 1).upper.y, 1e-4f) << "only the foot of the ball";
    EXPECT_GT(contact_of(*scene, 3).upper.x, 4.5f);
    EXPECT_LT(contact_of(*scene, 3).upper.x, 4.51f) << "only the face that is shared";
}

}  // namespace
}  // namespace spinel::contacts_test
