// SPDX-License-Identifier: MIT
// Large arrays of the program on huge pages, where Linux gives them to those who ask (transparent_hugepage "madvise",
// as several distributions have it). A large mesh is looked at all over: with pages of 4 KiB a tenth of the time goes
// into making them and finding them. The allocation functions of the program are replaced, as the standard allows it;
// the library leaves memory to its caller.
#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <atomic>
#include <cstddef>
#include <cstdint>
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

// Smaller arrays are in the heap. It grows by many pages at a time, is not given back to grow again, and what is new of
// it is asked for before it is used.
#ifdef __GLIBC__
constexpr std::size_t kGrowth = std::size_t{16} << 20;
constexpr std::size_t kWorthALook = 4096;  // bytes asked for
std::atomic<std::uintptr_t> asked_up_to{0};

const bool grows_widely = [] {
  return mallopt(M_TOP_PAD, int(kGrowth)) == 1 && mallopt(M_TRIM_THRESHOLD, INT32_MAX) == 1 &&
         mallopt(M_MMAP_THRESHOLD, int(kLarge)) == 1;
}();

// Where memory is short, the heap grows by what is needed only. True if it did not before.
bool grow_narrowly() {
  static std::atomic<bool> done{false};
  return !done.exchange(true) && mallopt(M_TOP_PAD, 0) == 1;
}
void ask_for_heap() {
  const auto end = reinterpret_cast<std::uintptr_t>(sbrk(0));
  std::uintptr_t begin = asked_up_to.load(std::memory_order_relaxed);
  if (end <= begin || !asked_up_to.compare_exchange_strong(begin, end, std::memory_order_relaxed)) return;
  if (begin == 0) begin = end > kGrowth ? end - kGrowth : 0;  // the first growth
  begin = begin / kHugePage * kHugePage;
  (void)madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}
#else
constexpr std::size_t kWorthALook = SIZE_MAX;
bool grow_narrowly() {
  return false;
}
void ask_for_heap() {}
#endif

}  // namespace

void* operator new(std::size_t size) {
  for (;;) {
    void* memory = size >= kLarge ? allocate_on_huge_pages(size) : nullptr;
    if (memory == nullptr) memory = std::malloc(size > 0 ? size : 1);
    if (size >= kWorthALook && size < kLarge) ask_for_heap();
    if (memory != nullptr) return memory;
    if (grow_narrowly()) continue;
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
