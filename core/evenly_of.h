// A part of a list that is spread over all of it.
#ifndef CAIRN_CORE_EVENLY_OF_H_
#define CAIRN_CORE_EVENLY_OF_H_

#include <cstddef>
#include <utility>
#include <vector>

namespace cairn {

// Returns `count` elements of the list at even distances, the first among them and in their order;
// all of them if they are no more.
template <typename T>
std::vector<T> EvenlyOf(std::vector<T> all, size_t count) {
  if (all.size() <= count) {
    return all;
  }
  std::vector<T> some;
  some.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    some.push_back(std::move(all[all.size() * i / count]));
  }
  return some;
}

}  // namespace cairn

#endif  // CAIRN_CORE_EVENLY_OF_H_
