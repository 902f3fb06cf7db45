#include "ingest/codebook/transcoder.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <utility>

#include "core/check.h"
#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

// Descriptors decoded at a time.
constexpr size_t kBlock = 65'536;

}  // namespace

std::string WhyNotTranscodable(const Codebook& from, const Codebook& to) {
  if (from.descriptor_type != to.descriptor_type || from.raw_dim() != to.raw_dim()) {
    return fmt::format(
        "one codebook is for {}-D descriptors of type '{}', the other for {}-D descriptors of "
        "type '{}'",
        from.raw_dim(), Excerpt(from.descriptor_type), to.raw_dim(), Excerpt(to.descriptor_type));
  }
  if (from.normalization != to.normalization) {
    return "the codebooks normalize descriptors differently";
  }
  return "";
}

Transcoder::Transcoder(std::shared_ptr<const Codebook> from, std::shared_ptr<const Codebook> to)
    : from_(std::move(from)), to_(std::move(to)) {
  const Codebook& source = from_.codebook();
  const Codebook& target = to_.codebook();
  const std::string reason = WhyNotTranscodable(source, target);
  if (!reason.empty()) {
    throw Error(ErrorCode::kBadInput, reason);
  }
  const Eigen::MatrixXd raw_from_projected =
      source.projection.cast<double>().completeOrthogonalDecomposition().pseudoInverse();
  const Eigen::MatrixXd projection = target.projection.cast<double>();
  to_from_projected_ = (projection * raw_from_projected).transpose().cast<float>();
  offset_ = (projection * (source.mean - target.mean).cast<double>()).transpose().cast<float>();
}

std::vector<uint8_t> Transcoder::Transcode(const std::vector<uint8_t>& codes) const {
  const auto code_size = static_cast<size_t>(from_.codebook().num_subspaces);
  CAIRN_CHECK(codes.size() % code_size == 0, "whole codes");
  const size_t num_codes = codes.size() / code_size;
  std::vector<uint8_t> transcoded;
  transcoded.reserve(num_codes * static_cast<size_t>(target().num_subspaces));
  for (size_t begin = 0; begin < num_codes; begin += kBlock) {
    const auto count = static_cast<int>(std::min(kBlock, num_codes - begin));
    DescriptorMatrix projected =
        from_.Decode(codes.data() + begin * code_size, count) * to_from_projected_;
    projected.rowwise() += offset_;
    const std::vector<uint8_t> block = to_.Encode(projected);
    transcoded.insert(transcoded.end(), block.begin(), block.end());
  }
  return transcoded;
}

void Transcoder::Transcode(Tile* tile) const {
  tile->codes = Transcode(tile->codes);
  tile->codebook_id = target().id;
  tile->code_size = target().num_subspaces;
}

}  // namespace cairn
