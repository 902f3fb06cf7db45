// What the bytes in the table `descriptors` of a COLMAP database are.
#ifndef CAIRN_INGEST_READERS_COLMAP_DESCRIPTORS_H_
#define CAIRN_INGEST_READERS_COLMAP_DESCRIPTORS_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace cairn {

constexpr int kSiftDim = 128;

// COLMAP's option SiftExtraction.normalization. A byte is 512 times
enum class SiftNormalization {
  kL1Root,  // the square root of the L1-normalised number (the default).
  kL2,      // the L2-normalised number.
};

// Throws Error(kBadInput) that says what the descriptors of `image_name` are unless they are bytes
// of SIFT. `type` is COLMAP's FeatureExtractorType, which databases have since 3.14; the blob has
// `num_bytes` for `rows` x `cols`.
void CheckSiftBlob(const std::string& image_name, std::optional<int64_t> type, int64_t rows,
                   int64_t cols, uint64_t num_bytes);

// Tells the normalisation by the statistics of SIFT: how even the numbers of a row are, that is
// sum / sqrt(count of those not zero * sum of squares). Of photos of streets 80 images by COLMAP
// had means from 0.781 to 0.822; the same descriptors, L2-normalised, 0.633 to 0.666.
class SiftStatistics {
 public:
  // Rows of kSiftDim bytes. Looks at a hundred of them.
  void Add(std::span<const uint8_t> rows);

  bool IsEnough() const { return num_rows_ >= 2000; }

  // kL1Root if there were fewer than 100 rows. Throws Error(kBadInput) if the rows are not of
  // length 512, as both normalisations make them.
  SiftNormalization Normalization() const;

 private:
  int num_rows_ = 0;
  double sum_evenness_ = 0.0;
  double sum_length_ = 0.0;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_READERS_COLMAP_DESCRIPTORS_H_
