// What a camera saw, as Python states it: a file, its bytes, pixels or features.
#ifndef CAIRN_PYTHON_CAMERA_INPUT_H_
#define CAIRN_PYTHON_CAMERA_INPUT_H_

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/images/exif.h"
#include "core/images/gray_image.h"
#include "python/features.h"

namespace cairn::python {

// Pixels of numpy, row by row, one byte a channel.
struct PixelView {
  const uint8_t* data = nullptr;
  int width_px = 0;
  int height_px = 0;
  int num_channels = 1;  // 1 is gray, 3 is red, green, blue.
};

// One of the four is set. The object of Python keeps what spans and views show.
struct CameraInput {
  std::string path;
  std::span<const uint8_t> encoded;
  PixelView pixels;
  std::shared_ptr<StoredFeatures> features;
};

// Throws Error(kInvalidArgument) that names the argument if `value` is none of the four.
CameraInput CameraInputOf(const std::string& argument, py::handle value);

// A picture and what its file says about it.
struct Picture {
  GrayImage image;
  ExifInfo exif;           // Of pixels: nothing.
  bool is_turned = false;  // The image is the stored one as turned by its EXIF.
};

// The encoded image of a file, or the bytes, or the pixels as a PGM. Not for features. Throws as
// ReadImageBytes.
std::vector<uint8_t> EncodedImage(const CameraInput& input);

// Whether a picture is turned: to the size of `camera` or, if that is null, upright.
bool WantsTurn(const ExifInfo& exif, const Camera* camera);

// Decodes the picture and turns it to the size of `camera` or, if that is null, upright, as `cairn
// localize` does. Not for features. Does not need the GIL. Throws as DecodeGrayImage; the message
// names the file or the argument.
Picture ReadPicture(const CameraInput& input, const Camera* camera);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_CAMERA_INPUT_H_
