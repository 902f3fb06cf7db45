#include "cli/demo/street/texture.h"

#include <cmath>
#include <cstddef>

#include "core/check.h"

namespace cairn {
namespace {

void HalveWidth(const uint8_t* in, int out_width, int height, uint8_t* out) {
  const size_t num_texels = static_cast<size_t>(out_width) * height;
  for (size_t i = 0; i < num_texels; ++i) {
    out[i] = static_cast<uint8_t>((in[2 * i] + in[2 * i + 1] + 1) / 2);
  }
}

void HalveHeight(const uint8_t* in, int width, int out_height, uint8_t* out) {
  for (int y = 0; y < out_height; ++y) {
    const uint8_t* upper = in + static_cast<size_t>(2 * y) * width;
    const uint8_t* lower = upper + width;
    for (int x = 0; x < width; ++x) {
      out[static_cast<size_t>(y) * width + x] = static_cast<uint8_t>((upper[x] + lower[x] + 1) / 2);
    }
  }
}

int LevelIndex(float extent) {
  if (extent <= 1.0f) {
    return 0;
  }
  return std::min(static_cast<int>(std::ilogb(extent * 1.41421356f)), Texture::kNumLevels - 1);
}

}  // namespace

Texture::Texture(const cv::Mat& pixels) : width_(pixels.cols), height_(pixels.rows) {
  CAIRN_CHECK(pixels.type() == CV_8UC1, "a texture is 8-bit gray");
  CAIRN_CHECK(width_ > 0 && width_ % kSizeStep == 0, "texture width is not a multiple of the step");
  CAIRN_CHECK(height_ > 0 && height_ % kSizeStep == 0, "texture height is not a multiple");
  size_t num_texels = 0;
  for (int v_level = 0; v_level < kNumLevels; ++v_level) {
    for (int u_level = 0; u_level < kNumLevels; ++u_level) {
      offsets_.push_back(num_texels);
      num_texels += static_cast<size_t>(width_ >> u_level) * (height_ >> v_level);
    }
  }
  texels_.resize(num_texels);
  for (int y = 0; y < height_; ++y) {
    std::copy_n(pixels.ptr<uint8_t>(y), width_, texels_.data() + static_cast<size_t>(y) * width_);
  }
  for (int v_level = 0; v_level < kNumLevels; ++v_level) {
    const int height = height_ >> v_level;
    const size_t first = static_cast<size_t>(v_level) * kNumLevels;
    if (v_level > 0) {
      HalveHeight(texels_.data() + offsets_[first - kNumLevels], width_, height,
                  texels_.data() + offsets_[first]);
    }
    for (int u_level = 1; u_level < kNumLevels; ++u_level) {
      HalveWidth(texels_.data() + offsets_[first + u_level - 1], width_ >> u_level, height,
                 texels_.data() + offsets_[first + u_level]);
    }
  }
}

Texture::Level Texture::LevelFor(float u_extent, float v_extent) const {
  const int u_level = LevelIndex(u_extent), v_level = LevelIndex(v_extent);
  Level level;
  level.texels = texels_.data() + offsets_[static_cast<size_t>(v_level) * kNumLevels + u_level];
  level.width = width_ >> u_level;
  level.height = height_ >> v_level;
  level.u_scale = 1.0f / static_cast<float>(1 << u_level);
  level.v_scale = 1.0f / static_cast<float>(1 << v_level);
  return level;
}

}  // namespace cairn
