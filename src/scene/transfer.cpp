#include "scene/transfer.h"

#include <algorithm>
#include <cmath>

namespace spinel {
namespace {

using glm::vec3;

// Colours as screens show them, that is sRGB.
struct Stop {
    float value, red, green, blue, opacity;
};
using Stops = std::vector<Stop>;

float linear_of_srgb(float c) { return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); }
vec3 color_of(const Stop& s) { return {linear_of_srgb(s.red), linear_of_srgb(s.green), linear_of_srgb(s.blue)}; }

struct PresetRow {
    bool windowed;  // values are 0 … 1 over the window; else Hounsfield units
    Stops stops;
};

const PresetRow& preset_row(DvrOptions::Preset preset) {
    static const PresetRow rows[] = {
        {true, {{0, 0, 0, 0, 0}, {1, 1, 1, 1, 0.3f}}},  // none: a grey ramp
        // Spongy bone reddish, compact bone and teeth pale.
        {false,
         {{150, 0.55f, 0.25f, 0.15f, 0},
          {240, 0.78f, 0.48f, 0.34f, 0.06f},
          {420, 0.93f, 0.80f, 0.64f, 0.45f},
          {1000, 0.98f, 0.95f, 0.88f, 0.85f},
          {2500, 1, 1, 1, 0.95f}}},
        // From fat on all is opaque: the first surface is the skin.
        {false,
         {{-400, 0.85f, 0.62f, 0.50f, 0},
          {-250, 0.88f, 0.66f, 0.54f, 0.25f},
          {-80, 0.93f, 0.74f, 0.62f, 0.7f},
          {300, 0.95f, 0.82f, 0.72f, 0.85f},
          {1200, 1, 0.96f, 0.90f, 0.95f}}},
        // Fat is glassy, muscle red, bone pale.
        {false,
         {{-120, 0.95f, 0.80f, 0.50f, 0},
          {-20, 0.80f, 0.38f, 0.28f, 0.02f},
          {60, 0.72f, 0.26f, 0.20f, 0.20f},
          {160, 0.85f, 0.45f, 0.35f, 0.30f},
          {350, 0.96f, 0.88f, 0.76f, 0.55f},
          {1500, 1, 1, 1, 0.9f}}},
        // Air is nothing, lung and its vessels stand in a faint chest.
        {false,
         {{-950, 0.30f, 0.45f, 0.60f, 0},
          {-880, 0.45f, 0.58f, 0.70f, 0.015f},
          {-700, 0.75f, 0.62f, 0.62f, 0.05f},
          {-550, 0.85f, 0.45f, 0.40f, 0.15f},
          {-450, 0.90f, 0.40f, 0.32f, 0.02f},
          {-150, 0.90f, 0.60f, 0.50f, 0.0f},
          {200, 0.95f, 0.85f, 0.72f, 0.005f},
          {1000, 1, 1, 1, 0.2f}}},
        // Contrast agent red, bone pale.
        {false,
         {{120, 0.60f, 0.08f, 0.06f, 0},
          {180, 0.78f, 0.12f, 0.08f, 0.10f},
          {320, 0.95f, 0.35f, 0.20f, 0.45f},
          {480, 0.96f, 0.82f, 0.66f, 0.55f},
          {1500, 1, 1, 0.98f, 0.9f}}},
        // Thin everywhere, as a radiograph.
        {false,
         {{-600, 0.6f, 0.75f, 0.9f, 0},
          {0, 0.7f, 0.82f, 0.95f, 0.004f},
          {400, 1, 1, 1, 0.02f},
          {2000, 1, 1, 1, 0.08f}}},
        // Magnetic resonance has no unit: air and noise at the bottom of the window, fat or white matter at its top.
        {true,
         {{0, 0, 0, 0, 0},
          {0.18f, 0.42f, 0.20f, 0.17f, 0},
          {0.32f, 0.66f, 0.42f, 0.36f, 0.06f},
          {0.55f, 0.84f, 0.68f, 0.58f, 0.35f},
          {0.80f, 0.95f, 0.88f, 0.80f, 0.60f},
          {1, 1, 0.98f, 0.94f, 0.75f}}},
        // A body: what is above a third of the window is opaque.
        {true,
         {{0, 0.4f, 0.45f, 0.5f, 0},
          {0.28f, 0.5f, 0.55f, 0.6f, 0},
          {0.38f, 0.70f, 0.72f, 0.74f, 0.5f},
          {1, 0.95f, 0.93f, 0.88f, 0.9f}}},
    };
    return rows[std::size_t(preset)];
}

const Stops& color_stops(DvrOptions::ColorMap map) {
    static const Stops rows[] = {
        {},
        {{0, 0, 0, 0, 1}, {1, 1, 1, 1, 1}},
        {{0.0f, 0.267f, 0.005f, 0.329f, 1},
         {0.1f, 0.283f, 0.141f, 0.458f, 1},
         {0.2f, 0.254f, 0.265f, 0.530f, 1},
         {0.3f, 0.207f, 0.372f, 0.553f, 1},
         {0.4f, 0.164f, 0.471f, 0.558f, 1},
         {0.5f, 0.128f, 0.567f, 0.551f, 1},
         {0.6f, 0.135f, 0.659f, 0.518f, 1},
         {0.7f, 0.267f, 0.749f, 0.441f, 1},
         {0.8f, 0.478f, 0.821f, 0.318f, 1},
         {0.9f, 0.741f, 0.873f, 0.150f, 1},
         {1.0f, 0.993f, 0.906f, 0.144f, 1}},
        {{0.0f, 0.001f, 0.000f, 0.014f, 1},
         {0.1f, 0.087f, 0.045f, 0.225f, 1},
         {0.2f, 0.258f, 0.039f, 0.406f, 1},
         {0.3f, 0.416f, 0.090f, 0.433f, 1},
         {0.4f, 0.578f, 0.148f, 0.404f, 1},
         {0.5f, 0.736f, 0.216f, 0.330f, 1},
         {0.6f, 0.865f, 0.317f, 0.226f, 1},
         {0.7f, 0.955f, 0.469f, 0.100f, 1},
         {0.8f, 0.988f, 0.645f, 0.040f, 1},
         {0.9f, 0.964f, 0.844f, 0.273f, 1},
         {1.0f, 0.988f, 0.998f, 0.645f, 1}},
        {{0, 0, 0, 0, 1}, {0.375f, 1, 0, 0, 1}, {0.75f, 1, 1, 0, 1}, {1, 1, 1, 1, 1}},
        {{0, 0.230f, 0.299f, 0.754f, 1}, {0.5f, 0.865f, 0.865f, 0.865f, 1}, {1, 0.706f, 0.016f, 0.150f, 1}},
        {{0, 0, 0, 0.6f, 1},
         {0.15f, 0, 0, 1, 1},
         {0.38f, 0, 1, 1, 1},
         {0.62f, 1, 1, 0, 1},
         {0.85f, 1, 0, 0, 1},
         {1, 0.6f, 0, 0, 1}},
    };
    return rows[std::size_t(map)];
}

vec3 color_at(const Stops& stops, float x) {
    if (x <= stops.front().value) return color_of(stops.front());
    for (std::size_t i = 1; i < stops.size(); ++i)
        if (x < stops[i].value) {
            const float u = (x - stops[i - 1].value) / (stops[i].value - stops[i - 1].value);
            return glm::mix(color_of(stops[i - 1]), color_of(stops[i]), u);
        }
    return color_of(stops.back());
}

}  // namespace

std::vector<TransferPoint> transfer_points(const DvrOptions& options, float lower, float upper) {
    const bool given = !options.points.empty();
    const PresetRow& row = preset_row(options.preset);
    std::vector<TransferPoint> points = options.points;
    if (!given)
        for (const Stop& stop : row.stops) points.push_back({stop.value, color_of(stop), stop.opacity});
    const bool window = options.width > 0;
    float low = options.level - 0.5f * options.width, high = options.level + 0.5f * options.width;
    if (!window && !given && row.windowed) low = lower, high = upper;
    if (window || (!given && row.windowed)) {
        // What was told in units of its own is stretched from its ends to those of the window.
        const bool unit = given || row.windowed;
        const float first = unit ? 0 : points.front().value, last = unit ? 1 : points.back().value;
        for (TransferPoint& p : points) p.value = low + (high - low) * (p.value - first) / (last - first);
    } else {
        low = points.front().value;
        high = points.back().value;
    }
    if (!(high > low)) high = low + std::max(1e-6f, 1e-6f * std::abs(low));
    if (options.color_map != DvrOptions::ColorMap::none) {
        // A point wherever either of the two bends.
        std::vector<TransferPoint> bends = points;
        const Stops& stops = color_stops(options.color_map);
        const auto opacity_at = [&](float value) {
            for (std::size_t i = 1; i < points.size(); ++i)
                if (value < points[i].value && points[i].value > points[i - 1].value)
                    return value <= points[i - 1].value
                               ? points[i - 1].opacity
                               : points[i - 1].opacity + (points[i].opacity - points[i - 1].opacity) *
                                                             (value - points[i - 1].value) /
                                                             (points[i].value - points[i - 1].value);
            return points.back().opacity;
        };
        for (const Stop& stop : stops) {
            const float value = low + (high - low) * stop.value;
            bends.push_back({value, {}, opacity_at(value)});
        }
        std::stable_sort(bends.begin(), bends.end(),
                         [](const TransferPoint& a, const TransferPoint& b) { return a.value < b.value; });
        for (TransferPoint& p : bends) p.color = color_at(stops, (p.value - low) / (high - low));
        points = std::move(bends);
    }
    if (!(points.back().value > points.front().value)) {
        points.push_back(points.back());
        points.back().value += std::max(1e-6f, 1e-6f * std::abs(points.back().value));
    }
    return points;
}

TransferTable transfer_table(const std::vector<TransferPoint>& points, float layer, float opacity) {
    TransferTable table;
    const double low = points.front().value, high = points.back().value;
    table.low = float(low);
    table.scale = float((transfer_size - 1) / (high - low));
    table.values.resize(std::size_t(8) * transfer_size);
    std::size_t next = 1;
    glm::dvec4 before(0), sum(0);
    for (int i = 0; i < transfer_size; ++i) {
        const double value = low + (high - low) * i / (transfer_size - 1);
        while (next + 1 < points.size() && points[next].value < value) ++next;
        const TransferPoint &a = points[next - 1], &b = points[next];
        const double span = double(b.value) - double(a.value);
        const double u = span > 0 ? std::clamp((value - a.value) / span, 0.0, 1.0) : 1.0;
        const double alpha = std::min(glm::mix(double(a.opacity), double(b.opacity), u), 0.9999);
        const double extinction = alpha > 0 ? -std::log1p(-alpha) * double(opacity) / double(layer) : 0.0;
        const glm::dvec3 color = glm::mix(glm::dvec3(a.color), glm::dvec3(b.color), u);
        const glm::dvec4 entry(color * extinction, extinction);
        if (i > 0) sum += 0.5 * (before + entry);
        before = entry;
        for (int k = 0; k < 4; ++k) {
            const std::size_t at = 4 * std::size_t(i) + std::size_t(k);
            table.values[at] = float(entry[k]);
            table.values[4 * std::size_t(transfer_size) + at] = float(sum[k]);
        }
    }
    return table;
}

}  // namespace spinel
