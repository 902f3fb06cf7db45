// Answers that a device reads. Reading must not throw, and no answer may name a feature that was
// not sent.
#include "fusion/transport/map_messages.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  fusion::MapQuery query;
  query.features.keypoints.resize(3);
  query.features.descriptors.setZero(3, 2);
  query.track_of_keypoint = {uint64_t{1}, std::nullopt, uint64_t{2}};
  fusion::ReadMapAnswer(cairn::testing::AsText(data, size), query,
                        Geodetic::FromDegrees(55.7, 13.2, 50), 300);
  return 0;
}
