#include "scene/validate.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "geometry/test_scene.h"
#include "image/pixels.h"

namespace spinel::validate_test {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

kernels::Material grey() {
    kernels::Material m{};
    m.color = vec3(0.5f);
    m.ior = 1.5f;
    m.opacity = 1;
    m.color_texture = m.roughness_texture = m.metallic_texture = m.emission_texture = m.normal_texture =
        m.opacity_texture = m.interior = kernels::NONE;
    return m;
}

// One of everything, all right.
Scene valid_scene() {
    Scene scene;
    scene.cameras.push_back({});
    scene.materials.push_back({"grey", grey()});
    scene.textures.push_back({"checker", CheckerTexture{}});
    ImageTexture image;
    image.pixels = std::make_shared<const PixelBuffer>(PixelBuffer{1, 1, 1, std::vector<float>{1}});
    scene.textures.push_back({"image", image});
    scene.grids.push_back({"grid", *build_grid({1, 1, 2}, std::vector<float>{0, 1})});
    scene.media.push_back({"fog", vec3(1), vec3(0), 0.5f, vec3(0), 0});
    MeshGeometry mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    scene.geometries.push_back({"mesh", mesh});
    scene.geometries.push_back({"voxels", test::voxels_of({1, 1, 1}, {2})});
    scene.geometries.push_back({"volume", VolumeGeometry{0}});
    scene.geometries.push_back({"sdf", SdfGeometry{{"sphere", {1}, {}}, std::nullopt}});
    scene.geometries.push_back({"ball", SphereGeometry{}});
    scene.geometries.push_back({"box", BoxGeometry{}});
    scene.geometries.push_back({"ground", PlaneGeometry{}});
    scene.geometries.push_back({"wall", RectangleGeometry{}});
    for (int i = 0; i < int(scene.geometries.size()); ++i) {
        Object object;
        object.name = scene.geometries[std::size_t(i)].name;
        object.geometry = i;
        if (i == 2) object.interior = 0;
        else object.materials = {0};
        scene.objects.push_back(object);
    }
    scene.lights.push_back({"point", PointLight{}});
    scene.lights.push_back({"spot", SpotLight{}});
    scene.lights.push_back({"sun", DirectionalLight{}});
    scene.environment = SkyEnvironment{};
    scene.expected = Expected{};
    return scene;
}

enum { mesh, voxels, volume, sdf, ball, box, ground, wall };

struct Case {
    std::string message;
    std::function<void(Scene&)> harm;
};

template <class T>
T& geometry(Scene& scene, int index) {
    return std::get<T>(scene.geometries[std::size_t(index)].data);
}

TEST(Validate, a_valid_scene_is_valid) {
    const Result<void> valid = validate(valid_scene());
    EXPECT_TRUE(valid) << valid.error().message;
    EXPECT_TRUE(validate(Scene{}));
}

TEST(Validate, each_fault_is_a_sentence_that_names_the_thing) {
    const Case cases[] = {
        {"film has a size of zero: width and height must be at least 1 pixel", [](Scene& s) { s.film.size.y = 0; }},
        {"film has an exposure that is not finite", [](Scene& s) { s.film.exposure = infinity; }},
        {"film has a filter_radius that is not above 0", [](Scene& s) { s.film.filter_radius = nan; }},
        {"integrator needs at least 1 sample per pixel", [](Scene& s) { s.integrator.spp = 0; }},
        {"camera 0 looks at the point where it stands: \"from\" and \"at\" must differ",
         [](Scene& s) { s.cameras[0].from = s.cameras[0].at; }},
        {"camera 0 has \"up\" along its view",
         [](Scene& s) {
             s.cameras[0].up = {0, 0, 1};
         }},
        {"camera \"front\" has a fov that is not between 0 and 180 degrees",
         [](Scene& s) { s.cameras[0].name = "front", s.cameras[0].fov = nan; }},
        {"texture \"image\" has no pixels",
         [](Scene& s) { std::get<ImageTexture>(s.textures[1].data).pixels = nullptr; }},
        {"environment has no pixels", [](Scene& s) { s.environment = ImageEnvironment{}; }},
        {"environment has haze or scale that is negative or not finite",
         [](Scene& s) { std::get<SkyEnvironment>(s.environment).haze = -1; }},
        {"grid \"grid\" has no samples", [](Scene& s) { s.grids[0].samples = nullptr; }},
        {"grid \"grid\" has a value that is not finite", [](Scene& s) { s.grids[0].background = nan; }},
        {"medium \"fog\" has a density_range that does not rise",
         [](Scene& s) {
             s.media[0].density_range = {1, 1};
         }},
        {"medium \"fog\" has an albedo that is not of colours",
         [](Scene& s) {
             s.grids.push_back(s.grids[0]);
             s.media[0].grid = 0;
             s.media[0].albedo = 1;
         }},
        {"medium \"fog\" has g that is not between −1 and 1", [](Scene& s) { s.media[0].g = -1; }},
        {"medium \"fog\" has a coefficient or emission that is negative or not finite",
         [](Scene& s) { s.media[0].absorption.y = -1; }},
        {"medium \"fog\" refers to a grid that is not there", [](Scene& s) { s.media[0].grid = 1; }},
        {"material \"grey\" refers to a texture that is not there",
         [](Scene& s) { s.materials[0].values.normal_texture = 2; }},
        {"material \"grey\" refers to a medium that is not there",
         [](Scene& s) { s.materials[0].values.interior = 1; }},
        {"material \"grey\" has opacity outside of 0 … 1", [](Scene& s) { s.materials[0].values.opacity = 1.5f; }},
        {"geometry \"mesh\" has a vertex that is not finite",
         [](Scene& s) { geometry<MeshGeometry>(s, mesh).positions[1].y = nan; }},
        {"geometry \"mesh\" has a triangle (0) with vertex 3, but there are 3 vertices",
         [](Scene& s) { geometry<MeshGeometry>(s, mesh).triangles[0].z = 3; }},
        {"geometry \"mesh\" has 1 normals; there must be none or 3",
         [](Scene& s) {
             geometry<MeshGeometry>(s, mesh).normals.push_back({0, 0, 1});
         }},
        {"geometry \"mesh\" has no triangles", [](Scene& s) { geometry<MeshGeometry>(s, mesh).triangles.clear(); }},
        {"geometry \"voxels\" has no voxels", [](Scene& s) { geometry<VoxelGeometry>(s, voxels).tree = nullptr; }},
        {"geometry \"volume\" refers to a grid that is not there",
         [](Scene& s) { geometry<VolumeGeometry>(s, volume).grid = -1; }},
        {"geometry \"volume\" has a level that is not finite",
         [](Scene& s) { geometry<VolumeGeometry>(s, volume).level = infinity; }},
        {"geometry \"volume\" is a surface of vectors; it needs numbers",
         [](Scene& s) {
             geometry<VolumeGeometry>(s, volume).surface = true;
             s.media[0].grid = -1;
             s.grids[0].samples = *build_grid({1, 1, 1}, std::vector<float>{1, 2, 3}, 3);
         }},
        {"geometry \"volume\" is a surface looked up by its nearest samples, which leaves steps: the filter has to be "
         "linear or cubic",
         [](Scene& s) {
             geometry<VolumeGeometry>(s, volume).surface = true;
             s.grids[0].filter = Filter::nearest;
         }},
        {"geometry \"sdf\" has no expression", [](Scene& s) { geometry<SdfGeometry>(s, sdf).root.op.clear(); }},
        {"geometry \"ball\" has a radius that is not above 0",
         [](Scene& s) { geometry<SphereGeometry>(s, ball).radius = 0; }},
        {"geometry \"box\" has an edge that is not above 0",
         [](Scene& s) { geometry<BoxGeometry>(s, box).size.z = infinity; }},
        {"geometry \"wall\" has an edge that is not above 0",
         [](Scene& s) { geometry<RectangleGeometry>(s, wall).size.y = -1; }},
        {"light \"point\" has an intensity that is negative or not finite",
         [](Scene& s) { std::get<PointLight>(s.lights[0].data).intensity.x = nan; }},
        {"light \"spot\" has a direction of length 0",
         [](Scene& s) { std::get<SpotLight>(s.lights[1].data).direction = vec3(0); }},
        {"light \"sun\" must have an angular_radius from 0 to below 90 degrees",
         [](Scene& s) { std::get<DirectionalLight>(s.lights[2].data).angular_radius = 90; }},
        {"object \"mesh\" refers to a geometry that is not there", [](Scene& s) { s.objects[mesh].geometry = 8; }},
        {"object \"mesh\" refers to a material that is not there", [](Scene& s) { s.objects[mesh].materials = {1}; }},
        {"object \"mesh\" refers to a medium that is not there", [](Scene& s) { s.objects[mesh].interior = 1; }},
        {"object \"mesh\" has no material", [](Scene& s) { s.objects[mesh].materials.clear(); }},
        {"object \"mesh\" has a transform that is not finite", [](Scene& s) { s.objects[mesh].transform[3].x = nan; }},
        {"object \"mesh\" has a singular transform: it flattens space",
         [](Scene& s) { s.objects[mesh].transform[0] = vec3(0); }},
        {"object \"mesh\" has a transform that scales an axis by 1e-30; 1e-18 to 1e18 is allowed",
         [](Scene& s) { s.objects[mesh].transform = 1e-30f * mat4x3(1); }},
        {"object \"voxels\" has 3 materials, but its geometry uses 4 slots",
         [](Scene& s) {
             geometry<VoxelGeometry>(s, voxels) = test::voxels_of({1, 1, 1}, {4});
             s.objects[voxels].materials = {0, 0, 0};
         }},
        {"object \"volume\" is a volume without an interior medium", [](Scene& s) { s.objects[volume].interior = -1; }},
        {"object \"volume\" is a volume, which has no surface for a material",
         [](Scene& s) { s.objects[volume].materials = {0}; }},
        {"object \"ground\" is a plane, which has no inside for an interior medium",
         [](Scene& s) { s.objects[ground].interior = 0; }},
        {"object \"wall\" is a rectangle, which has no inside for an interior medium",
         [](Scene& s) { s.objects[wall].interior = 0; }},
        {"expected has a mean or a tolerance that is negative or not finite",
         [](Scene& s) { s.expected->tolerance = 0; }},
    };
    for (const Case& c : cases) {
        Scene scene = valid_scene();
        c.harm(scene);
        const Result<void> result = validate(scene);
        if (result) ADD_FAILURE() << "found valid: " << c.message;
        else EXPECT_EQ(result.error().message, c.message);
    }
}

TEST(Validate, tiny_and_stretched_transforms_are_not_singular) {
    EXPECT_FALSE(transform_fault(mat4x3(1e-12f)));
    EXPECT_FALSE(transform_fault(mat4x3(1e-9f, 0, 0, 0, 1e9f, 0, 0, 0, 1, 0, 0, 0)));
    EXPECT_FALSE(transform_fault(mat4x3(1, 0, 0, 100, 1, 0, 0, 0, 1, 0, 0, 0)));  // sheared
    EXPECT_TRUE(transform_fault(mat4x3(1, 2, 3, 2, 4, 6.000001f, 0, 0, 1, 0, 0, 0)));
    EXPECT_TRUE(transform_fault(mat4x3(1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 0)));
}

}  // namespace
}  // namespace spinel::validate_test
