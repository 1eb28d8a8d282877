#include "image/metrics.h"

#include <cmath>
#include <string>

namespace spinel {
namespace {

std::string shape(const Image& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height) + "x" + std::to_string(image.channels);
}

template <class Difference>
Result<double> mean_difference(const Image& image, const Image& reference, Difference difference) {
    if (Result<void> comparable = check_comparable(image, reference); !comparable) return comparable.error();
    double sum = 0;
    for (std::size_t i = 0; i < image.values.size(); ++i)
        sum += difference(double(image.values[i]), double(reference.values[i]));
    return sum / double(image.values.size());
}

}  // namespace

Result<void> check_comparable(const Image& image, const Image& reference) {
    if (image.width != reference.width || image.height != reference.height || image.channels != reference.channels)
        return Error{"pictures of different shape cannot be compared: " + shape(image) + " and " + shape(reference)};
    if (image.values.empty()) return Error{"pictures without pixels cannot be compared"};
    return {};
}

std::vector<double> channel_means(const Image& image) {
    std::vector<double> means(std::size_t(image.channels), 0.0);
    for (std::size_t i = 0; i < image.values.size(); ++i) means[i % means.size()] += double(image.values[i]);
    for (double& mean : means) mean /= double(image.width) * double(image.height);
    return means;
}

Result<double> rmse(const Image& image, const Image& reference) {
    auto mean = mean_difference(image, reference, [](double a, double b) { return (a - b) * (a - b); });
    if (!mean) return mean;
    return std::sqrt(*mean);
}

Result<double> relative_mse(const Image& image, const Image& reference) {
    return mean_difference(image, reference, [](double a, double b) { return (a - b) * (a - b) / (b * b + 1e-2); });
}

Result<double> relative_mean_difference(const Image& image, const Image& reference) {
    if (Result<void> comparable = check_comparable(image, reference); !comparable) return comparable.error();
    const std::vector<double> a = channel_means(image), b = channel_means(reference);
    double largest = 0;
    for (std::size_t c = 0; c < a.size(); ++c) {
        const double difference = a[c] == b[c] ? 0 : std::abs(a[c] - b[c]) / std::abs(b[c]);
        if (!(difference <= largest)) largest = difference;  // NaN stays
        if (std::isnan(largest)) break;
    }
    return largest;
}

}  // namespace spinel
