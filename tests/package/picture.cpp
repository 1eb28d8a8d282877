// The whole way by public headers alone: reads the model or scene that it is given, renders it, saves the picture, and
// reads that again.
#include <spinel/formats.h>
#include <spinel/image.h>
#include <spinel/render.h>
#include <cstdio>

int fail(const spinel::Error& error) {
    std::fprintf(stderr, "%s\n", error.message.c_str());
    return 1;
}

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    using namespace spinel;
    const Result<Scene> scene = load_scene(argv[1]);
    if (!scene) return fail(scene.error());
    double fraction = 0;
    const Result<Picture> picture = render_picture(*scene, {.size = {48, 32}, .render = {.spp = 4}},
                                                   [&](const RenderProgress& p) { fraction = p.fraction; });
    if (!picture) return fail(picture.error());
    if (const Result<void> saved = save_picture(argv[2], picture->radiance, scene->film.tone_map); !saved)
        return fail(saved.error());
    const Result<Image> again = load_picture(argv[2]);
    if (!again) return fail(again.error());
    float brightest = 0;
    for (const float v : again->values) brightest = v > brightest ? v : brightest;
    std::printf("%d x %d, %g spp, %g done, brightest %g\n", again->width, again->height, picture->samples_per_pixel,
                fraction, double(brightest));
    return again->width == 48 && again->height == 32 && picture->samples_per_pixel == 4 && brightest > 0.1f ? 0 : 1;
}
