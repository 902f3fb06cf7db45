// The results of stages in the work folder of `cairn map`. The first byte chooses the stage.
#include <string>
#include <vector>

#include "core/error.h"
#include "fuzz/fuzz_target.h"
#include "mapping/photos/read_photo.h"
#include "mapping/session/stage_codec.h"

namespace cairn {
namespace {

// Three photos of one camera, with four keypoints each.
PhotoSet SetOfThree() {
  PhotoSet set;
  set.cameras = {{Camera(), {}, FocalSource::kGuess}};
  for (const char* name : {"a.jpg", "b.jpg", "c.jpg"}) {
    MappingPhoto photo;
    photo.name = name;
    photo.keypoints.resize(4);
    set.photos.push_back(photo);
  }
  return set;
}

std::vector<uint8_t> DecodeAndEncode(uint8_t stage, std::span<const uint8_t> bytes) {
  static const PhotoSet set = SetOfThree();
  switch (stage) {
    case 'F':
      return EncodeReadPhoto(DecodeReadPhoto(bytes, 128, "photo"));
    case 'P':
      return EncodePairs(DecodePairs(bytes, set, "pairs"));
    case 'V':
      return EncodeTwoViews(DecodeTwoViews(bytes, set, "views"));
    case 'C':
      return EncodeCameras(DecodeCameras(bytes, set, "cameras"));
    case 'G':
      return EncodeGrowth(DecodeGrowth(bytes, set, "segments"));
    default:
      return EncodeAdjusted(DecodeAdjusted(bytes, set, "adjusted"));
  }
}

void DecodeMappingWork(const uint8_t* data, size_t size) {
  const std::vector<uint8_t> bytes = DecodeAndEncode(data[0], {data + 1, size - 1});
  CAIRN_CHECK(DecodeAndEncode(data[0], bytes) == bytes,
              "a stage's result changes when it is decoded and encoded again");
}

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) {
    return 0;
  }
  try {
    cairn::DecodeMappingWork(data, size);
  } catch (const cairn::Error& error) {
    CAIRN_CHECK(error.code() == cairn::ErrorCode::kMapDamaged ||
                    error.code() == cairn::ErrorCode::kBadInput ||
                    error.code() == cairn::ErrorCode::kInvalidArgument,
                error.what());
  }
  return 0;
}
