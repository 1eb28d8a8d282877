#include "image/palette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <unordered_map>

#include "core/parallel.h"
#include "image/tone_map.h"

namespace spinel {
namespace {

using glm::dvec3;
using glm::vec3;

// Colours whose channels agree in their upper bits are one: 6 bits are finer than a palette of thousands.
struct Bin {
    dvec3 lab = dvec3(0);  // mean
    double weight = 0;
};

struct Box {
    std::size_t begin, end;  // into the bins
    int axis = 0;            // of the largest variance
    double variance = 0;     // of it, times the weight
    double mean = 0;         // along it
    bool operator<(const Box& other) const { return variance < other.variance; }
};

Box box_of(const std::vector<Bin>& bins, std::size_t begin, std::size_t end) {
    Box box{begin, end};
    dvec3 sum(0), squares(0);
    double weight = 0;
    for (std::size_t i = begin; i < end; ++i) {
        sum += bins[i].weight * bins[i].lab;
        squares += bins[i].weight * bins[i].lab * bins[i].lab;
        weight += bins[i].weight;
    }
    const dvec3 variance = squares - sum * sum / weight;
    for (int axis = 1; axis < 3; ++axis)
        if (variance[axis] > variance[box.axis]) box.axis = axis;
    box.variance = end - begin > 1 ? std::max(variance[box.axis], 0.0) : 0;
    box.mean = sum[box.axis] / weight;
    return box;
}

dvec3 centre_of(const std::vector<Bin>& bins, const Box& box) {
    dvec3 sum(0);
    double weight = 0;
    for (std::size_t i = box.begin; i < box.end; ++i) {
        sum += bins[i].weight * bins[i].lab;
        weight += bins[i].weight;
    }
    return sum / weight;
}

// Reorders the bins so that each box is a range of them.
std::vector<Box> median_cut(std::vector<Bin>& bins, std::size_t count) {
    std::priority_queue<Box> open;
    std::vector<Box> done;
    open.push(box_of(bins, 0, bins.size()));
    while (!open.empty() && open.size() + done.size() < count) {
        const Box box = open.top();
        open.pop();
        if (!(box.variance > 0)) {
            done.push_back(box);
            continue;
        }
        const auto first = bins.begin() + std::ptrdiff_t(box.begin), last = bins.begin() + std::ptrdiff_t(box.end);
        auto middle = std::partition(first, last, [&](const Bin& bin) { return bin.lab[box.axis] < box.mean; });
        if (middle == first || middle == last) {  // by rounding
            done.push_back(box);
            continue;
        }
        const auto at = std::size_t(middle - bins.begin());
        open.push(box_of(bins, box.begin, at));
        open.push(box_of(bins, at, box.end));
    }
    for (; !open.empty(); open.pop()) done.push_back(open.top());
    return done;
}

std::size_t nearest(const std::vector<dvec3>& centres, dvec3 lab) {
    std::size_t best = 0;
    double least = 1e30;
    for (std::size_t i = 0; i < centres.size(); ++i) {
        const dvec3 d = centres[i] - lab;
        const double distance = glm::dot(d, d);
        if (distance < least) least = distance, best = i;
    }
    return best;
}

void k_means(const std::vector<Bin>& bins, std::vector<dvec3>& centres, std::vector<std::size_t>& chosen) {
    constexpr int rounds = 8;
    for (int round = 0; round < rounds; ++round) {
        parallel_for(bins.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) chosen[i] = nearest(centres, bins[i].lab);
        });
        if (round + 1 == rounds) break;
        std::vector<dvec3> sums(centres.size(), dvec3(0));
        std::vector<double> weights(centres.size(), 0);
        for (std::size_t i = 0; i < bins.size(); ++i) {
            sums[chosen[i]] += bins[i].weight * bins[i].lab;
            weights[chosen[i]] += bins[i].weight;
        }
        for (std::size_t i = 0; i < centres.size(); ++i)
            if (weights[i] > 0) centres[i] = sums[i] / weights[i];
    }
}

}  // namespace

std::uint32_t srgb8(vec3 linear) {
    std::uint32_t color = 0;
    for (int i = 0; i < 3; ++i)
        color |= std::uint32_t(std::lround(255 * srgb_encoded(std::min(linear[i], 1.0f)))) << (8 * i);
    return color;
}

vec3 linear_of_srgb8(std::uint32_t color) {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> values;
        for (int i = 0; i < 256; ++i) values[std::size_t(i)] = srgb_decoded(float(i) / 255);
        return values;
    }();
    return {table[color & 255], table[color >> 8 & 255], table[color >> 16 & 255]};
}

vec3 oklab_of_linear(vec3 c) {
    const float l = std::cbrt(0.4122214708f * c.x + 0.5363325363f * c.y + 0.0514459929f * c.z);
    const float m = std::cbrt(0.2119034982f * c.x + 0.6806995451f * c.y + 0.1073969566f * c.z);
    const float s = std::cbrt(0.0883024619f * c.x + 0.2817188376f * c.y + 0.6299787005f * c.z);
    return {0.2104542553f * l + 0.7936177850f * m - 0.0040720468f * s,
            1.9779984951f * l - 2.4285922050f * m + 0.4505937099f * s,
            0.0259040371f * l + 0.7827717662f * m - 0.8086757660f * s};
}

vec3 linear_of_oklab(vec3 c) {
    float l = c.x + 0.3963377774f * c.y + 0.2158037573f * c.z;
    float m = c.x - 0.1055613458f * c.y - 0.0638541728f * c.z;
    float s = c.x - 0.0894841775f * c.y - 1.2914855480f * c.z;
    l = l * l * l;
    m = m * m * m;
    s = s * s * s;
    return {4.0767416621f * l - 3.3077115913f * m + 0.2309699292f * s,
            -1.2684380046f * l + 2.6097574011f * m - 0.3413193965f * s,
            -0.0041960863f * l - 0.7034186147f * m + 1.7076147010f * s};
}

ColorPalette quantise_colors(std::span<const std::uint32_t> colors, int max_colors) {
    ColorPalette palette;
    palette.index.resize(colors.size());
    std::unordered_map<std::uint32_t, std::uint64_t> counts;
    for (const std::uint32_t color : colors) ++counts[color];
    for (const auto& [color, count] : counts) palette.colors.push_back(color);
    std::sort(palette.colors.begin(), palette.colors.end());
    if (palette.colors.size() <= std::size_t(max_colors)) {
        for (std::size_t i = 0; i < colors.size(); ++i)
            palette.index[i] = std::uint16_t(std::lower_bound(palette.colors.begin(), palette.colors.end(), colors[i]) -
                                             palette.colors.begin());
        return palette;
    }

    // In rising order, so that the result does not depend on a hash's order.
    const auto key = [](std::uint32_t color) { return color >> 2 & 0x3f3f3f; };
    std::unordered_map<std::uint32_t, std::uint32_t> bin_of;
    std::vector<Bin> bins;
    for (const std::uint32_t color : palette.colors) {
        const auto [found, is_new] = bin_of.emplace(key(color), std::uint32_t(bins.size()));
        if (is_new) bins.emplace_back();
        Bin& bin = bins[found->second];
        const double weight = double(counts[color]);
        bin.lab += weight * dvec3(oklab_of_linear(linear_of_srgb8(color)));
        bin.weight += weight;
    }
    for (Bin& bin : bins) bin.lab /= bin.weight;

    std::vector<Bin> sorted = bins;
    std::vector<dvec3> centres;
    for (const Box& box : median_cut(sorted, std::size_t(max_colors))) centres.push_back(centre_of(sorted, box));
    std::vector<std::size_t> chosen(bins.size());
    constexpr std::size_t most_distances = std::size_t(1) << 30;  // of a round of k-means: seconds
    if (bins.size() * centres.size() <= most_distances) {
        k_means(bins, centres, chosen);
    } else {
        parallel_for(bins.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) chosen[i] = nearest(centres, bins[i].lab);
        });
    }
    palette.colors.clear();
    for (const dvec3& centre : centres) palette.colors.push_back(srgb8(linear_of_oklab(vec3(centre))));
    for (std::size_t i = 0; i < colors.size(); ++i) palette.index[i] = std::uint16_t(chosen[bin_of.at(key(colors[i]))]);
    return palette;
}

}  // namespace spinel
