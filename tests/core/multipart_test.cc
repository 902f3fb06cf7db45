#include "core/wire/multipart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/wire/problem.h"

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

// RFC 9110 section 5.6.4: a backslash escapes a quote, and what stands in quotes is no parameter.
TEST(Multipart, ReadsQuotedFileNames) {
  for (const char* file_name : {R"("12\" wall; name=old.jpg")", R"("a\\")", R"("\"; name=\"x")",
                                R"("12%22; name=old.jpg")", R"("C:\photos\a.jpg")", "\"\""}) {
    const std::string body = std::string("--XX\r\nContent-Disposition: form-data; filename=") +
                             file_name + "; name=\"image\"\r\n\r\nbytes\r\n--XX--\r\n";
    const std::vector<MultipartPart> parts = ParseMultipart(kType, body);
    ASSERT_EQ(parts.size(), 1u) << file_name;
    EXPECT_EQ(parts[0].name, "image") << file_name;
  }
}

std::string Contents(std::string_view type, const std::string& body) {
  std::string text;
  for (const MultipartPart& part : ParseMultipart(type, body)) {
    text += std::string(part.name) + "=" + std::string(part.content) + ";";
  }
  return text;
}

TEST(Multipart, ReadsTheBodiesOfKnownClients) {
  const std::string part = "Content-Disposition: form-data; name=\"a\"\r\n\r\n1";
  const std::string two = "\r\n--XX\r\nContent-Disposition: form-data; name=b\r\n\r\n2";
  const std::string first = "--XX\r\n" + part + two;
  EXPECT_EQ(Contents(kType, first + "\r\n--XX--\r\n"), "a=1;b=2;");
  EXPECT_EQ(Contents(kType, "\r\n" + first), "a=1;b=2;") << "Unity";
  EXPECT_EQ(Contents(kType, "\r\n" + first + "\r\n--XX--"), "a=1;b=2;") << "end by hand";
  EXPECT_EQ(Contents(kType, first + "\r\n--XX"), "a=1;b=2;") << "end without dashes";
  EXPECT_EQ(Contents(kType, first + "\r\n--XX\r\n"), "a=1;b=2;") << "end without dashes";
  EXPECT_EQ(Contents(kType, "text\r\n--XY\r\n" + first + "\r\n--XX--"), "a=1;b=2;") << "preamble";
  EXPECT_EQ(Contents(kType, first + "\r\n--XX--\r\n--XX\r\nepilogue"), "a=1;b=2;") << "epilogue";
  EXPECT_EQ(Contents(kType, "--XX \t\r\n" + part + "\r\n--XX--  \r\n"), "a=1;") << "blanks";
  EXPECT_EQ(Contents("multipart/form-data; boundary = \"XX\" ; x=y", first), "a=1;b=2;");
  std::string line_feeds = first + "\r\n--XX--\r\n";
  std::erase(line_feeds, '\r');
  EXPECT_EQ(Contents(kType, line_feeds), "a=1;b=2;");
  EXPECT_EQ(Contents(kType,
                     "--XX\r\nContent-Type: text/plain\r\nContent-Disposition: form-data;\r\n"
                     "\tfilename=x;\r\n name=a\r\n\r\n1\r\n--XX--"),
            "a=1;")
      << "continuation lines";
}

TEST(Multipart, BytesThatLookLikeABoundaryBelongToThePart) {
  const std::string content = "x--XX\r\n\r\n--XXL\r\n\n--XX\r\n-- XX";
  EXPECT_EQ(Contents(kType, Part("a", content) + "--XX--"), "a=" + content + ";");
}

// The search looks at blocks of bytes.
TEST(Multipart, FindsBoundariesWhereverTheyAre) {
  for (size_t size = 0; size < 200; ++size) {
    for (const char* filling : {"-", "\n", "\r\n--", "\r\n--X", "x"}) {
      std::string content;
      while (content.size() < size) {
        content += filling;
      }
      const std::string body = Part("a", content) + Part("b", "1") + "--XX--";
      EXPECT_EQ(Contents(kType, body), "a=" + content + ";b=1;") << size << filling;
      EXPECT_EQ(Contents(kType, content + "\r\n" + body), "a=" + content + ";b=1;") << size;
    }
  }
}

TEST(Multipart, RefusesBrokenFraming) {
  EXPECT_TRUE(IsRefused("multipart/form-data", Part("a", "b") + "--XX--"));
  EXPECT_TRUE(IsRefused("multipart/form-data; boundary=", Part("a", "b") + "--XX--"));
  EXPECT_TRUE(IsRefused("multipart/form-data; boundary=\"XX", Part("a", "b") + "--XX--"));
  EXPECT_TRUE(IsRefused(kType, ""));
  EXPECT_TRUE(IsRefused(kType, "--XX--\r\n"));
  EXPECT_TRUE(IsRefused(kType, "no boundary"));
  EXPECT_TRUE(IsRefused(kType, Part("", "b") + "--XX--"));
  EXPECT_TRUE(IsRefused(kType, Part("a", "b") + Part("a", "c") + "--XX--"));
  EXPECT_TRUE(IsRefused(kType, "--XX\r\nno end of headers\r\n--XX--"));
  EXPECT_TRUE(IsRefused(kType, "--XX\r\n\r\nno headers\r\n--XX--"));
  EXPECT_TRUE(IsRefused(kType, "--XX\r\n--XX--"));
  EXPECT_TRUE(IsRefused(kType, "--XXgarbage\r\n--XX--"));
}

TEST(Multipart, EveryTruncationIsRefusedOrAPartOfTheBody) {
  const std::string body = Part("request", "{}") + Part("image", "123") + "--XX--";
  const std::string whole = "request={};image=123;";
  for (size_t size = 0; size < body.size(); ++size) {
    const std::string cut = body.substr(0, size);
    if (!IsRefused(kType, cut)) {
      EXPECT_LE(Contents(kType, cut).size(), whole.size() + 8) << size;  // "\r\n--XX--"
    }
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

TEST(Multipart, AWrongBoundaryIsSaidToBeTheTaskOfTheLibrary) {
  for (const char* type : {"multipart/form-data", "multipart/form-data; boundary=YY"}) {
    try {
      ParseMultipart(type, Part("image", "bytes"));
      ADD_FAILURE() << "accepted";
    } catch (const HttpError& error) {
      EXPECT_THAT(ProblemJson(error, ""), ::testing::HasSubstr("do not set it by hand"));
    }
  }
}

}  // namespace
}  // namespace cairn
