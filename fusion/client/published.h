// Publishes the newest of a stream of values from one thread to any number of others without a
// lock.
#ifndef CAIRN_FUSION_CLIENT_PUBLISHED_H_
#define CAIRN_FUSION_CLIENT_PUBLISHED_H_

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace cairn::fusion {

// A value has kNumWords doubles. One thread may call Store, and any number of threads may call
// Load, at any time. Store never waits. Load does not wait for the writer either: it reads the
// newest of eight slots, and reads again only if the writer reached the same slot in the meantime
// (Boehm 2012, "Can seqlocks get along with programming language memory models?").
template <size_t kNumWords>
class Published {
 public:
  using Words = std::array<double, kNumWords>;

  void Store(const Words& words) {
    const uint64_t next = (newest_.load(std::memory_order_relaxed) + 1) % kNumSlots;
    Slot& slot = slots_[next];
    const uint64_t sequence = slot.sequence.load(std::memory_order_relaxed);
    slot.sequence.store(sequence + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    for (size_t i = 0; i < kNumWords; ++i) {
      slot.words[i].store(words[i], std::memory_order_relaxed);
    }
    slot.sequence.store(sequence + 2, std::memory_order_release);
    newest_.store(next, std::memory_order_release);
  }

  Words Load() const {
    Words words;
    while (true) {
      const Slot& slot = slots_[newest_.load(std::memory_order_acquire)];
      const uint64_t before = slot.sequence.load(std::memory_order_acquire);
      for (size_t i = 0; i < kNumWords; ++i) {
        words[i] = slot.words[i].load(std::memory_order_relaxed);
      }
      std::atomic_thread_fence(std::memory_order_acquire);
      if (before % 2 == 0 && slot.sequence.load(std::memory_order_relaxed) == before) {
        return words;
      }
    }
  }

 private:
  static constexpr uint64_t kNumSlots = 8;
  struct Slot {
    std::atomic<uint64_t> sequence{0};
    std::array<std::atomic<double>, kNumWords> words{};
  };

  std::array<Slot, kNumSlots> slots_;
  std::atomic<uint64_t> newest_{0};
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_CLIENT_PUBLISHED_H_
