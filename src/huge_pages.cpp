// SPDX-License-Identifier: MIT
// Large arrays of the program on huge pages, where Linux gives them to those who ask (transparent_hugepage "madvise",
// as several distributions have it). A large mesh is looked at all over: with pages of 4 KiB a tenth of the time goes
// into making them and finding them. The allocation functions of the program are replaced, as the standard allows it;
// the library leaves memory to its caller.
#ifdef __linux__
#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kLarge = 2 * kHugePage;  // rounding up wastes less than half of it

void* allocate_on_huge_pages(std::size_t size) {
  void* memory = nullptr;
  const std::size_t rounded = (size + kHugePage - 1) / kHugePage * kHugePage;
  if (rounded < size || posix_memalign(&memory, kHugePage, rounded) != 0) return nullptr;
  (void)madvise(memory, rounded, MADV_HUGEPAGE);  // advice: nothing is lost where it is not taken
  return memory;
}

}  // namespace

void* operator new(std::size_t size) {
  for (;;) {
    void* memory = size >= kLarge ? allocate_on_huge_pages(size) : nullptr;
    if (memory == nullptr) memory = std::malloc(size > 0 ? size : 1);
    if (memory != nullptr) return memory;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
#endif
