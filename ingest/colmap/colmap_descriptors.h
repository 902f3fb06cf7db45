// Identifies the contents of the table `descriptors` in a COLMAP database.
#ifndef CAIRN_INGEST_COLMAP_COLMAP_DESCRIPTORS_H_
#define CAIRN_INGEST_COLMAP_COLMAP_DESCRIPTORS_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace cairn {

constexpr int kColmapDim = 128;
// The Euclidean norm of a row of bytes.
constexpr float kColmapNorm = 512.0f;

// COLMAP's option SiftExtraction.normalization. The name states what a stored byte is.
enum class SiftNormalization {
  kL1Root,  // 512 times the square root of the L1-normalized value (the default).
  kL2,      // 512 times the L2-normalized value.
};

// Throws Error(kBadInput), which describes the descriptors of `image_name`, unless they are SIFT in
// bytes. `type` is COLMAP's FeatureExtractorType, which databases have since 3.14. The blob has
// `num_bytes` for `rows` x `cols` values.
void CheckSiftBlob(const std::string& image_name, std::optional<int64_t> type, int64_t rows,
                   int64_t cols, uint64_t num_bytes);

// Determines the normalization from the evenness of the values in a row: sum / sqrt(number of
// nonzero values * sum of squares). For 80 street images processed by COLMAP, the mean evenness was
// 0.781 to 0.822; for the same descriptors with L2 normalization, it was 0.633 to 0.666.
class SiftStatistics {
 public:
  // Adds rows of kColmapDim bytes. Uses at most a hundred of them.
  void Add(std::span<const uint8_t> rows);

  bool IsEnough() const { return num_rows_ >= 2000; }

  // Returns kL1Root if there were fewer than 100 rows. Throws Error(kBadInput) if the rows do not
  // have length 512, which both normalizations give.
  SiftNormalization Normalization() const;

 private:
  int num_rows_ = 0;
  double sum_evenness_ = 0.0;
  double sum_length_ = 0.0;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_COLMAP_DESCRIPTORS_H_
