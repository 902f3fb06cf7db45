#include "lab/descriptors/descriptor_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <vector>

#include "core/file_bytes.h"
#include "core/statistics.h"
#include "lab/descriptors/descriptor_statistics.h"

namespace cairn {
namespace {

constexpr uint64_t kPlotSeed = 1;
constexpr int kMinPairsOfPoint = 40;

// A place in the real data and in the model.
struct Place {
  std::string name;
  RealLooks real;
  RealLooks model;
  std::vector<LookPair> pairs;
};

std::string Header(const char* first, const std::vector<Place>& places) {
  std::string header = first;
  for (const Place& place : places) {
    header += fmt::format(",{0},{0} model", place.name);
  }
  return header + "\n";
}

std::string Spectrum(const std::vector<Place>& places) {
  std::string text = Header("rank", places);
  std::vector<Eigen::VectorXf> columns;
  for (const Place& place : places) {
    columns.push_back(PrincipalSigmas(FirstLooks(place.real)));
    columns.push_back(PrincipalSigmas(FirstLooks(place.model)));
  }
  for (int rank = 0; rank < DescriptorModel::kDim; ++rank) {
    text += fmt::format("{}", rank);
    for (const Eigen::VectorXf& column : columns) {
      text += fmt::format(",{:.5f}", column[rank]);
    }
    text += "\n";
  }
  return text;
}

// Returns the median distance of the pairs that `is_in` accepts; empty if there are few.
std::string MedianDistance(const DescriptorMatrix& root, const std::vector<LookPair>& pairs,
                           const std::function<bool(const LookPair&)>& is_in) {
  std::vector<LookPair> taken;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(taken), is_in);
  return static_cast<int>(taken.size()) < kMinPairsOfPoint
             ? ""
             : fmt::format("{:.4f}", std::sqrt(ValueAtShare(SqDistances(root, taken), 0.5)));
}

// Returns median distances over bins of one kind of view difference, while the other kind is small.
std::string Growth(const char* first, const std::vector<Place>& places,
                   const std::vector<float>& edges,
                   const std::function<float(const LookPair&)>& difference,
                   const std::function<bool(const LookPair&)>& is_alike) {
  std::string text = Header(first, places);
  for (size_t bin = 1; bin < edges.size(); ++bin) {
    const auto is_in = [&](const LookPair& pair) {
      return is_alike(pair) && difference(pair) >= edges[bin - 1] && difference(pair) < edges[bin];
    };
    text += fmt::format("{:.3f}", 0.5f * (edges[bin - 1] + edges[bin]));
    for (const Place& place : places) {
      text += "," + MedianDistance(place.real.root, place.pairs, is_in) + "," +
              MedianDistance(place.model.root, place.pairs, is_in);
    }
    text += "\n";
  }
  return text;
}

// Returns columns of sorted distances at the same shares.
std::string Quantiles(const std::string& header, const std::vector<std::vector<float>>& columns) {
  std::string text = header;
  for (int percent = 1; percent < 100; ++percent) {
    text += fmt::format("{:.2f}", 0.01 * percent);
    for (const std::vector<float>& column : columns) {
      text += fmt::format(",{:.4f}", ValueAtShare(column, 0.01 * percent));
    }
    text += "\n";
  }
  return text;
}

std::string Nearest(const std::vector<Place>& places) {
  std::string header = "share";
  std::vector<std::vector<float>> columns;
  for (const Place& place : places) {
    for (const int others : {100, 1000, 2500}) {
      header += fmt::format(",{0} of {1},{0} model of {1}", place.name, others);
      columns.push_back(NearestDistances(FirstLooks(place.real), others, kPlotSeed));
      columns.push_back(NearestDistances(FirstLooks(place.model), others, kPlotSeed));
    }
  }
  return Quantiles(header + "\n", columns);
}

// Answers a matcher's question: is the same landmark nearer than the nearest of a thousand others?
std::string SameAndOther(const std::vector<Place>& places) {
  std::string header = "share";
  std::vector<std::vector<float>> columns;
  for (const Place& place : places) {
    for (const bool is_model : {false, true}) {
      const RealLooks& looks = is_model ? place.model : place.real;
      std::vector<float> same = SqDistances(looks.root, place.pairs);
      std::transform(same.begin(), same.end(), same.begin(),
                     [](float sq) { return std::sqrt(sq); });
      header += fmt::format(",{0}{1} same,{0}{1} other", place.name, is_model ? " model" : "");
      columns.push_back(same);
      columns.push_back(NearestDistances(FirstLooks(looks), 1000, kPlotSeed));
    }
  }
  return Quantiles(header + "\n", columns);
}

std::string Crowd(const DescriptorFitData& data, const DescriptorModel& model) {
  std::string text = "others,crowd,model\n";
  const DescriptorMatrix clutter = SimulateClutter(300'000, model);
  for (int others = 100; others <= clutter.rows(); others *= 2) {
    const auto median = [&](const DescriptorMatrix& root) {
      return others > root.rows()
                 ? std::string()
                 : fmt::format("{:.4f}",
                               ValueAtShare(NearestDistances(root, others, kPlotSeed), 0.5));
    };
    text += fmt::format("{},{},{}\n", others, median(data.crowd), median(clutter));
  }
  return text;
}

}  // namespace

void WriteDescriptorPlots(const DescriptorFitData& data, const DescriptorModelOptions& options,
                          const std::string& output_dir) {
  const DescriptorModel model(options);
  std::vector<Place> places;
  for (const DescriptorFitStreet& street : data.streets) {
    places.push_back(
        {street.name, street.looks, Simulate(street.looks, model), PairsOf(street.looks.looks)});
  }
  std::filesystem::create_directories(output_dir);
  WriteTextFile(output_dir + "/spectrum.csv", Spectrum(places));
  WriteTextFile(output_dir + "/nearest.csv", Nearest(places));
  WriteTextFile(output_dir + "/same_and_other.csv", SameAndOther(places));
  WriteTextFile(output_dir + "/crowd.csv", Crowd(data, model));
  if (data.facade.size() > 0) {
    places.push_back(
        {"facade", data.facade, Simulate(data.facade, model), PairsOf(data.facade.looks)});
  }
  WriteTextFile(output_dir + "/angle.csv",
                Growth(
                    "angle_rad", places,
                    {0.0f, 0.01f, 0.02f, 0.035f, 0.05f, 0.075f, 0.1f, 0.15f, 0.2f, 0.3f, 0.45f,
                     0.6f, 0.8f, 1.0f, 1.4f},
                    [](const LookPair& pair) { return pair.angle_rad; },
                    [](const LookPair& pair) { return pair.log2_scale < 0.3f; }));
  WriteTextFile(
      output_dir + "/scale.csv",
      Growth(
          "log2_scale", places, {0.0f, 0.1f, 0.2f, 0.3f, 0.45f, 0.6f, 0.8f, 1.0f, 1.5f, 2.5f},
          [](const LookPair& pair) { return pair.log2_scale; },
          [](const LookPair& pair) { return pair.angle_rad < 0.1f; }));
}

}  // namespace cairn
