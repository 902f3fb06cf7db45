// Tests images in multipart bodies whose bytes are text.
#include "http/json/part_encoding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/wire/base64.h"
#include "core/wire/problem.h"
#include "http/json/localize_request.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

const std::vector<uint8_t> kPng = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 1, 2};

LocalizeRequest Parse(const std::string& image, const std::string& header) {
  const std::string body =
      "--B\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n"
      R"({"camera":{"size":[640,480]}})"
      "\r\n--B\r\nContent-Disposition: form-data; name=\"image\"\r\n" +
      header + "\r\n" + image + "\r\n--B--\r\n";
  return ParseLocalizeRequest("multipart/form-data; boundary=B", body, RequestLimits{});
}

// "code: detail (hint)"
std::string RefusalOf(const std::string& image, const std::string& header = "") {
  try {
    Parse(image, header);
    return "accepted";
  } catch (const HttpError& error) {
    return std::string(InfoOf(error.problem()).name) + ": " + ProblemJson(error, "");
  }
}

TEST(PartEncoding, AnImageThatSaysItIsBase64IsDecoded) {
  const std::string text = EncodeBase64(kPng);
  for (const std::string& sent : {text, text.substr(0, 8) + "\r\n" + text.substr(8) + "\r\n"}) {
    const LocalizeRequest request = Parse(sent, "Content-Transfer-Encoding: BASE64\r\n");
    ASSERT_EQ(request.images.size(), 1u);
    EXPECT_EQ(request.images[0].bytes, kPng);
  }
  const std::string raw(kPng.begin(), kPng.end());
  EXPECT_EQ(Parse(raw, "Content-Transfer-Encoding: binary\r\n").images[0].bytes, kPng);
  EXPECT_THAT(RefusalOf(raw, "Content-Transfer-Encoding: base64\r\n"), HasSubstr("is not base64"));
}

TEST(PartEncoding, AnImageThatIsTextIsToldSo) {
  const std::string text = EncodeBase64(kPng);
  EXPECT_THAT(RefusalOf(text), HasSubstr("is base64 text"));
  EXPECT_THAT(RefusalOf("/9j/4AAQSkZJRg=="), HasSubstr("send the raw bytes"));
  EXPECT_THAT(RefusalOf("data:image/png;base64," + text), HasSubstr("is a data: URL"));
}

TEST(PartEncoding, TextIsDecodedInTheTurnOfTheRequest) {
  const std::string body =
      "--B\r\nContent-Disposition: form-data; name=\"image\"\r\n"
      "Content-Transfer-Encoding: base64\r\n\r\n" +
      std::string(1 << 20, 'A') + "\r\n--B--\r\n";
  EXPECT_TRUE(TakesLongToParse("multipart/form-data; boundary=B", body));
}

}  // namespace
}  // namespace cairn
