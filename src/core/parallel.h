#pragma once
// Data parallelism over oneTBB. Everything parallel in Spinel goes through here, so that one place knows the threads.

#include <cstddef>
#include <functional>
#include <memory>

namespace spinel {

// Calls body(begin, end) for disjoint ranges that cover [0, count); ranges hold at least `grain` elements where
// possible.
void parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body);

// While it lives, exactly `threads` threads work, more than there are cores if so asked (0: as many as there are
// cores). One at a time, made and destroyed by the program's main flow.
class ThreadLimit {
  public:
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

// How many threads a parallel_for uses now.
int thread_count();

}  // namespace spinel
