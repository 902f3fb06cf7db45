#include "system/real_drive.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <utility>

#include "core/error.h"
#include "core/features/sift/sift_extractor.h"
#include "eval/reference_alignment.h"
#include "ingest/colmap/colmap_reader.h"
#include "support/test_data.h"

namespace cairn::testing {
namespace {

std::vector<uint8_t> ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Splits the model's image names into those that make the map and those that query it.
std::pair<std::vector<std::string>, std::vector<std::string>> Split(const Reconstruction& full,
                                                                    const RealDriveInput& input) {
  std::pair<std::vector<std::string>, std::vector<std::string>> names;
  for (const ReconImage& image : full.images) {
    if (!input.is_left_out || !input.is_left_out(image.name)) {
      (input.is_query(image.name) ? names.second : names.first).push_back(image.name);
    }
  }
  return names;
}

}  // namespace

RealDriveInput LundInput() {
  const std::filesystem::path root = TestDataDir() / "street_lund";
  return {.model_dir = root / "colmap_model",
          .database_path = root / "database.db",
          .image_dir = root / "images",
          .positions = [](const Reconstruction& full) { return GpsPositions(full, 5.0); },
          .georegister = {},
          .is_query = {},
          .is_left_out = {}};
}

RealDriveInput KittiInput() {
  const std::filesystem::path root = TestDataDir() / "kitti_vo_2x51";
  const std::string positions_path = root / "georef_seq1.csv";
  return {.model_dir = root / "colmap_model_seq1",
          .database_path = root / "database_seq1.db",
          .image_dir = root / "KITTI_sequence_1" / "image_l",
          .positions = [positions_path](
                           const Reconstruction&) { return ReadCameraPositions(positions_path); },
          .georegister = {},
          .is_query = {},
          .is_left_out = {}};
}

RealDriveInput HerzJesusInput() {
  const std::filesystem::path root = TestDataDir() / "facades_strecha" / "colmap_Herz-Jesus-both";
  const std::string positions_path = root / "georef.csv";
  return {.model_dir = root,
          .database_path = root / "database.db",
          .image_dir = {},
          .positions = [positions_path](
                           const Reconstruction&) { return ReadCameraPositions(positions_path); },
          .georegister = {},
          .is_query = {},
          .is_left_out = {}};
}

RealDrive::RealDrive(const RealDriveInput& input) {
  ColmapInput colmap{input.model_dir.string(), input.database_path.string(), {}};
  const Reconstruction full = ReadColmap(colmap);
  const auto [map_names, query_names] = Split(full, input);

  colmap.image_names = map_names;
  const Reconstruction mapped = ReadColmap(colmap);
  georegistration_ = Georegister(mapped, input.positions(mapped), input.georegister);
  auto store = std::make_shared<MapStore>(MapStore::Create(dir_.File("map.gpkg")));
  IngestOptions options;
  options.session_name = "drive";
  ingest_report_ =
      IngestSession(mapped, georegistration_.ecef_from_world, options, store.get(), {});

  const auto alignment =
      AlignToKeyframes(full, store->Snapshot().KeyframesOfSession(ingest_report_.session_id));
  if (!alignment) {
    throw Error(ErrorCode::kInternal, "the map shares no images with its own model");
  }
  const Sim3d ecef_from_full = alignment->ecef_from_world;
  for (EvalQuery& query :
       QueriesFromReconstruction(full, ecef_from_full, input.image_dir.string())) {
    if (input.is_query(query.name)) {
      queries_.push_back(std::move(query));
    }
  }
  AddNoisyPriors(PriorNoiseOptions{}, &queries_);

  localizer_ = std::make_unique<Localizer>(store, LocalizerOptions{}, size_t{1} << 28);
  ServerOptions server_options;
  server_options.map_path = store->path();
  server_options.port = 0;
  server_options.default_timeout_ms = 60'000;  // Sanitizers are slow.
  server_options.max_features = 10'000;
  server_options.max_body_bytes = size_t{8} << 20;  // 7,300 raw descriptors, sent without loss.
  server_ = std::make_unique<Server>(server_options);
  server_->Start();
  ClientOptions client_options;
  client_options.url = fmt::format("http://127.0.0.1:{}", server_->port());
  client_options.timeout_ms = 120'000;
  client_ = std::make_unique<LocalizeClient>(client_options);
}

RealDrive::~RealDrive() = default;

EvalReport RealDrive::Run(QueryRoute route, const StatedFocalOptions& focal) {
  std::vector<EvalQuery> queries = queries_;
  StateFocalLengths(focal, &queries);
  return Evaluate(queries, [&](const EvalQuery& query) { return LocalizeBy(route, query); }, {});
}

LocalizeResult RealDrive::LocalizeBy(QueryRoute route, const EvalQuery& query) {
  switch (route) {
    case QueryRoute::kInProcessFeatures:
      return localizer_->Localize(query.query);
    case QueryRoute::kServerFeatures:
      return client_->LocalizeFeatures(query.query);
    case QueryRoute::kInProcessImage: {
      LocalizeQuery with_own_features = query.query;
      with_own_features.features = ExtractSift(ReadGrayImage(query.image_path));
      return localizer_->Localize(with_own_features);
    }
    case QueryRoute::kServerImage:
      return client_->LocalizeImages(query.query, {ReadFile(query.image_path)});
  }
  throw Error(ErrorCode::kInternal, "no such route");
}

double PositionDifferenceM(const LocalizeResult& a, const LocalizeResult& b) {
  return (a.cam_from_ecef.Inverse().translation - b.cam_from_ecef.Inverse().translation).norm();
}

double RotationDifferenceRad(const LocalizeResult& a, const LocalizeResult& b) {
  return RotationAngleRad(a.cam_from_ecef.rotation, b.cam_from_ecef.rotation);
}

}  // namespace cairn::testing
