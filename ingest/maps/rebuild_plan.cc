#include "ingest/maps/rebuild_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

void RequireFinished(const ArchiveFolder& archive) {
  if (!archive.unfinished().empty()) {
    throw Error(ErrorCode::kConflict,
                fmt::format("{}: an ingest did not finish this file; run the ingest again, or any "
                            "other ingest of the map with --archive",
                            archive.unfinished().front()));
  }
}

// Sessions of the archive by name.
std::map<std::string, const ArchiveFile*> FilesByName(const ArchiveFolder& archive) {
  std::map<std::string, const ArchiveFile*> files;
  for (const ArchiveFile& file : archive.files()) {
    const auto [known, is_new] = files.emplace(file.manifest.session.name, &file);
    if (!is_new) {
      throw Error(ErrorCode::kConflict,
                  fmt::format("{} and {} are both of session '{}'; delete the one that the map "
                              "does not have",
                              known->second->path, file.path, Excerpt(known->first)));
    }
  }
  return files;
}

void RequireNothingMissing(const ArchiveFolder& archive, const ArchiveFile& file,
                           const std::map<std::string, const ArchiveFile*>& by_name,
                           const std::set<std::string>& without) {
  for (const SessionKey& earlier : file.manifest.earlier_sessions) {
    if (!by_name.contains(earlier.name) && !without.contains(earlier.name)) {
      throw Error(
          ErrorCode::kNotFound,
          fmt::format("{}: lacks session '{}', which the map had when '{}' was ingested; leave it "
                      "out with --without, or make a complete archive (docs/versions.md)",
                      archive.path(), Excerpt(earlier.name), Excerpt(file.manifest.session.name)));
    }
  }
}

void RequireSameDescriptors(const ArchiveFile& first, const ArchiveFile& file) {
  if (first.manifest.descriptor_type != file.manifest.descriptor_type ||
      first.manifest.descriptor_dim != file.manifest.descriptor_dim) {
    throw Error(ErrorCode::kConflict,
                fmt::format("{} has {}-D descriptors of type '{}', {} has {}-D ones of type '{}'; "
                            "they are not of one map",
                            first.path, first.manifest.descriptor_dim,
                            Excerpt(first.manifest.descriptor_type), file.path,
                            file.manifest.descriptor_dim, Excerpt(file.manifest.descriptor_type)));
  }
}

// True if a session is in the archive, or was in the map when one of the archive was ingested.
bool IsKnown(const std::string& name, const ArchiveFolder& archive) {
  return std::ranges::any_of(archive.files(), [&](const ArchiveFile& file) {
    return file.manifest.session.name == name ||
           std::ranges::count(file.manifest.earlier_sessions, name, &SessionKey::name) > 0;
  });
}

}  // namespace

std::vector<ArchiveFile> PlanRebuild(const ArchiveFolder& archive,
                                     const std::vector<std::string>& without) {
  RequireFinished(archive);
  const std::map<std::string, const ArchiveFile*> by_name = FilesByName(archive);
  for (const std::string& name : without) {
    if (!IsKnown(name, archive)) {
      throw Error(ErrorCode::kNotFound,
                  fmt::format("{}: has no session '{}'", archive.path(), Excerpt(name)));
    }
  }
  const std::set<std::string> left_out(without.begin(), without.end());
  std::vector<ArchiveFile> plan;
  for (const ArchiveFile& file : archive.files()) {
    if (!left_out.contains(file.manifest.session.name)) {
      RequireNothingMissing(archive, file, by_name, left_out);
      plan.push_back(file);
      RequireSameDescriptors(plan.front(), file);
    }
  }
  if (plan.empty()) {
    throw Error(ErrorCode::kBadInput, archive.path() + ": has no session to make a map of");
  }
  return plan;
}

}  // namespace cairn
