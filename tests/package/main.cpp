// A program outside of the project that uses the installed package: builds a scene by hand, renders it,
// traces a ray into it and writes the picture to the path it is given.
#include <spinel/scene.h>
#include <spinel/trace.h>
#include <atomic>
#include <cstdio>

#include "devices/devices.h"
#include "image/image_io.h"
#include "render/render.h"
#include "scene/compiled_scene.h"
#include "scene/material_registry.h"

int fail(const spinel::Error& error) {
    std::fprintf(stderr, "%s\n", error.message.c_str());
    return 1;
}

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    using namespace spinel;
    Scene scene;
    scene.film.size = {48, 32};
    scene.cameras.push_back({.name = "front", .from = {0, 0, 4}});
    scene.environment = ConstantEnvironment{};
    scene.materials.push_back({"white", default_material(find_material_info("diffuse")->kind)});
    scene.geometries.push_back({"ball", SphereGeometry{.radius = 1}});
    scene.objects.push_back({.name = "ball", .geometry = 0, .materials = {0}});

    const Result<CompiledScene> compiled = compile(scene);
    if (!compiled) return fail(compiled.error());

    Result<std::unique_ptr<Device>> device = make_device("cpu");
    if (!device) return fail(device.error());
    const std::atomic<bool> stop = false;
    const Result<RenderResult> rendered = render(**device, *compiled, {.spp = 4}, stop);
    if (!rendered) return fail(rendered.error());
    const Image display = tone_mapped(rendered->film.radiance(), scene.film.tone_map);
    if (Result<void> written = write_image(argv[1], {{{"R", "G", "B"}, display}}); !written)
        return fail(written.error());

    const TraceRay ray = {.origin = {0, 0, 4}, .t_min = 0, .direction = {0, 0, -1}, .t_max = 100};
    const Result<std::vector<TraceHit>> hits = trace_rays(compiled->view(), {&ray, 1});
    if (!hits) return fail(hits.error());
    std::printf("t = %g\n", double((*hits)[0].t));  // from z = 4 to the ball of radius 1: 3
    return (*hits)[0].t > 2.9999f && (*hits)[0].t < 3.0001f ? 0 : 1;
}
