#include "core/images/encode_image.h"

#include <fmt/format.h>
#include <jpeglib.h>
#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/error.h"

namespace cairn {
namespace {

void RequireContent(const PictureRows& picture) {
  if (picture.width_px <= 0 || picture.height_px <= 0 || picture.pixels == nullptr) {
    throw Error(ErrorCode::kInternal, "an empty picture cannot be encoded");
  }
}

[[noreturn]] void Fail(const char* format, const char* message) {
  throw Error(ErrorCode::kInternal, fmt::format("cannot encode a {}: {}", format, message));
}

// The state of one encoding. libjpeg exits by longjmp, so nothing between setjmp and longjmp may
// have a destructor.
struct JpegWriting {
  jpeg_error_mgr errors;  // First, so that its address is that of the state.
  std::jmp_buf failed;
  char message[JMSG_LENGTH_MAX] = {};
  unsigned char* bytes = nullptr;
  unsigned long num_bytes = 0;  // NOLINT: libjpeg's type.
};

[[noreturn]] void OnJpegError(j_common_ptr codec) {
  auto* writing = reinterpret_cast<JpegWriting*>(codec->err);
  codec->err->format_message(codec, writing->message);
  std::longjmp(writing->failed, 1);
}

// Returns false, with a message, if the library refuses the picture.
bool WriteJpeg(const PictureRows& picture, int quality, JpegWriting* writing) {
  jpeg_compress_struct codec = {};
  codec.err = jpeg_std_error(&writing->errors);
  writing->errors.error_exit = OnJpegError;
  if (setjmp(writing->failed) != 0) {
    jpeg_destroy_compress(&codec);
    return false;
  }
  jpeg_create_compress(&codec);
  jpeg_mem_dest(&codec, &writing->bytes, &writing->num_bytes);
  codec.image_width = static_cast<JDIMENSION>(picture.width_px);
  codec.image_height = static_cast<JDIMENSION>(picture.height_px);
  codec.input_components = picture.num_channels;
  codec.in_color_space = picture.num_channels == 1 ? JCS_GRAYSCALE : JCS_EXT_BGR;
  jpeg_set_defaults(&codec);
  jpeg_set_quality(&codec, quality, TRUE);
  jpeg_start_compress(&codec, TRUE);
  while (codec.next_scanline < codec.image_height) {
    auto* row = const_cast<JSAMPLE*>(picture.pixels + codec.next_scanline * picture.row_bytes);
    jpeg_write_scanlines(&codec, &row, 1);
  }
  jpeg_finish_compress(&codec);
  jpeg_destroy_compress(&codec);
  return true;
}

}  // namespace

std::vector<uint8_t> EncodePng(const PictureRows& picture) {
  RequireContent(picture);
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width_px);
  image.height = static_cast<png_uint_32>(picture.height_px);
  image.format = picture.num_channels == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_BGR;
  std::vector<uint8_t> bytes(PNG_IMAGE_PNG_SIZE_MAX(image));
  png_alloc_size_t num_bytes = bytes.size();
  if (png_image_write_to_memory(&image, bytes.data(), &num_bytes, 0, picture.pixels,
                                static_cast<png_int_32>(picture.row_bytes), nullptr) == 0) {
    Fail("PNG", image.message);
  }
  bytes.resize(num_bytes);
  return bytes;
}

std::vector<uint8_t> EncodeJpeg(const PictureRows& picture, int quality) {
  RequireContent(picture);
  JpegWriting writing;
  const bool is_written = WriteJpeg(picture, quality, &writing);
  std::vector<uint8_t> bytes;
  if (is_written) {
    bytes.assign(writing.bytes, writing.bytes + writing.num_bytes);
  }
  std::free(writing.bytes);
  if (!is_written) {
    Fail("JPEG", writing.message);
  }
  return bytes;
}

std::vector<uint8_t> EncodePnm(const PictureRows& picture) {
  RequireContent(picture);
  const bool is_gray = picture.num_channels == 1;
  const std::string header =
      fmt::format("P{}\n{} {}\n255\n", is_gray ? 5 : 6, picture.width_px, picture.height_px);
  std::vector<uint8_t> bytes(header.begin(), header.end());
  for (int y = 0; y < picture.height_px; ++y) {
    const uint8_t* row = picture.pixels + static_cast<size_t>(y) * picture.row_bytes;
    for (int x = 0; x < picture.width_px; ++x) {
      const uint8_t* pixel = row + static_cast<size_t>(x) * picture.num_channels;
      for (int channel = picture.num_channels - 1; channel >= 0;
           --channel) {  // To red, green, blue.
        bytes.push_back(pixel[channel]);
      }
    }
  }
  return bytes;
}

}  // namespace cairn
