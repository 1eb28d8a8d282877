#pragma once
// Ctrl-C and SIGTERM ask a render to stop and save; a second one ends the program at once.

#include <atomic>

namespace spinel::cli {

// Set by the first signal after install_interrupt().
extern std::atomic<bool> interrupted;
void install_interrupt();

}  // namespace spinel::cli
