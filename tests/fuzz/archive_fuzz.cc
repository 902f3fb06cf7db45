// Archived sessions. A decoded session must be valid and equal the decoding of its own encoding.
// The input is decoded as it is, and as the parts of a file: sizes and contents of the manifest and
// the blocks, which get the frames and checksums that an attacker could compute, too.
#include <algorithm>
#include <cstring>
#include <span>
#include <sstream>
#include <string>

#include "core/error.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/seal.h"
#include "ingest/maps/archive_blocks.h"
#include "ingest/maps/archive_codec.h"

namespace cairn {
namespace {

constexpr ArchiveLimits kArchiveLimits = {.max_block_bytes = 1 << 20};
constexpr size_t kArchiveChecksumOffset = 16;

using Bytes = std::vector<uint8_t>;

void Append(std::span<const uint8_t> bytes, Bytes* file) {
  file->insert(file->end(), bytes.begin(), bytes.end());
}

// Takes a size and that number of bytes from the front, or all bytes that are left.
std::span<const uint8_t> TakePart(std::span<const uint8_t>* input) {
  uint16_t size = 0;
  std::memcpy(&size, input->data(), std::min(sizeof(size), input->size()));
  *input = input->subspan(std::min(sizeof(size), input->size()));
  const std::span<const uint8_t> part = input->first(std::min<size_t>(size, input->size()));
  *input = input->subspan(part.size());
  return part;
}

Bytes FileOfParts(std::span<const uint8_t> input) {
  const std::span<const uint8_t> manifest = TakePart(&input);
  Bytes file;
  ByteWriter writer(&file);
  writer.PutArray(std::span<const char>("CSES\1\0\0", 8));
  writer.Put(static_cast<uint32_t>(manifest.size()));
  writer.Put(uint32_t{0});
  writer.Put(uint64_t{0});
  writer.PutArray(manifest);
  file = testing::Sealed(file.data(), file.size(), kArchiveChecksumOffset);
  while (!input.empty()) {
    Append(archive::EncodeBlock(TakePart(&input)), &file);
  }
  return file;
}

ArchivedSession Decode(std::span<const uint8_t> file) {
  std::istringstream stream(std::string(file.begin(), file.end()));
  return DecodeSession(&stream, "archive", kArchiveLimits);
}

Bytes Encode(const ArchivedSession& session) {
  Bytes file;
  EncodeSession(session.manifest, session.reconstruction,
                [&](std::span<const uint8_t> bytes) { Append(bytes, &file); });
  return file;
}

void DecodeAndCompare(std::span<const uint8_t> file) {
  ArchivedSession session;
  try {
    session = Decode(file);
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kMapDamaged, error.what());
    return;
  }
  session.reconstruction.Validate();
  const Bytes again = Encode(session);
  CAIRN_CHECK(again == Encode(Decode(again)),
              "an archived session changes when it is encoded and decoded again");
}

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  cairn::DecodeAndCompare({data, size});
  cairn::DecodeAndCompare(cairn::FileOfParts({data, size}));
  return 0;
}
