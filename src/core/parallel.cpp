#include "core/parallel.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>

#ifdef SPINEL_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace spinel {
namespace {

// The arena of the innermost ThreadLimit; null: TBB's own, as many threads as the machine has.
std::atomic<tbb::task_arena*> limited_arena{nullptr};

// oneTBB is a library built without ThreadSanitizer, and so is this file, where its headers are used: of TBB's work the
// sanitizer shall see nothing rather than half. What it then must be told is that a range starts after the call, and
// that the call returns after every range. These say so, and nothing more: ranges stay unordered among themselves, so
// that a race between two of them is found.
#ifdef SPINEL_THREAD_SANITIZER
void happens_before(char& moment) { __tsan_release(&moment); }
void happens_after(char& moment) { __tsan_acquire(&moment); }
#else
void happens_before(char&) {}
void happens_after(char&) {}
#endif

}  // namespace

void parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
    char start = 0, end = 0;
    const auto run = [&] {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain > 0 ? grain : 1),
                          [&](const tbb::blocked_range<std::size_t>& range) {
                              happens_after(start);
                              body(range.begin(), range.end());
                              happens_before(end);
                          });
    };
    happens_before(start);
    if (tbb::task_arena* arena = limited_arena.load()) arena->execute(run);
    else run();
    happens_after(end);
}

struct ThreadLimit::State {
    tbb::global_control control;
    tbb::task_arena arena;
    tbb::task_arena* outer;
};

ThreadLimit::ThreadLimit(int threads) {
    if (threads <= 0) return;
    state_ = std::unique_ptr<State>(
        new State{tbb::global_control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
                  tbb::task_arena(threads), nullptr});
    state_->outer = limited_arena.exchange(&state_->arena);
}

ThreadLimit::~ThreadLimit() {
    if (state_) limited_arena.store(state_->outer);
}

int thread_count() {
    const tbb::task_arena* arena = limited_arena.load();
    return arena ? arena->max_concurrency() : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

}  // namespace spinel
