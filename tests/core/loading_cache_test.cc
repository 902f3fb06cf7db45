#include "core/loading_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <barrier>
#include <latch>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/error.h"
#include "support/expect_error.h"

#ifdef __SANITIZE_THREAD__
// The reference count of a shared exception lives in libstdc++, where the sanitizer cannot see that
// the last release comes after all reads.
extern "C" const char* __tsan_default_suppressions() {
  return "race:LoadingCache_WaitingThreadsGetTheFailure_Test";
}
#endif

namespace cairn {
namespace {

using testing::ErrorCodeOf;

class FakeTile {
 public:
  explicit FakeTile(size_t bytes) : bytes_(bytes) {}
  size_t MemoryBytes() const { return bytes_; }

 private:
  size_t bytes_;
};

using TileCache = LoadingCache<FakeTile>;

TileCache::Loader LoaderOf(size_t bytes, int* num_loads = nullptr) {
  return [bytes, num_loads] {
    if (num_loads != nullptr) {
      ++*num_loads;
    }
    return std::make_shared<const FakeTile>(bytes);
  };
}

TEST(LoadingCache, LoadsOnceAndThenHits) {
  TileCache cache(100);
  int num_loads = 0;
  const auto first = cache.GetOrLoad("1", LoaderOf(10, &num_loads));
  const auto second = cache.GetOrLoad("1", LoaderOf(10, &num_loads));
  EXPECT_EQ(first, second);
  EXPECT_EQ(num_loads, 1);
  const CacheStats stats = cache.Stats();
  EXPECT_EQ(stats.num_hits, 1u);
  EXPECT_EQ(stats.num_misses, 1u);
  EXPECT_EQ(stats.num_entries, 1u);
  EXPECT_EQ(stats.bytes, 10u);
  EXPECT_EQ(stats.max_bytes, 100u);
}

TEST(LoadingCache, EvictsTheLeastRecentlyUsed) {
  TileCache cache(100);
  cache.GetOrLoad("1", LoaderOf(40));
  cache.GetOrLoad("2", LoaderOf(40));
  cache.GetOrLoad("1", LoaderOf(40));
  cache.GetOrLoad("3", LoaderOf(40));
  EXPECT_NE(cache.Peek("1"), nullptr);
  EXPECT_EQ(cache.Peek("2"), nullptr);
  EXPECT_NE(cache.Peek("3"), nullptr);
  EXPECT_EQ(cache.Stats().num_evictions, 1u);
  EXPECT_EQ(cache.Stats().bytes, 80u);
}

TEST(LoadingCache, ALargeTileEvictsAsManyAsItMust) {
  TileCache cache(100);
  for (int i = 1; i <= 10; ++i) {
    cache.GetOrLoad(std::to_string(i), LoaderOf(10));
  }
  cache.GetOrLoad("11", LoaderOf(95));
  EXPECT_EQ(cache.Stats().num_entries, 1u);
  EXPECT_EQ(cache.Stats().num_evictions, 10u);
}

TEST(LoadingCache, ATileAboveTheBoundIsHandedOutButNotKept) {
  TileCache cache(100);
  cache.GetOrLoad("1", LoaderOf(60));
  EXPECT_NE(cache.GetOrLoad("2", LoaderOf(101)), nullptr);
  EXPECT_EQ(cache.Peek("2"), nullptr);
  EXPECT_NE(cache.Peek("1"), nullptr);
  EXPECT_EQ(cache.Stats().bytes, 60u);
}

TEST(LoadingCache, EvictedTilesLiveWhileTheyAreHeld) {
  TileCache cache(50);
  const auto held = cache.GetOrLoad("1", LoaderOf(50));
  cache.GetOrLoad("2", LoaderOf(50));
  EXPECT_EQ(cache.Peek("1"), nullptr);
  EXPECT_EQ(held->MemoryBytes(), 50u);
  EXPECT_EQ(held.use_count(), 1);
}

TEST(LoadingCache, FailedLoadsAreNotKept) {
  TileCache cache(100);
  const auto fail = []() -> std::shared_ptr<const FakeTile> {
    throw Error(ErrorCode::kMapDamaged, "broken");
  };
  EXPECT_EQ(ErrorCodeOf([&] { cache.GetOrLoad("1", fail); }), ErrorCode::kMapDamaged);
  EXPECT_EQ(ErrorCodeOf([&] { cache.GetOrLoad("1", [] { return nullptr; }); }),
            ErrorCode::kInternal);
  int num_loads = 0;
  cache.GetOrLoad("1", LoaderOf(1, &num_loads));
  EXPECT_EQ(num_loads, 1);
}

TEST(LoadingCache, ClearForgetsTilesAndKeepsTheCounters) {
  TileCache cache(100);
  cache.GetOrLoad("1", LoaderOf(10));
  cache.Clear();
  EXPECT_EQ(cache.Peek("1"), nullptr);
  EXPECT_EQ(cache.Stats().bytes, 0u);
  EXPECT_EQ(cache.Stats().num_misses, 1u);
}

TEST(LoadingCache, NeedsASize) {
  EXPECT_EQ(ErrorCodeOf([] { TileCache cache(0); }), ErrorCode::kInvalidArgument);
}

TEST(LoadingCache, ThreadsThatAskForOneTileShareOneLoad) {
  constexpr int kNumThreads = 8;
  TileCache cache(100);
  std::atomic<int> num_loads = 0;
  std::latch loading(1);
  std::latch may_finish(1);
  std::vector<std::shared_ptr<const FakeTile>> results(kNumThreads);
  std::vector<std::thread> threads;
  threads.emplace_back([&] {
    results[0] = cache.GetOrLoad("1", [&] {
      ++num_loads;
      loading.count_down();
      may_finish.wait();
      return std::make_shared<const FakeTile>(10);
    });
  });
  loading.wait();
  EXPECT_EQ(cache.Peek("1"), nullptr);
  std::latch asking(kNumThreads - 1);
  for (int i = 1; i < kNumThreads; ++i) {
    threads.emplace_back([&, i] {
      asking.count_down();
      results[i] = cache.GetOrLoad("1", [&] {
        ++num_loads;
        return std::make_shared<const FakeTile>(10);
      });
    });
  }
  asking.wait();
  may_finish.count_down();
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(num_loads, 1);
  EXPECT_EQ(cache.Stats().num_misses, 1u);
  EXPECT_EQ(cache.Stats().num_hits, uint64_t{kNumThreads - 1});
  for (const auto& result : results) {
    EXPECT_EQ(result, results[0]);
  }
}

TEST(LoadingCache, WaitingThreadsGetTheFailure) {
  TileCache cache(100);
  std::latch loading(1);
  std::latch may_finish(1);
  const auto fail = [&]() -> std::shared_ptr<const FakeTile> {
    loading.count_down();
    may_finish.wait();
    throw Error(ErrorCode::kMapDamaged, "broken");
  };
  std::optional<ErrorCode> first_code;
  std::thread first([&] { first_code = ErrorCodeOf([&] { cache.GetOrLoad("1", fail); }); });
  loading.wait();
  // Counted as a hit the moment it finds the load, so this thread is waiting once that shows.
  std::optional<ErrorCode> second_code;
  std::thread second([&] { second_code = ErrorCodeOf([&] { cache.GetOrLoad("1", fail); }); });
  while (cache.Stats().num_hits == 0) {
    std::this_thread::yield();
  }
  may_finish.count_down();
  first.join();
  second.join();
  EXPECT_EQ(first_code, ErrorCode::kMapDamaged);
  EXPECT_EQ(second_code, ErrorCode::kMapDamaged);
}

TEST(LoadingCache, DifferentTilesLoadInParallel) {
  TileCache cache(100);
  std::barrier both_loading(2);  // Neither load can end before the other has begun.
  const auto load = [&] {
    both_loading.arrive_and_wait();
    return std::make_shared<const FakeTile>(10);
  };
  std::thread other([&] { cache.GetOrLoad("1", load); });
  cache.GetOrLoad("2", load);
  other.join();
  EXPECT_EQ(cache.Stats().num_entries, 2u);
}

TEST(LoadingCache, StaysWithinItsBoundUnderManyThreads) {
  constexpr int kNumThreads = 4;
  constexpr int kNumRounds = 2000;
  TileCache cache(500);
  std::vector<std::thread> threads;
  for (int t = 0; t < kNumThreads; ++t) {
    threads.emplace_back([&cache, t] {
      for (int i = 0; i < kNumRounds; ++i) {
        const int id = 1 + (i * 7 + t * 13) % 40;
        const auto tile = cache.GetOrLoad(std::to_string(id), LoaderOf(10 + id));
        EXPECT_EQ(tile->MemoryBytes(), 10u + id);
        EXPECT_LE(cache.Stats().bytes, 500u);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  const CacheStats stats = cache.Stats();
  EXPECT_EQ(stats.num_hits + stats.num_misses, uint64_t{kNumThreads * kNumRounds});
  EXPECT_GE(stats.num_misses, stats.num_evictions);
}

}  // namespace
}  // namespace cairn
