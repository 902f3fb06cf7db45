// The results of stages as bytes of the work folder: docs/formats/mapping_work_v2.md.
#ifndef CAIRN_MAPPING_SESSION_STAGE_CODEC_H_
#define CAIRN_MAPPING_SESSION_STAGE_CODEC_H_

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mapping/growth/grow_segments.h"
#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"
#include "mapping/session/place_segment.h"

namespace cairn {

std::vector<uint8_t> EncodePairs(std::span<const std::pair<int, int>> pairs);
std::vector<uint8_t> EncodeTwoViews(std::span<const TwoView> views);
// The decoders throw Error(kMapDamaged), beginning with `what`, if the bytes end too early or name
// what the set does not have.
std::vector<std::pair<int, int>> DecodePairs(std::span<const uint8_t> bytes, const PhotoSet& set,
                                             const std::string& what);
std::vector<TwoView> DecodeTwoViews(std::span<const uint8_t> bytes, const PhotoSet& set,
                                    const std::string& what);

std::vector<uint8_t> EncodeCameras(std::span<const MappingCamera> cameras);
std::vector<MappingCamera> DecodeCameras(std::span<const uint8_t> bytes, const PhotoSet& set,
                                         const std::string& what);

// Keypoints are those of the set, which the bytes do not repeat.
std::vector<uint8_t> EncodeGrowth(const Growth& growth);
Growth DecodeGrowth(std::span<const uint8_t> bytes, const PhotoSet& set, const std::string& what);

// Likewise.
std::vector<uint8_t> EncodeAdjusted(const AdjustedSegment& adjusted);
AdjustedSegment DecodeAdjusted(std::span<const uint8_t> bytes, const PhotoSet& set,
                               const std::string& what);

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_STAGE_CODEC_H_
