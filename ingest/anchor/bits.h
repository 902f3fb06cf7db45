// A set of indices. Private to ingest.
#ifndef CAIRN_INGEST_ANCHOR_BITS_H_
#define CAIRN_INGEST_ANCHOR_BITS_H_

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn {

// A set of indices below `size`, a bit each. Add, Remove and CountShared take sets of the same
// size.
class Bits {
 public:
  explicit Bits(size_t size) : words_((size + 63) / 64, 0) {}
  void Set(size_t i) { words_[i / 64] |= uint64_t{1} << (i % 64); }
  void Clear(size_t i) { words_[i / 64] &= ~(uint64_t{1} << (i % 64)); }
  bool Has(size_t i) const { return (words_[i / 64] >> (i % 64) & 1) != 0; }
  void Add(const Bits& other) {
    for (size_t w = 0; w < words_.size(); ++w) {
      words_[w] |= other.words_[w];
    }
  }
  void Remove(const Bits& other) {
    for (size_t w = 0; w < words_.size(); ++w) {
      words_[w] &= ~other.words_[w];
    }
  }
  int CountShared(const Bits& other) const {
    int count = 0;
    for (size_t w = 0; w < words_.size(); ++w) {
      count += std::popcount(words_[w] & other.words_[w]);
    }
    return count;
  }

 private:
  std::vector<uint64_t> words_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_ANCHOR_BITS_H_
