// Tests that adding an inertial sample does not allocate. Hundreds of samples arrive per second,
// and on a device all threads share the lock of the heap. This program counts its own calls of
// malloc.
#include <gtest/gtest.h>

#include <cstddef>

#include "fusion/client/fusion_client.h"
#include "fusion/simulation.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define CAIRN_COUNTS_ALLOCATIONS 0  // The sanitizer's own malloc is in the way.
#else
#define CAIRN_COUNTS_ALLOCATIONS 1
#endif

namespace {
thread_local size_t num_allocations = 0;
}  // namespace

#if CAIRN_COUNTS_ALLOCATIONS
extern "C" {
void* __libc_malloc(size_t size);
void* malloc(size_t size) {
  ++num_allocations;
  return __libc_malloc(size);
}
}
#endif

namespace cairn::fusion::testing {
namespace {

TEST(Allocation, AnInertialSampleAllocatesNothing) {
  if (CAIRN_COUNTS_ALLOCATIONS == 0) {
    GTEST_SKIP() << "malloc belongs to the sanitizer";
  }
  SimulationOptions options;
  options.duration_s = 9.0;
  options.walk.start_stop_s = {2.0};
  const Simulation simulation(options);
  auto [client, error] = FusionClient::Create(simulation.MatchingFusionOptions());
  ASSERT_NE(client, nullptr) << error;
  size_t num_of_samples = 0;  // After the warm-up: start, and buffers that grow to their size.
  size_t num_of_frames = 0;
  size_t next_imu = 0;
  for (size_t i = 0; i < simulation.frames().size(); ++i) {
    const SimulatedFrame& frame = simulation.frames()[i];
    while (next_imu < simulation.imu().size() &&
           simulation.imu()[next_imu].timestamp_ns <= frame.truth.timestamp_ns) {
      const size_t before = num_allocations;
      client->AddImu({&simulation.imu()[next_imu++], 1});
      num_of_samples += i > 60 ? num_allocations - before : 0;
    }
    const size_t before = num_allocations;
    client->AddFrame({frame.truth.timestamp_ns, frame.features});
    num_of_frames += num_allocations - before;
    if (const auto query = client->PollQuery()) {
      client->Submit(simulation.MakeAnswer(*query, i, {}));
    }
  }
  EXPECT_EQ(client->Latest().mode, Mode::kLocalized);
  EXPECT_GT(num_of_frames, 0u);  // The count works.
  EXPECT_EQ(num_of_samples, 0u);
}

}  // namespace
}  // namespace cairn::fusion::testing
