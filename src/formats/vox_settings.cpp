#include "formats/vox_settings.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "image/tone_map.h"

namespace spinel::vox {
namespace {

const Dictionary* setting(const File& file, const std::string& type) {
    const auto found = file.settings.find(type);
    return found == file.settings.end() ? nullptr : &found->second;
}

// Linear, of three sRGB bytes.
vec3 color_of(const Dictionary& dictionary, const std::string& key) {
    vec3 color = glm::clamp(triple(dictionary, key).value_or(vec3(255.0f)) / 255.0f, vec3(0), vec3(1));
    for (int c = 0; c < 3; ++c) color[c] = srgb_decoded(color[c]);
    return color;
}

float intensity(const Dictionary& dictionary) { return std::clamp(number(dictionary, "_i", 1.0f), 0.0f, 1000.0f); }

// To the file's axes (z up) from an elevation and an azimuth from −y (the viewer) towards +x, then to ours (y up).
vec3 direction_of(float elevation, float azimuth) {
    return {std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth)};
}

void apply_light(const File& file, Scene& scene) {
    const Dictionary* sun = setting(file, "_inf");
    const Dictionary* uniform = setting(file, "_uni");
    const Dictionary* air = setting(file, "_atm");
    if (!sun && !uniform) return;
    const Dictionary* environment = setting(file, "_env");
    const int mode = environment ? int(number(*environment, "_mode", 0.0f)) : 0;

    const vec3 angles =
        sun ? triple({{"_angle", word(*sun, "_angle") + " 0"}}, "_angle").value_or(vec3(50, 50, 0)) : vec3(0);
    const float elevation = std::clamp(angles.x, -90.0f, 90.0f), azimuth = std::fmod(angles.y, 360.0f);
    const float strength = sun ? intensity(*sun) : 0.0f;
    if (mode == 2 && air) {
        SkyEnvironment sky;
        sky.sun_elevation = elevation;
        sky.sun_azimuth = azimuth;
        sky.haze = std::clamp(number(*air, "_mie_d", 0.4f) / 0.4f, 0.0f, 10.0f);
        sky.sun = false;  // of its own strength, below
        scene.environment = sky;
    } else {
        scene.environment = ConstantEnvironment{uniform ? color_of(*uniform, "_k") * intensity(*uniform) : vec3(0)};
        if (mode == 1) {
            const Dictionary* picture = setting(file, "_ibl");
            scene.notes.push_back("its sky is a picture that is not in the file (" +
                                  (picture ? word(*picture, "_path") : "") + "); one colour takes its place");
        }
    }
    if (strength > 0.0f && elevation > 0.0f) {
        DirectionalLight light;
        light.direction = -direction_of(glm::radians(elevation), glm::radians(azimuth));
        // So strong that white that faces it has the radiance `_i`.
        light.irradiance = glm::pi<float>() * strength * color_of(*sun, "_k");
        light.angular_radius = glm::degrees(std::clamp(number(*sun, "_area", 0.07f), 0.0f, 0.5f));
        scene.lights.push_back({"sun", light});
    }
}

void apply_cameras(const File& file, Scene& scene) {
    int index = -1;
    for (const Dictionary& said : file.cameras) {
        ++index;
        const vec3 focus = triple(said, "_focus").value_or(vec3(0)), angle = triple(said, "_angle").value_or(vec3(0));
        const float radius = number(said, "_radius", 0.0f);
        // Every file has ten; those that were never set look at the origin from a voxel away.
        if (!(radius > 1.0f) && focus == vec3(0) && angle == vec3(0)) continue;
        const std::string mode = word(said, "_mode");
        Camera camera;
        camera.name = "camera " + std::to_string(index);
        // Pitch lifts the camera above the focus, yaw carries it round, at no yaw it looks along +y of the file.
        const vec3 back =
            direction_of(glm::radians(std::fmod(angle.x, 360.0f)), glm::radians(std::fmod(angle.y, 360.0f)));
        const vec3 at = glm::clamp(vec3(focus.x, focus.z, -focus.y), vec3(-1e6f), vec3(1e6f));
        camera.at = at;
        camera.from = at + back * std::clamp(radius, 1e-3f, 1e6f);
        if (camera.from == camera.at) continue;
        vec3 right = glm::cross(vec3(0, 1, 0), back);
        right = glm::dot(right, right) > 1e-6f ? glm::normalize(right) : vec3(1, 0, 0);
        const vec3 up = glm::cross(back, right);
        const float roll = glm::radians(std::fmod(angle.z, 360.0f));
        camera.up = std::cos(roll) * up + std::sin(roll) * right;
        camera.fov = std::clamp(number(said, "_fov", 45.0f), 1.0f, 170.0f);
        if (mode == "orth" || mode == "iso") {
            camera.kind = Camera::Kind::orthographic;
            // Half the height at a distance of one.
            camera.height = std::max(
                2.0f * std::clamp(number(said, "_frustum", 0.414214f), 1e-3f, 1e3f) * std::max(radius, 1e-3f), 1e-3f);
        }
        scene.cameras.push_back(camera);
    }
}

}  // namespace

void apply_settings(const File& file, Scene& scene) {
    apply_light(file, scene);
    if (const Dictionary* ground = setting(file, "_ground"))
        scene.surroundings.ground_color = color_of(*ground, "_color");
    if (const Dictionary* general = setting(file, "_setting"))
        scene.surroundings.ground = number(*general, "_ground", 1.0f) != 0.0f;
    if (const Dictionary* fog = setting(file, "_fog_uni")) {
        // The density's unit is the program's own; a hundredth of it a voxel looks like its pictures.
        scene.surroundings.fog_density = std::clamp(number(*fog, "_d", 0.0f), 0.0f, 100.0f) * 0.01f;
        scene.surroundings.fog_color = color_of(*fog, "_k");
        scene.surroundings.fog_g = std::clamp(number(*fog, "_g", 0.0f), -0.95f, 0.95f);
    }
    if (const Dictionary* film = setting(file, "_film")) {
        scene.film.exposure = std::log2(std::clamp(number(*film, "_expo", 1.0f), 1e-3f, 1e3f));
        if (number(*film, "_aces", 0.0f) != 0.0f) scene.film.tone_map = ToneMap::aces;
    }
    apply_cameras(file, scene);
}

}  // namespace spinel::vox
