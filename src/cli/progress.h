#pragma once
// Progress on stderr: a bar with the time to go on a terminal, a plain line now and then otherwise.

#include <chrono>
#include <string>

#include "render/render.h"

namespace spinel::cli {

class ProgressLine {
  public:
    ProgressLine(std::string title, bool quiet);
    ~ProgressLine();
    void show(const RenderProgress& progress);

  private:
    std::string title_;
    bool quiet_;
    bool terminal_;
    bool open_ = false;  // a bar stands on the current line
    std::chrono::steady_clock::time_point last_;
};

std::string duration_text(double seconds);  // "0.8s", "12s", "3m20s"

}  // namespace spinel::cli
