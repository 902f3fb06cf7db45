// Models and databases of COLMAP in a temporary folder, which the tests of a reader share.
#ifndef CAIRN_TESTS_INGEST_COLMAP_FIXTURE_H_
#define CAIRN_TESTS_INGEST_COLMAP_FIXTURE_H_

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>

#include "core/error.h"
#include "ingest/colmap/colmap_reader.h"
#include "ingest/colmap/write_colmap.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {

inline Reconstruction StreetReconstruction() {
  StreetWorldOptions options;
  options.length_m = 15.0;
  options.num_landmarks = 200;
  return StreetWorld(options).Reconstruct();
}

// The code and message of the Error that `action` throws.
inline std::pair<ErrorCode, std::string> ErrorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return {e.code(), e.what()};
  }
  return {ErrorCode::kInternal, "no error"};
}

class ColmapTest : public ::testing::Test {
 protected:
  ColmapInput Write(const Reconstruction& reconstruction, bool binary = true,
                    const ColmapDatabaseOptions& options = {}) {
    WriteColmapModel(reconstruction, dir_.path().string(),
                     binary ? ColmapModelFormat::kBinary : ColmapModelFormat::kText);
    WriteColmapDatabase(reconstruction, dir_.File("database.db"), options);
    return {dir_.path().string(), dir_.File("database.db"), {}};
  }

  TempDir dir_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_INGEST_COLMAP_FIXTURE_H_
