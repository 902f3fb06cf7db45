#include "ingest/tiles/appearance.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "core/check.h"
#include "core/random.h"
#include "core/require.h"
#include "ingest/tiles/tile_option_visit.h"

namespace cairn {
namespace {

constexpr int kMaxIterations = 10;

// Rows of `descriptors`, each drawn with probability proportional to its squared distance from the
// nearest one drawn before (k-means++, Arthur and Vassilvitskii 2007).
DescriptorMatrix PickSpreadCenters(const DescriptorMatrix& descriptors, int num_modes,
                                   std::mt19937_64* rng) {
  DescriptorMatrix centers(num_modes, descriptors.cols());
  centers.row(0) = descriptors.row(UniformIndex(descriptors.rows(), rng));
  Eigen::VectorXf sq_dist = (descriptors.rowwise() - centers.row(0)).rowwise().squaredNorm();
  for (int mode = 1; mode < num_modes; ++mode) {
    double remaining = UniformUnit(rng) * sq_dist.cast<double>().sum();
    Eigen::Index pick = 0;
    while (pick + 1 < sq_dist.size() && (remaining -= sq_dist[pick]) >= 0.0) {
      ++pick;
    }
    centers.row(mode) = descriptors.row(pick);
    sq_dist = sq_dist.cwiseMin((descriptors.rowwise() - centers.row(mode)).rowwise().squaredNorm());
  }
  return centers;
}

// Gives each descriptor to its nearest center; false if nothing changed.
bool AssignToNearest(const DescriptorMatrix& descriptors, AppearanceModes* modes) {
  bool changed = false;
  for (Eigen::Index i = 0; i < descriptors.rows(); ++i) {
    Eigen::Index nearest;
    (modes->centers.rowwise() - descriptors.row(i)).rowwise().squaredNorm().minCoeff(&nearest);
    changed |= modes->mode_of_descriptor[i] != static_cast<int>(nearest);
    modes->mode_of_descriptor[i] = static_cast<int>(nearest);
  }
  return changed;
}

// Equal descriptors leave modes without members.
void DropEmptyModes(AppearanceModes* modes) {
  std::vector<int> new_mode(modes->centers.rows(), -1);
  for (const int mode : modes->mode_of_descriptor) {
    new_mode[mode] = 0;
  }
  int num_modes = 0;
  for (size_t mode = 0; mode < new_mode.size(); ++mode) {
    if (new_mode[mode] < 0) {
      continue;
    }
    modes->centers.row(num_modes) = modes->centers.row(mode).eval();
    new_mode[mode] = num_modes++;
  }
  modes->centers.conservativeResize(num_modes, Eigen::NoChange);
  for (int& mode : modes->mode_of_descriptor) {
    mode = new_mode[mode];
  }
}

// What all kinds share: how many modes there are, and that they start from nothing but the options'
// seed.
class SeededSummarizer : public AppearanceSummarizer {
 public:
  explicit SeededSummarizer(const AppearanceOptions& options) : options_(options) {
    options.Validate();
  }

  int NumModes(int num_descriptors) const override {
    if (options_.count > 0) {
      return std::min(options_.count, num_descriptors);
    }
    const int wanted = static_cast<int>(std::lround(options_.ratio * num_descriptors));
    return std::min(std::clamp(wanted, options_.min_count, options_.max_count), num_descriptors);
  }

  AppearanceModes Summarize(const DescriptorMatrix& descriptors) const override {
    CAIRN_CHECK(descriptors.rows() > 0, "a landmark has descriptors");
    AppearanceModes modes;
    modes.mode_of_descriptor.assign(descriptors.rows(), 0);
    std::mt19937_64 rng(options_.seed);
    Fill(descriptors, NumModes(static_cast<int>(descriptors.rows())), &rng, &modes);
    DropEmptyModes(&modes);
    return modes;
  }

 private:
  // Sets centers and who belongs to them; all belong to the first before.
  virtual void Fill(const DescriptorMatrix& descriptors, int num_modes, std::mt19937_64* rng,
                    AppearanceModes* modes) const = 0;

  AppearanceOptions options_;
};

// Lloyd's k-means.
class KMeansSummarizer : public SeededSummarizer {
 public:
  using SeededSummarizer::SeededSummarizer;

 private:
  void Fill(const DescriptorMatrix& descriptors, int num_modes, std::mt19937_64* rng,
            AppearanceModes* modes) const override {
    if (num_modes == 1) {
      modes->centers = descriptors.colwise().mean();
      return;
    }
    modes->centers = PickSpreadCenters(descriptors, num_modes, rng);
    for (int i = 0; i < kMaxIterations && AssignToNearest(descriptors, modes); ++i) {
      MoveCenters(descriptors, modes);
    }
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
};

class KMedoidsSummarizer : public SeededSummarizer {
 public:
  using SeededSummarizer::SeededSummarizer;

 private:
  void Fill(const DescriptorMatrix& descriptors, int num_modes, std::mt19937_64* rng,
            AppearanceModes* modes) const override {
    modes->centers = PickSpreadCenters(descriptors, num_modes, rng);
    AssignToNearest(descriptors, modes);
    for (int i = 0; i < kMaxIterations; ++i) {
      for (int mode = 0; mode < num_modes; ++mode) {
        MoveCenter(descriptors, mode, modes);
      }
      if (!AssignToNearest(descriptors, modes)) {
        break;
      }
    }
  }

  // To the member with the least sum of distances to the others.
  static void MoveCenter(const DescriptorMatrix& descriptors, int mode, AppearanceModes* modes) {
    std::vector<int> members;
    for (size_t i = 0; i < modes->mode_of_descriptor.size(); ++i) {
      if (modes->mode_of_descriptor[i] == mode) {
        members.push_back(static_cast<int>(i));
      }
    }
    const DescriptorMatrix rows = descriptors(members, Eigen::all);
    float least = std::numeric_limits<float>::infinity();
    for (const int member : members) {
      const float sum = (rows.rowwise() - descriptors.row(member)).rowwise().norm().sum();
      if (sum < least) {
        least = sum;
        modes->centers.row(mode) = descriptors.row(member);
      }
    }
  }
};

class RandomSummarizer : public SeededSummarizer {
 public:
  using SeededSummarizer::SeededSummarizer;

 private:
  void Fill(const DescriptorMatrix& descriptors, int num_modes, std::mt19937_64* rng,
            AppearanceModes* modes) const override {
    // Not the same rows for all landmarks: descriptors come in the order of the drive.
    std::mt19937_64 own_rng((*rng)() ^ std::bit_cast<uint32_t>(descriptors(0, 0)));
    std::vector<int> rows(descriptors.rows());
    std::iota(rows.begin(), rows.end(), 0);
    for (int i = 0; i < num_modes; ++i) {
      std::swap(rows[i], rows[i + static_cast<int>(UniformIndex(rows.size() - i, &own_rng))]);
    }
    rows.resize(num_modes);
    modes->centers = descriptors(rows, Eigen::all);
    AssignToNearest(descriptors, modes);
  }
};

}  // namespace

void AppearanceOptions::Validate() const {
  CheckOptions("ingest.appearance", *this);
  RequireOption(max_count >= min_count, "ingest.appearance.max_count must be at least min_count");
}

std::unique_ptr<AppearanceSummarizer> MakeKMeansSummarizer(const AppearanceOptions& options) {
  return std::make_unique<KMeansSummarizer>(options);
}

std::unique_ptr<AppearanceSummarizer> MakeKMedoidsSummarizer(const AppearanceOptions& options) {
  return std::make_unique<KMedoidsSummarizer>(options);
}

std::unique_ptr<AppearanceSummarizer> MakeRandomSummarizer(const AppearanceOptions& options) {
  return std::make_unique<RandomSummarizer>(options);
}

std::unique_ptr<AppearanceSummarizer> MakeAppearanceSummarizer(const AppearanceOptions& options) {
  switch (options.kind) {
    case AppearanceKind::kKMedoids:
      return MakeKMedoidsSummarizer(options);
    case AppearanceKind::kRandom:
      return MakeRandomSummarizer(options);
    case AppearanceKind::kKMeans:
      break;
  }
  return MakeKMeansSummarizer(options);
}

}  // namespace cairn
