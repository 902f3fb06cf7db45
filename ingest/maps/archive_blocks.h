// The blocks of an archived session: their frames and their content. Private to ingest/maps.
#ifndef CAIRN_INGEST_MAPS_ARCHIVE_BLOCKS_H_
#define CAIRN_INGEST_MAPS_ARCHIVE_BLOCKS_H_

#include <cstddef>
#include <cstdint>
#include <istream>
#include <span>
#include <string>
#include <vector>

#include "core/scene/reconstruction.h"
#include "storage/tile/byte_io.h"

namespace cairn::archive {

inline constexpr uint32_t kMaxBlockBytes = uint32_t{1} << 28;
inline constexpr size_t kLandmarksPerBlock = 65'536;

[[noreturn]] void ThrowDamaged(const std::string& what, const std::string& problem);

// Throws Error(kIo) if the system could not read, which is no end of the bytes.
void RequireReadable(const std::istream& bytes, const std::string& what);

// Reads exactly `size` bytes. Throws Error(kMapDamaged) if there are fewer, and sets the failbit of
// `bytes`; throws as RequireReadable.
std::vector<uint8_t> ReadExactly(std::istream* bytes, size_t size, const std::string& what);

// Compresses and frames a content. Throws Error(kBadInput) if it is larger than kMaxBlockBytes.
std::vector<uint8_t> EncodeBlock(std::span<const uint8_t> content);
// This function and those below throw Error(kMapDamaged), and as RequireReadable.
std::vector<uint8_t> ReadBlock(std::istream* bytes, uint32_t max_block_bytes,
                               const std::string& what);

std::vector<uint8_t> EncodeCameras(const std::vector<Camera>& cameras);
std::vector<Camera> DecodeCameras(std::span<const uint8_t> content, size_t num_cameras,
                                  const std::string& what);

std::vector<uint8_t> EncodeImage(const ReconImage& image);
ReconImage DecodeImage(std::span<const uint8_t> content, int descriptor_dim,
                       const std::string& what);

std::vector<uint8_t> EncodeLandmarks(std::span<const ReconLandmark> landmarks);
// Appends the landmarks.
void DecodeLandmarks(std::span<const uint8_t> content, size_t num_landmarks,
                     const std::string& what, std::vector<ReconLandmark>* landmarks);

}  // namespace cairn::archive

#endif  // CAIRN_INGEST_MAPS_ARCHIVE_BLOCKS_H_
