#include "core/descriptor_file.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "core/packed_features.h"
#include "core/random.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

ByteDescriptorMatrix RandomBytes(Eigen::Index rows, uint64_t seed) {
  ByteDescriptorMatrix bytes(rows, 128);
  for (Eigen::Index i = 0; i < bytes.size(); ++i) {
    bytes.data()[i] = static_cast<uint8_t>(HashWord(seed + static_cast<uint64_t>(i)));
  }
  return bytes;
}

TEST(DescriptorFile, GivesBackTheDescriptorsOfMorePhotosThanItsCacheHolds) {
  const testing::TempDir dir;
  std::vector<StoredDescriptors> kept;
  {
    const auto file = DescriptorFile::Create(dir.path());
    for (uint64_t i = 0; i < 90; ++i) {  // 92 MB.
      kept.push_back(file->Append(RandomBytes(8000, i)));
    }
  }
  for (const uint64_t i : {0, 89, 0, 40}) {
    const ByteDescriptorMatrix bytes = RandomBytes(8000, i);
    EXPECT_EQ(kept[i].rows(), 8000);
    EXPECT_EQ(kept[i].cols(), 128);
    EXPECT_TRUE(*kept[i].Load() == bytes);
    EXPECT_TRUE(kept[i].Row(7999) == bytes.row(7999));
  }
}

TEST(DescriptorFile, BoundsAndEmptiesItsCache) {
  const testing::TempDir dir;
  const auto file = DescriptorFile::Create(dir.path());
  for (uint64_t i = 0; i < 90; ++i) {
    file->Append(RandomBytes(8000, i)).Load();
    EXPECT_LE(file->CachedBytes(), size_t{64} << 20);
  }
  EXPECT_GT(file->CachedBytes(), size_t{60} << 20);
  const ByteDescriptorMatrix bytes = RandomBytes(10, 1);
  const StoredDescriptors kept = file->Append(bytes);
  const auto loaded = kept.Load();
  file->EmptyCache();
  EXPECT_EQ(file->CachedBytes(), 0u);
  EXPECT_TRUE(*loaded == bytes);
  EXPECT_TRUE(*kept.Load() == bytes);
}

TEST(DescriptorFile, KeepsDescriptorsOfPhotosWithoutFeatures) {
  const testing::TempDir dir;
  const auto file = DescriptorFile::Create(dir.path());
  const StoredDescriptors none = file->Append(ByteDescriptorMatrix(0, 128));
  const StoredDescriptors some = file->Append(RandomBytes(3, 1));
  EXPECT_EQ(none.Load()->rows(), 0);
  EXPECT_EQ(none.Load()->cols(), 128);
  EXPECT_EQ(some.Load()->rows(), 3);
}

TEST(DescriptorFile, PackedDescriptorsAreThoseInMemory) {
  const testing::TempDir dir;
  const ByteDescriptorMatrix bytes = RandomBytes(20, 5);
  const PackedDescriptors in_memory(bytes);
  const PackedDescriptors on_disk(DescriptorFile::Create(dir.path())->Append(bytes));
  ASSERT_NE(on_disk.as_bytes(), nullptr);
  EXPECT_TRUE(*on_disk.as_bytes()->Load() == bytes);
  EXPECT_EQ(on_disk.rows(), 20);
  EXPECT_EQ(on_disk.Row(3), in_memory.Row(3));
  EXPECT_EQ(on_disk.Unpacked(), in_memory.Unpacked());
  const std::vector<int> rows = {4, 0, 19};
  EXPECT_EQ(on_disk.Rows(rows).Unpacked(), in_memory.Rows(rows).Unpacked());
}

}  // namespace
}  // namespace cairn
