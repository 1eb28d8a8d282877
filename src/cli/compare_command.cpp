#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "image/flip.h"
#include "image/image_io.h"
#include "image/metrics.h"
#include "image/tone_map.h"

namespace spinel::cli {
namespace {

struct CompareArguments {
    std::string image;
    std::string reference;
    std::string metric = "rmse";
    double threshold = INFINITY;
};

// A picture as linear light, without its alpha: bytes are sRGB-encoded, floats are not.
struct Picture {
    Image linear;
    Image display;
};

Result<Picture> read_picture(const std::string& path) {
    const Result<PixelBuffer> pixels = read_pixels(path);
    if (!pixels) return pixels.error();
    const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&pixels->data);
    const int channels = pixels->channels < 3 ? 1 : 3;
    Picture picture;
    for (Image* image : {&picture.linear, &picture.display}) *image = {pixels->width, pixels->height, channels, {}};
    for (std::size_t i = 0; i < pixels->value_count(); ++i) {
        if (int(i % std::size_t(pixels->channels)) >= channels) continue;
        const float stored = bytes ? float((*bytes)[i]) / 255 : std::get<std::vector<float>>(pixels->data)[i];
        picture.linear.values.push_back(pixels->encoded ? srgb_decoded(stored) : stored);
        // NaN is no colour, and stays what it is for the metric to refuse.
        picture.display.values.push_back(pixels->encoded || std::isnan(stored) ? stored
                                                                               : std::min(srgb_encoded(stored), 1.0f));
    }
    return picture;
}

struct Metric {
    const char* name;
    const char* doc;
    Result<double> (*value)(const Picture& image, const Picture& reference);
};

const Metric metrics[] = {
    {"rmse", "root of the mean squared difference of linear values",
     [](const Picture& a, const Picture& b) { return rmse(a.linear, b.linear); }},
    {"relmse", "mean of (a - b)^2 / (b^2 + 0.01), linear values",
     [](const Picture& a, const Picture& b) { return relative_mse(a.linear, b.linear); }},
    {"flip", "what an eye sees of the difference, 0 ... 1 (LDR-FLIP); floats are clipped at 1",
     [](const Picture& a, const Picture& b) { return flip(a.display, b.display); }},
    {"mean", "largest relative difference of a channel's mean, linear values",
     [](const Picture& a, const Picture& b) { return relative_mean_difference(a.linear, b.linear); }},
};

int run(const CompareArguments& o, const CommonOptions& common) {
    const Result<Picture> image = read_picture(o.image);
    if (!image) return fail(image.error());
    const Result<Picture> reference = read_picture(o.reference);
    if (!reference) return fail(reference.error());
    const Metric& metric =
        *std::find_if(std::begin(metrics), std::end(metrics), [&](const Metric& m) { return m.name == o.metric; });
    const Result<double> value = metric.value(*image, *reference);
    if (!value) return fail({fmt::format("'{}' and '{}': {}", o.image, o.reference, value.error().message)});
    const bool judged = std::isfinite(o.threshold);
    const bool within = !judged || *value <= o.threshold;  // not so for NaN
    if (common.json) {
        nlohmann::ordered_json json = {
            {"image", o.image}, {"reference", o.reference}, {"metric", o.metric}, {"value", *value}};
        if (judged) json.update({{"threshold", o.threshold}, {"within", within}});
        fmt::print("{}\n", json_text(json, -1));
    } else {
        fmt::print("{} {:.6g}\n", o.metric, *value);
    }
    if (within) return exit_ok;
    return fail({fmt::format("'{}' and '{}': {} is {:.6g}, not within {:.6g}", o.image, o.reference, o.metric, *value,
                             o.threshold)},
                exit_comparison_failed);
}

}  // namespace

std::function<int()> compare_command(CLI::App& app, const CommonOptions& common) {
    auto o = std::make_shared<CompareArguments>();
    std::vector<std::string> names;
    std::string doc;
    for (const Metric& metric : metrics) {
        names.push_back(metric.name);
        doc += fmt::format("{}{}: {}", doc.empty() ? "" : "; ", metric.name, metric.doc);
    }
    app.add_option("IMAGE", o->image, "picture (.png, .exr, …)")->required();
    app.add_option("REFERENCE", o->reference, "picture of the same size that it is compared with")->required();
    app.add_option("--metric", o->metric, doc)->check(CLI::IsMember(names))->capture_default_str();
    app.add_option("--threshold", o->threshold, "exit code 3 where the value is above this")
        ->check(finite_number())
        ->check(CLI::NonNegativeNumber);
    return [o, &common] { return run(*o, common); };
}

}  // namespace spinel::cli
