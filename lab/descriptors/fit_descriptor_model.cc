// Fits the descriptor model to real data and prints the resulting options:
//   cairn_fit_descriptor_model DATA_DIR OUTPUT_DIR
// DATA_DIR holds kitti_vo_2x51, street_lund, sacre_coeur10 and ann_bigann10k. Data sets that are
// missing are left out; the rendered street is always used. OUTPUT_DIR receives a CSV file for each
// plot.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/features/sift/sift_extractor.h"
#include "ingest/colmap/colmap_reader.h"
#include "lab/descriptors/descriptor_fit.h"
#include "lab/descriptors/descriptor_plots.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

void AddStreet(const std::string& name, const fs::path& model_dir, const fs::path& database,
               DescriptorFitData* data) {
  if (fs::exists(model_dir) && fs::exists(database)) {
    data->streets.push_back(
        {name, LooksAtReconstruction(ReadColmap({model_dir.string(), database.string(), {}}))});
  }
}

RealLooks ReadFacade(const fs::path& photo_dir) {
  std::vector<std::string> paths;
  if (fs::exists(photo_dir)) {
    for (const auto& entry : fs::directory_iterator(photo_dir)) {
      paths.push_back(entry.path().string());
    }
  }
  std::sort(paths.begin(), paths.end());
  std::vector<GrayImage> photos;
  for (const std::string& path : paths) {
    photos.push_back(ReadGrayImage(path));
  }
  return LooksAtFacade(photos);
}

// The file holds the number and the dimension as int32, then bytes.
DescriptorMatrix ReadCrowd(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  int32_t shape[2] = {};
  file.read(reinterpret_cast<char*>(shape), sizeof(shape));
  if (!file) {
    return {};
  }
  Eigen::Matrix<uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> bytes(shape[0], shape[1]);
  file.read(reinterpret_cast<char*>(bytes.data()), bytes.size());
  DescriptorMatrix root = bytes.cast<float>();
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &root);
  return root;
}

DescriptorFitData ReadFitData(const fs::path& dir) {
  DescriptorFitData data;
  const fs::path kitti = dir / "kitti_vo_2x51", lund = dir / "street_lund";
  AddStreet("kitti", kitti / "colmap_model_seq1", kitti / "database_seq1.db", &data);
  AddStreet("lund", lund / "colmap_model", lund / "database.db", &data);
  data.streets.push_back({"rendered", LooksAtStreet({}), true});
  data.repeats = RepeatsOnStreet({});
  data.facade = ReadFacade(dir / "sacre_coeur10/datasets/sacre_coeur/mapping");
  data.crowd = ReadCrowd(dir / "ann_bigann10k/base10k.u8bin");
  return data;
}

void PrintOptions(const DescriptorModelOptions& options) {
  for (const DescriptorAxis& axis : options.axes) {
    fmt::print("{{{}, {:.4f}f, {:.3f}f}},\n", axis.rank, axis.between, axis.within);
  }
  const auto print = [](const char* field, double value) {
    fmt::print("{} = {:.3f}\n", field, value);
  };
  print("cluster_share", options.cluster_share);
  print("log_cluster_spread", options.log_cluster_spread);
  print("log_landmark_spread", options.log_landmark_spread);
  print("noise_length", options.noise_length);
  print("view_length", options.view_length);
  print("mode_length", options.mode_length);
  print("instance_length", options.instance_length);
  print("view_angle_scale_rad", options.view_angle_scale_rad);
  print("view_log2_scale", options.view_log2_scale);
  print("log_look_spread", options.log_look_spread);
  print("log_stability_spread", options.log_stability_spread);
}

int Run(const fs::path& data_dir, const fs::path& output_dir) {
  const DescriptorFitData data = ReadFitData(data_dir);
  const DescriptorModelOptions options =
      FitDescriptorModel(data, {}, [](const std::string& what) { fmt::print("{}\n", what); });
  PrintOptions(options);
  for (const auto& list : {WithinResiduals(data, options), BetweenResiduals(data, options)}) {
    for (const DescriptorResidual& residual : list) {
      fmt::print("{:+.3f} {}\n", residual.value, residual.name);
    }
  }
  WriteDescriptorPlots(data, options, output_dir.string());
  return 0;
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: {} DATA_DIR OUTPUT_DIR\n", argv[0]);
    return 2;
  }
  try {
    return cairn::Run(argv[1], argv[2]);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
