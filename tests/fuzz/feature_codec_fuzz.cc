// Features on the wire: decoded features must encode again.
#include "core/error.h"
#include "core/wire/feature_codec.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr int kMaxFeatures = 100;
  cairn::WireFeatures features;
  try {
    features = cairn::DecodeFeatures({data, size}, kMaxFeatures);
  } catch (const cairn::Error&) {
    return 0;
  }
  CAIRN_CHECK(features.features.size() <= kMaxFeatures, "features beyond the limit");
  cairn::EncodeFeatures(features, cairn::LosslessEncoding(features.features));
  return 0;
}
