#include "core/huge_pages.h"

#include <cstdlib>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace spinel {

void* allocate_pages(std::size_t bytes) {
    constexpr std::size_t huge = std::size_t(1) << 21, line = 64;
    // Below a page there is nothing to gain, and up to one page of address space to lose.
    const std::size_t alignment = bytes >= huge ? huge : line;
    if (bytes > ~std::size_t(0) - alignment) throw std::bad_alloc();
    const std::size_t whole = (bytes + line - 1) / line * line;
    void* const memory = std::aligned_alloc(alignment, (whole + alignment - 1) / alignment * alignment);
    if (!memory) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
    // The last page too if half of it is wanted: to clear it costs less than to ask for 256 small ones. A refusal costs
    // speed only.
    if (alignment == huge) madvise(memory, (whole + huge / 2) / huge * huge, MADV_HUGEPAGE);
#endif
    return memory;
}

void free_pages(void* memory) noexcept { std::free(memory); }

}  // namespace spinel
