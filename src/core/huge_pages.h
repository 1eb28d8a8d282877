#pragma once
// An allocator for large arrays that are read at random places: asks the system for huge pages, of which an array needs
// fewer entries in the processor's table of pages (measured: + 12 % rays a second in a mesh of 870 000 triangles). Of 2
// MB and more; up to half of the last page may hold nothing. New elements are left as they are: whoever resizes a
// vector fills it.

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace spinel {

// `bytes` of memory, aligned to 64 bytes at least; throws std::bad_alloc.
void* allocate_pages(std::size_t bytes);
void free_pages(void* memory) noexcept;

template <class T>
struct HugePages {
    using value_type = T;

    HugePages() = default;
    template <class U>
    HugePages(const HugePages<U>&) {}

    T* allocate(std::size_t count) { return static_cast<T*>(allocate_pages(count * sizeof(T))); }
    void deallocate(T* memory, std::size_t) noexcept { free_pages(memory); }
    template <class U>
    void construct(U* at) noexcept {
        ::new (static_cast<void*>(at)) U;
    }
    template <class U, class... Arguments>
    void construct(U* at, Arguments&&... arguments) {
        std::construct_at(at, std::forward<Arguments>(arguments)...);
    }
    template <class U>
    bool operator==(const HugePages<U>&) const {
        return true;
    }
};

template <class T>
using HugeVector = std::vector<T, HugePages<T>>;

}  // namespace spinel
