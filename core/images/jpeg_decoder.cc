#include "core/images/jpeg_decoder.h"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <string>

#include "core/images/decoder_result.h"

// clang-format off
#include <jpeglib.h>  // Needs <cstdio>.
#include <jerror.h>   // Needs jpeglib.h.
// clang-format on

namespace cairn {
namespace {

constexpr int kMaxScans = 100;
constexpr int kFullScale = 8;  // In eighths.
// The coefficients of a color image without subsampling take 6 bytes a pixel. With this limit, 50
// megapixels of them are accepted, in the memory that feature extraction takes afterwards.
constexpr int64_t kMaxCoefficientBytesPerPixel = 24;
// Without an end marker, no more than this may follow the pixels: some cameras fill up a sector.
constexpr size_t kMaxPaddingBytes = 512;
// Some cameras write stray bytes between segments. Damaged pixels give one warning per block.
constexpr int kMaxWarnings = 100;

// The state of one decoding. The library exits by longjmp, so nothing between setjmp and longjmp
// may have a destructor.
struct JpegRun {
  std::span<const uint8_t> bytes;
  const ImageHeader& header;
  const ImageDecodeLimits& limits;
  int scale = kFullScale;  // In eighths.
  uint8_t* pixels = nullptr;

  jpeg_decompress_struct cinfo = {};
  jpeg_error_mgr errors = {};
  jpeg_progress_mgr progress = {};
  std::jmp_buf jump = {};
  bool stopped = false;
  bool out_of_memory = false;
  bool has_run_out = false;  // All bytes are read, and the library has seen no end marker.
  std::array<char, JMSG_LENGTH_MAX> message = {};
};

JpegRun& RunOf(j_common_ptr cinfo) { return *static_cast<JpegRun*>(cinfo->client_data); }

[[noreturn]] void Fail(JpegRun* run, const char* message) {
  std::snprintf(run->message.data(), run->message.size(), "%s", message);
  std::longjmp(run->jump, 1);
}

[[noreturn]] void OnError(j_common_ptr cinfo) {
  JpegRun& run = RunOf(cinfo);
  run.out_of_memory = cinfo->err->msg_code == JERR_OUT_OF_MEMORY;
  run.errors.format_message(cinfo, run.message.data());
  std::longjmp(run.jump, 1);
}

void OnMessage(j_common_ptr cinfo, int level) {
  if (level >= 0) {
    return;
  }
  JpegRun& run = RunOf(cinfo);
  const int message = cinfo->err->msg_code;
  run.has_run_out = run.has_run_out || message == JWRN_JPEG_EOF;
  if (run.has_run_out && message == JWRN_HIT_MARKER) {
    Fail(&run, "it is cut short");
  }
  if (++cinfo->err->num_warnings > kMaxWarnings) {
    Fail(&run, "its data are damaged in many places");
  }
}

void OnProgress(j_common_ptr cinfo) {
  JpegRun& run = RunOf(cinfo);
  if (run.cinfo.input_scan_number > kMaxScans) {
    Fail(&run, "it has more than 100 scans");
  }
  if (run.limits.should_stop && run.limits.should_stop()) {
    run.stopped = true;
    std::longjmp(run.jump, 1);
  }
}

void SetUp(JpegRun* run) {
  run->cinfo.err = jpeg_std_error(&run->errors);
  run->cinfo.client_data = run;
  run->errors.error_exit = OnError;
  run->errors.emit_message = OnMessage;
  run->progress.progress_monitor = OnProgress;
}

void CheckComponents(JpegRun* run) {
  const jpeg_decompress_struct& cinfo = run->cinfo;
  if (cinfo.image_width != run->header.width_px || cinfo.image_height != run->header.height_px) {
    Fail(run, "it has two sizes");
  }
  if (cinfo.num_components != 1 && cinfo.num_components != 3) {
    Fail(run, "it has neither one nor three components; convert it to RGB");
  }
}

// The library keeps all coefficients of an image in several scans.
void CheckCoefficients(JpegRun* run) {
  int64_t num_blocks = 0;
  for (int i = 0; i < run->cinfo.num_components; ++i) {
    const jpeg_component_info& component = run->cinfo.comp_info[i];
    num_blocks += int64_t{component.width_in_blocks} * component.height_in_blocks;
  }
  const int64_t num_bytes = num_blocks * static_cast<int64_t>(sizeof(JBLOCK));
  if (jpeg_has_multiple_scans(&run->cinfo) &&
      num_bytes / kMaxCoefficientBytesPerPixel > run->limits.max_pixels) {
    Fail(run, "it is too large for a progressive image; save it as baseline JPEG or scale it down");
  }
}

// True if every coefficient of a progressive image has come with all its bits.
bool HasAllBits(const jpeg_decompress_struct& cinfo) {
  for (int i = 0; i < cinfo.num_components; ++i) {
    for (int k = 0; k < DCTSIZE2; ++k) {
      if (cinfo.coef_bits == nullptr || cinfo.coef_bits[i][k] != 0) {
        return false;
      }
    }
  }
  return true;
}

// After the last row: true if an end marker follows, or if the data end where the pixels end.
bool IsComplete(JpegRun* run) {
  const jpeg_decompress_struct& cinfo = run->cinfo;
  if (jpeg_has_multiple_scans(&run->cinfo)) {
    return !run->has_run_out || HasAllBits(cinfo);
  }
  if (run->has_run_out) {
    return !cinfo.arith_code;  // An arithmetic decoder does not say that it lacks data.
  }
  if (cinfo.unread_marker == JPEG_EOI) {
    return true;
  }
  constexpr std::array<JOCTET, 2> kEndOfImage = {0xff, JPEG_EOI};
  const JOCTET* rest = cinfo.src->next_input_byte;
  const JOCTET* end = rest + cinfo.src->bytes_in_buffer;
  return cinfo.src->bytes_in_buffer <= kMaxPaddingBytes ||
         std::search(rest, end, kEndOfImage.begin(), kEndOfImage.end()) != end;
}

// Returns false if an error or `should_stop` ended the decoding.
bool Decode(JpegRun* run) {
  jpeg_decompress_struct* cinfo = &run->cinfo;
  if (setjmp(run->jump) != 0) {
    return false;
  }
  jpeg_create_decompress(cinfo);
  cinfo->progress = &run->progress;
  jpeg_mem_src(cinfo, run->bytes.data(), run->bytes.size());
  jpeg_read_header(cinfo, TRUE);
  CheckComponents(run);
  CheckCoefficients(run);
  cinfo->out_color_space = JCS_GRAYSCALE;
  cinfo->scale_num = run->scale;
  cinfo->scale_denom = kFullScale;
  jpeg_start_decompress(cinfo);
  while (cinfo->output_scanline < cinfo->output_height) {
    JSAMPROW row = run->pixels + static_cast<size_t>(cinfo->output_scanline) * cinfo->output_width;
    jpeg_read_scanlines(cinfo, &row, 1);
  }
  if (!IsComplete(run)) {
    Fail(run, "it is cut short");
  }
  return true;  // Ignores data after the last row, such as another image.
}

// A side of the image at a scale of `scale` eighths, as the library rounds it.
int64_t ScaledSide(int64_t side_px, int scale) {
  return (side_px * scale + kFullScale - 1) / kFullScale;
}

// The largest scale, in eighths, with at most `max_pixels`.
int ScaleWithin(const ImageHeader& header, int64_t max_pixels) {
  int scale = kFullScale;
  while (scale > 1 &&
         ScaledSide(header.width_px, scale) * ScaledSide(header.height_px, scale) > max_pixels) {
    --scale;
  }
  return scale;
}

}  // namespace

GrayImage DecodeJpeg(std::span<const uint8_t> bytes, const ImageHeader& header,
                     const ImageDecodeLimits& limits) {
  const int scale = ScaleWithin(header, limits.max_pixels);
  GrayImage image =
      BlankImage(ScaledSide(header.width_px, scale), ScaledSide(header.height_px, scale));
  if (scale != kFullScale) {
    image.full = FullPicture{.width_px = static_cast<int>(header.width_px),
                             .height_px = static_cast<int>(header.height_px),
                             .pixel_px = static_cast<double>(kFullScale) / scale};
  }
  JpegRun run{.bytes = bytes,
              .header = header,
              .limits = limits,
              .scale = scale,
              .pixels = image.pixels.data()};
  SetUp(&run);
  const bool done = Decode(&run);
  jpeg_destroy_decompress(&run.cinfo);
  RequireDecoded(done, run, "JPEG");
  return image;
}

}  // namespace cairn
