// How the decoders of images report what went wrong. Private to them.
#ifndef CAIRN_CORE_IMAGES_DECODER_RESULT_H_
#define CAIRN_CORE_IMAGES_DECODER_RESULT_H_

#include <fmt/format.h>

#include <new>

#include "core/error.h"
#include "core/images/gray_image.h"

namespace cairn {

// Does nothing if `run` decoded its image (`done`). Otherwise throws DecodingStopped,
// std::bad_alloc, or Error(kBadInput) that names the format of the file. `Run` has the members
// `stopped`, `out_of_memory` and `message`.
template <typename Run>
void RequireDecoded(bool done, const Run& run, const char* format) {
  if (run.stopped) {
    throw DecodingStopped();
  }
  if (run.out_of_memory) {
    throw std::bad_alloc();
  }
  if (!done) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("the {} does not decode: {}", format, run.message.data()));
  }
}

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_DECODER_RESULT_H_
