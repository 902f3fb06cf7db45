// Tests that an operation on maps leaves whole versions, whatever happens while it runs.
#ifndef CAIRN_TESTS_SUPPORT_WHOLE_VERSIONS_H_
#define CAIRN_TESTS_SUPPORT_WHOLE_VERSIONS_H_

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace cairn::testing {

// An operation that reads and writes maps in the working folder that it is given. `maps` are the
// names of the maps that it needs or makes.
struct MapOperation {
  std::vector<std::string> maps;
  std::function<void(const std::filesystem::path& folder)> prepare;
  std::function<void(const std::filesystem::path& folder)> run;
};

// Each of these runs the operation `count` times in a child process and disturbs it at a random
// write. Afterwards each map is as before or as after the operation, or is not there as before; it
// is sound; the operation can be run again if it had not happened; and no other file is left.

// The process is killed.
void ExpectWholeVersionsAfterKills(const MapOperation& operation, int count);
// The disk is full from this write on.
void ExpectWholeVersionsOnFullDisks(const MapOperation& operation, int count);
// The maps and their logs are copied at this moment; the copies are looked at.
void ExpectWholeVersionsInCopies(const MapOperation& operation, int count);

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_WHOLE_VERSIONS_H_
