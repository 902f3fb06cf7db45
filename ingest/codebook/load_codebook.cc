#include "ingest/codebook/load_codebook.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "ingest/codebook/shipped_codebook.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

constexpr std::string_view kShipped = "shipped";
constexpr std::string_view kMagic = "CCBK";
// The largest codebook has 4096 x 512 floats in its projection; no larger file is read.
constexpr size_t kMaxBytes = size_t{16} << 20;

// The first bytes of a file; empty if it is not a file.
std::vector<uint8_t> ReadStart(const std::string& path, size_t max_bytes) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    return {};
  }
  std::ifstream file(path, std::ios::binary);
  std::vector<uint8_t> bytes(max_bytes);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(max_bytes));
  bytes.resize(static_cast<size_t>(std::max<std::streamsize>(0, file.gcount())));
  return bytes;
}

bool IsCodebookFile(const std::string& path) {
  const std::vector<uint8_t> start = ReadStart(path, kMagic.size());
  return std::equal(start.begin(), start.end(), kMagic.begin(), kMagic.end());
}

std::shared_ptr<const Codebook> DecodeFile(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadStart(path, kMaxBytes);
  try {
    return std::make_shared<const Codebook>(
        DecodeCodebook(bytes.data(), bytes.size(), CodebookId{}));
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what());
  }
}

}  // namespace

std::shared_ptr<const Codebook> LoadCodebook(const std::string& source) {
  if (source == kShipped) {
    return ShippedCodebook();
  }
  if (IsCodebookFile(source)) {
    return DecodeFile(source);
  }
  const MapStore store = MapStore::Open(source, OpenMode::kReadOnly);
  std::shared_ptr<const Codebook> codebook = store.Snapshot().CurrentCodebook();
  if (codebook == nullptr) {
    throw Error(ErrorCode::kBadInput,
                source + ": the map has no codebook, as nothing was ingested yet");
  }
  return codebook;
}

}  // namespace cairn
