#include "ingest/images/jpeg_decoder.h"

#include <array>
#include <csetjmp>
#include <cstdio>
#include <string>

#include "ingest/images/decoder_result.h"

// clang-format off
#include <jpeglib.h>  // Needs <cstdio>.
#include <jerror.h>   // Needs jpeglib.h.
// clang-format on

namespace cairn {
namespace {

constexpr int kMaxScans = 100;
// Some cameras write stray bytes between segments. Damaged pixels give one warning per block.
constexpr int kMaxWarnings = 100;

// The state of one decoding. The library exits by longjmp, so nothing between setjmp and longjmp
// may have a destructor.
struct JpegRun {
  std::span<const uint8_t> bytes;
  const ImageHeader& header;
  const ImageDecodeLimits& limits;
  uint8_t* pixels = nullptr;

  jpeg_decompress_struct cinfo = {};
  jpeg_error_mgr errors = {};
  jpeg_progress_mgr progress = {};
  std::jmp_buf jump = {};
  bool stopped = false;
  bool out_of_memory = false;
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
  if (level < 0 && ++cinfo->err->num_warnings > kMaxWarnings) {
    Fail(&RunOf(cinfo), "its data are damaged in many places");
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
  if (cinfo->image_width != run->header.width_px || cinfo->image_height != run->header.height_px) {
    Fail(run, "it has two sizes");
  }
  if (cinfo->num_components != 1 && cinfo->num_components != 3) {
    Fail(run, "it has neither one nor three components; convert it to RGB");
  }
  cinfo->out_color_space = JCS_GRAYSCALE;
  jpeg_start_decompress(cinfo);
  while (cinfo->output_scanline < cinfo->output_height) {
    JSAMPROW row = run->pixels + static_cast<size_t>(cinfo->output_scanline) * cinfo->output_width;
    jpeg_read_scanlines(cinfo, &row, 1);
  }
  return true;  // Ignores data after the last row, such as another image.
}

}  // namespace

GrayImage DecodeJpeg(std::span<const uint8_t> bytes, const ImageHeader& header,
                     const ImageDecodeLimits& limits) {
  GrayImage image = BlankImage(header.width_px, header.height_px);
  JpegRun run{.bytes = bytes, .header = header, .limits = limits, .pixels = image.pixels.data()};
  SetUp(&run);
  const bool done = Decode(&run);
  jpeg_destroy_decompress(&run.cinfo);
  RequireDecoded(done, run, "JPEG");
  return image;
}

}  // namespace cairn
