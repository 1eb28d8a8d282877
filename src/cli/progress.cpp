#include "cli/progress.h"

#include <unistd.h>

#include <fmt/format.h>
#include <cmath>
#include <cstdio>

namespace spinel::cli {

std::string duration_text(double seconds) {
    if (seconds < 10) return fmt::format("{:.1f}s", seconds);
    if (seconds < 60) return fmt::format("{:.0f}s", seconds);
    const long whole = std::lround(seconds);
    return whole < 3600 ? fmt::format("{}m{:02}s", whole / 60, whole % 60)
                        : fmt::format("{}h{:02}m", whole / 3600, whole / 60 % 60);
}

ProgressLine::ProgressLine(std::string title, bool quiet)
    : title_(std::move(title)),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      last_(std::chrono::steady_clock::now()) {}

ProgressLine::~ProgressLine() {
    if (open_) fmt::print(stderr, "\r\x1b[K");
}

void ProgressLine::show(const RenderProgress& p) {
    if (quiet_) return;
    const auto now = std::chrono::steady_clock::now();
    const double since = std::chrono::duration<double>(now - last_).count();
    if (since < (terminal_ ? 0.1 : 10.0)) return;
    last_ = now;
    const std::string eta = p.remaining >= 0 ? "ETA " + duration_text(p.remaining) : duration_text(p.seconds);
    const std::string facts =
        fmt::format("{:3.0f}%  {} spp  noise {:.2g}  {}", 100 * p.fraction, p.samples, p.relative_error, eta);
    if (!terminal_) {
        fmt::print(stderr, "{}: {}\n", title_, facts);
        return;
    }
    const int width = 24, filled = int(p.fraction * width);
    fmt::print(stderr, "\r\x1b[K{} [{}{}] {}", title_, std::string(std::size_t(filled), '#'),
               std::string(std::size_t(width - filled), ' '), facts);
    std::fflush(stderr);
    open_ = true;
}

}  // namespace spinel::cli
