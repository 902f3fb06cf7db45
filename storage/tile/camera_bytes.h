// A camera as bytes. Private to ingest and mapping.
#ifndef CAIRN_STORAGE_TILE_CAMERA_BYTES_H_
#define CAIRN_STORAGE_TILE_CAMERA_BYTES_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/camera.h"
#include "storage/tile/byte_io.h"

namespace cairn {

// The model by COLMAP's number, width and height as 4 bytes each, then the parameters as doubles.
inline void PutCamera(const Camera& camera, ByteWriter* writer) {
  writer->Put(static_cast<int32_t>(camera.model()));
  writer->Put(static_cast<int32_t>(camera.width_px()));
  writer->Put(static_cast<int32_t>(camera.height_px()));
  writer->PutArray(std::span<const double>(camera.params()));
}

// Throws what ByteReader and Camera throw.
inline Camera GetCamera(ByteReader* reader) {
  const CameraModel model = CameraModelFromColmapId(reader->Get<int32_t>());
  const auto width_px = reader->Get<int32_t>();
  const auto height_px = reader->Get<int32_t>();
  return {model, width_px, height_px,
          reader->GetVector<double>(static_cast<size_t>(NumCameraParams(model)))};
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_CAMERA_BYTES_H_
