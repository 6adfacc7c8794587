// Room in memory for what a large file will fill, made at once: growing step by step would copy everything several
// times and hold it twice.
#pragma once

#include <cstddef>
#include <vector>

namespace turner {

// Has the system map memory that will soon be written, in large pages and in one call, which costs a small part of a
// fault for each page of 4 KiB; where it cannot, the faults come as always.
void prefault(void* begin, size_t bytes);

// Makes room for `count` more elements, and at least for half as many again as there are: calls in a row stay linear.
template <typename T>
void reservePrefaulted(std::vector<T>& elements, size_t count) {
  if (elements.capacity() - elements.size() < count) {
    elements.reserve(elements.size() + (count > elements.size() / 2 ? count : elements.size() / 2));
  }
  prefault(elements.data() + elements.size(), count * sizeof(T));
}

}  // namespace turner
