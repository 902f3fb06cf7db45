#include "lab/descriptors/descriptor_fit.h"

#include <ceres/dynamic_numeric_diff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/adjust/quiet_ceres.h"
#include "core/check.h"
#include "core/error.h"
#include "core/statistics.h"
#include "lab/descriptors/descriptor_statistics.h"

namespace cairn {
namespace {

constexpr int kRounds = 2;
constexpr int kAxisSteps = 4;
constexpr int kMaxIterations = 6;
// Smallest share of an axis' spread. Elements must not be negative, which moves spread from strong
// axes to weak ones; some weak axes have less spread than they receive.
constexpr float kLeastBetweenShare = 0.2f;
constexpr double kMaxClusterShare = 0.3;
// Limits for pairs with almost the same view. Few photos of the facade are as similar as those of a
// street.
constexpr float kNearStreetRad = 0.02f;
constexpr float kNearFacadeRad = 0.35f;
constexpr float kNearLog2Scale = 0.2f;
constexpr int kModeLandmarks = 1000;
constexpr int kMinPairs = 40;
constexpr double kManyPairs = 400.0;  // More pairs get no more weight.
constexpr float kMaxRenderedLog2Scale = 0.3f;
constexpr uint64_t kSeed = 1;
constexpr float kMaxSamePlaceDistance = 0.6f;
constexpr float kMaxRepeatDistance = 0.5f;
// Spread and correlation each weigh as much as a quarter of a street's medians.
constexpr double kSpreadWeight = 0.5;
// Weight of places that are flatter than streets.
constexpr double kPlanarWeight = 0.5;
constexpr double kNumericStep = 0.05;

double LogOf(float value) { return std::log(std::max(1e-9f, value)); }

class ResidualList {
 public:
  void Add(std::string name, double model, double real, double weight) {
    residuals_.push_back({std::move(name), model - real, weight});
  }
  std::vector<DescriptorResidual> Take() { return std::move(residuals_); }

 private:
  std::vector<DescriptorResidual> residuals_;
};

std::vector<float> Pick(const std::vector<float>& values, const std::vector<int>& indices) {
  std::vector<float> picked;
  for (const int i : indices) {
    picked.push_back(values[i]);
  }
  return picked;
}

// Adds the cells of a place. All cells together have the weight `sq_weight`.
void AddCells(const std::string& place, const RealLooks& real, const RealLooks& model,
              float max_log2_scale, double sq_weight, ResidualList* residuals) {
  const std::vector<LookPair> pairs = PairsOf(real.looks);
  const std::vector<float> real_sq = SqDistances(real.root, pairs);
  const std::vector<float> model_sq = SqDistances(model.root, pairs);
  std::vector<ViewCell> cells = ViewCells(pairs, kMinPairs);
  std::erase_if(cells, [&](const ViewCell& c) { return c.max_log2_scale > max_log2_scale; });
  const auto share = [](const ViewCell& cell) {
    return std::min(1.0, static_cast<double>(cell.pairs.size()) / kManyPairs);
  };
  double sum = 0.0;
  for (const ViewCell& cell : cells) {
    sum += share(cell);
  }
  for (const ViewCell& cell : cells) {
    residuals->Add(
        fmt::format("{} {:.2f} rad 2^{:.2f}", place, cell.max_angle_rad, cell.max_log2_scale),
        LogOf(ValueAtShare(Pick(model_sq, cell.pairs), 0.5)),
        LogOf(ValueAtShare(Pick(real_sq, cell.pairs), 0.5)),
        std::sqrt(sq_weight * share(cell) / sum));
  }
}

void AddSpread(const std::string& place, const RealLooks& real, const RealLooks& model,
               bool is_rendered, ResidualList* residuals) {
  const std::vector<LookPair> pairs = PairsOf(real.looks);
  residuals->Add(place + " pairs, 75 %", LogOf(ValueAtShare(SqDistances(model.root, pairs), 0.75)),
                 LogOf(ValueAtShare(SqDistances(real.root, pairs), 0.75)),
                 is_rendered ? 0.0 : 2.0 * kSpreadWeight);
  const NearSpread of_real = SpreadOfNearViews(real.looks, pairs, SqDistances(real.root, pairs));
  const NearSpread of_model = SpreadOfNearViews(real.looks, pairs, SqDistances(model.root, pairs));
  residuals->Add(place + " spread", of_model.log_sq_distance_range, of_real.log_sq_distance_range,
                 kSpreadWeight);
  residuals->Add(place + " correlation", of_model.landmark_correlation,
                 of_real.landmark_correlation, kSpreadWeight);
}

// Log of the median distance over the pairs that are alike at all.
double LogRepeatDistance(const DescriptorMatrix& root, const std::vector<LookPair>& pairs) {
  std::vector<float> sq_distances = SqDistances(root, pairs);
  std::erase_if(sq_distances,
                [](float sq) { return sq > kMaxRepeatDistance * kMaxRepeatDistance; });
  return sq_distances.empty() ? 0.0 : LogOf(ValueAtShare(std::move(sq_distances), 0.5));
}

// Adds the nearest-neighbor distances of a set of descriptors that show different things.
void AddNearest(const std::string& place, const DescriptorMatrix& real,
                const DescriptorMatrix& model, ResidualList* residuals) {
  for (const int num_others : {100, 1000, 2500}) {
    const std::vector<float> of_real = NearestDistances(real, num_others, kSeed);
    const std::vector<float> of_model = NearestDistances(model, num_others, kSeed);
    for (const double share : {0.05, 0.25, 0.5, 0.75, 0.95}) {
      residuals->Add(fmt::format("{} nearest of {}, {:.0f} %", place, num_others, 100.0 * share),
                     LogOf(ValueAtShare(of_model, share)), LogOf(ValueAtShare(of_real, share)),
                     1.0);
    }
  }
  const std::vector<float> of_real = RandomDistances(real, kSeed);
  const std::vector<float> of_model = RandomDistances(model, kSeed);
  for (const double share : {0.001, 0.01, 0.1, 0.5, 0.9}) {
    residuals->Add(fmt::format("{} random pair, {:.1f} %", place, 100.0 * share),
                   LogOf(ValueAtShare(of_model, share)), LogOf(ValueAtShare(of_real, share)), 1.0);
  }
}

// Returns the fall of the median from 1,000 to all descriptors of a large crowd. The crowd's own
// spread may differ.
double LogFall(const DescriptorMatrix& root) {
  const auto all = static_cast<int>(root.rows());
  return LogOf(ValueAtShare(NearestDistances(root, all, kSeed), 0.5)) -
         LogOf(ValueAtShare(NearestDistances(root, all / 10, kSeed), 0.5));
}

// A parameter is `value` times e^(x - 1). x starts at 1, so that all parameters have the same step.
using Setter = std::function<void(const std::vector<double>& factors, DescriptorModelOptions*)>;
using Residuals = std::function<std::vector<DescriptorResidual>(const DescriptorModelOptions&)>;

class FitFunctor {
 public:
  FitFunctor(DescriptorModelOptions start, int num_parameters, Setter set, Residuals residuals)
      : start_(std::move(start)),
        num_parameters_(num_parameters),
        set_(std::move(set)),
        residuals_(std::move(residuals)) {}

  DescriptorModelOptions OptionsAt(const double* x) const {
    std::vector<double> factors;
    for (int i = 0; i < num_parameters_; ++i) {
      factors.push_back(std::exp(x[i] - 1.0));
    }
    DescriptorModelOptions options = start_;
    set_(factors, &options);
    return options;
  }

  bool operator()(double const* const* x, double* residuals) const {
    try {
      for (const DescriptorResidual& residual : residuals_(OptionsAt(x[0]))) {
        *residuals++ = residual.weight * residual.value;
      }
    } catch (const Error&) {  // The step left the options' range.
      return false;
    }
    return true;
  }

 private:
  DescriptorModelOptions start_;
  int num_parameters_;
  Setter set_;
  Residuals residuals_;
};

DescriptorModelOptions Minimize(const DescriptorModelOptions& start, int num_parameters,
                                const Setter& set, const Residuals& residuals) {
  ceres::NumericDiffOptions numeric;
  numeric.relative_step_size = kNumericStep;
  const FitFunctor functor(start, num_parameters, set, residuals);
  auto* cost = new ceres::DynamicNumericDiffCostFunction<FitFunctor, ceres::CENTRAL>(
      &functor, ceres::DO_NOT_TAKE_OWNERSHIP, numeric);
  cost->AddParameterBlock(num_parameters);
  cost->SetNumResiduals(static_cast<int>(residuals(start).size()));
  std::vector<double> x(static_cast<size_t>(num_parameters), 1.0);
  ceres::Problem problem;
  problem.AddResidualBlock(cost, nullptr, x.data());
  ceres::Solver::Options options = QuietCeresOptions();
  options.max_num_iterations = kMaxIterations;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 1e-3;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return functor.OptionsAt(x.data());
}

void SetAll(const std::vector<double>& factors, DescriptorModelOptions* options) {
  double* const fields[] = {&options->noise_length,         &options->view_length,
                            &options->view_angle_scale_rad, &options->view_log2_scale,
                            &options->log_look_spread,      &options->log_stability_spread,
                            &options->instance_length,      &options->cluster_share,
                            &options->log_cluster_spread,   &options->log_landmark_spread};
  for (size_t i = 0; i < std::size(fields); ++i) {
    *fields[i] *= factors[i];
  }
  options->cluster_share = std::min(options->cluster_share, kMaxClusterShare);
}
constexpr int kNumFitted = 10;

// Returns the streets whose descriptors spread like real ones. If none was photographed, returns
// all streets.
std::vector<const DescriptorFitStreet*> Photographed(const DescriptorFitData& data) {
  const bool has_photos = std::any_of(data.streets.begin(), data.streets.end(),
                                      [](const auto& street) { return !street.is_rendered; });
  std::vector<const DescriptorFitStreet*> streets;
  for (const DescriptorFitStreet& street : data.streets) {
    if (!has_photos || !street.is_rendered) {
      streets.push_back(&street);
    }
  }
  return streets;
}

// Returns the mean over the streets of log(`values(street)`).
Eigen::ArrayXf MeanLog(const DescriptorFitData& data,
                       const std::function<Eigen::VectorXf(const RealLooks&)>& values) {
  Eigen::ArrayXf sum = Eigen::ArrayXf::Zero(DescriptorModel::kDim);
  const std::vector<const DescriptorFitStreet*> streets = Photographed(data);
  for (const DescriptorFitStreet* street : streets) {
    sum += values(street->looks).array().max(1e-6f).log();
  }
  return sum / static_cast<float>(streets.size());
}

// Averages neighboring ranks, which removes peculiarities of one street or one seed.
float MeanAbout(const Eigen::ArrayXf& values, int rank, int width) {
  const int begin = std::max(0, rank - width);
  return values.segment(begin, std::min(DescriptorModel::kDim, rank + width + 1) - begin).mean();
}

void FitAxes(const DescriptorFitData& data, DescriptorModelOptions* options) {
  const Eigen::ArrayXf within = MeanLog(data, [](const RealLooks& looks) {
    return Eigen::VectorXf(
        WithinSigmas(looks.root, PairsOf(looks.looks), kMaxSamePlaceDistance).normalized());
  });
  const Eigen::ArrayXf total =
      MeanLog(data, [](const RealLooks& looks) { return PrincipalSigmas(FirstLooks(looks)); });
  for (DescriptorAxis& axis : options->axes) {
    axis.within = std::exp(MeanAbout(within, axis.rank, axis.rank / 8));
    axis.between = std::exp(MeanAbout(total, axis.rank, axis.rank / 8));
  }
  Eigen::ArrayXf log_factor = Eigen::ArrayXf::Zero(DescriptorModel::kDim);
  const std::vector<DescriptorAxis> start = options->axes;
  for (int step = 0; step < kAxisSteps; ++step) {
    const DescriptorModel model(*options);
    log_factor += total - MeanLog(data, [&](const RealLooks& looks) {
                    return PrincipalSigmas(FirstLooks(Simulate(looks, model)));
                  });
    for (size_t i = 0; i < start.size(); ++i) {
      const int rank = start[i].rank;
      options->axes[i].between =
          start[i].between *
          std::max(kLeastBetweenShare, std::exp(MeanAbout(log_factor, rank, 4 + rank / 8)));
    }
  }
}

// Median of the squared distances between looks from almost the same place.
double NearSqDistance(const RealLooks& looks, float max_angle_rad) {
  std::vector<LookPair> pairs = PairsOf(looks.looks);
  std::erase_if(pairs, [&](const LookPair& pair) {
    return pair.angle_rad > max_angle_rad || pair.log2_scale > kNearLog2Scale;
  });
  return pairs.empty() ? 0.0 : ValueAtShare(SqDistances(looks.root, pairs), 0.5);
}

// Squared distance between descriptors of one view in two modes. Nothing else tells the looks
// apart.
double SqDistanceOfModes(DescriptorModelOptions options) {
  options.noise_length = options.view_length = 0.0;
  RealLooks looks;
  for (int landmark = 0; landmark < kModeLandmarks; ++landmark) {
    for (int mode = 0; mode < 2; ++mode) {
      looks.looks.push_back(
          {.ornament = landmark, .landmark = landmark, .image = mode, .appearance_mode = mode});
    }
  }
  return NearSqDistance(Simulate(looks, DescriptorModel(options)), kNearStreetRad);
}

// The facade's pairs also differ in view, if only a little. The effect of its modes is therefore
// measured against pairs of the streets with almost equal views, and is not fitted together with
// the effect of the view.
void FitMode(const DescriptorFitData& data, DescriptorModelOptions* options) {
  double of_streets = 0.0;
  for (const DescriptorFitStreet& street : data.streets) {
    of_streets += NearSqDistance(street.looks, kNearStreetRad);
  }
  of_streets /= static_cast<double>(data.streets.size());
  const double excess = NearSqDistance(data.facade, kNearFacadeRad) - of_streets;
  options->mode_length *= std::sqrt(std::max(0.0, excess) / SqDistanceOfModes(*options));
}

}  // namespace

std::vector<DescriptorResidual> WithinResiduals(const DescriptorFitData& data,
                                                const DescriptorModelOptions& options) {
  const DescriptorModel model(options);
  ResidualList residuals;
  for (const DescriptorFitStreet& street : data.streets) {
    const RealLooks simulated = Simulate(street.looks, model);
    AddCells(street.name, street.looks, simulated,
             street.is_rendered ? kMaxRenderedLog2Scale : std::numeric_limits<float>::infinity(),
             street.is_rendered ? kPlanarWeight : 1.0, &residuals);
    AddSpread(street.name, street.looks, simulated, street.is_rendered, &residuals);
  }
  if (data.facade.size() > 0) {
    AddCells("facade", data.facade, Simulate(data.facade, model),
             std::numeric_limits<float>::infinity(), kPlanarWeight, &residuals);
  }
  if (data.repeats.size() > 0) {
    const std::vector<LookPair> pairs = PairsOf(data.repeats.looks);
    residuals.Add("repeats", LogRepeatDistance(Simulate(data.repeats, model).root, pairs),
                  LogRepeatDistance(data.repeats.root, pairs), 1.0);
  }
  return residuals.Take();
}

std::vector<DescriptorResidual> BetweenResiduals(const DescriptorFitData& data,
                                                 const DescriptorModelOptions& options) {
  const DescriptorModel model(options);
  ResidualList residuals;
  for (const DescriptorFitStreet* street : Photographed(data)) {
    AddNearest(street->name, FirstLooks(street->looks), FirstLooks(Simulate(street->looks, model)),
               &residuals);
  }
  if (data.crowd.rows() > 0) {
    const DescriptorMatrix clutter = SimulateClutter(static_cast<int>(data.crowd.rows()), model);
    residuals.Add("crowd's fall", LogFall(clutter), LogFall(data.crowd), 3.0);
  }
  return residuals.Take();
}

DescriptorModelOptions FitDescriptorModel(const DescriptorFitData& data,
                                          const DescriptorModelOptions& start,
                                          const std::function<void(const std::string&)>& progress) {
  CAIRN_CHECK(!data.streets.empty(), "the fit needs at least one street");
  const auto report = [&](const char* what, const std::vector<DescriptorResidual>& residuals) {
    double sum = 0.0, weight = 0.0;
    for (const DescriptorResidual& residual : residuals) {
      sum += std::pow(residual.weight * residual.value, 2);
      weight += residual.weight * residual.weight;
    }
    if (progress) {
      progress(fmt::format("{}: model and data differ by e^{:.3f}", what,
                           std::sqrt(sum / std::max(1e-9, weight))));
    }
  };
  DescriptorModelOptions options = start;
  for (int round = 0; round < kRounds; ++round) {
    FitAxes(data, &options);
    if (data.facade.size() > 0) {
      FitMode(data, &options);
    }
    options = Minimize(options, kNumFitted, SetAll, [&](const DescriptorModelOptions& at) {
      std::vector<DescriptorResidual> all = WithinResiduals(data, at);
      for (DescriptorResidual& residual : BetweenResiduals(data, at)) {
        all.push_back(std::move(residual));
      }
      return all;
    });
    report("within landmarks", WithinResiduals(data, options));
    report("between landmarks", BetweenResiduals(data, options));
  }
  return options;
}

}  // namespace cairn
