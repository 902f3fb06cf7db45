#include "http/wire/multipart.h"

#include <gtest/gtest.h>

#include "http/wire/problem.h"

namespace cairn {
namespace {

constexpr char kType[] = "multipart/form-data; boundary=XX";

std::string Part(const std::string& name, const std::string& content) {
  return "--XX\r\nContent-Disposition: form-data; name=\"" + name + "\"\r\n\r\n" + content + "\r\n";
}

bool IsRefused(std::string_view type, std::string_view body) {
  try {
    ParseMultipart(type, body);
  } catch (const HttpError& e) {
    return e.problem() == ProblemCode::kInvalidMultipart;
  }
  return false;
}

TEST(Multipart, SplitsPartsAndKeepsTheirBytes) {
  const std::string binary("\0\r\n--XY\r\n\xff--", 12);
  const std::string body = Part("request", "{}") + Part("image", binary) + "--XX--\r\n";
  const std::vector<MultipartPart> parts = ParseMultipart(kType, body);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].name, "request");
  EXPECT_EQ(parts[0].content, "{}");
  EXPECT_EQ(parts[1].name, "image");
  EXPECT_EQ(parts[1].content, binary);
}

TEST(Multipart, ReadsHeadersAsBrowsersAndCurlWriteThem) {
  const std::string body =
      "--XX\r\nContent-Type: image/jpeg\r\ncontent-disposition: form-data; "
      "filename=\"a;name=b.jpg\"; name=image\r\n\r\nbytes\r\n--XX--\r\n";
  const std::vector<MultipartPart> parts =
      ParseMultipart("Multipart/Form-Data; charset=utf-8; boundary=\"XX\"", body);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].name, "image");
  EXPECT_EQ(parts[0].content, "bytes");
}

TEST(Multipart, RefusesBrokenFraming) {
  EXPECT_TRUE(IsRefused("multipart/form-data", Part("a", "b") + "--XX--"));
  EXPECT_TRUE(IsRefused("multipart/form-data; boundary=", Part("a", "b") + "--XX--"));
  EXPECT_TRUE(IsRefused(kType, ""));
  EXPECT_TRUE(IsRefused(kType, "preamble" + Part("a", "b") + "--XX--"));
  EXPECT_TRUE(IsRefused(kType, Part("a", "b")));  // No closing boundary.
  EXPECT_TRUE(IsRefused(kType, Part("", "b") + "--XX--"));
  EXPECT_TRUE(IsRefused(kType, Part("a", "b") + Part("a", "c") + "--XX--"));
  EXPECT_TRUE(IsRefused(kType, "--XX\r\nno end of headers\r\n--XX--"));
  EXPECT_TRUE(IsRefused(kType, "--XX\r\n\r\nno headers\r\n--XX--"));
  EXPECT_TRUE(IsRefused(kType, "--XXgarbage\r\n--XX--"));
}

TEST(Multipart, RefusesEveryTruncationBeforeTheLastBoundary) {
  const std::string body = Part("request", "{}") + Part("image", "123") + "--XX--";
  for (size_t size = 0; size < body.size(); ++size) {
    EXPECT_TRUE(IsRefused(kType, std::string_view(body).substr(0, size))) << size;
  }
}

TEST(Multipart, RefusesMoreThanSixteenParts) {
  std::string body;
  for (int i = 0; i < 17; ++i) {
    body += Part("p" + std::to_string(i), "x");
  }
  EXPECT_TRUE(IsRefused(kType, body + "--XX--"));
}

TEST(Multipart, OnlyFormDataIsMultipart) {
  EXPECT_TRUE(IsMultipart("multipart/form-data; boundary=a"));
  EXPECT_FALSE(IsMultipart("multipart/mixed; boundary=a"));
  EXPECT_FALSE(IsMultipart("application/json"));
  EXPECT_FALSE(IsMultipart(""));
}

}  // namespace
}  // namespace cairn
