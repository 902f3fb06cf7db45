#include "ingest/maps/plan_folder.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/replace_file.h"
#include "core/shared_folder.h"
#include "ingest/maps/built_tile_codec.h"
#include "ingest/maps/shard_codec.h"
#include "storage/tile/content_digest.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr const char* kManifest = "plan.json";
constexpr const char* kCodebook = "codebook.bin";
constexpr const char* kShards = "shards";
constexpr const char* kResults = "results";

constexpr uint64_t kMaxPlanBytes = uint64_t{256} << 20;
constexpr uint64_t kMaxFileBytes = uint64_t{16} << 30;

std::string Join(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

std::span<const uint8_t> BytesOf(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

void MakeFolder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) {
    throw Error(ErrorCode::kIo, fmt::format("{}: {}", path, error.message()));
  }
}

void RemoveFile(const fs::path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error) {
    throw Error(ErrorCode::kIo, fmt::format("{}: {}", path.string(), error.message()));
  }
}

std::vector<fs::path> FilesIn(const std::string& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    files.push_back(entry.path());
  }
  if (error && error != std::errc::no_such_file_or_directory) {
    throw Error(ErrorCode::kIo, fmt::format("{}: {}", folder, error.message()));
  }
  return files;
}

bool IsOfAnUnfinishedPlan(const std::string& name) {
  static const std::set<std::string> kNames = {kCodebook, kShards, kResults};
  return kNames.contains(name) || name.ends_with(kUnfinishedSuffix);
}

// Shards and results are files in these folders. Nothing outside of the plan is read or removed.
void RequireFolders(const std::string& path) {
  RequireUnlinkedFolder(Join(path, kShards));
  RequireUnlinkedFolder(Join(path, kResults));
}

// Reads a file whose digest the manifest names.
std::vector<uint8_t> ReadNamed(const std::string& path, const std::string& digest) {
  if (!fs::exists(path)) {
    throw Error(ErrorCode::kBadInput, path + ": is missing; plan again");
  }
  RequireUnlinkedFile(path);
  std::vector<uint8_t> bytes = ReadFileBytes(path, kMaxFileBytes);
  if (ContentDigest(bytes) != digest) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: is damaged; it is not the file that {} names. Plan again", path,
                            kManifest));
  }
  return bytes;
}

}  // namespace

void PreparePlanFolder(const std::string& path) {
  if (fs::exists(Join(path, kManifest))) {
    throw Error(
        ErrorCode::kConflict,
        fmt::format("{}: holds a plan; publish it, remove the folder or choose another", path));
  }
  const std::vector<fs::path> files = FilesIn(path);
  for (const fs::path& file : files) {
    if (!IsOfAnUnfinishedPlan(file.filename().string())) {
      throw Error(ErrorCode::kConflict,
                  fmt::format("{}: holds {}, which is of no plan; choose a folder of its own", path,
                              file.filename().string()));
    }
  }
  for (const fs::path& file : files) {
    RemoveFile(file);
  }
  MakeFolder(Join(path, kShards));
  MakeFolder(Join(path, kResults));
  RequireFolders(path);
}

void WritePlan(const PlannedSession& planned, const std::string& map_path, const std::string& path,
               const IngestProgress& progress) {
  PlanManifest manifest;
  manifest.plan = planned.plan;
  manifest.map_path = map_path;
  const int64_t num_tiles = std::ssize(planned.plan.tiles);
  for (int64_t i = 0; i < num_tiles; ++i) {
    ReportProgress(progress, "shards", i, num_tiles);
    const TileShard shard = planned.Shard(static_cast<size_t>(i));
    const std::vector<uint8_t> bytes = EncodeShard(shard);
    manifest.shard_digests.push_back(ContentDigest(bytes));
    ReplaceFile(Join(path, fmt::format("{}/{}", kShards, shard.tile_id.ToString())), bytes);
  }
  if (!planned.plan.is_unchanged) {
    const std::vector<uint8_t> codebook = EncodeCodebook(*planned.plan.codebook);
    manifest.codebook_digest = ContentDigest(codebook);
    ReplaceFile(Join(path, kCodebook), codebook);
  }
  ReplaceFile(Join(path, kManifest), BytesOf(ManifestAsJson(manifest)));
  ReportProgress(progress, "shards", num_tiles, num_tiles);
}

PlanFolder::PlanFolder(const std::string& path) : path_(path) {
  const std::string manifest_path = Join(path, kManifest);
  if (!fs::exists(manifest_path)) {
    throw Error(ErrorCode::kNotFound, path + ": holds no plan; run `cairn plan` to its end first");
  }
  RequireUnlinkedFile(manifest_path);
  RequireFolders(path);
  const std::string text = ReadTextFile(manifest_path, kMaxPlanBytes);
  try {
    manifest_ = ManifestFromJson(text);
  } catch (const Error& error) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: {}", manifest_path, error.what()));
  }
  digest_ = ContentDigest(BytesOf(text));
}

void PlanFolder::LoadCodebook() {
  const std::string codebook_path = Join(path_, kCodebook);
  const std::vector<uint8_t> bytes = ReadNamed(codebook_path, manifest_.codebook_digest);
  try {
    manifest_.plan.codebook = std::make_shared<const Codebook>(
        DecodeCodebook(bytes.data(), bytes.size(), plan().codebook->id));
  } catch (const Error& error) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: {}", codebook_path, error.what()));
  }
}

TileShard PlanFolder::LoadShard(size_t tile_idx) const {
  const std::string shard_path = ShardPath(tile_idx);
  const std::vector<uint8_t> bytes = ReadNamed(shard_path, manifest_.shard_digests[tile_idx]);
  TileShard shard;
  try {
    shard = DecodeShard(bytes);
  } catch (const Error& error) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: {}", shard_path, error.what()));
  }
  if (shard.tile_id != plan().tiles[tile_idx].tile_id) {
    throw Error(ErrorCode::kBadInput, shard_path + ": is of another tile; plan again");
  }
  return shard;
}

void PlanFolder::StoreResult(size_t tile_idx, const BuiltTile& built) const {
  ReplaceFile(ResultPath(tile_idx), EncodeBuiltTile(built, digest_));
}

std::optional<BuiltTile> PlanFolder::LoadResult(size_t tile_idx) const {
  if (!HasResult(tile_idx)) {
    return std::nullopt;
  }
  try {
    RequireUnlinkedFile(ResultPath(tile_idx));
    return DecodeBuiltTile(ReadFileBytes(ResultPath(tile_idx), kMaxFileBytes), digest_,
                           plan().tiles[tile_idx].tile_id, plan().session.id);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kIo) {
      throw;
    }
    return std::nullopt;
  }
}

bool PlanFolder::HasResult(size_t tile_idx) const {
  std::error_code ignored;
  return fs::exists(ResultPath(tile_idx), ignored);
}

void PlanFolder::RemoveContent() const {
  for (const char* name : {kShards, kResults, kCodebook}) {
    RemoveFile(fs::path(path_) / name);
  }
}

std::string PlanFolder::ShardPath(size_t tile_idx) const {
  return Join(path_, fmt::format("{}/{}", kShards, plan().tiles[tile_idx].tile_id.ToString()));
}

std::string PlanFolder::ResultPath(size_t tile_idx) const {
  return Join(path_, fmt::format("{}/{}", kResults, plan().tiles[tile_idx].tile_id.ToString()));
}

void PlanFolder::RemoveUnfinished() const {
  const std::vector<fs::path> files = FilesIn(Join(path_, kResults));
  std::set<std::string> results;
  for (const fs::path& file : files) {
    results.insert(file.filename().string());
  }
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    if (name.ends_with(kUnfinishedSuffix) && results.contains(name.substr(0, name.find('.')))) {
      std::error_code another_task_was_faster;
      fs::remove(file, another_task_was_faster);
    }
  }
}

}  // namespace cairn
