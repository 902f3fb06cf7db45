#include "ingest/summarize/appearance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/check.h"
#include "core/error.h"
#include "ingest/random.h"

namespace cairn {
namespace {

constexpr int kMaxIterations = 10;

// Lloyd's k-means from a k-means++ start (Arthur and Vassilvitskii 2007).
class KMeansSummarizer : public AppearanceSummarizer {
 public:
  explicit KMeansSummarizer(const AppearanceOptions& options) : options_(options) {
    options.Validate();
  }

  int NumModes(int num_descriptors) const override {
    const int wanted = static_cast<int>(std::lround(options_.ratio * num_descriptors));
    return std::min(std::clamp(wanted, options_.min_count, options_.max_count), num_descriptors);
  }

  AppearanceModes Summarize(const DescriptorMatrix& descriptors) const override {
    CAIRN_CHECK(descriptors.rows() > 0, "a landmark has descriptors");
    const auto num_descriptors = static_cast<int>(descriptors.rows());
    const int num_modes = NumModes(num_descriptors);
    AppearanceModes modes;
    modes.mode_of_descriptor.assign(num_descriptors, 0);
    if (num_modes == 1) {
      modes.centers = descriptors.colwise().mean();
      return modes;
    }
    std::mt19937_64 rng(options_.seed);
    modes.centers = PickSpreadCenters(descriptors, num_modes, &rng);
    for (int i = 0; i < kMaxIterations && Assign(descriptors, &modes); ++i) {
      MoveCenters(descriptors, &modes);
    }
    DropEmptyModes(&modes);
    return modes;
  }

 private:
  // Rows of `descriptors`, each drawn with probability proportional to its squared distance from
  // the nearest one drawn before.
  static DescriptorMatrix PickSpreadCenters(const DescriptorMatrix& descriptors, int num_modes,
                                            std::mt19937_64* rng) {
    DescriptorMatrix centers(num_modes, descriptors.cols());
    centers.row(0) = descriptors.row(UniformIndex(descriptors.rows(), rng));
    Eigen::VectorXf sq_dist = (descriptors.rowwise() - centers.row(0)).rowwise().squaredNorm();
    for (int mode = 1; mode < num_modes; ++mode) {
      double remaining = UniformUnit(rng) * sq_dist.cast<double>().sum();
      Eigen::Index pick = 0;
      while (pick + 1 < sq_dist.size() && (remaining -= sq_dist[pick]) >= 0.0) ++pick;
      centers.row(mode) = descriptors.row(pick);
      sq_dist =
          sq_dist.cwiseMin((descriptors.rowwise() - centers.row(mode)).rowwise().squaredNorm());
    }
    return centers;
  }

  // Gives each descriptor to its nearest center; false if nothing changed.
  static bool Assign(const DescriptorMatrix& descriptors, AppearanceModes* modes) {
    bool changed = false;
    for (Eigen::Index i = 0; i < descriptors.rows(); ++i) {
      Eigen::Index nearest;
      (modes->centers.rowwise() - descriptors.row(i)).rowwise().squaredNorm().minCoeff(&nearest);
      changed |= modes->mode_of_descriptor[i] != static_cast<int>(nearest);
      modes->mode_of_descriptor[i] = static_cast<int>(nearest);
    }
    return changed;
  }

  // To the means of their members; a center without members stays.
  static void MoveCenters(const DescriptorMatrix& descriptors, AppearanceModes* modes) {
    DescriptorMatrix sums = DescriptorMatrix::Zero(modes->centers.rows(), modes->centers.cols());
    std::vector<int> counts(modes->centers.rows(), 0);
    for (Eigen::Index i = 0; i < descriptors.rows(); ++i) {
      sums.row(modes->mode_of_descriptor[i]) += descriptors.row(i);
      ++counts[modes->mode_of_descriptor[i]];
    }
    for (size_t mode = 0; mode < counts.size(); ++mode) {
      if (counts[mode] > 0) {
        modes->centers.row(mode) = sums.row(mode) / static_cast<float>(counts[mode]);
      }
    }
  }

  // Equal descriptors leave modes without members.
  static void DropEmptyModes(AppearanceModes* modes) {
    std::vector<int> new_mode(modes->centers.rows(), -1);
    for (const int mode : modes->mode_of_descriptor) new_mode[mode] = 0;
    int num_modes = 0;
    for (size_t mode = 0; mode < new_mode.size(); ++mode) {
      if (new_mode[mode] < 0) continue;
      modes->centers.row(num_modes) = modes->centers.row(mode).eval();
      new_mode[mode] = num_modes++;
    }
    modes->centers.conservativeResize(num_modes, Eigen::NoChange);
    for (int& mode : modes->mode_of_descriptor) mode = new_mode[mode];
  }

  AppearanceOptions options_;
};

}  // namespace

void AppearanceOptions::Validate() const {
  const auto require = [](bool ok, const char* what) {
    if (!ok) throw Error(ErrorCode::kInvalidArgument, fmt::format("AppearanceOptions: {}", what));
  };
  require(ratio >= 0.0 && ratio <= 1.0, "ratio must lie in [0, 1]");
  require(min_count >= 1, "min_count must be at least 1");
  require(max_count >= min_count, "max_count must be at least min_count");
}

std::unique_ptr<AppearanceSummarizer> MakeKMeansSummarizer(const AppearanceOptions& options) {
  return std::make_unique<KMeansSummarizer>(options);
}

}  // namespace cairn
