#include "core/wire/base64.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

namespace cairn {
namespace {

std::vector<uint8_t> Bytes(std::string_view text) { return {text.begin(), text.end()}; }

TEST(Base64, AgreesWithRfc4648) {
  const std::pair<const char*, const char*> examples[] = {{"", ""},
                                                          {"f", "Zg=="},
                                                          {"fo", "Zm8="},
                                                          {"foo", "Zm9v"},
                                                          {"foob", "Zm9vYg=="},
                                                          {"fooba", "Zm9vYmE="},
                                                          {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, encoded] : examples) {
    EXPECT_EQ(EncodeBase64(Bytes(plain)), encoded);
    EXPECT_EQ(DecodeBase64(encoded), Bytes(plain)) << encoded;
  }
}

TEST(Base64, RoundTripsRandomBytesOfAllLengths) {
  std::mt19937 rng(1);
  for (size_t size = 0; size < 200; ++size) {
    std::vector<uint8_t> bytes(size);
    for (uint8_t& byte : bytes) {
      byte = static_cast<uint8_t>(rng());
    }
    EXPECT_EQ(DecodeBase64(EncodeBase64(bytes)), bytes);
  }
}

TEST(Base64, RefusesWhatIsNotCanonical) {
  for (const char* text : {"Z", "Zg", "Zg=", "Zg===", "====", "=", "Z===", "Zh==", "Zm9=", "Zm9v\n",
                           "Zm 9v", "Zm-_", "Zg==Zg==", "Zm9v====", "\xff\xff\xff\xff"}) {
    EXPECT_EQ(DecodeBase64(text), std::nullopt) << text;
  }
}

TEST(Base64, ReadsWhatEncodersOfClientsWrite) {
  for (const char* text :
       {"Zm9vYg==", "Zm9v\nYg==\n", "Zm9v\r\nYg==\r\n", "Zm9v Yg==", "Zm9vYg", "Zm9v\nYg\n"}) {
    EXPECT_EQ(DecodeBase64OfClient(text), Bytes("foob")) << text;
  }
  for (const char* text : {"Zm9vYh==", "Zm9vY", "Zm9vYg=", "Zm9-", "=", "Zm9v\v", "Yg==Yg=="}) {
    EXPECT_EQ(DecodeBase64OfClient(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace cairn
