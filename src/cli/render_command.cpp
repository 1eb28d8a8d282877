#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/load_options.h"
#include "cli/progress.h"
#include "core/parallel.h"
#include "devices/devices.h"
#include "geometry/mesh/mesh_builder.h"
#include "image/image_io.h"
#include "render/render.h"
#include "scene/compiled_scene.h"
#include "scene/integrator_setting.h"
#include "spinel/formats.h"

namespace spinel::cli {
namespace {

namespace fs = std::filesystem;

struct RenderArguments {
    std::vector<std::string> inputs;
    std::string output;
    std::string size;
    int spp = 0;
    std::string time;
    double noise = 0;
    int max_bounces = -2;
    double clamp = -1;
    std::string integrator;
    std::string preset;  // transfer function of dvr
    AcceleratorSettings accelerator = {"", ""};
    std::vector<std::string> set;  // KEY=VALUE of the integrator
    double level_of_detail = -1;   // −1: the scene's
    std::string device = "cpu";
    std::uint32_t seed = 0;
    int threads = 0;
    std::string crop;
    std::string camera;
    std::vector<std::string> aovs;
    std::string tone_map;
    double exposure = NAN;
    std::vector<std::string> voxels;  // inputs as well, read with LoadOptions::voxels
    LoadOptions load;
    std::string frames;
    bool check = false;
};

// "A:B" or "A:B:STEP": from A on, before B.
Result<std::vector<int>> parse_frames(const std::string& text) {
    int begin = 0, end = 0, step = 1, used = 0, used_with_step = 0;
    const int count = std::sscanf(text.c_str(), "%d:%d%n:%d%n", &begin, &end, &used, &step, &used_with_step);
    const int all = count == 3 ? used_with_step : used;
    if (count < 2 || std::size_t(all) != text.size() || begin < 0 || end <= begin || step < 1 || end > 1 << 20)
        return Error{fmt::format(
            "--frames '{}': expected FIRST:END or FIRST:END:STEP, frames from FIRST on and before END, up to {}", text,
            1 << 20)};
    std::vector<int> frames;
    for (int frame = begin; frame < end; frame += step) frames.push_back(frame);
    return frames;
}

// Where the number of a frame goes in a name: "%d", "%4d" or "%04d". Length 0: nowhere.
struct FramePlace {
    std::size_t begin = 0, length = 0;
    int width = 0;
};
FramePlace frame_place(const std::string& name) {
    const std::size_t begin = name.find('%');
    if (begin == std::string::npos) return {};
    std::size_t end = begin + 1;
    int width = 0;
    while (end < name.size() && name[end] >= '0' && name[end] <= '9' && width < 10)
        width = 10 * width + name[end++] - '0';
    if (end >= name.size() || name[end] != 'd' || width > 16) return {};
    return {begin, end + 1 - begin, width};
}

// "90", "90s", "1.5m", "1h": seconds.
Result<double> parse_duration(const std::string& text) {
    std::size_t used = 0;
    double value = 0;
    try {
        value = std::stod(text, &used);
    } catch (const std::exception&) { used = 0; }
    const std::string unit = text.substr(used);
    const double scale = unit == "m" ? 60 : unit == "h" ? 3600 : unit.empty() || unit == "s" ? 1 : 0;
    if (used == 0 || scale == 0 || !(value > 0) || !std::isfinite(value))
        return Error{fmt::format("--time '{}': expected a positive duration such as 30s, 5m or 1h", text)};
    return value * scale;
}

Result<ivec2> parse_film_size(const std::string& text) {
    if (text.empty()) return ivec2(0);
    int x = 0, y = 0, used = 0;
    if (std::sscanf(text.c_str(), "%dx%d%n", &x, &y, &used) != 2 || std::size_t(used) != text.size() || x < 1 ||
        y < 1 || x > 65536 || y > 65536)
        return Error{fmt::format("--size '{}': expected WIDTHxHEIGHT, each from 1 to 65536", text)};
    return ivec2(x, y);
}

Result<Crop> parse_crop(const std::string& text) {
    if (text.empty()) return Crop{};
    Crop c;
    int used = 0;
    if (std::sscanf(text.c_str(), "%d,%d,%d,%d%n", &c.lower.x, &c.lower.y, &c.upper.x, &c.upper.y, &used) != 4 ||
        std::size_t(used) != text.size() || c.lower.x < 0 || c.lower.y < 0 || c.upper.x <= c.lower.x ||
        c.upper.y <= c.lower.y)
        return Error{
            fmt::format("--crop '{}': expected LEFT,TOP,RIGHT,BOTTOM in pixels from the top left, not empty", text)};
    return c;
}

Result<ToneMap> parse_tone_map(const std::string& text, ToneMap fallback) {
    if (text.empty()) return fallback;
    if (text == "linear") return ToneMap::linear;
    if (text == "aces") return ToneMap::aces;
    if (text == "agx") return ToneMap::agx;
    return Error{fmt::format("unknown tone map '{}'; available: linear, aces, agx", text)};
}

fs::path output_path(const RenderArguments& o, const fs::path& input, std::optional<int> frame) {
    const std::string stem = input.stem().string();
    std::string name = o.output;
    if (const FramePlace place = frame_place(name); frame && place.length > 0)
        name.replace(place.begin, place.length, fmt::format("{:0{}d}", *frame, place.width));
    const std::size_t at = name.find("{name}");
    if (at != std::string::npos) return fs::path(name.replace(at, 6, stem));
    if (fs::is_directory(name) || name.ends_with('/')) return fs::path(name) / (stem + ".png");
    return fs::path(name);
}

// Pictures have an extension that can be written, and several inputs need a place each: a folder, or a name with {name}
// in it.
Result<void> check_outputs(const RenderArguments& o) {
    std::map<fs::path, const std::string*> taken;
    if (!o.frames.empty() && frame_place(o.output).length == 0)
        return Error{fmt::format("-o '{}': --frames needs a name with the frame's number in it, such as frame_%04d.png",
                                 o.output)};
    for (const std::string& input : o.inputs) {
        const fs::path output = output_path(o, input, o.load.frame);
        if (output.extension() != ".png" && output.extension() != ".exr")
            return Error{fmt::format("-o '{}': pictures are written as .png or .exr", output.string())};
        const auto [other, is_new] = taken.emplace(output.lexically_normal(), &input);
        if (is_new) continue;
        if (output == fs::path(o.output))
            return Error{fmt::format("-o '{}': {} inputs need a folder, or a name with {{name}} in it", o.output,
                                     o.inputs.size())};
        return Error{fmt::format("'{}' and '{}' would both become '{}'", *other->second, input, output.string())};
    }
    return {};
}

// Makes the folder of a picture. Noticed now, and not when hours of rendering are done.
Result<void> prepare_folder(const fs::path& output) {
    const fs::path folder = output.has_parent_path() ? output.parent_path() : ".";
    std::error_code error;
    if (fs::is_directory(output, error))
        return Error{fmt::format("cannot write '{}': that is a folder", output.string())};
    fs::create_directories(folder, error);
    if (error)
        return Error{
            fmt::format("cannot write '{}': no folder '{}': {}", output.string(), folder.string(), error.message())};
    if (access(folder.c_str(), W_OK | X_OK) != 0)
        return Error{
            fmt::format("cannot write '{}': folder '{}': {}", output.string(), folder.string(), std::strerror(errno))};
    return {};
}

double user_cpu_seconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_utime.tv_sec) + 1e-6 * double(usage.ru_utime.tv_usec);
}

const char* reason_text(StopReason reason) {
    switch (reason) {
        case StopReason::time: return "time";
        case StopReason::noise: return "noise";
        case StopReason::interrupted: return "interrupted";
        case StopReason::samples: break;
    }
    return "samples";
}

Result<void> save(const fs::path& path, const FilmBuffer& film, const RenderArguments& o, const Film& settings,
                  const ImageMetadata& metadata) {
    const float exposure = std::isnan(o.exposure) ? settings.exposure : float(o.exposure);
    const Image radiance = film.radiance();
    const bool exr = path.extension() == ".exr";
    std::vector<NamedPlane> aovs;
    for (const std::string& name : o.aovs) {
        Result<NamedPlane> plane = aov_plane(film, name);
        if (!plane) return plane.error();
        aovs.push_back(std::move(*plane));
    }
    if (!exr) {
        const Result<ToneMap> tone_map = parse_tone_map(o.tone_map, settings.tone_map);
        if (!tone_map) return tone_map.error();
        if (Result<void> written =
                write_image(path, {{{"R", "G", "B"}, tone_mapped(radiance, *tone_map, exposure)}}, metadata);
            !written)
            return written;
        if (aovs.empty()) return {};
        // A PNG has no room for planes of data: they go beside it.
        fs::path beside = path;
        return write_image(beside.replace_extension(".aov.exr"), aovs, metadata);
    }
    std::vector<NamedPlane> planes;
    planes.push_back({{"R", "G", "B"}, radiance});
    for (NamedPlane& plane : aovs) planes.push_back(std::move(plane));
    return write_image(path, planes, metadata);
}

// Whether the picture's mean is what the scene file says it must be.
bool as_expected(const Expected& expected, vec3 mean) {
    for (int k = 0; k < 3; ++k)
        if (!(std::abs(mean[k] - expected.mean[k]) <= expected.tolerance * std::max(std::abs(expected.mean[k]), 1e-6f)))
            return false;
    return true;
}

struct Run {
    const RenderArguments& o;
    const CommonOptions& common;
    ivec2 size;
    RenderOptions render;

    Result<int> operator()(const fs::path& input, std::optional<int> frame) const {
        const fs::path output = output_path(o, input, frame);
        LoadOptions load = o.load;
        load.frame = frame;
        load.plain = o.integrator == "dvr";
        load.voxels = std::find(o.voxels.begin(), o.voxels.end(), input) != o.voxels.end();
        Result<Scene> scene = load_scene(input, size, load);
        if (!scene) return scene.error();
        if (load.plain && input.extension() != ".json") {
            // Colours of a transfer function are meant to be seen as they are, and rays have no noise.
            scene->film.tone_map = ToneMap::linear;
            scene->film.filter = PixelFilter::box;
            scene->film.filter_radius = 0.5f;
            scene->integrator.spp = 4;
        }
        for (const std::string& assignment : o.set)
            if (Result<void> done = set_integrator(scene->integrator, assignment); !done) return done.error();
        if (o.level_of_detail >= 0)
            for (Geometry& geometry : scene->geometries)
                if (auto* voxels = std::get_if<VoxelGeometry>(&geometry.data))
                    voxels->level_of_detail = float(o.level_of_detail);
        if (!common.quiet)
            for (const std::string& note : scene->notes)
                fmt::print(stderr, "spinel: {}: {}\n", input.filename().string(), note);
        const std::string integrator = render.integrator.empty() ? scene->integrator.name : render.integrator;
        const auto volumes = std::count_if(scene->objects.begin(), scene->objects.end(), [&](const Object& object) {
            const auto* volume = std::get_if<VolumeGeometry>(&scene->geometries[std::size_t(object.geometry)].data);
            return volume && !volume->surface;
        });
        if (!o.preset.empty() && integrator != "dvr")
            return Error{"--preset is for the integrator dvr, and this is " + integrator};
        if (integrator == "dvr" && volumes > 1 && !common.quiet)
            fmt::print(stderr, "spinel: {}: warning: dvr shows the first of {} volumes; --grid chooses one of a file\n",
                       input.filename().string(), volumes);
        if (o.check && !scene->expected)
            return Error{fmt::format("{}: --check, but the scene has no \"expected\"", input.string())};
        const Result<CompiledScene> compiled = compile(
            *scene, {.camera = o.camera, .size = size, .integrator = o.integrator, .accelerator = o.accelerator});
        if (!compiled) return Error{fmt::format("{}: {}", input.string(), compiled.error().message)};
        const Result<std::unique_ptr<Device>> device = make_device(o.device);
        if (!device) return device.error();
        if (Result<void> prepared = prepare_folder(output); !prepared) return prepared.error();
        const double cpu_before = user_cpu_seconds();
        Result<RenderResult> result = [&] {
            ProgressLine line(input.filename().string(), common.quiet);
            return spinel::render(**device, *compiled, render, interrupted,
                                  [&](const RenderProgress& p) { line.show(p); });
        }();
        if (!result) return result.error();
        const double cpu = user_cpu_seconds() - cpu_before;
        const FilmBuffer& film = result->film;
        if (film.sample_count() == 0)
            return Error{fmt::format("{}: interrupted before the first sample; nothing is saved", input.string())};
        const double spp = double(film.sample_count()) / double(film.pixels.size());
        const ImageMetadata metadata = {
            {"Software", "Spinel " SPINEL_VERSION},
            {"spinel.input", input.filename().string()},
            {"spinel.integrator", integrator},
            {"spinel.device", o.device},
            {"spinel.spp", fmt::format("{:.6g}", spp)},
            {"spinel.seed", fmt::format("{}", o.seed)},
            {"spinel.max_bounces",
             fmt::format("{}", render.max_bounces == -2 ? scene->integrator.max_bounces : render.max_bounces)},
            {"spinel.clamp", fmt::format("{:.6g}", render.clamp < 0 ? double(scene->integrator.clamp) : render.clamp)},
            {"spinel.seconds", fmt::format("{:.3f}", result->seconds)},
            {"spinel.stopped_by", reason_text(result->reason)},
            {"spinel.relative_error", fmt::format("{:.6g}", film.relative_error())},
            {"spinel.film", fmt::format("{}x{}", film.size.x, film.size.y)},
            {"spinel.crop",
             fmt::format("{},{},{},{}", film.crop.lower.x, film.crop.lower.y, film.crop.upper.x, film.crop.upper.y)},
        };
        if (Result<void> saved = save(output, film, o, scene->film, metadata); !saved) return saved.error();

        glm::dvec3 mean(0);
        for (const FilmPixel& p : film.pixels) mean += p.sum / double(std::max(p.count, 1u));
        mean /= double(film.pixels.size());
        if (film.bound_reached > 0 && !common.quiet)
            fmt::print(stderr, "spinel: warning: {} of {} paths reached a safety bound; the picture may be biased\n",
                       film.bound_reached, film.sample_count());
        if (film.not_finite > 0 && !common.quiet)
            fmt::print(stderr, "spinel: warning: {} of {} paths were not finite and count as black\n", film.not_finite,
                       film.sample_count());
        if (common.json) {
            const nlohmann::ordered_json json = {
                {"input", input.string()},
                {"output", output.string()},
                {"width", film.crop.size().x},
                {"height", film.crop.size().y},
                {"spp", spp},
                {"seconds", result->seconds},
                {"cpu_seconds", cpu},
                {"render_cpu_seconds", result->cpu_seconds},
                {"paths_per_second", double(film.sample_count()) / std::max(result->seconds, 1e-9)},
                {"mean", {mean.x, mean.y, mean.z}},
                {"relative_error", spp < 2 ? nlohmann::ordered_json() : nlohmann::ordered_json(film.relative_error())},
                {"paths_cut", film.bound_reached},
                {"stopped_by", reason_text(result->reason)}};
            fmt::print("{}\n", json_text(json, -1));
        } else if (!common.quiet) {
            fmt::print(stderr, "{}: {}x{}, {:.4g} spp in {} ({:.2f} Mpaths/s){}{}\n", output.string(),
                       film.crop.size().x, film.crop.size().y, spp, duration_text(result->seconds),
                       1e-6 * double(film.sample_count()) / std::max(result->seconds, 1e-9),
                       spp < 2 ? "" : fmt::format(", noise {:.2g}", film.relative_error()),
                       result->reason == StopReason::interrupted ? ", interrupted" : "");
        }
        if (o.check) {
            if (!as_expected(*scene->expected, vec3(mean))) {
                const vec3 e = scene->expected->mean;
                fmt::print(
                    stderr,
                    "spinel: {}: mean ({:.6g}, {:.6g}, {:.6g}), expected ({:.6g}, {:.6g}, {:.6g}) within {:.3g} %\n",
                    input.string(), mean.x, mean.y, mean.z, e.x, e.y, e.z, 100 * double(scene->expected->tolerance));
                return int(exit_comparison_failed);
            }
        }
        return int(exit_ok);
    }
};

int run(const RenderArguments& o, const CommonOptions& common) {
    RenderOptions options;
    const Result<ivec2> size = parse_film_size(o.size);
    if (!size) return fail(size.error(), exit_usage);
    const Result<Crop> crop = parse_crop(o.crop);
    if (!crop) return fail(crop.error(), exit_usage);
    if (!o.time.empty()) {
        const Result<double> time = parse_duration(o.time);
        if (!time) return fail(time.error(), exit_usage);
        options.time_limit = *time;
    }
    std::vector<std::optional<int>> frames = {o.load.frame};
    if (!o.frames.empty()) {
        const Result<std::vector<int>> asked = parse_frames(o.frames);
        if (!asked) return fail(asked.error(), exit_usage);
        frames.assign(asked->begin(), asked->end());
    }
    if (const Result<void> outputs = check_outputs(o); !outputs) return fail(outputs.error(), exit_usage);
    if (const auto device = find_device(o.device); !device) return fail(device.error(), exit_usage);
    if (const auto known = choose_accelerator(o.accelerator); !known) return fail(known.error(), exit_usage);
    if (!o.integrator.empty())
        if (const auto integrator = find_integrator(o.integrator); !integrator)
            return fail(integrator.error(), exit_usage);
    for (const std::string& assignment : o.set) {
        IntegratorSettings unused;
        if (const Result<void> set = set_integrator(unused, assignment); !set) return fail(set.error(), exit_usage);
    }
    // What would only be noticed after the rendering is checked before it.
    if (const auto tone_map = parse_tone_map(o.tone_map, ToneMap::agx); !tone_map)
        return fail(tone_map.error(), exit_usage);
    for (const std::string& name : o.aovs)
        if (const auto plane = aov_plane(FilmBuffer({1, 1}, {{0, 0}, {1, 1}}), name); !plane)
            return fail(plane.error(), exit_usage);
    options.spp = o.spp;
    options.noise = o.noise;
    options.max_bounces = o.max_bounces;
    options.clamp = o.clamp;
    options.integrator = o.integrator;
    options.seed = o.seed;
    options.crop = *crop;
    const ThreadLimit limit(o.threads);
    install_interrupt();
    const Run render_one{o, common, *size, options};
    int code = exit_ok;
    for (const std::string& input : o.inputs) {
        // One bad file of a batch, or one bad frame, does not take the others with it.
        std::size_t failed = 0;
        std::string last;  // what is wrong with all frames is told once
        for (const std::optional<int> frame : frames) {
            if (interrupted) break;
            const Result<int> result = render_one(input, frame);
            int this_code = exit_ok;
            if (result) {
                this_code = *result;
            } else {
                this_code = exit_bad_input;
                ++failed;
                if (result.error().message != last) {
                    last = result.error().message;
                    fail(frames.size() > 1 ? Error{fmt::format("frame {}: {}", *frame, last)} : result.error());
                }
            }
            if (code == exit_ok) code = this_code;
        }
        if (failed > 1)
            fmt::print(stderr, "spinel: {}: {} of {} frames were not rendered\n", input, failed, frames.size());
        if (interrupted) break;
    }
    return code;
}

}  // namespace

std::function<int()> render_command(CLI::App& app, const CommonOptions& common) {
    auto o = std::make_shared<RenderArguments>();
    app.add_option("INPUT", o->inputs, "scene files (.json) or models; `spinel list formats`");
    app.add_option("--voxels", o->voxels, "an input too: a .vdb whose active voxels are solid, whatever it holds");
    app.add_option("-o,--output", o->output,
                   "picture: .png or .exr; for several inputs a folder, or a name with {name} in it")
        ->required();
    app.add_option("--size", o->size, "WIDTHxHEIGHT in pixels (default: the scene's, else 1280x720)");
    app.add_option("--spp", o->spp, "samples per pixel (default: the scene's, else 64)")->check(CLI::Range(1, 1 << 30));
    app.add_option("--time", o->time, "stop after this long: 30s, 5m, 1h");
    app.add_option("--noise", o->noise, "stop where the relative standard error falls below this, such as 0.01")
        ->check(finite_number())
        ->check(CLI::Range(1e-6, 1.0));
    app.add_option("--integrator", o->integrator, "`spinel list integrators` (default: the scene's, else path)");
    app.add_option("--preset", o->preset, "transfer function of dvr: ct-bone, ct-skin, mri … (as --set dvr.preset=…)");
    app.add_option("--set", o->set,
                   "KEY=VALUE of the integrator, as in a scene file: --set ao_radius=2 --set glow=0.5 (docs/scene.md)")
        ->allow_extra_args(false);
    app.add_option("--level-of-detail", o->level_of_detail,
                   "pixels: opaque voxels are kept no finer than this as the camera sees them; 0: whole (default: the "
                   "scene's, else 0)")
        ->check(finite_number())
        ->check(CLI::Range(0.0, 1024.0));
    app.add_option("--max-bounces", o->max_bounces, "scattering events of a path; 0: direct view only, -1: no limit")
        ->check(CLI::Range(-1, 1 << 20));
    app.add_option(
           "--clamp", o->clamp,
           "most that a path may add by indirect light, against sparks; 0: no limit, unbiased (default: the scene's, "
           "else 0; 10 for a bare model)")
        ->check(CLI::Range(0.0, 1e30));
    app.add_option("--accel", o->accelerator.structure,
                   "what meshes are built into, `spinel list accelerators` (default: the scene's)");
    app.add_option("--accel-preset", o->accelerator.preset,
                   "how wide-bvh8 and wide-bvh8-compact are built: fast, balanced, high (default: the scene's)");
    app.add_option("--device", o->device, "`spinel list devices`")->capture_default_str();
    app.add_option("--seed", o->seed, "another seed, another noise; the same seed, the same bits")
        ->capture_default_str();
    app.add_option("-t,--threads", o->threads, "worker threads (0: one a core)")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    app.add_option("--crop", o->crop, "LEFT,TOP,RIGHT,BOTTOM in pixels: render and write this part only");
    app.add_option("--camera", o->camera, "one of the scene's cameras by name");
    add_load_options(app, o->load);
    app.add_option("--frames", o->frames,
                   "FIRST:END[:STEP] of an animation, END not included; the number goes into -o as frame_%04d.png")
        ->excludes("--frame");
    app.add_option("--aov", o->aovs, "further outputs, comma-separated; `spinel list aovs`")->delimiter(',');
    app.add_option("--tone-map", o->tone_map, "linear, aces or agx; PNG only (default: the scene's, else agx)");
    app.add_option("--exposure", o->exposure, "stops; PNG only (default: the scene's, else 0)")->check(finite_number());
    app.add_flag("--check", o->check, "compare the mean with the scene's \"expected\"; exit code 3 if it differs");
    return [o, &common] {
        o->inputs.insert(o->inputs.end(), o->voxels.begin(), o->voxels.end());
        if (!o->preset.empty()) o->set.insert(o->set.begin(), "dvr.preset=" + o->preset);
        if (o->inputs.empty()) return fail({"INPUT is required; see spinel render --help"}, exit_usage);
        return run(*o, common);
    };
}

}  // namespace spinel::cli
