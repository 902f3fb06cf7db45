#include "core/images/raw_profile.h"

#include <png.h>

#include <algorithm>
#include <cctype>
#include <csetjmp>
#include <string>
#include <string_view>

#include "core/images/tiff_directory.h"

namespace cairn {
namespace {

constexpr size_t kTypeBytes = 4;
// Two digits for each byte, line breaks, and the lines in front.
constexpr size_t kMaxTextBytes = 3 * TiffDirectory::kMaxBytes;

std::string_view TextOf(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// A PNG up to its pixels: a header of one gray pixel, the chunk, and the beginning of IDAT.
std::vector<uint8_t> PngAround(std::span<const uint8_t> typed_chunk) {
  std::vector<uint8_t> png = {0x89, 'P',  'N',  'G', '\r', '\n', 0x1a, '\n',                 //
                              0,    0,    0,    13,  'I',  'H',  'D',  'R',                  //
                              0,    0,    0,    1,   0,    0,    0,    1,    8, 0, 0, 0, 0,  //
                              0x3a, 0x7e, 0x9b, 0x55};
  const size_t num_bytes = typed_chunk.size() - kTypeBytes;
  for (const int shift : {24, 16, 8, 0}) {
    png.push_back(static_cast<uint8_t>(num_bytes >> shift));
  }
  png.insert(png.end(), typed_chunk.begin(), typed_chunk.end());
  png.insert(png.end(), 4, 0);  // The checksum, which does not count.
  for (const char c : {'\0', '\0', '\0', '\0', 'I', 'D', 'A', 'T'}) {
    png.push_back(static_cast<uint8_t>(c));
  }
  return png;
}

void ReadRest(png_structp png, png_bytep target, size_t num_bytes) {
  auto* rest = static_cast<std::span<const uint8_t>*>(png_get_io_ptr(png));
  if (num_bytes > rest->size()) {
    png_error(png, "it is cut short");
  }
  std::copy_n(rest->begin(), num_bytes, target);
  *rest = rest->subspan(num_bytes);
}

[[noreturn]] void LeaveLibrary(png_structp png, png_const_charp) { png_longjmp(png, 1); }

void Ignore(png_structp, png_const_charp) {}

// Appends the text of the file's first text chunk to `text`, if the library can read it. The
// library leaves by longjmp, so nothing behind setjmp may have a destructor.
void AppendText(png_structp png, png_infop info, std::span<const uint8_t>* rest,
                std::string* text) {
  if (setjmp(png_jmpbuf(png)) != 0) {
    return;
  }
  png_set_read_fn(png, rest, ReadRest);
  png_set_crc_action(png, PNG_CRC_QUIET_USE, PNG_CRC_QUIET_USE);
  png_set_chunk_malloc_max(png, kMaxTextBytes);
  png_read_info(png, info);
  png_textp texts = nullptr;
  if (png_get_text(png, info, &texts, nullptr) > 0 && texts[0].text != nullptr) {
    text->append(texts[0].text);
  }
}

// The text of the chunk; empty if it is damaged or too long.
std::string ReadText(std::span<const uint8_t> typed_chunk) {
  const std::vector<uint8_t> bytes = PngAround(typed_chunk);
  std::span<const uint8_t> rest = bytes;
  std::string text;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, LeaveLibrary, Ignore);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info != nullptr) {
    AppendText(png, info, &rest, &text);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  return text;
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') {
    return c - '0';
  }
  const int lower = std::tolower(static_cast<unsigned char>(c));
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

// The bytes of pairs of digits up to the first other character that is no white space.
std::vector<uint8_t> BytesOfDigits(std::string_view text) {
  std::vector<uint8_t> bytes;
  int high = -1;
  for (const char c : text) {
    if (std::isspace(static_cast<unsigned char>(c))) {
      continue;
    }
    const int digit = HexDigit(c);
    if (digit < 0 || bytes.size() == TiffDirectory::kMaxBytes) {
      break;
    }
    if (high < 0) {
      high = digit;
    } else {
      bytes.push_back(static_cast<uint8_t>(16 * high + digit));
      high = -1;
    }
  }
  return bytes;
}

// Behind the lines with the name of the profile and its number of bytes.
std::string_view DigitsOf(std::string_view text) {
  for (int i = 0; i < 2; ++i) {
    text.remove_prefix(std::min(text.find_first_not_of("\r\n"), text.size()));
    text.remove_prefix(std::min(text.find('\n'), text.size()));
  }
  return text;
}

}  // namespace

bool IsRawProfile(std::span<const uint8_t> typed_chunk) {
  const std::string_view chunk = TextOf(typed_chunk);
  const std::string_view type = chunk.substr(0, kTypeBytes), content = chunk.substr(kTypeBytes);
  return (type == "tEXt" || type == "zTXt" || type == "iTXt") &&
         (content.starts_with(std::string_view("Raw profile type exif\0", 22)) ||
          content.starts_with(std::string_view("Raw profile type APP1\0", 22)));
}

std::vector<uint8_t> ReadRawProfile(std::span<const uint8_t> typed_chunk) {
  const std::string text = ReadText(typed_chunk);
  std::vector<uint8_t> bytes = BytesOfDigits(DigitsOf(text));
  constexpr std::string_view kSignature("Exif\0\0", 6);
  if (TextOf(bytes).starts_with(kSignature)) {
    bytes.erase(bytes.begin(), bytes.begin() + kSignature.size());
  }
  return bytes;
}

}  // namespace cairn
