#pragma once
// Counts every operator new of the program that includes this, in one of its files only.

#include <atomic>
#include <cstdlib>
#include <new>

namespace tendril::testing_support {
inline std::atomic<long> allocations{0};
}

// Not inlined, lest GCC see malloc's memory given to delete.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++tendril::testing_support::allocations;
  if (void* const memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
