#pragma once
// How `dvr`, scientific volume rendering, shows a volume: what its values look like, and how rays are summed.

#include <glm/glm.hpp>
#include <vector>

namespace spinel {

// What a value looks like; between points colour and opacity are linear, outside constant.
struct TransferPoint {
    float value = 0;  // in the data's own units, or 0 … 1 over the window where there is one
    glm::vec3 color = {1, 1, 1};
    float opacity = 0;  // 0 … 1 (not 1 itself): of a layer as thick as `unit`
};

struct DvrOptions {
    // Front to back through opacity; the greatest value; the mean value; the surface where the value is `iso`.
    enum class Mode { composite, maximum, average, isosurface };
    enum class Light { camera, scene };  // a lamp at the camera, or the scene's sun
    // Transfer functions by name (scene/transfer.cpp): of CT in Hounsfield units; of other data over the window.
    enum class Preset { none, ct_bone, ct_skin, ct_muscle, ct_lung, ct_angio, ct_xray, mri, solid };
    enum class ColorMap { none, grey, viridis, inferno, hot, cool_warm, rainbow };

    Mode mode = Mode::composite;
    Preset preset = Preset::none;            // none: `points`, or without these a grey ramp
    std::vector<TransferPoint> points = {};  // rising values; in place of a preset
    ColorMap color_map = ColorMap::none;     // colours over the window in place of the points'
    float level = 0;                         // middle of the window, data's units …
    float width = 0;                         // … and its width; 0: none, points are in the data's units
    float opacity = 1;                       // multiplies extinction
    float unit = 1;                          // edges of a voxel: how thick a layer opacities are told of
    float step = 1;                          // edges of a voxel
    float iso = 0;
    glm::vec3 iso_color = {0.9f, 0.87f, 0.8f};
    bool shaded = true;  // by the gradient, Blinn–Phong
    Light light = Light::camera;
    float ambient = 0.25f;
    float diffuse = 0.75f;
    float specular = 0.2f;
    float shininess = 24;
    float shadow = 0;                  // 0 … 1: how much of the light the volume itself may take on its way
    float shadow_reach = 48;           // edges of a voxel: how far that is looked for
    glm::vec3 clip_lower = {0, 0, 0};  // part of the volume that is shown, 0 … 1 along each of its axes
    glm::vec3 clip_upper = {1, 1, 1};
    std::vector<glm::vec4> clip_planes = {};  // world: what has x·p.x + y·p.y + z·p.z > w is cut away; at most 4
    glm::vec3 background = {0, 0, 0};
    bool jitter = false;
    bool shortcuts = true;  // false: the device takes every step
};

}  // namespace spinel
