#include "python/camera_input.h"

#include <fmt/format.h>

#include <utility>

#include "core/error.h"
#include "core/images/orient_image.h"
#include "http/json/image_orientation.h"
#include "python/arguments.h"
#include "python/arrays.h"

namespace cairn::python {
namespace {

PixelView PixelsOf(const std::string& argument, py::handle value) {
  const py::array array = RequireArray(argument, value);
  const bool is_gray = array.ndim() == 2;
  const bool is_color = array.ndim() == 3 && array.shape(2) == 3;
  if (!HoldsA<uint8_t>(array) || (!is_gray && !is_color)) {
    RefuseArgument(argument, DescribeArray(array) +
                                 "; must be uint8 of shape (height, width) or (height, width, 3) "
                                 "in the order red, green, blue");
  }
  for (int axis = 0; axis < 2; ++axis) {
    if (array.shape(axis) < 1 || array.shape(axis) > Camera::kMaxSidePx) {
      RefuseArgument(argument, DescribeArray(array) + "; a side has 1 to 100000 pixels");
    }
  }
  return {static_cast<const uint8_t*>(array.data()), static_cast<int>(array.shape(1)),
          static_cast<int>(array.shape(0)), is_gray ? 1 : 3};
}

GrayImage GrayOf(const PixelView& pixels) {
  GrayImage image{.width_px = pixels.width_px, .height_px = pixels.height_px, .pixels = {}};
  const size_t num_pixels = static_cast<size_t>(pixels.width_px) * pixels.height_px;
  if (pixels.num_channels == 1) {
    image.pixels.assign(pixels.data, pixels.data + num_pixels);
    return image;
  }
  image.pixels.resize(num_pixels);
  for (size_t i = 0; i < num_pixels; ++i) {
    const uint8_t* rgb = pixels.data + 3 * i;
    // ITU-R BT.601 luma in units of 1/256, as in JPEG decoders.
    image.pixels[i] = static_cast<uint8_t>((77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2] + 128) >> 8);
  }
  return image;
}

Picture Decode(std::span<const uint8_t> bytes, const Camera* camera) {
  Picture picture;
  picture.exif = ReadExif(bytes);
  const int turn = OrientationForCamera(picture.exif, camera);
  picture.image = OrientImage(DecodeGrayImage(bytes), turn);
  picture.is_turned = turn != 1;
  return picture;
}

}  // namespace

CameraInput CameraInputOf(const std::string& argument, py::handle value) {
  CameraInput input;
  if (py::isinstance<StoredFeatures>(value)) {
    input.features = value.cast<std::shared_ptr<StoredFeatures>>();
  } else if (IsPath(value)) {
    input.path = PathOf(argument, value);
  } else if (py::isinstance<py::bytes>(value)) {
    char* data = nullptr;
    Py_ssize_t size = 0;
    PyBytes_AsStringAndSize(value.ptr(), &data, &size);
    input.encoded = {reinterpret_cast<const uint8_t*>(data), static_cast<size_t>(size)};
    if (size == 0) {
      RefuseArgument(argument, "is empty");
    }
  } else if (py::isinstance<py::array>(value)) {
    input.pixels = PixelsOf(argument, value);
  } else {
    RefuseArgument(argument, fmt::format("must be a path, the bytes of an image file, a numpy "
                                         "array of pixels or cairn.Features, not {}",
                                         Py_TYPE(value.ptr())->tp_name));
  }
  return input;
}

std::vector<uint8_t> EncodedImage(const CameraInput& input) {
  if (!input.path.empty()) {
    return ReadImageBytes(input.path);
  }
  if (input.pixels.data == nullptr) {
    return {input.encoded.begin(), input.encoded.end()};
  }
  const PixelView& pixels = input.pixels;
  const std::string head = fmt::format("P{}\n{} {}\n255\n", pixels.num_channels == 1 ? 5 : 6,
                                       pixels.width_px, pixels.height_px);
  std::vector<uint8_t> bytes(head.begin(), head.end());
  bytes.insert(
      bytes.end(), pixels.data,
      pixels.data + static_cast<size_t>(pixels.width_px) * pixels.height_px * pixels.num_channels);
  return bytes;
}

bool WantsTurn(const ExifInfo& exif, const Camera* camera) {
  return OrientationForCamera(exif, camera) != 1;
}

Picture ReadPicture(const CameraInput& input, const Camera* camera) {
  if (input.pixels.data != nullptr) {
    return {.image = GrayOf(input.pixels), .exif = {}};
  }
  if (input.path.empty()) {
    return Decode(input.encoded, camera);
  }
  const std::vector<uint8_t> bytes = ReadImageBytes(input.path);
  try {
    return Decode(bytes, camera);
  } catch (const Error& error) {
    throw Error(error.code(), input.path + ": " + error.what());
  }
}

}  // namespace cairn::python
