// SPDX-License-Identifier: MIT
// In a translation unit of its own: the compiler must not see through the replaced operators.
#include "memory_in_use.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::size_t> in_use{0};
std::atomic<std::size_t> peak{0};
constexpr std::size_t kHead = alignof(std::max_align_t);  // room in front of a block for its size
static_assert(kHead >= sizeof(std::size_t));

void* allocate(std::size_t size) noexcept {
  void* block = std::malloc(size + kHead);
  if (block == nullptr) return nullptr;
  *static_cast<std::size_t*>(block) = size;
  const std::size_t now = in_use.fetch_add(size, std::memory_order_relaxed) + size;
  if (now > peak.load(std::memory_order_relaxed)) peak.store(now, std::memory_order_relaxed);
  return static_cast<char*>(block) + kHead;
}

void release(void* pointer) noexcept {
  if (pointer == nullptr) return;
  void* block = static_cast<char*>(pointer) - kHead;
  in_use.fetch_sub(*static_cast<std::size_t*>(block), std::memory_order_relaxed);
  std::free(block);
}

}  // namespace

void* operator new(std::size_t size) {
  if (void* pointer = allocate(size)) return pointer;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocate(size);
}
void operator delete(void* pointer) noexcept {
  release(pointer);
}
void operator delete(void* pointer, std::size_t) noexcept {
  release(pointer);
}
void operator delete(void* pointer, const std::nothrow_t&) noexcept {
  release(pointer);
}

namespace slice2mesh_benchmarks {

std::size_t restart_memory_peak() {
  const std::size_t now = in_use;
  peak = now;
  return now;
}

std::size_t memory_peak() {
  return peak;
}

}  // namespace slice2mesh_benchmarks
