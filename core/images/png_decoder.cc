#include "core/images/png_decoder.h"

#include <png.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "core/images/decoder_result.h"

namespace cairn {
namespace {

constexpr png_uint_32 kRowsBetweenStops = 16;
// Bytes of the file between two polls. They may inflate to a thousand times as many.
constexpr size_t kBytesBetweenStops = size_t{16} << 10;
// Bytes that the library reads behind the last row. Sound files have a few there: two checksums,
// and perhaps empty chunks. The library would inflate whatever else there is.
constexpr size_t kMaxTailBytes = 4096;
constexpr png_alloc_size_t kMaxChunkBytes = 8'000'000;  // libpng's own default.
constexpr png_uint_32 kMaxKeptChunks = 16;

// The state of one decoding. The library exits by longjmp, so nothing between setjmp and longjmp
// may have a destructor.
struct PngRun {
  std::span<const uint8_t> rest;  // Bytes not yet read.
  const ImageHeader& header;
  const ImageDecodeLimits& limits;
  uint8_t* pixels = nullptr;
  size_t num_bytes_since_stop = 0;
  bool is_at_last_row = false, has_all_rows = false;
  size_t num_tail_bytes = 0;  // Read behind the last row.

  png_structp png = nullptr;
  png_infop info = nullptr;
  bool stopped = false;
  bool has_long_tail = false;  // Which ended the decoding after its last row.
  bool out_of_memory = false;
  std::array<char, 200> message = {};
};

[[noreturn]] void OnError(png_structp png, png_const_charp message) {
  auto* run = static_cast<PngRun*>(png_get_error_ptr(png));
  std::snprintf(run->message.data(), run->message.size(), "%s", message);
  png_longjmp(png, 1);
}

void OnWarning(png_structp, png_const_charp) {}

void ExitIfStopped(PngRun* run) {
  run->num_bytes_since_stop = 0;
  if (run->limits.should_stop && run->limits.should_stop()) {
    run->stopped = true;
    png_longjmp(run->png, 1);
  }
}

void LimitTail(size_t num_bytes, PngRun* run) {
  run->num_tail_bytes += num_bytes;
  if (run->num_tail_bytes > kMaxTailBytes) {
    run->has_long_tail = true;
    png_longjmp(run->png, 1);
  }
}

// The library has a row, and reads no byte before it has put the row into the image.
void OnRow(png_structp png, png_row_infop, png_bytep) {
  auto* run = static_cast<PngRun*>(png_get_io_ptr(png));
  run->has_all_rows = run->is_at_last_row;
}

void ReadBytes(png_structp png, png_bytep target, size_t num_bytes) {
  auto* run = static_cast<PngRun*>(png_get_io_ptr(png));
  if (run->has_all_rows) {
    LimitTail(num_bytes, run);
  }
  if (num_bytes > run->rest.size()) {
    png_error(png, "it is cut short");
  }
  std::memcpy(target, run->rest.data(), num_bytes);
  run->rest = run->rest.subspan(num_bytes);
  run->num_bytes_since_stop += num_bytes;
  if (run->num_bytes_since_stop >= kBytesBetweenStops) {
    ExitIfStopped(run);
  }
}

png_voidp Allocate(png_structp png, png_alloc_size_t num_bytes) {
  void* memory = std::malloc(num_bytes);
  if (memory == nullptr) {
    static_cast<PngRun*>(png_get_mem_ptr(png))->out_of_memory = true;
  }
  return memory;
}

void Free(png_structp, png_voidp memory) { std::free(memory); }

// Skips chunks that do not affect pixels, so that none of them is decompressed. Transparency and
// color space chunks stay, because they affect the gray level.
void SkipOtherChunks(png_structp png) {
  static constexpr png_byte kSkipped[] =
      "bKGD\0eXIf\0hIST\0iTXt\0oFFs\0pCAL\0pHYs\0sBIT\0sCAL\0sPLT\0sTER\0tEXt\0tIME\0zTXt";
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, 0);
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, kSkipped, sizeof(kSkipped) / 5);
}

void SetLimits(PngRun* run) {
  png_set_user_limits(run->png, static_cast<png_uint_32>(run->header.width_px),
                      static_cast<png_uint_32>(run->header.height_px));
  png_set_chunk_malloc_max(run->png, kMaxChunkBytes);
  png_set_chunk_cache_max(run->png, kMaxKeptChunks);
  SkipOtherChunks(run->png);
}

// Converts any PNG to one byte per pixel.
void SetConversions(png_structp png, png_infop info) {
  const int color_type = png_get_color_type(png, info);
  const int bit_depth = png_get_bit_depth(png, info);
  if (bit_depth == 16) {
    png_set_strip_16(png);
  }
  png_set_strip_alpha(png);
  if (color_type == PNG_COLOR_TYPE_PALETTE) {
    png_set_palette_to_rgb(png);
  }
  if ((color_type & PNG_COLOR_MASK_COLOR) == 0 && bit_depth < 8) {
    png_set_expand_gray_1_2_4_to_8(png);
  }
  png_set_rgb_to_gray(png, PNG_ERROR_ACTION_NONE, 0.299, 0.587);
  png_set_read_user_transform_fn(png, OnRow);
}

void ReadRows(PngRun* run, int num_passes) {
  const auto width = static_cast<size_t>(run->header.width_px);
  const auto height = static_cast<png_uint_32>(run->header.height_px);
  for (int pass = 0; pass < num_passes; ++pass) {
    for (png_uint_32 y = 0; y < height; ++y) {
      if (y % kRowsBetweenStops == 0) {
        ExitIfStopped(run);
      }
      run->is_at_last_row = pass == num_passes - 1 && y == height - 1;
      if (run->is_at_last_row && num_passes > 1 && y % 2 == 0) {
        return;  // The last pass of an interlaced image has the odd rows only.
      }
      png_read_row(run->png, run->pixels + y * width, nullptr);
    }
  }
}

// Returns false if an error or `should_stop` ended the decoding.
bool Decode(PngRun* run) {
  if (setjmp(png_jmpbuf(run->png)) != 0) {
    return run->has_long_tail;
  }
  png_set_read_fn(run->png, run, ReadBytes);
  SetLimits(run);
  png_read_info(run->png, run->info);
  if (png_get_image_width(run->png, run->info) != run->header.width_px ||
      png_get_image_height(run->png, run->info) != run->header.height_px) {
    png_error(run->png, "it has two sizes");
  }
  SetConversions(run->png, run->info);
  const int num_passes = png_set_interlace_handling(run->png);
  png_read_update_info(run->png, run->info);
  if (png_get_rowbytes(run->png, run->info) != static_cast<size_t>(run->header.width_px)) {
    png_error(run->png, "its pixels cannot be converted to gray");
  }
  ReadRows(run, num_passes);
  return true;
}

}  // namespace

GrayImage DecodePng(std::span<const uint8_t> bytes, const ImageHeader& header,
                    const ImageDecodeLimits& limits) {
  GrayImage image = BlankImage(header.width_px, header.height_px);
  PngRun run{.rest = bytes, .header = header, .limits = limits, .pixels = image.pixels.data()};
  run.png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &run, OnError, OnWarning, &run,
                                     Allocate, Free);
  run.info = run.png == nullptr ? nullptr : png_create_info_struct(run.png);
  const bool done = run.info != nullptr && Decode(&run);
  png_destroy_read_struct(&run.png, &run.info, nullptr);
  RequireDecoded(done, run, "PNG");
  return image;
}

}  // namespace cairn
