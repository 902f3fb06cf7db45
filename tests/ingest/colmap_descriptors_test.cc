#include "ingest/colmap/colmap_descriptors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"
#include "ingest/colmap/colmap_ids.h"
#include "ingest/colmap/colmap_reader.h"
#include "ingest/colmap_fixture.h"
#include "storage/database/sqlite/connection.h"
#include "support/test_data.h"

namespace cairn {
namespace {

using testing::ErrorOf;
using ::testing::HasSubstr;
using testing::StreetReconstruction;

// What ReadColmap says of the database after `change` was made to it.
class ColmapDescriptors : public testing::ColmapTest {
 protected:
  std::string RefusalAfter(const std::string& change) {
    const ColmapInput input = Write(StreetReconstruction());
    sqlite::Connection(input.database_path, sqlite::Access::kReadWrite, 100).Execute(change);
    const auto [code, message] = ErrorOf([&] { ReadColmap(input); });
    EXPECT_EQ(code, ErrorCode::kBadInput) << message;
    EXPECT_THAT(message, HasSubstr("database.db"));
    return message;
  }
};

TEST_F(ColmapDescriptors, OfAnotherExtractorAreRefusedByItsName) {
  constexpr char kTypeColumn[] = "ALTER TABLE descriptors ADD COLUMN type INTEGER DEFAULT 0;";
  const auto refusal_of_type = [&](const char* type) {
    std::filesystem::remove(dir_.File("database.db"));
    return RefusalAfter(std::string(kTypeColumn) + "UPDATE descriptors SET type = " + type +
                        " WHERE image_id = 11");
  };
  EXPECT_THAT(refusal_of_type("1"), HasSubstr("0000.jpg are ALIKED_N16ROT"));
  EXPECT_THAT(refusal_of_type("2"), HasSubstr("ALIKED_N32"));
  EXPECT_THAT(refusal_of_type("77"), HasSubstr("type 77"));
}

TEST_F(ColmapDescriptors, OfTypeSiftAreReadAsWithoutTheColumn) {
  const Reconstruction written = StreetReconstruction();
  const ColmapInput input = Write(written);
  const DescriptorMatrix before = ReadColmap(input).images[0].features.descriptors.Unpacked();
  sqlite::Connection(input.database_path, sqlite::Access::kReadWrite, 100)
      .Execute("ALTER TABLE descriptors ADD COLUMN type INTEGER NOT NULL DEFAULT 0");
  EXPECT_EQ(ReadColmap(input).images[0].features.descriptors.Unpacked(), before);
}

// ALIKED's 128 floats a keypoint, as COLMAP 4 stores them (512 columns of bytes) and as scripts do
// (128 columns of four bytes).
TEST_F(ColmapDescriptors, OfFloatsAreRefusedAsSuch) {
  EXPECT_THAT(RefusalAfter("UPDATE descriptors SET cols = 512, data = zeroblob(512 * rows)"),
              HasSubstr("512 bytes per keypoint, probably floats of 128 dimensions"));
  std::filesystem::remove(dir_.File("database.db"));
  EXPECT_THAT(RefusalAfter("UPDATE descriptors SET data = zeroblob(512 * rows)"),
              HasSubstr("floats of 128 dimensions"));
}

TEST_F(ColmapDescriptors, OfAnotherDimensionAreRefused) {
  EXPECT_THAT(RefusalAfter("UPDATE descriptors SET cols = 64, data = zeroblob(64 * rows)"),
              HasSubstr("64 bytes per keypoint"));
}

TEST_F(ColmapDescriptors, ThatAreNoiseAreNotTakenForSift) {
  EXPECT_THAT(RefusalAfter("UPDATE descriptors SET data = randomblob(128 * rows)"),
              HasSubstr("not SIFT: their mean length is"));
}

TEST_F(ColmapDescriptors, WithL2NormalizationAreToldByTheirStatistics) {
  const Reconstruction written = StreetReconstruction();
  const ColmapInput input = Write(written);
  {
    sqlite::Connection database(input.database_path, sqlite::Access::kReadWrite, 100);
    for (size_t i = 0; i < written.images.size(); ++i) {
      // The builder's descriptors are whole numbers of length 512: what COLMAP stores with
      // --SiftExtraction.normalization L2.
      const DescriptorMatrix descriptors = written.images[i].features.descriptors.Unpacked();
      std::vector<uint8_t> bytes(descriptors.data(), descriptors.data() + descriptors.size());
      database.Prepare("UPDATE descriptors SET data = ? WHERE image_id = ?")
          .Bind(std::span<const uint8_t>(bytes), static_cast<int64_t>(kFirstColmapImageId + i))
          .Run();
    }
  }
  EXPECT_EQ(ReadColmap(input).images[3].features.descriptors.Unpacked(),
            written.images[3].features.descriptors.Unpacked());
}

// The same photos' descriptors by COLMAP, and as COLMAP would have stored them with the
// normalization L2.
TEST(SiftStatistics, TellTheNormalizationsOfRealPhotosApart) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund/database.db");
  sqlite::Connection database((testing::TestDataDir() / "street_lund/database.db").string(),
                              sqlite::Access::kImmutable, 100);
  sqlite::Statement statement = database.Prepare("SELECT data FROM descriptors");
  int num_images = 0;
  while (statement.Step()) {
    ++num_images;
    const std::vector<uint8_t> l1_root = statement.Blob(0);
    SiftStatistics statistics;
    statistics.Add(l1_root);
    EXPECT_EQ(statistics.Normalization(), SiftNormalization::kL1Root);

    std::vector<uint8_t> l2 = l1_root;
    for (size_t row = 0; row < l2.size(); row += kColmapDim) {
      Eigen::Map<Eigen::Array<uint8_t, kColmapDim, 1>> bytes(l2.data() + row);
      const Eigen::ArrayXd squares = bytes.cast<double>().square();
      bytes = (512.0 / squares.matrix().norm() * squares).round().min(255.0).cast<uint8_t>();
    }
    SiftStatistics of_l2;
    of_l2.Add(l2);
    EXPECT_EQ(of_l2.Normalization(), SiftNormalization::kL2);
  }
  EXPECT_GT(num_images, 20);
}

}  // namespace
}  // namespace cairn
